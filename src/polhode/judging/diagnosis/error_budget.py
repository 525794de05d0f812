"""The motion at any times in doubles: dearer digits are not needed to tell what a table means."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import accumulate, chain, pairwise
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.equations.form import field
from polhode.judging.diagnosis.ways import Right, matrices
from polhode.judging.reference import by_sign
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import brief
from polhode.numbers.number_types import DOUBLE, Doubles, NumberType
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from polhode.judging.conditioning import Band
    from polhode.scenes.body import Body


FARTHEST = 1e6  # radians, to which the steps of a run do not go


def integrated(
    scene: Scene, times: Sequence[Fraction], attitude: bool = True, number: NumberType = DOUBLE
) -> Right | None:
    """The motion, its attitude too where it has one; None where it cannot be integrated so far.

    ``number``: the type in which it is integrated.
    """
    if max((abs(to_double(t)) for t in times), default=0.0) * 10.0**scene.log10_rate > FARTHEST:
        return None
    from polhode.runs.solve import solve

    turning = attitude and bool(scene.columns[3:])
    asked = replace(scene, outputs=("attitude",) if turning else (), events=())
    parts = by_sign(times)
    states, turned = [], []
    try:
        for part in parts:
            run = solve(asked.at(part), number, interruptible=False)
            if len(run.times) < len(part):
                return None
            states.append(np.asarray(run.states, dtype=float))
            if turning:
                turned.append(np.asarray(run.attitude, dtype=float))
    except (BadInput, ImportError, ValueError, OverflowError):
        return None
    places = {t: k for k, t in enumerate(chain(*parts))}
    order = [places[t] for t in times]
    rows = np.concatenate(states)[order]
    if not turning:
        return Right(rows)
    quaternions = np.concatenate(turned)[order]
    return Right(rows, quaternions, matrices(quaternions))


# --- error budget ---------------------------------------------------------------------------------
#
# What limits the digits of a trajectory: rounding, inputs, conditioning, method or reference.
#
# And where a part leaves the motion: right until one time, and wrong from the next one on. A
# motion that multiplies errors takes digits too, and takes them from any part: what is expected
# of rounding explains such a fall, and then none is told.


LAST = 1.0  # digits: the type's own last ones
MOTION_TAKES = 2.0  # digits: what the motion takes before it is named
UNKNOWN = "unknown (the digits to expect were not computed)"
#: Smallest moment over largest below which a step loses more than one rounding, up to so many
#: digits: 12 of 24 runs of bodies like the case euler/needle (1e-6), 2 of 16 at 1e-4.
THIN, THIN_TAKES = 5e-5, 2.0
OF_THIN = "unknown (steps of so thin a body lose more than the expected digits allow for)"
ALONE = 0.03  # digits: what steps add to an error three times theirs
_MORE = 1.1  # times what rounded times explain: of rates that are not the same between two times
_MOST = 2.0  # times what the worst row's time explains: most of its error
FALL = 3.0  # digits between the fewest before and the most after
_BEFORE = 2  # times before, beside t = 0, where every program is right


def limit(
    digits: float,
    held: float,
    expected: Band | None,
    inputs: float | None,
    reference: float,
    steps: str,
    times: int = 1,
    thin: bool = False,
) -> str:
    """The name of what limits so many correct digits.

    ``held``: the most that the number type holds.  ``expected``: those of a run that rounds once a
    step.  ``inputs``: those that rounding the scene's numbers leaves.  ``reference``: those that
    the reference is good for, inf for a closed form.  ``times``: of so many these digits are the
    fewest.

    *reference*: it is not good for more.  *rounding*: these are the type's own last digits, or the
    motion takes few.  *inputs*: no fewer than expected, and it is rounding the scene's numbers that
    costs them: the steps add next to nothing.  *conditioning*: no fewer than expected; any method
    that rounds its state at each step in this type loses as much.  *method*: fewer than nineteen in
    twenty such runs have at their worst time; ``steps`` says what the method does.  *unknown*:
    what to expect was not computed, for the motion is too long; or the body is ``thin``, of which
    steps lose more.
    """
    if reference < digits + LAST:
        return "reference"
    if digits >= held - LAST:
        return "rounding"
    if expected is None:
        return UNKNOWN
    if digits < expected.least - selected(times):
        of_thin = thin and digits >= expected.least - selected(times) - THIN_TAKES
        return OF_THIN if of_thin else f"method ({steps})"
    if expected.middle >= held - MOTION_TAKES:
        return "rounding"
    lost = expected.most == 0
    alone = inputs is not None and inputs < expected.middle + ALONE and not lost
    return "inputs" if alone else "conditioning"


def selected(times: int) -> float:
    """How many digits below the band of its time the worst one of several may lie.

    At one time a run in twenty has fewer digits than the band's least.  A run whose worst time is
    looked for has many chances; with n times it is no more likely than that to fall short anywhere
    if each is allowed what happens once in 20 n (Bonferroni; however the times depend on each
    other).  For a normal deviate that is an error z(20 n)/z(20) times as large.
    """
    once, each = (NormalDist().inv_cdf(1 - 1 / (40 * n)) for n in (1, max(1, times)))
    return math.log10(each / once)


def chance(digits: float, expected: Band, times: int) -> float:
    """The share of runs that have so few digits at their worst time by rounding alone, or fewer.

    Of a normal deviate, as in :func:`selected`; at most 1.  Who looks at hundreds of runs finds
    some of a share of one in a hundred.
    """
    ratio = 10.0 ** min(expected.least - digits, 3.0)
    deviate = NormalDist().inv_cdf(1 - 1 / 40) * ratio
    return min(1.0, times * math.erfc(deviate / math.sqrt(2)))


def is_thin(body: Body) -> bool:
    """Whether steps of a body lose more than the band allows: see :data:`THIN`."""
    moments = [to_double(x) for x in body.moments]
    return min(moments) < THIN * max(moments)


def is_lost(digits: float | None, expected: Band | None) -> bool:
    """Whether no digit is expected there, and none was found either."""
    return expected is not None and expected.middle == 0 and digits is not None and digits < LAST


def shown_digits(digits: float | None, expected: Band | None) -> str:
    """Correct digits for people; never a number where none is left, or none was judged."""
    if digits is None:
        return "-"
    return "none left" if is_lost(digits, expected) else f"{digits:.2f}"


def between(known: Mapping[int, Any], times: Sequence[Fraction]) -> tuple[Any, ...]:
    """Digits (numbers or bands) at times, linear between the rows where they are known.

    None where they are not known at a neighbour.
    """
    kind = next((x for x in known.values() if x is not None), None)
    if kind is None:
        return (None,) * len(times)
    nodes, unknown = sorted(known, key=times.__getitem__), np.full(np.size(kind), math.nan)
    rows = np.array([unknown if known[k] is None else np.ravel(known[k]) for k in nodes])
    at = np.array([to_double(t) for t in times])
    found = np.stack([np.interp(at, at[nodes], column) for column in rows.T], axis=1).tolist()
    make = type(kind) if np.size(kind) > 1 else float
    return tuple(
        known[k] if k in known else None if math.isnan(row[0]) else make(*row)
        for k, row in enumerate(found)
    )


def time_rounding(
    scene: Scene,
    states: Doubles,
    time_errors: Sequence[float],
    digits: Sequence[float],
    rounding: Sequence[float],
) -> float | None:
    """By how much rounded times are off at most, if that explains the digits; None if not.

    A row holds at a time that the table has rounded, such as a clock's late ones:
    :mod:`polhode.judging.tables.csv_file`.

    ``states``: rows of the scene's columns.  ``time_errors``: by how much their times may be off.
    ``digits``: the correct ones of each row.  ``rounding``: those that rounding the states leaves.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # of numbers that are no motion's
        speed = float(np.max(np.linalg.norm(states[:, :3], axis=1))) or 1.0
        rates = np.abs(field(scene)(0.0, states.T))
        omega, gamma = np.max(rates[:3], axis=0), np.max(rates[3:], axis=0, initial=0.0)
        moved = np.array(time_errors) * np.maximum(omega / speed, gamma)
    errors = 10.0 ** -np.array(digits)
    right = bool(np.all(errors <= _MORE * (moved + 10.0 ** -np.array(rounding))))
    worst = int(np.argmax(errors))
    return max(time_errors) if right and errors[worst] <= _MOST * moved[worst] else None


