"""The equations in G and gamma with z through the centre of mass and A12 = 0 (3.38–3.42).

A = I⁻¹ is the gyration matrix; the axes are Kharlamov's, found exactly from any body.  A body
without torque is given in its principal axes.
"""

from __future__ import annotations

from polhode.equations.forms.centre_axes import centre_axes
from polhode.equations.forms.momentum import Momentum, in_axes
from polhode.numbers.vectors import inverse
from polhode.scenes.scene import Scene

SOURCE = "3.38–3.42"


def for_scene(scene: Scene) -> Momentum:
    """The equations of a scene."""
    return in_axes(scene, centre_axes(scene.body, inverse(scene.body.inertia)))
