"""Hess's motions with f = 0 and on the steady cone: explicit (units with b = 1).

f = 0: th, the angle from r0 to the vertical, is a pendulum's: del = th - pi,
del'' = -P sin del, and

    Z = th' e^{i ch},    u = cos th,    Gm = i sin th e^{i ch},    ch' = -a12 Re Z,

solved by al + i be = |..| e^{i (ch/2 + pi/4)}: al = (cos - sin)(ch0/2) e^X, be = (cos + sin)(ch0/2)
e^-X, X = a12 (th - th0)/2.  The angular momentum keeps its direction in space.  Steady cone: |Z|, u
and Gm/Z are constant, and (sin, cos)(ch/2) obeys a linear equation to a common factor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from polhode.closed_forms.functions.jacobi import Jacobi, SeriesFunctions, jacobi
from polhode.closed_forms.functions.quaternion import Quaternion, of_matrix, product
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.hess.axes import (
    CONE_LIMIT,
    CONE_TURNING,
    LIBRATION,
    ROTATION,
    SEPARATRIX,
    HessStart,
)
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar


class SurfacePoint(NamedTuple):
    """Z, Gm as pairs of reals, u, and the frame's quaternion."""

    Z: tuple[Scalar, Scalar]
    g: tuple[Scalar, Scalar]
    u: Scalar
    frame: Quaternion


@dataclass(frozen=True)
class PlaneMotion:
    """f = 0."""

    kind: str
    elliptic: Jacobi | None
    k: Scalar
    om: Scalar
    v0: Scalar
    rate: Scalar  # of v
    th0: Scalar  # del at the start
    a12: Scalar
    half: tuple[Scalar, Scalar]  # cos and sin of ch0/2

    def at(self, t: Scalar, fn: SeriesFunctions) -> SurfacePoint:
        """The motion at t."""
        c, s, speed, angle = self._pendulum(t, fn)
        X = self.a12 * (angle - self.th0) / 2
        c0, s0 = self.half
        grown, shrunk = _balanced(X)
        al, be = (c0 - s0) * grown, (c0 + s0) * shrunk
        norm = fn.hypot(al, be)
        al, be = al / norm, be / norm
        cos, sin = 2 * al * be, (be - al) * (be + al)
        sine = -2 * s * c  # sin th
        # ch/2 = arg(al + i be) - pi/4; then a turn about e2 by th - pi/2.
        zero = 0 * al
        turn = ((al + be) / 2, (al - be) / 2, zero, zero)  # twice 1/sqrt 2 goes into the tilt
        tilt = (c - s, zero, c + s, zero)
        return SurfacePoint(
            (speed * cos, speed * sin),
            (-sine * sin, sine * cos),
            (s - c) * (s + c),
            product(tilt, turn),
        )

    def _pendulum(self, t: Scalar, fn: SeriesFunctions) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """cos and sin of del/2, th', and del unwrapped."""
        v = self.v0 + self.rate * t
        if self.elliptic is None:
            cosh, sinh = fn.cosh_sinh(v)
            return 1 / cosh, sinh / cosh, 2 * self.om / cosh, 2 * _arctan2(sinh, 1 + 0 * sinh)
        waves = self.elliptic.waves(v, fn)
        sn, cn, dn = self.elliptic.functions(waves)
        side = 1 - 2 * (waves.turns % 2)
        if self.kind == LIBRATION:
            s = self.k * side * sn
            return dn, s, 2 * self.om * self.k * side * cn, 2 * _arctan2(s, dn)
        angle = 2 * (_arctan2(sn, cn) + waves.turns * _pi(sn))
        return side * cn, side * sn, 2 * self.om * self.k * dn, angle

    @property
    def period(self) -> Scalar | None:
        """4K/om of a libration; none of the others, which tend to a plane."""
        if self.kind != LIBRATION or self.elliptic is None:
            return None
        return 4 * self.elliptic.K / self.rate

    def floats(self) -> PlaneMotion:
        """The same in doubles."""
        elliptic = None if self.elliptic is None else self.elliptic.floats()
        names = ("k", "om", "v0", "rate", "th0", "a12")
        numbers: dict[str, Any] = {name: float(getattr(self, name)) for name in names}
        half = float(self.half[0]), float(self.half[1])
        return replace(self, elliptic=elliptic, half=half, **numbers)


def plane(start: HessStart, kind: str, bits: int) -> PlaneMotion:
    """The constants at the precision in force, that of ``bits`` bits."""
    P, h, a12, u = (number(x, bits) for x in (start.P, start.h, start.a12, start.u))
    Z, g = (mpmath.mpc(*(number(x, bits) for x in pair)) for pair in (start.Z, start.g))
    ch = mpmath.arg(Z) if Z else mpmath.arg(-1j * g)
    speed = abs(Z)
    th = mpmath.atan2((g * mpmath.expj(-ch)).imag, u)
    angle = th - mpmath.pi if th > 0 else th + mpmath.pi
    om = mpmath.sqrt(P)
    k2 = mpmath.sin(angle / 2) ** 2 + speed**2 / (4 * P)
    k = mpmath.sqrt(k2)
    c, s = mpmath.cos_sin(angle / 2)
    half = mpmath.cos_sin(ch / 2)
    if kind == LIBRATION:
        m1 = (P - h) / (2 * P)
        sn, cn = s / k, speed / (2 * om * k)
        v0 = sn * mpmath.elliprf(cn * cn, c * c, 1)
        return PlaneMotion(kind, jacobi(k2, m1), k, om, v0, om, angle, a12, half)
    if kind == ROTATION:
        m1 = (h - P) / (2 * P * k2)
        v0 = s * mpmath.elliprf(c * c, m1 + c * c / k2, 1)
        return PlaneMotion(kind, jacobi(1 / k2, m1), k, om, v0, om * k, angle, a12, half)
    assert kind == SEPARATRIX
    return PlaneMotion(kind, None, mpf(1), om, mpmath.asinh(s / c), om, angle, a12, half)


