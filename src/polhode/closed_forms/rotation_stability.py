"""The spectrum of a permanent rotation, decided exactly.

The linearised equations of (w, gamma) at a permanent rotation have the characteristic polynomial
lam^2 (lam^4 + b lam^2 + d) with, J being their matrix,

    b = -tr J^2/2,    d = (tr J^2)^2/8 - tr J^4/4.

All lam are imaginary and, but for lam = 0, simple if b > 0, d > 0 and b^2 > 4d.  One has a positive
real part if b < 0, d < 0 or b^2 < 4d.  What is left is not decided by the linear equations:
d = 0 <= b, or b^2 = 4d.
"""

from __future__ import annotations

from collections.abc import Sequence

from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import Scalar

STABLE, UNSTABLE, UNDECIDED = "spectrally stable", "unstable", "stability undecided"

_CYCLE = ((1, 2), (2, 0), (0, 1))


def verdict(b: Exact, d: Exact) -> str:
    """STABLE, UNSTABLE or UNDECIDED."""
    signs = sign(b), sign(d), sign(b * b - 4 * d)
    if min(signs) < 0:
        return UNSTABLE
    return STABLE if min(signs) > 0 else UNDECIDED


def spectrum(
    moments: Sequence[Scalar],
    torque: Sequence[Scalar],
    omega: Sequence[Scalar],
    gamma: Sequence[Scalar],
) -> tuple[Scalar, Scalar]:
    """b and d of a state, for any scalar that has arithmetic, polynomials too.

    Only products of two components of omega, and of one of the torque with one of gamma, enter b,
    and products of two such d: omega and gamma may be scaled by one factor together.
    """
    matrix = jacobian(moments, torque, omega, gamma)
    square = _product(matrix, matrix)
    trace = sum(square[i][i] for i in range(6))
    fourth = sum(square[i][j] * square[j][i] for i in range(6) for j in range(6))
    return -trace / 2, trace * trace / 8 - fourth / 4


def jacobian(
    moments: Sequence[Scalar],
    torque: Sequence[Scalar],
    w: Sequence[Scalar],
    g: Sequence[Scalar],
) -> list[list[Scalar]]:
    """Of I w' = gamma x T - w x I w, gamma' = gamma x w in (w, gamma)."""
    zero = 0 * w[0]
    rows: list[list[Scalar]] = [[zero] * 6 for _ in range(6)]
    for i, (j, k) in enumerate(_CYCLE):
        spin = (moments[j] - moments[k]) / moments[i]
        rows[i][j], rows[i][k] = spin * w[k], spin * w[j]
        rows[i][3 + j], rows[i][3 + k] = torque[k] / moments[i], -torque[j] / moments[i]
        rows[3 + i][3 + j], rows[3 + i][3 + k] = w[k], -w[j]
        rows[3 + i][k], rows[3 + i][j] = g[j], -g[k]
    return rows


def _product(left: list[list[Scalar]], right: list[list[Scalar]]) -> list[list[Scalar]]:
    return [[sum(row[k] * right[k][j] for k in range(6)) for j in range(6)] for row in left]
