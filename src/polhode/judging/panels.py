"""A closed form at very many times: asked at Chebyshev's points of panels, told between them.

A closed form is an analytic function of time.  On a panel it is a sum of Chebyshev polynomials,

    f(x) = sum c_k T_k(x),    c_k = (2 - [k = 0])/n sum_j f(x_j) T_k(x_j),    T_n(x_j) = 0,

whose last coefficients say how far it reaches: a panel is halved until they are below the digits
asked for.  Where w and gamma have a period T, panels cover one of them: then

    w(t + T) = w(t),    gamma(t + T) = gamma(t),    q(t + T) = (cos D, 0, 0, sin D) q(t).

The sums are made in pairs of doubles (L. N. Trefethen, *Approximation Theory and Approximation
Practice*, SIAM 2013, chapters 3, 4 and 8).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.closed_forms.attitude.quaternion import conjugate, product
from polhode.common.progress import Tell
from polhode.common.text import few
from polhode.judging.by_processes import asked_by
from polhode.judging.reference import Reference, rows
from polhode.numbers.convert import exactly
from polhode.numbers.pairs import Pairs, cos_sin, of_fractions, pairs
from polhode.numbers.private import mpmath, own

NODES = 40
_FIRST = 4.0  # radians that the first panels are long
_SPARE = 3  # digits of the values at the nodes
_LAST = 4  # coefficients that must be below the digits
_TRIED = 5  # panels that tell how long the others may be
_PAYS = 2  # rows for each node: below that rows are asked for one by one
_BLOCK = 2048  # rows that are told together: what stays in the processor's cache
_SINGLE = 1e-12  # coefficients below it need no second double
_BITS = 200

Doubles = npt.NDArray[np.float64]
Span: TypeAlias = tuple[float, float]


class Columns(NamedTuple):
    """States and quaternions, each column an array; None where they were not asked for."""

    states: list[Pairs] | None
    quaternion: list[Pairs] | None


class Cycle(NamedTuple):
    """After ``period`` w and gamma repeat; the body has turned by 2 ``half`` about the vertical."""

    period: Fraction
    half: Any  # an mpf


class TooDear(ValueError):
    """Panels would take about as long as the rows one by one."""


def in_panels(
    reference: Reference,
    times: Sequence[Fraction],
    digits: int,
    asked: Sequence[str],
    workers: int,
    tell: Tell | None = None,
) -> Columns | None:
    """The reference at the times, right to about so many digits of max |w| and of 1.

    ``asked``: "at", "attitude", or both, in this order.  None where panels do not pay, or where
    they cannot reach the digits.  ``tell``: see :func:`polhode.judging.by_processes.asked_by`.
    """
    questions = [asked_by(reference, name, workers, tell) for name in asked]

    def ask(some: Sequence[Fraction]) -> Doubles:
        """Both doubles of all columns, shape (2, times, columns)."""
        answers = zip(*(rows(q, some, digits + _SPARE) for q in questions), strict=True)
        cells = [[_both(x) for part in parts for x in part] for parts in answers]
        return np.array(cells).transpose(2, 0, 1)

    try:
        cycle = _cycle(reference, asked, max(map(abs, times)), digits)
        here, counts = _folded(times, cycle)
        ends = (Fraction(0), cycle.period) if cycle else (min(times), max(times))
        length = _FIRST / 10.0**reference.scene.log10_rate
        trials = _Trials(ask, digits, "at" in asked)
        found = _told(here, _panels(trials, ends, length, here.hi))
    except TooDear:
        return None
    states = found[:-4] if "attitude" in asked else found
    turns = found[-4:] if "attitude" in asked else None
    if cycle is not None and turns is not None:
        turns = _turned(turns, counts * pairs(cycle.half))
    return Columns(states if "at" in asked else None, turns)


def _cycle(reference: Reference, asked: Sequence[str], last: Fraction, digits: int) -> Cycle | None:
    """The period of the state, where it has one shorter than the times; seen at three moments."""
    period = reference.period
    if period is None or not mpmath.isfinite(own(period)) or exactly(period) >= last:
        return None
    whole = exactly(period)
    moments = [whole * k / 16 for k in (0, 5, 11)]
    with mpmath.workprec(_BITS):
        halves, small = [], mpmath.mpf(10) ** -digits
        size = max(1.0, 10.0**reference.scene.log10_rate)
        for t in moments:
            for question in asked:
                found = getattr(reference, question)([t, t + whole], digits + _SPARE)
                before, after = (own(row) for row in found)
                if question == "attitude":
                    c, x, y, s = product(tuple(after), conjugate(tuple(before)))
                    if max(abs(x), abs(y)) > small:
                        return None
                    halves.append((c, s))
                elif max(abs(x - y) for x, y in zip(before, after, strict=True)) > small * size:
                    return None
        if any(max(abs(c - halves[0][0]), abs(s - halves[0][1])) > small for c, s in halves):
            return None
        half = mpmath.atan2(halves[0][1], halves[0][0]) if halves else mpmath.mpf(0)
    return Cycle(whole, half)


def _folded(times: Sequence[Fraction], cycle: Cycle | None) -> tuple[Pairs, Doubles]:
    """Times within a period, and how many periods were taken away."""
    at = of_fractions(times)
    if cycle is None:
        return at, np.zeros(len(times))
    counts: Doubles = np.floor(at.hi / float(cycle.period))
    return at - counts * pairs(cycle.period), counts


@dataclass(frozen=True)
class _Panels:
    """Ascending ends, and coefficients: both doubles, shape (2, panels, NODES, columns)."""

    ends: Doubles  # shape (panels, 2)
    terms: Doubles


class _Trials:
    """Panels tried: their coefficients, and whether these reach the digits.

    ``ask``: both doubles of all columns at times; the first three are omega where ``moving``.
    """

    def __init__(
        self, ask: Callable[[Sequence[Fraction]], Doubles], digits: int, moving: bool
    ) -> None:
        self._ask, self._small, self._moving = ask, 10.0 ** -(digits + 1), moving
        self._points, self._matrix = _rule()
        self._fastest = 0.0

    def of(self, spans: Sequence[Span]) -> tuple[Doubles, list[bool]]:
        """Coefficients, shape (2, panels, NODES, columns), and which panels are short enough."""
        exact = [(Fraction(a), Fraction(b) - Fraction(a)) for a, b in spans]
        values = self._ask([a + span * x for a, span in exact for x in self._points])
        values = values.reshape(2, len(spans), NODES, -1)
        scales = np.ones(values.shape[-1])
        if self._moving:
            self._fastest = max(self._fastest, float(np.abs(values[0, ..., :3]).max()))
            scales[:3] = self._fastest or 1.0
        terms = _product(self._matrix, values)
        left = (np.abs(terms[0, :, -_LAST:]) / scales).max(axis=(1, 2))
        return terms, [bool(x < self._small) for x in left]


def _panels(
    trials: _Trials, ends: tuple[Fraction, Fraction], length: float, here: Doubles
) -> _Panels:
    """Panels about so long, and halved as often as it takes; raises TooDear."""
    margin = 1e-9 * float(ends[1] - ends[0])
    low, high = float(ends[0]) - margin, float(ends[1]) + margin
    count, most = max(1, math.ceil((high - low) / length)), len(here) // (NODES * _PAYS)
    if count > most:
        raise TooDear
    count <<= _halvings(trials, _equal(low, high, count), most)
    held, open_ = np.sort(here), _equal(low, high, count)
    done: list[tuple[Span, Doubles]] = []
    while open_:
        first = np.searchsorted(held, [a for a, _ in open_])
        last = np.searchsorted(held, [b for _, b in open_], "right")
        open_ = [span for span, i, k in zip(open_, first, last, strict=True) if i < k]  # with rows
        if len(done) + len(open_) > most:
            raise TooDear
        terms, right = trials.of(open_)
        done += [(span, terms[:, k]) for k, span in enumerate(open_) if right[k]]
        open_ = [half for k, span in enumerate(open_) if not right[k] for half in _halves(span)]
    done.sort(key=lambda panel: panel[0])
    spans, found = zip(*done, strict=True)
    return _Panels(np.array(spans), np.stack(found, axis=1))


def _halvings(trials: _Trials, spans: Sequence[Span], most: int) -> int:
    """How often all panels are to be halved, by some of them; raises TooDear."""
    if len(spans) <= _TRIED:
        return 0
    some = [spans[k] for k in few(len(spans), _TRIED)]
    level, needed, enough = 0, 0.0, 0
    while some:
        _, right = trials.of(some)
        if any(right) and not needed:
            enough = level
        needed += sum(right) << level
        some = [_halves(span)[0] for span, done in zip(some, right, strict=True) if not done]
        level += 1
        if (needed + (len(some) << level)) / _TRIED * len(spans) > most:
            raise TooDear
    return enough


def _equal(low: float, high: float, count: int) -> list[Span]:
    edges = np.linspace(low, high, count + 1).tolist()
    return [*pairwise(edges)]


def _halves(span: Span) -> tuple[Span, Span]:
    a, b = span
    return (a, (a + b) / 2), ((a + b) / 2, b)


def _rule() -> tuple[list[Fraction], Doubles]:
    """Chebyshev's points as parts of a panel, and the matrix from values to coefficients."""
    with mpmath.workprec(_BITS):
        unit = mpmath.pi / (2 * NODES)
        points = [exactly(+((1 + mpmath.cos((2 * j + 1) * unit)) / 2)) for j in range(NODES)]
        matrix = [
            [
                _both(mpmath.mpf(2 if k else 1) / NODES * mpmath.cos(k * (2 * j + 1) * unit))
                for j in range(NODES)
            ]
            for k in range(NODES)
        ]
    return points, np.array(matrix).transpose(2, 0, 1)


