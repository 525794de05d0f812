"""From a state of the Kovalevskaya top to its point on the Jacobian.

The variables s1, s2 are the roots of q^2 s^2 + (R/2) s + R1/4, with sg = 2p, pi = p^2 + q^2,

    R = -pi^2 + 2H pi - 2m sg + b,    R1 = -2H pi^2 - b sg^2 + 4m pi sg + 2Hb - 4m^2,

and w_i = T' s_i - N', T = s1 + s2, N = s1 s2, sg' = q r, pi' = q G3, 2q' = -p r + G3 (Kowalevski
1889; Mumford's form of the divisor).  Then A(s1, w1) + A(s2, w2) moves as u(0) + t (0, 1).
Next to q = 0 the w_i are roots of w^2 = -2 (s^2 - k^2) S(s), of either sign.
"""

from __future__ import annotations

import cmath
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import flint

from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.curve import KovalevskayaCurve, principal_roots
from polhode.closed_forms.kovalevskaya.theta.balls import Ball, ball, middle, more_bits
from polhode.closed_forms.kovalevskaya.theta.quadrature import Place, nodes, place
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_NEAR = -24  # |q| below 2^this, in the units of the start: the signs of w_i are left open
_FAR = 4  # |s| beyond this multiple of the branch points: the path comes from infinity

#: s, w; None at infinity.
CurvePoint = tuple[Scalar, Scalar] | None


def divisors(start: KovalevskayaStart, prec: int) -> list[tuple[CurvePoint, CurvePoint]]:
    """The pairs (s1, w1), (s2, w2) that the start may stand for, right to ``prec`` bits.

    One pair, or four next to q = 0, of which only one reproduces the start.
    """
    w, G = start.numbers(3 * prec + 64)
    return divisors_of(start, w, G[2], prec)


def divisors_of(
    start: KovalevskayaStart, w: Sequence[Scalar], G3: Scalar, prec: int
) -> list[tuple[CurvePoint, CurvePoint]]:
    """The same for another state with the integrals of the start."""
    bits = 3 * prec + 64
    with mpmath.workprec(bits):
        p, q, r = w
        H, m, b, k2 = (number(x, bits) for x in (start.H, start.m, start.b, start.k2))
        sg, pi = 2 * p, p * p + q * q
        R = -pi * pi + 2 * H * pi - 2 * m * sg + b
        R1 = -2 * H * pi * pi - b * sg * sg + 4 * m * pi * sg + 2 * H * b - 4 * m * m
        root = mpmath.sqrt(max(mpf(0), R * R / 4 - q * q * R1))
        B = -(R / 2 + (root if R >= 0 else -root)) / 2
        s2 = R1 / (4 * B) if B else mpf(0)
        if not q or mpmath.mag(q) < _NEAR:

            def ordinate(s: Scalar) -> Scalar:
                S = (s + H) * (s * s + b) - 2 * m * m
                return mpmath.sqrt(max(mpf(0), -2 * (s * s - k2) * S))

            choices: list[list[CurvePoint]] = [[(s2, w), (s2, -w)] for w in (ordinate(s2),)]
            if q:
                s1 = B / (q * q)
                w1 = ordinate(s1)
                choices.append([(s1, w1), (s1, -w1)])
            else:
                choices.append([None])
            return [(two, one) for one, two in product(*choices)]
        sg1, pi1, q1 = q * r, q * G3, (G3 - p * r) / 2
        R_1 = -2 * pi * pi1 + 2 * H * pi1 - 2 * m * sg1
        R1_1 = -4 * H * pi * pi1 - 2 * b * sg * sg1 + 4 * m * (pi1 * sg + pi * sg1)
        # T = -R/(2 q^2), N = R1/(4 q^2)
        T_1 = -R_1 / (2 * q * q) + R * q1 / q**3
        N_1 = R1_1 / (4 * q * q) - R1 * q1 / (2 * q**3)
        s1 = B / (q * q)
        return [((s1, T_1 * s1 - N_1), (s2, T_1 * s2 - N_1))]


