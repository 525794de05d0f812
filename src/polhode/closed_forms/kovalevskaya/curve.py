"""The genus-2 curve of the Kovalevskaya top: branch points, type, periods, characteristics.

    w^2 = -2 (s^2 - k^2) S(s),    S(s) = (s + H)(s^2 + b) - 2m^2 = (s - e1)(s - e2)(s - e3)

(Kowalevski 1889; b = a^2 - k^2, symbols as in :mod:`polhode.closed_forms.kovalevskaya.axes`), with
the finite branch points e1, e2, e3, k, -k and the sixth at infinity.

The five are numbered a_1 ... a_5 along a direction exp(i vth), |vth| < pi/2.  On the segment from
a_j to a_(j+1), w = sqrt(-2) product r_i with r_i = sqrt(s - a_i) for i <= j and i sqrt(a_i - s) for
i > j, principal roots, and I_j is the integral of (1, s) ds/w.  With c_j = 2 I_j the cycles c_1,
c_3 | c_2 + c_4, c_4 are a canonical basis a | b, tau = inv(Om_A) Om_B (Mumford, Tata Lectures on
Theta II, IIIa.5).  A(.) is the integral from infinity: A(a_5) = I_1 + I_3 and
A(a_j) = A(a_(j+1)) - I_j.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

import flint

from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.theta.balls import Ball, ball, middle, more_bits
from polhode.closed_forms.kovalevskaya.theta.quadrature import nodes, place
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import (
    Pair,
    SymmetricMatrix,
    reduced,
    solved,
)
from polhode.closed_forms.kovalevskaya.theta.riemann_theta import (
    Characteristic,
    added,
    is_odd,
    whole_parts,
)
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_TILTS = 61  # directions tried
_SMALL = 1e-280


class Unresolved(ArithmeticError):
    """More digits are needed to tell the branch points apart."""


@dataclass(frozen=True)
class KovalevskayaCurve:
    """Branch points a_1 ... a_5, ``order[i]`` telling which: 0, 1, 2 for e's, 3 for k, 4 for -k.

    ``points`` are in the order e1, e2, e3, k, -k.
    """

    points: tuple[Scalar, ...]
    order: tuple[int, ...]

    @property
    def along(self) -> list[Scalar]:
        """a_1 ... a_5."""
        return [self.points[i] for i in self.order]

    @property
    def real(self) -> bool:
        """Whether all branch points are real."""
        return all(isinstance(a, mpf) for a in self.points)

    @cached_property
    def segments(self) -> list[Pair]:
        """The four integrals I_j."""
        return [self._segment(j) for j in range(4)]

    @cached_property
    def periods(self) -> tuple[list[Pair], list[Pair], SymmetricMatrix]:
        """Columns of Om_A and Om_B, reduced, and tau."""
        i1, i2, i3, i4 = ((2 * x, 2 * y) for x, y in self.segments)
        b = [(i2[0] + i4[0], i2[1] + i4[1]), i4]
        return reduced([i1, i3], b)

    @cached_property
    def images(self) -> list[Pair]:
        """A of the points, numbered as ``points``."""
        found: list[Any] = [None] * 5
        i = self.segments
        now = i[0][0] + i[2][0], i[0][1] + i[2][1]
        found[self.order[4]] = now
        for j in (3, 2, 1, 0):
            now = now[0] - i[j][0], now[1] - i[j][1]
            found[self.order[j]] = now
        return found

    def reduced(self, u: Pair) -> Pair:
        """z = inv(Om_A) u."""
        return solved(self.periods[0], u)

    @cached_property
    def characteristics(self) -> list[Characteristic]:
        """eta of the points: inv(Om_A) A = (b + tau a)/2 modulo the lattice."""
        tau = self.periods[2]
        found = []
        for image in self.images:
            z1, z2 = self.reduced(image)
            (x, l), (y, k) = whole_parts(tau, (2 * z1, 2 * z2))
            miss = max(abs(v - n) for v, n in zip((*x, *y), (*l, *k), strict=True))
            if miss > 1e-3:
                raise Unresolved
            found.append((k[0] % 2, k[1] % 2, l[0] % 2, l[1] % 2))
        return found

    @cached_property
    def delta(self) -> Characteristic:
        """The characteristic del: it and all del + eta are odd."""
        etas = self.characteristics
        found = [c for c in _ALL if is_odd(c) and all(is_odd(added(c, eta)) for eta in etas)]
        if len(found) != 1:
            raise Unresolved
        return found[0]

    @cached_property
    def cycles(self) -> tuple[Pair, Pair]:
        """L1 and L2: the integrals of (1, s) ds/w around the cycles of s1 and of s2.

        s1 goes from -infinity to the lowest real branch point, s2 between the two highest.
        """
        line = sorted(a for a in self.points if isinstance(a, mpf))
        return self._unbounded(line[0]), self._bounded(line[-2], line[-1])

    @cached_property
    def frequencies(self) -> Pair:
        """Mean rates of s1 and s2 in their cycles: u = (th1 L1 + th2 L2)/2 pi = u(0) + t (0, 1).

        L1 and L2 are the :attr:`cycles`.
        """
        rates = solved(self.cycles, (mpf(0), 2 * mpmath.pi))
        return abs(rates[0]), abs(rates[1])

    def _bounded(self, a: Scalar, b: Scalar) -> Pair:
        """Twice the integral of (1, s) ds/|w| between real branch points."""
        length = b - a
        others = [c for c in self.points if c not in (a, b)]
        total, moment = flint.arb(0), flint.arb(0)
        rule = nodes([place(c - a, c - b, length) for c in others])
        ends, size = (ball(a), ball(b)), ball(length)
        gaps = tuple([ball(end - c) for c in others] for end in (a, b))
        with more_bits():
            for weight, x, y in rule:
                first = x < y
                shift = size * x if first else -size * y
                whole = flint.acb(1)
                for gap in gaps[0 if first else 1]:
                    whole *= gap + shift
                term = weight / abs(whole.real).sqrt()
                total += term
                moment += term * (ends[0 if first else 1] + shift)
        root = mpmath.sqrt(mpf(2))
        return root * middle(total), root * middle(moment)

    def _unbounded(self, a: Scalar) -> Pair:
        """Twice the integral of (1, s) ds/|w| from -infinity to a: s = a - size x/(1 - x)."""
        gaps = [c - a for c in self.points if c != a]
        size = max(abs(gap) for gap in gaps)
        rule = nodes([place(d, size, d - size) for d in gaps if d != size])
        first, unit, others = ball(a), ball(size), [ball(gap) for gap in gaps]
        total, moment = flint.arb(0), flint.arb(0)
        with more_bits():
            for weight, x, y in rule:
                far, whole = unit * x, flint.acb(1)
                for gap in others:
                    whole *= far + gap * y
                term = weight / abs(whole.real).sqrt()
                total += term * y
                moment += term * (first * y - far)
        root = mpmath.sqrt(2 * size)
        return root * middle(total), root * middle(moment)

    def _segment(self, j: int) -> Pair:
        along = self.along
        a, b = along[j], along[j + 1]
        length = b - a
        others = [(i, c) for i, c in enumerate(along) if i not in (j, j + 1)]
        rule = nodes([place(c - a, c - b, length) for _, c in others])
        real, above = self.real, [i > j for i, _ in others]
        turn = mpc(0, 1) ** (1 + sum(above))
        ends = tuple([ball(end - c) for _, c in others] for end in (a, b))
        first, last, way = ball(a), ball(b), ball(length)
        total, moment = (flint.arb(0), flint.arb(0)) if real else (flint.acb(0), flint.acb(0))
        with more_bits():
            for weight, x, y in rule:
                if x < y:
                    left = way * x
                    s, gaps = first + left, [d + left for d in ends[0]]
                else:
                    right = way * y
                    s, gaps = last - right, [d - right for d in ends[1]]
                if real:
                    g1, g2, g3 = gaps
                    term = weight / abs(g1 * g2 * g3).sqrt()
                else:
                    signed = [-g if up else g for up, g in zip(above, gaps, strict=True)]
                    term = weight / principal_roots(signed)
                total += term
                moment += term * s
        over = 1 / (turn * mpmath.sqrt(mpf(2)) * mpc(0, 1))
        return middle(total) * over, middle(moment) * over


_ALL: list[Characteristic] = list(product((0, 1), repeat=4))  # type: ignore[arg-type]


def principal_roots(factors: Sequence[Ball]) -> Ball:
    """The product of the principal square roots of balls, with one root taken."""
    whole = flint.acb(1)
    angle = 0.0
    for factor in factors:
        whole *= factor
        angle += _angle(factor)
    # Of the middle: across the negative numbers there is no root of a ball.
    root = flint.acb(whole.real.mid(), whole.imag.mid()).sqrt()
    # The principal root of the product differs from the wanted one by a sign at most.
    turn = (angle / 2 - _angle(root)) / math.pi
    return -root if round(turn) % 2 else root


def _angle(z: Ball) -> float:
    """arg z in doubles, at any magnitude."""
    near = complex(z)
    if abs(near) > _SMALL:
        return math.atan2(near.imag, near.real)
    number = mpc(middle(z))
    re, im = number.real, number.imag
    shift = -max(mpmath.mag(re) if re else -(10**9), mpmath.mag(im) if im else -(10**9))
    return math.atan2(float(mpmath.ldexp(im, shift)), float(mpmath.ldexp(re, shift)))


def curve(start: KovalevskayaStart, prec: int) -> KovalevskayaCurve:
    """The curve at the precision in force; the points with ``prec`` bits.

    Raises Unresolved where the branch points do not stand apart.
    """
    points = branch_points(start, prec)
    return KovalevskayaCurve(points, _numbered(points))


def branch_points(start: KovalevskayaStart, prec: int) -> tuple[Scalar, ...]:
    """e1, e2, e3, k, -k with ``prec`` bits."""
    with mpmath.workprec(prec):
        return (*cubic_roots(start, prec), *_ends(start, prec))


def _ends(start: KovalevskayaStart, prec: int) -> tuple[Scalar, Scalar]:
    k = mpmath.sqrt(number(start.k2, prec + 20))
    return k, -k


def cubic_roots(start: KovalevskayaStart, prec: int) -> tuple[Scalar, Scalar, Scalar]:
    """e1, e2, e3: real ones in ascending order, or the real one and a conjugate pair.

    s^3 + H s^2 + b s + (H b - 2 m^2) by Cardano's and Viete's formulas, at twice the precision: a
    double root costs half the digits.
    """
    with mpmath.workprec(2 * prec + 40):
        H, b, m2 = (number(x, 2 * prec + 80) for x in (start.H, start.b, start.m2))
        shift = H / 3
        p = b - H * H / 3
        q = 2 * shift**3 - shift * b + (H * b - 2 * m2)
        disc = -4 * p**3 - 27 * q * q
        if disc > 0:
            size = 2 * mpmath.sqrt(-p / 3)
            argument = max(mpf(-1), min(mpf(1), 3 * q / (p * size)))
            angle = mpmath.acos(argument) / 3
            third = 2 * mpmath.pi / 3
            roots = sorted(size * mpmath.cos(angle - third * k) - shift for k in range(3))
        else:
            root = mpmath.sqrt(-disc / 108)
            u = -q / 2 - root if q > 0 else -q / 2 + root
            u = mpmath.cbrt(u) if u > 0 else -mpmath.cbrt(-u)
            v = -p / (3 * u) if u else mpf(0)
            half = mpmath.sqrt(mpf(3)) / 2 * (u - v)
            roots = [u + v - shift, mpc(-(u + v) / 2 - shift, half)]
            roots.append(roots[1].conjugate())
    with mpmath.workprec(prec):
        x, y, z = (+root for root in roots)
    return x, y, z


def _numbered(points: Sequence[Scalar]) -> tuple[int, ...]:
    """The order along exp(i vth): vth = 0 if all are real, else with the largest least gap."""
    gaps = [points[i] - points[j] for i in range(5) for j in range(i)]
    if any(not gap for gap in gaps):
        raise Unresolved
    if all(isinstance(a, mpf) for a in points):
        return tuple(sorted(range(5), key=lambda i: points[i]))
    flat = [complex(gap) for gap in gaps]
    best, tilt = -1.0, 0.0
    for n in range(1, _TILTS + 1):
        angle = math.pi * (n / (_TILTS + 1) - 0.5)
        turn = cmath.exp(-1j * angle)
        least = min(abs((turn * gap).real) for gap in flat)
        if least > best:
            best, tilt = least, angle
    turn = mpmath.expj(-tilt)
    return tuple(sorted(range(5), key=lambda i: (turn * points[i]).real))


def kind(start: KovalevskayaStart) -> str:
    """The type of a curve with five different finite branch points: their order on the real line.

    "-" and "+" are the points -k and k, "e" a root of S.
    """
    prec = 128
    while prec <= 1 << 15:
        with mpmath.workprec(prec):
            e = cubic_roots(start, prec)
            k, low = _ends(start, prec)
            real = [(x, "e") for x in e if isinstance(x, mpf)]
            line = sorted([*real, (k, "+"), (low, "-")])
            scale = abs(_size(start, prec))
            least = min(abs(x[0] - y[0]) for x, y in pairwise(line))
            if not isinstance(e[1], mpf):
                least = min(least, abs(e[1].imag))
        if least > mpmath.ldexp(scale, -prec // 3):
            return "".join(name for _, name in line) + ("" if len(real) == 3 else " (complex pair)")
        prec *= 2
    raise Unresolved


def _size(start: KovalevskayaStart, prec: int) -> Scalar:
    """A bound of the branch points' size."""
    H, b, m2, k2 = (abs(number(x, prec)) for x in (start.H, start.b, start.m2, start.k2))
    return 2 * max(H, mpmath.sqrt(b), mpmath.cbrt(H * b + 2 * m2), mpmath.sqrt(k2))
