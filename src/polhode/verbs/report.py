"""``polhode report``: run the studies and write them."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.verbs.terminal import DONE, Progress, print_json

HELP = "run the studies and write them as JSON and Markdown"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("--quick", action="store_true", help="fewer and shorter cases")
    parser.add_argument("-o", dest="folder", metavar="DIR", default="reports", help="where to")


def main(options: Namespace) -> int:
    """Run the studies and write them."""
    from polhode.report import write_report

    folder = Path(options.folder)
    with Progress("report") as progress:
        written = write_report(folder, quick=options.quick, tick=progress.say)
    if options.json:
        print_json({"written": [str(path) for path in written]})
    else:
        print("\n".join(str(path) for path in written))
    return DONE
