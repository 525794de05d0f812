"""A closed form at very many times: asked at some, carried to those around by the equations.

A motion is an analytic function of time: about a time m at which the closed form is asked, its
Taylor series (:mod:`polhode.judging._dense_reference.taylor_series`) is summed as far as its last
terms are below the digits asked for.  Such panels cover the times.  Where two touch, their sums
must be the same, and where a panel has no neighbour, the closed form itself is asked: so each
answer of the closed form is held against the next one by the equations, and a wrong one is noticed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.common.text_tables import few
from polhode.judging._dense_reference.parallel_evaluation import Ask
from polhode.judging._dense_reference.taylor_series import FINE, ORDER, Equations
from polhode.judging.references.reference import Reference, rows
from polhode.numbers.double_double import Pairs, pairs
from polhode.numbers.rows import Doubles

_FIRST = 1.0  # radians that the first panels are thought to reach to each side
_FARTHEST = 4.0  # times what they were thought to reach, that is believed of a series
_FULL = 0.95  # of what a series reaches, that the next ones are laid out for
_PILOTS = 8  # panels that tell how far the others may reach
SPARE = 3  # digits of the closed form beyond those asked for
_LAST = 4  # terms of a series that must be below the digits
_SINGLE = 1e13  # times the digits asked for: terms below it need no second double
_PAYS = 3  # rows for each panel: below that rows are asked for one by one
_BLOCK = 2048  # times that are told together: what stays in the processor's cache

Numbers: TypeAlias = npt.NDArray[np.int64]
Booleans: TypeAlias = npt.NDArray[np.bool_]


class NotSo(ValueError):
    """Panels would take about as long as the rows one by one, or do not fit each other."""


class Source:
    """A closed form's w and gamma at some times, in columns."""

    def __init__(self, reference: Reference, digits: int, turning: bool, ask: Ask) -> None:
        self.equations = Equations(reference.scene, turning)
        self.digits, self.fastest = digits, 0.0
        self.radian = 10.0**-reference.scene.log10_rate
        self._ask = ask

    def at(self, times: Sequence[float]) -> Pairs:
        """Shape (columns, times)."""
        found = in_columns(rows(self._ask, [Fraction(t) for t in times], self.digits + SPARE))
        self.fastest = max(self.fastest, float(np.abs(found.hi[:3]).max()))
        return found

    def small(self, columns: int) -> Doubles:
        """Errors of the columns that the digits asked for allow, shape (columns, 1)."""
        found = np.full((columns, 1), 10.0**-self.digits)
        found[:3] *= self.fastest or 1.0
        return found


@dataclass(frozen=True)
class Panels:
    """Series about ascending ``middles``, in units of time ``spans``; each reaches ``reach`` of it.

    ``terms``: both doubles, shape (2, ORDER + 1, columns, panels), of w, gamma and, where the body
    is followed, of the turn from where it is at the middle: q(t) = q(middle) ∘ turn.
    """

    middles: Doubles
    spans: Doubles
    reach: Doubles
    terms: Doubles

    @property
    def begins(self) -> Doubles:
        """From where on each can be summed."""
        return self.middles - self.reach * self.spans

    @property
    def ends(self) -> Doubles:
        """Up to where each can be summed."""
        return self.middles + self.reach * self.spans

    def and_these(self, others: Panels) -> Panels:
        """Both, in order."""
        order = np.argsort(np.concatenate([self.middles, others.middles]))
        one, two, three = (
            np.concatenate([getattr(self, name), getattr(others, name)])[order]
            for name in ("middles", "spans", "reach")
        )
        terms = np.concatenate([self.terms, others.terms], axis=3)[..., order]
        return Panels(one, two, three, terms)

    @property
    def joints(self) -> tuple[Doubles, Booleans]:
        """Where each gives way to the next, and whether both reach so far."""
        low = np.maximum(self.begins[1:], self.middles[:-1])
        high = np.minimum(self.ends[:-1], self.middles[1:])
        return (low + high) / 2, self.ends[:-1] >= self.begins[1:]

    def edges(self, held: Doubles) -> tuple[Numbers, Doubles]:
        """Panels without a neighbour on a side, and up to where they are used there."""
        _, touch = self.joints
        alone = np.nonzero(~np.concatenate([[False], touch, touch, [False]]))[0]
        edges = np.concatenate([self.begins, self.ends]).clip(held[0], held[-1])
        return alone % len(self.middles), edges[alone]

    def of(self, at: Doubles) -> Numbers:
        """Which panel a time belongs to."""
        return np.searchsorted(self.joints[0], at, "right")

    def used(self, held: Doubles) -> tuple[Doubles, Doubles]:
        """From where, and up to where, each panel is used for such times."""
        joints, touch = self.joints
        low, high = (x.clip(held.min(), held.max()) for x in (self.begins, self.ends))
        low[1:][touch] = high[:-1][touch] = joints[touch]
        return low, high

    def roughly(self, of: Numbers, times: Doubles) -> tuple[Doubles, Doubles, Doubles]:
        """The turn of panels in doubles at times of each, and bounds of |w| and |w'| there.

        ``times``: shape (panels, times); answers: shapes (4, panels, times), (panels,), (panels,).
        """
        x = (times - self.middles[of, None]) / self.spans[of, None]
        terms = self.terms[0][:, :, of]
        turn = np.zeros((4, *times.shape))
        for k in range(ORDER, -1, -1):
            turn = turn * x + terms[k, -4:, :, None]
        order = np.arange(ORDER + 1)[:, None, None]
        sizes = np.abs(terms[:, :3]) * np.abs(x).max(axis=1) ** order
        more = order * np.abs(terms[:, :3]) * np.abs(x).max(axis=1) ** np.maximum(order - 1, 0)
        speed, change = (np.sqrt((y.sum(axis=0) ** 2).sum(axis=0)) for y in (sizes, more))
        return turn, speed, change / self.spans[of]

    def summed(self, of: Numbers, at: Pairs) -> Pairs:
        """Some panels' series, each at a time: shape (columns, times)."""
        found = np.empty((2, self.terms.shape[2], len(of)))
        for k in range(0, len(of), _BLOCK):
            block = slice(k, k + _BLOCK)
            total = self._summed(of[block], at[block])
            found[0, :, block], found[1, :, block] = total.hi, total.lo
        return Pairs(*found)

    def _summed(self, of: Numbers, at: Pairs) -> Pairs:
        """What is small is added in doubles."""
        x = (at - self.middles[of]) / self.spans[of]
        rough = np.zeros((self.terms.shape[2], len(of)))
        for k in range(ORDER, FINE - 1, -1):
            rough = rough * x.hi + self.terms[0, k][:, of]
        total = Pairs(rough)
        for k in range(FINE - 1, -1, -1):
            total = total * x + Pairs(*self.terms[:, k][:, :, of])
        return total


