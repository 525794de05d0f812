"""The axes in which a motion is solved, and those of the scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from polhode.numbers.exact import Exact, total

_ODD = ((0, 2, 1), (1, 0, 2), (2, 1, 0))


@dataclass(frozen=True)
class MotionAxes:
    """``rows[i]`` is principal axis i in the scene's axes (None: the same axes).

    Axis n of the motion is principal axis ``order[n]``; where that is an odd permutation, axis 2 is
    reversed, so that the frame stays right-handed.
    """

    rows: tuple[tuple[Any, ...], ...] | None
    order: tuple[int, ...] = (0, 1, 2)

    def principal(self, vector: Sequence[Exact]) -> tuple[Exact, ...]:
        """From the scene's axes to the principal ones."""
        if self.rows is None:
            return tuple(vector)
        return tuple(total(a * x for a, x in zip(row, vector, strict=True)) for row in self.rows)

    def numbered(self, vector: Sequence[Exact]) -> tuple[Exact, ...]:
        """From the scene's axes to those numbered for the motion."""
        principal = self.principal(vector)
        a, b, c = (principal[i] for i in self.order)
        return a, (-b if self.order in _ODD else b), c

    def scene(self, vector: Sequence[Any]) -> list[Any]:
        """From the axes numbered for the motion to the scene's; any scalars."""
        principal: list[Any] = [None] * 3
        for i, x in zip(self.order, vector, strict=True):
            principal[i] = x
        if self.order in _ODD:
            principal[self.order[1]] = -principal[self.order[1]]
        if self.rows is None:
            return principal
        a, b, c = principal
        return [a * x + b * y + c * z for x, y, z in zip(*self.rows, strict=True)]

    def mapped(self, convert: Any) -> MotionAxes:
        """The same with the rows' numbers converted."""
        if self.rows is None:
            return self
        return replace(self, rows=tuple(tuple(convert(x) for x in row) for row in self.rows))
