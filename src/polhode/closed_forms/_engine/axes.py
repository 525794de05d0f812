"""The axes in which a motion is solved, and those of the scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from polhode.closed_forms.functions.rounding import number
from polhode.numbers.exact import Exact, total
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector

#: rows[i] is principal axis i in the scene's axes.
Rows = tuple[tuple[Exact, ...], ...]

#: Axes as rows of components, of any scalars.
RowMatrix = Sequence[Sequence[Scalar]]


def principal(rows: Rows | None, vector: Sequence[Exact]) -> Vector:
    """From the scene's axes to the principal ones, exactly; ``rows`` None: the same axes."""
    if rows is None:
        a, b, c = vector
    else:
        a, b, c = (total(x * y for x, y in zip(row, vector, strict=True)) for row in rows)
    return a, b, c


def in_scene(turn: RowMatrix, rows: Rows | None, bits: int) -> RowMatrix:
    """Axes given by rows in principal axes, by rows in the scene's; rounded to ``bits`` bits."""
    if rows is None:
        return turn
    known = [[number(x, bits) for x in row] for row in rows]
    with mpmath.workprec(bits):
        return [[sum(t[k] * known[k][j] for k in range(3)) for j in range(3)] for t in turn]


def placed(matrix: RowMatrix, vector: Sequence[Scalar]) -> list[Scalar]:
    """From axes given by rows to those they are given in; any scalars.  0 and 1 cost nothing."""
    found = []
    for column in range(3):
        whole: Any = None
        for row, x in zip(matrix, vector, strict=True):
            e = row[column]
            if not e:
                continue
            term = x if e == 1 else -x if e == -1 else e * x
            whole = term if whole is None else whole + term
        found.append(whole)
    return found


@dataclass(frozen=True)
class MotionAxes:
    """``rows[i]`` is principal axis i in the scene's axes (None: the same axes)."""

    rows: tuple[tuple[Scalar, ...], ...] | None

    def principal(self, vector: Sequence[Exact]) -> tuple[Exact, ...]:
        """From the scene's axes to the principal ones."""
        return principal(self.rows, vector)

    def scene(self, vector: Sequence[Scalar]) -> list[Scalar]:
        """From the principal axes to the scene's; any scalars."""
        if self.rows is None:
            return list(vector)
        a, b, c = vector
        return [a * x + b * y + c * z for x, y, z in zip(*self.rows, strict=True)]

    def mapped(self, convert: Any) -> MotionAxes:
        """The same with the rows' numbers converted."""
        if self.rows is None:
            return self
        return replace(self, rows=tuple(tuple(convert(x) for x in row) for row in self.rows))
