"""``polhode benchmark``: the heavy top benchmark, made again."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.verbs.options import folder, word
from polhode.verbs.terminal import DONE, ProgressLine, note, print_json, say

HELP = "the heavy top benchmark: certified values, certificates, checkers in other languages"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "-o",
        dest="folder",
        type=folder,
        metavar="DIR",
        default="reports/benchmark",
        help="folder (reports/benchmark)",
    )
    parser.add_argument(
        "--only",
        type=word,
        metavar="NAME",
        action="append",
        default=[],
        help="one top, its values and certificate alone (may be repeated)",
    )


def main(options: Namespace) -> int:
    """Prove and write all tops, or some."""
    from polhode.benchmark.folder import SECONDS, write_benchmark
    from polhode.benchmark.tops import TOPS

    if not options.only:
        note(f"polhode: {len(TOPS)} tops, about {SECONDS * len(TOPS) / 60:.0f} minutes")
    with ProgressLine("benchmark") as progress:
        written = write_benchmark(Path(options.folder), options.only, progress.say)
    if options.json:
        print_json({"written": [str(path) for path in written]})
    else:
        say("\n".join(str(path) for path in written))
    return DONE
