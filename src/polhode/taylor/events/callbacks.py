"""What heyoka calls in a run with events: where one is met, and after each step, to go on?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from polhode.numbers.expression import Algebra, evaluate
from polhode.numbers.number_types import NumberType
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.types import HeyokaIntegrator, HeyokaNumber
from polhode.taylor.integrator.protocols import Desk

_PATIENCE = 8  # steps in a row that do not change the time; the last one before an end may be such


class AfterStep:
    """Go on?  Not after an event that stops the run, and not where steps stand still at a pole.

    Where an expression runs to infinity, so do its Taylor coefficients, and heyoka's steps shrink
    to zero.  Steps of zero count towards no limit: they would go on for ever.
    """

    def __init__(
        self, stopped: Callable[[HeyokaIntegrator], bool], number: NumberType
    ) -> None:
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
    """heyoka's call where an event is met; heyoka copies its callbacks, this one stays one."""

    def __init__(self, desk: Desk, k: int, order: int) -> None:
        self.desk, self.k, self.order = desk, k, order

    def __call__(self, ta: HeyokaIntegrator, t: HeyokaNumber, _: int) -> None:
        """Tell whoever watches."""
        if self.desk.watch is not None:
            self.desk.watch.met(self.k, self.order, ta, t)

    def __deepcopy__(self, _: object) -> Callback:
        return self


def is_entire(scene: Scene, event: Event) -> bool:
    """Whether an event's expression has a value wherever the motion goes, and so no pole.

    True without division by what varies, negative powers of it, and roots.
    """
    return _sort(event, (*scene.columns, "t"), ()).entire


def _sort(event: Event, varying: Sequence[str], constant: Sequence[str]) -> _Sort:
    """What is known of an event's expression where some of its names vary."""
    names = dict.fromkeys(constant, _Sort(False, True)) | dict.fromkeys(varying, _Sort(True, True))
    functions = {"sin": _same, "cos": _same, "sqrt": _root}
    algebra = Algebra(lambda _: _Sort(False, True), functions)
    found = evaluate(event.expression, names, algebra) if event.expression is not None else None
    return found if isinstance(found, _Sort) else _Sort(False, True)


@dataclass(frozen=True)
class _Sort:
    """What is known of an expression: whether it varies, and whether it always has a value."""

    varies: bool
    entire: bool

    def both(self, other: _Sort) -> _Sort:
        """What is known of a sum or a product."""
        return _Sort(self.varies or other.varies, self.entire and other.entire)

    __add__ = __sub__ = __mul__ = both

    def __neg__(self) -> _Sort:
        return self

    def __truediv__(self, other: _Sort) -> _Sort:
        return replace(self.both(other), entire=self.entire and not other.varies)

    def __pow__(self, n: int) -> _Sort:
        return self if n >= 0 else _root(self)


def _same(x: _Sort) -> _Sort:
    return x


def _root(x: _Sort) -> _Sort:
    return _Sort(x.varies, x.entire and not x.varies)
