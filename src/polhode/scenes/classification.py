"""Which classical top a body is, and about which axis: decided here and nowhere else.

With two equal moments A = B, C the third one, T = Mg r0 and the axis of C the third:

    Lagrange                 T along the axis (of three equal moments: anywhere)
    Kovalevskaya             A = 2C, T across the axis
    Goryachev, Chaplygin     A = 4C, T across the axis

All by exact arithmetic on the body's numbers.
"""

from __future__ import annotations

from typing import NamedTuple

from polhode.numbers.exact import sign
from polhode.numbers.vectors import Vector, is_zero
from polhode.scenes.body import Body

EULER, LAGRANGE, SPHERE = "Euler top", "Lagrange top", "Lagrange top (three equal moments)"
KOVALEVSKAYA, CHAPLYGIN = "Kovalevskaya top", "Goryachev-Chaplygin body"
SYMMETRIC = "heavy symmetric body, centre of mass off its axis"
ASYMMETRIC = "heavy asymmetric body"


class ClassicalTop(NamedTuple):
    """``kind``: the body's classical name, one of the seven above.

    ``axis``: the principal axis (0, 1 or 2) of the moment C; of three equal moments the one that
    carries the centre of mass.  None where there is no such axis, and for a body without weight.
    """

    kind: str
    axis: int | None = None


def classical_top(moments: Vector, torque: Vector) -> ClassicalTop:
    """What a body is, by its principal moments and T = Mg r0 in principal axes."""
    if is_zero(torque):
        return ClassicalTop(EULER)
    spherical = moments[0] == moments[1] == moments[2]
    for axis in (2, 0, 1):
        i, j, k = with_last(axis)
        if moments[i] != moments[j]:
            continue
        if sign(torque[i]) == 0 == sign(torque[j]):
            return ClassicalTop(SPHERE if spherical else LAGRANGE, axis)
        if spherical:
            continue
        if sign(torque[k]) == 0 and moments[i] == 2 * moments[k]:
            return ClassicalTop(KOVALEVSKAYA, axis)
        if sign(torque[k]) == 0 and moments[i] == 4 * moments[k]:
            return ClassicalTop(CHAPLYGIN, axis)
        return ClassicalTop(SYMMETRIC, axis)
    return ClassicalTop(SPHERE if spherical else ASYMMETRIC)


def with_last(axis: int) -> tuple[int, int, int]:
    """The three axes in cyclic order, ``axis`` last: a right-handed frame stays so."""
    return (axis + 1) % 3, (axis + 2) % 3, axis


def kind_of_body(body: Body) -> str:
    """The classical name of a body: Euler, Lagrange or Kovalevskaya top, or what it is instead."""
    return classical_top(body.moments, body.axes.components(body.torque)).kind
