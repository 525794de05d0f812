"""Certified zeros of a polynomial g along the exact motion: existence, uniqueness, time.

Trusted.  On a step the exact state is in xhat(tau) +- r (``step_bound``), and the derivative of g
along it is the polynomial g' = grad g · f, so h g' is that by tau.  With balls over a closed
interval I:

    0 not in g(I)                no zero in I;
    0 not in g'(I)               at most one, and exactly one if g has certified opposite signs at
                                 the ends; interval Newton I and (m - g(m)/(h g'(I))) tells where.

Otherwise I is split, off its middle; below 2**-40 of a step it is *undecided*, never counted.  So
is one that no splitting decides: g has no certified sign at its ends, and on it g' has one, or is
so small that g stays within a few radii of its ball at the middle.  What is left of a step after
MOST_PIECES is undecided, too.  Intervals that touch are one.

A zero within the radius of a step's boundary has no certified sign there: the intervals on both
sides are joined, and hold one zero if g' has one certified sign on both and the outer ends have
opposite ones.  Where g' has one on an undecided interval, only the ball that Newton's steps leave
of it is undecided, or nothing.  An interval that touches the last time stays undecided; one that
touches the first does, unless g and its first derivatives along the motion are known to be 0
there: if g and k - 1 derivatives are, and the k-th is not 0 on [0, b], g has no zero in (0, b].
Ends are multiples of 2**-48 of a step, so that a ball's midpoint and radius hold them exactly.

Where there is one zero in I, the state then is among those of the step at all times of I.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_poly

from polhode.common.cached_property import cached_property
from polhode.common.deadline import NONE, Deadline
from polhode.enclosures.fixed_point_problem import CLOCK, UP
from polhode.enclosures.integral_contraction import Contradiction
from polhode.enclosures.polynomial import BallPolynomial
from polhode.enclosures.step_bound import Bounds
from polhode.enclosures.zonotope import Step, approximation, widened
from polhode.numbers.flint_context import ctx

GRAIN = 48  # ends of intervals are integers times 2**-GRAIN of a step
WHOLE = 1 << GRAIN
EMPTY, SPLIT, OPEN = "no zero", "not decided", "not to be decided"
_FINEST = 1 << (GRAIN - 40)
_SPLIT = (499, 1000)  # off the middle: zeros like to sit at halves
_SMALL = 1 << (GRAIN - 8)  # an interval worth more than the coarse bits
_COARSE = 64  # bits for deciding; the times are found with all that the proof has
_NEWTONS = 60
MOST_PIECES = 512  # of a step; ordinary ones take up to 50
_FLAT = 4  # radii
_TIMES = 1 << 12  # bits: more than any time has


class Zero(NamedTuple):
    """Where a zero is: balls around its time, in the proof's unit, and around the state then."""

    time: Any
    state: tuple[Any, ...]


class Crossing(NamedTuple):
    """One zero, and the sign of g' there."""

    at: Zero
    slope: int


class Contact(NamedTuple):
    """An interval of time in which it is not decided how many zeros there are."""

    begin: Any
    end: Any


class _Part(NamedTuple):
    """An interval of a step that ends at a boundary without a certified sign of g there."""

    sign: int  # of g at its other end; 0 where that is not certified either
    slope: int  # of g' on it
    zero: Zero | None  # where its zero is, if it has one; None if Newton shows that it has none
    begin: Any
    end: Any


