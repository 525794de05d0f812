"""Input that its rounding to doubles alone keeps from being possible, made possible exactly.

An inertia matrix ``R @ D @ R.T`` of numpy is symmetric to some eps, a unit vector of doubles is of
length 1 to as much, and 0.1 + 0.2 is more than what 0.1 and 0.2 add up to.  To 8 eps that is
forgiven, and what was changed is told.  A number that was given as a text is exact: it is not.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from decimal import Decimal
from fractions import Fraction

from polhode.numbers import exact
from polhode.numbers.decimals import brief
from polhode.numbers.exact import ZERO, Exact, Irrational, sign
from polhode.numbers.vectors import Matrix, Vector

#: What is forgiven, relative to the largest number.
GRACE = 8 * Fraction(sys.float_info.epsilon)

_PAIRS = ((0, 1), (0, 2), (1, 2))
_WIDEST = 64  # bits of a longdouble
_FINEST = 1100  # bits of the denominator of the smallest double


def are_rounded(numbers: Iterable[object]) -> bool:
    """Whether some of the numbers that were given are floats, and none is a text."""
    given = [*numbers]
    if any(isinstance(x, str) for x in given):
        return False
    return any(
        not isinstance(x, (Fraction, Irrational, Decimal)) and not hasattr(x, "__index__")
        for x in given
    )


def is_unit_but_for_rounding(numbers: Sequence[object]) -> bool:
    """Whether numbers are all doubles, of length 1 to 8 eps but not exactly."""
    exactly = [x for x in numbers if isinstance(x, (int, float, Fraction))]
    doubles = [Fraction(x) for x in exactly if _is_double(x)]
    square = sum((x**2 for x in doubles), Fraction(-1))
    return len(doubles) == len(numbers) and 0 < abs(square) <= GRACE


def _is_double(x: float | Fraction) -> bool:
    over, under = x.as_integer_ratio()
    small = abs(over).bit_length() <= _WIDEST and under.bit_length() < _FINEST
    return small and under & (under - 1) == 0


def asymmetry(matrix: Matrix) -> tuple[Exact, tuple[int, int]]:
    """The largest difference of two elements across the diagonal, and where it is."""
    pairs = ((matrix[i][j], matrix[j][i], (i, j)) for i, j in _PAIRS)
    gaps = [(abs(x - y), where) for x, y, where in pairs if x is not y and x != y]
    return max(gaps, key=lambda gap: gap[0], default=(ZERO, (0, 0)))


def symmetrised(matrix: Matrix) -> tuple[Matrix, str]:
    """A matrix made symmetric where it is so to 8 eps, and what was changed; else as it is."""
    gap, _ = asymmetry(matrix)
    if gap is ZERO or gap > GRACE * max(abs(x) for row in matrix for x in row):
        return matrix, ""
    a, b, c = ((*((matrix[i][j] + matrix[j][i]) / 2 for j in range(3)),) for i in range(3))
    change = f"inertia made symmetric (elements differed by {brief(gap, 2)} at most: rounding)"
    return (a, b, c), change  # type: ignore[return-value]  # of three elements each


def excess(moments: Vector) -> Exact:
    """By how much the largest principal moment exceeds the sum of the others; 0 if it does not."""
    a, b, c = moments
    over = 2 * max(moments) - (a + b + c)
    return over if sign(over) > 0 else ZERO


def flattened(matrix: Matrix, over: Exact) -> tuple[Matrix, str]:
    """The inertia of a flat body where it is that of one to 8 eps, and what was changed.

    ``over``: by how much the largest principal moment exceeds the sum of the others.  Of a diagonal
    matrix it becomes that sum; to the diagonal of any other is added what it is too much.
    """
    if over > GRACE * max(abs(x) for row in matrix for x in row):
        return matrix, ""
    rows = [[*row] for row in matrix]
    diagonal = all(sign(matrix[i][j]) == 0 for i, j in _PAIRS)
    if diagonal:
        k = max(range(3), key=lambda i: matrix[i][i])
        rows[k][k] = rows[k][k] - over
    else:
        more = over if isinstance(over, Fraction) else _above(over)
        for i in range(3):
            rows[i][i] = rows[i][i] + more
    change = (
        "largest moment made the sum of the others"
        if diagonal
        else "inertia made that of a flat body, by its diagonal"
    )
    a, b, c = (tuple(row) for row in rows)
    told = f"{change} (the largest moment exceeded it by {brief(over, 2)}: rounding)"
    return (a, b, c), told  # type: ignore[return-value]  # of three elements each


def _above(x: Irrational) -> Fraction:
    """A rational a little above a number above 0."""
    return exact.binary(*exact.rounded(x, 30)) * (1 + Fraction(1, 1 << 28))
