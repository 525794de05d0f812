"""The motion of a Lagrange top at one precision, in the top's own axes.

The Cayley-Klein parameters of R (body -> space, z up) and the velocity across the axis,

    al = cos(th/2) exp i(psi + phi)/2,   bt = sin(th/2) exp i(psi - phi)/2,   xi = p + i q,
    al' = (i/2) r al - conj(xi) bt/2,    bt' = -(i/2) r bt + xi al/2,
    xi' = i (C/A - 1) r xi - i (Mg z0/A)(g1 + i g2),   g1 + i g2 = 2i conj(al) bt,

are quotients of theta functions times a uniform turn (Klein and Sommerfeld, Theorie des Kreisels,
ch. VI; theta functions as in DLMF 20): with v = v0 + rate t, rate^2 = a (u3 - u1)/4,
k^2 = (u2 - u1)/(u3 - u1) and u = u1 + (u2 - u1) sn^2 v,

    al ~ Theta(v + i a1 s1)/Theta(v)     · exp(+i r (1 - C/A) t/2),   s1 = sgn(f + C r),
    bt ~ Theta(v + K + i a2 s2)/Theta(v) · exp(-i r (1 - C/A) t/2),   s2 = sgn(f - C r),
    xi ~ Theta(v + K - i a3 s3)/Theta(v) · exp(i (C/2A - 1) r t),     s3 = sgn(f - C r b),

each with the linear phase that makes it a solution
(:func:`polhode.closed_forms.functions.jacobi.quotient`).  They are single-valued, pass through 0
where the axis passes through a pole or stands still, and the separatrix (k' = 0) is no exception.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from polhode.closed_forms.functions.jacobi import (
    MP,
    Jacobi,
    Quotient,
    SeriesFunctions,
    Waves,
    jacobi,
    quotient,
)
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.lagrange.regimes import Constants
from polhode.closed_forms.lagrange.roots import Gaps, gaps
from polhode.numbers.exact import sign
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

#: A complex number of any scalars, as its two parts.
Parts: TypeAlias = tuple[Scalar, Scalar]


@dataclass(frozen=True)
class LagrangeStart:
    """al, bt, xi and their slopes at t = 0, psi such that the larger of al and bt is real."""

    values: tuple[Scalar, Scalar, Scalar]
    slopes: tuple[Scalar, Scalar, Scalar]


def equations(
    values: tuple[Scalar, Scalar, Scalar], r: Scalar, ratio: Scalar, torque: Scalar
) -> tuple[Scalar, ...]:
    """al', bt', xi' of al, bt, xi; ``ratio`` = C/A, ``torque`` = Mg z0/A."""
    al, bt, xi = values
    return (
        (1j * r * al - xi.conjugate() * bt) / 2,
        (-1j * r * bt + xi * al) / 2,
        1j * ((ratio - 1) * r * xi - torque * 2j * al.conjugate() * bt),
    )


