"""Permanent rotations: w constant along the vertical, and rest (O. Staude, J. reine angew. Math.
113 (1894) 318).

All right-hand sides of the six equations vanish: w = om gamma and om^2 I gamma - Mg r0 = mu gamma.
State and theta, phi stay, psi' = om.  Whether the rotation is stable is decided exactly
(:mod:`polhode.closed_forms.rotation_stability`).
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from fractions import Fraction

from polhode.closed_forms._one_orbit.orbits import OrbitPlacement
from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import Frame, Motion, PermanentRotation
from polhode.closed_forms.membership import ALL_AXES, Condition, NormalAxes, NormalScene, vanishing
from polhode.closed_forms.rotation_stability import STABLE, UNDECIDED, UNSTABLE, Stability, spectrum
from polhode.common.values import cached_property
from polhode.numbers.exact import sign
from polhode.numbers.vectors import cross, dot, is_zero, minus


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """w along gamma, and the moment of the weight balances the gyroscopic one."""
    yield vanishing("w along gamma", cross(scene.gamma, scene.omega), lambda: scene.speed)
    lacking = minus(cross(scene.gamma, scene.torque), cross(scene.omega, scene.momentum))
    yield vanishing("gamma x Mg r0 = w x Iw", lacking, lambda: scene.weight)


class Regime(StrEnum):
    """The kinds of motion."""

    HANGING = "rest, hanging"
    UPRIGHT = "rest, upright"
    STABLE = f"permanent rotation, {STABLE}"
    UNSTABLE = f"permanent rotation, {UNSTABLE}"
    UNDECIDED = f"permanent rotation, {UNDECIDED}"


_BY_VERDICT = {
    STABLE: Regime.STABLE,
    UNSTABLE: Regime.UNSTABLE,
    UNDECIDED: Regime.UNDECIDED,
}


class Staude(OrbitPlacement):
    """One permanent rotation, or rest."""

    conditions = staticmethod(conditions)
    candidates = ALL_AXES[:1]  # the same in all

    def __init__(
        self, axes: NormalAxes, normal: NormalScene, unit: Fraction, principal: Frame
    ) -> None:
        super().__init__(axes, normal, unit, principal)
        self.rates_of = {"precession": "of the body about the vertical"}

    @cached_property
    def stability(self) -> Stability:
        """The coefficients of the characteristic polynomial, exact."""
        scene = self.normal
        return Stability(*spectrum(scene.moments, scene.torque, scene.omega, scene.gamma))

    def _regime(self) -> Regime:
        scene = self.normal
        if is_zero(scene.omega):
            upright = sign(dot(scene.torque, scene.gamma)) > 0
            return Regime.UPRIGHT if upright else Regime.HANGING
        return _BY_VERDICT[self.stability.verdict]

    def solve(self) -> Motion:
        """The rotation; psi', its rate about the vertical, is a frequency, but at rest."""
        omega, gamma = self.normal.omega, self.normal.gamma
        return PermanentRotation(
            [ball(x) for x in omega],
            ball(abs(dot(omega, gamma))) / 2,
            [ball(x) for x in gamma],
            stays=True,
            precession=None if is_zero(omega) else ball(dot(omega, gamma)),
        )
