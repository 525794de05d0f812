"""polhode's own evidence, made again: ``python reports/make.py [NAME] [--quick] [--only TEXT]``.

A study is a file beside this one with ``rows(quick, say, only)``, the JSON object of the rows that
are wanted (``say``: told what is being done), ``tables(results)``, the rows of the tables that its
page ``templates/NAME.md`` describes, ``facts(results)``, what stands in its fields, and
``svgs(results)``, its figures by name.  Its page begins with a title and the study's question.
Where it has ``versions()``, they belong to its provenance.  Pages and figures are made from the
JSON alone.
"""

from __future__ import annotations

import argparse
import json
import re
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import benchmark
import kit
import polhode
from kit import HERE, JsonObject, Only, PageTable, template, write

#: The studies, each a file of that name, with _ for -; the seconds that each takes on two
#: processors, whole and quick.
STUDIES = {
    "speed": (2600, 90),
    "accuracy": (170, 9),
    "proofs": (170, 6),
    "stability": (190, 6),
    "long-run": (300, 6),
    "events": (35, 6),
}
BENCHMARK = "benchmark"
README = HERE.parent / "README.md"


def main(arguments: Sequence[str] | None = None) -> int:
    """Make what is asked for; 0, or 1 for what was stale, or 2 for bad input."""
    parser = argparse.ArgumentParser("make.py", description=(__doc__ or "").partition("\n")[0])
    every_name = ", ".join([*STUDIES, BENCHMARK])
    only = "rows with TEXT in their names (may be repeated), printed; of the benchmark written"
    stale = (
        "make pages, figures and README's table from the rows again; name what changes, and rows "
        "of another version"
    )
    name_help = f"{every_name}; without it every study"
    parser.add_argument("name", nargs="?", metavar="NAME", help=name_help)
    parser.add_argument("--quick", action="store_true", help="fewer and shorter cases")
    parser.add_argument("--only", metavar="TEXT", action="append", default=[], help=only)
    parser.add_argument("-o", dest="folder", metavar="DIR", type=Path, help="here: reports/")
    parser.add_argument("--stale", action="store_true", help=stale)
    options = parser.parse_args(arguments)
    if options.name not in (None, *STUDIES, BENCHMARK):
        parser.error(f"NAME {options.name!r}: expected {every_name}")
    if options.only and options.name is None:
        parser.error("--only: expected it with the NAME of one study")
    if options.only and options.folder and options.name != BENCHMARK:
        parser.error("-o: expected no --only, which prints rows of a study and writes nothing")
    if options.stale and options.name == BENCHMARK:
        parser.error("--stale: expected a study, as the benchmark is its own rows")
    stale_texts = []
    try:
        for text in answers(options):
            print(text, flush=True)
            stale_texts += [text] * options.stale
    except (polhode.BadInput, OSError) as fault:
        print(fault, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("make.py: stopped; the study that was being made is not written", file=sys.stderr)
        return 130
    return int(bool(stale_texts))


def answers(options: argparse.Namespace) -> Iterator[object]:
    """What is asked for, as it is made: paths, the tables of some rows, or what was stale."""
    names = [options.name] if options.name else sorted(STUDIES, key=lambda name: STUDIES[name])
    folder: Path = options.folder or HERE / (BENCHMARK * (options.name == BENCHMARK))
    if options.stale:
        yield from write_stale(folder, names)
        yield from filter(None, (old_rows(folder, name) for name in names))
    elif options.name == BENCHMARK:
        yield from benchmark.write_benchmark(folder, Only(tuple(options.only)), say)
    elif options.only:
        yield part(options.name, options.only, options.quick)
    else:
        for name in names:
            yield from write_study(name, folder, options.quick)


_interrupts: list[object] = []  # that came so far


def interrupt(*signal_and_frame: object) -> None:
    """What Ctrl-C does: it ends a run early, without an exception, and then the study."""
    _interrupts.append(signal_and_frame)
    raise KeyboardInterrupt


def say(text: str) -> None:
    """Tell what is being done."""
    if _interrupts:  # a run that it ended is no row
        raise KeyboardInterrupt
    print(text, file=sys.stderr, flush=True)


def write_study(name: str, folder: Path, quick: bool = False) -> list[Path]:
    """Run one study and write its results, page and figures; the paths."""
    began = time.perf_counter()
    study = module(name)
    rows = study.rows(quick, lambda text: say(f"{name}: {text}"), Only())
    say(f"{name}: figures and page")
    _, question, *_ = template(name).split("\n\n")
    results = {"study": name, "question": question, "quick": quick, **rows}
    origin: Any = polhode.load("euler/rest").provenance()
    results["provenance"] = {
        "command": _command(name) + " --quick" * quick,
        "seconds": round(time.perf_counter() - began, 1),
        "versions": origin["versions"] | (study.versions() if hasattr(study, "versions") else {}),
        "cpu": origin["cpu"],
    }
    text = json.dumps(results, indent=1, allow_nan=False) + "\n"
    texts = {f"{name}.json": text, **pages(json.loads(text))}
    folder.mkdir(parents=True, exist_ok=True)
    return write({folder / file: text for file, text in texts.items()})


def part(name: str, texts: Sequence[str], quick: bool = False) -> str:
    """The tables of the rows of a study whose names hold all texts; nothing is written."""
    only = Only(tuple(texts))
    rows = module(name).rows(quick, lambda text: say(f"{name}: {text}"), only)
    results = {"quick": quick, **rows}
    only.check()
    return "\n\n".join(x.markdown for x in tables(name, results).values() if x.rows)


def pages(results: JsonObject) -> dict[str, str]:
    """What is made of a study's results by the names of the files: figures and page."""
    name = results["study"]
    figures = module(name).svgs(results)
    return {**{f"{key}.svg": svg for key, svg in figures.items()}, f"{name}.md": page(results)}


def page(results: JsonObject, *templates: str) -> str:
    """A study's page as Markdown, from its JSON object; or other templates filled from it."""
    name, origin = results["study"], dict(results["provenance"])
    packages = [f"{package} {version}" for package, version in origin["versions"].items()]
    again = _command(name) + " --quick" * results["quick"]
    origin |= {"again": again, "packages": ", ".join(packages), "polhode": packages[0]}
    facts = module(name).facts(results) | {"origin": origin}
    text = "".join(map(template, templates or (name, "provenance")))
    return kit.filled(text, tables(name, results), facts)


def tables(name: str, results: JsonObject) -> dict[str, PageTable]:
    """The tables of a study's page that its template describes, from its JSON object."""
    rows, page_tables, columns = module(name).tables(results), dict[str, PageTable](), ""
    for part, again, lines in kit.TABLE.findall(template(name)):
        columns = lines or columns
        page_tables[part] = kit.table(rows[part], columns, again and f"{_command(name)} {again}")
    return page_tables


def write_stale(folder: Path, names: Sequence[str]) -> list[Path]:
    """Make all that follows from the studies' rows again; the paths of what was out of date."""
    texts: dict[Path, str] = {}
    for name in names:
        results = results_of(folder, name)
        texts |= {folder / file: text for file, text in pages(results).items()}
        if name == "speed" and folder == HERE:
            texts[README] = with_summary(README.read_text(encoding="utf-8"), results)
    before = {path: path.read_text("utf-8") if path.exists() else None for path in texts}
    return write({path: text for path, text in texts.items() if text != before[path]})


def old_rows(folder: Path, name: str) -> str:
    """That a study's rows are of another version of polhode than this one; "" else ""."""
    version = results_of(folder, name)["provenance"]["versions"]["polhode"]
    if version == polhode.__version__:
        return ""
    file = folder / f"{name}.json"
    return f"{file}: rows of polhode {version}, this is {polhode.__version__}: {_command(name)}"


def results_of(folder: Path, name: str) -> JsonObject:
    """The JSON object of a study in a folder."""
    results: JsonObject = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    return results


def with_summary(readme: str, speed: JsonObject) -> str:
    """README with the speed study's table of lengths, of outputs and of many starts."""
    text, pattern = page(speed, "summary"), r"(<!-- summary: [^>]*-->\n).*?(<!-- end -->)"
    return re.sub(pattern, lambda match: match[1] + text + match[2], readme, flags=re.DOTALL)


def module(name: str) -> Any:
    """A study's module; imported when it is asked for."""
    return import_module(name.replace("-", "_"))


def _command(name: str) -> str:
    return f"python reports/make.py {name}"


if __name__ == "__main__":
    signal.signal(signal.SIGINT, interrupt)
    sys.exit(main())
