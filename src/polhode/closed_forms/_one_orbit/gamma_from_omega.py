"""gamma of a motion whose q^2 and r^2 are polynomials in p, the centre of mass on axis 1.

With Mg r0 = (c, 0, 0), q^2 = Q(p), r^2 = R(p), p' = (B - C) q r/A and the energy h, Euler's
equations give

    c gamma1 = h - (A p^2 + B Q + C R)/2,
    c gamma2 = q [(A - B) p - C (B - C) R'/2A],
    c gamma3 = r [(A - C) p + B (B - C) Q'/2A].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from polhode.numbers.exact import Exact
from polhode.numbers.scalars import Scalar
from polhode.numbers.vectors import Vector


def value(polynomial: Sequence[Scalar], x: Scalar) -> Scalar:
    """The value of a polynomial, coefficients from the constant one up (Horner)."""
    total = polynomial[-1]
    for c in reversed(polynomial[:-1]):
        total = total * x + c
    return total


def slope(polynomial: Sequence[Scalar]) -> list[Scalar]:
    """The derivative's coefficients."""
    return [n * c for n, c in enumerate(polynomial)][1:]


@dataclass(frozen=True)
class GammaOfOmega:
    """gamma as polynomials in p, times q and r; any scalars (:func:`gamma_of_omega`)."""

    one: Sequence[Scalar]
    two: Sequence[Scalar]
    three: Sequence[Scalar]
    Q: Sequence[Scalar]
    R: Sequence[Scalar]

    def gamma(self, p: Scalar, q: Scalar, r: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """gamma1, gamma2, gamma3."""
        return value(self.one, p), q * value(self.two, p), r * value(self.three, p)

    def squares(self, p: Scalar) -> tuple[Scalar, Scalar]:
        """q^2 and r^2."""
        return value(self.Q, p), value(self.R, p)

    def mapped(self, convert: Callable[[Exact], Scalar]) -> GammaOfOmega:
        """The same with its numbers converted."""
        rows = (self.one, self.two, self.three, self.Q, self.R)
        return GammaOfOmega(*([convert(x) for x in row] for row in rows))


def gamma_of_omega(
    moments: Vector, c: Exact, h: Exact, Q: Sequence[Exact], R: Sequence[Exact]
) -> GammaOfOmega:
    """The polynomials, exact; the degree of R is not below that of Q, nor below 2."""
    A, B, C = moments
    one = [-C * x / (2 * c) for x in R]
    for n, x in enumerate(Q):
        one[n] = one[n] - B * x / (2 * c)
    one[0], one[2] = one[0] + h / c, one[2] - A / (2 * c)
    two = [-C * (B - C) * x / (2 * A * c) for x in slope(R)]
    three = [B * (B - C) * x / (2 * A * c) for x in slope(Q)]
    two[1] = two[1] + (A - B) / c
    three[1] = three[1] + (A - C) / c
    return GammaOfOmega(one, two, three, Q, R)
