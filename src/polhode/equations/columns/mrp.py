"""Modified Rodrigues parameters of the attitude: the axis times tan(angle/4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from polhode.equations.column import Column
from polhode.numbers.number_types import Functions, Scalar


def _parameters(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    return [part / (x[0] + 1) for part in x[1:]]


COLUMN: Final = Column(_parameters, not_judged="the quaternion is")
