"""What a field needs of its scalars: floats, mpmath numbers and expressions alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    pass


class Functions(NamedTuple):
    """What a scalar brings along: its zero, and its elementary functions."""

    zero: Any
    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]


def combination(k: Mapping[str, Any], zero: Any, *terms: tuple[str, Any]) -> Any:
    """Sum of k[name]·x over the terms whose coefficient is there; an absent one is exactly zero."""
    present = [k[name] * x for name, x in terms if name in k]
    return sum(present[1:], present[0]) if present else zero
