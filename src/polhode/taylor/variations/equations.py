"""Variational equations of the Euler–Poisson equations (3.29), by heyoka, in double.

Beside the state x, tangents v obey v' = J(x) v, or v' = J(x) v + s·f where f is the field's change
when an input of the body changes; J by symbolic differentiation.  The equations are compiled once
for any body: their numbers are parameters.  Tangents are linear, so they may be scaled at any time:
s carries the scale of those that are driven.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from functools import cache

import heyoka as hy
import numpy as np

from polhode.equations.forms import principal
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Number
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS
from polhode.taylor.backend.types import HeyokaIntegrator

_BLOCK = 50_000  # steps, a fifth of a second, between which a signal is heard


class Variations:
    """A state in principal axes and tangents to it, marched together.

    ``coefficients``: of :mod:`polhode.equations.forms.principal`; ``start``: six doubles;
    ``tangents``: shape (6, n), of which the last ``len(drives)`` are driven by these
    changes of the coefficients.  ``exponent``: the tangents are 2**exponent times what is kept.
    """

    def __init__(
        self,
        coefficients: Mapping[str, Number],
        start: Doubles,
        tangents: Doubles,
        drives: Sequence[Mapping[str, Number]] = (),
    ) -> None:
        count = tangents.shape[1]
        self.heyoka = copy.deepcopy(_compiled(count, len(drives)))
        self._pars = np.array(
            [
                to_double(by.get(name, 0))
                for by in (coefficients, *drives)
                for name in principal.NAMES
            ]
        )
        self.heyoka.pars[:] = self._pars
        self.heyoka.time = 0.0
        self.exponent = self.steps = 0
        self.state = start
        self._tangents[:] = tangents.T

    def restart(self, tangents: Doubles) -> None:
        """Begin with other tangents where the state stands."""
        self._tangents[:] = tangents.T

    @property
    def time(self) -> float:
        """The time reached."""
        return float(self.heyoka.time)

    @property
    def state(self) -> Doubles:
        """The six components of the state."""
        found: Doubles = self.heyoka.state[:6]
        return found

    @state.setter
    def state(self, values: Doubles) -> None:
        self.heyoka.state[:6] = values

    @property
    def finite(self) -> bool:
        """Whether state and tangents are."""
        return bool(np.all(np.isfinite(self.heyoka.state)))

    @property
    def tangents(self) -> Doubles:
        """The tangents as kept, shape (6, n)."""
        return self._tangents.T

    @property
    def _tangents(self) -> Doubles:
        found: Doubles = self.heyoka.state[6:].reshape(-1, 6)
        return found

    def to(self, time: float, steps: int) -> bool:
        """March to a time in at most so many steps; whether it was reached with finite numbers."""
        while steps > 0:  # to heyoka 0 is no limit
            most = min(steps, _BLOCK)
            outcome, _, _, taken, *_ = self.heyoka.propagate_until(time, max_steps=most)
            self.steps, steps = self.steps + int(taken), steps - most
            if outcome != hy.taylor_outcome.step_limit:
                return bool(outcome == hy.taylor_outcome.time_limit)
        return False

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
        driven = len(principal.NAMES)
        self.heyoka.pars[driven:] = np.ldexp(self._pars[driven:], -self.exponent)


@cache
def _compiled(count: int, driven: int) -> HeyokaIntegrator:
    """An integrator of the state and ``count`` tangents, the last ``driven`` of them driven."""
    size = len(principal.NAMES)
    numbers = [
        {name: hy.par[k * size + j] for j, name in enumerate(principal.NAMES)}
        for k in range(1 + driven)
    ]
    x = hy.make_vars(*STATE)
    field = principal.field(x, numbers[0], EXPRESSIONS)
    jacobian = [[hy.diff(rate, variable) for variable in x] for rate in field]
    system = list(zip(x, field, strict=True))
    for k in range(count):
        v = hy.make_vars(*(f"{name}_{k}" for name in STATE))
        rates = [
            hy.sum([a * b for a, b in zip(row, v, strict=True) if a != EXPRESSIONS.zero])
            for row in jacobian
        ]
        if k >= count - driven:
            drive = principal.field(x, numbers[1 + k - (count - driven)], EXPRESSIONS)
            rates = [a + b for a, b in zip(rates[:3], drive[:3], strict=True)] + rates[3:]
        system += list(zip(v, rates, strict=True))
    return hy.taylor_adaptive(
        system, np.zeros(len(system)), compact_mode=True, pars=[0.0] * (size * (1 + driven))
    )
