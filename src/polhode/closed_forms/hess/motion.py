"""Hess's motion in balls: a spherical pendulum's, in axes that turn about r0.

On the surface Iw.r0 = 0 the vector (M2, M3, 0)/B is the angular velocity w' of axes that have e1 in
common with the body and do not turn about it, and

    B w'' + w' x B w' = gamma x T,    gamma' = gamma x w'    in them:

a sphere's motion with all moments B and without spin.  If f = Iw.gamma = 0 it is a swing in a plane
(:mod:`polhode.closed_forms.pendulum.motion`), else Lagrange's (:mod:`..lagrange.motion`).  The body
turns against these axes about e1 with a12 M2/B.  With z = w'_1 + i w'_2 the angle is 2 arg y,

    y' = i (a12/2) z conj(y),    y(0) = 1,    (M2 + i M3)/B = z conj(y)/y.

* Swing: z = del' n with a constant n; y/sqrt(i n) = Y has Y' = (a12/2) del' conj(Y), so that its
  parts grow as exp(+-a12 (del - del0)/2).
* Steady cone: z = z0 exp(i om t), om = -T f/|M|^2, and y = exp(i om t/2) Y has constant
  coefficients, Y'' = (a12^2 |z0|^2 - om^2) Y/4.
* Else :mod:`.period_map`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits, ball, either_root, enclosed
from polhode.closed_forms.balls.frames import Frame, Start, Turn
from polhode.closed_forms.hess.axes import HessStart
from polhode.closed_forms.hess.period_map import PeriodMap
from polhode.closed_forms.lagrange.motion import Nutating, Seen, Steady, own_start
from polhode.closed_forms.lagrange.regimes import Constants, constants
from polhode.closed_forms.pendulum.conditions import axis_of
from polhode.closed_forms.pendulum.motion import Numbers, Swing, numbers
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.vectors import Vector, quaternion_product

_I = acb(0, 1)
_STILL: Turn = (arb(1), arb(0), arb(0), arb(0))

LIBRATION = "f = 0, libration"
ROTATION = "f = 0, rotation: tends to a plane rotation"
SEPARATRIX = "f = 0, separatrix: tends to rest upright"
CONE_TURNING = "steady cone, turning"
CONE_TENDING = "steady cone, tending to a permanent rotation"
CONE_LIMIT = "steady cone, at the limit of turning"
GENERAL = "f not 0: elliptic gamma1, linear equation"

#: The exact numbers of the sphere's motion.
Sphere: TypeAlias = Numbers | Constants


def sphere(start: HessStart) -> Sphere:
    """Those of a swing where f = 0, else Lagrange's."""
    B = start.B
    if sign(start.f) == 0:
        return numbers((B, B, B), (ZERO, ZERO, start.weight), start.omega, start.gamma)
    return constants(B, B, start.weight, start.omega, start.gamma)


def regime(start: HessStart, exact: Sphere) -> str:
    """The kind of motion, decided by exact arithmetic."""
    if isinstance(exact, Numbers):
        return LIBRATION if exact.librates else ROTATION if sign(exact.kc2) else SEPARATRIX
    if exact.steady:
        side = sign(_excess(exact, start.a12)[1])
        return (CONE_LIMIT, CONE_TURNING, CONE_TENDING)[side]
    return GENERAL


def _excess(c: Constants, a12: Exact) -> tuple[Exact, Exact]:
    """om, and om^2 - a12^2 |z0|^2, of a steady cone."""
    om = -c.a * c.turning / (2 * c.speed2)
    return om, om * om - a12 * a12 * c.speed2


class Spin(Protocol):
    """The body's turn about e1 against the sphere's axes."""

    def at(self, t: arb) -> acb:
        """A positive multiple of y."""
        ...


class HessMotion:
    """The motion at the precision in force."""

    def __init__(self, start: HessStart, exact: Sphere, scene: Start) -> None:
        self._frame, self._scene = start.frame, scene
        begin = Start([ball(x) for x in start.gamma], _STILL)
        self._a12 = ball(start.a12)
        self.sphere: Swing | Steady | Nutating
        self.spin: Spin
        if isinstance(exact, Numbers):
            n = axis_of((ZERO, ZERO, start.weight), start.omega, start.gamma)
            self.sphere = swing = Swing(exact, n, begin)
            self.spin = PlaneSpin(swing, n, self._a12)
        else:
            seen = Seen(Frame(), begin, arb(0), own_start(start.omega, start.gamma))
            if exact.steady:
                self.sphere = Steady(exact, seen)
                self.spin = ConeSpin(exact, seen, start.a12)
            else:
                self.sphere = nutating = Nutating(exact, seen)
                self.spin = PeriodMap(nutating, enclosed(exact.a), self._a12)
        self.speed = self.sphere.speed * (1 + self._a12 * self._a12).sqrt()

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """The row at a time."""
        del attitude
        p, q, _, g1, g2, g3, *turn = self.sphere.row(t, attitude=True)
        y = self.spin.at(t)
        size = abs(y)
        if not size > 0:
            raise TooFewBits
        y = y / size
        back = (y * y).conjugate()
        w, g = acb(p, q) * back, acb(g1, g2) * back
        s0, s1, s2, s3 = turn
        body = quaternion_product((s0, s1, s2, s3), (y.real, arb(0), arb(0), y.imag))
        assert self._scene.attitude is not None
        return (
            *self._frame.back((w.real, w.imag, self._a12 * w.real)),
            *self._frame.back((g.real, g.imag, g3)),
            *quaternion_product(self._scene.attitude, self._frame.turn(body)),
        )


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
            one, two = arb(1), (-2 * grown).exp()
        else:
            one, two = (2 * grown).exp(), arb(1)
        return self._unit * acb(one * self._unit.real, -two * self._unit.imag)


class ConeSpin:
    """y over a steady cone."""

    def __init__(self, c: Constants, seen: Seen, a12: Exact) -> None:
        om, excess = _excess(c, a12)
        self._side = sign(excess)
        #: How fast Y turns, or half of how fast its direction tends to a constant one.
        self.rate = abs(ball(excess)).sqrt() / 2
        self._om, self._pull = ball(om), _I * ball(a12) * seen.own[2] / 2

    def at(self, t: arb) -> acb:
        """A positive multiple of y."""
        if self._side > 0:
            s, c = (self.rate * t).sin_cos()
            s = s / self.rate
        elif self._side < 0:  # over cosh
            s, c = (self.rate * t).tanh() / self.rate, arb(1)
        else:
            s, c = t, arb(1)
        turned = acb(0, self._om / 2)
        return (turned * t).exp() * (c + s * (self._pull - turned))
