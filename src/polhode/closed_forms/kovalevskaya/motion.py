"""The Kovalevskaya top in closed form: states, attitude, period, frequencies.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(2C, 2C, C), r0 = (x0, y0, 0)

(Yehia 3.13-3.17).  w = (p, q, r) and the upward vertical gamma in body axes.  Any start, any time,
any number of digits: generic motion by genus-2 theta functions (Kowalevski, Acta Math. 12 (1889)
177), one-frequency motions by Weierstrass' functions, those on a curve of which an e is -k by sigma
functions.  Units: any consistent set, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import (
    Motion,
    State,
    StateAndTurning,
    Turn,
    Turning,
    halves,
    no_attitude,
    quaternion,
)
from polhode.closed_forms.balls.periodic_attitude import PeriodicAttitude, PeriodicOrbit
from polhode.closed_forms.balls.weierstrass import Weierstrass, WeierstrassSolution
from polhode.closed_forms.kovalevskaya.axes import EQUATIONS, KovalevskayaStart
from polhode.closed_forms.kovalevskaya.branch_points import branch_points
from polhode.closed_forms.kovalevskaya.degenerate import DegenerateState
from polhode.closed_forms.kovalevskaya.jacobian import rates
from polhode.closed_forms.kovalevskaya.place import (
    DEGENERATE,
    ONE_FREQUENCY,
    KovalevskayaPlacement,
    Regime,
    appelrot_numbers,
    quartic,
)
from polhode.closed_forms.kovalevskaya.theta_attitude import ThetaAttitude
from polhode.closed_forms.kovalevskaya.theta_state import ThetaState
from polhode.numbers.exact import ZERO

#: p, q, r, G1, G2, G3 of a complex time.
ComplexState: TypeAlias = Callable[[acb], Sequence[acb]]

_I = acb(0, 1)


def solve(place: KovalevskayaPlacement) -> Motion:
    """The motion in the top's axes and units, at the precision in force."""
    start = place.start
    if place.regime in DEGENERATE:
        return KovalevskayaMotion(place, DegenerateState(start), no_attitude)
    if place.regime in ONE_FREQUENCY:
        return _periodic(place)
    state = ThetaState(start, place.disc)
    return KovalevskayaMotion(place, state, lambda: ThetaAttitude(state, first_turn(place)))


class KovalevskayaMotion(StateAndTurning):
    """A motion of the top."""

    def __init__(
        self,
        place: KovalevskayaPlacement,
        state: State,
        turning: Callable[[], Turning],
        period: arb | None = None,
    ) -> None:
        super().__init__(state, turning, place.start.speed_bound(), period)
        self._place = place

    def curve(self) -> Mapping[str, arb]:
        """H, K^2 = k^2, the points e1, e2, e3 and the period matrix tau of a generic motion."""
        start = self._place.start
        named = {"H": ball(start.H), "K2": ball(start.k2)}
        rows = {"e": branch_points(start, self._place.disc)[:3]}
        if isinstance(self.state, ThetaState):
            rows["tau"] = list(self.state.jacobian.lattice.tau)
        for name, row in rows.items():
            for n, x in enumerate(row):
                named |= {f"{name}{n} real": x.real, f"{name}{n} imag": x.imag}
        return named

    def rates(self) -> Mapping[str, arb]:
        """The motion's frequencies, radians a unit of time.

        Generic motion: "s1" and "s2", the mean rates at which the two separation variables go
        through their cycles; w and gamma repeat when both have made an even number of turns.
        One-frequency motion: "body".  Others: none.
        """
        if not isinstance(self.state, ThetaState):
            return super().rates()
        return dict(zip(("s1", "s2"), rates(self.state.jacobian.points), strict=True))


def first_turn(place: KovalevskayaPlacement) -> Turn:
    """A quaternion of the start's gamma in the top's axes."""
    a, b, c = (x / place.start.weight for x in place.start.G)
    return quaternion(*halves((a, b, c), ZERO))


