"""The order at which an integrator converges, seen from its errors at several steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from polhode.common.arguments import each
from polhode.common.errors import BadInput
from polhode.common.result import Result
from polhode.judging.references.reference import reference
from polhode.judging.score.compare import compare
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
        between = f"{self.least:.2f} to {self.most:.2f} between neighbours"
        return f"<ObservedOrder {self.order:.2f}, {between} of {sum(self.counted)} steps>"

    def __str__(self) -> str:
        lines = []
        for h, d, counts in zip(self.steps, self.digits, self.counted, strict=True):
            lines.append(f"step {h:<10.4g} {d:6.2f} digits{'' if counts else ', not counted'}")
        told = f"order {self.order:.2f}; {self.least:.2f} to {self.most:.2f} between neighbours"
        return "\n".join([*lines, told])


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
    points = [
        (math.log(h), -math.log(10.0) * d)
        for h, d, c in zip(lengths, digits, counted, strict=True)
        if c
    ]
    if len(points) < _FEWEST:
        told = ", ".join(f"{h:.3g}: {d:.1f}" for h, d in zip(lengths, digits, strict=True))
        low = min(most)
        expected = f"{_FEWEST} or more that give {_LEAST:g} to {low:.1f} digits (there were {told})"
        raise BadInput("order_of", "steps", len(points), expected)
    x, y = (sum(column) / len(points) for column in zip(*points, strict=True))
    square = sum((a - x) ** 2 for a, _ in points)
    order = sum((a - x) * (b - y) for a, b in points) / square
    slopes = [(d - b) / (c - a) for (a, b), (c, d) in pairwise(points)]
    return ObservedOrder(order, min(slopes), max(slopes), lengths, tuple(digits), counted)
