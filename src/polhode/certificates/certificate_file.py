"""Files of certificates, and their grids of numbers."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TypeAlias, TypeVar

from flint import arb

from polhode.certificates import verify
from polhode.common.arguments import of_kind
from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import check_writable, write_whole
from polhode.common.interrupts import Progress
from polhode.numbers import exact
from polhode.numbers.exact import Exact, Irrational
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import middle
from polhode.scenes.body import Body

# --- certificate file -----------------------------------------------------------------------------
#
# Certificates are checked by their own checker before they are written.


#: The part of the time that guesses take; the check, which takes the rest, counts from 0 again.
MAKING = 0.2
#: JSON's objects.
JsonObject: TypeAlias = dict[str, object]
Proved = TypeVar("Proved")

_MORE = (0, 48, 112, 192)  # bits, where those given are too few


def checked(
    name: str,
    certificate_of: Callable[[int], JsonObject],
    bits: int,
    progress: Progress | None = None,
) -> JsonObject:
    """The first of several tries that its checker proves, each with more bits; raises BadInput.

    ``name``: of the scene; ``certificate_of``: a certificate with so many bits, whose making shows
    the progress up to :data:`MAKING`.
    """
    fault = ""
    for more in _MORE:
        certificate = certificate_of(bits + more)
        try:
            checking = part_of(progress, MAKING, 1.0)
            by_checker(verify.KINDS[str(certificate["kind"])], certificate, checking)
        except (verify.NotProved, verify.Damaged) as refused:
            fault = str(refused)
            if isinstance(refused, verify.Damaged):
                break
            continue
        return certificate
    raise BadInput(name, "certificate", fault, "a statement that its own checker proves")


def part_of(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """What shows the progress of a part of the work, which is all from ``begin`` to ``end``."""
    if progress is None:
        return None
    return lambda fraction, steps: progress(begin + (end - begin) * fraction, steps)


def by_checker(function: Callable[..., Proved], *arguments: object) -> Proved:
    """What a function of the checker gives; raises its NotProved and Damaged."""
    with ctx.workprec(verify.COARSE):  # which the checker changes as it likes
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
    if not isinstance(there, dict) or there.get("kind") not in verify.KINDS:
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
    numbers: JsonObject,
    start: Sequence[arb],
    end: Fraction,
    bits: int,
    time_bits: int | None = None,
    part: float = _STEP,
    progress: Progress | None = None,
    growth: float = 0.0,
) -> JsonObject:
    """A grid of steps beyond ``end``, and numbers near the motion at its times.

    ``time_bits``: the last time is ``end`` rounded to so many bits.  ``part``: of the radius of
    convergence that a step is.  ``growth``: about int |A| of a step, instead.
    """
    rows, (centre, (weight,)), _ = verify.read_body(numbers, ())
    inertia = [[verify.ball(x) for x in row] for row in rows]
    torque = [verify.ball(weight) * verify.ball(x) for x in centre]
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
    return {"time_bits": fine, "grid": grid, "state_bits": state_bits, "centres": centres}


def _length(body: verify.Body, centre: Sequence[arb], part: float) -> float:
    """A step that is a part of the radius of convergence."""
    rows = verify.taylor(body, centre, arb(1), _ORDER)
    sizes = [max(float(abs(x)) for x in column) for column in zip(*rows, strict=True)]
    rates = [x ** (1 / k) for k, x in enumerate(sizes, 1) if 3 * k > _ORDER and x > 0]
    return min(part / max(rates, default=part), _LONGEST)
