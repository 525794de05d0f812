"""An integration that shares nothing with the package: power series of the motion, in plain mpmath.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w

for any inertia matrix in any body axes, with the attitude quaternion (body -> space, scalar first)
where asked for.  Every step sums the Taylor series of the solution to an order and over a
length chosen so that the last terms are below the working precision; the working precision carries
20 digits more than are asked for, and the test of the series is that two precisions agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from polhode.numbers.mpmath_context import mpf, mpmath
from shared import fast_series
from shared.plain_taylor import length, total

Matrix = Sequence[Sequence[Any]]


def integrate(
    inertia: Any,
    omega: Sequence[Any],
    gamma: Sequence[Any],
    times: Sequence[Any],
    digits: int,
    *,
    torque: Sequence[Any] = (0, 0, 0),
    quaternion: Sequence[Any] | None = None,
) -> list[list[mpf]]:
    """Rows p, q, r, g1, g2, g3 [, q0, q1, q2, q3], one a time; the times go away from 0.

    ``inertia`` is three principal moments or a 3x3 matrix, ``torque`` is Mg r0.  Numbers are
    anything exact: ints, Fractions, decimal strings, or mpf.  The error is about 10^-digits while
    the motion does not amplify errors by more than 10^10.  About principal axes and
    with numbers of order 1, the same series are summed in integers (:mod:`.fast_series`).
    """
    if not isinstance(inertia[0], (list, tuple)):
        with mpmath.workdps(digits + 40):
            given = [[number(x) for x in row] for row in (inertia, torque, omega, gamma, times)]
            turn = None if quaternion is None else [number(x) for x in quaternion]
        if _of_order_one(given):
            found = fast_series.integrate(*given, digits + 5, turn)
            with mpmath.workdps(digits + 5):
                return [[+x for x in row[: 6 if turn is None else 10]] for row in found]
    with mpmath.workdps(digits + 20):
        state = [number(x) for x in (*omega, *gamma)]
        if quaternion is not None:
            state += [number(x) for x in quaternion]
        if not isinstance(inertia[0], (list, tuple)):
            inertia = [[x if i == j else 0 for j in range(3)] for i, x in enumerate(inertia)]
        tensor = mpmath.matrix([[number(x) for x in row] for row in inertia])
        body = (tensor.tolist(), (tensor**-1).tolist(), [number(x) for x in torque])
        order = int(1.15 * mpmath.prec * 0.69 / 2) + 10  # terms fall as e^-2
        now, rows = mpf(0), []
        for time in map(number, times):
            while now != time:
                series = _series(state, body, order)
                step, left = length(mpmath, series), time - now
                step = left if abs(left) <= step else mpmath.sign(left) * step
                state = [total(row, step) for row in series]
                now = time if step == left else now + step
            rows.append([*state])
    with mpmath.workdps(digits + 5):
        return [[+x for x in row] for row in rows]


def _of_order_one(given: list[list[mpf]]) -> bool:
    """Whether integers in units of 2^-bits keep the digits: nothing large, |w| not small."""
    moments, torque, omega, gamma, _ = given
    size = max(abs(x) for x in (*moments, *torque, *omega, *gamma))
    return size < 32 and min(moments) > mpf(1) / 32 and max(abs(x) for x in omega) > mpf(1) / 32


def number(x: Any) -> mpf:
    """An exact number as mpf, at the precision in force."""
    if isinstance(x, Fraction):
        return mpf(x.numerator) / x.denominator
    return mpf(x)


def _series(state: list[mpf], body: Any, order: int) -> list[Any]:
    """Taylor coefficients of every component, by Cauchy products."""
    inertia, inverse, torque = body
    x: list[list[mpf]] = [[c] for c in state]
    momentum: list[list[mpf]] = [[], [], []]
    heavy = any(torque)

    def times(a: list[mpf], b: list[mpf], n: int) -> mpf:
        return mpmath.fdot(a[: n + 1], b[n::-1])

    for n in range(order):
        w, g = x[0:3], x[3:6]
        for i in range(3):
            momentum[i].append(mpmath.fsum(inertia[i][j] * w[j][n] for j in range(3)))
        moment = [times(momentum[b], w[c], n) - times(momentum[c], w[b], n) for b, c in CYCLE]
        if heavy:
            for i, (b, c) in enumerate(CYCLE):
                moment[i] += g[b][n] * torque[c] - g[c][n] * torque[b]
        new = [mpmath.fdot(inverse[i], moment) for i in range(3)]
        new += [times(g[b], w[c], n) - times(g[c], w[b], n) for b, c in CYCLE]
        if len(x) == 10:
            q = x[6:10]
            new += [
                -(times(q[1], w[0], n) + times(q[2], w[1], n) + times(q[3], w[2], n)) / 2,
                (times(q[0], w[0], n) + times(q[2], w[2], n) - times(q[3], w[1], n)) / 2,
                (times(q[0], w[1], n) + times(q[3], w[0], n) - times(q[1], w[2], n)) / 2,
                (times(q[0], w[2], n) + times(q[1], w[1], n) - times(q[2], w[0], n)) / 2,
            ]
        for row, c in zip(x, new, strict=True):
            row.append(c / (n + 1))
    return x


CYCLE = ((1, 2), (2, 0), (0, 1))
