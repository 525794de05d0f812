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
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
from mpmath import mpf

from polhode import exact
from polhode.body import Vector, cross, dot, is_zero, scaled
from polhode.exact import EQUAL_BITS, ONE, ZERO, Exact, sign
from polhode.references.euler import EulerTop
from polhode.references.euler_attitude import direction
from polhode.references.euler_axes import Axes
from polhode.references.euler_motion import product
from polhode.references.rounding import log2, number, shortened
from polhode.references.theta import MP, Jacobi, jacobi

_GUARD = 40  # bits beyond the digits asked for and the growth of phases
_SPARE = 8  # bits kept beyond the digits asked for
_REST: Vector = (ZERO, ZERO, ZERO)


def fits(moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> bool:
    """Whether the body swings about a horizontal axis, or is in equilibrium at rest.

    All in principal axes.  The axis is that of w, or of the moment of the weight where w = 0; it
    must be a principal axis (of a symmetric body, or of a sphere, there are more than three) and at
    right angles to gamma and the torque Mg r0, which is not zero.
    """
    if is_zero(torque):
        return False
    n = _axis(torque, omega, gamma)
    turned = _momentum(moments, n)
    return is_zero(cross(n, turned)) and sign(dot(n, gamma)) == 0 and sign(dot(n, torque)) == 0


class Pendulum:
    """The plane motion of one heavy body from one start; raises ValueError unless it fits.

    ``moments`` are the principal moments and ``torque`` is Mg r0 in principal axes; ``axes[i]`` is
    the unit vector of principal axis i in the scene's body axes (right-handed; None for the same
    axes).  ``omega`` and ``gamma`` are given at t = 0 in the scene's axes, where all answers are.

    ``regime`` names the kind of motion; it is decided once, by exact arithmetic.
    """

    def __init__(
        self,
        moments: Vector,
        torque: Vector,
        omega: Vector,
        gamma: Vector,
        psi: Exact = ZERO,
        axes: tuple[tuple[Exact, ...], ...] | None = None,
    ) -> None:
        turn = Axes(axes)
        principal, vertical = _triple(turn.principal(omega)), _triple(turn.principal(gamma))
        if not fits(moments, torque, principal, vertical):
            raise ValueError("a body that does not swing about a horizontal principal axis")
        self._omega, self._gamma, self._psi = omega, gamma, psi
        # A body at rest keeps the start, by the same conventions for every closed form.
        self._start = EulerTop(moments, _REST, gamma, psi, axes)
        self.regime = _regime(moments, torque, principal, vertical)
        self._numbers: Mapping[str, Exact] = {}
        self._swings: dict[int, _Swing] = {}
        if self._at_rest:
            return
        n = _axis(torque, principal, vertical)
        self._numbers = _exact_numbers(moments, torque, principal, vertical)
        weight = exact.sqrt(dot(torque, torque))
        self._n = scaled(1 / exact.sqrt(dot(n, n)), _triple(turn.scene(n)))
        self._down = _triple(turn.scene(scaled(1 / weight, torque)))
        self._sideways = cross(self._n, self._down)

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r, gamma1, gamma2, gamma3, one a time.

        The error of w is below 10^-digits |w|, of gamma below 10^-digits.
        """
        rows = []
        for t in times:
            if self._at_rest or sign(t) == 0:
                bits = self._bits((), digits)
                rows.append([number(x, bits) for x in (*self._omega, *self._gamma)])
            else:
                rows.append(self._state(t, digits))
        return [shortened(row, digits) for row in rows]

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0, q1, q2, q3 of R, one a time: q0 >= 0 at t = 0, then continuous.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive.
        """
        bits = self._bits(times, digits)
        start = self._start.attitude([ZERO], _digits(bits))[0]
        rows = []
        with mpmath.workprec(bits):
            for t in times:
                if self._at_rest or sign(t) == 0:
                    rows.append(start)
                    continue
                swing = self._swing(bits)
                _, c, s, _ = swing.at(number(t, bits))
                c, s = _minus((c, s), swing.start)
                turn = (c, *(s * x for x in swing.n))
                rows.append(list(product((start[0], start[1], start[2], start[3]), turn)))
        return [shortened(row, digits) for row in rows]

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[mpf | None]]:
        """Rows psi, theta, phi; psi and phi continuous in t, None where gamma is along axis 3.

        They start from the psi given and phi = atan2(gamma1, gamma2), and are functions of the
        swing's angle: of a libration they return with the body.  Passing through a pole, psi and
        phi jump by pi, one of psi + phi, psi - phi stays continuous, and psi jumps upwards where
        the swing leads away from its start.  The error is below 10^-digits.
        """
        rows = []
        for t in times:
            if self._at_rest or sign(t) == 0:
                row = self._start.angles([ZERO], digits)[0]
            else:
                meets = sign(self._n[2]) == 0
                row = (self._through_poles if meets else self._past_poles)(t, digits)
            rows.append(shortened(row, digits, absolute=True))
        return rows

    def period(self, digits: int) -> mpf | None:
        """The period of the state; None on the separatrix and at rest."""
        if self._at_rest or self.regime == _SEPARATRIX:
            return None
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            swing = self._swing(bits)
            period = (2 if swing.rotating else 4) * swing.elliptic.K / swing.rate
        return shortened([period], digits)[0]

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """2 pi over the period, as "libration" or "rotation"; none where there is no period."""
        period = self.period(digits + 5)
        if period is None:
            return {}
        with mpmath.workprec(self._bits((), digits)):
            found = 2 * mpmath.pi / period
        name = "rotation" if self.regime == _ROTATING else "libration"
        return {name: shortened([found], digits)[0]}

    @property
    def _at_rest(self) -> bool:
        return self.regime in (_HANGING, _UPRIGHT)

    def _state(self, t: Exact, digits: int) -> list[mpf]:
        """w and gamma, at a precision that keeps the digits of w next to a turning point."""
        first = bits = self._bits((t,), digits)
        while True:
            with mpmath.workprec(bits):
                swing = self._swing(bits)
                speed, c, s, _ = swing.at(number(t, bits))
                lost = 0  # only cn, where it is nearly 0, is less exact than its argument
                if not swing.rotating:
                    largest = mpmath.mag(2 * swing.rate * swing.k)
                    lost = largest - mpmath.mag(speed) if speed else bits
                if first + lost <= bits + _SPARE or bits > first + EQUAL_BITS:
                    cos, sin = (c - s) * (c + s), 2 * c * s
                    pairs = zip(swing.down, swing.sideways, strict=True)
                    return [*(speed * x for x in swing.n), *(sin * y - cos * x for x, y in pairs)]
            bits = _rounded_up(first + lost)

    def _past_poles(self, t: Exact, digits: int) -> list[Any]:
        """Angles where n has a component n3 along axis 3, so that gamma never comes to that axis.

        With chi = del counted from where gamma is nearest to axis 3 and m = sqrt(1 - n3^2),
        psi = const - arg(n3 + i m sin chi) and phi = const + arg(n3 cos chi + i sin chi).
        """
        n3 = self._n[2]
        bits = _rounded_up(self._bits((t,), digits) - 2 * min(0, math.floor(log2(n3))))
        with mpmath.workprec(bits):
            swing = self._swing(bits)
            up = 1 if sign(n3) > 0 else -1
            along, across = abs(swing.n[2]), mpmath.hypot(swing.n[0], swing.n[1])

            def arguments(cos: mpf, sin: mpf) -> tuple[mpf, mpf]:
                """Those of psi and phi, but for the mean growth of phi."""
                return (
                    mpmath.atan2(across * sin, along),
                    mpmath.atan2(sin * cos * (1 - along), along * cos * cos + sin * sin),
                )

            grown, cos, sin = swing.swung(number(t, bits))
            one, other = arguments(*swing.nearest), arguments(cos, sin)
            return [
                number(self._psi, bits) - up * (other[0] - one[0]),
                mpmath.atan2(mpmath.hypot(along * cos, sin), across * cos),
                self._phi(bits) + up * (grown + other[1] - one[1]),
            ]

    def _through_poles(self, t: Exact, digits: int) -> list[Any]:
        """Angles where n3 = 0: gamma is along axis 3 wherever chi is a multiple of pi."""
        more = 0
        while True:
            bits = self._bits((t,), digits + _digits(more))
            with mpmath.workprec(bits):
                swing = self._swing(bits)
                grown, cos, sin = swing.swung(number(t, bits))
                theta = mpmath.atan2(abs(sin), cos)
                if abs(sin) > mpmath.ldexp(1, -math.floor(digits * math.log2(10)) - more):
                    chi = mpmath.atan2(swing.nearest[1], swing.nearest[0]) + grown
                    psi, phi = self._after_poles(int(mpmath.floor(chi / mpmath.pi)), swing, bits)
                    return [number(self._psi, bits) + psi, theta, phi]
            if more >= EQUAL_BITS:
                return [None, theta, None]
            more = 2 * more or 64

    def _after_poles(self, here: int, swing: _Swing, bits: int) -> tuple[mpf, mpf]:
        """psi - psi(0) and phi where here < chi/pi < here + 1.

        theta is 0 at even multiples of pi: psi + phi is continuous there, psi - phi at odd ones.
        """
        if sign(self._gamma[0]) == 0 and sign(self._gamma[1]) == 0:
            # From a pole: phi is its limit on this side of it, where sin chi has the sign of side.
            pole = 0 if sign(self._gamma[2]) > 0 else 1
            start = pole if here >= pole else pole - 1
            side = 1 if start == pole else -1
            psi = direction(mpmath.mpc(swing.n[0], swing.n[1]) * side)
            phi = -psi
            if pole:
                psi = phi = direction(-side * mpmath.mpc(swing.n[0], -swing.n[1]))
        else:
            start = 0 if swing.nearest[1] > 0 else -1
            psi, phi = mpf(0), self._phi(bits)
        passed = range(min(start, here) + 1, max(start, here) + 1)
        odd = (len(passed) + passed[0] % 2) // 2 if passed else 0
        return psi + len(passed) * mpmath.pi, phi + (2 * odd - len(passed)) * mpmath.pi

    def _phi(self, bits: int) -> mpf:
        return mpmath.atan2(number(self._gamma[0], bits), number(self._gamma[1], bits))

    def _swing(self, bits: int) -> _Swing:
        """The constants at a precision, made once."""
        if bits not in self._swings:
            with mpmath.workprec(bits):
                numbers = {name: number(x, bits) for name, x in self._numbers.items()}
                vectors = (self._n, self._down, self._sideways, self._gamma)
                rows = [[number(x, bits) for x in vector] for vector in vectors]
                self._swings[bits] = _swing(numbers, self.regime != _LIBRATING, *rows)
        return self._swings[bits]

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """Working precision: the digits, what the phase costs, a guard."""
        phase = 0.0
        last = max((log2(t) for t in times), default=-math.inf)
        if last > -math.inf and not self._at_rest:
            phase = max(0.0, log2(self._numbers["rate2"]) / 2 + last)
        return _rounded_up(digits * math.log2(10) + phase + _GUARD)


