"""Short ways from many known states of one motion at once, one in each SIMD lane."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from polhode.numbers.exact import Number
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.scalars import Doubles
from polhode.taylor import batches
from polhode.taylor.heyoka_numbers import scalars
from polhode.taylor.pool import Idle

_IDLE = Idle(4)
_MOST_STEPS = 1000
_LOOKED_AT = 32  # steps from the start on


class Hops:
    """The compiled equations of a body in its principal axes, in doubles.

    ``columns``: of a state, which is in the run's unit of time.
    """

    def __init__(self, coefficients: Mapping[str, Number], columns: int) -> None:
        self.places = batches.width(DOUBLE)
        self._key = (tuple(coefficients), columns)
        self._heyoka = _IDLE.take(self._key) or batches.built(*self._key, DOUBLE, None)
        if coefficients:
            constants = scalars([*coefficients.values()], DOUBLE)
            self._heyoka.pars[:] = np.array(constants)[:, None]

    def release(self) -> None:
        """Leave the compiled code to the next run of such equations; the last call of all."""
        _IDLE.put(self._key, self._heyoka)
        del self._heyoka

    def pace(self, start: Doubles) -> float:
        """The length of a step, on average over the first ones."""
        ta = self._heyoka
        ta.set_time(0.0)
        ta.state[:] = start[:, None]
        for _ in range(_LOOKED_AT):
            ta.step()
        return float(ta.time[0]) / _LOOKED_AT

    def along(self, states: Doubles, times: Doubles) -> Doubles:
        """States (n, columns) after so much time each; nan where a lane did not come so far."""
        ta, count, size = self._heyoka, len(times), self.places
        spare = -count % size
        columns = np.vstack([states, np.repeat(states[-1:], spare, axis=0)]).T.copy()
        ends = np.append(times, np.zeros(spare))
        reached = np.empty_like(ends)
        state, targets = ta.state, ends.tolist()
        for first in range(0, count, size):
            here = slice(first, first + size)
            ta.set_time(0.0)
            state[:] = columns[:, here]
            ta.propagate_until(targets[here], max_steps=_MOST_STEPS)
            columns[:, here] = state
            reached[here] = ta.time
        columns[:, reached != ends] = np.nan
        found: Doubles = columns[:, :count].T.copy()
        return found
