"""Jacobi's functions and quotients of theta functions, in balls.

With the modulus k, its complement k', the quarter periods K and K', tau = i K'/K and z = v/2K,
the theta functions th1(z), ..., th4(z) have pi in their argument as those of FLINT have, and

    sn v = th3(0) th1(z)/(th2(0) th4(z)),    cn v = th4(0) th2(z)/(th2(0) th4(z)),
    dn v = th4(0) th3(z)/(th3(0) th4(z))     (DLMF 22.2).

The circle k = 0 and the separatrix k' = 0 are told by the exact 0. Every direction cosine and
Cayley-Klein parameter of Euler's and Lagrange's tops is a factor times

    F(v) = Th(v + i a)/Th(v) e^(i L v),    Th(v) = th4(z),    or Th(v + K + i a)/Th(v) e^(i L v).

What a is and what L is follows from the motion. For real v, with sn(i a, k) = i sc(a, k') and
sn(K + i a, k) = 1/dn(a, k') (DLMF 22.6(iv), 22.4),

    |F|^2 ~ 1 - k^2 sn^2(i a) sn^2 v       = 1 + k^2 sc^2(a, k') sn^2 v,
    |F|^2 ~ 1 - k^2 sn^2(K + i a) sn^2 v   = 1 - (k/dn(a, k'))^2 sn^2 v    of the other quotient:

both sides have the same periods, zeros and double poles. A modulus that is known as a multiple
of 1 + al sn^2 v therefore tells a by its functions to the modulus k'. The argument of F grows by
L + Im(Z(v + i a) - Z(v)), Z = Th'/Th; where v = i K', w is infinite, and Z(i K' + x) = -i pi/2K +
th1'/th1(x) makes that imaginary part, continued from real v, -i th1'/th1(i a). What is left of
the argument's rate there is what the motion adds for itself: so L = i th1'/th1(i a), or
i th2'/th2(i a) of the other quotient, the derivatives being those in v.

The quotient without its phase has the period 2K, so that v is reduced in it and not in the
phase.

*Its real part is positive* for |a| < K', which makes its principal root and argument
continuous: for 0 < x < pi/2 the function f(s) = arg(1 - s e^(-2ix)) rises from 0 to pi/2 - x on
0 <= s <= 1, and by the product for th4, with y the imaginary part of pi z and q the nome,

    arg th4(x + iy) = sum over n >= 1 of f(q^(2n-1) e^(2y)) - f(q^(2n-1) e^(-2y)),

where q^(2n-1) e^(2y) < q^(2n-2) and q^(2n-1) e^(-2y) > q^(2n) as |a| < K'. The sum telescopes:
it is between 0 and f(1) - f(0) = pi/2 - x. By symmetry so for x < 0, and for th3 by a quarter
period.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from flint import acb, arb, arb_poly, fmpz_poly

from polhode.closed_forms.balls.core import certainly, nearest_integer
from polhode.common.values import cached_property
from polhode.numbers.flint_context import ctx

# --- theta series ---------------------------------------------------------------------------------
#
# Theta functions of a real variable as polynomials, in balls: the same ones at many rows.
#
# With q = e^(-pi s), c = cos 2 pi z and Chebyshev's polynomials T, U (DLMF 18.5, 20.2)
#
#     th3(z), th4(z) = 1 + sum a_n cos 2 pi n z,    a_n = 2 (+-1)^n q^(n^2),  cos 2 pi n z = T_n(c),
#     th1(z) = sin pi z sum b_n (-1)^n W_n(c),      W_n = sin (2n + 1) pi z/sin pi z,
#     th2(z) = cos pi z sum b_n V_n(c),             V_n = cos (2n + 1) pi z/cos pi z,
#
# with b_n = 2 q^((n + 1/2)^2), and at a fixed distance above the real line
#
#     Re th3, th4(z + i y) = 1 + sum a_n cosh(2 pi n y) T_n(c),
#     Im th3, th4(z + i y) = -sin 2 pi z sum a_n sinh(2 pi n y) U_(n-1)(c).
#
# All four kinds of polynomials have the recurrence p_(n+1) = 2c p_n - p_(n-1), and for real z they
# are at most 2n + 1.  What is left out is bounded by twice its first term, once the terms are
# proven to fall by half.


#: Below this s the series are long and cancel; FLINT's own functions turn it into 1/s.
LEAST = 1 / 16
_T, _U, _V, _W = (fmpz_poly(p) for p in ([0, 1], [], [1], [-1]))  # each before the first, 1
_TWICE = fmpz_poly([0, 2])


class ThetaSeries:
    """The functions of one ``s`` = tau/i, real and at least :data:`LEAST`."""

    def __init__(self, s: arb) -> None:
        self._s = s
        odd = self._weights(1, arb(0))
        signed = [-b if n % 2 else b for n, b in enumerate(odd)]
        even = self._weights(0, arb(0))
        self.th1, self.th2 = _sum(signed, _W), _sum(odd, _V)
        self.th3, self.th4 = _sum(even, _T), _sum(_alternating(even), _T)

    def above(self, y: arb, *, third: bool) -> tuple[arb_poly, arb_poly]:
        """The real part of th4(z + i y), or th3, and the imaginary one over sin 2 pi z."""
        up, down = self._weights(0, y), self._weights(0, -y)
        real = [(a + b) / 2 for a, b in zip(up, down, strict=True)]
        imaginary = [(b - a) / 2 for a, b in zip(up, down, strict=True)]
        if not third:
            real, imaginary = _alternating(real), _alternating(imaginary)
        imaginary[1] += imaginary[0]  # nothing but the ball of what is left out
        return _sum(real, _T), _sum(imaginary[1:], _U)

    def _weights(self, odd: int, y: arb) -> list[arb]:
        """2 q^(m^2) e^(2 pi m y) with m = n + ``odd``/2, of n = 0 half if it is even.

        In the first is a ball of what all those left out give, of polynomials up to 2n + 1.
        """
        least, most = self._s.lower(), y.abs_upper()
        reach, width = float(most), float(least)
        certainly(math.isfinite(reach) and width > 0)
        count = 1 + math.ceil(reach / width + math.sqrt(ctx.prec * math.log(2) / (math.pi * width)))

        def weight(n: int, s: arb, y: arb) -> arb:
            m = arb(2 * n + odd) / 2
            return 2 * (arb.pi() * m * (2 * y - s * m)).exp()

        first, second = ((2 * n + 1) * weight(n, least, most) for n in (count, count + 1))
        certainly(2 * second < first)  # the ratios fall from one to the next
        weights = [weight(n, self._s, y) for n in range(count)]
        if not odd:
            weights[0] = arb(1)
        weights[0] += arb(0, (2 * first).abs_upper())
        return weights


def _alternating(weights: Sequence[arb]) -> list[arb]:
    return [-a if n % 2 else a for n, a in enumerate(weights)]


def _sum(weights: Sequence[arb], before: fmpz_poly) -> arb_poly:
    """The sum of the polynomials with so many weights, of which the first is 1."""
    total, polynomial = arb_poly([0]), fmpz_poly([1])
    for weight in weights:
        total += arb_poly(polynomial) * weight
        before, polynomial = polynomial, _TWICE * polynomial - before
    return total


# --- jacobi ---------------------------------------------------------------------------------------


_I = acb(0, 1)


class Jacobi:
    """The functions of one modulus, at the precision in force.

    ``k2`` and ``kc2`` are k^2 and k'^2, each from exact numbers and not from the other; the exact 0
    means the circle and the separatrix.  ``K`` is infinite on the separatrix.
    """

    def __init__(self, k2: arb, kc2: arb) -> None:
        self.circle, self.limit = k2.is_zero(), kc2.is_zero()
        self.K = arb.pos_inf()
        if self.limit:
            return
        mean = kc2.sqrt().agm(1)
        self._period = arb.pi() / mean
        self.K = self._period / 2
        if not self.circle:
            self._s = mean / k2.sqrt().agm(1)
            self.tau = acb(0, self._s)
            _, th2, th3, th4 = (th.real for th in acb.modular_theta(acb(0), self.tau))
            self.factors = th3 / th2, th4 / th2, th4 / th3  # of sn, cn, dn

    @cached_property
    def series(self) -> ThetaSeries | None:
        """Those of real variables; None where they are long."""
        return ThetaSeries(self._s) if self._s > LEAST else None

    @staticmethod
    def argument(squares: Iterable[arb], side: int = 1) -> arb:
        """v in [-K, K], or to the modulus k' in [-K', K'], from the squares of sn v, cn v and dn v.

        ``side``: the sign of sn v.
        """
        sn2, cn2, dn2 = squares
        return side * sn2.sqrt() * carlson_rf(cn2, dn2)

    def at(self, v: arb) -> ReducedArgument:
        """The functions at a phase."""
        if self.limit:
            return ReducedArgument(self, 0, v)
        z = v / self._period
        n = nearest_integer(z)
        return ReducedArgument(self, n, z - n)


class Shift:
    """The quotient Th(v + i a)/Th(v), or Th(v + K + i a)/Th(v) if ``half``, of one ``a``."""

    def __init__(self, jacobi: Jacobi, a: arb, half: bool) -> None:
        self.jacobi, self.a, self.half = jacobi, a, half
        if jacobi.circle or jacobi.limit:
            return
        self.y = a / (2 * jacobi.K)
        self._is_series = jacobi.series is not None and self.y.is_finite()
        if jacobi.series is not None and self._is_series:
            self._real, self._imaginary = jacobi.series.above(self.y, third=half)

    @property
    def rate(self) -> arb:
        """L of the quotient's phase."""
        jacobi = self.jacobi
        if jacobi.circle:
            return self.a.tanh() if self.half else self.a.coth()
        if jacobi.limit:
            return arb(0) if self.half else self.a.cot()
        y, which = acb(0, self.y), 1 if self.half else 0
        slope, value = (acb.modular_theta(y, jacobi.tau, n)[which] for n in (1, 0))
        return (_I * slope / value).real / (2 * jacobi.K)

    def at(self, place: ReducedArgument) -> acb:
        """The quotient at a place."""
        if self.jacobi.circle:
            return acb(1)
        if self.jacobi.limit:
            return (acb(1) if self.half else acb(place.z, self.a).cosh()) / place.z.cosh()
        if not self._is_series:
            z = acb(place.z, self.y)
            return acb.modular_theta(z, self.jacobi.tau)[2 if self.half else 3] / place.th4
        cosine, sine = place.double
        return acb(self._real(cosine) / place.th4, self._imaginary(cosine) * sine / place.th4)

    def slope(self, place: ReducedArgument) -> acb:
        """The quotient with its numerator differentiated: its derivative where it is 0."""
        jacobi = self.jacobi
        if jacobi.circle or (jacobi.limit and self.half):
            return acb(0)  # the numerator is constant
        if jacobi.limit:
            return acb(place.z, self.a).sinh() / place.z.cosh()
        below = place.th4 * 2 * jacobi.K
        z = acb(place.z, self.y)
        return acb.modular_theta(z, jacobi.tau, 1)[2 if self.half else 3] / below


