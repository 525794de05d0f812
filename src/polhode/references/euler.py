"""The torque-free rigid body (Euler's top) in closed form: states, attitude, Euler angles.

    I w' + w x I w = 0,    gamma' = gamma x w            (Yehia 3.13-3.17 without weight)

w = (p, q, r) and the unit vector gamma in body axes; attitude R (body -> space, z along gamma).
Any body, any start, any time, any number of digits.  Units: any consistent set.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import mpmath
from mpmath import mpf

from polhode.exact import Exact, rounded, sign, sqrt
from polhode.references.euler_motion import (
    Motion,
    Quaternion,
    Vector,
    permanent_rotation,
    polhode,
    product,
    turned_back,
)
from polhode.references.theta import MP

_ZERO = Fraction(0)
_GUARD = 40  # bits beyond the digits asked for, the growth of phases and the spread of the moments
_SPARE = 8  # bits kept beyond the digits asked for


class EulerTop:
    """The motion of one torque-free body from one start.

    ``moments`` are the principal moments, ``axes[i]`` the unit vector of principal axis i in the
    scene's body axes (right-handed; None for the same axes).  ``omega`` and ``gamma`` are given at
    t = 0 in the scene's axes, where all answers are too; without ``gamma`` only w is known.

    ``regime`` names the kind of motion; it is decided once, by exact arithmetic.
    """

    def __init__(
        self,
        moments: tuple[Exact, Exact, Exact],
        omega: tuple[Exact, Exact, Exact],
        gamma: tuple[Exact, Exact, Exact] | None = None,
        psi: Exact = _ZERO,
        axes: tuple[tuple[Exact, ...], ...] | None = None,
    ) -> None:
        self._axes = axes
        self._scene_omega = tuple(omega)
        self._gamma = None if gamma is None else tuple(gamma)
        self._psi = psi
        I = tuple(moments)  # noqa: E741
        w = self._principal(omega)

        ranking = sorted(range(3), key=functools.cmp_to_key(lambda i, j: sign(I[i] - I[j])))
        excess = _total(I[i] * (I[i] - I[ranking[1]]) * w[i] * w[i] for i in range(3))  # G^2 - 2hB
        if sign(excess) < 0:
            ranking.reverse()
        self._order = tuple(ranking)
        # An even renumbering keeps the frame right-handed; an odd one needs axis 2 reversed.
        self._odd = self._order in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
        self._moments = tuple(I[i] for i in self._order)
        self._omega = self._numbered(w)
        self._permanent = all(
            sign((I[i] - I[j]) * w[i] * w[j]) == 0 for i, j in ((0, 1), (1, 2), (2, 0))
        )
        self.regime = _regime(I, w, self._permanent, sign(excess))
        self._numbers = {} if self._permanent else _numbers(self._moments, self._omega)
        self._motions: dict[int, Motion] = {}
        self._starts: dict[int, tuple[Quaternion, Any]] = {}
        self._sign: int | None = None

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r [, gamma1, gamma2, gamma3], one a time.

        The error is below 10^-digits, of w relative to its largest modulus.
        """
        bits = self._bits(times, digits)
        rows = []
        with mpmath.workprec(bits):
            motion, frame = self._motion(bits), self._frame(bits)
            gamma = None
            if self._gamma is not None:
                gamma = self._numbered(self._principal(self._gamma))
                gamma = tuple(_mpf(x, bits) for x in gamma)
            for t in times:
                omega, turn = motion.state(_mpf(t, bits), MP)
                row = self._scene(omega, frame)
                if gamma is not None:
                    row += self._scene(turned_back(turn, gamma), frame)
                rows.append(row)
        return _shortened(rows, digits)

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0, q1, q2, q3 of R, one a time: q0 >= 0 at t = 0, then continuous.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive.
        """
        bits = self._bits(times, digits)
        with mpmath.workprec(bits):
            rows = [list(self._quaternion(_mpf(t, bits), bits)) for t in times]
        return _shortened(rows, digits)

    def period(self, digits: int) -> mpf | None:
        """The period of w in the body; None where w is constant or tends to the middle axis."""
        if self._permanent or sign(self._numbers["kc2"]) == 0:
            return None
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            motion: Any = self._motion(bits)
            period = 4 * motion.elliptic.K / motion.rate
        return _shortened([[period]], digits)[0][0]

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """Mean rates in radians a unit of time.

        "polhode": of w in the body (absent where w has no period); "precession": of the axis that
        the polhode circles, about G.
        """
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            motion: Any = self._motion(bits)
            if self._permanent:
                found = {"precession": 2 * motion.half}
            else:
                found = {"precession": motion.precession}
                if motion.elliptic.K < mpmath.inf:
                    half_period = 2 * motion.elliptic.K / motion.rate
                    found["polhode"] = mpmath.pi / half_period
                    found["precession"] += motion.jump / half_period
        return {name: _shortened([[x]], digits)[0][0] for name, x in found.items()}

    def _motion(self, bits: int) -> Motion:
        """The constants at a precision, made once."""
        if bits not in self._motions:
            with mpmath.workprec(bits):
                if self._permanent:
                    made: Motion = permanent_rotation(_vector(self._omega, bits))
                else:
                    numbers = {name: _mpf(x, bits) for name, x in self._numbers.items()}
                    s1, s3 = (1 if sign(self._omega[i]) >= 0 else -1 for i in (0, 2))
                    s2 = sign(self._moments[2] - self._moments[1]) * s1 * s3
                    numbers["sn0"] = mpmath.sqrt(numbers["sn0_2"]) * sign(self._omega[1]) * s2
                    made = polhode(numbers, (s1, s2, s3))
            self._motions[bits] = made
        return self._motions[bits]

    def _quaternion(self, t: mpf, bits: int) -> Quaternion:
        """The attitude at t, continuous in t."""
        start, frame = self._start(bits)
        c, *axis = self._motion(bits).state(t, MP)[1]
        return product(start, (c, *self._scene(tuple(axis), frame)))

    def _start(self, bits: int) -> tuple[Quaternion, Any]:
        """The attitude at t = 0, and the axes as numbers."""
        if self._gamma is None:
            raise ValueError("this motion was given without gamma: it has states of w only")
        if bits not in self._starts:
            with mpmath.workprec(bits):
                self._starts[bits] = (self._initial(bits), self._frame(bits))
        return self._starts[bits]

    def _initial(self, bits: int) -> Quaternion:
        assert self._gamma is not None
        g1, g2, g3 = self._gamma
        across = _total((g1 * g1, g2 * g2))
        # cos^2 and sin^2 of theta/2, the smaller one from sin theta.
        near = (1 + _mpf(abs(g3), bits)) / 2
        far = _mpf(across, bits) / (4 * near)
        near, far = mpmath.sqrt(near), mpmath.sqrt(far)
        cos, sin = (near, far) if sign(g3) >= 0 else (far, near)
        phi = mpmath.atan2(_mpf(g1, bits), _mpf(g2, bits))
        psi = _mpf(self._psi, bits)
        c1, s1 = mpmath.cos_sin((psi + phi) / 2)
        c2, s2 = mpmath.cos_sin((psi - phi) / 2)
        found = (cos * c1, sin * c2, sin * s2, cos * s1)
        if self._sign is None:
            tiny = mpmath.ldexp(1, -bits // 2)  # rounding of an exact zero
            self._sign = next((1 if x > 0 else -1) for x in found if abs(x) > tiny)
        a, b, c, d = (self._sign * x for x in found)
        return a, b, c, d

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """Working precision: the digits, what phases and the spread of the moments cost, a guard.

        Rounded up to a multiple of 64, so that nearby requests share their constants.
        """
        moments = [abs(x) for x in self._moments]
        spread = _log2(moments[0]), _log2(moments[1]), _log2(moments[2])
        phase = 0.0
        momentum = max((_log2(x) + m for x, m in zip(self._omega, spread, strict=True)))
        last = max((_log2(t) for t in times), default=-math.inf)
        if last > -math.inf and momentum > -math.inf:
            phase = max(0.0, momentum - min(spread) + last)
        wanted = digits * math.log2(10) + phase + (max(spread) - min(spread)) + _GUARD
        return 64 * math.ceil(wanted / 64)

    def _principal(self, vector: Sequence[Exact]) -> tuple[Exact, ...]:
        """From the scene's axes to the principal ones."""
        if self._axes is None:
            return tuple(vector)
        return tuple(_total(a * x for a, x in zip(row, vector, strict=True)) for row in self._axes)

    def _numbered(self, vector: Sequence[Exact]) -> tuple[Exact, ...]:
        """From the principal axes to those numbered for the motion."""
        a, b, c = (vector[i] for i in self._order)
        return a, (-b if self._odd else b), c

    def _frame(self, bits: int) -> tuple[Vector, ...] | None:
        return None if self._axes is None else tuple(_vector(row, bits) for row in self._axes)

    def _scene(self, vector: Sequence[Any], frame: tuple[Vector, ...] | None) -> list[Any]:
        """From the axes numbered for the motion to the scene's."""
        principal: list[Any] = [None] * 3
        for i, x in zip(self._order, vector, strict=True):
            principal[i] = x
        if self._odd:
            principal[self._order[1]] = -principal[self._order[1]]
        if frame is None:
            return principal
        return [sum(x * row[i] for x, row in zip(principal, frame, strict=True)) for i in range(3)]


