"""A scene's motion by a textbook's formulas, in the scene's axes: its digits repeat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from polhode.closed_forms.membership.principal_scene import PrincipalScene, in_principal_axes
from polhode.closed_forms.rounding import SPARE
from polhode.closed_forms.textbook import euler, kovalevskaya, lagrange
from polhode.numbers.conversion import to_mpf
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.scenes.body import IDENTITY
from polhode.scenes.scene import Scene

_GUARD, _GUARD_OF_SERIES = 15, 10  # digits beyond those asked for
_TRIES = 5
_MOTIONS = {"euler": euler, "lagrange": lagrange, "kovalevskaya": kovalevskaya}


def states(
    scene: Scene, family: str, regime: str, times: Sequence[Exact], digits: int
) -> list[list[mpf]]:
    """Rows p q r [gamma1 gamma2 gamma3] in the scene's axes, one a time.

    ``family``: euler, lagrange or kovalevskaya, to which the scene belongs; ``regime``: the name of
    the motion.  The rows are those of two working precisions that agree to 10^-digits, of w
    relative to its largest modulus.

    Raises ValueError for a motion that the formulas do not have, ArithmeticError where no two
    precisions agree.
    """
    principal = in_principal_axes(scene)
    # equal roots, and turning points at t = 0, cost half of the digits; series are dear
    guard, working = _GUARD, 2 * (digits + _GUARD)
    if family == "kovalevskaya":
        guard, working = _GUARD_OF_SERIES, digits + _GUARD_OF_SERIES
    before, why = None, "no two of which agree"
    for more in range(_TRIES):
        with mpmath.workdps(working + guard * (2**more - 1)):
            try:
                rows = _rows(scene, principal, family, regime, times)
            except ArithmeticError as fault:
                before, why = None, str(fault)
                continue
            if before is not None and _agree(before, rows, mpmath.mpf(10) ** -(digits + 1)):
                return [_shortened(row, digits) for row in rows]
            before = rows
    raise ArithmeticError(f"{_TRIES} working precisions, {why}")


def _shortened(row: list[mpf], digits: int) -> list[mpf]:
    """Rounded to the digits after the units' place of the largest and a little more."""
    bits = math.ceil(digits * math.log2(10)) + SPARE
    with mpmath.workprec(bits + max([0, *(mpmath.mag(x) for x in row if x)])):
        return [+x for x in row]


def _rows(
    scene: Scene, principal: PrincipalScene, family: str, regime: str, times: Sequence[Exact]
) -> list[list[mpf]]:
    """The rows at the precision in force; gamma, where it is not given, is any."""

    def vector(v: Sequence[Exact]) -> Any:
        return mpmath.matrix([to_mpf(x, mpmath.prec) for x in v])

    moments, torque, omega = map(vector, principal[:3])
    gamma = vector(principal.gamma or IDENTITY[2])
    own = _axes(family, moments, torque, omega)
    along = [sum(a * x * x for a, x in zip(moments, row, strict=True)) for row in own.tolist()]
    size = mpmath.norm(torque)
    state = _MOTIONS[family].motion(along, size, own * omega, own * gamma, regime)
    back = (own * mpmath.matrix([[*vector(row)] for row in scene.body.axes.rows])).T
    width = 3 if principal.gamma is None else 6
    found = []
    for t in vector(times):
        row = state(t)
        w, g = (back * mpmath.matrix(v) for v in (row[:3], row[3:]))
        found.append([*w, *g][:width])
    return found


def _axes(family: str, moments: Any, torque: Any, omega: Any) -> Any:
    """Rows of the family's axes in the principal ones.

    Euler's third is the one that the polhode circles, the second that of the middle moment;
    Lagrange's third and Kovalevskaya's first go through the centre of mass, and Kovalevskaya's
    third is that of the smallest moment.
    """
    unit = [mpmath.eye(3)[:, k] for k in range(3)]
    order = sorted(range(3), key=lambda k: moments[k])
    if family == "kovalevskaya":
        first, third = torque, unit[order[0]]
    elif family == "lagrange":
        first, third = _cross(unit[min(range(3), key=lambda k: abs(torque[k]))], torque), torque
    else:
        middle = moments[order[1]]
        excess = sum(a * (a - middle) * x * x for a, x in zip(moments, omega, strict=True))
        first, third = unit[order[0 if excess >= 0 else 2]], unit[order[2 if excess >= 0 else 0]]
    first, third = first / mpmath.norm(first), third / mpmath.norm(third)
    return mpmath.matrix([[*first], [*_cross(third, first)], [*third]])


def _cross(a: Any, b: Any) -> Any:
    """The vector product."""
    return mpmath.matrix([a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)])


def _agree(rows: list[list[mpf]], others: list[list[mpf]], goal: mpf) -> bool:
    """Whether all differences, of w over its largest modulus in these rows, are below the goal.

    Each is asked: the largest of several would pass over one that is not a number.
    """
    rate = max(mpmath.norm(row[:3]) for row in others) or 1
    pairs = [
        abs(x - y) / (rate if k < 3 else 1)
        for row, other in zip(rows, others, strict=True)
        for k, (x, y) in enumerate(zip(row, other, strict=True))
    ]
    return all(x < goal for x in pairs)
