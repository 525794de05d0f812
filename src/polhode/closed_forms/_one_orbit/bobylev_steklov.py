"""Bobylev and Steklov's motions in closed form: A = 2C, any B, the centre of mass on axis 1.

With T = Mg r0 = (x, 0, 0) and k = x/C, a start with q = 0 and k gamma3 = p r keeps both; p and
Ga = gamma1 + r^2/2k are constant, and

    gamma1 = Ga - r^2/2k,    gamma2 = -r'/k,    gamma3 = p r/k,
    4 r'^2 = (R1 - r^2)(r^2 - R2),    R1 + R2 = 2b,  R1 R2 = -e,
    b = 2 (k Ga - p^2),  e = 4 k^2 (1 - Ga^2)

(D. K. Bobylev 1896 and V. A. Steklov 1896 for A = 2C; the moment B does not enter;
``tests/closed_forms/test_coefficients.py`` proves that they solve the equations, identically in r
and in all constants).  With
v = v0 + nu t

    Ga^2 < 1:   r = sqrt(R1) cn v,        m = R1/(R1 - R2),    nu = sqrt(R1 - R2)/2;
    Ga^2 >= 1:  r = +-sqrt(R1) dn v,      m = (R1 - R2)/R1,    nu = sqrt(R1)/2;

Ga = 1 is asymptotic to the rotation p about the upright axis 1: r = +-sqrt(R1) sech v
(:class:`Asymptotic`).  The axes are taken so that x > 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum

from flint import acb, arb

from polhode.closed_forms._one_orbit.orbits import EllipticTime, Formula, OrbitCase, orbit_family
from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import MotionAxes, SolvedMotion, Turn, conjugate, quaternion
from polhode.closed_forms.balls.jacobi import Jacobi
from polhode.closed_forms.balls.weierstrass import complex_functions
from polhode.closed_forms.membership import Condition, NormalScene, PrincipalScene, equal, exclusion
from polhode.common.values import cached_property
from polhode.numbers.exact import ZERO, Exact, sign, sqrt
from polhode.numbers.number_types import Scalar
from polhode.numbers.vectors import cross, is_zero, quaternion_product
from polhode.scenes.body import KOVALEVSKAYA, classical_top, with_last


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """A = 2C, the centre on axis 1, q = 0 and x0 gamma3 Mg = C p r; not a rotation."""
    A, _, C = scene.moments
    p, q, r = scene.omega
    yield equal("A = 2C", A, 2 * C)
    yield from scene.centred_on_axis_1()
    yield equal("q = 0", q, 0, lambda: scene.speed)
    k = scene.torque[0] / C
    yield equal("Mg x0 gamma3 = C p r", k * scene.gamma[2], p * r, k)
    still = is_zero(scene.moment) and is_zero(cross(scene.gamma, scene.omega))
    yield exclusion("no permanent rotation", still)


def state_of(p: Scalar, Ga: Scalar, k: Scalar, r: Scalar, slope: Scalar) -> Sequence[Scalar]:
    """p, q, r, gamma1, gamma2, gamma3 for any scalars; ``slope``: r'."""
    return p, 0 * r, r, Ga - r * r / (2 * k), -slope / k, p * r / k