class ReducedArgument:
    """What the functions take at v = 2K (``n`` + ``z``), |z| <= 1/2 but for the ball's radius.

    On the separatrix, whose K is infinite, ``z`` is v itself.  sn and cn of the reduced phase have
    the factor ``side`` = (-1)^n at the whole one.
    """

    def __init__(self, jacobi: Jacobi, n: int, z: arb) -> None:
        self._jacobi, self.n, self.z = jacobi, n, z
        self.side = -1 if n % 2 else 1

    @cached_property
    def functions(self) -> tuple[arb, arb, arb]:
        """sn and cn of the reduced phase, and dn, of either one."""
        jacobi = self._jacobi
        if jacobi.circle:
            return (*self._sin_cos, arb(1))
        if jacobi.limit:
            cn = self.z.sech()
            return self.z.tanh(), cn, cn
        if jacobi.series is None:
            th1, th2, th3, _ = self._thetas
        else:
            (sine, cosine), (double, _) = self._sin_cos, self.double
            th1, th2 = sine * jacobi.series.th1(double), cosine * jacobi.series.th2(double)
            th3 = jacobi.series.th3(double)
        (a, b, c), th4 = jacobi.factors, self.th4
        return a * th1 / th4, b * th2 / th4, c * th3 / th4

    @cached_property
    def _sin_cos(self) -> tuple[arb, arb]:
        """sin and cos of pi z."""
        sine, cosine = self.z.sin_cos_pi()
        return sine, cosine

    @cached_property
    def double(self) -> tuple[arb, arb]:
        """cos and sin of 2 pi z."""
        sine, cosine = self._sin_cos
        return (cosine - sine) * (cosine + sine), 2 * sine * cosine

    @cached_property
    def th4(self) -> arb:
        """th4(z)."""
        series = self._jacobi.series
        return self._thetas[3] if series is None else series.th4(self.double[0])

    @cached_property
    def _thetas(self) -> list[arb]:
        """th1, ..., th4 of z by FLINT."""
        return [th.real for th in acb.modular_theta(acb(self.z), self._jacobi.tau)]


def carlson_rf(x: arb, y: arb) -> arb:
    """Carlson's R_F of 1 and two numbers that are not negative."""
    return acb.elliptic_rf(acb(x), acb(y), acb(1)).real
