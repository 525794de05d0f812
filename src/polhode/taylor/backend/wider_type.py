"""The next wider number type, in which corrections are computed, and ways there and back."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from polhode.numbers.number_types import EXTENDED, QUAD, NumberType, extended_here
from polhode.numbers.rows import Array
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.types import HeyokaNumber

#: Between two number types: a state into an array, an array to a state, one number.
Conversions: TypeAlias = tuple[
    Callable[[Array, Array], None], Callable[[Array], Array], Callable[[HeyokaNumber], HeyokaNumber]
]


def wider(number: NumberType) -> NumberType:
    """The type in which corrections of a run in ``number`` are computed."""
    if number.name == "double" and extended_here():
        return EXTENDED
    if number.flat:
        return QUAD
    return NumberType("mp", number.bits + 64)


def conversions(number: NumberType, wide: NumberType) -> Conversions:
    """Ways between the two types: a state into an array, an array to a state, one number."""
    if wide.name == "extended":
        return np.copyto, lambda row: row.astype(np.float64), np.longdouble
    bits = number.bits

    def widened(x: HeyokaNumber) -> HeyokaNumber:
        return hy.real128(x) if wide.name == "quad" else hy.real(x, wide.bits)

    def narrowed(x: HeyokaNumber) -> HeyokaNumber:
        if number.name == "double":
            return float(x)
        if number.name == "extended":
            high = float(x)
            return np.longdouble(high) + np.longdouble(float(x - hy.real128(high)))
        rounded = hy.real(x, bits)
        return hy.real128(rounded) if number.name == "quad" else rounded

    def load(into: Array, row: Array) -> None:
        for i, x in enumerate(row):
            into[i] = widened(x)

    return load, lambda row: heyoka_numbers.array([narrowed(x) for x in row], number), widened