class Asymptotic(SolvedMotion):
    """The motion that tends to the rotation p, at one precision; r = 2 side nu sech v."""

    def __init__(
        self, clock: EllipticTime, formula: Formula, p: arb, side: int, speed: arb
    ) -> None:
        self.speed = speed
        self._functions, self._formula = Jacobi(arb(1), arb(0)), formula
        self._nu, self._p, self._side = root(clock.rate2), p, side
        self._v0 = clock.phase(self._functions)
        self._first = conjugate(self._place(self._v0, arb(0)))

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, gamma1, gamma2, gamma3."""
        v = acb(self._v0 + self._nu * t)
        return [x.real for x in self._formula(*complex_functions(self._functions, v))]

    def turn(self, t: arb) -> Turn:
        """The turn since t = 0."""
        c, y, z, x = quaternion_product(
            self._first, self._place(self._v0 + self._nu * t, self._p * t / 2)
        )
        return c, x, y, z

    def _place(self, v: arb, half_angle: arb) -> Turn:
        """A quaternion of axes 2, 3, 1 that solves the equations, the turns about axis 1 apart."""
        phase = acb(0, half_angle).exp() / (self._p * self._p + self._nu * self._nu).sqrt()
        return quaternion(
            acb(self._p, self._nu * v.tanh()) * phase, self._side * self._nu * v.sech() * phase
        )


class Regime(StrEnum):
    """The kinds of motion."""

    SWINGING = "Bobylev-Steklov, r changes its sign"
    TURNING = "Bobylev-Steklov, r keeps its sign"
    ASYMPTOTIC = "Bobylev-Steklov, asymptotic to a rotation about the vertical"


_BY_SIGN = (Regime.ASYMPTOTIC, Regime.SWINGING, Regime.TURNING)


class BobylevSteklov(OrbitCase):
    """One motion of Bobylev and Steklov."""

    conditions = staticmethod(conditions)

    @classmethod
    def views(cls, scene: PrincipalScene) -> Iterator[tuple[MotionAxes, PrincipalScene]]:
        """Of Kovalevskaya's body also the axes of which one goes through the centre of mass."""
        yield from super().views(scene)
        moments, torque, omega, gamma = scene
        kind, axis = classical_top(moments, torque)
        if kind != KOVALEVSKAYA or axis is None or gamma is None:
            return
        i, j, k = with_last(axis)
        if sign(torque[i]) and sign(torque[j]):
            frame = MotionAxes.equatorial((i, j, k), torque[i], torque[j])
            permuted = moments[i], moments[j], moments[k]
            yield frame, PrincipalScene(permuted, *map(frame.into, (torque, omega, gamma)))

    def _regime(self) -> Regime:
        return _BY_SIGN[sign(1 - self._level * self._level)]

    @cached_property
    def _k(self) -> Exact:
        return self.normal.torque[0] / self.normal.moments[2]

    @cached_property
    def _level(self) -> Exact:
        """Ga."""
        r = self.normal.omega[2]
        return self.normal.gamma[0] + r * r / (2 * self._k)

    def solve(self) -> SolvedMotion:
        """The constants are exact, each without cancellation."""
        p, _, r = self.normal.omega
        Ga, k = self._level, self._k
        b, e = 2 * (k * Ga - p * p), 4 * k * k * (1 - Ga * Ga)
        side, width, up = sign(e), sqrt(b * b + e), sign(self.normal.gamma[1]) or 1
        R1 = b + width if sign(b) > 0 else e / (width - b)
        R2 = -e / R1 if side else ZERO
        if side > 0:
            m, m1, cn2 = R1 / (2 * width), -R2 / (2 * width), r * r / R1
            squares = 1 - cn2, cn2, m1 + m * cn2
            clock = EllipticTime(m, m1, (up, sign(r)), squares, width / 2)
        else:
            m, m1 = 2 * width / R1, R2 / R1
            squares = (R1 - r * r) / (2 * width), (r * r - R2) / (2 * width), r * r / R1
            clock = EllipticTime(m, m1, (up * sign(r), 1), squares, R1 / 4)
        scale = root(R1) * (1 if side > 0 else sign(r))
        p0, g, k0, fall = ball(p), ball(Ga), ball(k), -scale * root(clock.rate2)
        m0 = ball(m)

        def state(sn: acb, cn: acb, dn: acb) -> Sequence[acb]:
            r, slope = (cn, sn * dn) if side > 0 else (dn, m0 * sn * cn)
            r, slope = scale * r, fall * slope
            return state_of(p0, g, k0, r, slope)

        if side:
            return self._on(clock.orbit(state, 4 if side > 0 else 2))
        return Asymptotic(clock, state, p0, sign(r), self._speed())


FAMILY = orbit_family("bobylev-steklov", BobylevSteklov)
