"""Vectors of mpmath's numbers, and axes as rows of components."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from polhode.numbers.mpmath_context import mpf, mpmath

Row: TypeAlias = list[Any]


def cross(a: Sequence[mpf], b: Sequence[mpf]) -> Row:
    """The vector product a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Sequence[mpf], b: Sequence[mpf]) -> mpf:
    """The scalar product a.b."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def unit(a: Sequence[mpf]) -> Row:
    """The vector over its length."""
    size = mpmath.norm(a)
    return [x / size for x in a]


def along(rows: Sequence[Row], v: Sequence[mpf]) -> Row:
    """The components of a vector along axes."""
    return [dot(row, v) for row in rows]


def back(rows: Sequence[Row], v: Sequence[mpf]) -> Row:
    """From components along axes to those in which the axes are given."""
    return along([*map(list, zip(*rows, strict=True))], v)


def axis(k: int) -> Row:
    """A unit vector of the axes themselves."""
    return [mpmath.mpf(i == k) for i in range(3)]