@dataclass(frozen=True)
class _Swing:
    """The swing at one precision, chi as in :meth:`Pendulum._past_poles`."""

    elliptic: Jacobi
    rate: Any  # of v
    v0: Any
    k: Any  # 1 where rotating
    rotating: bool  # or on the separatrix
    start: tuple[Any, Any]  # cos and sin of del/2 at t = 0, the former not negative
    angle: Any  # del at t = 0
    nearest: tuple[Any, Any]  # cos and sin of chi at t = 0
    n: Sequence[Any]  # in the scene's axes, as the next two
    down: Sequence[Any]  # T/P
    sideways: Sequence[Any]  # n x T/P

    def at(self, t: Any) -> tuple[Any, Any, Any, int]:
        """del', cos and sin of del/2, continuous in t, and whole turns of del."""
        waves = self.elliptic.waves(self.v0 + self.rate * t, MP)
        sn, cn, dn = self.elliptic.functions(waves)
        if waves.turns % 2:
            sn, cn = -sn, -cn
        if self.rotating:
            return 2 * self.rate * dn, cn, sn, waves.turns
        return 2 * self.rate * self.k * cn, dn, self.k * sn, 0

    def swung(self, t: Any) -> tuple[Any, Any, Any]:
        """The growth of del since t = 0, and cos and sin of chi."""
        _, c, s, turns = self.at(t)
        half = mpmath.atan2(-s, -c) if turns % 2 else mpmath.atan2(s, c)
        cos, sin = _minus((c, s), self.start)
        cos, sin = (cos - sin) * (cos + sin), -2 * cos * sin
        return 2 * (mpmath.pi * turns + half) - self.angle, *_minus(self.nearest, (cos, sin))


