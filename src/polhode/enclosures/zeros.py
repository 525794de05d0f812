"""Zeros of polynomials along the exact motion: at its start, and later, proven or undecided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_poly

from polhode.common.interrupts import NONE, Deadline
from polhode.common.values import cached_property
from polhode.enclosures.fixed_point_problem import CLOCK, UP, ExactMotion
from polhode.enclosures.integral_contraction import Contradiction
from polhode.enclosures.polynomial import BallPolynomial, Polynomial, ball, rate
from polhode.enclosures.step_bound import Bounds
from polhode.enclosures.zonotope import Step, approximation, widened
from polhode.numbers.flint_context import ctx

# --- zero at start --------------------------------------------------------------------------------
#
# Whether a polynomial of the state is 0 at t = 0, how often, and whether it is 0 all along.
#
# Trusted in one thing: ``first_derivative``.  For rational data the derivatives of g along the
# exact motion at t = 0 are fractions: what is 0 of them is 0.


_ORDERS = 24  # Taylor coefficients that are looked at
_MOST_ORDER, _MOST_TERMS = 4, 2000  # of a derivative as a polynomial
_BITS = 2000


def first_derivative(motion: ExactMotion, g: Polynomial) -> Polynomial | None:
    """The first derivative of g along the motion that is not 0 at t = 0, where g is 0 there.

    None where g is not, where that is not decided exactly, or is of too high an order; and where
    the start is a box.
    """
    start = [x for x in motion.start if isinstance(x, Fraction)]
    exactly = len(start) == 6 and all(isinstance(x, Fraction) for x in motion.constants)
    if motion.radii or not (exactly and g.rational):
        return None
    derivative = g
    for order in range(_MOST_ORDER + 1):
        if derivative.at(start):
            return derivative if order else None
        derivative = rate(derivative, motion.field)
        if not 0 < len(derivative.terms) <= _MOST_TERMS:
            return None
    return None


def is_still(motion: ExactMotion, g: Polynomial) -> bool:
    """Whether nothing tells g from 0 all along the motion.

    Not trusted: said of the first Taylor coefficients to many digits, and only where a product of
    as many factors as g has would show, each 0 twice at most.  Those of the motion come one by one
    of x = x(0) + int f(x).
    """
    degree = max(sum(key) for key in g.terms)
    if 2 * degree > _ORDERS:
        return False
    with ctx.workprec(_BITS):
        start = [ball(x, _BITS) for x in motion.start]
        along = g.balls(_BITS)
        if not along.at(start).contains(0):
            return False
        field = [row.balls(_BITS) for row in motion.field]
        x = [arb_poly([value]) for value in start]
        for order in range(1, _ORDERS + 1):
            rates = [arb_poly(row.at(x)).truncate(order) for row in field]
            x = [arb_poly([a]) + row.integral() for a, row in zip(start, rates, strict=True)]
        derivatives = arb_poly(along.at(x))
        return all(derivatives[k].contains(0) for k in range(_ORDERS + 1))


# --- certified zeros ------------------------------------------------------------------------------
#
# Certified zeros of a polynomial g along the exact motion: existence, uniqueness, time.
#
# Trusted. On a step the exact state is in xhat(tau) +- r (``step_bound``), and the derivative of
# g along it is the polynomial g' = grad g · f, so h g' is that by tau. With balls over a closed
# interval I:
#
#     0 not in g(I)                no zero in I;
#     0 not in g'(I)               at most one, and exactly one if g has certified opposite signs at
#                                  the ends; interval Newton I and (m - g(m)/(h g'(I))) tells where.
#
# Otherwise I is split, off its middle; below 2**-40 of a step it is *undecided*, never counted.
# So is one that no splitting decides: g has no certified sign at its ends, and g' is so small
# that g stays within a few radii of its ball at the middle. What is left of a step after
# MOST_PIECES is undecided, too. Undecided intervals that touch are one.
#
# Near a zero g has no certified sign: neighbouring intervals without a point of one between them,
# on both sides of a step's boundary too, are a group. If g' has one sign on all of it, it holds
# one zero where g has opposite signs at its ends, none where they are the same. Every other group
# is undecided, of an interval with a sign of g' only the ball that Newton's steps leave. A group
# that touches the last time stays undecided; one that touches the first does, unless g and its
# first derivatives along the motion are known to be 0 there: if g and k - 1 derivatives are, and
# the k-th is not 0 on [0, b], g has no zero in (0, b].
#
# Ends are multiples of 2**-48 of a step, so that a ball's midpoint and radius hold them exactly.
# Where there is one zero in I, the state then is among those of the step at all times of I.


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


class _Piece(NamedTuple):
    """An interval on which g may have zeros."""

    slope: int  # of g' on it; 0 where it has no certified sign
    zero: Zero | None  # where its zero is, if it has one; None if Newton shows that it has none
    begin: Any
    end: Any


@dataclass
class _Group:
    """Neighbouring pieces without a point between them where g has a certified sign."""

    sign: int  # of g where it begins; 0 where that is not certified
    pieces: list[_Piece] = field(default_factory=list)

    @property
    def slope(self) -> int:
        """The sign of g' on all of it; 0 where it has none."""
        slopes = {piece.slope for piece in self.pieces}
        return slopes.pop() if len(slopes) == 1 else 0


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
    _group: _Group | None = None  # what is open where the search stands
    _sign: int = 0  # of g at the last boundary

    def window(self, bounds: Bounds, steps: Sequence[Step]) -> None:
        """The zeros in a window whose steps have been accepted."""
        for n, step in enumerate(steps):
            self._step(_OnStep(self, bounds, n, step))

    def finish(self) -> None:
        """What is left at the last time is undecided."""
        self._close(0)

    def _step(self, on: _OnStep) -> None:
        sign = on.sign(0)
        if sign * self._sign < 0:
            raise Contradiction("g has two signs on a step's boundary")
        on.signs[0] = sign or self._sign
        if on.signs[0]:
            self._close(on.signs[0])
        pending, pieces = [(0, WHOLE)], 0
        while pending:
            self.deadline.check()
            a, b = pending.pop()
            pieces += 1
            if pieces > MOST_PIECES:
                pending, b, outcome = [], WHOLE, None
            else:
                outcome = on.decide(a, b)
            if outcome == SPLIT and b - a > _FINEST:
                middle = on.split(a, b)
                pending += [(middle, b), (a, middle)]
                continue
            if outcome == EMPTY:  # the sign of g is one, from a on
                self._close(on.sign(b))
                continue
            if not isinstance(outcome, _Piece):
                outcome = _Piece(0, None, on.time(a), on.time(b))
            self._group = self._group or _Group(on.sign(a))
            self._group.pieces.append(outcome)
            if on.sign(b):
                self._close(on.sign(b))
        self._sign = on.sign(WHOLE)

    def _close(self, sign: int) -> None:
        """The open group ends where g has this sign; 0 where that is not certified."""
        group, self._group = self._group, None
        if group is None:
            return
        slope = group.slope
        if not slope * group.sign * sign:
            for piece in group.pieces:
                self._undecided(piece)
        elif group.sign != sign:
            zeros = [piece.zero for piece in group.pieces if piece.zero is not None]
            if not zeros:
                raise Contradiction("a zero between two signs is nowhere")
            self.crossings.append(Crossing(_either(zeros), slope))

    def _undecided(self, piece: _Piece) -> None:
        begin, end = piece.begin, piece.end
        if piece.slope:  # one zero at the most, and only where Newton's steps leave it
            if piece.zero is None:
                return
            with ctx.workprec(_TIMES):
                begin, end = piece.zero.time.lower(), piece.zero.time.upper()
        if self.contacts and not self.contacts[-1].end < begin:
            last = self.contacts.pop()
            begin, end = last.begin, last.end if last.end > end else end
        self.contacts.append(Contact(begin, end))


