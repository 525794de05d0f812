"""Reports: each study's results as JSON, from which alone its figures and its page are made.

A study is a folder beside this file: ``rows.py`` has NAME, QUESTION and ``rows(quick, tick,
only)``, the JSON object, or some of its rows; ``page.md``, the page as a template, and ``page.py``
``tables(found)`` and ``facts(found)``, what stands in its fields; ``figure.py`` ``svg(found)``, one
figure with the study's name, or ``svgs(found)``, several by name.
Where ``rows.py`` tells its own ``versions()``, they belong to its provenance.
"""

from __future__ import annotations

import inspect
import json
import shlex
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import Any

from polhode.common.errors import UNREADABLE, BadInput, nearest
from polhode.common.files import check_writable, make_folder, write_whole
from polhode.common.interrupts import heard
from polhode.common.json_text import as_json
from polhode.common.progress import Message
from polhode.common.provenance import cpu, digest, versions
from polhode.figures.canvas import canvas
from polhode.scenes import library
from polhode.studies.page.html import html
from polhode.studies.page.html import require as require_markdown
from polhode.studies.page.tables import PageTable
from polhode.studies.page.template import filled
from polhode.studies.row_filter import Only

#: The studies in the order of the report; each is a folder of that name, with _ for -.
STUDIES = ("accuracy", "proofs", "speed", "stability", "long-run", "events")
#: Studies that there were, and what has their rows, or makes them, now.
GONE = {
    "needs": "the studies accuracy (digits of each case) and speed (what they cost)",
    "published": "the study accuracy, whose rows of printed figures are shown by --only printed",
    "certified": "the study accuracy, whose closed forms in enclosures are shown by --only proven",
    "forms": "polhode check --forms (each form's digits), polhode guide forms (which one to use)",
    "dynamics": "polhode levels, polhode section and polhode map, each of any scene",
    "gallery": "reports/gallery.md, whose figures polhode plot draws",
}
PAGE = "report.html"
PACKAGE = Path(__file__).parents[1]


def write_report(
    folder: Path, quick: bool = False, fresh: bool = False, tick: Message | None = None
) -> list[Path]:
    """Run the studies and write each whole as it ends, then the page of all; the paths.

    A study whose results in ``folder`` were made by today's code, cases and versions in the same
    mode is kept, unless ``fresh``: a report that was interrupted goes on where it stopped.
    """
    command = "polhode report" + " --quick" * quick
    require_markdown()
    _check(folder, STUDIES)
    check_writable(folder / PAGE)
    for k, name in enumerate(STUDIES):
        if fresh or not _is_current(folder, name, quick):
            said = None if tick is None else _counted(tick, k + 1)
            write_whole({folder / f"{name}.json": _run(name, quick, command, said)})
    return write_pages(folder, tick)


def write_study(
    name: str,
    folder: Path,
    quick: bool = False,
    tick: Message | None = None,
    without: Sequence[str] = (),
) -> list[Path]:
    """Run one study and write its results, page and figures, all of them or none; the paths.

    ``without``: what is left out of a study that can.
    """
    options = _options(name, without)
    _check(folder, [name])
    command = f"polhode study {name}" + " --quick" * quick
    command += "".join(f" --without {shlex.quote(word)}" for word in without)
    text = _run(name, quick, command, tick, options)
    texts = {folder / f"{name}.json": text, **_made(folder, json.loads(text), tick)}
    write_whole(texts)
    return [*texts]


def part(
    name: str,
    texts: Sequence[str],
    quick: bool = False,
    tick: Message | None = None,
    without: Sequence[str] = (),
) -> tuple[dict[str, Any], str]:
    """The rows of a study whose names hold all texts, made again, and their tables as Markdown.

    Nothing is written: a part of a study is no study.  Raises BadInput where no row is named so.
    """
    options = _options(name, without)
    only = Only(tuple(texts))
    found: dict[str, Any] = _module(name, "rows").rows(quick, tick, only, **options)
    if not only.taken:
        likely = nearest(" ".join(texts), [*dict.fromkeys(only.passed)])
        raise BadInput("study", "--only", " ".join(texts), f"part of the name of a row; {likely}")
    tables: dict[str, PageTable] = _module(name, "page").tables(found)
    return found, "\n\n".join(made.markdown for made in tables.values() if made.rows)


def write_pages(folder: Path, tick: Message | None = None) -> list[Path]:
    """Figures and pages of all results in the folder, made from them alone; paths of all files."""
    every = [found for name in STUDIES if (found := results(folder, name)) is not None]
    texts = {path: text for found in every for path, text in _made(folder, found, tick).items()}
    texts[folder / PAGE] = html({path.name: text for path, text in texts.items()})
    write_whole(texts)
    return [*(folder / f"{found['study']}.json" for found in every), *texts]


def _made(folder: Path, found: dict[str, Any], tick: Message | None) -> dict[Path, str]:
    """What is made of a study's results, by its place: figures and page."""
    if tick is not None:
        tick(f"{found['study']}: figures and pages")
    texts = {folder / f"{name}.svg": svg for name, svg in figures(found).items()}
    return {**texts, folder / f"{found['study']}.md": page(found)}


