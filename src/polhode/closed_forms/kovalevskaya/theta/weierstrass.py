"""Solutions of y'^2 = f(y), f a quartic, from a start (y0, y0'), by Weierstrass' function.

    y = y0 + [-y0' P' + f'(P - f''/24)/2 + f f'''/24] / [2 (P - f''/24)^2 - f f''''/48],

f and its derivatives at y0, P = P(t; g2, g3) of the invariants of f (Biermann 1865; Whittaker &
Watson, A Course of Modern Analysis, 20.6).  No sign of a root is chosen; y0 may be complex while g2
and g3 are real.  P comes from Jacobi's functions (DLMF 23.6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from polhode.closed_forms.functions.jacobi import MP, Jacobi, jacobi
from polhode.closed_forms.functions.rounding import number
from polhode.numbers.exact import Exact, sign
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar


@dataclass(frozen=True)
class Quartic:
    """a0 y^4 + 4 a1 y^3 + 6 a2 y^2 + 4 a3 y + a4, exact and real."""

    a: tuple[Exact, Exact, Exact, Exact, Exact]

    @property
    def invariants(self) -> tuple[Exact, Exact]:
        """g2 and g3."""
        a0, a1, a2, a3, a4 = self.a
        return (
            a0 * a4 - 4 * a1 * a3 + 3 * a2 * a2,
            a0 * a2 * a4 + 2 * a1 * a2 * a3 - a2 * a2 * a2 - a0 * a3 * a3 - a1 * a1 * a4,
        )

    @property
    def sign_of_discriminant(self) -> int:
        """The sign of g2^3 - 27 g3^2."""
        g2, g3 = self.invariants
        return sign(g2 * g2 * g2 - 27 * g3 * g3)

    def derivatives(self, y: Scalar, bits: int) -> list[Scalar]:
        """f, f', f'', f''', f'''' at y."""
        a0, a1, a2, a3, a4 = (number(x, bits) for x in self.a)
        return [
            (((a0 * y + 4 * a1) * y + 6 * a2) * y + 4 * a3) * y + a4,
            4 * (((a0 * y + 3 * a1) * y + 3 * a2) * y + a3),
            12 * ((a0 * y + 2 * a1) * y + a2),
            24 * (a0 * y + a1),
            24 * a0,
        ]


@dataclass(frozen=True)
class Weierstrass:
    """P on the real line; ``rate`` t is the argument of the Jacobi functions."""

    g2: Scalar
    functions: Jacobi | None  # None: P = 1/t^2
    rate: Scalar
    base: Scalar  # P is base + size/sn^2, or base + size (1 + cn)/(1 - cn)
    size: Scalar
    paired: bool  # the latter

    def at(self, t: Scalar) -> tuple[Scalar, Scalar] | None:
        """P and P'; None at a pole."""
        if self.functions is None:
            return (1 / (t * t), -2 / t**3) if t else None
        waves = self.functions.waves(self.rate * t, MP)
        sn, cn, dn = self.functions.functions(waves)
        if not sn:
            if not self.paired or waves.turns % 2 == 0:
                return None
            return self.base, mpf(0)
        if not self.paired:
            return (
                self.base + self.size / (sn * sn),
                -2 * self.size * self.rate * cn * dn / sn**3,
            )
        if waves.turns % 2:
            sn, cn = -sn, -cn
        less = sn * sn / (1 + cn) if cn > 0 else 1 - cn
        return (
            self.base + self.size * (1 + cn) / less,
            -2 * self.size * self.rate * sn * dn / (less * less),
        )

    @property
    def period(self) -> Scalar:
        """The real period; infinite where there is none."""
        return (
            mpmath.inf
            if self.functions is None
            else 2 * self.functions.K / self.rate * (2 if self.paired else 1)
        )


def weierstrass(quartic: Quartic, bits: int) -> Weierstrass:
    """P of the quartic's invariants, at the precision in force."""
    kind = quartic.sign_of_discriminant
    with mpmath.workprec(2 * bits + 40):
        g2, g3 = (number(x, 2 * bits + 80) for x in quartic.invariants)
        if kind == 0:
            if not g2:
                return Weierstrass(mpf(0), None, mpf(1), mpf(0), mpf(1), False)
            d = -3 * g3 / (2 * g2)
            e = [max(d, -2 * d), d, min(d, -2 * d)]
        elif kind > 0:
            size = mpmath.sqrt(g2 / 3)
            argument = max(mpf(-1), min(mpf(1), g3 / size**3))
            angle = mpmath.acos(argument) / 3
            e = [size * mpmath.cos(angle - 2 * mpmath.pi * k / 3) for k in range(3)]
            e = sorted(e, reverse=True)
        else:
            root = mpmath.sqrt((g3 * g3 - g2**3 / 27) / 64)
            u = g3 / 8 + root if g3 > 0 else g3 / 8 - root
            u = mpmath.cbrt(u) if u > 0 else -mpmath.cbrt(-u)
            real = u + g2 / (12 * u)
            size = mpmath.sqrt(3 * real * real - g2 / 4)
            share = 3 * real / (4 * size)
            half = mpf(1) / 2
            functions = jacobi(half - share, half + share)
            rate = 2 * mpmath.sqrt(size)
            return Weierstrass(g2, functions, rate, real, size, True)
        width = e[0] - e[2]
        functions = jacobi((e[1] - e[2]) / width, (e[0] - e[1]) / width)
        return Weierstrass(g2, functions, mpmath.sqrt(width), e[2], width, False)


@dataclass(frozen=True)
class WeierstrassSolution:
    """y(t) as a quotient Y/Z, with derivatives."""

    y0: Scalar
    slope: Scalar
    f: Sequence[Scalar]
    P: Weierstrass

    def at(self, t: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """Y, Z, Y', Z'."""
        found = self.P.at(t)
        if found is None:
            return self.y0, mpf(1), self.slope, mpf(0)
        P, P1 = found
        P2 = 6 * P * P - self.P.g2 / 2
        f, f1, f2, f3, f4 = self.f
        x = P - f2 / 24
        # Divided by P^2 + 1 both stay of the size of y.
        over = 1 / (1 + P * P)
        Z, Z1 = (2 * x * x - f * f4 / 48) * over, 4 * x * P1 * over
        N = (-self.slope * P1 + f1 * x / 2 + f * f3 / 24) * over
        N1 = (-self.slope * P2 + f1 * P1 / 2) * over
        return self.y0 * Z + N, Z, self.y0 * Z1 + N1, Z1

    def value(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """y and y'."""
        Y, Z, Y1, Z1 = self.at(t)
        y = Y / Z
        return y, (Y1 - y * Z1) / Z


def solution(quartic: Quartic, y0: Scalar, slope: Scalar, bits: int) -> WeierstrassSolution:
    """The solution from (y0, y0') at the precision in force."""
    return WeierstrassSolution(y0, slope, quartic.derivatives(y0, bits), weierstrass(quartic, bits))
