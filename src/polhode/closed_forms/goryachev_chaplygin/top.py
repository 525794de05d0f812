"""Goryachev and Chaplygin's case in closed form: every motion with f = 0, at any time.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(4C, 4C, C), r0 = (x0, y0, 0)

and Iw.gamma = 0 (Goryachev, Mat. Sb. 21 (1900) 431; Chaplygin, Trudy Otd. Fiz. Nauk 10 (1901)).
w = (p, q, r) and the upward vertical gamma in body axes.  In the halves of the angles xi and et,

    p = sg sqrt(uv)/2 sin((et - xi)/2),   q = sg sqrt(uv)/2 cos((et - xi)/2),   r = u - v,
    g1 = -(u cos xi + v cos et)/(u + v),  g2 = -(u sin xi - v sin et)/(u + v),
    g3 = sg 2 sqrt(uv) sin((xi + et)/2)/(u + v),   sg = +1 or -1 throughout.

The state has any number of digits, each of them proven; the attitude has no formula here.  Units:
any consistent set.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flint import arb

from polhode.closed_forms.balls.core import TooFewBits, ball, root, square
from polhode.closed_forms.balls.frames import Rows, SeenMotion
from polhode.closed_forms.closed_form import ENCLOSED_ATTITUDE, ClosedForm, no_attitude
from polhode.closed_forms.goryachev_chaplygin import regimes
from polhode.closed_forms.goryachev_chaplygin.axes import GoryachevStart, start
from polhode.closed_forms.goryachev_chaplygin.explicit import explicit
from polhode.closed_forms.goryachev_chaplygin.separated import Point, Separated
from polhode.closed_forms.membership import PrincipalScene


class GoryachevMotion:
    """The state in the motion's axes and units, at the precision in force."""

    def __init__(self, start: GoryachevStart, regime: str) -> None:
        of_zero = regime in regimes.EXPLICIT
        self.path = explicit(start, regime) if of_zero else Separated(start, regime)
        self._side = 1
        given, row = [ball(x) for x in (*start.omega, *start.gamma)], self.at(arb(0))
        lead = max((0, 1, 5), key=lambda i: abs(given[i].mid()))
        if not abs(row[lead]) > 0:
            raise TooFewBits
        self._side = 1 if (row[lead] > 0) == (given[lead] > 0) else -1

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, g1, g2, g3."""
        point: Point = self.path.at(t)
        (sx, cx), (se, ce) = point.xi, point.et
        one, two, both = point.shares
        half = self._side * point.root / 2
        return [
            half * (se * cx - ce * sx),
            half * (cx * ce + sx * se),
            point.u - point.v,
            one * (square(sx) - square(cx)) + two * (square(se) - square(ce)),
            2 * (two * se * ce - one * sx * cx),
            2 * self._side * both * (sx * ce + cx * se),
        ]


class GoryachevChaplyginTop(ClosedForm[SeenMotion[GoryachevMotion]]):
    """The state of one motion of Goryachev and Chaplygin's case from one start."""

    proven = ENCLOSED_ATTITUDE
    has_attitude = False
    is_dear = True
    held = ("A = B = 4C", "r0 at right angles to axis 3", "f = Iw.gamma = 0")

    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        self._begin = start(scene, axes)
        self.regime = regimes.regime(self._begin)

    def _solved(self) -> SeenMotion[GoryachevMotion]:
        start = self._begin
        unit, speed = ball(start.unit), root(start.H + 2 * start.a)  # w^2 <= H - 2a gamma1
        motion = GoryachevMotion(start, self.regime)
        first, speed = self._start().attitude, speed * unit.sgn()
        return SeenMotion(motion, no_attitude, start.frame, first, speed, unit)

    def _period_ball(self) -> arb | None:
        """None where there are two frequencies or none."""
        if self.regime in (*regimes.TWO_FREQUENCIES, *regimes.ASYMPTOTIC):
            return None
        period = self._solution().motion.path.period
        return None if period is None else period / ball(abs(self._begin.unit))

    def _rate_balls(self) -> Mapping[str, arb]:
        """Of two frequencies "u" and "v", the mean rates of the phases of u and v.

        u and v repeat with 2 pi of them, p, q and gamma3 with twice that.
        """
        if self.regime not in regimes.TWO_FREQUENCIES:
            return super()._rate_balls()
        path, unit = self._solution().motion.path, ball(abs(self._begin.unit))
        assert isinstance(path, Separated)
        return {name: rate * unit for name, rate in zip("uv", path.means, strict=True)}
