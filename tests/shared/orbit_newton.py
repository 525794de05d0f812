"""Periodic orbits to twenty-four digits in plain mpmath: Newton's method beside a proof.

It imports nothing of polhode.  The derivative of the flow comes from central differences of
``plain_taylor`` at a step of 1e-8, right to about sixteen digits.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from mpmath import MPContext

from shared import plain_taylor

DIGITS = 24
STEP = Fraction(1, 10**8)
CYCLE = ((0, 1, 2), (1, 2, 0), (2, 0, 1))

Vector = Sequence[Fraction]


class Truth(NamedTuple):
    """Start, period and residue, to about twenty-four and sixteen digits."""

    start: list[Fraction]
    period: Fraction
    residue: Fraction


def flow(moments: Vector, torque: Vector, state: Vector, time: Fraction) -> list[Fraction]:
    """The state after a time."""
    return plain_taylor.integrate(moments, torque, state[:3], state[3:], [time], DIGITS)[0]


def derivative(
    moments: Vector, torque: Vector, state: Vector, time: Fraction
) -> list[list[Fraction]]:
    """Of the state after a time by the start: six rows."""
    columns = []
    for k in range(6):
        ends = []
        for side in (1, -1):
            moved = list(state)
            moved[k] += side * STEP
            ends.append(flow(moments, torque, moved, time))
        columns.append([(a - b) / (2 * STEP) for a, b in zip(*ends, strict=True)])
    return [list(row) for row in zip(*columns, strict=True)]


def rates(moments: Vector, torque: Vector, x: Vector) -> list[Fraction]:
    """The right-hand sides, from the vector equations."""
    w, g = x[:3], x[3:]
    along = [
        ((moments[j] - moments[k]) * w[j] * w[k] + g[j] * torque[k] - g[k] * torque[j]) / moments[i]
        for i, j, k in CYCLE
    ]
    return along + [g[j] * w[k] - g[k] * w[j] for i, j, k in CYCLE]


def corrected(
    moments: Vector,
    torque: Vector,
    level: Vector,
    near: Vector,
    period: Fraction,
    plane: tuple[Vector, Vector],
) -> Truth:
    """One Newton step from an orbit known to twelve digits; its start is on a plane (a, point)."""
    mp = MPContext()
    mp.dps = DIGITS + 10

    def number(x: Fraction) -> Any:
        return mp.mpf(x.numerator) / x.denominator

    d = derivative(moments, torque, near, period)
    end = flow(moments, torque, near, period)
    a, point = plane
    w, g = near[:3], near[3:]
    momentum = [m * x for m, x in zip(moments, w, strict=True)]
    gradients = [
        [*momentum, *torque],
        [*(m * x for m, x in zip(moments, g, strict=True)), *momentum],
        [Fraction(0)] * 3 + [2 * x for x in g],
    ]
    values = [
        sum(m * x for m, x in zip(momentum, w, strict=True)) / 2
        + sum(t * x for t, x in zip(torque, g, strict=True)),
        sum(m * x for m, x in zip(momentum, g, strict=True)),
        sum(x * x for x in g),
    ]
    speed = rates(moments, torque, end)
    rows = [[d[i][j] - (i == j) for j in range(6)] + [speed[i]] for i in range(6)]
    rows += [[*a, Fraction(0)], *([*row, Fraction(0)] for row in gradients)]
    miss = [x - y for x, y in zip(end, near, strict=True)]
    miss.append(sum(x * (y - z) for x, y, z in zip(a, near, point, strict=True)))
    miss += [x - y for x, y in zip(values, level, strict=True)]
    matrix = mp.matrix([[number(x) for x in row] for row in rows])
    # ten equations for seven unknowns, of which three depend on the others at an orbit
    normal = matrix.T * matrix
    step = mp.lu_solve(normal, matrix.T * mp.matrix([number(-x) for x in miss]))
    steps = [plain_taylor.exact(x) for x in step]
    trace = sum(d[i][i] for i in range(6))
    return Truth(
        [x + y for x, y in zip(near, steps, strict=False)], period + steps[6], (6 - trace) / 4
    )