@dataclass
class Search:
    """The zeros of one polynomial as the steps of a proof go by.

    ``first``: the first of its derivatives along the motion that is not 0 at t = 0, where it is
    known that g and those before are; None elsewhere.  ``deadline``: looked at with each interval.
    """

    g: BallPolynomial
    rate: BallPolynomial
    first: BallPolynomial | None = None
    deadline: Deadline = NONE
    crossings: list[Crossing] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)
    _left: _Part | None = None  # an interval up to the last boundary, where no sign was certified
    _sign: int = 0  # of g at the last boundary

    def window(self, known: Bounds, steps: Sequence[Step]) -> None:
        """The zeros in a window whose steps have been accepted."""
        for n, step in enumerate(steps):
            self._step(_OnStep(self, known, n, step))

    def finish(self) -> None:
        """What is left at the last time is undecided."""
        self._undecided(self._left)
        self._left = None

    def _step(self, on: _OnStep) -> None:
        self._boundary(on)
        pending, pieces = [(0, WHOLE)], 0
        found: Crossing | _Part | str
        while pending:
            self.deadline.check()
            a, b = pending.pop()
            pieces += 1
            if pieces > MOST_PIECES:
                pending, b, found = [], WHOLE, OPEN
            else:
                found = on.decide(a, b)
            if found == SPLIT and b - a > _FINEST:
                middle = on.split(a, b)
                pending += [(middle, b), (a, middle)]
                continue
            if found in (SPLIT, OPEN):
                found = _Part(0, 0, None, on.time(a), on.time(b))
            if isinstance(found, _Part):
                self._part(found, a == 0 and not on.sign(0), b == WHOLE and not on.sign(WHOLE))
                continue
            self._undecided(self._left)
            self._left = None
            if isinstance(found, Crossing):
                self.crossings.append(found)
        self._sign = on.sign(WHOLE)

    def _boundary(self, on: _OnStep) -> None:
        """The sign of g where two steps meet, as either of them certifies it."""
        sign = on.sign(0)
        if sign * self._sign < 0:
            raise Contradiction("g has two signs on a step's boundary")
        sign = on.signs[0] = sign or self._sign
        left = self._left
        if left is None or not sign:
            return
        self._left = None
        if left.slope * left.sign == 0:
            self._undecided(left)
        elif left.sign != sign:
            if left.zero is None:
                raise Contradiction("a zero before a step's boundary is nowhere")
            self.crossings.append(Crossing(left.zero, left.slope))

    def _part(self, part: _Part, at_begin: bool, at_end: bool) -> None:
        """An interval without a certified sign at the step's beginning, its end, or both."""
        left, self._left = self._left, None
        if not at_begin:
            self._undecided(left)
            if not at_end:
                self._undecided(part)
        elif left is None:
            self._undecided(part)
        elif left.slope == part.slope != 0 and left.sign * part.sign < 0:
            zeros = [x.zero for x in (left, part) if x.zero is not None]
            if not zeros:
                raise Contradiction("a zero on a step's boundary is nowhere")
            self.crossings.append(Crossing(_either(zeros), left.slope))
        elif not (left.slope == part.slope != 0 and left.sign * part.sign > 0):
            self._undecided(left)
            self._undecided(part)
        if at_end:
            self._left = part._replace(sign=0) if at_begin else part

    def _undecided(self, part: _Part | None) -> None:
        if part is None:
            return
        begin, end = part.begin, part.end
        if part.slope:  # one zero at the most, and only where Newton's steps leave it
            if part.zero is None:
                return
            with ctx.workprec(_TIMES):
                begin, end = part.zero.time.lower(), part.zero.time.upper()
        if self.contacts and not self.contacts[-1].end < begin:
            last = self.contacts.pop()
            begin, end = last.begin, last.end if last.end > end else end
        self.contacts.append(Contact(begin, end))


