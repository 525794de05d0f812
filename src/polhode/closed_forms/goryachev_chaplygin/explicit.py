"""Goryachev and Chaplygin's motions with G = 0, every release from rest among them: explicit.

Goryachev 1900.  With su = SF CP + CF SP, cu = CF CP - SF SP, sv = SF CP - CF SP,
cv = CF CP + SF SP, and Du^2 = m1 + m cu^2, Dv^2 = m1 + m cv^2, the variables are elliptic functions
of y = y0 + rate t:

    |H| < 2a: u = 2 sqrt(a m m1) su/Du, v likewise with sv (both may pass through 0, at rest);
    H > 2a:   u = sqrt(H - 2a)/Du, v likewise, SP and CP constant;
    H = 2a:   u = 2 sqrt(a) sech(y + b), v = 2 sqrt(a) sech(y - b).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from polhode.closed_forms.functions.jacobi import Jacobi, SeriesFunctions, jacobi
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar


class HalvesPoint(NamedTuple):
    """Everything that the state is made of, at one time; u, v and root may be negative together."""

    u: Scalar
    v: Scalar
    root: Scalar  # sqrt(uv)
    shares: tuple[Scalar, Scalar, Scalar]  # u, v and root over u + v, which may be 0
    xi: tuple[Scalar, Scalar]  # sin and cos of xi/2
    et: tuple[Scalar, Scalar]
    turning: Scalar  # chi', the rate at which the angular momentum turns in space


@dataclass(frozen=True)
class Libration:
    """|H| < 2a: the body swings; from rest it comes back to rest on the same path."""

    elliptic: Jacobi
    m: Scalar
    m1: Scalar
    a: Scalar
    l: Scalar
    y0: Scalar
    rate: Scalar

    def at(self, t: Scalar, fn: SeriesFunctions) -> HalvesPoint:
        """The motion at t."""
        m, m1, l, a = self.m, self.m1, self.l, self.a
        sn, cn, dn = _functions(self.elliptic, self.y0 + self.rate * t, fn)
        inner = dn * dn + l * l * m * sn * sn * cn * cn  # n^2
        n = fn.sqrt(inner)
        SF, CF = sn * dn / n, cn * fn.sqrt(dn * dn + l * l * m * sn * sn) / n
        SP = l * SF
        CP = fn.sqrt(dn * dn * (1 - l * l * sn * sn) + l * l * m * sn * sn * cn * cn) / n
        su, cu, sv, cv = SF * CP + CF * SP, CF * CP - SF * SP, SF * CP - CF * SP, CF * CP + SF * SP
        Du, Dv = fn.sqrt(m1 + m * cu * cu), fn.sqrt(m1 + m * cv * cv)
        size, across = 2 * fn.sqrt(a * m * m1), fn.sqrt(1 - l * l)
        one, two, both = (CP + l * CF) / Du, (CP - l * CF) / Dv, across / fn.sqrt(Du * Dv)
        total = one + two
        root = fn.sqrt(m), fn.sqrt(m1)
        return HalvesPoint(
            size * su / Du,
            size * sv / Dv,
            size * SF * both,
            (one / total, two / total, both / total),
            (root[0] * cu / Du, root[1] / Du),
            (root[0] * cv / Dv, root[1] / Dv),
            2 * fn.sqrt(a) * l * across * SF / (fn.sqrt(Du * Dv) ** 3 * total * total),
        )

    @property
    def period(self) -> Scalar:
        """8K/sqrt(a)."""
        return 4 * self.elliptic.K / self.rate

    def floats(self) -> Libration:
        """The same in doubles."""
        rest = (float(x) for x in (self.m, self.m1, self.a, self.l, self.y0, self.rate))
        return Libration(self.elliptic.floats(), *rest)


@dataclass(frozen=True)
class Rotation:
    """H > 2a: u and v never vanish."""

    elliptic: Jacobi
    m: Scalar
    m1: Scalar
    a: Scalar
    size: Scalar  # sqrt(H - 2a)
    P: tuple[Scalar, Scalar]  # SP and CP
    y0: Scalar
    rate: Scalar

    def at(self, t: Scalar, fn: SeriesFunctions) -> HalvesPoint:
        """The motion at t."""
        m, m1, (SP, CP) = self.m, self.m1, self.P
        sn, cn, dn = _functions(self.elliptic, self.y0 + self.rate * t, fn)
        SF = sn * fn.sqrt(m1 + m * CP * CP * cn * cn) / dn
        CF = cn * fn.sqrt(dn * dn + m * SP * SP * sn * sn) / dn
        su, cu, sv, cv = SF * CP + CF * SP, CF * CP - SF * SP, SF * CP - CF * SP, CF * CP + SF * SP
        Du, Dv = fn.sqrt(m1 + m * cu * cu), fn.sqrt(m1 + m * cv * cv)
        small = fn.sqrt(m1)
        xi, et = (cu / Du, small * su / Du), (cv / Dv, small * sv / Dv)
        return positive(self.size / Du, self.size / Dv, xi, et, self.a, fn)

    @property
    def period(self) -> Scalar:
        """8K/sqrt(H + 2a)."""
        return 2 * self.elliptic.K / self.rate

    def floats(self) -> Rotation:
        """The same in doubles."""
        SP, CP = self.P
        m, m1, a, size, y0, rate = (
            float(x) for x in (self.m, self.m1, self.a, self.size, self.y0, self.rate)
        )
        return Rotation(self.elliptic.floats(), m, m1, a, size, (float(SP), float(CP)), y0, rate)


@dataclass(frozen=True)
class Separatrix:
    """H = 2a: the body tends to rest upright, before and after."""

    a: Scalar
    dl: Scalar
    y0: Scalar
    rate: Scalar
    period = None

    def at(self, t: Scalar, fn: SeriesFunctions) -> HalvesPoint:
        """The motion at t."""
        cosh, sinh = fn.cosh_sinh(self.y0 + self.rate * t)
        # sinh and cosh of b, sinh b = dl/cosh y; then of y + b and y - b.
        sb = self.dl / cosh
        cb = fn.sqrt(1 + sb * sb)
        found = []
        for side in (1, -1):
            up = cosh * cb + side * sinh * sb
            found.append((1 / up, -(sinh * cb + side * cosh * sb) / up))
        (cx, sx), (ce, se) = found
        size = 2 * fn.sqrt(self.a)
        return positive(size * cx, size * ce, (sx, cx), (se, ce), self.a, fn)

    def floats(self) -> Separatrix:
        """The same in doubles."""
        return Separatrix(*(float(x) for x in (self.a, self.dl, self.y0, self.rate)))


def positive(
    u: Scalar,
    v: Scalar,
    xi: tuple[Scalar, Scalar],
    et: tuple[Scalar, Scalar],
    a: Scalar,
    fn: SeriesFunctions,
) -> HalvesPoint:
    """A point with u, v > 0; chi' = 2a sqrt(uv) sin((et - xi)/2)/(u + v)^2."""
    root, total = fn.sqrt(u * v), u + v
    turning = 2 * a * root * (et[0] * xi[1] - et[1] * xi[0]) / (total * total)
    return HalvesPoint(u, v, root, (u / total, v / total, root / total), xi, et, turning)


