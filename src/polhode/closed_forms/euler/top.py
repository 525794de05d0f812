"""The torque-free rigid body (Euler's top) in closed form: states, attitude, Euler angles.

    I w' + w x I w = 0,    gamma' = gamma x w            (Yehia 3.13-3.17 without weight)

w = (p, q, r) and the unit vector gamma in body axes; attitude R (body -> space, z along gamma).
Any body, any start, any time, any number of digits, each of them proven.  Units: any consistent
set, angles in radians.  Formulas: :mod:`polhode.closed_forms.euler.motion`, after Whittaker,
Analytical Dynamics, art. 69.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from flint import arb

from polhode.closed_forms.balls.angles import Arguments
from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import Frame, Rows
from polhode.closed_forms.balls.one_axis import OneAxis, PermanentRotation
from polhode.closed_forms.closed_form import ClosedForm
from polhode.closed_forms.euler.conditions import fits
from polhode.closed_forms.euler.motion import Polhode
from polhode.closed_forms.euler.regimes import is_permanent, numbered, numbers, regime
from polhode.closed_forms.membership import PrincipalScene
from polhode.numbers.vectors import dot

_ODD = ((0, 2, 1), (1, 0, 2), (2, 1, 0))

EulerMotion: TypeAlias = PermanentRotation | Polhode


class EulerTop(ClosedForm[EulerMotion]):
    """The motion of one torque-free body from one start; without gamma only w is known.

    psi and phi of a permanent rotation are known at any time, of any other they are counted.
    """

    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        if not fits(scene):
            raise ValueError("a body whose weight has a moment")
        moments, principal = scene.moments, scene.omega
        order, side = numbered(moments, principal)
        self.regime = regime(moments, principal, side)
        self.knows_turns = self._permanent = is_permanent(moments, principal)
        if self._permanent:
            if self._known_gamma is not None:
                self._turning = OneAxis(self._omega, self._known_gamma)
            return
        self._order = order
        a, b, c = (moments[i] for i in order)
        self._frame = Frame.signed(order, (1, -1 if order in _ODD else 1, 1), axes)
        self._numbers = numbers((a, b, c), self._frame.into(self._omega))

    def _solved(self) -> EulerMotion:
        if self._permanent:
            half = root(dot(self._omega, self._omega)) / 2
            return PermanentRotation([ball(x) for x in self._omega], half, self._start())
        gamma = self._known_gamma
        vertical = None if gamma is None else [ball(x) for x in self._frame.into(gamma)]
        return Polhode(self._numbers, self._frame, self._start(), vertical)

    def arguments_at(self, t: arb) -> Arguments:
        """Of a permanent rotation."""
        motion, start = self._solution(), self._start().attitude
        assert isinstance(motion, PermanentRotation)
        assert start is not None
        return self._turning.arguments(start, motion.axis, motion.swung(t))

    def _period_ball(self) -> arb | None:
        """None where w is constant or tends to the middle axis."""
        motion = self._solution()
        if isinstance(motion, PermanentRotation) or motion.elliptic.limit:
            return None
        return 4 * motion.elliptic.K / motion.rate

    @property
    def rates_of(self) -> Mapping[str, str]:
        """Of the axis that the polhode circles, the third of the motion's."""
        if self._permanent:
            return {"precession": "of the body about omega"}
        which = "largest" if self._numbers.sense > 0 else "smallest"
        axis = f"principal axis {self._order[2] + 1} (of the {which} moment)"
        return {"precession": f"of {axis} about the angular momentum"}

    def _rate_balls(self) -> Mapping[str, arb]:
        """Mean rates in radians a unit of time.

        "polhode": of w in the body (absent where w has no period); "precession": of the axis that
        the polhode circles, about G.
        """
        motion = self._solution()
        if isinstance(motion, PermanentRotation):
            return {"precession": 2 * motion.half}
        if motion.elliptic.limit:
            return {"precession": motion.precession}
        polhode = arb.pi() * motion.rate / (2 * motion.elliptic.K)
        return {"precession": motion.precession, "polhode": polhode}
