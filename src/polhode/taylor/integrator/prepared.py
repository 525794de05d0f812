"""heyoka's integrator of equations whose numbers are parameters: one code for every body.

It is taken from the pool and left to the next user.  Where it stands, and with which numbers, each
user says anew.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Self

from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.numbers.rows import Array, Numbers
from polhode.taylor.backend.heyoka_numbers import array, scalar
from polhode.taylor.backend.integrator_pool import POOL, Kind
from polhode.taylor.backend.step_outcomes import ending
from polhode.taylor.backend.types import HeyokaIntegrator, HeyokaNumber, HeyokaOutput


class Prepared:
    """An integrator of what ``key`` tells from others of its kind, built where none is idle.

    ``heyoka``: the integrator itself, ``state`` and ``parameters``: views of its memory.  In a
    ``with`` block it is left to the next user at the end, unless an exception ends the block.
    """

    def __init__(
        self,
        kind: Kind[HeyokaIntegrator],
        key: Hashable,
        build: Callable[[], HeyokaIntegrator],
        number: NumberType = DOUBLE,
    ) -> None:
        self._kind, self._key = kind, key
        self.number, self._zero = number, scalar(0, number)
        self.heyoka = POOL.taken_or_built(kind, key, build)
        self.state, self.parameters = self.heyoka.state, self.heyoka.pars

    def begin(self) -> None:
        """Be at time 0 where the state stands."""
        self.heyoka.time = self._zero

    def stand(self, state: Numbers, parameters: Numbers | None = None) -> None:
        """Be at time 0 in a state, with these parameters or those from before."""
        self.begin()
        self.state[:] = state
        if parameters is not None:
            self.parameters[:] = parameters

    def until(self, end: HeyokaNumber, most: int, block: int) -> tuple[Outcome, int]:
        """Go on to a time in at most so many steps: how it ended, and the steps taken.

        Between two blocks of so many steps a signal is heard.
        """
        ended, taken, left = Outcome.STEP_LIMIT, 0, most
        while ended is Outcome.STEP_LIMIT and left > 0:  # to heyoka 0 is no limit
            result = self.heyoka.propagate_until(end, max_steps=min(block, left))
            ended, taken, left = ending(result[0]), taken + int(result[3]), left - block
        return ended, taken

    @property
    def now(self) -> HeyokaNumber:
        """The time reached."""
        return self.heyoka.time

    @property
    def row(self) -> Array:
        """The state where it stands, a view."""
        found: Array = self.state
        return found

    def grid(self, times: list[HeyokaNumber], most: int) -> tuple[Array, int, Outcome]:
        """Go on through times, the first of them now: states at the others met, steps, ending."""
        result = self.heyoka.propagate_grid(array(times, self.number), max_steps=most)
        rows: Array = result[-1][1:]
        return rows, int(result[3]), ending(result[0])

    def polynomials(self, end: HeyokaNumber, most: int) -> tuple[Outcome, HeyokaOutput]:
        """Go on to a time in at most so many steps: how it ended, and the continuous output."""
        result = self.heyoka.propagate_until(end, max_steps=most, c_output=True)
        return ending(result[0]), result[4]

    def release(self) -> None:
        """Leave the compiled code to the next user of such equations; the last call of all."""
        POOL.put(self._kind, self._key, self.heyoka)
        del self.heyoka, self.state, self.parameters

    def __enter__(self) -> Self:
        return self

    def __exit__(self, fault: type[BaseException] | None, *_: object) -> None:
        if fault is None:
            self.release()
