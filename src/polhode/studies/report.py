"""Reports: each study's results as JSON, from which alone its figures and its page are made.

A study is a folder beside this file: ``rows.py`` has QUESTION and ``rows(quick, say, wanted)``, the
JSON object of the rows that are wanted (``say``: told what is being done); ``page.md``, the page as
a template, and ``page.py`` ``tables(found)`` and ``facts(found)``, what stands in its fields;
``figure.py`` ``svgs(found)``, its figures by name.  Where ``rows.py`` tells its own ``versions()``,
they belong to its provenance.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any

from polhode.common.errors import UNREADABLE, BadInput, nearest
from polhode.common.files import check_writable, make_folder, write_whole
from polhode.common.interrupts import Message, heard
from polhode.common.provenance import cpu, digest, versions
from polhode.common.texts import JsonObject, as_json
from polhode.figures import canvas
from polhode.scenes import library
from polhode.studies.page.html import html
from polhode.studies.page.html import require as require_markdown
from polhode.studies.page.tables import PageTable
from polhode.studies.page.template import filled
from polhode.studies.row_filter import Only

#: The studies in the order of the report, each a folder of that name, with _ for -; the seconds
#: that each takes on two processors, whole and quick.
STUDIES = {
    "speed": (2600, 90),
    "accuracy": (170, 30),
    "proofs": (170, 20),
    "stability": (190, 30),
    "long-run": (300, 30),
    "events": (35, 10),
}
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


def _unsaid(text: str) -> None:
    """A message for nobody."""


def write_report(
    folder: Path,
    quick: bool = False,
    fresh: bool = False,
    tick: Message = _unsaid,
    foretell: Message = _unsaid,
) -> list[Path]:
    """Run the studies and write each whole as it ends, then the page of all; the paths.

    A study whose results in ``folder`` were made by today's code, cases and versions in the same
    mode is kept, unless ``fresh``: a report that was interrupted goes on where it stopped.  Short
    studies are run first.
    ``foretell``: told once what is run, and for how long.
    """
    command = "polhode study all" + " --quick" * quick
    require_markdown()
    _check(folder, STUDIES)
    check_writable(folder / PAGE)
    asked = [name for name in STUDIES if fresh or not _is_current(folder, name, quick)]
    asked.sort(key=lambda name: STUDIES[name][quick])
    foretell(_forecast(asked, quick))
    for k, name in enumerate(asked, 1):
        counted = partial(_count, tick, f"{k} of {len(asked)}")
        write_whole({folder / f"{name}.json": _run(name, quick, command, counted)})
    return write_pages(folder, tick)


def _count(tick: Message, which: str, text: str) -> None:
    tick(f"{which}: {text}")


def _forecast(asked: Sequence[str], quick: bool) -> str:
    """Which studies a report runs, and how long that takes."""
    if not asked:
        return "every study is of today's code: pages and figures alone are made"
    minutes = sum(STUDIES[name][quick] for name in asked) / 60
    goes_on = "stopped, the same command goes on with the study that it was at"
    return f"{', '.join(asked)}: about {minutes:.0f} minutes on two processors; {goes_on}"


def write_study(
    name: str, folder: Path, quick: bool = False, tick: Message = _unsaid
) -> list[Path]:
    """Run one study and write its results, page and figures, all of them or none; the paths."""
    _check(folder, [_known(name)])
    text = _run(name, quick, f"polhode study {name}" + " --quick" * quick, tick)
    texts = {folder / f"{name}.json": text, **_made(folder, json.loads(text), tick)}
    write_whole(texts)
    return [*texts]


def part(
    name: str, texts: Sequence[str], quick: bool = False, tick: Message = _unsaid
) -> tuple[JsonObject, str]:
    """The rows of a study whose names hold all texts, made again, and their tables as Markdown.

    Nothing is written: a part of a study is no study.  Raises BadInput where no row is named so.
    """
    only = Only(tuple(texts))
    found = _rows(_known(name), quick, tick, only)
    if not only.taken:
        likely = nearest(" ".join(texts), [*dict.fromkeys(only.passed)])
        raise BadInput("study", "--only", " ".join(texts), f"part of the name of a row; {likely}")
    tables: dict[str, PageTable] = _module(name, "page").tables(found)
    return found, "\n\n".join(made.markdown for made in tables.values() if made.rows)


def write_pages(folder: Path, tick: Message = _unsaid) -> list[Path]:
    """Figures and pages of all results in the folder, made from them alone; paths of all files."""
    every = [found for name in STUDIES if (found := results(folder, name)) is not None]
    texts = {path: text for found in every for path, text in _made(folder, found, tick).items()}
    texts[folder / PAGE] = html({path.name: text for path, text in texts.items()})
    write_whole(texts)
    return [*(folder / f"{found['study']}.json" for found in every), *texts]


def _made(folder: Path, found: JsonObject, tick: Message) -> dict[Path, str]:
    """What is made of a study's results, by its place: figures and page."""
    tick(f"{found['study']}: figures and pages")
    texts = {folder / f"{name}.svg": svg for name, svg in figures(found).items()}
    return {**texts, folder / f"{found['study']}.md": page(found)}


def results(folder: Path, name: str) -> JsonObject | None:
    """The JSON object of a study in a folder; None where there is none that can be read."""
    try:
        found = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, *UNREADABLE):
        return None
    return found if isinstance(found, dict) and found.get("study") == name else None


def figures(found: JsonObject) -> dict[str, str]:
    """A study's figures as SVG by name, from its JSON object."""
    drawn: dict[str, str] = _module(found["study"], "figure").svgs(found)
    return drawn


def page(found: JsonObject) -> str:
    """A study's page as Markdown, from its JSON object."""
    name, origin = found["study"], dict(found["provenance"])
    packages = [f"{package} {version}" for package, version in origin["versions"].items()]
    origin |= {
        "again": f"polhode study {name}{' --quick' * found['quick']}",
        "packages": ", ".join(packages),
        "polhode": packages[0],
    }
    module = _module(name, "page")
    template = _text(_folder(name), "page.md") + _text("page", "provenance.md")
    shared = {"question": found["question"], "origin": origin}
    return filled(template, module.tables(found), module.facts(found) | shared)


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


def _known(name: str) -> str:
    """The name of a study; raises BadInput for another."""
    if name in GONE:
        there = f"{', '.join(STUDIES)}; {name} is a study no more, see {GONE[name]}"
        raise BadInput("study", "NAME", name, there)
    if name not in STUDIES:
        raise BadInput("study", "NAME", name, nearest(name, [*STUDIES]))
    return name


def _run(name: str, quick: bool, command: str, tick: Message) -> str:
    """Run one study; its results as JSON text."""
    began, made_of = time.perf_counter(), key(name, quick)
    found = _rows(name, quick, tick, Only())
    found["provenance"] = {
        "command": command,
        "key": made_of,
        "seconds": round(time.perf_counter() - began, 1),
        "versions": _versions(name),
        "cpu": cpu(),
    }
    return as_json(found)


def _rows(name: str, quick: bool, tick: Message, wanted: Only) -> JsonObject:
    """The rows of a study that are wanted; Ctrl-C ends it, as what is left of a run is no row."""

    def say(text: str) -> None:
        _end_if_interrupted()
        tick(f"{name}: {text}")

    study = _module(name, "rows")
    rows = study.rows(quick, say, wanted)
    _end_if_interrupted()
    return {"study": name, "question": study.QUESTION, "quick": quick, **rows}


def _end_if_interrupted() -> None:
    """Ctrl-C during a run ends the run early, without an exception."""
    if heard.came:
        raise KeyboardInterrupt
