"""Output times as options say them: listed, or evenly spaced from 0 on."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence

from polhode.common.errors import BadInput
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.expression import ExpressionError
from polhode.scenes.given_numbers import TIME, in_text
from polhode.scenes.scene import MAX_SAMPLES, Scene, even_times
from polhode.scenes.vary import numbers


def times_of(options: Namespace, scene: Scene) -> Sequence[Exact]:
    """The times that are asked for, exact: the scene's own unless an option says otherwise."""
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
    try:
        return in_text(text, scene.units, TIME)
    except ExpressionError as fault:
        raise BadInput(scene.name, key, text, f"a time ({fault})") from None
