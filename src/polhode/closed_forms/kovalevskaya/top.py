"""The Kovalevskaya top in closed form: states, attitude, period, frequencies.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(2C, 2C, C), r0 = (x0, y0, 0)

(Yehia 3.13-3.17).  w = (p, q, r) and the upward vertical gamma in body axes.  Any start, any time,
any number of digits: generic motion by genus-2 theta functions (Kowalevski, Acta Math. 12 (1889)
177), one-frequency motions by Weierstrass' functions, those on a curve of which an e is -k by sigma
functions.  Units: any consistent set, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from flint import arb

from polhode.closed_forms.balls.angles import Arguments
from polhode.closed_forms.balls.core import ball, enclosed
from polhode.closed_forms.balls.frames import (
    OwnMotion,
    OwnTurning,
    Rows,
    SeenMotion,
    Turn,
    halves,
    quaternion,
)
from polhode.closed_forms.balls.one_axis import OneAxis, Permanent
from polhode.closed_forms.balls.periodic_attitude import PeriodicAttitude, PeriodicOrbit, Strip
from polhode.closed_forms.closed_form import ENCLOSED_ATTITUDE, ClosedForm, no_attitude
from polhode.closed_forms.kovalevskaya import regimes
from polhode.closed_forms.kovalevskaya.axes import EQUATIONS, top_start
from polhode.closed_forms.kovalevskaya.branch_points import branch_points, discriminant
from polhode.closed_forms.kovalevskaya.degenerate import DegenerateState
from polhode.closed_forms.kovalevskaya.periodic import Periodic, quartic
from polhode.closed_forms.kovalevskaya.theta.cycles import rates
from polhode.closed_forms.kovalevskaya.theta.theta_attitude import ThetaAttitude
from polhode.closed_forms.kovalevskaya.theta.theta_state import ThetaState
from polhode.closed_forms.membership import PrincipalScene
from polhode.numbers.exact import ZERO, sign
from polhode.numbers.mpmath_context import mpc
from polhode.numbers.number_types import Scalar

_CHECKED = "states are proven; of the attitude the formula is checked, the arithmetic proven"


class KovalevskayaTop(ClosedForm[SeenMotion[Any]]):
    """The motion of one Kovalevskaya top from one start.

    ``regime`` is, of a generic motion, the type of its curve
    (:func:`polhode.closed_forms.kovalevskaya.regimes.regime`).
    """

    is_dear = True

    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        self._frame, self.begin = top_start(scene, axes)
        self.regime = regime = regimes.regime(self.begin)
        if regime == regimes.OTHER:
            raise ValueError("a degenerate curve on which the motion has no formula")
        self._disc = discriminant(self.begin)
        self._strip: Strip | None = None
        if regime in regimes.ONE_FREQUENCY:
            self.has_attitude = quartic(self.begin, regime).has_period
            passes = regimes.passes_the_vertical(self.begin, regime)
            self.passes_poles = passes and self._frame.along_third(2) != 0
        elif regime not in regimes.STEADY:
            self.has_attitude, self.proven = regime not in regimes.DEGENERATE, _CHECKED
        if not self.has_attitude:
            self.proven = ENCLOSED_ATTITUDE
        self.knows_turns = regime in regimes.STEADY
        if self.knows_turns:
            self._axis = OneAxis(self._omega, self._gamma)

    def _most_bits(self, digits: int) -> int:
        """Ever more bits would take minutes: near some motions no number of them is enough."""
        return 20 * digits + 3_000

    def _solved(self) -> SeenMotion[Any]:
        start, regime = self.begin, self.regime
        if regime in regimes.STEADY:
            steady = Permanent([ball(x) for x in (*start.omega, *start.G)])
            return self._seen(steady, steady.speed, lambda: steady)
        speed = start.speed_bound()
        if regime in regimes.DEGENERATE:
            return self._seen(DegenerateState(start), speed, no_attitude)
        if regime in regimes.ONE_FREQUENCY:
            periodic = Periodic(start, regime)
            return self._seen(periodic, speed, partial(self._periodic_turning, periodic))
        state = ThetaState(start, self._disc)
        return self._seen(state, speed, lambda: ThetaAttitude(state, self._first_turn()))

    def _seen(
        self, motion: OwnMotion, speed: arb, turning: Callable[[], OwnTurning]
    ) -> SeenMotion[Any]:
        """A motion of the top's axes in the scene's."""
        unit, weight = arb(2) ** self.begin.exponent, enclosed(self.begin.weight)
        attitude = self._start().attitude
        return SeenMotion(motion, turning, self._frame, attitude, speed, unit, weight)

    def _periodic_turning(self, motion: Periodic) -> OwnTurning:
        """The attitude of a motion that has a period."""
        if motion.period is None:
            return no_attitude()
        size = ball(self.begin.a2).sqrt()
        orbit = PeriodicOrbit(motion.complex_state, motion.period)
        attitude = PeriodicAttitude(orbit, size, motion.speed, EQUATIONS, self._strip)
        self._strip = attitude.strip
        return attitude

    def _first_turn(self) -> Turn:
        """A quaternion of the start's gamma in the top's axes."""
        a, b, c = (x / self.begin.weight for x in self.begin.G)
        return quaternion(*halves((a, b, c), ZERO))

    def arguments_at(self, t: arb) -> Arguments:
        """Of a state that stays."""
        motion, start = self._solution(), self._start().attitude
        assert start is not None
        w = motion.row(t, attitude=False)[:3]
        x, y, z = (v / motion.speed for v in w)
        still = all(v.is_zero() for v in w)  # whose speed is no zero, but 1, to divide by
        return self._axis.arguments(start, (x, y, z), arb(0) if still else motion.speed * t / 2)

    def repeats(self) -> arb | None:
        """The period, of w and gamma."""
        return self._period_ball()

    def _period_ball(self) -> arb | None:
        """The period of w and gamma; None for a motion of two frequencies, or without any."""
        motion = self._solution()
        if not isinstance(motion.motion, Periodic) or motion.motion.period is None:
            return None
        period: arb = motion.motion.period / motion.unit
        return period

    def curve(self, digits: int) -> dict[str, object]:
        """H, K^2 = k^2, the points e1, e2, e3 and the period matrix tau, in time units of 1/n.

        n is rounded to a power of two, 2^exponent.  tau is None on a degenerate curve.
        """
        start = self.begin

        def parts() -> dict[str, arb]:
            named = {"H": ball(start.H), "K2": ball(start.k2)}
            state = self._solution().motion
            rows = {"e": branch_points(start, self._disc)[:3]}
            if isinstance(state, ThetaState):
                rows["tau"] = list(state.jacobian.lattice.tau)
            for name, row in rows.items():
                for n, x in enumerate(row):
                    named |= {f"{name}{n} real": x.real, f"{name}{n} imag": x.imag}
            return named

        known = self._relative(parts, digits)
        pair = sign(self._disc) < 0

        def row(name: str) -> list[Scalar] | None:
            if f"{name}0 real" not in known:
                return None
            both = [(known[f"{name}{n} real"], known[f"{name}{n} imag"]) for n in range(3)]
            real = [name == "e" and not (pair and n) for n in range(3)]
            return [x if plain else mpc(x, y) for (x, y), plain in zip(both, real, strict=True)]

        shown: dict[str, object] = {"exponent": start.exponent}
        shown |= {"H": known["H"], "K2": known["K2"], "e": row("e"), "tau": row("tau")}
        return shown

    def _rate_balls(self) -> Mapping[str, arb]:
        """The motion's frequencies, radians a unit of time.

        Generic motion: "s1" and "s2", the mean rates at which the two separation variables go
        through their cycles; w and gamma repeat when both have made an even number of turns.
        One-frequency motion: "body".  Others: none.
        """
        motion = self._solution()
        if not isinstance(motion.motion, ThetaState):
            return super()._rate_balls()
        one, two = rates(motion.motion.jacobian.points)
        return {"s1": one * motion.unit, "s2": two * motion.unit}
