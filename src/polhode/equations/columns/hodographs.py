"""omega along the axes of space, z up: R(q) omega (3.34)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from polhode.equations.column import Column
from polhode.equations.kinematics import turned
from polhode.numbers.number_types import Functions, Scalar
from polhode.scenes.vocabulary import STATE


def _in_space(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    return turned(x[len(STATE) :], x[:3])


COLUMN: Final = Column(_in_space, not_judged="p q r are")
