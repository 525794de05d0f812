"""``polhode benchmark``: the heavy top benchmark, made again."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from polhode.verbs.options import add_folder, word
from polhode.verbs.terminal import DONE, ProgressLine, note, say_written


def add_benchmark(parser: ArgumentParser) -> None:
    """The verb's own options."""
    add_folder(parser, "reports/benchmark")
    parser.add_argument(
        "--only",
        type=word,
        metavar="NAME",
        action="append",
        default=[],
        help="one top, its values and certificate alone (may be repeated)",
    )


def benchmark(options: Namespace) -> int:
    """Prove and write all tops, or some."""
    from polhode.benchmark.folder import SECONDS, write_benchmark
    from polhode.benchmark.tops import TOPS

    if not options.only:
        note(f"polhode: {len(TOPS)} tops, about {SECONDS * len(TOPS) / 60:.0f} minutes")
    with ProgressLine("benchmark") as progress:
        written = write_benchmark(options.folder, options.only, progress.say)
    say_written(written, options.json)
    return DONE
