"""The equations in G and gamma with z through the centre of mass and A12 = 0 (3.38–3.42).

A = I⁻¹ is the gyration matrix; the axes are Kharlamov's, found exactly from any body.  A body
without torque is given in its principal axes.
"""

from __future__ import annotations

from polhode.equations.forms.centre_axes import centre_axes
from polhode.equations.forms.momentum import for_scene
from polhode.numbers.vectors import inverse
from polhode.scenes.body import PrincipalAxes
from polhode.scenes.scene import Scene

__all__ = ["SOURCE", "axes", "for_scene"]

SOURCE = "3.38–3.42"


def axes(scene: Scene) -> PrincipalAxes:
    """Those in which the equations are the ones in the momentum."""
    return centre_axes(scene.body, inverse(scene.body.inertia))
