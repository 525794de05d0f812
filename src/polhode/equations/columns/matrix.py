"""The rotation matrix, body to space, row by row: R(q) of (3.34)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from polhode.equations.column import Column
from polhode.numbers.number_types import Functions, Scalar
from polhode.numbers.vectors import rotation


def _rows(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> Sequence[Scalar]:
    return rotation(x)


COLUMN: Final = Column(_rows, not_judged="the quaternion is")
