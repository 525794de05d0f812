"""``polhode report``: run all studies and write them."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.verbs.options import folder
from polhode.verbs.terminal import DONE, ProgressLine, note, print_json, say

HELP = "run all studies and write them as JSON, Markdown and one HTML page"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("--quick", action="store_true", help="fewer and shorter cases")
    parser.add_argument("--fresh", action="store_true", help="discard earlier results")
    parser.add_argument(
        "-o", dest="folder", type=folder, metavar="DIR", default="reports", help="folder (reports)"
    )


def main(options: Namespace) -> int:
    """Run all studies and write them."""
    from polhode.studies.report import write_report

    place, mode = Path(options.folder), (options.quick, options.fresh)
    with ProgressLine("report") as progress:
        written = write_report(place, *mode, progress.say, lambda text: note(f"report: {text}"))
    if options.json:
        print_json({"written": [str(path) for path in written]})
    else:
        say("\n".join(str(path) for path in written))
    return DONE
