"""The order at which an integrator converges, seen from its errors at several steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from statistics import median

from polhode.common.arguments import each
from polhode.common.errors import BadInput
from polhode.common.result import Result
from polhode.judging.references.reference import reference
from polhode.judging.score.compare import compare
from polhode.judging.score.judgement import Judgement
from polhode.numbers.conversion import exact_number, to_double
from polhode.numbers.exact import sign
from polhode.numbers.scalars import AnyNumber, AnyVector
from polhode.scenes.scene import Scene

_HALVINGS = range(5, 12)  # of the time, for the steps that are tried
_LEAST = 1.5  # digits below which no power of the step rules the error
_SPARE = 2.5  # digits above which rounding does
_FEWEST = 3  # steps


@dataclass(frozen=True, repr=False)
class ObservedOrder(Result):
    """An order p, error ~ step**p, as the least squares through log errors have it.

    ``least``, ``most``: between any two neighbours of the steps that count.  ``steps``: all that
    were tried, the longest first; ``digits``: correct ones at each; ``counted``: which steps count:
    those at which neither the first digit is wrong nor rounding rules.
    """

    order: float
    least: float
    most: float
    steps: tuple[float, ...]
    digits: tuple[float, ...]
    counted: tuple[bool, ...]

    def __repr__(self) -> str:
        between = f"{self.least:.2f} to {self.most:.2f} between successive steps"
        return f"<ObservedOrder {self.order:.2f}, {between}, {sum(self.counted)} of them counted>"

    def __str__(self) -> str:
        lines = []
        for h, d, counts in zip(self.steps, self.digits, self.counted, strict=True):
            lines.append(f"step {h:<10.4g} {d:6.2f} digits{'' if counts else ', not counted'}")
        order = f"order {self.order:.2f}; "
        order += f"{self.least:.2f} to {self.most:.2f} between successive steps"
        return "\n".join([*lines, order])


def observed_order(
    mine: Callable[[float], Iterable[AnyVector]],
    scene: Scene,
    steps: Sequence[AnyNumber] | None,
    at: Iterable[AnyNumber] | None,
    columns: Sequence[str] | None,
) -> ObservedOrder:
    """See :func:`polhode.testing.order_of`."""
    times = [scene.end] if at is None else [*each("order_of", "at", at, exact_number, "times")]
    if not times or sign(max(times, key=abs)) == 0:
        raise BadInput("order_of", "at", None, "a time other than 0")
    if steps is None:
        end = abs(max(times, key=abs))
        steps = [to_double(end * Fraction(1, 2**k)) for k in _HALVINGS]
    lengths = each("order_of", "steps", steps, lambda h: to_double(exact_number(h)), "numbers")
    if len({*lengths}) < _FEWEST or not all(0 < h < math.inf for h in lengths):
        raise BadInput("order_of", "steps", len(lengths), f"{_FEWEST} or more, different, above 0")
    lengths = tuple(sorted(lengths, reverse=True))
    against, digits, most = reference(scene), [], []
    for h in lengths:
        rows = mine(h)
        found = compare(rows, against, at=times, columns=columns, as_it_stands=True)
        digits.append(found.worst)
        most.append(found.subject.held - _SPARE)
    counted = tuple(_LEAST < d < m for d, m in zip(digits, most, strict=True))
    points = [(h, d) for h, d, c in zip(lengths, digits, counted, strict=True) if c]
    if len(points) < _FEWEST:
        told = ", ".join(f"{h:.3g}: {d:.1f}" for h, d in zip(lengths, digits, strict=True))
        low = min(most)
        expected = f"{_FEWEST} or more that give {_LEAST:g} to {low:.1f} digits (there were {told})"
        raise BadInput("order_of", "steps", len(points), expected)
    order = _slope(*zip(*points, strict=True))
    slopes = [_slope(*zip(*pair, strict=True)) for pair in pairwise(points)]
    return ObservedOrder(order, min(slopes), max(slopes), lengths, tuple(digits), counted)


@dataclass(frozen=True, repr=False)
class OrderBetweenTables(Result):
    """The order that tables made with different steps show at the times that all of them have.

    ``order``: the median of ``orders``, one a time, ``least`` and ``most`` among them; None at a
    time where the first digit is wrong or rounding rules.  ``steps``: of the tables; ``digits``: a
    row a table, correct ones at each of ``times``.
    """

    names: tuple[str, ...]
    steps: tuple[float, ...]
    times: tuple[Fraction, ...]
    digits: tuple[tuple[float, ...], ...]
    orders: tuple[float | None, ...]

    @property
    def known(self) -> list[float]:
        """The orders at the times that count."""
        return [x for x in self.orders if x is not None]

    @property
    def order(self) -> float:
        """The median."""
        return median(self.known)

    @property
    def least(self) -> float:
        """The smallest."""
        return min(self.known)

    @property
    def most(self) -> float:
        """The largest."""
        return max(self.known)

    def __repr__(self) -> str:
        return f"<OrderBetweenTables {self.order:.2f}, {self._range}>"

    @property
    def _range(self) -> str:
        return (
            f"{self.least:.2f} to {self.most:.2f} at {len(self.known)} of {len(self.times)} times"
        )

    def __str__(self) -> str:
        steps = ", ".join(
            f"{h:.6g} of {name}" for h, name in zip(self.steps, self.names, strict=True)
        )
        return f"order {self.order:.2f}; {self._range}; steps {steps}"


def order_between(
    judged: Sequence[Judgement], steps: Sequence[AnyNumber] | None = None
) -> OrderBetweenTables:
    """The order of one method whose tables, made with different steps, were judged.

    ``steps``: of the tables, the distances of their rows unless given.
    """
    names = tuple(one.subject.name for one in judged)
    if steps is None:
        lengths = tuple(_spacing(one) for one in judged)
        expected = f"step sizes: the rows of all files are {lengths[0]:g} apart"
    else:
        lengths = each("orders", "steps", steps, lambda h: to_double(exact_number(h)), "numbers")
        expected = f"{len(judged)} different ones above 0, one a file"
    right = all(0 < h < math.inf for h in lengths)
    if not right or len(lengths) != len(judged) or len({*lengths}) < max(2, len(judged)):
        raise BadInput(", ".join(names), "steps", None, expected)
    digits = [
        {_label(t): d for t, d in zip(one.times, _fewest(one), strict=True) if d is not None}
        for one in judged
    ]
    times = [t for t in judged[0].times if t and all(_label(t) in held for held in digits)]
    rows = tuple(tuple(held[_label(t)] for t in times) for held in digits)
    most = min(one.subject.held for one in judged) - _SPARE
    orders = tuple(
        _slope(lengths, here) if all(_LEAST < d < most for d in here) else None
        for here in zip(*rows, strict=True)
    )
    if not any(x is not None for x in orders):
        told = ", ".join(f"{min(row):.1f} to {max(row):.1f}" for row in rows if row)
        expected = f"common ones at which all files have {_LEAST:g} to {most:.1f} digits"
        raise BadInput(", ".join(names), "t", told or None, expected)
    return OrderBetweenTables(names, lengths, tuple(times), rows, orders)


def _spacing(judged: Judgement) -> float:
    """The distance of a table's rows, the median."""
    times = sorted(judged.times)
    return float(median(b - a for a, b in pairwise(times))) if len(times) > 1 else 0.0


def _label(t: Fraction) -> str:
    """What times of several files have in common that differ in the last digits of doubles."""
    return f"{float(t):.12g}"


def _fewest(judged: Judgement) -> list[float | None]:
    """At each time the digits of the state; of what is judged, where there is no state."""
    if judged.digits:
        return [*judged.digits]
    parts = [row for row in judged.part_digits.values() if row]
    return [
        min((d for d in here if d is not None), default=None) for here in zip(*parts, strict=True)
    ]


def _slope(steps: Sequence[float], digits: Sequence[float]) -> float:
    """Of the least squares through log errors over log steps."""
    points = [(math.log10(h), -d) for h, d in zip(steps, digits, strict=True)]
    x, y = (sum(column) / len(points) for column in zip(*points, strict=True))
    square = sum((a - x) ** 2 for a, _ in points)
    return float(sum((a - x) * (b - y) for a, b in points) / square)
