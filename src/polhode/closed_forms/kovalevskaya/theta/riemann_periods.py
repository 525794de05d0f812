"""Period matrices of genus 2: tau = inv(Om_A) Om_B, brought near to Siegel's fundamental domain."""

from __future__ import annotations

from collections.abc import Sequence

from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

#: The three entries tau11, tau12, tau22.
SymmetricMatrix = tuple[Scalar, Scalar, Scalar]
Pair = tuple[Scalar, Scalar]

_SLACK = 1e-6
_INSIDE = 0.99


def reduced(
    first: list[Pair], second: list[Pair]
) -> tuple[list[Pair], list[Pair], SymmetricMatrix]:
    """Periods whose tau = inv(Om_A) Om_B is nearly Siegel-reduced, and that tau.

    ``first`` and ``second`` are the columns of Om_A and Om_B.  Im tau becomes Minkowski-reduced,
    |Re tau| <= 1/2 and |tau11| > 0.99, by symplectic changes of the basis of cycles (Siegel 1943;
    Deconinck et al., Math. Comp. 73 (2004) 1417, algorithm in section 4).
    """
    (a1, a2), (b1, b2) = first, second
    for _ in range(1000):
        tau = _quotient((a1, a2), (b1, b2))
        y11, y12, y22 = (t.imag for t in tau)
        if y11 > y22 * (1 + _SLACK):
            a1, a2, b1, b2 = a2, a1, b2, b1
            continue
        step = int(mpmath.nint(y12 / y11)) if abs(y12) > y11 * (1 + _SLACK) / 2 else 0
        if step:  # tau -> U tau U^T, U = ((1, 0), (-step, 1))
            b2 = _plus(b2, b1, -step)
            a1 = _plus(a1, a2, step)
            continue
        n11, n12, n22 = (int(mpmath.nint(t.real)) for t in tau)
        if n11 or n12 or n22:
            b1 = _plus(_plus(b1, a1, -n11), a2, -n12)
            b2 = _plus(_plus(b2, a1, -n12), a2, -n22)
            continue
        if abs(tau[0]) < _INSIDE:
            a1, b1 = b1, (-a1[0], -a1[1])
            continue
        return [a1, a2], [b1, b2], tau
    raise ArithmeticError("a period matrix that does not reduce: more digits are needed")


def solved(columns: Sequence[Pair], right: Pair) -> Pair:
    """x with x1 column1 + x2 column2 = right."""
    (a, c), (b, d) = columns
    det = a * d - b * c
    return (d * right[0] - b * right[1]) / det, (a * right[1] - c * right[0]) / det


def _quotient(first: Sequence[Pair], second: Sequence[Pair]) -> SymmetricMatrix:
    t11, t21 = solved(first, second[0])
    t12, t22 = solved(first, second[1])
    return t11, (t12 + t21) / 2, t22


def _plus(x: Pair, y: Pair, n: int) -> Pair:
    return x[0] + n * y[0], x[1] + n * y[1]
