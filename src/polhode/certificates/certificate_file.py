"""Files of certificates, and their grids of numbers."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

from flint import arb

from polhode.certificates import verify
from polhode.common.arguments import of_kind
from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import check_writable, write_whole
from polhode.common.interrupts import Progress
from polhode.common.texts import JsonObject as JsonObject
from polhode.numbers import exact
from polhode.numbers.exact import ONE, Exact, Irrational
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import middle
from polhode.scenes.body import Body

# --- certificate file -----------------------------------------------------------------------------


Proved = TypeVar("Proved")


def by_checker(
    function: Callable[..., Proved], *arguments: object, bits: int = verify.COARSE
) -> Proved:
    """What a function of the checker gives; raises its NotProved and Damaged.

    ``bits``: the precision, where the function does not set it itself.
    """
    with ctx.workprec(bits):  # which the checker changes as it likes
        try:
            return function(*arguments)
        except (ZeroDivisionError, OverflowError):
            raise verify.NotProved("a number is too large, or too small") from None


def refuse_another(path: str | Path) -> None:
    """Raise BadInput where a file is there that is no certificate; an empty one is nothing."""
    of_kind("save", "path", path, (str, Path), "the path of a .json file")
    place = Path(path)
    if not os.path.isfile(place) or not place.stat().st_size:
        return
    try:
        there = json.loads(place.read_text(encoding="utf-8"))
    except (OSError, *UNREADABLE):
        there = None
    kinds = [*verify.KINDS]  # in which a list, too, can be looked for
    if not isinstance(there, dict) or there.get("kind") not in kinds:
        expected = "a new file, or a certificate's (there is another, perhaps that of a table)"
        raise BadInput(str(place), "file", None, expected)


def write(path: str | Path, text: str) -> None:
    """A certificate's file, whole or not at all; raises BadInput."""
    check_writable(Path(path), [".json"], [])
    refuse_another(path)
    write_whole({Path(path): text + "\n"})


# --- grid -----------------------------------------------------------------------------------------
#
# What a certificate needs besides its statement: a body's exact numbers, and a grid of steps.
#
# The grid uses the checker's own polynomials. Nothing of it is believed, but the numbers.


_STEP = 0.3  # of the radius of convergence, if nothing else is asked
_ORDER = 24  # of the polynomials that tell it
_LONGEST = 1.0  # step, in the unit of time that the body suggests
_FINE = 12  # bits of a step, in that unit
_BODY = "moments", "inertia", "centre", "weight"


def on_level(body: Body, h: Exact, f: Exact, bits: int) -> JsonObject:
    """A body's numbers with h, f and |gamma|^2 of a level."""
    level = [number(x, bits) for x in (h, f, ONE)]
    return {**body_numbers(body, bits), "level": level}


def body_numbers(body: Body, bits: int) -> JsonObject:
    """A body's exact numbers as texts, irrational ones as balls."""
    rows = [[number(x, bits) for x in row] for row in body.inertia]
    oblique = any(body.inertia[i][j] != 0 for i in range(3) for j in range(3) if i != j)
    form = {"inertia": rows} if oblique else {"moments": [rows[i][i] for i in range(3)]}
    centre = [number(x, bits) for x in body.centre]
    return {**form, "centre": centre, "weight": number(body.weight, bits)}


def number(x: Exact, bits: int) -> str | list[str]:
    """A number as the checker reads it: a text, or middle and radius."""
    if not isinstance(x, Irrational):
        return str(x)
    mantissa, exponent = exact.rounded(x, bits) if x else (0, -bits)
    unit = Fraction(2) ** exponent  # more than the rounding
    return [str(mantissa * unit), str(unit)]


def steps(
    scene: JsonObject,
    start: Sequence[arb],
    end: Fraction,
    bits: int,
    time_bits: int | None = None,
    part: float = _STEP,
    progress: Progress | None = None,
    growth: float = 0.0,
) -> verify.Guesses:
    """A grid of steps beyond ``end``, and numbers near the motion at its times.

    ``scene``: a body's numbers, and others.  ``time_bits``: the last time is ``end`` rounded to so
    many bits.  ``part``: of the radius of convergence that a step is.  ``growth``: about int |A| of
    a step, instead.
    """
    numbers = {key: scene[key] for key in _BODY if key in scene}
    inertia, torque, _ = verify.balls_of(verify.read_body(numbers, ()))
    shift = verify.scaling(inertia, torque, start)
    body = verify.Body(inertia, [x * arb(2) ** (-2 * shift) for x in torque])
    sense = 1 if end > 0 else -1
    last = math.ceil(abs(end) * Fraction(2) ** (_FINE + shift))
    state_bits = max(bits // 2 + 30, bits - verify.STATES)  # V's bits are those that are left
    powers = [state_bits + shift] * 3 + [state_bits] * 3
    x = [(x * arb(2) ** (-shift if k < 3 else 0)).mid() for k, x in enumerate(start)]
    grid, centres = [0], list[list[int]]()
    while abs(grid[-1]) < last:
        if progress is not None:
            progress(abs(grid[-1]) / last, len(centres))
        centres.append([round(middle(y * arb(2) ** e)) for y, e in zip(x, powers, strict=True)])
        steep = float(verify.row_sum(verify.slope(body, x))) if growth else 0.0
        longest = growth / steep if steep else _length(body, x, part)
        ticks = max(1, min(int(longest * 2**_FINE), last - abs(grid[-1])))
        h = arb(sense * ticks) * arb(2) ** -_FINE
        series = verify.taylor(body, x, h, bits)
        x = [(y + verify.summed(row)).mid() for y, row in zip(x, series, strict=True)]
        grid.append(grid[-1] + sense * ticks)
        if len(grid) > verify.MOST_STEPS:
            break  # which the checker refuses
    fine = _FINE + shift
    if time_bits is not None:
        times = [x << (time_bits - fine) for x in grid[:-1]]
        grid, fine = [*times, round(end * Fraction(2) ** time_bits)], time_bits
    return verify.Guesses(fine, grid, state_bits, centres, bits)


def _length(body: verify.Body, centre: Sequence[arb], part: float) -> float:
    """A step that is a part of the radius of convergence."""
    rows = verify.taylor(body, centre, arb(1), _ORDER)
    sizes = [max(float(abs(x)) for x in column) for column in zip(*rows, strict=True)]
    rates = [x ** (1 / k) for k, x in enumerate(sizes, 1) if 3 * k > _ORDER and x > 0]
    return min(part / max(rates, default=part), _LONGEST)
