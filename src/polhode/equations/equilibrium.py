"""Relative equilibria: the motions in which the state stands still.

All derivatives of (3.29) vanish exactly at the start: rest, hanging or upright, and permanent
rotation: w along gamma (Staude), or, of a free body without gamma, along a principal axis.  The
body then turns uniformly about w, which is fixed in body and space.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from polhode.equations import kinematics
from polhode.equations.form import equations
from polhode.numbers import exact
from polhode.numbers.exact import Exact
from polhode.numbers.vectors import (
    Vector,
    dot,
    is_zero,
    parallel,
    quaternion_product,
    scaled,
)
from polhode.scenes.scene import Scene


class Rest(NamedTuple):
    """Whether w, and whether the whole state, stand still."""

    omega: bool
    state: bool


def at_rest(scene: Scene) -> Rest:
    """What stands still: of which every derivative vanishes at the start, by the rule for *equal*.

    w by itself may only where no torque acts on it: then it does not depend on gamma.
    """
    body, omega, gamma = scene.body, scene.omega, scene.gamma
    along = gamma is None or parallel(gamma, omega)  # gamma' = gamma × w
    if not along and not body.torque_free:
        return Rest(False, False)
    still = is_zero(body.moment(omega, gamma))
    return Rest(still, still and along)


def name(scene: Scene) -> str | None:
    """Rest or permanent rotation; None for any other motion."""
    if not at_rest(scene).state:
        return None
    return "rest" if is_zero(scene.omega) else "permanent rotation"


def variables(scene: Scene, t: Fraction) -> list[Exact]:
    """State in principal form, inside its frame, quaternion, psi and phi, at time t.

    As far as the scene asks for them; no psi and phi at a pole.  The quaternion is
    q(0) ⊗ (cos |w|t/2, sin |w|t/2 w/|w|); psi' = w·gamma.
    """
    values, gamma = [*equations(scene).start], scene.gamma
    if gamma is None:
        return values
    if scene.modelled:
        values += _turned(kinematics.starting_attitude(gamma, scene.psi), scene.omega, t)
    if "angles" in scene.modelled and not scene.starts_at_pole:
        values += [scene.psi + dot(scene.omega, gamma) * t, kinematics.starting_phi(gamma)]
    return values


def _turned(quaternion: tuple[Exact, ...], omega: Vector, t: Fraction) -> tuple[Exact, ...]:
    """A quaternion after a uniform turn with omega, body axes, for a time t."""
    if is_zero(omega) or t == 0:
        return quaternion
    rate = exact.sqrt(dot(omega, omega))
    half = rate * t / 2
    return quaternion_product(quaternion, (exact.cos(half), *scaled(exact.sin(half) / rate, omega)))
