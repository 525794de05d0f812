"""The separation variables u and v of Goryachev and Chaplygin's case, each on its interval.

    u = (r + S)/2,  v = (S - r)/2,  S^2 = r^2 + 16(p^2 + q^2),
    x' = x_s/(u + v),  y' = y_s/(u + v),  u = M - D cos x,  v = M - D cos y,

M and D the middle and the half of the interval.  The halves sin(xi/2), cos(xi/2) of the angles

    sin xi = 2q g3/u - g2,  cos xi = (u^2 - H - 4G/u)/2a,
    sin et = 2q g3/v + g2,  cos et = (v^2 - H + 4G/v)/2a

are smooth functions of x and y without branches: the roots at the ends of the interval divide out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms.functions.rounding import log2, number
from polhode.closed_forms.goryachev_chaplygin.axes import GoryachevStart
from polhode.closed_forms.goryachev_chaplygin.regimes import discriminants
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

#: Which functions of the half angle stand before the roots in sin(angle/2) and cos(angle/2).
_FACTORS: dict[str, Callable[[Scalar, Scalar], Scalar]] = {
    "cos half": lambda c, s: c,
    "sin half": lambda c, s: s,
    "sin": lambda c, s: 2 * s * c,
    "one": lambda c, s: 1,
}


@dataclass(frozen=True)
class Variable:
    """One variable z on [low, high]: its speed and the halves of its angle.

    x_s = sqrt(product of ``speed`` factors)/2; a half is its trigonometric factor times the root of
    a product over 4az (2az).  Factors are polynomials c0 + c1 z + c2 z^2 + c3/z.
    """

    low: Scalar
    high: Scalar
    others: tuple[Scalar, ...]  # the other roots of the radicand, for the width of the series
    speed: tuple[Sequence[Scalar], ...]
    sine: tuple[str, Any, tuple[Sequence[Any], ...]]  # factor, constant, polynomials
    cosine: tuple[str, Any, tuple[Sequence[Any], ...]]

    @property
    def middle(self) -> Scalar:
        """M."""
        return (self.low + self.high) / 2

    @property
    def half(self) -> Scalar:
        """D."""
        return (self.high - self.low) / 2

    def at(self, c: Scalar, s: Scalar) -> Scalar:
        """z, from cos(x/2) and sin(x/2)."""
        return self.low + 2 * self.half * s * s

    def rate(self, z: Scalar, sqrt: Callable[[Scalar], Scalar]) -> Scalar:
        """x_s."""
        return sqrt(_product(self.speed, z)) / 2

    def halves(
        self, c: Scalar, s: Scalar, sqrt: Callable[[Scalar], Scalar]
    ) -> tuple[Scalar, Scalar, Scalar]:
        """z, and sin and cos of half its angle."""
        z = self.at(c, s)
        found = []
        for name, constant, factors in (self.sine, self.cosine):
            root = sqrt(constant * _product(factors, z) / z)
            found.append(_FACTORS[name](c, s) * root)
        return z, found[0], found[1]

    def floats(self) -> Variable:
        """The same in doubles; without the other roots."""

        def rows(
            factors: Sequence[Sequence[Scalar]],
        ) -> tuple[tuple[Scalar, ...], ...]:
            return tuple(tuple(float(x) for x in row) for row in factors)

        return Variable(
            float(self.low),
            float(self.high),
            (),
            rows(self.speed),
            (self.sine[0], float(self.sine[1]), rows(self.sine[2])),
            (self.cosine[0], float(self.cosine[1]), rows(self.cosine[2])),
        )


def _product(factors: Sequence[Sequence[Scalar]], z: Scalar) -> Scalar:
    total: Any = 1
    for c0, c1, c2, c3 in factors:
        total = total * (c0 + z * (c1 + z * c2) + (c3 / z if c3 else 0))
    return total


def lost_bits(start: GoryachevStart) -> float:
    """Bits that the roots of the cubics lose where two of them are near each other."""
    scale = 3 * max(log2(start.H), log2(start.a), log2(start.G) * 2 / 3)
    gaps = [log2(d) for d in discriminants(start)]
    return sum(max(0.0, scale - gap) for gap in gaps if gap > float("-inf"))


def cubic_roots(c1: Scalar, c0: Scalar) -> list[Scalar]:
    """The roots of z^3 - c1 z + c0: three real ones ascending, or the real one and the pair.

    Viete's and Cardano's formulas in the angle that is never near its singular point.
    """
    with mpmath.extraprec(32):
        square = 4 * c1**3 - 27 * c0 * c0
        if square >= 0:
            size = 2 * mpmath.sqrt(c1 / 3)
            angle = mpmath.atan2(mpmath.sqrt(square), -c0 * mpmath.sqrt(mpf(27)))
            thirds = [(angle + 2 * mpmath.pi * k) / 3 for k in (1, 2, 0)]
            low, _, high = (size * mpmath.cos(x) for x in thirds)
            # The root next to 0 keeps its digits however small it is.
            return [low, -c0 / (low * high), high]
        size = mpmath.sqrt(abs(c1) / 3)
        if not size:
            one = -mpmath.sign(c0) * mpmath.cbrt(abs(c0))
        elif c1 > 0:
            one = -mpmath.sign(c0) * 2 * size * mpmath.cosh(mpmath.acosh(abs(c0) / 2 / size**3) / 3)
        else:
            one = -2 * size * mpmath.sinh(mpmath.asinh(c0 / 2 / size**3) / 3)
        pair = mpmath.mpc(-one / 2, mpmath.sqrt(3 * one * one / 4 - c1))
        return [one, pair, mpmath.conj(pair)]


def u_variable(start: GoryachevStart, bits: int) -> Variable:
    """u between the positive roots u- and u+ of u^3 - (H -+ 2a)u - 4G."""
    a, H, G = (number(x, bits) for x in (start.a, start.H, start.G))
    low, high = (_positive(H + side * 2 * a, 4 * G) for side in (-1, 1))
    D = (high - low) / 2
    rest = [w for z in (low, high) for w in _quadratic(z, 4 * G / z)]
    e_minus, e_plus = ((4 * G / z, z, 1, 0) for z in (low, high))
    return Variable(
        low,
        high,
        tuple(rest),
        (e_plus, e_minus),
        ("cos half", D / (2 * a), (e_plus,)),
        ("sin half", D / (2 * a), (e_minus,)),
    )


def _positive(c1: Scalar, c0: Scalar) -> Scalar:
    """The only positive root of z^3 - c1 z - c0, c0 > 0."""
    return next(z for z in reversed(cubic_roots(c1, -c0)) if not mpmath.im(z) and z > 0)


def _quadratic(b: Scalar, c: Scalar) -> list[Scalar]:
    """The roots of z^2 + b z + c, b > 0; without cancellation where they are real."""
    far = -b / 2 - mpmath.sqrt(b * b / 4 - c)
    return [c / far, far]


def v_roots(start: GoryachevStart, bits: int) -> tuple[Scalar, Scalar]:
    """v1 <= v2, the positive roots of v^3 - (H + 2a)v + 4G."""
    a, H, G = (number(x, bits) for x in (start.a, start.H, start.G))
    _, one, two = cubic_roots(H + 2 * a, 4 * G)
    return one, two


def v_whole(start: GoryachevStart, bits: int) -> Variable:
    """v between v1 and v2."""
    a, H, G = (number(x, bits) for x in (start.a, start.H, start.G))
    v1, v2 = v_roots(start, bits)
    e = (v1 + v2, 1, 0, 0)
    others = [-(v1 + v2), *cubic_roots(H - 2 * a, 4 * G)]
    D = (v2 - v1) / 2
    # N = v^3 - (H - 2a)v + 4G = v (v^2 - (H - 2a) + 4G/v)
    N = ((0, 1, 0, 0), (2 * a - H, 0, 1, 4 * G))
    return Variable(
        v1,
        v2,
        tuple(others),
        (e, *N),
        ("sin", D * D / (4 * a), (e,)),
        ("one", 1 / (4 * a), N),
    )


def v_part(start: GoryachevStart, bits: int, *, high: bool) -> Variable:
    """v between v1 and w1, or (``high``) between w2 and v2."""
    a, H, G = (number(x, bits) for x in (start.a, start.H, start.G))
    v1, v2 = v_roots(start, bits)
    _, w1, w2 = cubic_roots(H - 2 * a, 4 * G)
    e, f = (v1 + v2, 1, 0, 0), (w1 + w2, 1, 0, 0)
    outer = (-(v1 + v2), -(w1 + w2))
    if high:
        above, over = (-v1, 1, 0, 0), (-w1, 1, 0, 0)
        D = (v2 - w2) / 2
        sine = ("cos half", D / (2 * a), (e, above))
        cosine = ("sin half", D / (2 * a), (f, over))
        return Variable(w2, v2, (*outer, v1, w1), (e, f, above, over), sine, cosine)
    below, under = (v2, -1, 0, 0), (w2, -1, 0, 0)
    D = (w1 - v1) / 2
    sine = ("sin half", D / (2 * a), (e, below))
    cosine = ("cos half", D / (2 * a), (f, under))
    return Variable(v1, w1, (*outer, v2, w2), (e, f, below, under), sine, cosine)


def started(variable: Variable, z: Scalar, sine: Scalar, a: Scalar) -> Scalar:
    """x at the start: atan2(a z sin(angle)/(D x_s), (M - z)/D), in (-pi, pi]."""
    D = variable.half
    speed = variable.rate(z, mpmath.sqrt)
    return mpmath.atan2(a * z * sine / (D * speed), (variable.middle - z) / D)


def width(variable: Variable) -> tuple[Scalar, Scalar]:
    """The least ln|W + sqrt(W^2 - 1)|, W = (M - z')/D over the other roots z', and that z'."""
    best: tuple[Any, Any] = (mpf("inf"), None)
    for z in variable.others:
        W = mpmath.mpc((variable.middle - z) / variable.half)
        root = mpmath.sqrt(W - 1) * mpmath.sqrt(W + 1)
        eta = abs(mpmath.log(abs(W + root)))
        if eta < best[0]:
            best = eta, z
    return best
