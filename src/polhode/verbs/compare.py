"""``polhode compare``: judge a trajectory that some other program computed."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.output import json_results
from polhode.verbs.terminal import DONE, ProgressLine, print_json, say, whole, word

if TYPE_CHECKING:
    from polhode.judging.score.judgement import Judgement

HELP = "judge a trajectory that some other program computed"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "file", type=word, metavar="FILE", help="a CSV with a column t and any of the others"
    )
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument("--number", help="the file's decimals are rounded values of this type")
    parser.add_argument("--digits", type=whole, help="digits of mp, with --number mp")
    parser.add_argument(
        "--as-it-stands", action="store_true", help="apply no other convention than the scene's"
    )


def main(options: Namespace) -> int:
    """Judge a trajectory that some other program computed."""
    from polhode.common.executors import cores
    from polhode.judging.score.compare import compare

    path, number, digits = Path(options.file), options.number, options.digits
    with ProgressLine("compare") as progress:

        def first(brief: Judgement, count: int) -> None:
            digits = f"{min(brief.digits):.2f} correct digits" if brief.digits else "no state"
            told = f"{digits} in {len(brief.times)} of {count} rows, all of them follow"
            progress.say(told, at_once=True)

        judged = compare(
            path,
            options.scene,
            number=number,
            digits=digits,
            first=first,
            workers=cores(),
            progress=partial(progress.show, what="rows of the closed form"),
            as_it_stands=options.as_it_stands,
        )
        told = json_results.of_judgement(judged) if options.json else str(judged)
    if isinstance(told, str):
        say(told)
    else:
        print_json(told)
    return DONE