class _OnStep:
    """g and g' on one step."""

    def __init__(self, search: Search, bounds: Bounds, n: int, step: Step) -> None:
        self.g, self.rate = search.g, search.rate
        self.known, self.n, self.step = bounds, n, step
        self.first = None if bounds.pieces.times[n] else search.first
        self.bits = bounds.problem.noise + 104
        pieces = bounds.pieces
        unit = arb((1, -bounds.problem.noise))
        with ctx.workprec(_COARSE):
            self.h = arb((pieces.times[n + 1] - pieces.times[n], -CLOCK))
            off = UP * float(np.sum(pieces.gap[n]))
            self.slack = arb(0, off) + arb(0, UP * (float(bounds.sigma[n]) + step.r)) * unit
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

    def decide(self, a: int, b: int) -> _Piece | str:
        """EMPTY, SPLIT, OPEN, or what is known of a zero where g' has a sign."""
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
        if left == right != 0:
            return EMPTY
        return _Piece(_sign(slope), self._newton(a, b, slope), self.time(a), self.time(b))

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
    union = zeros[0]
    with ctx.workprec(_TIMES):
        for time, state in zeros[1:]:
            both = tuple(x.union(y) for x, y in zip(union.state, state, strict=True))
            union = Zero(union.time.union(time), both)
    return union


def _sign(value: Any) -> int:
    return 1 if value > 0 else -1 if value < 0 else 0
