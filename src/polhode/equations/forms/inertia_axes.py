"""The Euler–Poisson equations with z through the centre of mass and I12 = 0 (3.24–3.27).

Of gamma only gamma1 and gamma2 enter w', and two of the three products of inertia are left.  The
axes are found exactly from any body; one without torque is given in its principal axes.
"""

from __future__ import annotations

from polhode.equations.forms.centre_axes import centre_axes
from polhode.equations.forms.general import for_scene
from polhode.scenes.body import PrincipalAxes
from polhode.scenes.scene import Scene

__all__ = ["SOURCE", "axes", "for_scene"]

SOURCE = "3.24–3.27"


def axes(scene: Scene) -> PrincipalAxes:
    """Those in which the equations are the general ones."""
    return centre_axes(scene.body, scene.body.inertia)
