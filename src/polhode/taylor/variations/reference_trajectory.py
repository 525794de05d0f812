"""What leads tangents in double along a motion that a double does not follow."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from polhode.equations.system import System
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import EXTENDED, QUAD, NumberType
from polhode.numbers.rows import Doubles, Rows
from polhode.scenes.scene import Scene
from polhode.taylor.backend import defaults
from polhode.taylor.integrator.prepared_system import PreparedSystem
from polhode.taylor.integrator.stepping import Integrator

_SPARE_DIGITS = 10  # of a state as doubles, and of what is lost until the next one is asked for


class Leader:
    """The motion in a type wide enough for what it has multiplied errors by, at growing times."""

    def __init__(self, plain: System) -> None:
        self._plain = plain
        self._number: NumberType | None = None

    def at(self, time: float, log10_growth: float) -> Doubles:
        """The six components of the state at a time, as doubles."""
        needed = log10_growth + _SPARE_DIGITS
        if self._number is None or needed > self._number.most_digits:
            ready = [EXTENDED] if number_types.extended_here() else []
            holding = (kind for kind in (*ready, QUAD) if kind.most_digits >= needed)
            self._number = next(holding, None) or number_types.mp(2 * needed)
            self._run = Integrator(PreparedSystem(self._plain, self._number))
        rows: Rows = []
        while len(rows) == 0:
            rows, _ = self._run.chunk([Fraction(time)], defaults.of(self._number).chunk)
        return six([exactly(x) for x in rows[0]])


def six(state: Sequence[Exact]) -> Doubles:
    """A state as six doubles, gamma zero where there is none."""
    return np.array([*(to_double(x) for x in state), *[0.0] * (6 - len(state))])


def pendulum(scene: Scene) -> float:
    """The scale of w for a body at rest, in the scene's own unit of time."""
    square = scene.pendulum_rate_squared
    return to_double(exact.sqrt(square * Fraction(4) ** scene.time_unit)) if sign(square) else 1.0
