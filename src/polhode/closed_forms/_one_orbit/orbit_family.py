"""A family that its conditions in the axes of its normal form decide."""

from __future__ import annotations

from functools import partial

from polhode.closed_forms._one_orbit.placed_motion import PlacedMotion
from polhode.closed_forms.membership.family import Family
from polhode.closed_forms.membership.normal_form import placed_in, shortfall
from polhode.closed_forms.membership.principal_scene import PrincipalScene


def orbit_family(name: str, motion: type[PlacedMotion]) -> Family:
    """A family of that name, of one class of motions."""

    def fits(scene: PrincipalScene) -> bool:
        return placed_in(motion.conditions, scene) is not None

    return Family(name, fits, partial(shortfall, motion.conditions), lambda: motion)