def results(folder: Path, name: str) -> dict[str, Any] | None:
    """The JSON object of a study in a folder; None where there is none that can be read."""
    try:
        found = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, *UNREADABLE):
        return None
    return found if isinstance(found, dict) and found.get("study") == name else None


def figures(found: dict[str, Any]) -> dict[str, str]:
    """A study's figures as SVG by name, from its JSON object."""
    name = found["study"]
    module = _module(name, "figure")
    drawn: dict[str, str] = (
        module.svgs(found) if hasattr(module, "svgs") else {name: module.svg(found)}
    )
    return drawn


def page(found: dict[str, Any]) -> str:
    """A study's page as Markdown, from its JSON object."""
    name, origin = found["study"], found["provenance"]
    again = f"polhode study {name}{' --quick' * found['quick']}"
    packages = ", ".join(f"{package} {version}" for package, version in origin["versions"].items())
    module, template = _module(name, "page"), _text(_folder(name), "page.md")
    facts = module.facts(found) | {"question": found["question"]}
    made = {"again": again, "packages": packages, "note": "", **origin}
    end = _text("page", "provenance.md").format_map(made)
    return f"{filled(template, module.tables(found), facts)}{end.rstrip()}\n"


def _text(folder: str, file: str) -> str:
    """A template, beside the modules that fill it."""
    return (files("polhode.studies") / folder / file).read_text(encoding="utf-8")


def key(name: str, quick: bool) -> str:
    """What a study's results depend on: the package, cases, versions, processor, mode."""
    cases = [library.folder() / f"{case}.toml" for case in library.names()]
    parts = [f"{'/'.join(path.parts[-3:])}\n{path.read_text(encoding='utf-8')}" for path in cases]
    return digest("\0".join([*_package(), *parts, str(_versions(name)), cpu(), str(quick)]))


def _package() -> Iterator[str]:
    """The modules of polhode, each with its place; nothing else that lies beside them counts."""
    for path in sorted(PACKAGE.rglob("*.py")):
        # a stray file, such as a "._name.py" of macOS, is no text
        text = path.read_text(encoding="utf-8", errors="backslashreplace")
        yield f"{path.relative_to(PACKAGE).as_posix()}\n{text}"


def _folder(study: str) -> str:
    return study.replace("-", "_")


def _module(study: str, part: str) -> Any:
    """A part of a study: rows, page or figure; imported when it is asked for."""
    return import_module(f"polhode.studies.{_folder(study)}.{part}")


def _versions(name: str) -> dict[str, str]:
    study = _module(name, "rows")
    return versions() | (study.versions() if hasattr(study, "versions") else {})


def _is_current(folder: Path, name: str, quick: bool) -> bool:
    found = results(folder, name)
    return found is not None and found.get("provenance", {}).get("key") == key(name, quick)


def _check(folder: Path, names: Iterable[str]) -> None:
    """Refuse what would fail at the end, before the work."""
    canvas.require()
    make_folder(folder)
    for name in names:
        for suffix in (".json", ".md", ".svg"):
            check_writable(folder / f"{name}{suffix}")


def _options(name: str, without: Sequence[str]) -> dict[str, Any]:
    """Options of a study's rows; raises BadInput for a study that is not, or that has none."""
    if name in GONE:
        there = f"{', '.join(STUDIES)}; {name} is a study no more, see {GONE[name]}"
        raise BadInput("study", "NAME", name, there)
    if name not in STUDIES:
        raise BadInput("study", "NAME", name, nearest(name, [*STUDIES]))
    if not without:
        return {}
    if "without" not in inspect.signature(_module(name, "rows").rows).parameters:
        raise BadInput("study", "--without", without[0], f"nothing: {name} runs polhode alone")
    return {"without": tuple(without)}


def _run(
    name: str,
    quick: bool,
    command: str,
    tick: Message | None,
    options: Mapping[str, Any] = MappingProxyType({}),
) -> str:
    """Run one study; its results as JSON text."""
    began, made_of = time.perf_counter(), key(name, quick)
    found = _module(name, "rows").rows(quick, _stoppable(tick), **options)
    _end_if_interrupted()
    found["provenance"] = {
        "command": command,
        "key": made_of,
        "seconds": round(time.perf_counter() - began, 1),
        "versions": _versions(name),
        "cpu": cpu(),
    }
    return as_json(found)


def _stoppable(tick: Message | None) -> Message:
    """A message that ends the study where Ctrl-C came."""

    def tell(text: str) -> None:
        _end_if_interrupted()
        if tick is not None:
            tick(text)

    return tell


def _end_if_interrupted() -> None:
    """Ctrl-C during a run ends the run early, and what is left of it is no row."""
    if heard.came:
        raise KeyboardInterrupt


def _counted(tick: Message, k: int) -> Message:
    return lambda text: tick(f"{k} of {len(STUDIES)}: {text}")
