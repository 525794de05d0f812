"""heyoka's integrator of a system, prepared: it stands wherever it is put, one run at a time.

Building one takes milliseconds even when its code is found on the disk, and so does freeing it: as
long as a short run itself.  So a run takes one that is idle, and leaves it to the next one.  That
may be of another body: whoever takes one tells it all coefficients, and the state.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import TypeVar

from polhode.numbers.rows import Doubles, Extendeds, Numbers
from polhode.taylor.backend.heyoka_numbers import array, scalar, scalars
from polhode.taylor.backend.integrator_pool import POOL, Kind
from polhode.taylor.integrator.angle_variables import Cyclic
from polhode.taylor.integrator.protocols import Desk, Watcher
from polhode.taylor.integrator.specification import CLOCK, Blueprint, Built, built

#: Times, and states at them.
K = TypeVar("K", Doubles, Extendeds)

RUNS: Kind[Built] = Kind(16)


class Compiled:
    """A prepared integrator of one blueprint, with its coefficients, at its start at time 0.

    ``heyoka``: the integrator itself, ``state``: a view of its memory.  ``desk``: of its events,
    where it looks for any.  ``again``: whether another run may take it up, see
    :class:`polhode.taylor.integrator.specification.Built`.
    """

    def __init__(
        self, plan: Blueprint, watcher: Watcher | None = None, cyclic: Cyclic | None = None
    ) -> None:
        start, coefficients = plan.state, plan.parameters  # refused before anything is compiled
        self._key: Hashable = plan.key
        if watcher is not None and self._key is not None:
            self._key = (self._key, watcher.key)
        idle = POOL.take(RUNS, self._key)
        self._built = idle or built(plan, watcher, cyclic)
        self.heyoka = self._built.heyoka
        self.desk: Desk | None = self._built.desk
        self.again = self._built.again
        self.state, self._parameters = self.heyoka.state, self.heyoka.pars
        first = self._built.first
        after = first + self._built.coefficients
        self.kept = tuple(enumerate(self._built.kept, after))
        if after > first:
            self._parameters[first:after] = coefficients[: self._built.coefficients]
        if watcher is not None:
            damping = array(scalars(watcher.damping, plan.number), plan.number)
            self._parameters[CLOCK:first] = damping[: len(self._parameters[CLOCK:first])]
        self._zero = scalar(0, plan.number)
        if idle is not None:
            self.state[:] = start
        self.begin()

    @property
    def pooled(self) -> bool:
        """Whether :meth:`release` leaves it to another run."""
        return self.again and self._key is not None

    def begin(self) -> None:
        """Be at time 0 in the state that was written to :attr:`state`."""
        self.heyoka.time = self._zero
        if self.kept:
            self.tell_kept()

    def stand(self, state: Numbers) -> None:
        """Be at time 0 in a state."""
        self.state[:] = state
        self.begin()

    def grid(self, times: K) -> K:
        """The states at times, the first of them the one at which it stands."""
        found: K = self.heyoka.propagate_grid(times)[-1]
        return found

    def tell_kept(self) -> None:
        """Give the rates the variables that the equations keep, from where they stand."""
        for parameter, column in self.kept:
            self._parameters[parameter] = self.state[column]

    def release(self) -> None:
        """Leave the compiled code to the next run of the same equations; the last call of all."""
        if self.desk is not None:
            self.desk.watch = None  # which knows a run, its scene and its times
        if self._built.again:
            POOL.put(RUNS, self._key, self._built)
        del self._built, self.heyoka, self.state, self._parameters