@dataclass(frozen=True)
class Cone:
    """The steady cone: gamma and Iw keep their angles with r0, and turn about it."""

    kind: str
    ro: Scalar
    g: tuple[Scalar, Scalar]  # ro Gm/Z
    u: Scalar
    al: Scalar
    be: Scalar
    rate: Scalar  # sqrt |al be|
    half: tuple[Scalar, Scalar]  # sin and cos of ch0/2
    upright: Quaternion  # takes (u, g) to the vertical
    turning: Scalar  # chi' of the angular momentum in space

    def at(self, t: Scalar, fn: SeriesFunctions) -> SurfacePoint:
        """The motion at t."""
        (y1, y2), rate = self.half, self.rate
        if self.kind == CONE_LIMIT:
            one, two = y1 + self.al * y2 * t, y2 - self.be * y1 * t
        elif self.kind == CONE_TURNING:
            c, s = fn.cos_sin(rate * t)
            one, two = y1 * c + self.al / rate * y2 * s, y2 * c - self.be / rate * y1 * s
        else:  # over cosh
            cosh, sinh = fn.cosh_sinh(rate * t)
            s = sinh / cosh
            one, two = y1 + self.al / rate * y2 * s, y2 - self.be / rate * y1 * s
        norm = fn.hypot(one, two)
        s, c = one / norm, two / norm
        cos, sin = (c - s) * (c + s), 2 * s * c
        x, y = self.g
        turn = (c, -s, 0 * s, 0 * s)
        return SurfacePoint(
            (self.ro * cos, self.ro * sin),
            (x * cos - y * sin, x * sin + y * cos),
            self.u,
            product(self.upright, turn),
        )

    @property
    def period(self) -> Any | None:
        """pi/sqrt(al be) while it turns."""
        return mpmath.pi / self.rate if self.kind == CONE_TURNING else None

    def floats(self) -> Cone:
        """The same in doubles."""
        pairs = ((float(a), float(b)) for a, b in (self.g, self.half))
        g, half = pairs
        ro, u, al, be, rate, turning = (
            float(x) for x in (self.ro, self.u, self.al, self.be, self.rate, self.turning)
        )
        a, b, c, d = (float(x) for x in self.upright)
        return Cone(self.kind, ro, g, u, al, be, rate, half, (a, b, c, d), turning)


def cone(start: HessStart, kind: str, bits: int) -> Cone:
    """The constants at the precision in force, that of ``bits`` bits."""
    P, f, a12, u = (number(x, bits) for x in (start.P, start.f, start.a12, start.u))
    Z, g = (mpmath.mpc(*(number(x, bits) for x in pair)) for pair in (start.Z, start.g))
    ro = abs(Z)
    level = g / Z * ro
    x, y = level.real, level.imag
    et = -P * f / ro**2
    al, be = (et - a12 * ro) / 2, (et + a12 * ro) / 2
    if kind == CONE_LIMIT:
        al, be = (mpf(0), be) if abs(al) < abs(be) else (al, mpf(0))
    c, s = mpmath.cos_sin(mpmath.arg(Z) / 2)
    # Rows: the part of e2 (Iw) at right angles to gamma = (u, x, y), gamma x it, gamma.
    across = mpmath.sqrt(u * u + y * y)
    row = (-x * u / across, across, -x * y / across)
    other = (x * row[2] - y * row[1], y * row[0] - u * row[2], u * row[1] - x * row[0])
    turning = -f * P * u / (ro * ro - f * f)
    rate = mpmath.sqrt(abs(al * be))
    upright = of_matrix((row, other, (u, x, y)))
    return Cone(kind, ro, (x, y), u, al, be, rate, (s, c), upright, turning)


def _balanced(X: Scalar) -> tuple[Scalar, Scalar]:
    """e^X and e^-X over the larger of them."""
    if isinstance(X, mpf):
        small = mpmath.exp(-2 * abs(X))
        return (mpf(1), small) if X >= 0 else (small, mpf(1))
    import numpy as np

    small = np.exp(-2 * np.abs(X))
    return np.where(X >= 0, 1.0, small), np.where(X >= 0, small, 1.0)


def _arctan2(y: Scalar, x: Scalar) -> Scalar:
    if isinstance(y, mpf):
        return mpmath.atan2(y, x)
    import numpy as np

    return np.arctan2(y, x)


def _pi(like: Scalar) -> Scalar:
    return +mpmath.pi if isinstance(like, mpf) else float(mpmath.pi)
