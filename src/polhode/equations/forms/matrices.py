"""Exact matrices of the forms with full inertia, as products with vectors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import Scalar, combination
from polhode.numbers.vectors import Matrix, Vector

OMEGA = ("p", "q", "r")
GAMMA = ("gamma1", "gamma2", "gamma3")
_PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))
_CYCLE = ((1, 2), (2, 0), (0, 1))


def product(left: Matrix, right: Sequence[Sequence[Exact]]) -> list[list[Exact]]:
    """left·right, right of any width."""
    return [
        [
            sum((a * b for a, b in zip(row, column, strict=True)), ZERO)
            for column in zip(*right, strict=True)
        ]
        for row in left
    ]


def turning(matrix: Matrix) -> list[list[Exact]]:
    """x × (matrix·x), one row per component, as coefficients of the :func:`products` of x.

    The coefficients of the squares add up to zero: x2² enters as x2² - x3².
    """
    rows = []
    for a, b in _CYCLE:
        coefficients: dict[tuple[int, int], Exact] = dict.fromkeys(_PAIRS, ZERO)
        for i in range(3):
            for first, second, term in ((a, i, matrix[b][i]), (b, i, -matrix[a][i])):
                pair = (first, second) if (first, second) in coefficients else (second, first)
                coefficients[pair] = coefficients[pair] + term
        rows.append([coefficients[pair] for pair in _PAIRS if pair != (2, 2)])
    return rows


def across(vector: Vector) -> Matrix:
    """The matrix of gamma -> gamma × vector."""
    x, y, z = vector
    return (ZERO, z, -y), (-z, ZERO, x), (y, -x, ZERO)


def named(
    rows: Sequence[str], columns: Iterable[str], entries: Sequence[Sequence[Exact]]
) -> dict[str, Exact]:
    """The entries of a matrix that are not zero, as coefficients row.column."""
    coefficients = {
        f"{row}.{column}": x
        for row, line in zip(rows, entries, strict=True)
        for column, x in zip(columns, line, strict=True)
    }
    return {name: x for name, x in coefficients.items() if sign(x) != 0}


def products(names: Sequence[str], vector: Sequence[Scalar]) -> dict[str, Scalar]:
    """x1² - x3², x2² - x3², x2 x3, x3 x1, x1 x2 by name."""
    x, y, z = vector
    square = z * z
    values = (x * x - square, y * y - square, y * z, z * x, x * y)
    return dict(zip(product_names(names), values, strict=True))


def product_names(names: Sequence[str]) -> list[str]:
    """The names of the five products."""
    x, y, z = names
    return [f"{x}{x}-{z}{z}", f"{y}{y}-{z}{z}", y + z, z + x, x + y]


def rates(
    names: Sequence[str], terms: Mapping[str, Scalar], k: Mapping[str, Scalar], zero: Scalar
) -> list[Scalar]:
    """For each name the combination of the terms with the coefficients name.term."""
    return [combination(k, zero, *((f"{n}.{t}", x) for t, x in terms.items())) for n in names]


def turning_rates(vector: Sequence[Scalar], omega: Sequence[Scalar]) -> list[Scalar]:
    """vector × omega, the rates in body axes of what is fixed in space, as gamma is."""
    (p, q, r), (g1, g2, g3) = omega, vector
    return [r * g2 - q * g3, p * g3 - r * g1, q * g1 - p * g2]