def covering(source: Source, held: Doubles) -> Panels:
    """Panels that reach all times, which ascend; raises NotSo."""
    most = len(held) // _PAYS
    if (held[-1] - held[0]) / (2 * _FARTHEST * _FIRST * source.radian) > most:
        raise NotSo
    pilots = held[few(len(held), min(_PILOTS, most))]
    panels = _made(source, pilots, np.full(len(pilots), _FIRST * source.radian))
    while True:
        middles, spans = _open(panels, held)
        if len(middles) == 0:
            _fit(source, panels, held)
            return panels
        if len(panels.middles) + len(middles) > most:
            raise NotSo
        panels = panels.and_these(_made(source, middles, spans))


def _made(source: Source, middles: Doubles, spans: Doubles) -> Panels:
    """Panels about such times; raises NotSo where a series reaches nowhere."""
    terms = source.equations.series(source.at(middles.tolist()), spans)
    small = source.small(terms.shape[2]) / 10
    with np.errstate(all="ignore"):
        left = np.abs(terms[0]) / small  # shape (order, columns, panels)
        order = np.arange(ORDER + 1)[:, None, None]
        last = left[-_LAST:] ** (1 / order[-_LAST:])
        rough = (left[FINE:] / _SINGLE) ** (1 / order[FINE:])
        reach = 1 / np.maximum(last.max(axis=(0, 1)), rough.max(axis=(0, 1)))
    if not np.all(reach > 0):  # or not a number
        raise NotSo
    return Panels(middles, spans, np.minimum(reach, _FARTHEST), terms)


def _open(panels: Panels, held: Doubles) -> tuple[Doubles, Doubles]:
    """Middles and spans of panels that are still to be made: where rows are not reached."""
    far = panels.reach * panels.spans
    low = np.concatenate([[-np.inf], panels.ends])
    high = np.concatenate([panels.begins, [np.inf]])
    usual = np.concatenate([far[:1], (far[1:] + far[:-1]) / 2, far[-1:]])
    first, last = np.searchsorted(held, low, "right"), np.searchsorted(held, high, "left")
    middles, spans = [], []
    for k in np.nonzero(last > first)[0]:
        some = held[first[k] : last[k]]
        begin, end = max(low[k], some[0]), min(high[k], some[-1])
        count = max(1, math.ceil((end - begin) / (2 * _FULL * usual[k])))
        edges = np.linspace(begin, end, count + 1)
        inner = np.searchsorted(some, edges[1:-1])
        there = np.diff([0, *inner, len(some)]) > 0
        middles.append(((edges[1:] + edges[:-1]) / 2)[there])
        spans.append(np.full(int(there.sum()), usual[k]))
    if not middles:
        return np.array([]), np.array([])
    return np.concatenate(middles), np.concatenate(spans)


def _fit(source: Source, panels: Panels, held: Doubles) -> None:
    """Raises NotSo unless panels are the same where they touch, and right at other ends."""
    joints, touch = panels.joints
    which = np.nonzero(touch)[0]
    of, edges = panels.edges(held)
    if len(panels.middles) + len(of) > len(held) / _PAYS:
        raise NotSo
    true = source.at(edges.tolist())
    small = source.small(len(true.hi))
    one, other = (panels.summed(which + k, at_doubles(joints[which])) for k in (0, 1))
    for departure in (
        (one - other)[: len(small)],
        panels.summed(of, at_doubles(edges))[: len(small)] - true,
    ):
        if not np.all(np.abs(departure.hi) <= small):
            raise NotSo


def at_doubles(times: Doubles) -> Pairs:
    """Times that doubles are."""
    return Pairs(times, np.zeros_like(times))


def in_columns(answers: Sequence[Sequence[Any]]) -> Pairs:
    """Rows of mpf as pairs, shape (columns, rows)."""
    cells = [[(x.hi, x.lo) for x in map(pairs, row)] for row in answers]
    return Pairs(*np.array(cells).transpose(2, 1, 0))
