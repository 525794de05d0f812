"""Where a root of the radicand is near the interval: an elliptic angle in place of x.

With z = M - D cos x on [z1, z2] and z' the nearest other root, an argument tau of Jacobi's
functions takes z' to the far end of its period; a Fourier series in theta = 2 pi tau/period then
needs only as many terms as log(1/gap).  Every chart is odd and increasing, theta and x make whole
turns together: it changes the length of the series and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from polhode.closed_forms.functions.jacobi import Jacobi, SeriesFunctions, jacobi
from polhode.closed_forms.goryachev_chaplygin.separation_variables import Variable, width
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar


class Chart(Protocol):
    """x as a function of theta."""

    def at(self, theta: Scalar, fn: SeriesFunctions) -> tuple[Scalar, Scalar, Scalar]:
        """cos(x/2), sin(x/2) and dx/dtheta."""
        ...

    def inverse(self, x: Scalar) -> Scalar:
        """theta for x in [-pi, pi]."""
        ...

    def floats(self) -> Chart:
        """The same in doubles."""
        ...


@dataclass(frozen=True)
class Plain:
    """theta = x."""

    def at(self, theta: Scalar, fn: SeriesFunctions) -> tuple[Scalar, Scalar, Scalar]:
        """cos(x/2), sin(x/2) and dx/dtheta."""
        c, s = fn.cos_sin(theta / 2)
        return c, s, 1

    def inverse(self, x: Scalar) -> Scalar:
        """theta for x in [-pi, pi]."""
        return x

    def floats(self) -> Plain:
        """The same in doubles."""
        return self


@dataclass(frozen=True)
class Beside:
    """z' on the real axis: x/2 = am tau, or its complement (``below``: z' < z1)."""

    elliptic: Jacobi
    m: tuple[Scalar, Scalar]  # the parameter and its complement
    below: bool
    pi: Scalar

    def at(self, theta: Scalar, fn: SeriesFunctions) -> tuple[Scalar, Scalar, Scalar]:
        """cos(x/2), sin(x/2) and dx/dtheta."""
        j = self.elliptic
        tau = theta * j.K / self.pi
        if self.below:
            tau = tau + j.K
        waves = j.waves(tau, fn)
        sn, cn, dn = j.functions(waves)
        side = 1 - 2 * (waves.turns % 2)
        rate = 2 * dn * j.K / self.pi
        if self.below:
            return side * sn, -side * cn, rate
        return side * cn, side * sn, rate

    def inverse(self, x: Scalar) -> Scalar:
        """theta for x in [-pi, pi]."""
        j = self.elliptic
        c, s = mpmath.cos_sin(x / 2)
        if self.below:  # sn(tau + K) = c, cn(tau + K) = -s
            return self.pi * (_phase(j, self.m, c, -s) / j.K - 1)
        return self.pi * _phase(j, self.m, s, c) / j.K

    def floats(self) -> Beside:
        """The same in doubles."""
        m = float(self.m[0]), float(self.m[1])
        return Beside(self.elliptic.floats(), m, self.below, float(self.pi))


@dataclass(frozen=True)
class Around:
    """A pair of complex z': tan(x/2) = ka tan(am(tau)/2)."""

    elliptic: Jacobi
    m: tuple[Scalar, Scalar]
    ka: Scalar
    pi: Scalar

    def at(self, theta: Scalar, fn: SeriesFunctions) -> tuple[Scalar, Scalar, Scalar]:
        """cos(x/2), sin(x/2) and dx/dtheta."""
        j = self.elliptic
        # Whole turns of theta first: then the half of am has a cosine that is not negative.
        turns = fn.nint(theta / (2 * self.pi))
        waves = j.waves((theta - 2 * self.pi * turns) * 2 * j.K / self.pi, fn)
        sn, cn, dn = j.functions(waves)
        side = 1 - 2 * (waves.turns % 2)
        sn, cn = side * sn, side * cn
        half = _half(sn, cn, fn)
        c, s = half[0], self.ka * half[1]
        norm2 = c * c + s * s
        over = (1 - 2 * (turns % 2)) / fn.sqrt(norm2)
        return c * over, s * over, self.ka * dn * 2 * j.K / (self.pi * norm2)

    def inverse(self, x: Scalar) -> Scalar:
        """theta for x in [-pi, pi]."""
        c, s = mpmath.cos_sin(x / 2)
        c, s = self.ka * c, s
        norm = c * c + s * s
        sn, cn = 2 * c * s / norm, (c - s) * (c + s) / norm
        return self.pi * _phase(self.elliptic, self.m, sn, cn) / (2 * self.elliptic.K)

    def floats(self) -> Around:
        """The same in doubles."""
        m = float(self.m[0]), float(self.m[1])
        return Around(self.elliptic.floats(), m, float(self.ka), float(self.pi))


def _half(sn: Scalar, cn: Scalar, fn: SeriesFunctions) -> tuple[Scalar, Scalar]:
    """cos and sin of half the angle in [-pi, pi] with that sine and cosine."""
    larger = fn.sqrt((1 + abs(cn)) / 2)
    smaller = abs(sn) / (2 * larger)
    up = (cn >= 0) * 1
    c = up * larger + (1 - up) * smaller
    s = up * smaller + (1 - up) * larger
    return c, s * (1 - 2 * ((sn < 0) * 1))


def _phase(j: Jacobi, m: tuple[Scalar, Scalar], sn: Scalar, cn: Scalar) -> Scalar:
    """v in [-2K, 2K] with that sn and cn (Carlson's R_F; DLMF 22.15, 19.25)."""
    dn2 = m[1] + m[0] * cn * cn
    v = sn * mpmath.elliprf(cn * cn, dn2, 1)
    if cn < 0:
        v = (-2 if sn < 0 else 2) * j.K - v
    return v


def chart(variable: Variable, limit: int) -> tuple[Chart, int]:
    """The chart to use, and about how many samples of a turn it needs.

    x itself where ``limit`` samples are enough.
    """
    eta, nearest = width(variable)
    bits = mpmath.prec
    needed = 2 * bits * mpmath.ln2 / eta if eta else mpf("inf")
    if needed <= limit:
        return Plain(), int(needed)
    z1, z2, pi = variable.low, variable.high, +mpmath.pi
    if mpmath.im(nearest):
        one, other = abs(z2 - nearest), abs(z1 - nearest)
        gap = (z2 - z1) ** 2
        m = (gap - (one - other) ** 2) / (4 * one * other)
        m1 = ((one + other) ** 2 - gap) / (4 * one * other)
        return Around(jacobi(m, m1), (m, m1), mpmath.sqrt(other / one), pi), limit
    z = mpmath.re(nearest)
    below = bool(z < z1)
    span = z2 - z if below else z - z1
    m, m1 = (z2 - z1) / span, (z1 - z if below else z - z2) / span
    return Beside(jacobi(m, m1), (m, m1), below, pi), limit
