"""omega along the axes of space, z up: R(q) omega (3.34)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from polhode.equations.column import Column, Texts
from polhode.equations.hodographs import turned
from polhode.numbers.scalars import Functions, Scalar
from polhode.scenes.vocabulary import STATE


def _in_space(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    return turned(x[len(STATE) :], x[:3])


def _both(states: Texts, space: Texts) -> Mapping[str, Texts]:
    """The curve in the body beside the one in space."""
    return {"body": [row[:3] for row in states], "space": space}


COLUMN: Final = Column(
    _in_space,
    not_judged="p q r are",
    as_json=_both,
    from_json=lambda shown: shown["space"],
)
