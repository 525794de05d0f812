"""``polhode compare``: judge a trajectory that some other program computed."""

from __future__ import annotations

import math
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from polhode.common.errors import BadInput
from polhode.numbers.decimals import brief
from polhode.output import json_results
from polhode.verbs.terminal import (
    DONE,
    LONG,
    NOT_REACHED,
    ProgressLine,
    note,
    print_json,
    print_table,
    say,
    seconds,
    whole,
    word,
)

if TYPE_CHECKING:
    from polhode.judging.score.judgement import Judgement

_SECONDS = 1e-4  # about, for a radian of the motion that is followed
_FOLLOWED = 3e5  # radians: as far as its steps go

T = TypeVar("T")

HELP = "judge a trajectory that another program computed"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "files",
        type=word,
        nargs="+",
        metavar="FILE",
        help="a CSV (- for standard input), .npz, .npy or .parquet with a column t; several with "
        "--orders",
    )
    parser.add_argument("scene", type=word, metavar="SCENE", help="a case that ships, or a path")
    parser.add_argument("--number", help="the file's decimals are rounded values of this type")
    parser.add_argument("--digits", type=whole, help="digits of mp, with --number mp")
    parser.add_argument(
        "--as-it-stands", action="store_true", help="apply no other convention than the scene's"
    )
    parser.add_argument(
        "--read",
        metavar="WORDS",
        help="readings to apply, in their words: 'omega degrees; attitude scalar-last'",
    )
    parser.add_argument(
        "--columns",
        metavar="NAMES",
        help="the file's columns in order, t,qw,qx,...; or some of them: 'time_ms=t*1e-3, Q.W=q0'",
    )
    parser.add_argument(
        "--at-least",
        type=at_least,
        metavar="D",
        help="judge the table as it stands, unless --read names its conventions: exit code 3 if "
        "any part has fewer correct digits at any time, 2 if a number is missing",
    )
    parser.add_argument(
        "--orders",
        action="store_true",
        help="for files made with different steps: the order of their method at each time",
    )
    parser.add_argument(
        "--steps",
        metavar="H,H",
        help="with --orders: the files' step sizes, if they are not the spacing of the rows",
    )
    parser.add_argument(
        "--max-seconds",
        type=seconds,
        metavar="S",
        help="a limit on the proof that judges where there is no closed form",
    )


def main(options: Namespace) -> int:
    """Judge a trajectory that some other program computed."""
    if options.orders:
        return _orders(options)
    if len(options.files) > 1 or options.steps is not None:
        key, value = ("FILE", options.files[1]) if len(options.files) > 1 else ("--steps", None)
        raise BadInput("polhode compare", key, value, "with --orders only")
    try:
        judged, told = _judged(options, options.files[0], partial(_answer, options.json))
    except BadInput as fault:
        if fault.key != "max_seconds":
            raise
        note(f"polhode: {fault}")
        return NOT_REACHED
    if options.at_least is not None:
        from polhode.judging.score.gate import refuse_incomplete

        refuse_incomplete(judged)
    if isinstance(told, str):
        say(told)
    else:
        print_json(told)
    wanted = options.at_least
    if wanted is not None and not judged.worst >= wanted:
        where = f"{judged.worst_part} at t = {brief(judged.worst_time)}"
        found = f"{judged.worst:.2f} correct digits of {where}"
        note(f"polhode: {judged.subject.name}: {found}, where at least {wanted:g} are wanted")
        return NOT_REACHED
    return DONE


def at_least(text: str) -> float:
    """An option that is a number of digits."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise ArgumentTypeError(f"a number of digits, not {text[:40]!r}")
    return found


def _orders(options: Namespace) -> int:
    """The order between files; exit code 2 where they show none."""
    from polhode.judging.convergence_order import order_between

    if len(options.files) < 2 or options.at_least is not None:
        expected = "two files or more" if len(options.files) < 2 else "without --at-least"
        raise BadInput("polhode compare", "--orders", None, expected)
    judged = [_judged(options, file, lambda found: found) for file in options.files]
    steps = None if options.steps is None else options.steps.split(",")
    found = order_between(judged, steps)
    if options.json:
        print_json(json_results.of_order(found))
        return DONE
    rows = [
        [brief(t), *(f"{d:.2f}" for d in digits), "" if order is None else f"{order:.2f}"]
        for t, order, *digits in zip(found.times, found.orders, *found.digits, strict=True)
    ]
    print_table(["t", *found.names, "order"], rows)
    say(str(found))
    return DONE


def _answer(json: bool, judged: Judgement) -> tuple[Judgement, str | dict[str, object]]:
    """The judgement, and as text, or as an object for JSON."""
    return judged, json_results.of_judgement(judged) if json else str(judged)


def _judged(options: Namespace, file: str, answer: Callable[[Judgement], T]) -> T:
    """What is made of the judgement of a file, which may ask for more of it."""
    from polhode.judging.score.compare import compare

    path, number, digits = Path(file), options.number, options.digits
    with ProgressLine("compare") as progress:

        def first(brief: Judgement, count: int) -> None:
            digits = f"{brief.state_worst:.2f} correct digits" if brief.digits else "no state"
            told = f"{digits} in {len(brief.times)} of {count} rows, all of them follow"
            progress.say(told, at_once=True)

        def foretold(seconds: float, unit: str) -> None:
            if seconds > LONG:
                hint = f"; its t seems to be in {unit}" if unit else ""
                progress.clear()
                note(
                    f"{path}: there is no closed form here, and the proof that judges will take "
                    f"about {seconds:.2g} s; --max-seconds S or Ctrl-C ends it sooner{hint}"
                )

        judged = compare(
            path,
            options.scene,
            number=number,
            digits=digits,
            columns=None if options.columns is None else options.columns.split(","),
            first=first,
            progress=partial(progress.show, what="rows or steps of the reference"),
            max_seconds=options.max_seconds,
            forecast=foretold,
            as_it_stands=options.as_it_stands or options.at_least is not None,
            read=options.read,
        )
        angle = 10.0**judged.reference.scene.log10_rate * max(abs(float(t)) for t in judged.times)
        if (seconds := _SECONDS * min(angle, _FOLLOWED)) > LONG:
            progress.clear()
            told = f"the motion is followed through {angle:.2g} radians for the digits to expect"
            note(f"{path}: {told}, up to some {seconds:.0f} s; Ctrl-C ends it")
        return answer(judged)
