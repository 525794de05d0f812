"""The order at which an integrator converges, seen from its errors at several steps and times."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from statistics import linear_regression, median

from polhode.common.arguments import each
from polhode.common.errors import BadInput
from polhode.judging.compare import compare
from polhode.judging.conditioning import Band
from polhode.judging.limits import expectation
from polhode.judging.reference import reference
from polhode.judging.score import RowDigits, Score
from polhode.numbers.conversion import exact_number, to_double
from polhode.numbers.exact import sign
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.results.cells import TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes.scene import Scene

_HALVINGS = range(5, 12)  # of the time, for the steps that are tried
_LEAST = 1.5  # digits below which no power of the step rules the error
_SPARE = 2.5  # digits above which rounding does
_FEWEST = 3  # steps; of fewer tables all, and of those that rounding leaves
_SHORT = 0.25  # digits fewer than the step's: nearly half of the error is another one
_NEAR = 0.5  # digits by which errors of rounding may lie below what they amount to


@dataclass(frozen=True, repr=False)
class ObservedOrder(Result):
    """The order p of a method, error ~ step**p, from correct digits at several steps and times.

    ``digits``: a row for each of ``steps``, correct ones at each of ``times``, nan where a table
    lacks a number; ``limited``: likewise, whether rounding limits them; ``names``: of the tables,
    where they are some.  At a step counts what is above the first digits and not limited.
    ``orders``: at each time that of the least squares through log errors at the steps that count,
    None where these are too few.  ``order``: the median of them; ``least``, ``most``: between any
    two neighbours of the steps that count, at any time.
    """

    steps: tuple[float, ...]
    times: tuple[Fraction, ...]
    digits: tuple[tuple[float, ...], ...]
    limited: tuple[tuple[bool, ...], ...]
    names: tuple[str, ...] = ()

    def table(self) -> Table:
        """A row a time: the order, and the correct digits of each step."""
        digits = (
            Column(f"correct_digits_{k}", row, f"of step {k}", digits=4)
            for k, row in enumerate(self.digits, 1)
        )
        order = Column("order", list(self.orders), "of the method, none from too few steps")
        return Table([Column("t", list(self.times), "time"), order, *digits])

    def facts(self) -> list[Fact]:
        """The order, and of what steps."""
        return [
            Fact("order", self.order, "the median over the times"),
            Fact("order_least", self.least, "between two neighbouring steps"),
            Fact("order_most", self.most, "between two neighbouring steps"),
            Fact("steps", list(self.steps)),
            Fact("files", list(self.names), type=TEXT),
            Fact("left_out", list(self.left_out), "steps that rounding limits"),
        ]

    @property
    def orders(self) -> tuple[float | None, ...]:
        """The order at each time."""
        enough = self.fewest_steps
        return tuple(_slope(here) if len(here) >= enough else None for here in self._points)

    @property
    def fewest_steps(self) -> int:
        """The fewest that tell an order: of fewer tables all, and two of those rounding leaves."""
        return max(2, min(_FEWEST, len(self.steps) - len(self.left_out)))

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
        counted = {h for here in self._points for h, _ in here}
        return tuple(h in counted for h in self.steps)

    @property
    def left_out(self) -> tuple[float, ...]:
        """The steps that rounding limits at all times."""
        both = zip(self.steps, self.limited, strict=True)
        return tuple(h for h, limited in both if limited and all(limited))

    @property
    def _points(self) -> list[list[tuple[float, float]]]:
        """The steps that count at each time with the digits there, the longest first."""
        rows = sorted(zip(self.steps, self.digits, self.limited, strict=True), reverse=True)
        return [
            [(h, d[k]) for h, d, limited in rows if d[k] > _LEAST and not limited[k]]
            for k in range(len(self.times))
        ]

    @property
    def _between(self) -> list[float]:
        enough = self.fewest_steps
        points = (here for here in self._points if len(here) >= enough)
        return [_slope(pair) for here in points for pair in pairwise(here)]

    @property
    def _summary(self) -> str:
        count = sum(x is not None for x in self.orders)
        words = f"{self.least:.2f} to {self.most:.2f} between successive steps"
        return words if len(self.times) == 1 else f"{words} at {count} of {len(self.times)} times"

    def __repr__(self) -> str:
        counted = f"{sum(self.counted)} of them counted"
        return f"<ObservedOrder {self.order:.2f}, {self._summary}, {counted}>"

    def __str__(self) -> str:
        names = [f", {name}" for name in self.names] or [""] * len(self.steps)
        lines = []
        for h, digits, counts, name in zip(
            self.steps, self.digits, self.counted, names, strict=True
        ):
            line = f"step {h:<10.4g} {_least(digits):6.2f} digits"
            if missing := sum(map(math.isnan, digits)):
                line += f", no numbers at {missing} of {len(digits)} times"
            if not counts:
                line += f", left out{': rounding limits it' if h in self.left_out else ''}"
            lines.append(line + name)
        return "\n".join([*lines, f"order {self.order:.2f}; {self._summary}"])


def _least(digits: Sequence[float]) -> float:
    """The fewest, of those that are there."""
    return min((d for d in digits if not math.isnan(d)), default=math.nan)


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
        steps = [end * Fraction(1, 2**k) for k in _HALVINGS]
    lengths = _lengths("order_of", steps)
    if len({*lengths}) < _FEWEST or not all(0 < h < math.inf for h in lengths):
        raise BadInput("order_of", "steps", len(lengths), f"{_FEWEST} or more, different, above 0")
    lengths = tuple(sorted(lengths, reverse=True))
    against = reference(scene)
    scores = [
        compare(mine(h), against, at=times, columns=columns, as_it_stands=True) for h in lengths
    ]
    return _order("order_of", scores, lengths)


def order_between(
    judged: Sequence[Score], steps: Sequence[AnyNumber] | None = None, where: str = "in --steps"
) -> ObservedOrder:
    """The order of one method whose tables, made with different steps, were judged.

    ``steps``: of the tables, the distances of their rows unless given.
    ``where``: in which place a user gives them.
    """
    names = tuple(score.subject.name for score in judged)
    if steps is None:
        lengths = tuple(_spacing(score) for score in judged)
        apart = ", ".join(f"{x:g}" for x in lengths)
        expected = f"the step sizes of the method {where}: the files' rows are {apart} apart"
    else:
        lengths = _lengths("orders", steps)
        expected = f"{len(judged)} different ones above 0, one a file"
    right = all(0 < h < math.inf for h in lengths)
    if not right or len(lengths) != len(judged) or len({*lengths}) < max(2, len(judged)):
        raise BadInput(", ".join(names), "steps", None, expected)
    return _order(", ".join(names), judged, lengths, names)


def _lengths(source: str, steps: Sequence[AnyNumber]) -> tuple[float, ...]:
    return each(source, "steps", steps, lambda h: to_double(exact_number(h)), "numbers")


def _order(
    source: str, judged: Sequence[Score], steps: tuple[float, ...], names: tuple[str, ...] = ()
) -> ObservedOrder:
    """What judgements tell at those times that all of them have, but t = 0; raises BadInput."""
    digits = [
        {_label(t): d for t, d in zip(score.times, _digits(score), strict=True) if d is not None}
        | {_label(score.times[k]): math.nan for rows in score.gaps.values() for k in rows}
        for score in judged
    ]
    times = judged[0].times
    common = tuple(t for t in times if t and all(_label(t) in by_time for by_time in digits))
    rows = tuple(tuple(by_time[_label(t)] for t in common) for by_time in digits)
    rounding = min(score.subject.held for score in judged) - _SPARE
    limited = _limited(judged, steps, common, rows, rounding)
    order = ObservedOrder(steps, common, rows, limited, names)
    if all(x is None for x in order.orders):
        both = zip(steps, rows, strict=True)
        ranges = (f"{h:.3g}: {_least(row):.1f} to {max(row):.1f}" for h, row in both if row)
        digits_of_steps = ", ".join(ranges)
        count, window = order.fewest_steps, f"{_LEAST:g} to {rounding:.1f} digits"
        expected = f"{count} or more that give {window} at a time that all have"
        if order.left_out:
            expected += f"; rounding limits {', '.join(f'{h:.3g}' for h in order.left_out)}"
        raise BadInput(source, "steps", digits_of_steps or None, expected)
    return order


def _limited(
    judged: Sequence[Score],
    steps: Sequence[float],
    times: Sequence[Fraction],
    rows: Sequence[Sequence[float]],
    rounding: float,
) -> tuple[tuple[bool, ...], ...]:
    """Whether each step is limited by rounding at each time.

    It is from ``rounding`` digits on.  It is as well where it has fewer digits than the two longer
    ones before it foretell, and the roundings of all steps, in one direction at worst, may leave no
    more.  A step is, where a longer one is.
    """
    limited = [[False] * len(times) for _ in steps]
    bands: dict[int, dict[str, Band | None]] = {}
    longest_first = sorted(range(len(steps)), key=steps.__getitem__, reverse=True)
    for j, t in enumerate(times):
        before: list[tuple[float, float]] = []  # lengths and digits of the longer steps
        for place, k in enumerate(longest_first):
            h, d = steps[k], rows[k][j]
            rules = d >= rounding
            if not rules and len(before) > 1 and _falls_short(before, h, d):
                if k not in bands:
                    expected = expectation(judged[k]).bands
                    pairs = zip(judged[k].times, expected, strict=True)
                    bands[k] = {_label(x): band for x, band in pairs}
                band = bands[k][_label(t)]
                most = judged[k].subject.held if band is None else band.middle
                rules = d > most - math.log10(max(1.0, to_double(abs(t)) / h)) - _NEAR
            if rules:
                for shorter in longest_first[place:]:
                    limited[shorter][j] = True
                break
            if d > _LEAST:
                before.append((h, d))
    return tuple(map(tuple, limited))


def _falls_short(before: Sequence[tuple[float, float]], h: float, digits: float) -> bool:
    """Whether a step has fewer digits than the two longer ones foretell."""
    length, d = before[-1]
    return digits < d + _slope(before[-2:]) * math.log10(length / h) - _SHORT


def _spacing(judged: Score) -> float:
    """The distance of a table's rows, the median."""
    times = sorted(judged.times)
    return float(median(b - a for a, b in pairwise(times))) if len(times) > 1 else 0.0


def _label(t: Fraction) -> str:
    """What times of several files have in common that differ in the last digits of doubles."""
    return f"{float(t):.12g}"


def _digits(judged: Score) -> RowDigits:
    """At each time the digits of the state; of what is judged, where there is no state."""
    return judged.digits or judged.fewest_digits


def _slope(points: Sequence[tuple[float, float]]) -> float:
    """Of the least squares through log errors over log steps, of steps with their digits."""
    logs, errors = zip(*((math.log10(h), -d) for h, d in points), strict=True)
    return linear_regression(logs, errors).slope
