"""Permanent rotations: w constant along the vertical, and rest (O. Staude, J. reine angew. Math.
113 (1894) 318).

All right-hand sides of the six equations vanish: w = om gamma and om^2 I gamma - Mg r0 = mu gamma.
State and theta, phi stay, psi' = om.  Whether the rotation is stable is decided exactly
(:mod:`polhode.closed_forms.rotation_stability`).
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from typing import ClassVar

from polhode.closed_forms._one_orbit.orbits import OrbitCase, orbit_family
from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import PermanentRotation, SolvedMotion
from polhode.closed_forms.membership import ALL_AXES, Condition, NormalScene, vanishing
from polhode.closed_forms.rotation_stability import STABLE, UNDECIDED, UNSTABLE, spectrum, verdict
from polhode.numbers.exact import sign
from polhode.numbers.vectors import cross, dot, is_zero


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """w along gamma, and the moment of the weight balances the gyroscopic one."""
    yield vanishing("w along gamma", cross(scene.gamma, scene.omega), lambda: scene.speed)
    yield vanishing("gamma x Mg r0 = w x Iw", scene.moment, lambda: scene.weight)


class Regime(StrEnum):
    """The kinds of motion."""

    HANGING = "rest, hanging"
    UPRIGHT = "rest, upright"
    STABLE = f"permanent rotation, {STABLE}"
    UNSTABLE = f"permanent rotation, {UNSTABLE}"
    UNDECIDED = f"permanent rotation, {UNDECIDED}"


class Staude(OrbitCase):
    """One permanent rotation, or rest."""

    conditions = staticmethod(conditions)
    candidates = ALL_AXES[:1]  # the same in all
    rates_of: ClassVar = {"precession": "of the body about the vertical"}

    def _regime(self) -> Regime:
        scene = self.normal
        if is_zero(scene.omega):
            upright = sign(dot(scene.torque, scene.gamma)) > 0
            return Regime.UPRIGHT if upright else Regime.HANGING
        b, d = spectrum(scene.moments, scene.torque, scene.omega, scene.gamma)
        return Regime(f"permanent rotation, {verdict(b, d)}")

    def solve(self) -> SolvedMotion:
        """The rotation; psi', its rate about the vertical, is a frequency, but at rest."""
        omega, gamma = self.normal.omega, self.normal.gamma
        return PermanentRotation(
            omega,
            ball(abs(dot(omega, gamma))) / 2,
            gamma,
            stays=True,
            precession=None if is_zero(omega) else ball(dot(omega, gamma)),
        )


FAMILY = orbit_family("staude", Staude)
