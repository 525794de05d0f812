"""Reports: each study's rows as JSON, the truth; pages and figures are made from it alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from polhode.answers import as_json
from polhode.errors import BadInput
from polhode.figures import canvas
from polhode.files import check_writable, write_whole
from polhode.pages.blocks import Block, Heading, Text, markdown
from polhode.provenance import cpu, versions

#: The studies by name, in the order of the report: modules of studies/, pages/ and figures/.
STUDIES = {"accuracy": "accuracy", "forms": "forms"}


def write_report(
    folder: Path, quick: bool = False, tick: Callable[[str], None] | None = None
) -> list[Path]:
    """Run the studies and write ``folder``/NAME.json, NAME.svg, NAME.md, each whole; the paths."""
    if not folder.is_dir():
        raise BadInput(str(folder), "-o", None, "an existing folder")
    written = []
    for name, module in STUDIES.items():
        paths = [folder / f"{name}{suffix}" for suffix in (".json", ".svg", ".md")]
        for path in paths:
            check_writable(path)
        canvas.require()
        command = "polhode report" + (" --quick" if quick else "")
        found = import_module(f"polhode.studies.{module}").rows(quick, tick)
        found["provenance"] = {"command": command, "versions": versions(), "cpu": cpu()}
        drawn = import_module(f"polhode.figures.{module}").svg(found)
        texts = (as_json(found), drawn, page(found))
        write_whole(dict(zip(paths, texts, strict=True)))
        written += paths
    return written


def page(found: dict[str, Any]) -> str:
    """A study's page as Markdown, from its JSON object."""
    made = import_module(f"polhode.pages.{STUDIES[found['study']]}")
    return markdown(made.TITLE, _framed(found, made.blocks(found)))


def _framed(found: dict[str, Any], blocks: Iterator[Block]) -> Iterator[Block]:
    """A study's blocks between its question and its provenance."""
    origin = found["provenance"]
    yield Text(found["question"])
    yield Text(f"Made by `{origin['command']}`; no number here was edited by hand.")
    yield from blocks
    yield Heading("Provenance")
    packages = ", ".join(f"{name} {version}" for name, version in origin["versions"].items())
    yield Text(f"{packages}; {origin['cpu']}.")
