"""The order at which an integrator converges, seen from its errors at several steps and times."""

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
_FEWEST = 3  # steps; of fewer tables all


@dataclass(frozen=True, repr=False)
class ObservedOrder(Result):
    """The order p of a method, error ~ step**p, from correct digits at several steps and times.

    ``digits``: a row for each of ``steps``, correct ones at each of ``times``; ``names``: of the
    tables, where they are some.  At a step counts what is above the first digits and below
    ``rounding``, the digits from which on rounding rules.  ``orders``: at each time that of the
    least squares through log errors at the steps that count, None where these are too few.
    ``order``: the median of them; ``least``, ``most``: between any two neighbours of the steps that
    count, at any time.
    """

    steps: tuple[float, ...]
    times: tuple[Fraction, ...]
    digits: tuple[tuple[float, ...], ...]
    rounding: float
    names: tuple[str, ...] = ()

    @property
    def orders(self) -> tuple[float | None, ...]:
        """The order at each time."""
        enough = min(_FEWEST, len(self.steps))
        points = self._points
        return tuple(_slope(here) if len(here) >= enough else None for here in points)

    @property
    def order(self) -> float:
        """The median over the times."""
        return median(x for x in self.orders if x is not None)

    @property
    def least(self) -> float:
        """The smallest between neighbouring steps."""
        return min(self._between)

    @property
    def most(self) -> float:
        """The largest between neighbouring steps."""
        return max(self._between)

    @property
    def counted(self) -> tuple[bool, ...]:
        """Which steps count, at any time."""
        return tuple(any(map(self._counts, row)) for row in self.digits)

    def _counts(self, digits: float) -> bool:
        return _LEAST < digits < self.rounding

    @property
    def _points(self) -> list[list[tuple[float, float]]]:
        """The steps that count at each time with the digits there, the longest first."""
        return [
            sorted((h, d) for h, d in zip(self.steps, here, strict=True) if self._counts(d))[::-1]
            for here in zip(*self.digits, strict=True)
        ]

    @property
    def _between(self) -> list[float]:
        both = zip(self._points, self.orders, strict=True)
        return [_slope(pair) for here, x in both if x is not None for pair in pairwise(here)]

    @property
    def _range(self) -> str:
        known = sum(x is not None for x in self.orders)
        told = f"{self.least:.2f} to {self.most:.2f} between successive steps"
        return told if len(self.times) == 1 else f"{told} at {known} of {len(self.times)} times"

    def __repr__(self) -> str:
        return (
            f"<ObservedOrder {self.order:.2f}, {self._range}, {sum(self.counted)} of them counted>"
        )

    def __str__(self) -> str:
        lines = []
        names = self.names or [""] * len(self.steps)
        rows = zip(self.steps, self.digits, self.counted, names, strict=True)
        for h, digits, counts, name in rows:
            told = f"step {h:<10.4g} {min(digits):6.2f} digits{'' if counts else ', not counted'}"
            lines.append(f"{told}, {name}" if name else told)
        return "\n".join([*lines, f"order {self.order:.2f}; {self._range}"])


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
    against = reference(scene)
    judged = [
        compare(mine(h), against, at=times, columns=columns, as_it_stands=True) for h in lengths
    ]
    found = _order(judged, lengths, judged[0].times)
    if all(x is None for x in found.orders):
        worst = [min(row, default=0.0) for row in found.digits]
        told = ", ".join(f"{h:.3g}: {d:.1f}" for h, d in zip(lengths, worst, strict=True))
        window = f"{_LEAST:g} to {found.rounding:.1f} digits"
        expected = f"{_FEWEST} or more that give {window} (there were {told})"
        raise BadInput("order_of", "steps", sum(found.counted), expected)
    return found


def order_between(
    judged: Sequence[Judgement], steps: Sequence[AnyNumber] | None = None
) -> ObservedOrder:
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
    found = _order(judged, lengths, judged[0].times, names)
    if all(x is None for x in found.orders):
        told = ", ".join(f"{min(row):.1f} to {max(row):.1f}" for row in found.digits if row)
        window = f"{_LEAST:g} to {found.rounding:.1f} digits"
        expected = f"common ones at which the files have {window}"
        raise BadInput(", ".join(names), "t", told or None, expected)
    return found


def _order(
    judged: Sequence[Judgement],
    steps: tuple[float, ...],
    times: Sequence[Fraction],
    names: tuple[str, ...] = (),
) -> ObservedOrder:
    """What judgements tell at those of the times that all of them have, but t = 0."""
    digits = [
        {_label(t): d for t, d in zip(one.times, _fewest(one), strict=True) if d is not None}
        for one in judged
    ]
    common = tuple(t for t in times if t and all(_label(t) in known for known in digits))
    rows = tuple(tuple(known[_label(t)] for t in common) for known in digits)
    rounding = min(one.subject.held for one in judged) - _SPARE
    return ObservedOrder(steps, common, rows, rounding, names)


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


def _slope(points: Sequence[tuple[float, float]]) -> float:
    """Of the least squares through log errors over log steps, of steps with their digits."""
    logs = [(math.log10(h), -d) for h, d in points]
    x, y = (sum(column) / len(logs) for column in zip(*logs, strict=True))
    square = sum((a - x) ** 2 for a, _ in logs)
    return float(sum((a - x) * (b - y) for a, b in logs) / square)
