"""Siegel's reduction of a canonical basis of periods of genus two.

Each step is a change of basis by whole numbers, so that doubles may choose it: nothing is to be
proven but what the balls that are carried along tell in the end.
"""

from __future__ import annotations

from typing import TypeAlias

from polhode.closed_forms.balls.clocks import Pair
from polhode.closed_forms.balls.core import TooFewBits

#: Two periods, each of du = (ds/w, s ds/w).
Columns: TypeAlias = tuple[Pair, Pair]

_LEAST = 1e-6  # steps that gain less would go on for ever by rounding
_SMALL = 0.99  # |tau11| below which the first pair is exchanged
_MOST_STEPS = 1_000


def reduced_basis(first: Columns, second: Columns) -> tuple[Columns, Columns]:
    """The columns of Om_A and Om_B in another basis, tau = inv(Om_A) Om_B nearly reduced."""
    a1, a2 = first
    b1, b2 = second
    for _ in range(_MOST_STEPS):
        t11, t12, t22 = _flat_periods((a1, a2), (b1, b2))
        if t11.imag > t22.imag * (1 + _LEAST):
            a1, a2, b1, b2 = a2, a1, b2, b1
            continue
        n = _whole(t12.imag / t11.imag)
        if n:
            a1, b2 = _plus(a1, a2, n), _plus(b2, b1, -n)
            continue
        n11, n12, n22 = _whole(t11.real), _whole(t12.real), _whole(t22.real)
        if n11 or n12 or n22:
            b1 = _plus(_plus(b1, a1, -n11), a2, -n12)
            b2 = _plus(_plus(b2, a1, -n12), a2, -n22)
            continue
        if abs(t11) < _SMALL:
            a1, b1 = b1, (-a1[0], -a1[1])
            continue
        return (a1, a2), (b1, b2)
    raise TooFewBits


def _flat_periods(first: Columns, second: Columns) -> tuple[complex, complex, complex]:
    """tau in doubles."""
    (a, c), (b, d) = ((complex(x), complex(y)) for x, y in first)
    det = a * d - b * c
    if not det or det != det:
        raise TooFewBits
    (t11, t21), (t12, t22) = (
        ((d * x - b * y) / det, (a * y - c * x) / det)
        for x, y in ((complex(u), complex(v)) for u, v in second)
    )
    if not t11.imag:
        raise TooFewBits
    return t11, (t12 + t21) / 2, t22


def _whole(x: float) -> int:
    """The nearest integer; 0 where that is hardly farther than 0."""
    return round(x) if abs(x) > 0.5 + _LEAST else 0


def _plus(one: Pair, other: Pair, n: int) -> Pair:
    return one[0] + n * other[0], one[1] + n * other[1]
