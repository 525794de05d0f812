"""Short ways from many known states of one motion at once, one in each SIMD lane."""

from __future__ import annotations

import numpy as np

from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.taylor.backend.integrator_pool import Idle
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches import batch_integrator
from polhode.taylor.integrator.specification import Blueprint

_IDLE: Idle[HeyokaIntegrator] = Idle(4)
_LOOKED_AT = 32  # steps from the start on


class Hops:
    """The compiled equations of a body in its principal axes, in doubles.

    ``plan``: what an integrator of a run would be built from.
    """

    def __init__(self, plan: Blueprint) -> None:
        self.places = batch_integrator.width(DOUBLE)
        self._key = (tuple(plan.coefficients), len(plan.names))
        self._heyoka = _IDLE.take(self._key) or batch_integrator.built(*self._key, DOUBLE, None)
        self._kept = batch_integrator.kept_rates(*self._key)
        self._spins = len(plan.constants)  # the row of the first parameter after the coefficients
        if plan.constants:
            self._heyoka.pars[: self._spins] = np.array(plan.constants)[:, None]

    def release(self) -> None:
        """Leave the compiled code to the next run of such equations; the last call of all."""
        _IDLE.put(self._key, self._heyoka)
        del self._heyoka

    def pace(self, start: Doubles) -> float:
        """The length of a step, on average over the first ones."""
        ta = self._heyoka
        self._start(start[:, None])
        for _ in range(_LOOKED_AT):
            ta.step()
        return float(ta.time[0]) / _LOOKED_AT

    def beginning(self, start: Doubles, times: Doubles) -> Doubles:
        """States (n, columns) at times from a start on, the first time 0."""
        ta = self._heyoka
        self._start(start[:, None])
        found: Doubles = ta.propagate_grid(np.repeat(times[:, None], self.places, 1))[1][:, :, 0]
        return found

    def _start(self, state: Doubles) -> None:
        self._heyoka.set_time(0.0)
        self._heyoka.state[:] = state
        self._heyoka.pars[self._spins :] = state[self._kept]

    def along(self, states: Doubles, times: Doubles) -> Doubles:
        """States (n, columns) after so much time each; not finite where the motion is not."""
        ta, (count, width), size = self._heyoka, states.shape, self.places
        spare = -count % size
        rows = np.vstack([states, np.repeat(states[-1:], spare, axis=0)])
        blocks = rows.reshape(-1, size, width).transpose(0, 2, 1).copy()
        targets = np.append(times, np.zeros(spare)).reshape(-1, size).tolist()
        state, spins, kept = ta.state, ta.pars[self._spins :], self._kept
        start, onwards = ta.set_time, ta.propagate_until
        for block, ends in zip(blocks, targets, strict=True):
            start(0.0)
            state[:] = block
            if kept:
                spins[:] = block[kept]
            onwards(ends)
            block[:] = state
        found: Doubles = blocks.transpose(0, 2, 1).reshape(-1, width)[:count]
        return found
