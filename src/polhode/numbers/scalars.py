"""What a field needs of its scalars: floats, mpmath numbers and expressions alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Set
from typing import Any, NamedTuple, Protocol, SupportsFloat, TypeAlias

from polhode.numbers import exact

#: What a formula is written for: int, Fraction, Irrational, float, numpy's longdouble and arrays,
#: mpmath's mpf, heyoka's expressions.  They have arithmetic in common and no type: mpmath and
#: heyoka bring none along.
Scalar: TypeAlias = Any

#: A number as a user may give it: int, Fraction, float, Decimal, numpy's and mpmath's, all taken
#: exactly; or a text that holds an expression.
AnyNumber: TypeAlias = SupportsFloat | str

#: Three of them, or four: any sequence, an array.
AnyVector: TypeAlias = Iterable[AnyNumber]


class Real(Protocol):
    """A number of any precision as a reference gives it: mpmath's mpf, which has no types."""

    def __float__(self) -> float: ...
    def __abs__(self) -> Real: ...
    def __neg__(self) -> Real: ...
    def __add__(self, other: Real | float, /) -> Real: ...
    def __radd__(self, other: Real | float, /) -> Real: ...
    def __sub__(self, other: Real | float, /) -> Real: ...
    def __rsub__(self, other: Real | float, /) -> Real: ...
    def __mul__(self, other: Real | float, /) -> Real: ...
    def __rmul__(self, other: Real | float, /) -> Real: ...
    def __truediv__(self, other: Real | float, /) -> Real: ...
    def __rtruediv__(self, other: Real | float, /) -> Real: ...
    def __pow__(self, other: Real | float, /) -> Real: ...
    def __lt__(self, other: Real | float, /) -> bool: ...
    def __le__(self, other: Real | float, /) -> bool: ...
    def __gt__(self, other: Real | float, /) -> bool: ...
    def __ge__(self, other: Real | float, /) -> bool: ...


def numbers_given(t: object) -> tuple[list[object], bool]:
    """What was given as one number or several: a list of them, and whether it was several.

    What has no order, a set or a mapping, is no several numbers: whoever reads it refuses it.
    """
    if isinstance(t, (str, bytes, Set, Mapping)) or not isinstance(t, Iterable):
        return [t], False
    if getattr(t, "ndim", 1) == 0:  # an array of no dimension is a number
        return [t], False
    return list(t), True


class Functions(NamedTuple):
    """What a scalar brings along: its zero, its elementary functions, and whole powers."""

    zero: Scalar
    sin: Callable[[Scalar], Scalar]
    cos: Callable[[Scalar], Scalar]
    sqrt: Callable[[Scalar], Scalar]
    power: Callable[[Scalar, int], Scalar] = pow


#: Of exact numbers.
EXACT = Functions(exact.ZERO, exact.sin, exact.cos, exact.sqrt)

#: Of Python's floats.
FLOATS = Functions(0.0, math.sin, math.cos, math.sqrt)


def of_mpmath() -> Functions:
    """Of mpmath's numbers, to the precision at which they are called."""
    from polhode.numbers.mpmath_context import mpmath

    return Functions(mpmath.mpf(0), mpmath.sin, mpmath.cos, mpmath.sqrt)


def of_extended() -> Functions:
    """Of numpy's longdoubles and of arrays of them."""
    import numpy as np

    return Functions(np.longdouble(0), np.sin, np.cos, np.sqrt)


def combination(k: Mapping[str, Scalar], zero: Scalar, *terms: tuple[str, Scalar]) -> Scalar:
    """Sum of k[name]·x over the terms whose coefficient is there; an absent one is exactly zero."""
    present = [k[name] * x for name, x in terms if name in k]
    return sum(present[1:], present[0]) if present else zero
