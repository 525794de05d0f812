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

from polhode.closed_forms.balls.core import TooFewBits, ball, square
from polhode.closed_forms.balls.frames import Rows
from polhode.closed_forms.closed_form import ENCLOSED_ATTITUDE, ClosedForm, no_attitude
from polhode.closed_forms.goryachev_chaplygin import regimes
from polhode.closed_forms.goryachev_chaplygin.axes import GoryachevStart, start
from polhode.closed_forms.goryachev_chaplygin.explicit import explicit
from polhode.closed_forms.goryachev_chaplygin.separated import Point, Separated
from polhode.closed_forms.membership.principal_scene import PrincipalScene
from polhode.numbers.exact import Exact, sign
from polhode.numbers.mpmath_context import mpf


class GoryachevMotion:
    """A motion at the precision in force."""

    def __init__(self, start: GoryachevStart, regime: str) -> None:
        self._start, self._unit = start, ball(start.unit)
        of_zero = regime in regimes.EXPLICIT
        self.path = explicit(start, regime) if of_zero else Separated(start, regime)
        self._side = 1
        given, row = [ball(x) for x in (*start.omega, *start.gamma)], self._state(arb(0))
        lead = max((0, 1, 5), key=lambda i: abs(given[i].mid()))
        if not abs(row[lead]) > 0:
            raise TooFewBits
        self._side = 1 if (row[lead] > 0) == (given[lead] > 0) else -1
        #: w^2 <= H - 2a gamma1.
        self.speed = abs(self._unit) * ball(start.H + 2 * start.a).sqrt()

    @property
    def unit(self) -> arb:
        """How many of the motion's units of time are in the scene's."""
        return abs(self._unit)

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """p q r gamma1 gamma2 gamma3 in the scene's axes."""
        if attitude:
            no_attitude()
        state, back = self._state(t * self._unit), self._start.frame.back
        return [*back([x * self._unit for x in state[:3]]), *back(state[3:])]

    def _state(self, t: arb) -> list[arb]:
        """p, q, r, g1, g2, g3 in the motion's axes and units."""
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


class GoryachevChaplyginTop(ClosedForm[GoryachevMotion]):
    """The state of one motion of Goryachev and Chaplygin's case from one start."""

    proven = ENCLOSED_ATTITUDE
    has_attitude = False
    is_dear = True
    held = ("A = B = 4C", "r0 at right angles to axis 3", "f = Iw.gamma = 0")

    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        self._begin = start(scene, axes)
        self.regime = regimes.regime(self._begin)

    def _solved(self) -> GoryachevMotion:
        return GoryachevMotion(self._begin, self.regime)

    def _period_ball(self) -> arb | None:
        """None where there are two frequencies or none."""
        if self.regime in (*regimes.TWO_FREQUENCIES, *regimes.ASYMPTOTIC):
            return None
        motion = self._solution()
        return None if motion.path.period is None else motion.path.period / motion.unit

    def _rate_balls(self) -> Mapping[str, arb]:
        """Of two frequencies "u" and "v", the mean rates of the phases of u and v.

        u and v repeat with 2 pi of them, p, q and gamma3 with twice that.
        """
        if self.regime not in regimes.TWO_FREQUENCIES:
            return super()._rate_balls()
        motion = self._solution()
        assert isinstance(motion.path, Separated)
        one, other = motion.path.means
        return {"u": one * motion.unit, "v": other * motion.unit}