def _product(matrix: Doubles, values: Doubles) -> Doubles:
    """The matrix times each panel's values, in pairs; shape (2, panels, NODES, columns)."""
    found = []
    for panel in range(values.shape[1]):
        total = Pairs(np.zeros(values.shape[2:]))
        for j in range(NODES):
            column = Pairs(matrix[0, :, j, None], matrix[1, :, j, None])
            total = total + column * Pairs(*values[:, panel, j])
        found.append([total.hi, total.lo])
    return np.array(found).transpose(1, 0, 2, 3)


def _told(here: Pairs, panels: _Panels) -> list[Pairs]:
    """The sums at the times, by Clenshaw's recurrence."""
    width = panels.terms.shape[-1]
    found = np.empty((2, width, len(here.hi)))
    of = np.clip(np.searchsorted(panels.ends[:, 0], here.hi, "right") - 1, 0, None)
    for k in range(0, len(of), _BLOCK):
        block = slice(k, k + _BLOCK)
        which = of[block]
        a, b = (Pairs(x) for x in panels.ends[which].T)
        x = (2.0 * here[block] - (a + b)) / (b - a)
        total = _clenshaw(panels.terms, which, x)
        found[0, :, block], found[1, :, block] = total.hi.T, total.lo.T
    return [Pairs(found[0, i], found[1, i]) for i in range(width)]


