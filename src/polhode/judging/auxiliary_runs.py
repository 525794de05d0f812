"""Runs beside a reference: in double, or in a wider type where that one does not decide.

They tell how often psi and phi of a closed form went round, and what a table may be near to.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.common.errors import BadInput, ConstantZero
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, NumberType, Real, Row
from polhode.scenes.scene import Event, Scene

# a run's side of a pole is the motion's where it keeps away by so many of its errors of theta, and
# of its eps
_ERRORS, _ROUNDINGS = 1e3, 1e6
FARTHEST = 1e6  # radians, to which the steps of a run do not go
FINE = NumberType("mp", 192)  # of times at which a run is asked


class TurningRun(NamedTuple):
    """A run that tells how often psi and phi went round: at the times asked for, and its poles.

    ``extremes``: times at which theta is extreme, and how far the third axis is from the vertical
    there, as a sine; ``eps``: of its numbers.
    """

    angles: list[Row]
    extremes: list[tuple[Fraction, float]]
    eps: float

    def passages(self, rows: Sequence[Sequence[Real | None]]) -> list[Fraction]:
        """Times at which it passes a pole so near that rounding may have chosen the side.

        ``rows``: the true angles at the times asked for.
        """
        pairs = [(x, y) for (_, x, _), (_, y, _) in zip(rows, self.angles, strict=True)]
        errors = [abs(float(x) - float(y)) for x, y in pairs if x is not None and y is not None]
        clear = max(_ERRORS * max(errors, default=0.0), _ROUNDINGS * self.eps)
        return [t for t, sine in self.extremes if not sine > clear]


def turning_run(
    scene: Scene, times: Sequence[Exact], number: NumberType, farthest: float
) -> TurningRun | None:
    """The run in a number type; None where it does not come so far."""
    try:
        rows = in_double(scene, times, ("angles",), number, farthest, (Event("nutation"),))
    except ConstantZero:  # theta stays what it is at the start
        rows = in_double(scene, times, ("angles",), number, farthest)
    if not rows:
        return None
    extremes = [(t, math.hypot(*map(float, row[3:5]))) for t, row in rows["events"]]
    if not scene.starts_at_pole:
        extremes.append((Fraction(0), math.hypot(*map(to_double, scene.start[3:5]))))
    return TurningRun(rows["angles"], extremes, float(number.eps))


def in_double(
    scene: Scene,
    times: Sequence[Exact],
    outputs: tuple[str, ...],
    number: NumberType = DOUBLE,
    farthest: float = FARTHEST,
    events: tuple[Event, ...] = (),
) -> dict[str, list[Any]]:
    """Rows of a run at times of either sign in any order: states, and outputs that are integrated.

    By "events" the times and states of all events, of both senses of time.

    Nothing where it does not come so far.  ``number``: the type in which it is integrated;
    ``farthest``: radians, to which it is.  Raises ConstantZero for an event that is zero all along,
    and ImportError where heyoka is not installed.
    """
    if max((abs(to_double(t)) for t in times), default=0.0) * 10.0**scene.log10_rate > farthest:
        return {}
    from polhode.runs.trajectory import solve

    plain = replace(scene, outputs=outputs, events=events)
    met: list[tuple[Fraction, Any]] = []
    instants = [t if isinstance(t, Fraction) else FINE.rounded(t) for t in times]
    by_time: dict[str, dict[Fraction, Any]] = {word: {} for word in ("states", *outputs)}
    try:
        for part in by_sign(instants):
            run = solve(plain.at(part), number, interruptible=False)
            if len(run.times) < len(part):
                return {}
            for word, rows in by_time.items():
                rows |= zip(part, getattr(run, word), strict=True)
            for event in run.events:
                if not event.complete:
                    return {}
                met += zip(event.times, event.states, strict=True)
    except ConstantZero:
        raise
    except (BadInput, ValueError, OverflowError):
        return {}
    return {word: [rows[t] for t in instants] for word, rows in by_time.items()} | {"events": met}


def by_sign(times: Sequence[Fraction]) -> list[list[Fraction]]:
    """The different times from 0 ahead, and those from 0 back, each in order; none empty."""
    different = dict.fromkeys(times)  # in the order given, which is nearly always sorted
    ahead, behind = ([t for t in different if s * t.numerator > 0] for s in (1, -1))
    if 0 in different:
        (ahead if ahead or not behind else behind).append(Fraction(0))
    return [part for part in (sorted(ahead), sorted(behind, reverse=True)) if part]
