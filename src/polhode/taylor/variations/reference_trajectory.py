"""The motion that tangents in double are taken along, also where a double does not follow it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from polhode.motion.outcomes import Outcome
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import doubles, to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, NumberType
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene
from polhode.taylor.backend import defaults
from polhode.taylor.integrator.stepping import Integrator
from polhode.taylor.integrator.system import System

_DOUBLES_TRUE = 8.0  # log10 of the growth up to which a run in double is the motion to 7 digits
_SPARE_DIGITS = 10  # of wider types: of a state as doubles, and of what is lost until the next one


class Leader:
    """The motion in a type wide enough for what it has multiplied errors by, at growing times."""

    def __init__(self, plain: System) -> None:
        self._plain = plain
        self._number: NumberType | None = None

    def holds(self, log10_growth: float) -> bool:
        """Whether the type at work is wide enough for a motion that multiplies errors so."""
        return self._number is not None and _is_enough(self._number, log10_growth)

    def rows(self, times: Sequence[float], log10_growth: float) -> Doubles:
        """The six components of the state at times, as doubles; nan where it does not get there.

        From time 0 on in a wider type, where the one at work does not hold the growth.
        """
        if self._number is None or not self.holds(log10_growth):
            self.release()
            ready = [DOUBLE, *([EXTENDED] if number_types.extended_here() else []), QUAD]
            enough = (kind for kind in ready if _is_enough(kind, log10_growth))
            wide = number_types.mp(2 * (log10_growth + _SPARE_DIGITS))
            self._number = next(enough, wide)
            self._run = Integrator(replace(self._plain, number=self._number))
        found, done, ended = np.full((len(times), 6), np.nan), 0, Outcome.STEP_LIMIT
        ahead = [Fraction(t) for t in times]
        while ended is Outcome.STEP_LIMIT and done < len(times):
            rows, ended = self._run.chunk(ahead[done:], defaults.of(self._number).chunk)
            if len(rows):
                there = found[done : done + len(rows)]
                there[:] = 0.0  # gamma, where there is none
                there[:, : len(self._plain.start)] = doubles(rows)
                done += len(rows)
        return found

    def at(self, time: float, log10_growth: float) -> Doubles:
        """The same at one time."""
        found: Doubles = self.rows([time], log10_growth)[0]
        return found

    def release(self) -> None:
        """Leave the compiled code to the next motion; the last call of all."""
        if self._number is not None:
            self._run.release()
            self._number = None


def _is_enough(number: NumberType, log10_growth: float) -> bool:
    if number == DOUBLE:
        return log10_growth <= _DOUBLES_TRUE
    return log10_growth + _SPARE_DIGITS <= number.most_digits


def six(state: Sequence[Exact]) -> Doubles:
    """A state as six doubles, gamma zero where there is none."""
    return np.array([*(to_double(x) for x in state), *[0.0] * (6 - len(state))])


def pendulum(scene: Scene) -> float:
    """The scale of w for a body at rest; of a scene inside its frame."""
    square = scene.pendulum_rate_squared
    return to_double(exact.sqrt(square)) if sign(square) else 1.0
