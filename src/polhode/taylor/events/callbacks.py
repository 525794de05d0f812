"""What heyoka calls in a run with events: where one is met, and after each step, to go on?"""

from __future__ import annotations

from collections.abc import Callable

from polhode.numbers.number_types import NumberType
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.protocols import Desk
from polhode.taylor.backend.types import HeyokaIntegrator, HeyokaNumber

_PATIENCE = 8  # steps in a row that do not change the time; the last one before an end may be such


class AfterStep:
    """Go on?  Not after an event that stops the run, and not where steps stand still at a pole.

    Where an expression runs to infinity, so do its Taylor coefficients, and heyoka's steps shrink
    to zero.  Steps of zero count towards no limit: they would go on for ever.
    """

    def __init__(self, stopped: Callable[[HeyokaIntegrator], bool], number: NumberType) -> None:
        self.stopped, self.idle = stopped, 0
        self.eps = heyoka_numbers.scalar(number.eps, number)

    def __call__(self, ta: HeyokaIntegrator) -> bool:
        """Whether to go on."""
        moved = abs(ta.last_h) > abs(ta.time) * self.eps
        self.idle = 0 if moved else self.idle + 1
        return not self.stopped(ta) and self.idle < _PATIENCE

    def __deepcopy__(self, _: object) -> AfterStep:
        return self


class Callback:
    """heyoka's call where an event is met; heyoka copies its callbacks, this one stays one.

    ``k``: which expression; in a batch the lane is told instead.
    """

    def __init__(self, desk: Desk, k: int, order: int) -> None:
        self.desk, self.k, self.order = desk, k, order

    def __call__(
        self, ta: HeyokaIntegrator, t: HeyokaNumber, _: int, lane: int | None = None
    ) -> None:
        """Tell whoever watches."""
        if self.desk.watch is not None:
            self.desk.watch.met(self.k if lane is None else lane, self.order, ta, t)

    def __deepcopy__(self, _: object) -> Callback:
        return self
