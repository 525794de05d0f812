"""The physical pendulum in closed form: any heavy body that swings about a horizontal axis.

    I w' + w x I w = gamma x T,    gamma' = gamma x w,    T = Mg r0      (Yehia 3.13-3.17)

Where a principal axis n is horizontal and at right angles to r0, and w is along it, w stays there.
With P = |T|, A the moment about n and del the angle that the body has turned about n from the
stable vertical gamma = -T/P,

    w = del' n,    A del'' = -P sin del,    gamma = (-cos del T + sin del n x T)/P.

With om^2 = P/A and k^2 = sin^2(del/2) + del'^2/(4 om^2), k'^2 = 1 - k^2 (Whittaker, Analytical
Dynamics, art. 44; DLMF 22.19(i))

    libration, k'^2 > 0:   sin(del/2) = k sn v,  cos(del/2) = dn v,  del' = 2 om k cn v,
                           v = v0 + om t,  modulus k;
    rotation, k'^2 < 0:    sin(del/2) = sn v,  cos(del/2) = cn v,  del' = 2 om k dn v,
                           v = v0 + om k t,  modulus 1/k; the separatrix k = 1 included.

n points so that del' >= 0 at t = 0 (at rest there: so that sin del > 0); hence -K <= v0 <= K.
Any start, any time, any number of digits, each of them proven.  psi and phi are functions of the
swing's angle: in a libration they return with the body.  Units: any consistent set, angles in
radians.
"""

from __future__ import annotations

from flint import arb

from polhode.closed_forms.balls.angles import Arguments
from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import Frame, Rows
from polhode.closed_forms.balls.one_axis import OneAxis, PermanentRotation
from polhode.closed_forms.closed_form import ClosedForm
from polhode.closed_forms.membership import PrincipalScene
from polhode.closed_forms.pendulum.conditions import axis_of, fits
from polhode.closed_forms.pendulum.motion import (
    HANGING,
    ROTATING,
    UPRIGHT,
    Swing,
    numbers,
    regime,
)


class Pendulum(ClosedForm[Swing | PermanentRotation]):
    """The plane motion of one heavy body from one start."""

    knows_turns = True

    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        moments, torque, omega, gamma = scene
        if gamma is None or not fits(scene):
            raise ValueError("a body that does not swing about a horizontal principal axis")
        self.regime = regime(moments, torque, omega, gamma)
        self._body = "rotation" if self.regime == ROTATING else "libration"
        self._at_rest = self.regime in (HANGING, UPRIGHT)
        self._n = Frame(within=axes).out(axis_of(torque, omega, gamma))
        self._turning = OneAxis(self._n, self._gamma)
        if not self._at_rest:
            self._numbers = numbers(moments, torque, omega, gamma)

    def _solved(self) -> Swing | PermanentRotation:
        if self._at_rest:
            return PermanentRotation([ball(x) for x in self._omega], arb(0), self._start())
        return Swing(self._numbers, self._n, self._start())

    def arguments_at(self, t: arb) -> Arguments:
        """Of the swing's angle."""
        motion, start = self._solution(), self._start().attitude
        assert start is not None
        return self._turning.arguments(start, motion.axis, motion.swung(t))

    def _period_ball(self) -> arb | None:
        motion = self._solution()
        if isinstance(motion, PermanentRotation) or motion.elliptic.limit:
            return None
        return (4 if motion.librates else 2) * motion.elliptic.K / motion.rate
