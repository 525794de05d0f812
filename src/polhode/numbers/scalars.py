"""What a field needs of its scalars: floats, mpmath numbers and expressions alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias

from polhode.numbers import exact

#: What a formula is written for: int, Fraction, Irrational, float, numpy's longdouble and arrays,
#: mpmath's mpf, heyoka's expressions.  They have arithmetic in common and no type: mpmath and
#: heyoka bring none along.
Scalar: TypeAlias = Any

#: A number as a trajectory holds it: float, numpy.longdouble, or mpf above extended.
Value: TypeAlias = Any

#: A row of such numbers, or of heyoka's: an ndarray, or a list above extended.
Row: TypeAlias = Any

#: Several rows: an ndarray of shape (rows, columns), or a list of rows above extended.
Rows: TypeAlias = Any


class Functions(NamedTuple):
    """What a scalar brings along: its zero, and its elementary functions."""

    zero: Scalar
    sin: Callable[[Scalar], Scalar]
    cos: Callable[[Scalar], Scalar]
    sqrt: Callable[[Scalar], Scalar]


#: Of exact numbers.
EXACT = Functions(exact.ZERO, exact.sin, exact.cos, exact.sqrt)

#: Of Python's floats.
FLOATS = Functions(0.0, math.sin, math.cos, math.sqrt)


def of_mpmath() -> Functions:
    """Of mpmath's numbers, to the precision at which they are called."""
    from polhode.numbers.private import mpmath

    return Functions(mpmath.mpf(0), mpmath.sin, mpmath.cos, mpmath.sqrt)


def of_extended() -> Functions:
    """Of numpy's longdoubles and of arrays of them."""
    import numpy as np

    return Functions(np.longdouble(0), np.sin, np.cos, np.sqrt)


def combination(k: Mapping[str, Scalar], zero: Scalar, *terms: tuple[str, Scalar]) -> Scalar:
    """Sum of k[name]·x over the terms whose coefficient is there; an absent one is exactly zero."""
    present = [k[name] * x for name, x in terms if name in k]
    return sum(present[1:], present[0]) if present else zero
