"""``polhode report``: run all studies and write them."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.verbs.options import add_folder
from polhode.verbs.terminal import DONE, ProgressLine, note, say_written

HELP = "run all studies and write them as JSON, Markdown and one HTML page"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("--quick", action="store_true", help="fewer and shorter cases")
    parser.add_argument("--fresh", action="store_true", help="discard earlier results")
    add_folder(parser, "reports")


def main(options: Namespace) -> int:
    """Run all studies and write them."""
    from polhode.studies.report import write_report

    def foretell(text: str) -> None:
        note(f"report: {text}")

    with ProgressLine("report") as progress:
        how = options.quick, options.fresh, progress.say, foretell
        written = write_report(options.folder, *how)
    say_written(written, options.json)
    return DONE
