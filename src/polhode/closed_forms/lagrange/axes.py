"""Which heavy bodies are Lagrange tops, and the axes in which they are one.

The axes of the top: the third is the axis of symmetry, turned so that the weight's moment is
positive about it -- gamma3 = 1 is the upright top, with the centre of mass above the fixed point --
and the three are right-handed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from polhode.closed_forms.balls.frames import Frame, Rows
from polhode.closed_forms.membership import Condition, Placed, PrincipalScene, equal
from polhode.numbers.exact import ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, cross, dot
from polhode.scenes import body
from polhode.scenes.body import LAGRANGE, SPHERE, classical_top, with_last


def fits(scene: PrincipalScene) -> bool:
    """Whether the body is a Lagrange top.

    Two moments are equal and the centre of mass is on the third axis, or all three are equal; a
    body without weight is none.
    """
    return classical_top(scene.moments, scene.torque).kind in (LAGRANGE, SPHERE)


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, its axes in the top's order."""
    A, B, _ = scene.moments
    yield equal("A = B", A, B)
    yield equal("x0 = 0", scene.torque[0], ZERO, scene.weight)
    yield equal("y0 = 0", scene.torque[1], ZERO, scene.weight)


@dataclass(frozen=True)
class LagrangeAxes:
    """The top's axes in the scene's, and its numbers in them."""

    frame: Frame
    moments: tuple[Exact, Exact]  # A, across the axis of symmetry, and C, about it
    torque: Exact  # Mg z0 > 0
    side: int  # of the axis along its principal axis


def top_axes(moments: Vector, torque: Vector, rows: Rows | None) -> LagrangeAxes:
    """The axes of the top; raises ValueError for a body that is none (:func:`fits`)."""
    top = classical_top(moments, torque)
    if top.kind not in (LAGRANGE, SPHERE):
        raise ValueError("not a Lagrange top")
    if top.axis is not None:
        i, j, k = with_last(top.axis)
        up = sign(torque[k])
        frame = Frame.signed((i, j, k), (1, up, up), rows)
        return LagrangeAxes(frame, (moments[i], moments[k]), abs(torque[k]), up)
    # Directions and squared lengths: beside them only |Mg r0| is irrational.
    across = max((cross(unit, torque) for unit in body.IDENTITY), key=lambda v: dot(v, v))
    directions = across, cross(torque, across), torque
    squares = [dot(v, v) for v in directions]
    frame = Frame(directions, squares, rows)
    return LagrangeAxes(frame, (moments[0], moments[0]), sqrt(squares[2]), 1)
