"""Rows of a closed form of which every printed digit is right.

A closed form answers to so many digits of the largest |w|, or of 1: a small component then has
fewer digits of its own, and one that is zero may come out as a rounding error.  So it is asked for
more, by what the smallest components lack; what has no digit in common at two precisions is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from polhode.numbers import number_types
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpmath, ordinary, own
from polhode.numbers.scalars import Scalar

_SPARE = 4  # digits beyond the last printed one: the last is then right to 0.5001 of its unit


def right_rows(
    ask: Callable[[Sequence[Exact], int], list[list[Scalar]]], times: Sequence[Exact], printed: int
) -> list[list[Scalar]]:
    """The rows of a closed form at the times, each component to so many digits of its own.

    ``ask``: its question, of times and digits.  None in a row stays None.
    """
    digits = printed + _SPARE
    rows = ask(times, digits)
    lacking = _lacking(rows, digits)
    if not lacking:
        return rows
    finer = ask(times, digits + lacking)
    return [
        [_zero_or(x, y, digits) for x, y in zip(row, fine, strict=True)]
        for row, fine in zip(rows, finer, strict=True)
    ]


def _lacking(rows: list[list[Scalar]], digits: int) -> int:
    """The digits that the smallest component lacks, as far as twice the digits asked for."""
    sizes = [mpmath.mag(x) for row in rows for x in row if x]
    if not sizes:
        return 0
    bits = max(0, *sizes) - min(sizes)
    return min(2 * digits, int(bits * number_types.LOG10_2) + 1) if bits > 3 else 0


def _zero_or(coarse: Scalar, fine: Scalar, digits: int) -> Scalar:
    """The finer value; 0 where it is below what was asked for first and shares no digit with it."""
    if not fine or not coarse:
        return fine
    if mpmath.mag(coarse) >= -digits / number_types.LOG10_2 + 8:
        return fine
    with mpmath.workprec(53):
        alike = abs(own(coarse) - own(fine)) <= abs(own(fine)) / 2
    return fine if alike else ordinary(mpmath.mpf(0))
