"""Poles, where the third axis is vertical and psi and phi have no meaning: the rule for branches.

Over a pole one of psi + phi (the upper pole) and psi - phi (the lower one) stays continuous; the
other jumps by 2 pi up or down, and both are right.  The rule:

    a start at a pole is left with phi in [-pi, pi) from the upper one, in (-pi, pi] from the lower
    (:func:`phi_leaving_the_pole`), on either side of t = 0;
    at each later passage exactly through a pole psi jumps up by pi, and phi by pi down at the upper
    pole and up at the lower one.  Later means farther from t = 0, on either side of it.

So the motion with w reversed has the angles of the same motion at -t.  Closed forms count so; only
a pendulum's libration takes its jumps back where it returns, its angles being functions of the
swing.  Proofs lose the angles at such a passage.  A run passes the pole at a distance of rounding,
on either side: its psi and phi are from there on right up to whole turns.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from polhode.numbers.exact import sign
from polhode.numbers.vectors import Vector, apply, inverse
from polhode.scenes.scene import Scene


class Departure(NamedTuple):
    """gamma leaves the pole with its derivative of that order, gamma x vector, which is not 0.

    ``vector``: w for order 1, w' for order 2.
    """

    order: int
    vector: Vector


def departure(scene: Scene) -> Departure | None:
    """How a start at a pole leaves it; None where the third axis stays vertical for ever.

    gamma' = gamma x w, and gamma'' = gamma x w' where w is along the third axis.  Where both vanish
    all derivatives do: I w' is then across gamma and w' along it, so that w'.I w' = 0 and w' = 0.
    """
    for order, vector in ((1, scene.omega), (2, _slope(scene))):
        if not sign(vector[0]) == 0 == sign(vector[1]):
            return Departure(order, vector)
    return None


def _slope(scene: Scene) -> Vector:
    """w' at the start."""
    assert scene.gamma is not None
    moment = scene.body.moment(scene.omega, scene.gamma)
    return apply(inverse(scene.body.inertia), moment)


def phi_leaving_the_pole(scene: Scene, sense: int) -> float:
    """The limit of phi at a start at a pole, as time goes on (``sense`` 1) or back (-1).

    On the negative axis, where phi could be either, it is -pi from the upper pole and pi from the
    lower one, as the closed forms count it.  0 where the pole is never left.
    """
    assert scene.gamma is not None
    up, leaving = sign(scene.gamma[2]), departure(scene)
    if leaving is None:
        return 0.0
    order, w = leaving
    sense = sense if order == 1 else 1  # t^2 has the same sign on both sides
    across, along = -sense * up * sign(w[1]), sense * up * sign(w[0])
    if across == 0 and along < 0:
        return -up * math.pi
    largest = max(abs(w[0]), abs(w[1]))
    p, q = (float(x / largest) if sign(x) else 0.0 for x in w[:2])
    return math.atan2(-sense * up * q if across else 0.0, sense * up * p)
