"""What kind a motion is, by the growth of its tangents: the one definition.

*regular*: nearby motions separate no faster than a power of t (quasi-periodic motion, on a torus).
*unstable*: they separate exponentially, but the motion is known: a closed form, a fixed point, a
body that is integrable for every start.  It is unstable periodic, or asymptotic to such a motion,
as on a separatrix.
*chaotic*: they separate exponentially, and nothing of that kind is known.
*undecided*: the time is too short.
"""

from __future__ import annotations

from polhode.scenes.body import Body
from polhode.scenes.classification import EULER, KOVALEVSKAYA, LAGRANGE, SPHERE, kind_of_body

REGULAR, UNSTABLE, CHAOTIC, UNDECIDED = "regular", "unstable", "chaotic", "undecided"
#: Units of time, about a radian, before which no motion is called regular by its growth.
SHORTEST = 1000.0
#: Of ln |tangent| in the second half of the time: below the first regular, above the second not.
REGULAR_GROWTH, UNSTABLE_GROWTH = 2.0, 6.0


def of_growing(known: bool) -> str:
    """The kind of a motion from which nearby motions separate exponentially."""
    return UNSTABLE if known else CHAOTIC


def is_integrable(body: Body) -> bool:
    """Whether no motion of a body is chaotic, whatever its start."""
    return kind_of_body(body) in (EULER, LAGRANGE, SPHERE, KOVALEVSKAYA)


def shown(kind: str) -> str:
    """The kind in words."""
    return "unstable (periodic or asymptotic)" if kind == UNSTABLE else kind
