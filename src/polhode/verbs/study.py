"""``polhode study``: run one study and write it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.verbs.options import add_folder
from polhode.verbs.terminal import DONE, ProgressLine, print_json, say, say_written

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
    add_folder(parser, "reports")


def main(options: Namespace) -> int:
    """Run one study and write it, or print some of its rows."""
    from polhode.studies import report

    if options.only:
        with ProgressLine("study") as progress:
            rows, tables = report.part(options.name, options.only, options.quick, progress.say)
        if options.json:
            print_json(rows)
        else:
            say(tables.rstrip())
        return DONE
    with ProgressLine("study") as progress:
        written = report.write_study(options.name, options.folder, options.quick, progress.say)
    if options.json:
        print_json(report.results(options.folder, options.name))
    else:
        say_written(written, json=False)
    return DONE