def _swing(
    numbers: Mapping[str, Any],
    rotating: bool,
    n: Sequence[Any],
    down: Sequence[Any],
    sideways: Sequence[Any],
    gamma: Sequence[Any],
) -> _Swing:
    """The constants at the precision in force, from the exact numbers rounded."""
    # R_F takes sn, cn, dn as three exact numbers: next to a turning point nothing is lost.
    sn0 = numbers["side"] * mpmath.sqrt(numbers["sn0_2"])
    v0 = sn0 * mpmath.elliprf(numbers["cn0_2"], numbers["dn0_2"], 1)
    c, s = mpmath.sqrt(numbers["cos2"]), numbers["side"] * mpmath.sqrt(numbers["sin2"])
    nearest = mpf(1), mpf(0)  # where gamma never comes nearer, chi counts from t = 0
    if across := mpmath.hypot(n[0], n[1]):
        nearest = gamma[2] / across, (gamma[1] * n[0] - gamma[0] * n[1]) / across
    return _Swing(
        elliptic=jacobi(numbers["m"], numbers["mc"]),
        rate=mpmath.sqrt(numbers["rate2"]),
        v0=v0,
        k=mpf(1) if rotating else mpmath.sqrt(numbers["m"]),
        rotating=rotating,
        start=(c, s),
        angle=2 * mpmath.atan2(s, c),
        nearest=nearest,
        n=n,
        down=down,
        sideways=sideways,
    )


