"""Which scenes are Chaplygin's motions of 1904; their coefficients."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

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
from polhode.numbers.exact import ONE, ZERO, Exact, power, sign


@dataclass(frozen=True)
class Coefficients:
    """Of a body that fits; ``cube`` is B1^3, ``ratio`` C1/B1."""

    b2: Exact
    c2: Exact
    ratio: Exact
    cube: Exact

    @property
    def B1(self) -> Exact:  # noqa: N802
        """The coefficient of p^(2/3) in q^2."""
        return power(self.cube, ONE / 3)


def ratio_of(scene: Placed) -> Exact:
    """C1/B1, positive where the motion is real."""
    A, B, C = scene.moments
    return -(3 * A - 2 * B) * (A - 2 * B) / ((3 * A - 2 * C) * (A - 2 * C))


def coefficients(scene: Placed) -> Coefficients:
    """Of a body that fits."""
    (A, B, C), c = scene.moments, scene.torque[0]
    ratio = ratio_of(scene)
    K = ratio * (B - C) ** 2 * (C * C * ratio + B * B) / (9 * A * A)
    return Coefficients(
        b2=A * (A - C) / ((A - 2 * B) * (B - C)),
        c2=-A * (A - B) / ((A - 2 * C) * (B - C)),
        ratio=ratio,
        cube=c * c / K,
    )


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, h = f = 0, then q^2, r^2 and gamma."""
    A, B, C = scene.moments
    left = 9 * A * A + 32 * B * C
    yield from on_axis_1(scene)
    yield positive("B > C", B - C)
    yield equal("9 A^2 + 32 B C = 18 A (B + C)", left, 18 * A * (B + C))
    yield positive("C1/B1 > 0", ratio_of(scene))
    c, size = scene.torque[0], scene.speed
    yield equal("h = 0", scene.energy, ZERO, c)
    yield equal("f = 0", scene.area, ZERO, A * size)
    x, (p, q, r) = coefficients(scene), scene.omega
    rest = q * q - x.b2 * p * p
    yield equal("(q^2 - b2 p^2)^3 = B1^3 p^2", rest**3, x.cube * p * p, size**6)
    yield equal(
        "r^2 - c2 p^2 = C1/B1 (q^2 - b2 p^2)", r * r - x.c2 * p * p, x.ratio * rest, size**2
    )
    if sign(p) == 0:
        yield from _at_rest(scene, x)
        return
    # C1 Y and B1 Z, Y = q/p^(1/3), Z = r/p^(1/3), without roots: B1 p^(2/3) = q^2 - b2 p^2.
    one, two = x.ratio * q * rest / p, r * rest / p
    yield from matching(
        scene,
        (
            -(A * p * p + B * q * q + C * r * r) / (2 * c),
            ((A - B) * p * q - C * (B - C) * (x.c2 * p * q + one / 3) / A) / c,
            ((A - C) * p * r + B * (B - C) * (x.b2 * p * r + two / 3) / A) / c,
        ),
    )


def _at_rest(scene: Placed, x: Coefficients) -> Iterator[Condition]:
    """Where the orbit passes w = 0: gamma1 = 0, and Y^2 = B1 there."""
    (A, B, C), c = scene.moments, scene.torque[0]
    yield equal("gamma1 = 0", scene.gamma[0], ZERO, ONE)
    # c gamma2 = -C (B - C) C1 Y/3A: to the third power of its square, B1^3 being rational.
    factor = (C * (B - C) * x.ratio / (3 * A * c)) ** 6
    yield equal("gamma2 as w = 0 requires", scene.gamma[1] ** 6, factor * x.cube**3, ONE)


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the family."""
    return placed_in(conditions, scene) is not None


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails; None where all hold."""
    return shortfall(conditions, scene)