def starts(curve: KovalevskayaCurve, start: KovalevskayaStart) -> Iterator[Pair]:
    """u(0) for each of the :func:`divisors`, at the precision in force."""
    known: dict[tuple[int, Any], Pair] = {}
    for pair in divisors(start, mpmath.prec):
        total: Pair = (mpf(0), mpf(0))
        for i, point in enumerate(pair):
            if point is None:
                continue
            if (i, point) not in known:
                known[i, point] = image(curve, *point)
            u = known[i, point]
            total = total[0] + u[0], total[1] + u[1]
        yield total


def image(curve: KovalevskayaCurve, s: Scalar, w: Scalar) -> Pair:
    """A(s, w), the integral of (1, s) ds/w from infinity.

    From the nearest branch point a, s' = a + (s - a) x^2, and w' = w x times the product of the
    square roots of (s' - a_k)/(s - a_k); from infinity s' = s/x^2.
    """
    points = curve.points
    if abs(s) > _FAR * max(abs(a) for a in points):
        return _from_infinity(points, s, w)
    j = min(range(5), key=lambda i: abs(s - points[i]))
    a = points[j]
    rest = [points[i] for i in range(5) if i != j]
    A0, A1 = curve.images[j]
    span = s - a
    if not span or not w:
        return A0, A1
    gaps = [s - c for c in rest]
    product: Any = mpf(1)
    for gap in gaps:
        product = product * gap
    bases = [(a - c) / gap for c, gap in zip(rest, gaps, strict=True)]
    slopes = [span / gap for gap in gaps]
    # With real ends every root is of a positive number, or of a conjugate pair.
    plain = not (mpmath.im(a) or mpmath.im(s))
    rule = _unit_nodes([place(c - a, c - s, span) for c in rest])
    ways = [(ball(base), ball(slope)) for base, slope in zip(bases, slopes, strict=True)]
    first, way = ball(a), ball(span)
    total, moment = (flint.arb(0), flint.arb(0)) if plain else (flint.acb(0), flint.acb(0))
    with more_bits():
        if plain:
            first, way = (flint.acb(x).real for x in (first, way))
        for weight, square in rule:
            factors = [base + slope * square for base, slope in ways]
            if plain:
                whole = flint.acb(1)
                for factor in factors:
                    whole *= factor
                term = weight / abs(whole.real).sqrt()
            else:
                term = weight / principal_roots(factors)
            total += term
            moment += term * (first + way * square)
    factor = -w / product
    return A0 + factor * middle(total), A1 + factor * middle(moment)


def _from_infinity(points: tuple[Scalar, ...], s: Scalar, w: Scalar) -> Pair:
    ratios = [a / s for a in points]
    singular = [place(1 / ratio, 1 / ratio - 1, mpf(1)) for ratio in ratios if ratio]
    rule = _unit_nodes(singular)
    gaps = [(ball(1 - ratio), ball(ratio)) for ratio in ratios]
    plain = not mpmath.im(s)
    total, moment = (flint.arb(0), flint.arb(0)) if plain else (flint.acb(0), flint.acb(0))
    with more_bits():
        for weight, square in rule:
            factors = [gap / (1 - ratio * square) for gap, ratio in gaps]
            if plain:  # positive: real factors and conjugate pairs
                whole = flint.acb(1)
                for factor in factors:
                    whole *= factor
                term = weight * abs(whole.real).sqrt()
            else:
                term = weight * principal_roots(factors)
            total += term * square
            moment += term
    over = -2 * s / w
    return over * middle(total), over * s * middle(moment)


def _unit_nodes(squares: list[Place]) -> list[tuple[Ball, Ball]]:
    """Nodes (weight, x^2) for integrals over dx from 0 to 1; singularities at these x^2."""
    singular = []
    for z, rest in squares:
        root = cmath.sqrt(z)
        singular += [(root, rest / (1 + root)), (-root, 1 + root)]
    rule = nodes(singular, periodic=False)
    with more_bits():
        return [(weight * (x * y).sqrt(), x * x) for weight, x, y in rule]
