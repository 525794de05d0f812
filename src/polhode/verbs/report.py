"""``polhode report``: an accuracy report of one's own scenes and files, as a page."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from polhode.scenes import library
from polhode.verbs import scene_options
from polhode.verbs.options import names, real, whole, word
from polhode.verbs.terminal import (
    DONE,
    ProgressLine,
    note,
    refuse_two_on_stdout,
    say,
)

_WHAT = (
    "scenes (cases that ship, or paths), and files of trajectories as for polhode compare, each "
    "after the scene that it is judged against (a run that polhode saved may stand first, and is "
    "judged against the scene that it holds); mine.csv=0.8s tells what it cost, "
    "mine.csv=0.8s,h=0.01 its method's step too; files whose names differ in digits alone are one "
    "method's, whose order is told"
)


def add_report(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("what", type=word, nargs="*", metavar="SCENE|FILE", help=_WHAT)
    endings = (
        ".html, a page that needs nothing else; .md, with its figures in a folder beside it; "
        ".json, all numbers; .csv, .npz, .parquet; may be repeated"
    )
    parser.add_argument(
        "-o", dest="places", type=word, metavar="FILE", action="append", default=[], help=endings
    )
    number = "one number type (double, extended, quad, mp) in place of the first three"
    parser.add_argument("--number", metavar="TYPE", help=number)
    digits = "correct digits wanted: a run to them is made too, and verdicts go by them"
    parser.add_argument("--digits", type=whole, metavar="N", help=digits)
    scene_options.add(parser, [scene_options.TIMES])
    columns = "of the files: their columns in order, or some of them, as for polhode compare"
    parser.add_argument("--columns", type=names, metavar="NAME,NAME...", help=columns)
    read = "of the files: readings to apply, in their words, as for polhode compare"
    parser.add_argument("--read", metavar="WORDS", help=read)
    limit = "a limit in seconds on each proof that judges where there is no closed form (20)"
    parser.add_argument("--max-seconds", type=real, metavar="X", default=20.0, help=limit)


def report(options: Namespace) -> int:
    """Measure, print the first table, and write the pages."""
    from polhode.common.files import is_stdout, write_stdout
    from polhode.judging.tables.table_file import is_table
    from polhode.output import report

    paths = [Path(place) for place in options.places]
    _check(options, paths)
    what: list[Any] = []
    for text in options.what:
        if is_table(report.file_of(text)):
            what.append(text)
        else:
            scene = library.load(text)
            what.append(scene_options.applied(options, scene, [scene_options.TIMES]))
    with ProgressLine("report") as line:
        found = report.report(
            *what,
            number=options.number,
            digits=options.digits,
            columns=options.columns,
            read=options.read,
            max_seconds=options.max_seconds,
            progress=line.say,
            forecast=lambda text: note(f"report: {text}"),
        )
        line.say("pages")
        report.write(found, paths)
    if options.json:
        write_stdout(found.to_json())
    else:
        (note if any(map(is_stdout, paths)) else say)(str(found))
    if written := [str(path) for path in paths if not is_stdout(path)]:
        note(f"report: written: {', '.join(written)}")
    return DONE


def _check(options: Namespace, paths: Sequence[Path]) -> None:
    """Refuse, before the work, what cannot be written."""
    from polhode.output import report

    inputs = [library.path_of(report.file_of(text)) for text in options.what]
    for path in paths:
        refuse_two_on_stdout(path, options.json)
        report.check_place(path, inputs)
