"""A scene's motion by a textbook's formulas, in the scene's axes: its digits repeat."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from polhode.closed_forms.membership.principal_scene import PrincipalScene, in_principal_axes
from polhode.closed_forms.rounding import SPARE, number
from polhode.closed_forms.textbook import euler, kovalevskaya, lagrange
from polhode.closed_forms.textbook.legendre import TooFewDigits
from polhode.closed_forms.textbook.vectors import Row, along, axis, back, cross, dot, unit
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.scenes.scene import Scene

_GUARD = 15  # digits beyond those asked for
_TRIES = 5
_PIECES, _CUTS = 6, 4  # of a period for quadratures, and how many more at each try


def states(
    scene: Scene, family: str, regime: str, times: Sequence[Exact], digits: int
) -> list[Row]:
    """Rows p q r [gamma1 gamma2 gamma3] in the scene's axes, one a time.

    ``family``: euler, lagrange or kovalevskaya, to which the scene belongs; ``regime``: the name of
    the motion.  The rows are those of two working precisions, with other cuts of the quadratures,
    that agree to 10^-digits, of w relative to its largest modulus.

    Raises ValueError for a motion that the formulas do not have, ArithmeticError where no two
    precisions agree.
    """
    principal = in_principal_axes(scene)
    # equal roots, and turning points at t = 0, cost half of the digits; quadratures are dear
    working = digits + _GUARD if family == "kovalevskaya" else 2 * (digits + _GUARD)
    before, why = None, "no two of which agree"
    for more in range(_TRIES):
        with mpmath.workdps(working + _GUARD * (2**more - 1)):
            try:
                rows = _rows(scene, principal, family, regime, times, _PIECES + _CUTS * more)
            except TooFewDigits as fault:
                before, why = None, str(fault)
                continue
            if before is not None and _agree(before, rows, mpmath.mpf(10) ** -(digits + 1)):
                return [_shortened(row, digits) for row in rows]
            before = rows
    raise ArithmeticError(f"{_TRIES} working precisions, {why}")


def _shortened(row: Row, digits: int) -> Row:
    """Rounded to the digits after the units' place of the largest and a little more."""
    bits = math.ceil(digits * math.log2(10)) + SPARE
    with mpmath.workprec(bits + max([0, *(mpmath.mag(x) for x in row if x)])):
        return [+x for x in row]


def _rows(
    scene: Scene,
    principal: PrincipalScene,
    family: str,
    regime: str,
    times: Sequence[Exact],
    pieces: int,
) -> list[Row]:
    """The rows at the precision in force."""

    def vector(v: Sequence[Exact]) -> Row:
        return [number(x, mpmath.prec) for x in v]

    moments, torque, omega = map(vector, principal[:3])
    gamma = None if principal.gamma is None else vector(principal.gamma)
    axes = [vector(row) for row in scene.body.axes.rows]
    state: Callable[[mpf], Row]
    if family == "euler" or gamma is None:
        own = [axis(k) for k in range(3)]
        state = euler.motion(moments, omega, gamma, regime)
    else:
        top = family == "lagrange"
        own = _lagrange_axes(torque) if top else _kovalevskaya_axes(moments, torque)
        start = along(own, omega), along(own, gamma)
        first, _, third = (dot(moments, [x * x for x in row]) for row in own)
        weight = mpmath.norm(torque)
        if top:
            state = lagrange.motion(first, third, weight, *start)
        else:
            state = kovalevskaya.motion(weight / third, *start, pieces)
    found = []
    for t in vector(times):
        row = state(t)
        vectors = [back(axes, back(own, row[k : k + 3])) for k in range(0, len(row), 3)]
        found.append([x for v in vectors for x in v])
    return found


def _lagrange_axes(torque: Row) -> list[Row]:
    """The third axis through the centre of mass, the others anyhow."""
    third = unit(torque)
    smallest = min(range(3), key=lambda i: abs(third[i]))
    first = unit(cross(axis(smallest), third))
    return [first, cross(third, first), third]


def _kovalevskaya_axes(moments: Row, torque: Row) -> list[Row]:
    """The first axis through the centre of mass, the third that of the smallest moment."""
    first, third = unit(torque), axis(min(range(3), key=lambda i: moments[i]))
    return [first, cross(third, first), third]


def _agree(rows: list[Row], others: list[Row], goal: mpf) -> bool:
    """Whether all differences, of w over its largest modulus in these rows, are below the goal.

    Each is asked: the largest of several would pass over one that is not a number.
    """
    rate = max(mpmath.norm(row[:3]) for row in others)
    pairs = [
        (abs(x - y) / (rate if k < 3 and rate else 1))
        for row, other in zip(rows, others, strict=True)
        for k, (x, y) in enumerate(zip(row, other, strict=True))
    ]
    return all(x < goal for x in pairs)