def _numbers(I: Sequence[Exact], w: Sequence[Exact]) -> dict[str, Exact]:  # noqa: E741
    """The exact numbers of :mod:`polhode.references.euler_motion`, all of them >= 0."""
    I1, I2, I3 = I
    m1, m2, m3 = (a * x for a, x in zip(I, w, strict=True))
    d21, d31, d32 = I2 - I1, I3 - I1, I3 - I2
    G2 = m1 * m1 + m2 * m2 + m3 * m3
    # P, R and G^2 - 2h I2 as sums over two axes: irrational data then cancel as little as may be.
    P = m1 * w[0] * d31 + m2 * w[1] * d32
    R = m2 * w[1] * d21 + m3 * w[2] * d31
    D = m3 * w[2] * d32 - m1 * w[0] * d21
    p2, q2, r2 = P / (I1 * d31), P / (I2 * d32), R / (I3 * d31)
    return {
        "I1": I1,
        "I2": I2,
        "I3": I3,
        "G2": G2,
        "k2": d21 * P / (d32 * R),
        "kc2": d31 * D / (d32 * R),
        "rate2": d32 * R / (I1 * I2 * I3),
        "p2": p2,
        "q2": q2,
        "r2": r2,
        "sn0_2": w[1] * w[1] / q2,
        "cn0_2": w[0] * w[0] / p2,
        "dn0_2": w[2] * w[2] / r2,
        "sn_a2": I3 * R / (G2 * d31),
        "cn_a2": I1 * P / (G2 * d31),
        "dn_a2": I2 * P / (G2 * d32),
    }


