"""Options that change a scene before a verb takes it: output times, form, outputs."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.scenes.vocabulary import COLUMNS
from polhode.verbs.options import whole

if TYPE_CHECKING:
    from polhode.numbers.exact import Exact
    from polhode.scenes.scene import Scene

TIMES, FORM, OUTPUTS = "times", "form", "outputs"


def add(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Add the options of some of the words TIMES, FORM, OUTPUTS."""
    if TIMES in words:
        _add_times(parser)
    if FORM in words:
        parser.add_argument("--form", metavar="F", help="form of the equations")
    if OUTPUTS in words:
        parser.add_argument("--outputs", metavar="O,O", help=", ".join(COLUMNS))


def applied(options: Namespace, scene: Scene, words: Sequence[str]) -> Scene:
    """The scene with what the options of these words say; raises BadInput."""
    if TIMES in words:
        scene = scene.at(times_of(options, scene))
    if FORM in words and options.form is not None:
        scene = replace(scene, form=options.form)
    if OUTPUTS in words and options.outputs is not None:
        scene = replace(scene, outputs=tuple(o for o in options.outputs.split(",") if o))
    return scene


def applied_to_all(
    options: Namespace, names: Sequence[str], words: Sequence[str]
) -> list[Scene | str]:
    """The scenes of these names with what the options say; tables stay names."""
    from polhode.judging.tables.table_file import is_table
    from polhode.output.report import file_of
    from polhode.scenes import library

    return [
        name if is_table(file_of(name).name) else applied(options, library.load(name), words)
        for name in names
    ]


def _add_times(parser: ArgumentParser) -> None:
    at = "output times instead of the scene's; one of them may be FROM:TO:N, for N evenly spaced"
    parser.add_argument("--at", metavar="T,T...", help=at)
    parser.add_argument("--end", metavar="T", help="last time instead of the scene's")
    spacing = parser.add_mutually_exclusive_group()
    samples = "N evenly spaced times from 0 to the end, both included (as many as the scene's)"
    spacing.add_argument("--samples", type=whole, metavar="N", help=samples)
    every = "the times 0, DT, 2 DT, ... that are not beyond the end"
    spacing.add_argument("--every", metavar="DT", help=every)


def times_of(options: Namespace, scene: Scene) -> Sequence[Exact]:
    """The times that are asked for, exact: the scene's own unless an option says otherwise."""
    from polhode.numbers.conversion import TIME
    from polhode.numbers.exact import sign
    from polhode.scenes.scene import MAX_SAMPLES, even_times
    from polhode.scenes.vary import numbers

    even = {"--end": options.end, "--samples": options.samples, "--every": options.every}
    if options.at is not None:
        for key, value in even.items():
            if value is not None:
                raise BadInput(scene.name, key, value, "no value together with --at")
        return tuple(numbers(options.at, "--at", scene.name, scene.units, TIME))
    if all(value is None for value in even.values()):
        return scene.times
    end = scene.end if options.end is None else time_of(scene, "--end", options.end)
    if sign(end) == 0:
        raise BadInput(scene.name, "--end", options.end, "a time other than 0")
    if options.every is not None:
        return _multiples(scene, end, options.every)
    samples = max(2, len(scene.times)) if options.samples is None else options.samples
    if not 2 <= samples <= MAX_SAMPLES:
        raise BadInput(scene.name, "--samples", samples, f"a whole number from 2 to {MAX_SAMPLES}")
    return even_times(end, samples)


def _multiples(scene: Scene, end: Exact, text: str) -> Sequence[Exact]:
    """The multiples of a step from 0 to the end."""
    from polhode.numbers.conversion import to_double
    from polhode.numbers.exact import sign
    from polhode.scenes.scene import MAX_SAMPLES, even_times

    step = time_of(scene, "--every", text)
    if sign(step) <= 0:
        raise BadInput(scene.name, "--every", text, "a time above 0; --end says the direction")
    last = abs(end)
    ratio = to_double(last / step)
    if not 1 <= ratio < MAX_SAMPLES:
        expected = f"a time that makes two to {MAX_SAMPLES} times until t = {to_double(end):g}"
        raise BadInput(scene.name, "--every", text, expected)
    count = round(ratio)
    count -= sign(count * step - last) > 0  # the double may be rounded to a whole number
    return even_times(count * step * sign(end), count + 1)


def time_of(scene: Scene, key: str, text: str) -> Exact:
    """A time in the scene's units; raises BadInput, with the option's name as ``key``."""
    from polhode.numbers.conversion import TIME, in_text
    from polhode.numbers.expression import ExpressionError

    try:
        return in_text(text, scene.units, TIME)
    except ExpressionError as fault:
        raise BadInput(scene.name, key, text, f"a time ({fault})") from None
