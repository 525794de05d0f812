"""Variational equations of the Euler–Poisson equations (3.29), by heyoka, in double.

Beside the state x, tangents v obey v' = J(x) v, J by symbolic differentiation.  The equations are
compiled once for any body: their numbers are parameters.  Tangents are linear, so they may be
scaled at any time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from polhode.equations.terms import NAMES
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Number
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import STATE
from polhode.taylor.integrator.engine import Engine
from polhode.taylor.integrator.specification import Equations, principal_engine

_BLOCK = 50_000  # steps, a fifth of a second, between which a signal is heard


class Variations:
    """A state in principal axes and tangents to it, marched together.

    ``coefficients``: of :mod:`polhode.equations.forms.principal`; ``start``: six doubles;
    ``tangents``: shape (6, n).  ``exponent``: the tangents are 2**exponent times what is kept.
    """

    def __init__(
        self, coefficients: Mapping[str, Number], start: Doubles, tangents: Doubles
    ) -> None:
        equations = Equations(STATE, NAMES, tangents=tangents.shape[1])
        self._ready = principal_engine(equations, Engine)
        numbers = np.array([to_double(coefficients.get(name, 0)) for name in NAMES])
        self.exponent = self.steps = 0
        self._ready.stand(np.concatenate([start, tangents.T.ravel()]), numbers)

    def release(self) -> None:
        """Leave the compiled code to the next motion; the last call of all."""
        self._ready.release()

    @property
    def time(self) -> float:
        """The time reached."""
        return float(self._ready.heyoka.time)

    @property
    def state(self) -> Doubles:
        """The six components of the state."""
        found: Doubles = self._ready.state[:6]
        return found

    @state.setter
    def state(self, values: Doubles) -> None:
        self._ready.state[:6] = values

    @property
    def finite(self) -> bool:
        """Whether state and tangents are."""
        return bool(np.all(np.isfinite(self._ready.state)))

    @property
    def tangents(self) -> Doubles:
        """The tangents as kept, shape (6, n)."""
        return self._tangents.T

    @property
    def _tangents(self) -> Doubles:
        found: Doubles = self._ready.state[6:].reshape(-1, 6)
        return found

    def to(self, time: float, steps: int) -> bool:
        """March to a time in at most so many steps; whether it was reached with finite numbers."""
        ended, taken = self._ready.until(time, steps, _BLOCK)
        self.steps += taken
        return ended is Outcome.REACHED_END

    def rescale(self) -> None:
        """Bring the largest tangent to about 1: tangents that lead would take digits of the step.

        By a power of two, so that nothing is rounded.
        """
        largest = float(np.max(np.abs(self._tangents), initial=0.0))
        if largest == 0:
            return
        by = math.frexp(largest)[1]
        self._tangents[:] = np.ldexp(self._tangents, -by)
        self.exponent += by
