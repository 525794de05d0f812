"""Polynomials in p q r gamma1 gamma2 gamma3 with exact coefficients: first integrals and events.

Trusted.  A sum is a mapping from six exponents to a coefficient; rational ones are added and
multiplied exactly, so that an identity such as grad H · f = 0 is decided, not estimated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from flint import arb

from polhode.numbers import exact
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx

SIZE = 6
MOST_POWER = 12
_NOTHING = (0,) * SIZE
_ZERO = arb(0)


@dataclass(frozen=True)
class Polynomial:
    """A sum of monomials: ``terms`` maps the exponents of the six variables to a coefficient."""

    terms: Mapping[tuple[int, ...], Exact]

    def __add__(self, other: Polynomial) -> Polynomial:
        terms = dict(self.terms)
        for key, value in other.terms.items():
            terms[key] = terms[key] + value if key in terms else value
        return Polynomial({key: value for key, value in terms.items() if not _is_zero(value)})

    def __mul__(self, other: Polynomial | Exact | int) -> Polynomial:
        factor = other if isinstance(other, Polynomial) else constant(other)
        product = Polynomial({})
        for a, x in self.terms.items():
            moved = {
                tuple(i + j for i, j in zip(a, b, strict=True)): x * y
                for b, y in factor.terms.items()
            }
            product = product + Polynomial(moved)
        return product

    def __neg__(self) -> Polynomial:
        return self * -1

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + -other

    def __truediv__(self, other: Polynomial) -> Polynomial:
        if set(other.terms) != {_NOTHING}:
            raise ValueError("a polynomial is divided by numbers alone")
        return self * (1 / other.terms[_NOTHING])

    def __pow__(self, exponent: int) -> Polynomial:
        if not 0 <= exponent <= MOST_POWER:
            raise ValueError(f"a power of a name lies between 0 and {MOST_POWER}")
        power = constant(1)
        for _ in range(exponent):
            power = power * self
        return power

    def derivative(self, variable: int) -> Polynomial:
        """The partial derivative by one of the six variables."""
        terms: dict[tuple[int, ...], Exact] = {}
        for key, value in self.terms.items():
            if key[variable]:
                lower = (*key[:variable], key[variable] - 1, *key[variable + 1 :])
                terms[lower] = key[variable] * value
        return Polynomial(terms)

    @property
    def rational(self) -> bool:
        """Whether every coefficient is a fraction."""
        return all(isinstance(value, Fraction) for value in self.terms.values())

    def at(self, state: Sequence[Fraction]) -> Any:
        """The exact value at a state of fractions, where the coefficients are fractions."""
        return BallPolynomial(tuple(self.terms.items())).at(state, Fraction(0))

    def balls(self, bits: int) -> BallPolynomial:
        """The same with coefficients as balls of so many bits."""
        return BallPolynomial(tuple((key, ball(x, bits)) for key, x in self.terms.items()))


class BallPolynomial(NamedTuple):
    """The same polynomial with coefficients as balls, for evaluation."""

    terms: tuple[tuple[tuple[int, ...], Any], ...]

    def at(self, state: Sequence[Any], total: Any = _ZERO) -> Any:
        """A ball around the values at every point of a box of six balls; ``total``: its zero."""
        for key, value in self.terms:
            for x, power in zip(state, key, strict=True):
                for _ in range(power):  # x**power is no number where a ball holds 0
                    value = value * x
            total = total + value
        return total


def constant(value: Exact | int) -> Polynomial:
    """A number as a polynomial."""
    number = exact.exact(value)
    return Polynomial({} if _is_zero(number) else {_NOTHING: number})


def variable(index: int) -> Polynomial:
    """One of the six variables."""
    return Polynomial({tuple(int(i == index) for i in range(SIZE)): exact.ONE})


def total(parts: Sequence[Polynomial]) -> Polynomial:
    """The sum of any number of polynomials."""
    return sum(parts, Polynomial({}))


def rate(of: Polynomial, field: Sequence[Polynomial]) -> Polynomial:
    """The derivative grad(of) · field along a polynomial field."""
    return total([of.derivative(i) * field[i] for i in range(SIZE)])


def _is_zero(value: Exact) -> bool:
    # Only an exact zero is dropped: an irrational one stays, as a ball around zero.
    return isinstance(value, Fraction) and value == 0


def ball(x: Exact, bits: int) -> Any:
    """A ball around an exact number, every step carried to so many bits."""
    with ctx.workprec(bits):
        if isinstance(x, Fraction):
            return exact.as_ball(x)
        return x.enclosure(bits)
