"""Forms of the equations of motion: one file a form, each field written once for any scalar.

A form is ``field(state, k, fn)``: the state's components, the exact non-zero coefficients by name
as the run's numbers, and the scalar's own functions.  The same lines feed floats, mpmath numbers
and heyoka expressions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple


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


Field = Callable[[Sequence[Any], Mapping[str, Any], Functions], list[Any]]
