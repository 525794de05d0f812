"""Hess's motion in balls: a spherical pendulum's, in axes that turn about r0.

On the surface Iw.r0 = 0 the vector (M2, M3, 0)/B is the angular velocity w' of axes that have e1 in
common with the body and do not turn about it, and

    B w'' + w' x B w' = gamma x T,    gamma' = gamma x w'    in them:

a sphere's motion with all moments B and without spin.  If f = Iw.gamma = 0 it is a swing in a plane
(:mod:`polhode.closed_forms.pendulum`), else Lagrange's (:mod:`..lagrange.motion`).  The body
turns against these axes about e1 with a12 M2/B.  With z = w'_1 + i w'_2 the angle is 2 arg y,

    y' = i (a12/2) z conj(y),    y(0) = 1,    (M2 + i M3)/B = z conj(y)/y.

* Swing: z = del' n with a constant n; y/sqrt(i n) = Y has Y' = (a12/2) del' conj(Y), so that its
  parts grow as exp(+-a12 (del - del0)/2).
* Steady cone: z = z0 exp(i om t), om = -T f/|M|^2, and y = exp(i om t/2) Y has constant
  coefficients, Y'' = (a12^2 |z0|^2 - om^2) Y/4.
* Else :mod:`.period_map`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits, ball, either_root, enclosed
from polhode.closed_forms.balls.frames import Latest, Motion, Turn
from polhode.closed_forms.hess.period_map import PeriodMap
from polhode.closed_forms.hess.place import HessPlacement, Regime, cone
from polhode.closed_forms.lagrange.motion import Nutating, Parameters, Steady, own_start
from polhode.closed_forms.lagrange.place import Constants
from polhode.closed_forms.pendulum import Swing, SwingNumbers, axis_of
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.vectors import Vector, quaternion_product

_I = acb(0, 1)


class Spin(Protocol):
    """The body's turn about e1 against the sphere's axes."""

    def at(self, t: arb) -> acb:
        """A positive multiple of y."""
        ...


class HessMotion(Motion):
    """The motion at the precision in force."""

    def __init__(self, place: HessPlacement) -> None:
        self._place, self._a12 = place, ball(place.a12)
        self.sphere: Swing | Steady | Nutating
        self.spin: Spin
        exact = place.sphere
        if isinstance(exact, SwingNumbers):
            n = axis_of((ZERO, ZERO, place.weight), place.omega, place.gamma)
            self.sphere = swing = Swing(exact, n, [ball(x) for x in place.gamma])
            self.spin = PlaneSpin(swing, n, self._a12)
            if swing.librates:
                self.period = swing.period
        else:
            start = own_start(place.omega, place.gamma)
            if exact.steady:
                self.sphere = Steady(exact, start)
                self.spin = cone_spin = ConeSpin(exact, start, place.a12)
                if place.regime == Regime.CONE_TURNING:
                    self.period = arb.pi() / cone_spin.rate
            else:
                self.sphere = nutating = Nutating(exact, start)
                self.spin = PeriodMap(nutating, enclosed(exact.a), self._a12)
        self.speed = self.sphere.speed * (1 + self._a12 * self._a12).sqrt()
        self._y = Latest(self._y_at)

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, gamma1, gamma2, gamma3."""
        p, q, _, g1, g2, g3 = self.sphere.at(t)
        y = self._y(t)
        back = (y * y).conjugate()
        w, g = acb(p, q) * back, acb(g1, g2) * back
        return w.real, w.imag, self._a12 * w.real, g.real, g.imag, g3

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn since t = 0."""
        y = self._y(t)
        turn = (y.real, arb(0), arb(0), y.imag)
        return quaternion_product(self.sphere.turn(t, state), turn)

    def _y_at(self, t: arb) -> acb:
        """y/|y|."""
        y = self.spin.at(t)
        size = abs(y)
        if not size > 0:
            raise TooFewBits
        return y / size

    def rates(self) -> Mapping[str, arb]:
        """Of the general motion "nutation", of the angle between r0 and the vertical.

        Where it does not tend to a periodic motion also "turning", of the second phase, known
        modulo the first.
        """
        spin = self.spin
        if not isinstance(spin, PeriodMap):
            return super().rates()
        rates = {"nutation": 2 * arb.pi() / spin.period}
        if not _tends(spin):
            rates["turning"] = 2 * (spin.trace / 2).acos() / spin.period
        return rates

    def approach(self) -> arb | None:
        """Of a plane rotation and of a cone that tends to a permanent rotation too."""
        sphere, spin, regime = self.sphere, self.spin, self._place.regime
        if isinstance(spin, PeriodMap):
            return 2 * (spin.trace / 2).acosh() / spin.period if _tends(spin) else None
        if isinstance(spin, ConeSpin) and regime == Regime.CONE_TENDING:
            return 2 * spin.rate
        if isinstance(sphere, Swing) and regime == Regime.ROTATION:
            # y's parts grow apart as exp(a12 del), and del by 2 pi while v by 2K.
            return abs(self._a12) * arb.pi() * sphere.rate / sphere.elliptic.K
        return None


def _tends(spin: PeriodMap) -> bool:
    """Whether |tr N| > 2."""
    if not (spin.trace > 2 or spin.trace < 2):
        raise TooFewBits
    return bool(spin.trace > 2)


class PlaneSpin:
    """y over a swing about ``n``."""

    def __init__(self, swing: Swing, n: Vector, a12: arb) -> None:
        self._swing, self._a12 = swing, a12
        # Unnormed: of an axis along e3 one part of Y stays the exact 0.
        self._unit = either_root(_I * acb(ball(n[0]), ball(n[1])))

    def at(self, t: arb) -> acb:
        """A positive multiple of y."""
        grown = self._a12 * self._swing.swung(t)
        if grown.mid() > 0:
            growing, decaying = arb(1), (-2 * grown).exp()
        else:
            growing, decaying = (2 * grown).exp(), arb(1)
        return self._unit * acb(growing * self._unit.real, -decaying * self._unit.imag)


class ConeSpin:
    """y over a steady cone."""

    def __init__(self, c: Constants, start: Parameters, a12: Exact) -> None:
        om, excess = cone(c, a12)
        self._side = sign(excess)
        #: How fast Y turns, or half of how fast its direction tends to a constant one.
        self.rate = abs(ball(excess)).sqrt() / 2
        self._om, self._pull = ball(om), _I * ball(a12) * start[2] / 2

    def at(self, t: arb) -> acb:
        """A positive multiple of y."""
        if self._side > 0:
            s, c = (self.rate * t).sin_cos()
            s = s / self.rate
        elif self._side < 0:  # over cosh
            s, c = (self.rate * t).tanh() / self.rate, arb(1)
        else:
            s, c = t, arb(1)
        rate = acb(0, self._om / 2)
        return (rate * t).exp() * (c + s * (self._pull - rate))
