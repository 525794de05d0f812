"""A body and its start in principal axes, exact: what decides which closed form fits."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from polhode.closed_forms.rounding import log2
from polhode.numbers.exact import sign
from polhode.numbers.vectors import Vector, scaled
from polhode.scenes.scene import Scene

_USUAL = 256  # bits: numbers whose binary exponents are within are products of few doubles


class PrincipalScene(NamedTuple):
    """A body and its start in principal axes, every number exact.

    ``moments``: the principal moments A, B, C.  ``torque``: Mg r0.  ``omega`` and ``gamma``: the
    angular velocity and the upward vertical at t = 0; ``gamma`` is None where a torque-free body
    was given without it, never for a heavy one.
    """

    moments: Vector
    torque: Vector
    omega: Vector
    gamma: Vector | None


def in_principal_axes(scene: Scene) -> PrincipalScene:
    """The body and the start of a scene in the body's principal axes."""
    body = scene.body
    along = body.axes.components
    gamma = None if scene.gamma is None else along(scene.gamma)
    return PrincipalScene(body.moments, along(body.torque), along(scene.omega), gamma)


def in_usual_units(scene: PrincipalScene) -> tuple[PrincipalScene, Fraction]:
    """A heavy body in units where doubles hold its numbers, and the unit of its rates."""
    mass = log2(max(scene.moments))
    fastest = [log2(x) for x in scene.omega if sign(x)]
    fastest += [(log2(x) - mass) / 2 for x in scene.torque if sign(x)]
    inertia, rate = _unit(mass), _unit(max(fastest, default=0.0))
    moments, torque = scaled(1 / inertia, scene.moments), scaled(1 / inertia, scene.torque)
    torque, omega = scaled(1 / (rate * rate), torque), scaled(1 / rate, scene.omega)
    return PrincipalScene(moments, torque, omega, scene.gamma), rate


def _unit(log2_size: float) -> Fraction:
    """1, or a power of two of such a size."""
    return Fraction(2) ** round(log2_size) if abs(log2_size) > _USUAL else Fraction(1)
