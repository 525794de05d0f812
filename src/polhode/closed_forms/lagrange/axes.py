"""Which heavy bodies are Lagrange tops, and the axes in which they are one.

The axes of the top: the third is the axis of symmetry, turned so that the weight's moment is
positive about it -- gamma3 = 1 is the upright top, with the centre of mass above the fixed point --
and the three are right-handed.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms._engine.axes import RowMatrix, in_scene, principal
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.functions.rounding import number
from polhode.numbers.exact import Exact, sign, sqrt
from polhode.scenes import body
from polhode.scenes.body import Vector, cross, dot
from polhode.scenes.classification import LAGRANGE, SPHERE, classical_top, with_last


def fits(scene: PrincipalScene) -> bool:
    """Whether the body is a Lagrange top.

    Two moments are equal and the centre of mass is on the third axis, or all three are equal; a
    body without weight is none.
    """
    return classical_top(scene.moments, scene.torque).kind in (LAGRANGE, SPHERE)


@dataclass(frozen=True)
class LagrangeAxes:
    """The top's axes in principal ones, and the principal axes in the scene's (None: the same).

    Axis n of the top is ``signs[n]`` times principal axis ``order[n]``, or row n of ``turned``.
    """

    rows: tuple[tuple[Exact, ...], ...] | None
    order: tuple[int, int, int]
    signs: tuple[int, int, int]
    turned: body.PrincipalAxes | None
    moments: tuple[Exact, Exact]  # A, across the axis of symmetry, and C, about it
    torque: Exact  # Mg z0 > 0

    def top(self, vector: Vector) -> Vector:
        """From the scene's axes to the top's, exactly."""
        v = principal(self.rows, vector)
        if self.turned is not None:
            return self.turned.components(v)
        x, y, z = (s * v[i] for s, i in zip(self.signs, self.order, strict=True))
        return x, y, z

    def matrix(self, bits: int) -> RowMatrix:
        """The top's axes as rows of components in the scene's axes, rounded."""
        if self.turned is not None:
            turn = [[number(x, bits) for x in row] for row in self.turned.rows]
        else:
            turn = [
                [s if i == j else 0 for j in range(3)]
                for s, i in zip(self.signs, self.order, strict=True)
            ]
        return in_scene(turn, self.rows, bits)


def top_axes(
    moments: Vector, torque: Vector, rows: tuple[tuple[Exact, ...], ...] | None
) -> LagrangeAxes:
    """The axes of the top; raises ValueError for a body that is none (:func:`fits`)."""
    found = classical_top(moments, torque)
    if found.kind not in (LAGRANGE, SPHERE):
        raise ValueError("not a Lagrange top")
    if found.axis is not None:
        i, j, k = with_last(found.axis)
        up = sign(torque[k])
        return LagrangeAxes(
            rows, (i, j, k), (1, up, up), None, (moments[i], moments[k]), abs(torque[k])
        )
    units = body.IDENTITY
    across = max((cross(unit, torque) for unit in units), key=lambda v: dot(v, v))
    directions = across, cross(torque, across), torque
    a, b, c = (dot(v, v) for v in directions)
    turned = body.PrincipalAxes(directions, (a, b, c))
    return LagrangeAxes(rows, (0, 1, 2), (1, 1, 1), turned, (moments[0], moments[0]), sqrt(c))