# --- one frequency --------------------------------------------------------------------------------
#
# One-frequency motions. Symbols as in :mod:`.axes`; every one reduces to y'^2 = f(y):
#
# Delaunay, k = 0:  x = p + iq,  4x'^2 = x^4 - 2H x^2 + 4m x - a^2,  G1 + iG2 = x^2.
# Appelrot's special motion, xh and ro constant:  p = xh + ro cos ps, q = ro sin ps, r = -2 ps',
# G3 = xh r, G1 + iG2 = 2 xh (ro + xh cos ps) exp(i ps),
# E = r^2/4 + 2 xh ro cos ps + xh^2 cos^2 ps, and for y = tan(ps/2)
# y'^2 = [E (1 + y^2)^2 - 2 xh ro (1 - y^4) - xh^2 (1 - y^2)^2]/4.


class _OneFrequency:
    """The state of a motion without a period: it tends to a steady one."""

    def __init__(self, state: ComplexState) -> None:
        self._state = state

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, G1, G2, G3."""
        return [x.real for x in self._state(acb(t))]


def _periodic(place: KovalevskayaPlacement) -> Motion:
    """A motion of one frequency, or one that tends to a steady one."""
    start, kind = place.start, place.regime
    make = _delaunay if kind == Regime.DELAUNAY else _appelrot
    function = Weierstrass(quartic(start, kind))
    state = make(start, function)
    if function.period is None:
        return KovalevskayaMotion(place, _OneFrequency(state), no_attitude)
    orbit = PeriodicOrbit(state, function.period)

    def turning() -> PeriodicAttitude:
        size = ball(start.a2).sqrt()
        attitude = PeriodicAttitude(orbit, size, start.speed_bound(), EQUATIONS, place.strip)
        place.strip = attitude.strip
        return attitude

    return KovalevskayaMotion(place, orbit, turning, function.period)


def _balls(start: KovalevskayaStart) -> list[arb]:
    """w and G."""
    return [ball(x) for x in (*start.omega, *start.G)]


def _delaunay(start: KovalevskayaStart, P: Weierstrass) -> ComplexState:
    p0, q0, r0, _, _, G3 = _balls(start)
    f = quartic(start, Regime.DELAUNAY)
    # x and its conjugate, each analytic in t.
    solutions = []
    for side in (1, -1):
        x0 = acb(p0, side * q0)
        solutions.append(WeierstrassSolution(f, x0, side * _I * (G3 - r0 * x0) / 2, P))
    H, m = ball(start.H), ball(start.m)

    def state(t: acb) -> Sequence[acb]:
        (x, x1), (y, y1) = (solution.value(t) for solution in solutions)
        p, q, p1, q1 = (x + y) / 2, (x - y) / (2 * _I), (x1 + y1) / 2, (x1 - y1) / (2 * _I)
        # q1 r = m - p H + p (p^2 - q^2), q r = 2 p1
        r = (2 * p1 * q + q1 * (m - p * H + p * (p * p - q * q))) / (q * q + q1 * q1)
        return [p, q, r, p * p - q * q, 2 * p * q, 2 * q1 + p * r]

    return state


def _appelrot(start: KovalevskayaStart, P: Weierstrass) -> ComplexState:
    xh, ro, x = (ball(v) for v in appelrot_numbers(start))
    _, q0, r0 = _balls(start)[:3]
    y0 = q0 / (ro + x)  # tan of half of ps
    f = quartic(start, Regime.APPELROT)
    y = WeierstrassSolution(f, acb(y0), acb(-r0 * (1 + y0 * y0) / 4), P)

    def state(t: acb) -> Sequence[acb]:
        Y, Z, moved = y.quotient(t)
        over = 1 / (Z * Z + Y * Y)
        c, s = (Z * Z - Y * Y) * over, 2 * Y * Z * over
        r = -4 * moved * over
        G = 2 * xh * (ro + xh * c)
        return [xh + ro * c, ro * s, r, G * c, G * s, xh * r]

    return state
