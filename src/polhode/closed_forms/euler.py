"""The torque-free rigid body (Euler's top) in closed form.

    I w' + w x I w = 0,    gamma' = gamma x w            (Yehia 3.13-3.17 without weight)

Any body, any start, any time, any number of digits, each of them proven.  Principal axes are
numbered for the motion (:func:`numbered`): the polhode circles axis 3, which belongs to the largest
or the smallest moment, and axis 2 to the middle one.  With 2h = w.Iw and G = |Iw| (Whittaker,
Analytical Dynamics, art. 69; van Zon and Schofield, J. Comput. Phys. 225 (2007) 145, section 3)

    P = 2h I3 - G^2,  R = G^2 - 2h I1,  k^2 = (I2-I1)P/((I3-I2)R),  rate^2 = (I3-I2)R/(I1 I2 I3),
    w = (s1 p_m cn v, s2 q_m sn v, s3 r_m dn v),  v = v0 + rate t.

In space axes of which the third is along G, Iw/G = (s1 sin th cos chi, -s1 sin th sin chi, cos th)
has the angles z-y-z of the attitude.  Half of each is linear in time, but for the root of a number
in the right half plane, whose principal value is continuous.

The third body axis has the projection -s1 sin th exp(i psi) on the plane across G, a quotient of
theta functions times a uniform turn (Jacobi), and the vertical gamma one that stays.  Its modulus
squared is 1 - g3^2 dn^2 v ~ 1 + (g3^2/(1 - g3^2)) k^2 sn^2 v, g3 = I3 r_m/G: so
(:mod:`.balls.jacobi`) sc(a, k')^2 = g3^2/(1 - g3^2), and sn(a, k')^2 = g3^2 = I3 R/(G^2 (I3 - I1)).
Its rate is psi' = (Z x e3).(w x e3)/|Z x e3|^2 = G (2h - I3 r^2)/(G^2 - I3^2 r^2), Z = Iw/G, which
is G/I3 + G P/(I3 (G^2 - I3^2 r^2)), whose second term is 0 where w is infinite: G/I3 and the
quotient's L make the uniform turn.  So their product H, the second conjugated, is such
a quotient, -e3.(gamma - u Z) + i Z.(e3 x gamma); it and gamma.Z = u give

    H = u Z3 - gamma3 + i (gamma1 Z2 - gamma2 Z1),    gamma3 = u Z3 - Re H,
    (gamma1, gamma2) = u (Z1, Z2) + (Re H Z3 (Z1, Z2) + Im H (Z2, -Z1))/(Z1^2 + Z2^2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from functools import partial
from typing import NamedTuple

from flint import acb, arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import (
    Latest,
    MotionAxes,
    PermanentRotation,
    SolvedMotion,
    Turn,
    conjugate,
    quaternion,
)
from polhode.closed_forms.balls.jacobi import Jacobi, ReducedArgument, Shift
from polhode.closed_forms.membership import Family, Misfit, Placement, PrincipalScene
from polhode.numbers.exact import ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, dot, is_zero, quaternion_product

_ODD = ((0, 2, 1), (1, 0, 2), (2, 1, 0))
_I = acb(0, 1)
_QUARTERS = (acb(1), _I, acb(-1), -_I)


class Regime(StrEnum):
    """The kinds of motion."""

    REST = "rest"
    SPHERE = "sphere"
    ABOUT_SYMMETRY = "permanent rotation about the symmetry axis"
    ABOUT_EQUATOR = "permanent rotation about an equatorial axis"
    OBLATE = "axisymmetric, oblate: regular precession"
    PROLATE = "axisymmetric, prolate: regular precession"
    ABOUT_SMALLEST = "permanent rotation about the smallest-moment axis"
    ABOUT_MIDDLE = "permanent rotation about the middle-moment axis"
    ABOUT_LARGEST = "permanent rotation about the largest-moment axis"
    SEPARATRIX = "separatrix"
    AROUND_LARGEST = "polhode about the largest-moment axis"
    AROUND_SMALLEST = "polhode about the smallest-moment axis"


_BY_RANK = (Regime.ABOUT_SMALLEST, Regime.ABOUT_MIDDLE, Regime.ABOUT_LARGEST)


def is_permanent(I: Sequence[Exact], w: Sequence[Exact]) -> bool:
    """Whether w x Iw = 0."""
    return all(sign((I[i] - I[j]) * w[i] * w[j]) == 0 for i, j in ((0, 1), (1, 2), (2, 0)))


def regime(I: Sequence[Exact], w: Sequence[Exact], side: int) -> Regime:
    """The kind of motion; ``side``: the sign of G^2 - 2hB, B the middle moment."""
    if all(sign(x) == 0 for x in w):
        return Regime.REST
    permanent = is_permanent(I, w)
    equal = [(i, j) for i, j in ((0, 1), (1, 2), (2, 0)) if sign(I[i] - I[j]) == 0]
    if len(equal) > 1:
        return Regime.SPHERE
    if equal:
        i, j = equal[0]
        k = 3 - i - j
        if permanent:
            return Regime.ABOUT_SYMMETRY if sign(w[k]) else Regime.ABOUT_EQUATOR
        return Regime.OBLATE if I[k] > I[i] else Regime.PROLATE
    if permanent:
        (k,) = (i for i in range(3) if sign(w[i]))
        return _BY_RANK[sum(I[j] < I[k] for j in range(3))]
    if side == 0:
        return Regime.SEPARATRIX
    return Regime.AROUND_LARGEST if side > 0 else Regime.AROUND_SMALLEST


def numbered(I: Sequence[Exact], w: Sequence[Exact]) -> tuple[tuple[int, ...], int]:
    """The principal axes in the order of the motion, and the sign of G^2 - 2hB (B the middle one).

    The third is the axis that the polhode circles, of the largest moment where G^2 >= 2hB and of
    the smallest where G^2 < 2hB; the second is that of B.
    """
    ranking = sorted(range(3), key=I.__getitem__)
    middle = I[ranking[1]]
    side = sign(sum((I[i] * (I[i] - middle) * w[i] * w[i] for i in range(3)), ZERO))
    if side < 0:
        ranking.reverse()
    return tuple(ranking), side


class PolhodeNumbers(NamedTuple):
    """The exact numbers of a motion that is no permanent rotation; no square is negative.

    Triples of squares are those of sn, cn, dn: of the phase at t = 0 to the modulus k, and of the
    imaginary shift to k'.
    """

    moments: Vector
    G2: Exact
    k2: Exact
    kc2: Exact
    rate2: Exact
    squares: Vector  # of the amplitudes of w
    phase: Vector
    shift: Vector
    signs: tuple[int, int, int]  # of the amplitudes
    side: int  # of the phase at t = 0
    sense: int  # 1 where the third moment is the largest, -1 where it is the smallest


def numbers(I: Vector, w: Vector) -> PolhodeNumbers:
    """The numbers of moments and w in the axes numbered for the motion."""
    I1, I2, I3 = I
    m1, m2, m3 = (a * x for a, x in zip(I, w, strict=True))
    d21, d31, d32 = I2 - I1, I3 - I1, I3 - I2
    G2 = m1 * m1 + m2 * m2 + m3 * m3
    # P, R and G^2 - 2h I2 as sums over two axes: irrational data then cancel as little as may be.
    P = m1 * w[0] * d31 + m2 * w[1] * d32
    R = m2 * w[1] * d21 + m3 * w[2] * d31
    D = m3 * w[2] * d32 - m1 * w[0] * d21
    p2, q2, r2 = P / (I1 * d31), P / (I2 * d32), R / (I3 * d31)
    s1, s3 = (1 if sign(x) >= 0 else -1 for x in (w[0], w[2]))
    s2 = sign(d32) * s1 * s3
    return PolhodeNumbers(
        moments=I,
        G2=G2,
        k2=d21 * P / (d32 * R),
        kc2=d31 * D / (d32 * R),
        rate2=d32 * R / (I1 * I2 * I3),
        squares=(p2, q2, r2),
        phase=(w[1] * w[1] / q2, w[0] * w[0] / p2, w[2] * w[2] / r2),
        shift=(I3 * R / (G2 * d31), I1 * P / (G2 * d31), I2 * P / (G2 * d32)),
        signs=(s1, s2, s3),
        side=s2 * (sign(w[1]) or 1),
        sense=sign(d31),
    )


# --- placing --------------------------------------------------------------------------------------
#
# Which scenes are a torque-free body's, and their axes.


def place(scene: PrincipalScene) -> Placement | None:
    """A body on which the weight has no moment."""
    moments, torque, omega, gamma = scene
    if not is_zero(torque):
        return None
    order, side = numbered(moments, omega)
    kind = regime(moments, omega, side)
    if is_permanent(moments, omega):
        return Placement(
            regime=kind,
            solve=partial(_permanent_rotation, omega, gamma),
            rates_of={"precession": "of the body about omega"},
        )
    a, b, c = (moments[i] for i in order)
    frame = MotionAxes().numbered(order, (1, -1 if order in _ODD else 1, 1))
    exact = numbers((a, b, c), frame.into(omega))
    which = "largest" if exact.sense > 0 else "smallest"
    axis = f"principal axis {order[2] + 1} (of the {which} moment)"
    return Placement(
        regime=kind,
        solve=partial(Polhode, exact, None if gamma is None else frame.into(gamma)),
        frame=frame,
        rates_of={"precession": f"of {axis} about the angular momentum"},
    )


def misfit(scene: PrincipalScene) -> Misfit | None:
    """By how much the weight has a moment, beside A |w|^2 with the largest moment of inertia."""
    if is_zero(scene.torque):
        return None
    pull = sqrt(dot(scene.torque, scene.torque))
    return Misfit("Mg r0 = 0", pull / (pull + max(scene.moments) * dot(scene.omega, scene.omega)))


# --- motion ---------------------------------------------------------------------------------------


def _permanent_rotation(omega: Vector, vertical: Vector | None) -> SolvedMotion:
    """A permanent rotation, rest or the motion of a sphere."""
    half = root(dot(omega, omega)) / 2
    return PermanentRotation(omega, half, vertical, precession=2 * half)


class Polhode(SolvedMotion):
    """The general motion; k = 0 (two equal moments) and k' = 0 (the separatrix) included.

    ``vertical``: at t = 0; None where it is not known.
    """

    def __init__(self, n: PolhodeNumbers, vertical: Vector | None) -> None:
        self._has_vertical = vertical is not None
        self.elliptic = Jacobi(ball(n.k2), ball(n.kc2))
        self.rate, momentum = root(n.rate2), root(n.G2)
        self._sense, (self._s1, s2, self._s3) = n.sense, n.signs
        amplitudes = [s * root(x) for s, x in zip(n.signs, n.squares, strict=True)]
        self.speed = root(n.squares[0] + n.squares[1] + n.squares[2])
        self._forward = self._s1 * s2 < 0  # the sense of chi
        self._v0 = self.elliptic.argument(map(ball, n.phase), n.side)
        shift = self.elliptic.argument(map(ball, n.shift))
        self._shift = Shift(self.elliptic, shift, half=False)
        turning = self._sense * self._shift.rate * self.rate
        #: The mean rate of the third axis about G.
        self.precession = momentum / ball(n.moments[2]) + turning
        self._rates = [momentum / ball(m) for m in n.moments]  # w over Iw/G
        self._momentum = [x / rate for x, rate in zip(amplitudes, self._rates, strict=True)]
        self._g = tuple(map(abs, self._momentum))
        self._place = Latest(lambda t: self.elliptic.at(self._v0 + self.rate * t))
        if not self.elliptic.limit:
            self.period = 4 * self.elliptic.K / self.rate
        begin = self.elliptic.at(self._v0)
        self._begin = conjugate(self._attitude(begin, arb(0)))
        if vertical is not None:
            self._along, across = _projections(self._direction(begin), [ball(x) for x in vertical])
            self._across = across / self._turned(begin, arb(0))

    def at(self, t: arb) -> Sequence[arb]:
        """w, and the vertical where it is known."""
        place = self._place(t)
        direction = self._direction(place)
        omega = [x * rate for x, rate in zip(direction, self._rates, strict=True)]
        return (*omega, *self._vertical_at(direction, place, t)) if self._has_vertical else omega

    def turn(self, t: arb) -> Turn:
        """The turn since t = 0."""
        return quaternion_product(self._begin, self._attitude(self._place(t), t))

    def rates(self) -> Mapping[str, arb]:
        """Mean rates in radians a unit of time.

        "polhode": of w in the body (absent where w has no period); "precession": of the axis that
        the polhode circles, about G.
        """
        if self.elliptic.limit:
            return {"precession": self.precession}
        polhode = arb.pi() * self.rate / (2 * self.elliptic.K)
        return {"precession": self.precession, "polhode": polhode}

    def _direction(self, at: ReducedArgument) -> tuple[arb, arb, arb]:
        """Iw/G."""
        (a, b, c), (sn, cn, dn) = self._momentum, at.functions
        return at.side * (a * cn), at.side * (b * sn), c * dn

    def _turned(self, at: ReducedArgument, t: arb) -> acb:
        """The projection of the third axis across G, but for a factor that stays."""
        theta = self._shift.at(at)
        sine, cosine = (self.precession * t).sin_cos()
        return (theta if self._sense > 0 else theta.conjugate()) * acb(cosine, sine)

    def _vertical_at(
        self, direction: tuple[arb, arb, arb], at: ReducedArgument, t: arb
    ) -> tuple[arb, arb, arb]:
        """gamma."""
        z1, z2, z3 = direction
        across = self._across * self._turned(at, t)
        real, imaginary, along = across.real, across.imag, self._along
        square = z1 * z1 + z2 * z2
        same, crossed = along + real * z3 / square, imaginary / square
        return z1 * same + z2 * crossed, z2 * same - z1 * crossed, along * z3 - real

    def _attitude(self, at: ReducedArgument, t: arb) -> Turn:
        """The quaternion body -> space in axes of space of which the third is along G."""
        (g1, g2, g3), (sn, cn, dn) = self._g, at.functions
        x, y = g1 * cn, g2 * sn
        near = ((1 + g3 * dn) / 2).sqrt()
        far = (x * x + y * y).sqrt() / (2 * near)
        cos, sin = (near, far) if self._s3 > 0 else (far, near)
        theta = self._shift.at(at)
        psi = _half_argument(theta if self._sense > 0 else theta.conjugate())
        psi *= (_I * (self.precession * t / 2)).exp()
        chi = _half_argument(acb(x, y)) * _QUARTERS[at.n % 4]
        if not self._forward:
            chi = chi.conjugate()
        return quaternion(psi * chi * cos, psi * chi.conjugate() * (-self._s1 * sin) * _I)


def _projections(z: Sequence[arb], gamma: Sequence[arb]) -> tuple[arb, acb]:
    """u and H of the vertical; H of its part across z3, which may be all that is not small."""
    (z1, z2, z3), (g1, g2, g3) = z, gamma
    level = z1 * g1 + z2 * g2
    across = acb(z3 * level - g3 * (z1 * z1 + z2 * z2), g1 * z2 - g2 * z1)
    return level + z3 * g3, across


def _half_argument(z: acb) -> acb:
    """exp of i/2 times the argument of z, whose real part is positive."""
    return (z / abs(z)).sqrt()


FAMILY = Family("euler", place, misfit)