class _OnStep:
    """g and g' on one step."""

    def __init__(self, search: Search, known: Bounds, n: int, step: Step) -> None:
        self.g, self.rate = search.g, search.rate
        self.known, self.n, self.step = known, n, step
        self.first = None if known.pieces.times[n] else search.first
        self.bits = known.problem.noise + 104
        pieces = known.pieces
        unit = arb((1, -known.problem.noise))
        with ctx.workprec(_COARSE):
            self.h = arb((pieces.times[n + 1] - pieces.times[n], -CLOCK))
            off = UP * float(np.sum(pieces.gap[n]))
            self.slack = arb(0, off) + arb(0, UP * (float(known.sigma[n]) + step.r)) * unit
            self.rows = [arb_poly([arb(float(c)) for c in row]) for row in pieces.near[n].T]
        self.signs: dict[int, int] = {}

    def coarse(self, tau: Any) -> list[Any]:
        """The exact states at all tau of a ball."""
        return [row(tau) + self.slack for row in self.rows]

    @cached_property
    def polynomials(self) -> list[arb_poly]:
        """The approximation of the step."""
        with ctx.workprec(self.bits):
            return approximation(self.known, self.n)

    def fine(self, tau: Any) -> list[Any]:
        """The exact states at all tau of a ball, as sharply as the proof allows."""
        return widened(self.polynomials, tau, [self.step.r] * 6, self.known.problem.noise)

    def value(self, at: int) -> Any:
        """g at one point, likewise."""
        with ctx.workprec(self.bits):
            return self.g.at(self.fine(arb((at, -GRAIN))))

    def sign(self, at: int) -> int:
        """The certified sign of g at a point; 0 where there is none."""
        if at not in self.signs:
            with ctx.workprec(_COARSE):
                value = self.g.at(self.coarse(arb((at, -GRAIN))))
            if value.contains(0):
                value = self.value(at)
            self.signs[at] = _sign(value)
        return self.signs[at]

    def split(self, a: int, b: int) -> int:
        """A point inside an interval, where g has a sign if one is easily found."""
        for k in range(4):
            middle = a + (b - a) * (_SPLIT[0] + 37 * k) // _SPLIT[1]
            if self.sign(middle):
                break
        return middle

    def time(self, at: int) -> Any:
        """The time at a point of the step."""
        times = self.known.pieces.times
        with ctx.workprec(self.bits):
            return arb((times[self.n], -CLOCK)) + arb((at, -GRAIN)) * self.h

    def decide(self, a: int, b: int) -> Crossing | _Part | str:
        """EMPTY, a zero, an interval that has no sign at a boundary of the step, SPLIT or OPEN."""
        with ctx.workprec(_COARSE):
            over = _ball(a, b)
            states = self.coarse(over)
            value, slope = self.g.at(states), self.rate.at(states)
            if not value.contains(0):
                return EMPTY
            if a == 0 and self.first is not None:
                return SPLIT if self.first.at(states).contains(0) else EMPTY
            steep = not slope.contains(0)
        if not steep and b - a < _SMALL and self._away(a, b):
            return EMPTY
        left, right = self.sign(a), self.sign(b)
        if not steep:
            return OPEN if not (left or right) and self._flat(a, b) else SPLIT
        if not (left or a == 0) or not (right or b == WHOLE):
            return SPLIT if left or right else OPEN
        if left == right != 0:
            return EMPTY
        where = self._newton(a, b, slope)
        if not (left and right):
            return _Part(left or right, _sign(slope), where, self.time(a), self.time(b))
        if where is None:
            raise Contradiction("a zero between two signs is nowhere")
        return Crossing(where, _sign(slope))

    def _away(self, a: int, b: int) -> bool:
        """Whether g has no zero on [a, b], by g(m) + h g'(I)(I - m): for contacts that miss."""
        with ctx.workprec(self.bits):
            over = _ball(a, b)
            slope = self.rate.at(self.fine(over)) * self.h
            middle = arb(over.mid())
            value = self.g.at(self.fine(middle))
            return not (value + slope * (over - middle)).contains(0)

    def _flat(self, a: int, b: int) -> bool:
        """Whether g on [a, b] is nowhere far from what its radius at the middle leaves open."""
        value = self.value((a + b) // 2)
        with ctx.workprec(self.bits):
            over = _ball(a, b)
            slope = self.rate.at(self.fine(over)) * self.h
            off = (slope * (over - arb(over.mid()))).abs_upper()
            return bool(value.contains(0) and off <= _FLAT * arb(value.rad()))

    def _newton(self, a: int, b: int, slope: Any) -> Zero | None:
        """Where the zero in [a, b] is, if it has one; None if it has none.

        tau = m - g(m)/(h g'(I)) for the zero in I, whatever m of [0, 1] is taken.
        """
        times = self.known.pieces.times
        with ctx.workprec(self.bits):
            inside, low, high = _ball(a, b), arb((a, -GRAIN)), arb((b, -GRAIN))
            for _ in range(_NEWTONS):
                middle = arb(inside.mid())
                middle = low if middle < low else high if middle > high else middle
                sharper = self.rate.at(self.fine(inside.union(middle)))
                if not sharper.contains(0):
                    slope = sharper
                value = self.g.at(self.fine(middle))
                nearer = middle - value / (slope * self.h)
                if not nearer.overlaps(inside):
                    return None
                smaller = nearer.intersection(inside)
                if smaller.rad() * 2 > inside.rad():
                    break
                inside = smaller
            state = self.fine(inside)
            return Zero(arb((times[self.n], -CLOCK)) + inside * self.h, tuple(state))


def _ball(a: int, b: int) -> Any:
    """A ball that holds [a, b] of a step's grains, ends included."""
    return arb((a + b, -GRAIN - 1)) + arb(0, float(b - a) * 2.0 ** (-GRAIN - 1))


def _either(zeros: Sequence[Zero]) -> Zero:
    """A zero that is one of these."""
    found = zeros[0]
    with ctx.workprec(_TIMES):
        for time, state in zeros[1:]:
            both = tuple(x.union(y) for x, y in zip(found.state, state, strict=True))
            found = Zero(found.time.union(time), both)
    return found


def _sign(value: Any) -> int:
    return 1 if value > 0 else -1 if value < 0 else 0
