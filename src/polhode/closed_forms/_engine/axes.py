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

_ODD = ((0, 2, 1), (1, 0, 2), (2, 1, 0))


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
    """``rows[i]`` is principal axis i in the scene's axes (None: the same axes).

    Axis n of the motion is principal axis ``order[n]``; where that is an odd permutation, axis 2 is
    reversed, so that the frame stays right-handed.
    """

    rows: tuple[tuple[Scalar, ...], ...] | None
    order: tuple[int, ...] = (0, 1, 2)

    def principal(self, vector: Sequence[Exact]) -> tuple[Exact, ...]:
        """From the scene's axes to the principal ones."""
        return principal(self.rows, vector)

    def numbered(self, vector: Sequence[Exact]) -> tuple[Exact, ...]:
        """From the scene's axes to those numbered for the motion."""
        found = self.principal(vector)
        a, b, c = (found[i] for i in self.order)
        return a, (-b if self.order in _ODD else b), c

    def scene(self, vector: Sequence[Scalar]) -> list[Scalar]:
        """From the axes numbered for the motion to the scene's; any scalars."""
        found: list[Any] = [None] * 3
        for i, x in zip(self.order, vector, strict=True):
            found[i] = x
        if self.order in _ODD:
            found[self.order[1]] = -found[self.order[1]]
        if self.rows is None:
            return found
        a, b, c = found
        return [a * x + b * y + c * z for x, y, z in zip(*self.rows, strict=True)]

    def mapped(self, convert: Any) -> MotionAxes:
        """The same with the rows' numbers converted."""
        if self.rows is None:
            return self
        return replace(self, rows=tuple(tuple(convert(x) for x in row) for row in self.rows))
