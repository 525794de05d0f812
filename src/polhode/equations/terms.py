"""The Euler–Poisson equations in principal axes (3.29) as data: every term, once.

    I_i w_i' = (I_a - I_b) w_a w_b + k_b gamma_a - k_a gamma_b,    k = Mg r0,
    gamma_i' = gamma_a w_b - gamma_b w_a,    i, a, b cyclic.

A row of the equations is a sum of terms, a coefficient times a product of one or two variables; a
coefficient is a sum of the body's numbers over a moment.  From these lists are made: the principal
form, polynomials, defects, derivatives, series and approximate trajectories.  What judges them has
equations of its own: closed forms, the checker of certificates, the integrators of the tests.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Scalar
from polhode.scenes.body import Body
from polhode.scenes.vocabulary import STATE

CYCLE = ((1, 2), (2, 0), (0, 1))  # a and b of each i

#: Of each of the body's numbers, A, B, C and Mg r0 along the principal axes, which power of
#: 1/time it has beside mass and length.
TIMES = (0, 0, 0, 2, 2, 2)
MOMENTS, TORQUE = slice(0, 3), slice(3, 6)  # their places


class Coefficient(NamedTuple):
    """A coefficient by its name: a sum of the body's numbers, with signs, over a moment.

    ``power``: of 1/time that it has, which is that of its numbers.
    """

    name: str
    above: tuple[tuple[int, int], ...]
    below: int
    power: int

    @classmethod
    def of(cls, name: str, above: tuple[tuple[int, int], ...], below: int) -> Coefficient:
        """A coefficient, with the power of its numbers."""
        return cls(name, above, below, TIMES[above[0][1]])


class Term(NamedTuple):
    """A term of a row: of which variables it is the product, and the place of its coefficient.

    Where that is None, its coefficient is ``sign``, 1 or -1.
    """

    row: int
    factors: tuple[int, ...]
    coefficient: int | None = None
    sign: int = 1

    def of(self, coefficients: Sequence[Scalar]) -> Scalar:
        """Its coefficient among those of a body."""
        return self.sign if self.coefficient is None else coefficients[self.coefficient]


#: Of a term of w its coefficient, its row and its factors.
_OfOmega: TypeAlias = tuple[Coefficient, int, tuple[int, ...]]


def _products() -> list[_OfOmega]:
    """The gyroscopic terms."""
    return [
        (Coefficient.of(f"{STATE[i]}.{STATE[a]}{STATE[b]}", ((1, a), (-1, b)), i), i, (a, b))
        for i, (a, b) in enumerate(CYCLE)
    ]


def _weights() -> list[_OfOmega]:
    """The terms of the weight, row by row."""
    weights: list[_OfOmega] = []
    for i, (a, b) in enumerate(CYCLE):
        for sign, arm, gamma in ((1, b, 3 + a), (-1, a, 3 + b)):
            name = f"{STATE[i]}.{STATE[gamma]}"
            weights.append((Coefficient.of(name, ((sign, TORQUE.start + arm),), i), i, (gamma,)))
    return weights


_OF_OMEGA = [*_products(), *_weights()]

#: Every coefficient that a body can have, and their names: in this order wherever they are listed.
COEFFICIENTS = tuple(coefficient for coefficient, _, _ in _OF_OMEGA)
NAMES = tuple(coefficient.name for coefficient in COEFFICIENTS)

#: The terms of each row, p q r gamma1 gamma2 gamma3; those of a row in one order everywhere.
ROWS = (
    *(
        tuple(Term(i, factors, n) for n, (_, row, factors) in enumerate(_OF_OMEGA) if row == i)
        for i in range(3)
    ),
    *(
        (Term(3 + i, (3 + a, b)), Term(3 + i, (3 + b, a), sign=-1))
        for i, (a, b) in enumerate(CYCLE)
    ),
)


#: Those that are products of two variables, and those of one.
PRODUCTS, LINEAR = (
    tuple(term for row in ROWS for term in row if len(term.factors) == n) for n in (2, 1)
)


class Layer(NamedTuple):
    """A term of each of three rows, for arrays: ``rows`` of w, or of gamma.

    ``columns``: where its products are among all of ``LEFT`` times ``RIGHT``; None of a layer of
    single variables, which are ``factors``.
    """

    rows: slice
    terms: tuple[Term, ...]
    factors: list[list[int]]
    columns: slice | None

    def coefficients(self, of: Sequence[Scalar]) -> list[Scalar] | None:
        """Its three coefficients among those of a body; None where they are the terms' sign."""
        places = [term.coefficient for term in self.terms]
        return None if None in places else [of[n] for n in places if n is not None]


