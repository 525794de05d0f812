"""The attitude of a Goryachev-Chaplygin motion from its halves: no sign or branch is chosen.

Angular momentum over |Iw| and gamma are two unit vectors at right angles, as f = 0.  The quaternion
that takes the first to the third axis and gamma to the second has the parameters

    al = sqrt(u/(u + v)) e^{-i (xi/2 + pi/4)},    bt = sg sqrt(v/(u + v)) e^{-i (et/2 + pi/4)},

smooth in time.  The axes are then renamed, and turned about the vertical by chi.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from polhode.closed_forms.goryachev_chaplygin.explicit import Point
from polhode.closed_forms.goryachev_chaplygin.motion import Motion
from polhode.closed_forms.goryachev_chaplygin.turning import Turning
from polhode.references.euler_motion import Quaternion, product
from polhode.references.theta import Functions

#: Takes the third axis to the first, the first to the second, the second to the third.
_RENAMED = (0.5, 0.5, 0.5, 0.5)


@dataclass(frozen=True)
class Attitude:
    """The attitude of the motion's own axes, time in the scene's units."""

    motion: Motion
    turning: Turning
    unit: Any  # the motion's time over the scene's; negative where time is reversed

    def at(self, t: Any, fn: Functions) -> Quaternion:
        """The quaternion at t, continuous in t."""
        time = t * self.unit
        point = self.motion.path.at(time, fn)
        return placed(point, self.motion.sg, self.turning(time), fn)


def placed(point: Point, sg: int, chi: Any, fn: Functions) -> Quaternion:
    """The quaternion of the point with the angular momentum at the angle chi."""
    (sx, cx), (se, ce) = point.xi, point.et
    one, two, _ = point.shares
    root = fn.sqrt(one / 2), sg * fn.sqrt(two / 2)
    # e^{-i (f + pi/4)} = ((c - s) - i (c + s))/sqrt 2
    frame = (root[0] * (cx - sx), root[1] * (ce - se), -root[1] * (ce + se), -root[0] * (cx + sx))
    cos, sin = fn.cos_sin(chi / 2)
    return product((cos, 0 * sin, 0 * sin, sin), product(_RENAMED, frame))

