"""The axes in which a motion is solved, and those of the scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from polhode.numbers.exact import Exact, total
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector

#: rows[i] is principal axis i in the scene's axes.
Rows = tuple[tuple[Exact, ...], ...]


def principal(rows: Rows | None, vector: Sequence[Exact]) -> Vector:
    """From the scene's axes to the principal ones, exactly; ``rows`` None: the same axes."""
    if rows is None:
        a, b, c = vector
    else:
        a, b, c = (total(x * y for x, y in zip(row, vector, strict=True)) for row in rows)
    return a, b, c


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
