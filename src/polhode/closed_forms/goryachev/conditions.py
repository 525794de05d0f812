"""Which scenes are Goryachev's motions; their coefficients."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    equal,
    matching,
    on_axis_1,
    placed_in,
    positive,
    shortfall,
)
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.functions.gamma_from_omega import Frame, frame
from polhode.numbers.exact import ZERO, Exact


def coefficients(scene: Placed) -> dict[str, Exact]:
    """Of a body that fits."""
    (_, B, C), c = scene.moments, scene.torque[0]
    D = 9 * B - 8 * C
    one, two, three = B - 2 * C, 3 * B - 2 * C, 3 * B - 4 * C
    b0 = 4 * B * C * c / (one * two * three)
    return {
        "b0": b0,
        "b2": -16 * C * C / (D * D),
        "c0": 2 * b0 * one * two / (B * C),
        "c2": 16 * three * (9 * B * B - 28 * B * C + 16 * C * C) / (B * D * D),
        "c4": -256 * C * C * three * three * (5 * B - 4 * C) / (B * b0 * D**4),
        "h": b0 * (9 * B * B - 22 * B * C + 12 * C * C) / (4 * C),
    }


def frame_of(scene: Placed, x: dict[str, Exact]) -> Frame:
    """gamma, q^2 and r^2 as functions of p, from those coefficients."""
    Q, R = (x["b0"], ZERO, x["b2"]), (x["c0"], ZERO, x["c2"], ZERO, x["c4"])
    return frame(scene.moments, scene.torque[0], x["h"], Q, R)


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, then q^2, r^2 and gamma as functions of p."""
    A, B, C = scene.moments
    yield from on_axis_1(scene)
    yield equal("A (9B - 8C) = 16 C (B - C)", A * (9 * B - 8 * C), 16 * C * (B - C))
    yield positive("B > 2C", B - 2 * C)
    yield positive("3B < 8C", 8 * C - 3 * B)
    found = frame_of(scene, coefficients(scene))
    yield from matching(scene, found.gamma(*scene.omega), found.squares(scene.omega[0]))


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the family."""
    return placed_in(conditions, scene) is not None


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails; None where all hold."""
    return shortfall(conditions, scene)