def _regime(
    I: Sequence[Exact],  # noqa: E741
    w: Sequence[Exact],
    permanent: bool,
    excess: int,
) -> str:
    """The name of the motion; ``excess`` is the sign of G^2 - 2hB."""
    if all(sign(x) == 0 for x in w):
        return "rest"
    equal = [(i, j) for i, j in ((0, 1), (1, 2), (2, 0)) if sign(I[i] - I[j]) == 0]
    if len(equal) > 1:
        return "sphere"
    if equal:
        i, j = equal[0]
        k = 3 - i - j
        if permanent:
            axis = "the symmetry axis" if sign(w[k]) else "an equatorial axis"
            return f"permanent rotation about {axis}"
        return f"axisymmetric, {'oblate' if I[k] > I[i] else 'prolate'}: regular precession"
    if permanent:
        (k,) = (i for i in range(3) if sign(w[i]))
        rank = sum(I[j] < I[k] for j in range(3))
        return f"permanent rotation about the {('smallest', 'middle', 'largest')[rank]}-moment axis"
    if excess == 0:
        return "separatrix"
    return f"polhode about the {'largest' if excess > 0 else 'smallest'}-moment axis"


def _total(terms: Any) -> Exact:
    total: Exact = _ZERO
    for term in terms:
        total = total + term
    return total


def _mpf(x: Exact, bits: int) -> mpf:
    """x rounded to ``bits`` bits."""
    return mpf(rounded(x, bits))


def _vector(row: Sequence[Exact], bits: int) -> Vector:
    a, b, c = (_mpf(x, bits) for x in row)
    return a, b, c


def _log2(x: Exact) -> float:
    """log2 |x|, to a bit; -inf at 0."""
    mantissa, exponent = rounded(x, 8)
    return math.log2(abs(mantissa)) + exponent if mantissa else -math.inf


def _shortened(rows: list[list[Any]], digits: int) -> list[list[mpf]]:
    with mpmath.workprec(math.ceil(digits * math.log2(10)) + _SPARE):
        return [[+x for x in row] for row in rows]