def _clenshaw(terms: Doubles, which: Any, x: Pairs) -> Pairs:
    """sum c_k T_k(x); what is small is added in doubles."""
    fine = int(np.max(np.nonzero(np.abs(terms[0]).max(axis=(0, 2)) > _SINGLE)[0], initial=0)) + 1
    twice = 2 * x.hi[:, None]
    one, two = (np.zeros((len(which), terms.shape[-1])) for _ in range(2))
    for k in range(NODES - 1, fine - 1, -1):
        one, two = terms[0, which, k] + twice * one - two, one
    first, second = Pairs(one), Pairs(two)
    x = Pairs(x.hi[:, None], x.lo[:, None])
    double = Pairs(2 * x.hi, 2 * x.lo)
    for k in range(fine - 1, 0, -1):
        first, second = double * first - second + Pairs(*terms[:, which, k]), first
    return x * first - second + Pairs(*terms[:, which, 0])


def _turned(q: Sequence[Pairs], half: Pairs) -> list[Pairs]:
    """(cos, 0, 0, sin) q."""
    c, s = cos_sin(half)
    q0, q1, q2, q3 = q
    return [c * q0 - s * q3, c * q1 - s * q2, c * q2 + s * q1, c * q3 + s * q0]


def _both(x: Any) -> tuple[float, float]:
    found = pairs(x)
    return found.hi, found.lo
