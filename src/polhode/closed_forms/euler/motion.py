"""The torque-free rotation at one precision: angular velocity and turn, in the moments' own axes.

``I w' + w x I w = 0`` in principal axes numbered for the motion (by
:mod:`polhode.closed_forms.euler.top`): the polhode circles axis 3, which belongs to the
largest or the smallest moment, and axis 2 to the middle one.  The turn from time 0 to t is a
quaternion, scalar first, in the axes of the body at time 0, or at t: a turn's own axis is the same
in both.

With 2h = w.Iw and G = |Iw| (Whittaker, Analytical Dynamics, art. 69; van Zon and Schofield,
J. Comput. Phys. 225 (2007) 145, section 3)

    P = 2h I3 - G^2,  R = G^2 - 2h I1,  k^2 = (I2-I1)P/((I3-I2)R),  rate^2 = (I3-I2)R/(I1 I2 I3),
    w = (s1 p_m cn v, s2 q_m sn v, s3 r_m dn v),  v = v0 + rate t.

Every constant that a difference could spoil comes here as the square of an exact number.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from polhode.closed_forms.functions.jacobi import (
    MP,
    Jacobi,
    Quotient,
    SeriesFunctions,
    jacobi,
    quotient,
)
from polhode.closed_forms.functions.quaternion import AnyVector, Quaternion, product
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar


@dataclass(frozen=True)
class PermanentRotation:
    """w constant: the body turns uniformly about it (Rodrigues' formula)."""

    omega: AnyVector
    half: Scalar  # |w|/2
    axis: AnyVector  # w/|w|, or zero at rest

    def state(self, t: Scalar, fn: SeriesFunctions) -> tuple[AnyVector, Quaternion]:
        """w at t, and the turn from time 0 to t as a quaternion continuous in t."""
        c, s = fn.cos_sin(self.half * t)
        x, y, z = self.axis
        return self.omega, (c, s * x, s * y, s * z)

    def floats(self, speed: Any) -> PermanentRotation:
        """The same with Python floats, time in units of 1/speed."""
        omega = tuple(x / speed for x in self.omega)
        return PermanentRotation(_floats(omega), float(self.half / speed), _floats(self.axis))


@dataclass(frozen=True)
class Polhode:
    """The general motion; k = 0 (two equal moments) and k' = 0 (the separatrix) included."""

    elliptic: Jacobi
    shift: Quotient
    rate: Scalar
    v0: Scalar
    omega: AnyVector  # the amplitudes, with their signs
    momentum: AnyVector  # the same times I/G
    ellipse: tuple[Scalar, Scalar]  # |momentum| 1 and 2 over the larger: no double of it underflows
    precession: Scalar  # of axis 3 about G, but for what ``jump`` and ``shift`` add
    jump: Scalar  # of psi with every half period 2K
    backward: bool  # the smallest moment is the third: the quotient enters conjugated
    sense: int  # s1 s2
    start: Quaternion = (1, 0, 0, 0)  # inverse of the place at t = 0

    def state(self, t: Scalar, fn: SeriesFunctions) -> tuple[AnyVector, Quaternion]:
        """w at t, and the turn from time 0 to t as a quaternion continuous in t."""
        omega, place = self.place(t, fn)
        return omega, product(self.start, place)

    def place(self, t: Scalar, fn: SeriesFunctions) -> tuple[AnyVector, Quaternion]:
        """w, and the quaternion body -> space in the space axes whose third is along G.

        Euler angles z-y-z: Iw/G = (s1 sin th cos phi, -s1 sin th sin phi, cos th).
        With psi and phi continuous, cos th/2 exp i(psi+phi)/2 and sin th/2 exp i(psi-phi)/2 are
        continuous, hence the quaternion.  Each angle is a linear part, half turns counted by n, and
        the argument of a point of the right half plane, whose half has no branch to choose.
        """
        waves = self.elliptic.waves(self.v0 + self.rate * t, fn)
        sn, cn, dn = self.elliptic.functions(waves)
        n = waves.turns
        odd = n % 2
        sign = 1 - 2 * odd
        a, b, c = self.omega
        omega = (sign * a * cn, sign * b * sn, c * dn)

        one, two, three = self.momentum
        z1, z2, z3 = one * cn, two * sn, three * dn
        across2 = z1 * z1 + z2 * z2  # sin^2 th, never 0
        larger = (1 + abs(z3)) / 2
        near, far = fn.sqrt(larger), fn.sqrt(across2 / (4 * larger))
        cos_th, sin_th = (near, far) if three > 0 else (far, near)

        x, y = self.shift.at(waves)
        c1, s1 = _half(x, -y if self.backward else y, fn)
        c2, s2 = fn.cos_sin((self.precession * t + self.jump * n) / 2)
        psi = c1 * c2 - s1 * s2, s1 * c2 + c1 * s2
        # chi = n pi + atan2(|z2|, |z1|), phi = -sense chi; exp(i n pi/2) by n modulo 4.
        wide, high = self.ellipse
        c3, s3 = _half(wide * cn, high * sn, fn)
        turn = 1 - (n % 4 - odd)
        still, quarter = turn * (1 - odd), turn * odd
        c4, s4 = still * c3 - quarter * s3, still * s3 + quarter * c3
        phi = c4, -self.sense * s4
        sin_th = -sin_th if one > 0 else sin_th
        return omega, (
            cos_th * (psi[0] * phi[0] - psi[1] * phi[1]),
            -sin_th * (psi[1] * phi[0] - psi[0] * phi[1]),
            sin_th * (psi[0] * phi[0] + psi[1] * phi[1]),
            cos_th * (psi[1] * phi[0] + psi[0] * phi[1]),
        )

    def angles(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The continuous psi and phi of :meth:`place`, to a constant each."""
        waves = self.elliptic.waves(self.v0 + self.rate * t, MP)
        sn, cn, _ = self.elliptic.functions(waves)
        x, y = self.shift.at(waves)
        psi = mpmath.atan2(-y if self.backward else y, x)
        chi = mpmath.atan2(self.ellipse[1] * sn, self.ellipse[0] * cn)
        n = waves.turns
        return self.precession * t + self.jump * n + psi, -self.sense * (chi + mpmath.pi * n)

    def floats(self, speed: Scalar) -> Polhode:
        """The same with Python floats, time in units of 1/speed."""
        return replace(
            self,
            elliptic=self.elliptic.floats(),
            shift=self.shift.floats(),
            rate=float(self.rate / speed),
            v0=float(self.v0),
            omega=_floats(tuple(x / speed for x in self.omega)),
            momentum=_floats(self.momentum),
            ellipse=_floats(self.ellipse),
            precession=float(self.precession / speed),
            jump=float(self.jump),
            start=_floats(self.start),
        )


EulerMotion: TypeAlias = PermanentRotation | Polhode


def permanent_rotation(omega: AnyVector) -> PermanentRotation:
    """The rotation about a constant w."""
    speed = mpmath.sqrt(sum(x * x for x in omega))
    return PermanentRotation(omega, speed / 2, tuple(x / speed if speed else x for x in omega))


def polhode(numbers: Mapping[str, Any], signs: tuple[int, int, int]) -> Polhode:
    """The constants of the general motion, at the precision in force.

    ``numbers`` are the exact ones of :class:`polhode.closed_forms.euler.top.EulerTop`, rounded;
    ``signs`` those of w at v = 0, K, 0.
    """
    n, sqrt = numbers, mpmath.sqrt
    s1, s2, s3 = signs
    elliptic = jacobi(n["k2"], n["kc2"])
    rate = sqrt(n["rate2"])
    # R_F takes sn, cn, dn as three exact numbers: near a turning point nothing is lost.
    v0 = n["sn0"] * mpmath.elliprf(n["cn0_2"], n["dn0_2"], 1)
    shift = _shift(n, elliptic)
    backward = bool(n["I3"] < n["I1"])
    sense = -1 if backward else 1
    G = sqrt(n["G2"])
    omega = (s1 * sqrt(n["p2"]), s2 * sqrt(n["q2"]), s3 * sqrt(n["r2"]))
    momentum = tuple(n[name] * x / G for name, x in zip(("I1", "I2", "I3"), omega, strict=True))
    wide, high = abs(momentum[0]), abs(momentum[1])
    made = Polhode(
        elliptic,
        shift,
        rate,
        v0,
        omega,
        momentum,
        (wide / max(wide, high), high / max(wide, high)),
        G / n["I3"] + sense * shift.rate * rate,
        sense * shift.jump,
        backward,
        s1 * s2,
    )
    q0, q1, q2, q3 = made.place(mpf(0), MP)[1]
    return replace(made, start=(q0, -q1, -q2, -q3))


def _shift(n: Mapping[str, Any], elliptic: Jacobi) -> Quotient:
    """The quotient for axis 3 in space; its argument a from whichever end of [0, K'] is nearer.

    sn, cn, dn of a have modulus k'; those of K' - a are cn/dn, k sn/dn, k/dn.
    """
    sn2, cn2, dn2 = n["sn_a2"], n["cn_a2"], n["dn_a2"]
    a = mpmath.sqrt(sn2) * mpmath.elliprf(cn2, dn2, 1)
    if 2 * a <= elliptic.Kc:
        return quotient(elliptic, a)
    k2 = n["k2"]
    b = mpmath.sqrt(cn2 / dn2) * mpmath.elliprf(k2 * sn2 / dn2, k2 / dn2, 1)
    return quotient(elliptic, b, from_end=True)


def _half(x: Scalar, y: Scalar, fn: SeriesFunctions) -> tuple[Scalar, Scalar]:
    """(cos, sin) of half the argument of x + i y, x >= 0."""
    modulus = fn.hypot(x, y)
    cos = fn.sqrt((1 + x / modulus) / 2)
    return cos, y / (2 * modulus * cos)


def _floats(row: tuple[Scalar, ...]) -> tuple[Scalar, ...]:
    return tuple(float(x) for x in row)
