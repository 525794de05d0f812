"""``polhode study``: run one study and write it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.verbs.options import folder
from polhode.verbs.terminal import DONE, ProgressLine, print_json, say

HELP = "run one study and write it"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("name", metavar="NAME", help="accuracy, stability, events, ...")
    parser.add_argument("--quick", action="store_true", help="fewer and shorter cases")
    parser.add_argument(
        "--only",
        metavar="TEXT",
        action="append",
        default=[],
        help="only rows with TEXT in their names (may be repeated); printed, nothing is written",
    )
    parser.add_argument(
        "-o", dest="folder", type=folder, metavar="DIR", default="reports", help="folder (reports)"
    )


def main(options: Namespace) -> int:
    """Run one study and write it, or print some of its rows."""
    from polhode.studies import report

    if options.only:
        with ProgressLine("study") as progress:
            found, tables = report.part(options.name, options.only, options.quick, progress.say)
        if options.json:
            print_json(found)
        else:
            say(tables.rstrip())
        return DONE
    place = Path(options.folder)
    with ProgressLine("study") as progress:
        written = report.write_study(options.name, place, options.quick, progress.say)
    if options.json:
        print_json(report.results(place, options.name))
    else:
        say("\n".join(str(path) for path in written))
    return DONE
