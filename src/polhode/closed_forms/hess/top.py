"""Hess and Appelrot's case in closed form: every motion on the surface Iw.r0 = 0, at any time.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w

(Hess, Math. Ann. 37 (1890) 153; Appelrot, Mat. Sb. 16 (1893); Nekrasov 1896).  w = (p, q, r) and
the upward vertical gamma in body axes.  Any start, any time, any number of digits, each of them
proven.  Formulas: :mod:`polhode.closed_forms.hess.motion`.  Units: any consistent set.
"""

from __future__ import annotations

from collections.abc import Mapping

from flint import arb

from polhode.closed_forms.balls.core import TooFewBits, ball
from polhode.closed_forms.balls.frames import Rows
from polhode.closed_forms.closed_form import ClosedForm
from polhode.closed_forms.hess import axes as surface
from polhode.closed_forms.hess import motion as kinds
from polhode.closed_forms.hess.motion import ConeSpin, HessMotion
from polhode.closed_forms.hess.period_map import PeriodMap
from polhode.closed_forms.membership import PrincipalScene
from polhode.closed_forms.pendulum.motion import Swing
from polhode.numbers.mpmath_context import mpf


class HessTop(ClosedForm[HessMotion]):
    """One motion on Hess's surface from one start."""

    held = ("r0 at right angles to the middle axis", "(B/C - 1) T1^2 = (1 - B/A) T3^2", "Iw.r0 = 0")

    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        self._begin = surface.start(scene, axes)
        self._sphere = kinds.sphere(self._begin)
        self.regime = kinds.regime(self._begin, self._sphere)

    def _solved(self) -> HessMotion:
        return HessMotion(self._begin, self._sphere, self._start())

    def _most_bits(self, digits: int) -> int | None:
        """A series of ever more bits would take minutes."""
        return 4 * digits + 1_200 if self.regime == kinds.GENERAL else None

    def _period_ball(self) -> arb | None:
        motion = self._solution()
        if isinstance(motion.sphere, Swing):
            swing = motion.sphere
            return 4 * swing.elliptic.K / swing.rate if swing.librates else None
        if isinstance(motion.spin, ConeSpin) and self.regime == kinds.CONE_TURNING:
            return arb.pi() / motion.spin.rate
        return None

    def _rate_balls(self) -> Mapping[str, arb]:
        """Of the general motion "nutation", of the angle between r0 and the vertical.

        Where it does not tend to a periodic motion also "turning", of the second phase, known
        modulo the first.
        """
        spin = self._solution().spin
        if not isinstance(spin, PeriodMap):
            return super()._rate_balls()
        rates = {"nutation": 2 * arb.pi() / spin.period}
        if not _tends(spin):
            rates["turning"] = 2 * (spin.trace / 2).acos() / spin.period
        return rates

    def approach(self, digits: int) -> mpf | None:
        """The rate at which the motion tends to a periodic one; None where it does not.

        Differences fall as exp(-rate t); of a plane rotation and of a cone that tends to a
        permanent rotation too.
        """
        return self._one(self._approach, digits)

    def _approach(self) -> arb | None:
        motion = self._solution()
        sphere, spin = motion.sphere, motion.spin
        if isinstance(spin, PeriodMap):
            return 2 * (spin.trace / 2).acosh() / spin.period if _tends(spin) else None
        if isinstance(spin, ConeSpin) and self.regime == kinds.CONE_TENDING:
            return 2 * spin.rate
        if isinstance(sphere, Swing) and self.regime == kinds.ROTATION:
            # y's parts grow apart as exp(a12 del), and del by 2 pi while v by 2K.
            return abs(ball(self._begin.a12)) * arb.pi() * sphere.rate / sphere.elliptic.K
        return None


def _tends(spin: PeriodMap) -> bool:
    """Whether |tr N| > 2."""
    if not (spin.trace > 2 or spin.trace < 2):
        raise TooFewBits
    return bool(spin.trace > 2)
