"""Of which number type the cells of a table are: what arrays and lists of floats say themselves."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from polhode.numbers.number_types import DOUBLE, EXTENDED, SINGLE, NumberType

_WIDER = (SINGLE, DOUBLE, EXTENDED)
_KINDS = {"float32": 0, "float": 1, "float64": 1, "longdouble": 2}
_NEUTRAL = ("bool", "int", "NoneType")  # exact in every type, or empty, or refused elsewhere


def type_of(parts: Iterable[Any]) -> NumberType | None:
    """The widest floating-point type of the cells; None where a cell is of no such type.

    ``parts``: arrays, lists or tuples of cells.  Integers and empty cells go with any type.
    """
    widest = -1
    for kind in {kind for part in parts for kind in _kinds(part)}:
        if _is_neutral(kind):
            continue
        if kind.__name__ not in _KINDS:
            return None
        widest = max(widest, _KINDS[kind.__name__])
    return None if widest < 0 else _WIDER[widest]


def _kinds(part: Any) -> set[type]:
    """The classes of the cells of one part."""
    dtype = getattr(part, "dtype", None)
    if dtype is not None and dtype.kind != "O":
        return {dtype.type}
    return {*map(type, part)} if dtype is not None or isinstance(part, (list, tuple)) else {object}


def _is_neutral(kind: type) -> bool:
    return kind.__name__ in _NEUTRAL or kind.__name__.startswith(("int", "uint"))
