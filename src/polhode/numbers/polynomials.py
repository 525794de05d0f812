"""Real roots of rational polynomials, isolated exactly (FLINT) and enclosed to any precision."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from flint import arb, fmpq, fmpq_poly

from polhode.numbers import exact
from polhode.numbers.conversion import to_mpf
from polhode.numbers.exact import Number
from polhode.numbers.mpmath_context import mpf, ordinary

#: flint.fmpq_poly: coefficients ascending.
QPolynomial: TypeAlias = fmpq_poly


class Root(NamedTuple):
    """A real root: a ball that holds no other one, and how often it is one."""

    ball: arb
    multiplicity: int

    @property
    def middle(self) -> Fraction:
        """A rational number in the ball."""
        return middle(self.ball)


def rational(x: Fraction) -> fmpq:
    """A Fraction as FLINT's."""
    return fmpq(x.numerator, x.denominator)


def real_roots(polynomial: QPolynomial) -> list[Root]:
    """The real roots, ascending, in balls of the precision in force; none of the zero polynomial.

    Which of the roots are real is decided exactly, in integers.
    """
    if polynomial.degree() < 1:
        return []
    every: list[Any] = polynomial.complex_roots()
    roots = [Root(root.real, int(m)) for root, m in every if root.imag == 0]
    return sorted(roots, key=lambda root: root.middle)


def middle(ball: arb) -> Fraction:
    """The middle of a ball, exactly."""
    mantissa, exponent = ball.mid().man_exp()
    return exact.binary(int(mantissa), int(exponent))


def nearest(ball: arb, bits: int) -> mpf:
    """The middle of a ball rounded to so many bits, as a plain mpf."""
    return ordinary(to_mpf(middle(ball), bits))


def fraction_near(x: Number, bits: int) -> tuple[Fraction, bool]:
    """x as a Fraction and whether that is x itself; an irrational one has so many bits."""
    if isinstance(x, (int, Fraction)):
        return Fraction(x), True
    return exact.nearest(x, bits), False