@dataclass(frozen=True)
class Steady:
    """theta constant: al, bt and xi turn uniformly."""

    values: tuple[Parts, Parts, Parts]  # at t = 0
    rates: tuple[Scalar, Scalar, Scalar]
    r: Scalar
    speed: Scalar  # |w|

    def parameters(self, t: Scalar, fn: SeriesFunctions) -> tuple[Parts, Parts]:
        """al and bt."""
        al, bt, _ = self.all(t, fn)
        return al, bt

    def all(self, t: Scalar, fn: SeriesFunctions) -> tuple[Parts, Parts, Parts]:
        """al, bt and xi."""
        al, bt, xi = (
            times(z, fn.cos_sin(rate * t)) for z, rate in zip(self.values, self.rates, strict=True)
        )
        return al, bt, xi

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """arg al and arg bt, continuous in t, each to a constant."""
        return self.rates[0] * t, self.rates[1] * t

    def slopes(self, t: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """The derivatives of al, bt and xi."""
        now = self.all(t, MP)
        al, bt, xi = (1j * rate * mpc(*z) for z, rate in zip(now, self.rates, strict=True))
        return al, bt, xi

    @property
    def fastest(self) -> Scalar:
        """A bound of every rate in it."""
        return max(self.speed, *map(abs, self.rates))

    @property
    def means(self) -> tuple[Any, Any]:
        """The mean rates of arg al and arg bt."""
        return self.rates[0], self.rates[1]

    def floats(self, speed: Any) -> Steady:
        """The same with Python floats, time in units of 1/speed."""
        al, bt, xi = ((float(x), float(y)) for x, y in self.values)
        a, b, c = (float(x / speed) for x in self.rates)
        return Steady((al, bt, xi), (a, b, c), float(self.r / speed), 1.0)


@dataclass(frozen=True)
class Parameter:
    """z(t) = factor · (x + i sense y)/Theta(v_r) · exp i(rate t + jump n), (x, y) of ``shift``."""

    shift: Quotient
    sense: int
    factor: Parts
    rate: Scalar
    jump: Scalar
    uniform: Scalar  # what ``rate`` has beside sense · shift.rate · v'

    def at(self, t: Scalar, waves: Waves, over: Scalar, fn: SeriesFunctions) -> Parts:
        """z, with ``over`` = 1/Theta(v_r)."""
        x, y = self.shift.at(waves)
        turn = fn.cos_sin(self.rate * t + self.jump * waves.turns)
        re, im = times(times((x, -y if self.sense < 0 else y), turn), self.factor)
        return re * over, im * over

    def argument(self, t: Scalar, waves: Waves) -> Scalar:
        """arg z, continuous in t, to a constant."""
        x, y = self.shift.at(waves)
        return self.rate * t + self.jump * waves.turns + self.sense * mpmath.atan2(y, x)

    def slope(self, t: Scalar, waves: Waves, elliptic: Jacobi, rate: Scalar) -> Scalar:
        """dz/dt, where v' = ``rate``."""
        moved = elliptic.slopes(waves)
        below, fall = elliptic.denominator(waves), elliptic.denominator(moved) * rate
        x, y = self.shift.at(waves)
        dx, dy = self.shift.at(moved)
        z, dz = mpc(x, self.sense * y), mpc(dx, self.sense * dy) * rate
        grown = (dz + z * (1j * self.rate - fall / below)) / below
        return grown * mpc(*self.factor) * mpmath.expj(self.rate * t + self.jump * waves.turns)

    def mean(self, rate: Any, elliptic: Jacobi) -> Any:
        """The mean rate of arg z; a jump by pi, where z passes through 0, is not counted."""
        if not mpmath.isfinite(elliptic.K):
            return self.rate
        return self.rate + (self.jump - self.zeros * mpmath.pi) * rate / (2 * elliptic.K)

    @property
    def zeros(self) -> int:
        """How often z passes through 0 in a period, with the sense in which arg z then jumps."""
        return self.sense if self.passes and self.jump else 0

    @property
    def passes(self) -> bool:
        """Whether z passes through 0."""
        return not any(self.shift.real) or not any(self.shift.imaginary)

    def floats(self, speed: Any) -> Parameter:
        """The same with Python floats, time in units of 1/speed."""
        return Parameter(
            self.shift.floats(),
            self.sense,
            (float(self.factor[0]), float(self.factor[1])),
            float(self.rate / speed),
            float(self.jump),
            float(self.uniform / speed),
        )


@dataclass(frozen=True)
class Nutating:
    """The general motion; k = 0 excluded (:class:`Steady`), k' = 0 included."""

    elliptic: Jacobi
    rate: Scalar  # of v
    v0: Scalar
    al: Parameter
    bt: Parameter
    xi: Parameter
    r: Scalar
    speed: Scalar  # the largest |w|

    def parameters(self, t: Scalar, fn: SeriesFunctions) -> tuple[Parts, Parts]:
        """al and bt."""
        waves, over = self._waves(t, fn)
        return self.al.at(t, waves, over, fn), self.bt.at(t, waves, over, fn)

    def all(self, t: Scalar, fn: SeriesFunctions) -> tuple[Parts, Parts, Parts]:
        """al, bt and xi."""
        waves, over = self._waves(t, fn)
        return (
            self.al.at(t, waves, over, fn),
            self.bt.at(t, waves, over, fn),
            self.xi.at(t, waves, over, fn),
        )

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """arg al and arg bt, continuous in t but for jumps by pi at a zero, to a constant."""
        waves, _ = self._waves(t, MP)
        return self.al.argument(t, waves), self.bt.argument(t, waves)

    def turns_over_zeros(self, which: int, begin: Scalar, end: Scalar) -> int:
        """What arg al or arg bt gains on :meth:`arguments` if each zero on the way adds pi to it.

        In turns.  al is 0 at v = 0, bt at v = K, and again after each 2K.
        """
        z = (self.al, self.bt)[which]
        K = self.elliptic.K
        # Without a jump in a period the argument of a real quotient of one sign is none of a zero.
        if not (z.zeros if mpmath.isfinite(K) else z.passes):
            return 0
        v = [self.v0 + self.rate * t for t in (begin, end)]
        if mpmath.isfinite(K):
            first, last = (int(mpmath.floor((x - which * K) / (2 * K))) for x in v)
        else:
            first, last = (int(x > 0) for x in v)
        return max(0, z.sense * (first - last))

    def slopes(self, t: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """The derivatives of al, bt and xi."""
        waves, _ = self._waves(t, MP)
        al, bt, xi = (
            z.slope(t, waves, self.elliptic, self.rate) for z in (self.al, self.bt, self.xi)
        )
        return al, bt, xi

    @property
    def fastest(self) -> Scalar:
        """A bound of every rate in it."""
        found = [self.speed, self.rate]
        for z in (self.al, self.bt, self.xi):
            found += [abs(z.rate), abs(z.uniform), abs(z.shift.rate * self.rate)]
        return max(found)

    @property
    def means(self) -> tuple[Any, Any]:
        """The mean rates of arg al and arg bt, jumps at a pole not counted."""
        return self.al.mean(self.rate, self.elliptic), self.bt.mean(self.rate, self.elliptic)

    def floats(self, speed: Any) -> Nutating:
        """The same with Python floats, time in units of 1/speed."""
        return Nutating(
            self.elliptic.floats(),
            float(self.rate / speed),
            float(self.v0),
            self.al.floats(speed),
            self.bt.floats(speed),
            self.xi.floats(speed),
            float(self.r / speed),
            1.0,
        )

    def _waves(self, t: Scalar, fn: SeriesFunctions) -> tuple[Waves, Scalar]:
        waves = self.elliptic.waves(self.v0 + self.rate * t, fn)
        return waves, 1 / self.elliptic.denominator(waves)


LagrangeMotion: TypeAlias = Steady | Nutating


def steady(c: Constants, start: LagrangeStart, bits: int) -> Steady:
    """The motion with theta constant, at the precision in force."""
    r, u0 = number(c.r, bits), number(c.u0, bits)
    if c.level:
        psi, phi = (r, mpf(0)) if c.level > 0 else (mpf(0), r)
    else:
        psi = number(c.turning / c.across, bits)
        phi = r - psi * u0
    al, bt, xi = ((z.real, z.imag) for z in start.values)
    speed = mpmath.sqrt(number(c.speed2, bits) + r * r)
    return Steady((al, bt, xi), ((psi + phi) / 2, (psi - phi) / 2, -phi), r, speed)


def nutating(c: Constants, start: LagrangeStart, bits: int) -> Nutating:
    """The general motion, at the precision in force."""
    g = gaps(c, bits)
    a, r, ratio = (number(x, bits) for x in (c.a, c.r, c.ratio))
    elliptic = jacobi(g.u21 / g.u31, g.u32 / g.u31)
    rate = mpmath.sqrt(a * g.u31) / 2
    v0 = mpmath.sqrt(g.start[0] / g.u21) * mpmath.elliprf(g.start[1] / g.u21, g.start[2] / g.u31, 1)
    if sign(c.rate) < 0:
        v0 = -v0
    one, two, three = g.bottom
    spin = r * (1 - ratio) / 2
    wide = a * g.b[0]
    s1, s2, s3 = (1 if sign(x) >= 0 else -1 for x in (c.below, c.above, c.looping))
    k2 = g.u21 / g.u31
    shifts = (
        (_shift(elliptic, k2, (g.u31 / three, one / three, two / three), False), s1, spin),
        (_shift(elliptic, k2, _sides(g, g.top), True), s2, -spin),
        (_shift(elliptic, k2, _sides(g, g.b), True), -s3, (ratio / 2 - 1) * r),
    )
    # The largest modulus of each, met at v = K or v = 0.
    sizes = (two / 2, True), (g.top[0] / 2, False), (wide, False)
    begin = elliptic.waves(v0, MP)
    ends = elliptic.waves(elliptic.K, MP) if mpmath.isfinite(elliptic.K) else None
    made = []
    for (shift, sense, uniform), (size, at_end), z0, dz0 in zip(
        shifts, sizes, start.values, start.slopes, strict=True
    ):
        modulus = mpmath.sqrt(size)
        if not at_end or ends is not None:
            waves = ends if at_end and ends is not None else elliptic.waves(mpf(0), MP)
            modulus /= mpmath.hypot(*shift.at(waves)) / elliptic.denominator(waves)
        turn = sense * shift.rate * rate + uniform
        plain = Parameter(shift, sense, (mpf(1), mpf(0)), turn, sense * shift.jump, uniform)
        if z0:
            over = 1 / elliptic.denominator(begin)
            factor = z0 / mpc(*plain.at(mpf(0), begin, over, MP))
        else:
            factor = dz0 / plain.slope(mpf(0), begin, elliptic, rate)
        factor *= modulus / abs(factor)
        made.append(replace(plain, factor=(factor.real, factor.imag)))
    al, bt, xi = made
    return Nutating(elliptic, rate, v0, al, bt, xi, r, mpmath.sqrt(wide + r * r))


def times(a: Parts, b: Parts) -> Parts:
    """The product of two complex numbers."""
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _sides(g: Gaps, x: tuple[Scalar, Scalar, Scalar]) -> tuple[Scalar, Scalar, Scalar]:
    """sn^2, cn^2, dn^2 (modulus k') of a(x), x in [u2, u3]."""
    if not g.u32:
        return mpf(0), mpf(1), mpf(1)
    return x[2] / g.u32, x[1] / g.u32, x[0] / g.u31


def _shift(
    j: Jacobi, k2: Scalar, squares: tuple[Scalar, Scalar, Scalar], shifted: bool
) -> Quotient:
    """The quotient for the shift a with these sn^2, cn^2, dn^2 (modulus k'); a from the nearer end.

    sn, cn, dn of K' - a are cn/dn, k sn/dn, k/dn.
    """
    sn2, cn2, dn2 = squares
    a = mpmath.sqrt(sn2) * mpmath.elliprf(cn2, dn2, 1)
    if 2 * a <= j.Kc:
        return quotient(j, a, shifted=shifted)
    b = mpmath.sqrt(cn2 / dn2) * mpmath.elliprf(k2 * sn2 / dn2, k2 / dn2, 1)
    return quotient(j, b, from_end=True, shifted=shifted)