class Departure(NamedTuple):
    """``least`` digits or more until a time, ``most`` or fewer from the next one on."""

    until: Fraction
    least: float
    since: Fraction
    most: float

    def __str__(self) -> str:
        return (
            f"right until t = {brief(self.until)} ({self.least:.2f} digits or more), "
            f"then from t = {brief(self.since)} on {self.most:.2f} or fewer"
        )


def departure(
    times: Sequence[Fraction],
    digits: Sequence[float | None],
    expected: Callable[[], Sequence[Band | None]],
) -> Departure | None:
    """Where digits fall for good, by far more than is expected; None where they do not.

    ``expected``: the digits of runs that round once a step; asked only where there is a fall.
    """
    kept = [k for k, d in enumerate(digits) if d is not None]
    told = [d for d in digits if d is not None]
    least = list(accumulate(told, min))
    most = list(accumulate(reversed(told), max))[::-1]
    first = _BEFORE + (times[0] == 0 and kept[:1] == [0])
    falls = [(least[n - 1] - most[n], n) for n in range(first, len(told))]
    fall, n = max(falls, default=(0.0, 0))
    if fall < FALL or least[n - 1] < FALL:
        return None
    if not all(abs(s) < abs(t) and s * t >= 0 for s, t in pairwise(times)):
        return None  # not in order
    bands = expected()
    for k in kept[n:]:
        band = bands[k] if bands else None
        if band is None or band.least < most[n] + FALL:
            return None
    return Departure(times[kept[n - 1]], least[n - 1], times[kept[n]], most[n])