def _functions(j: Jacobi, y: Scalar, fn: SeriesFunctions) -> tuple[Scalar, Scalar, Scalar]:
    waves = j.waves(y, fn)
    sn, cn, dn = j.functions(waves)
    side = 1 - 2 * (waves.turns % 2)
    return side * sn, side * cn, dn


def libration(
    a: Scalar, H: Scalar, start: tuple[Scalar, Scalar, Scalar, Scalar, Scalar | None]
) -> Libration:
    """From u, v, xi, et and l (of a start from rest; else None) at the precision in force."""
    u, v, xi, et, l = start
    m, m1 = (2 * a + H) / (4 * a), (2 * a - H) / (4 * a)
    y0 = mpmath.mpf(0)
    if l is None:
        size = 2 * mpmath.sqrt(a * m1)
        fu, fv = (mpmath.atan2(z / size, mpmath.sin(x / 2)) for z, x in ((u, xi), (v, et)))
        l = mpmath.sin((fu - fv) / 2) / mpmath.sin((fu + fv) / 2)
        y0 = (_first(fu, m, m1) + _first(fv, m, m1)) / 2
    return Libration(jacobi(m, m1), m, m1, a, l, y0, mpmath.sqrt(a) / 2)


def rotation(a: Scalar, H: Scalar, start: tuple[Any, Any, Any, Any, Any]) -> Rotation:
    """From u, v, xi, et at the precision in force."""
    _, _, xi, et, _ = start
    m, m1 = 4 * a / (H + 2 * a), (H - 2 * a) / (H + 2 * a)
    fu, fv = (
        mpmath.atan2(mpmath.cos(x / 2) / mpmath.sqrt(m1), mpmath.sin(x / 2)) for x in (xi, et)
    )
    cos, sin = mpmath.cos_sin((fu - fv) / 2)
    y0 = (_first(fu, m, m1) + _first(fv, m, m1)) / 2
    size, rate = mpmath.sqrt(H - 2 * a), mpmath.sqrt(H + 2 * a) / 4
    return Rotation(jacobi(m, m1), m, m1, a, size, (sin, cos), y0, rate)


def separatrix(a: Scalar, H: Scalar, start: tuple[Any, Any, Any, Any, Any]) -> Separatrix:
    """From xi, et at the precision in force."""
    _, _, xi, et, _ = start
    one, other = (-mpmath.tan(x / 2) for x in (xi, et))  # sinh of y0 + b0 and of y0 - b0
    y0 = (mpmath.asinh(one) + mpmath.asinh(other)) / 2
    return Separatrix(a, (one - other) / 2, y0, mpmath.sqrt(a) / 2)


def _first(f: Scalar, m: Scalar, m1: Scalar) -> Scalar:
    """F(f|m), f in [-pi, pi] (DLMF 19.25(i))."""
    cos, sin = mpmath.cos_sin(f)
    found = sin * mpmath.elliprf(cos * cos, m1 + m * cos * cos, 1)
    if cos < 0:
        K = mpmath.pi / (2 * mpmath.agm(1, mpmath.sqrt(m1)))
        found = (-2 if sin < 0 else 2) * K - found
    return found
