"""The Euler–Poisson equations with z through the centre of mass and I12 = 0 (3.24–3.27).

Of gamma only gamma1 and gamma2 enter w', and two of the three products of inertia are left.  The
axes are found exactly from any body; one without torque is given in its principal axes.
"""

from __future__ import annotations

from polhode.equations.forms.centre_axes import centre_axes
from polhode.equations.forms.general import General, in_axes
from polhode.scenes.scene import Scene

SOURCE = "3.24–3.27"


def for_scene(scene: Scene) -> General:
    """The equations of a scene."""
    return in_axes(scene, centre_axes(scene.body, scene.body.inertia))