def _layers() -> Iterator[Layer]:
    """First terms of the rows of w, second ones, and so on; then those of gamma's."""
    count = 0
    for first in (0, 3):
        for terms in zip(*ROWS[first : first + 3], strict=True):
            factors = [
                list(column) for column in zip(*(term.factors for term in terms), strict=True)
            ]
            columns = slice(count, count + 3) if len(factors) == 2 else None
            count += 3 * (columns is not None)
            yield Layer(slice(first, first + 3), terms, factors, columns)


LAYERS = tuple(_layers())
LEFT, RIGHT = (
    [n for layer in LAYERS if layer.columns for n in layer.factors[side]] for side in (0, 1)
)


def layered(
    products: Scalar, variables: Scalar, coefficients: Sequence[Scalar | None]
) -> list[Scalar]:
    """The rates of w and of gamma, arrays (3, n), of many states at once.

    ``products``: of the variables ``LEFT`` and ``RIGHT``, or of series in their place, (9, n);
    ``variables``: (6, n); ``coefficients``: (3, 1) of each layer that has any.
    """
    rates: dict[int, Scalar] = {}
    for layer, factor in zip(LAYERS, coefficients, strict=True):
        part = variables[layer.factors[0]] if layer.columns is None else products[layer.columns]
        part = part if factor is None else factor * part
        row = layer.rows.start
        if row not in rates:  # of the first terms the sign is 1
            rates[row] = part
        else:
            rates[row] = rates[row] + part if layer.terms[0].sign > 0 else rates[row] - part
    return [*rates.values()]


class Slope(NamedTuple):
    """A part of the derivative of a row by a variable: a term's coefficient times ``other``.

    Where that is None, the term has no other variable.
    """

    row: int
    column: int
    term: Term
    other: int | None


def _slopes() -> list[Slope]:
    """Those of all terms; of a row first by its own kind of variables, w or gamma."""
    slopes = [
        Slope(term.row, n, term, next((m for m in term.factors if m != n), None))
        for row in ROWS
        for term in row
        for n in term.factors
    ]
    return sorted(
        slopes,
        key=lambda at: (
            at.row % 3,
            at.row // 3,
            at.column // 3 != at.row // 3,
            (at.column - at.row) % 3,
        ),
    )


SLOPES = tuple(_slopes())


def numbers_of(body: Body) -> list[Exact]:
    """The body's numbers along its principal axes."""
    return [*body.moments, *body.axes.components(body.torque)]


def coefficients_of(numbers: Sequence[Scalar]) -> list[Scalar]:
    """All coefficients of a body's numbers, for any scalars."""
    coefficients = []
    for _, ((sign, first), *others), below, _ in COEFFICIENTS:
        above = numbers[first] if sign > 0 else -numbers[first]
        for sign, n in others:
            above = above + numbers[n] if sign > 0 else above - numbers[n]
        coefficients.append(above / numbers[below])
    return coefficients


def derivatives_of(numbers: Sequence[Exact], place: int) -> Mapping[str, Exact]:
    """The coefficients' derivatives by the logarithm of one of the body's numbers, by name.

    Those that the number does not enter are left out.
    """
    derivatives: dict[str, Exact] = {}
    values = coefficients_of(numbers)
    for (name, above, below, _), value in zip(COEFFICIENTS, values, strict=True):
        for sign, n in above:
            if n == place:
                derivatives[name] = sign * numbers[n] / numbers[below]
        if below == place:
            derivatives[name] = -value
    return derivatives


def product(state: Sequence[Scalar], factors: Sequence[int]) -> Scalar:
    """The product of one or two variables."""
    first, *others = factors
    value = state[first]
    for n in others:
        value = value * state[n]
    return value