_HANGING, _UPRIGHT = "rest, hanging", "rest, upright"
_LIBRATING, _ROTATING = "pendulum, librating", "pendulum, rotating"
_SEPARATRIX = "pendulum, separatrix"


def _axis(torque: Vector, omega: Vector, gamma: Vector) -> Vector:
    """A vector along n; zero in equilibrium at rest."""
    return cross(torque, gamma) if is_zero(omega) else omega


def _momentum(moments: Vector, omega: Vector) -> Vector:
    a, b, c = (moment * x for moment, x in zip(moments, omega, strict=True))
    return a, b, c


def _regime(moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> str:
    """The name of the motion."""
    if is_zero(_axis(torque, omega, gamma)):
        return _UPRIGHT if sign(dot(torque, gamma)) > 0 else _HANGING
    side = sign(_excess(moments, torque, omega, gamma)[0])
    return (_SEPARATRIX, _LIBRATING, _ROTATING)[side]


def _excess(moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> tuple[Exact, Exact]:
    """k'^2 as a fraction: its numerator, with rational data rational, and its denominator.

    With the energy h = w.Iw/2 + T.gamma: 2P k'^2 = P - h = (P^2 - h^2)/(P + h).
    """
    height, twice = dot(torque, gamma), dot(omega, _momentum(moments, omega))
    weight, energy = exact.sqrt(dot(torque, torque)), height + twice / 2
    if sign(energy) <= 0:
        return weight - energy, 2 * weight
    moment = cross(torque, gamma)
    numerator = dot(moment, moment) - twice * (height + twice / 4)
    return numerator, 2 * weight * (weight + energy)


def _exact_numbers(
    moments: Vector, torque: Vector, omega: Vector, gamma: Vector
) -> dict[str, Exact]:
    """The numbers that :func:`_swing` takes: no difference in them is left to rounding."""
    n = _axis(torque, omega, gamma)
    inertia = dot(n, _momentum(moments, n)) / dot(n, n)
    weight, height = exact.sqrt(dot(torque, torque)), dot(torque, gamma)
    moment = cross(torque, gamma)
    larger = (weight + abs(height)) / (2 * weight)
    smaller = dot(moment, moment) / (4 * weight * weight * larger)
    sin2, cos2 = (larger, smaller) if sign(height) > 0 else (smaller, larger)
    kinetic = dot(omega, _momentum(moments, omega)) / (4 * weight)
    numerator, denominator = _excess(moments, torque, omega, gamma)
    k2, kc2, rate2 = sin2 + kinetic, numerator / denominator, weight / inertia
    found = {"sin2": sin2, "cos2": cos2, "side": Fraction(sign(dot(n, moment)) or 1)}
    if sign(kc2) > 0:
        return found | {
            "m": k2,
            "mc": kc2,
            "rate2": rate2,
            "sn0_2": sin2 / k2,
            "cn0_2": kinetic / k2,
            "dn0_2": cos2,
        }
    if sign(kc2) == 0:
        k2, kc2 = ONE, ZERO
    return found | {
        "m": 1 / k2,
        "mc": -kc2 / k2,
        "rate2": rate2 * k2,
        "sn0_2": sin2,
        "cn0_2": cos2,
        "dn0_2": kinetic / k2,
    }


def _minus(one: tuple[Any, Any], other: tuple[Any, Any]) -> tuple[Any, Any]:
    """cos and sin of the difference of two angles."""
    (c, s), (cos, sin) = one, other
    return c * cos + s * sin, s * cos - c * sin


def _triple(row: Sequence[Any]) -> Vector:
    a, b, c = row
    return a, b, c


def _digits(bits: int) -> int:
    return math.ceil(bits * math.log10(2))


def _rounded_up(bits: float) -> int:
    """To a multiple of 64, so that nearby requests share their constants."""
    return 64 * math.ceil(bits / 64)
