"""How a motion leaves a pole, where the third axis is vertical and psi and phi have no meaning."""

from __future__ import annotations

import math

from polhode.equations.forms.matrices import apply, inverse
from polhode.numbers.exact import sign
from polhode.scenes.body import cross, minus
from polhode.scenes.scene import Scene


def phi_leaving_the_pole(scene: Scene, sense: int) -> float:
    """The limit of phi at a start at a pole, as time goes on (``sense`` 1) or back (-1).

    gamma' = gamma x w, and gamma'' = gamma x w' where w is along the third axis.  On the negative
    axis, where phi could be either, it is -pi from the upper pole and pi from the lower one, as the
    closed forms count it.
    """
    assert scene.gamma is not None
    up, w = sign(scene.gamma[2]), scene.omega
    if sign(w[0]) == 0 == sign(w[1]):
        momentum = apply(scene.body.inertia, w)
        moment = minus(cross(scene.gamma, scene.body.torque), cross(w, momentum))
        w, sense = apply(inverse(scene.body.inertia), moment), 1
    across, along = -sense * up * sign(w[1]), sense * up * sign(w[0])
    if across == 0 and along < 0:
        return -up * math.pi
    largest = max(abs(w[0]), abs(w[1]))
    p, q = (float(x / largest) if sign(x) else 0.0 for x in w[:2])
    return math.atan2(-sense * up * q if across else 0.0, sense * up * p)
