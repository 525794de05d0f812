"""``polhode study``: run one of polhode's own studies, or all of them, and write them."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path

from polhode.common.errors import BadInput
from polhode.verbs.options import add_folder
from polhode.verbs.terminal import DONE, ProgressLine, note, print_json, say, say_written

ALL = "all"


def add_study(parser: ArgumentParser) -> None:
    """The verb's own options."""
    named = f"accuracy, stability, events, ...; {ALL}: every study, and one HTML page of them"
    parser.add_argument("name", metavar="NAME", help=named)
    parser.add_argument("--quick", action="store_true", help="fewer and shorter cases")
    fresh = f"with {ALL}: discard earlier results"
    parser.add_argument("--fresh", action="store_true", help=fresh)
    parser.add_argument(
        "--only",
        metavar="TEXT",
        action="append",
        default=[],
        help="only rows with TEXT in their names (may be repeated); printed, nothing is written",
    )
    add_folder(parser, "reports")


def study(options: Namespace) -> int:
    """Run studies and write them, or print some rows of one."""
    from polhode.studies import report

    if options.name == ALL and options.only:
        raise BadInput("study", "--only", " ".join(options.only), f"it with one study, not {ALL}")
    if options.fresh and options.name != ALL:
        raise BadInput("study", "--fresh", None, f"it with {ALL}: one study is always run anew")
    with ProgressLine("study") as progress:
        if options.only:
            rows, tables = report.part(options.name, options.only, options.quick, progress.say)
        elif options.name == ALL:
            how = options.quick, options.fresh, progress.say, _foretell
            written: Sequence[Path] = report.write_report(options.folder, *how)
        else:
            written = report.write_study(options.name, options.folder, options.quick, progress.say)
    if options.only and options.json:
        print_json(rows)
    elif options.only:
        say(tables.rstrip())
    elif options.json and options.name != ALL:
        print_json(report.results(options.folder, options.name))
    else:
        say_written(written, options.json)
    return DONE


def _foretell(text: str) -> None:
    note(f"study: {text}")
