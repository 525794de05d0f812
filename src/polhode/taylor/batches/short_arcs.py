"""Short ways from many known states of one motion at once, one in each SIMD lane."""

from __future__ import annotations

import numpy as np

from polhode.numbers.rows import Doubles
from polhode.taylor.batches import batch_integrator
from polhode.taylor.integrator.specification import Blueprint

_LOOKED_AT = 32  # steps from the start on


class Hops:
    """The compiled equations of a body in its principal axes, in doubles.

    ``plan``: what an integrator of a run would be built from.
    """

    def __init__(self, plan: Blueprint) -> None:
        key = tuple(plan.coefficients), len(plan.names)
        self._batch = batch_integrator.lanes(*key)
        self._kept = batch_integrator.kept_rates(*key)
        self._spins = self._batch.parameters[len(plan.constants) :]
        self._batch.parameters[: len(plan.constants)] = np.array(plan.constants)[:, None]

    def release(self) -> None:
        """Leave the compiled code to the next run of such equations; the last call of all."""
        self._batch.release()
        del self._batch, self._spins

    def pace(self, start: Doubles) -> float:
        """The length of a step, on average over the first ones."""
        self._stand(start[:, None])
        for _ in range(_LOOKED_AT):
            self._batch.heyoka.step()
        return float(self._batch.heyoka.time[0]) / _LOOKED_AT

    def beginning(self, start: Doubles, times: Doubles) -> Doubles:
        """States (n, columns) at times from a start on, the first time 0."""
        self._stand(start[:, None])
        grid = np.repeat(times[:, None], self._batch.places, 1)
        return np.concatenate([start[None], self._batch.rows(grid)[:, :, 0]])

    def _stand(self, states: Doubles) -> None:
        self._batch.stand(states)
        self._spins[:] = states[self._kept]

    def along(self, states: Doubles, times: Doubles) -> Doubles:
        """States (n, columns) after so much time each; not finite where the motion is not."""
        batch, (count, width), size = self._batch, states.shape, self._batch.places
        spare = -count % size
        rows = np.vstack([states, np.repeat(states[-1:], spare, axis=0)])
        blocks = rows.reshape(-1, size, width).transpose(0, 2, 1).copy()
        targets = np.append(times, np.zeros(spare)).reshape(-1, size).tolist()
        stand, spins, kept = batch.stand, self._spins, self._kept
        for block, ends in zip(blocks, targets, strict=True):
            stand(block)
            if kept:
                spins[:] = block[kept]
            block[:] = batch.to(ends)
        found: Doubles = blocks.transpose(0, 2, 1).reshape(-1, width)[:count]
        return found
