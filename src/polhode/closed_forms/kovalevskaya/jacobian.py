"""The Jacobian of the Kovalevskaya curve in balls: periods, Abel's map, characteristics.

The finite branch points are numbered a_1 ... a_5 along a direction
(:func:`polhode.closed_forms.kovalevskaya.place.numbered`). On the segment from a_j to
a_(j+1), w = sqrt(-2) product r_i with r_i = sqrt(s - a_i) for i <= j and i sqrt(a_i - s) for i
> j, principal roots, and I_j is the integral of (1, s) ds/w. With c_j = 2 I_j the cycles c_1,
c_3 | c_2 + c_4, c_4 are a canonical basis a | b, tau = inv(Om_A) Om_B (Mumford, Tata Lectures
on Theta II, IIIa.5). A(.) is the integral from infinity: A(a_5) = I_1 + I_3 and A(a_j) =
A(a_(j+1)) - I_j.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.clocks import Linear, Pair, circle, unit
from polhode.closed_forms.balls.core import TooFewBits, certainly
from polhode.closed_forms.balls.theta2 import (
    CHARACTERISTICS,
    Characteristic,
    Lattice,
    added,
    is_odd,
)
from polhode.closed_forms.kovalevskaya.place import ascending, numbered
from polhode.common.values import cached_property

# --- reduction ------------------------------------------------------------------------------------
#
# Siegel's reduction of a canonical basis of periods of genus two.
#
# Each step is a change of basis by whole numbers, so that doubles may choose it: nothing is to be
# proven but what the balls that are carried along tell in the end.


#: Two periods, each of du = (ds/w, s ds/w).
Columns: TypeAlias = tuple[Pair, Pair]

_LEAST = 1e-6  # steps that gain less would go on for ever by rounding
_SMALL = 0.99  # |tau11| below which the first pair is exchanged
_MOST_STEPS = 1_000


def reduced_basis(first: Columns, second: Columns) -> tuple[Columns, Columns]:
    """The columns of Om_A and Om_B in another basis, tau = inv(Om_A) Om_B nearly reduced."""
    a1, a2 = first
    b1, b2 = second
    for _ in range(_MOST_STEPS):
        t11, t12, t22 = _flat_periods((a1, a2), (b1, b2))
        if t11.imag > t22.imag * (1 + _LEAST):
            a1, a2, b1, b2 = a2, a1, b2, b1
            continue
        n = _whole(t12.imag / t11.imag)
        if n:
            a1, b2 = _plus(a1, a2, n), _plus(b2, b1, -n)
            continue
        n11, n12, n22 = _whole(t11.real), _whole(t12.real), _whole(t22.real)
        if n11 or n12 or n22:
            b1 = _plus(_plus(b1, a1, -n11), a2, -n12)
            b2 = _plus(_plus(b2, a1, -n12), a2, -n22)
            continue
        if abs(t11) < _SMALL:
            a1, b1 = b1, (-a1[0], -a1[1])
            continue
        return (a1, a2), (b1, b2)
    raise TooFewBits


def _flat_periods(first: Columns, second: Columns) -> tuple[complex, complex, complex]:
    """tau in doubles."""
    (a, c), (b, d) = ((complex(x), complex(y)) for x, y in first)
    det = a * d - b * c
    certainly(det == det != 0)
    (t11, t21), (t12, t22) = (
        ((d * x - b * y) / det, (a * y - c * x) / det)
        for x, y in ((complex(u), complex(v)) for u, v in second)
    )
    certainly(t11.imag != 0)
    return t11, (t12 + t21) / 2, t22


def _whole(x: float) -> int:
    """The nearest integer; 0 where that is hardly farther than 0."""
    return round(x) if abs(x) > 0.5 + _LEAST else 0


def _plus(pair: Pair, addend: Pair, n: int) -> Pair:
    return pair[0] + n * addend[0], pair[1] + n * addend[1]


# --- jacobian -------------------------------------------------------------------------------------


_FAR = 4  # |s| beyond this multiple of the branch points: the way comes from infinity

_I = acb(0, 1)


class Jacobian:
    """The Jacobian of the curve with five branch points, at the precision in force.

    ``points`` and ``images``, A(.) of them, are in the order e1, e2, e3, k, -k, and so are
    ``characteristics``: eta with inv(Om_A) A = (b + tau a)/2 modulo the lattice.
    """

    def __init__(self, points: Sequence[acb]) -> None:
        self.points = list(points)
        order = numbered(self.points)
        line = [self.points[i] for i in order]
        segments = [segment(line[j], line[j + 1], line[:j], line[j + 2 :]) for j in range(4)]
        loop1, loop2, loop3, loop4 = ((2 * x, 2 * y) for x, y in segments)
        first = loop1, loop3
        second = (loop2[0] + loop4[0], loop2[1] + loop4[1]), loop4
        self.columns, columns_b = reduced_basis(first, second)
        self.lattice = Lattice(self._period_matrix(columns_b))
        now = segments[0][0] + segments[2][0], segments[0][1] + segments[2][1]
        images = {order[4]: now}
        for j in (3, 2, 1, 0):
            now = now[0] - segments[j][0], now[1] - segments[j][1]
            images[order[j]] = now
        self.images = [images[i] for i in range(5)]
        self.characteristics = [self._characteristic(image) for image in self.images]

    def reduced(self, u: Pair) -> Pair:
        """z = inv(Om_A) u."""
        (a, c), (b, d) = self.columns
        det = a * d - b * c
        return (d * u[0] - b * u[1]) / det, (a * u[1] - c * u[0]) / det

    @cached_property
    def delta(self) -> Characteristic:
        """The characteristic del: the only odd one for which all del + eta are odd."""
        (delta,) = (
            c
            for c in CHARACTERISTICS
            if is_odd(c) and all(is_odd(added(c, eta)) for eta in self.characteristics)
        )
        return delta

    def image(self, s: acb, w: acb) -> Pair:
        """A(s, w).

        From the nearest branch point a, s' = a + (s - a) x^2 and w' = w x times the product of the
        square roots of (s' - a_k)/(s - a_k); from infinity s' = s/x^2.
        """
        size = abs(s).mid()
        if all(size > _FAR * abs(a).mid() for a in self.points):
            return self._from_infinity(s, w)
        # By the middles of balls: doubles tie where two points are closer than 1e-16.
        distances = [abs(s - a).mid() for a in self.points]
        j = min(range(5), key=lambda i: distances[i])
        a, rest = self.points[j], [c for i, c in enumerate(self.points) if i != j]
        whole = acb(1)
        for c in rest:
            whole *= s - c
        step = s - a
        factors = [Linear((a - c) / (s - c), acb(1), step / (s - c)) for c in rest]
        first, second = unit(factors)
        over = w / whole
        A0, A1 = self.images[j]
        return A0 - over * first, A1 - over * (a * first + step * second)

    def _from_infinity(self, s: acb, w: acb) -> Pair:
        factors = [Linear(s / (s - a), acb(1), -a / (s - a)) for a in self.points]
        first, second = unit(factors)
        over = -2 * s / w
        return over * second, over * s * first

    def _period_matrix(self, second: Columns) -> tuple[acb, acb, acb]:
        (t11, t21), (t12, t22) = (self.reduced(column) for column in second)
        if not t12.overlaps(t21):
            certainly(t12.is_finite() and t21.is_finite())
            raise ArithmeticError("the period matrix is not symmetric: its basis is none")
        return t11, (t12 + t21) / 2, t22

    def _characteristic(self, image: Pair) -> Characteristic:
        z = self.reduced((2 * image[0], 2 * image[1]))
        x, y = self.lattice.coordinates(z)
        numbers = [v.unique_fmpz() for v in (*y, *x)]
        whole = [int(n) % 2 for n in numbers if n is not None]
        certainly(len(whole) == 4)
        a1, a2, b1, b2 = whole
        return a1, a2, b1, b2


def segment(a: acb, b: acb, below: Sequence[acb], above: Sequence[acb]) -> Pair:
    """The integral of (1, s) ds/w from a to b, which are branch points.

    s = (a + b)/2 - (b - a)/2 cos phi; ``below`` and ``above``: the other branch points.
    """
    step = b - a
    factors = [Linear(a - c, b - c, step) for c in below]
    factors += [Linear(c - a, c - b, -step) for c in above]
    constant, slope = circle(factors)
    over = -1 / arb(2).sqrt()
    for _ in above:
        constant, slope = -_I * constant, -_I * slope
    return over * constant, over * ((a + b) / 2 * constant - step / 2 * slope)


# --- cycles ---------------------------------------------------------------------------------------
#
# The cycles of the two separation variables of the Kovalevskaya top, and their mean rates.


def rates(points: Sequence[acb]) -> tuple[arb, arb]:
    """Mean rates of s1 and s2: u = (th1 L1 + th2 L2)/2 pi = u(0) + t (0, 1).

    L1 and L2 are the integrals of (1, s) ds/w around their cycles: s1 goes from -infinity to the
    lowest real branch point, s2 between the two highest.
    """
    line = [x.real for x in points if x.imag.is_zero()]
    line = [line[i] for i in ascending(line, range(len(line)))]
    certainly(all(x < y for x, y in pairwise(line)))
    a, c = _unbounded(line[0], points)
    rest = [x for x in points if not x.overlaps(acb(line[-2])) and not x.overlaps(acb(line[-1]))]
    b, d = (2 * x.real for x in segment(acb(line[-2]), acb(line[-1]), rest, []))
    det = abs(a * d - b * c)
    turn = 2 * arb.pi()
    return turn * abs(b) / det, turn * abs(a) / det


def _unbounded(a: arb, points: Sequence[acb]) -> tuple[arb, arb]:
    """Twice the integral of (1, s) ds/|w| from -infinity to a.

    s = a - size (1 + cos phi)/(1 - cos phi).
    """
    gaps = [c - a for c in points if not c.overlaps(acb(a))]
    size = arb(0)
    for gap in gaps:
        size = size.max(abs(gap))
    size = size.mid()
    constant, slope = circle([Linear(acb(2 * size), 2 * gap, 2 * (gap - size)) for gap in gaps])
    below, above = constant.real - slope.real, constant.real + slope.real
    root = 2 * (2 * size).sqrt()
    return root * below, root * (a * below - size * above)
