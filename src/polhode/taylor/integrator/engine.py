"""heyoka's integrator with views of its memory: it stands wherever it is put, one user at a time.

Building one takes milliseconds even when its code is found on the disk, and so does freeing it: as
long as a short run itself.  So whoever needs one takes one that is idle, and leaves it to the next
user.  That may be of another body: whoever takes one tells it all coefficients, and the state.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from contextlib import nullcontext
from typing import Any, Self, TypeVar

from polhode.common.interrupts import Lock, Place
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.numbers.rows import Array, Numbers
from polhode.taylor.backend.heyoka_numbers import array, scalar
from polhode.taylor.backend.integrator_pool import POOL
from polhode.taylor.backend.protocols import Desk
from polhode.taylor.backend.step_outcomes import ending
from polhode.taylor.backend.types import HeyokaIntegrator, HeyokaNumber, HeyokaOutput

_COMPILING = Lock(Place.COMPILING)


class Engine:
    """heyoka's integrator, and what its parameters are.

    ``heyoka``: the integrator itself, ``state`` and ``parameters``: views of its memory.  From the
    parameter ``first`` on stand the ``coefficients``; behind them are ``kept``, the columns that
    the equations keep, as far as any rate asks for them.  ``desk``: of its events, where it looks
    for any.  ``singular``: whether it ends near a form's singular set.  In a ``with`` block it is
    left to the next user at the end, unless an exception ends the block.
    """

    def __init__(
        self,
        heyoka: HeyokaIntegrator,
        number: NumberType = DOUBLE,
        first: int = 0,
        coefficients: int = 0,
        kept: tuple[int, ...] = (),
        desk: Desk | None = None,
    ) -> None:
        self.heyoka, self.number, self.desk = heyoka, number, desk
        self.state, self.parameters = heyoka.state, heyoka.pars
        used = max(0, len(self.parameters) - first)  # no rate asks for those after
        self.first, self.after = first, first + min(used, coefficients)
        self.kept = tuple(enumerate(kept[: first + used - self.after], self.after))
        self.singular = bool(heyoka.t_events) if heyoka.with_events else False
        self.key: Hashable = None  # where the pool has it, if anywhere
        self._zero = scalar(0, number)

    def begin(self) -> None:
        """Be at time 0 in the state that was written to :attr:`state`."""
        self.heyoka.time = self._zero
        if self.singular:
            self.heyoka.reset_cooldowns()  # traces of a run that ended there
        if self.kept:
            self.tell_kept()

    def tell(self, coefficients: Numbers) -> None:
        """Give the rates their coefficients."""
        if self.after > self.first:
            self.parameters[self.first : self.after] = coefficients[: self.after - self.first]

    def tell_kept(self) -> None:
        """Give the rates the variables that the equations keep, from where they stand."""
        for parameter, column in self.kept:
            self.parameters[parameter] = self.state[column]

    def stand(self, state: Numbers, coefficients: Numbers | None = None) -> None:
        """Be at time 0 in a state, with these coefficients or those from before."""
        self.state[:] = state
        if coefficients is not None:
            self.tell(coefficients)
        self.begin()

    def until(self, end: HeyokaNumber, most: int, block: int) -> tuple[Outcome, int]:
        """Go on to a time in at most so many steps: how it ended, and the steps taken.

        Between two blocks of so many steps a signal is heard.
        """
        ended, taken, left = Outcome.STEP_LIMIT, 0, most
        while ended is Outcome.STEP_LIMIT and left > 0:  # to heyoka 0 is no limit
            result = self.heyoka.propagate_until(end, max_steps=min(block, left))
            ended, steps = self.ended(result)
            taken, left = taken + steps, left - block
        return ended, taken

    def ended(self, result: Any) -> tuple[Outcome, int]:
        """How heyoka's call ended, and the steps that it took."""
        return ending(result[0]), int(result[3])

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
        """Leave it to the next user of such equations; the last call of all."""
        if self.desk is not None:
            self.desk.watch = None  # which knows a run, its scene and its times
        if self.key is not None:
            POOL.put(self.key, self)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, fault: type[BaseException] | None, *_: object) -> None:
        if fault is None:
            self.release()


E = TypeVar("E", bound=Engine)


def lent(key: Hashable, build: Callable[[], E], wait: bool = True) -> E:
    """An engine of what a key tells from others, built where none is idle.

    One thread at a time builds, since the code that heyoka has compiled serves the others; not so
    without ``wait``, for those that may hold a precision.
    """
    found: E | None = POOL.take(key)
    if found is None:
        with _COMPILING.held() if wait else nullcontext():
            found = POOL.take(key) or build()
        found.key = key
    return found
