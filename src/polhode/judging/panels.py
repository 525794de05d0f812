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
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.closed_forms.attitude.quaternion import conjugate, product
from polhode.judging.by_processes import asked_by
from polhode.judging.reference import Reference, rows
from polhode.numbers.convert import exactly
from polhode.numbers.pairs import Pairs, cos_sin, of_fractions, pairs
from polhode.numbers.private import mpmath, own

NODES = 40
_FIRST = 4.0  # radians that the first panels are long
_SPARE = 3  # digits of the values at the nodes
_LAST = 4  # coefficients that must be below the digits
_PAYS = 3  # rows for each node: below that rows are asked for one by one
_BLOCK = 2048  # rows that are told together: what stays in the processor's cache
_SINGLE = 1e-12  # coefficients below it need no second double
_BITS = 200

Doubles = npt.NDArray[np.float64]


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
    reference: Reference, times: Sequence[Fraction], digits: int, asked: Sequence[str], workers: int
) -> Columns | None:
    """The reference at the times, right to about so many digits of max |w| and of 1.

    ``asked``: "at", "attitude", or both, in this order.  None where panels do not pay, or where
    they cannot reach the digits.
    """
    questions = [asked_by(reference, name, workers) for name in asked]

    def ask(some: Sequence[Fraction]) -> Doubles:
        """Both doubles of all columns, shape (2, times, columns)."""
        answers = zip(*(rows(q, some, digits + _SPARE) for q in questions), strict=True)
        cells = [[_both(x) for part in parts for x in part] for parts in answers]
        return np.array(cells).transpose(2, 0, 1)

    def scales(largest: Doubles) -> Doubles:
        """What the columns' errors are relative to."""
        found = np.ones_like(largest)
        if "at" in asked:
            found[:3] = largest[:3].max() or 1.0
        return found

    try:
        cycle = _cycle(reference, asked, max(map(abs, times)), digits)
        here, counts = _folded(times, cycle)
        ends = (Fraction(0), cycle.period) if cycle else (min(times), max(times))
        length = _FIRST / 10.0**reference.scene.log10_rate
        found = _told(here, _panels(ask, scales, ends, length, here.hi, digits))
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


def _panels(
    ask: Callable[[Sequence[Fraction]], Doubles],
    scales: Callable[[Doubles], Doubles],
    ends: tuple[Fraction, Fraction],
    length: float,
    here: Doubles,
    digits: int,
) -> _Panels:
    """Panels in which the coefficients fall below the digits; raises TooDear."""
    low, high = float(ends[0]), float(ends[1])
    low, high = low - 1e-9 * (high - low), high + 1e-9 * (high - low)
    count = max(1, math.ceil((high - low) / length))
    most = len(here) // (NODES * _PAYS)
    if count > most:
        raise TooDear
    edges = np.linspace(low, high, count + 1)
    open_ = [*zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)]
    done: list[tuple[float, float, Doubles]] = []
    points, to_terms = _rule()
    held, largest = np.sort(here), np.zeros(0)
    while open_:
        spans = (
            np.searchsorted(held, np.array(open_).T[0]),
            np.searchsorted(held, np.array(open_).T[1], "right"),
        )
        open_ = [panel for panel, a, b in zip(open_, *spans, strict=True) if b > a]  # with rows
        if len(done) + len(open_) > most:
            raise TooDear
        exact = [(Fraction(a), Fraction(b) - Fraction(a)) for a, b in open_]
        values = ask([a + span * x for a, span in exact for x in points])
        values = values.reshape(2, len(open_), NODES, -1)
        largest = (
            np.maximum(largest, np.abs(values[0]).max(axis=(0, 1)))
            if largest.size
            else np.abs(values[0]).max(axis=(0, 1))
        )
        terms = _product(to_terms, values)
        left = (np.abs(terms[0, :, -_LAST:]) / scales(largest)).max(axis=(1, 2))
        halved = []
        for k, (a, b) in enumerate(open_):
            if left[k] < 10.0 ** -(digits + 1):
                done.append((a, b, terms[:, k]))
            else:
                halved += [(a, (a + b) / 2), ((a + b) / 2, b)]
        open_ = halved
    done.sort(key=lambda panel: panel[0])
    ends_of = np.array([[a, b] for a, b, _ in done])
    return _Panels(ends_of, np.stack([x for *_, x in done], axis=1))


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
