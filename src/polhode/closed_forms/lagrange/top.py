"""Lagrange's top in closed form: states, attitude, Euler angles, period, frequencies.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(A, A, C), r0 = (0, 0, z0)

(Yehia 3.13-3.17), or A = B = C with r0 in any direction.  w = (p, q, r) and the upward vertical
gamma in body axes; attitude R (body -> space, z along gamma).  Any start, any time, any number of
digits, each of them proven.  Units: any consistent set, angles in radians.  Formulas (Klein and
Sommerfeld, Theorie des Kreisels, ch. VI): :mod:`polhode.closed_forms.lagrange.motion`.
"""

from __future__ import annotations

from collections.abc import Mapping

from flint import arb

from polhode.closed_forms.balls.angles import Arguments
from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import Rows
from polhode.closed_forms.closed_form import ClosedForm
from polhode.closed_forms.lagrange.axes import top_axes
from polhode.closed_forms.lagrange.motion import LagrangeMotion, Nutating, Seen, Steady, own_start
from polhode.closed_forms.lagrange.regimes import constants, regime
from polhode.closed_forms.membership import PrincipalScene
from polhode.numbers.exact import sign
from polhode.numbers.mpmath_context import mpf


class LagrangeTop(ClosedForm[LagrangeMotion]):
    """The motion of one Lagrange top from one start.

    The regimes are those of :func:`polhode.closed_forms.lagrange.regimes.regime`.  psi and phi are
    known at any time where the axis of symmetry is the scene's third; else they are counted.
    """

    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        self._axes = top_axes(scene.moments, scene.torque, axes)
        into = self._axes.frame.into
        self._top = into(self._omega), into(self._gamma)
        self._constants = constants(*self._axes.moments, self._axes.torque, *self._top)
        self.regime = regime(self._constants)
        self._own_side = self._axes.frame.along_third(2)
        self.knows_turns = self._own_side != 0

    def _solved(self) -> LagrangeMotion:
        c = self._constants
        seen = Seen(self._axes.frame, self._start(), ball(c.r), own_start(*self._top))
        return Steady(c, seen) if c.steady else Nutating(c, seen)

    def arguments_at(self, t: arb) -> Arguments:
        """Where the axis of symmetry is the scene's third."""
        motion = self._solution()
        one, other = motion.argument(0, t), motion.argument(1, t)
        return (one, other) if self._own_side > 0 else (other, one)

    def _period_ball(self) -> arb | None:
        """Of omega in the body, where the motion shows one.

        A pendulum in a plane passes the lower pole twice in a libration; in a steady precession
        omega goes round the axis of symmetry with phi.  Of other motions omega returns only if
        nutation and proper rotation have commensurable rates, which no digits decide.
        """
        c, nutation = self._constants, self._nutation()
        if self.regime.startswith("planar"):
            if nutation is None:
                return None
            return 2 * nutation if self.regime.endswith("librating") else nutation
        if not c.steady or c.level or sign(c.proper_rotation) == 0:
            return None
        return 2 * arb.pi() / abs(ball(c.proper_rotation))

    def nutation(self, digits: int) -> mpf | None:
        """The period of theta; None where theta is constant or tends to the upper pole."""
        return self._one(self._nutation, digits)

    def _nutation(self) -> arb | None:
        motion = self._solution()
        if not isinstance(motion, Nutating) or motion.elliptic.limit:
            return None
        return 2 * motion.elliptic.K / motion.rate

    @property
    def rates_of(self) -> Mapping[str, str]:
        """Of the axis of symmetry, which of a sphere is that through its centre of mass."""
        axis = "the axis of symmetry through the centre of mass"
        return {
            "precession": f"of {axis} about the vertical",
            "proper rotation": f"of the body about {axis}",
        }

    def _rate_balls(self) -> Mapping[str, arb]:
        """Mean rates in radians a unit of time.

        "nutation": of theta (absent where theta has no period); "precession": the mean of psi',
        about the vertical; "proper rotation": the mean of phi', about the principal axis that is
        the axis of symmetry (about Mg r0 if the three moments are equal).  The jumps by pi of a
        passage through a pole are not counted.  A top that stays upright or hanging has only the
        rotation r, and a pendulum that stays in its plane, which does not precess, neither.
        """
        c, period, side = self._constants, self._nutation(), self._axes.side
        rates = {} if period is None else {"nutation": 2 * arb.pi() / period}
        one, other = self._solution().means
        if c.steady and c.level:
            rates["proper rotation"] = side * ball(c.r)
        elif not self.regime.startswith("planar"):
            rates["precession"] = one + other
            rates["proper rotation"] = side * (one - other)
        return rates
