"""Jacobi's functions and quotients of theta functions, in balls.

With the modulus k, its complement k', the quarter periods K and K', tau = i K'/K and z = v/2K, the
theta functions th1(z), ..., th4(z) have pi in their argument as those of FLINT have, and

    sn v = th3(0) th1(z)/(th2(0) th4(z)),    cn v = th4(0) th2(z)/(th2(0) th4(z)),
    dn v = th4(0) th3(z)/(th3(0) th4(z))     (DLMF 22.2).

The circle k = 0 and the separatrix k' = 0 are told by the exact 0.  Every direction cosine and
Cayley-Klein parameter of Euler's and Lagrange's tops is a factor times

    F(v) = Th(v + i a)/Th(v) e^(i L v),    Th(v) = th4(z),    or Th(v + K + i a)/Th(v) e^(i L v).

The quotient without its phase has the period 2K, so that v is reduced in it and not in the phase.

*Its real part is positive* for |a| < K', which makes its principal root and argument continuous:
for 0 < x < pi/2 the function f(s) = arg(1 - s e^(-2ix)) rises from 0 to pi/2 - x on 0 <= s <= 1,
and by the product for th4, with y the imaginary part of pi z and q the nome,

    arg th4(x + iy) = sum over n >= 1 of f(q^(2n-1) e^(2y)) - f(q^(2n-1) e^(-2y)),

where q^(2n-1) e^(2y) < q^(2n-2) and q^(2n-1) e^(-2y) > q^(2n) as |a| < K'.  The sum telescopes: it
is between 0 and f(1) - f(0) = pi/2 - x.  By symmetry so for x < 0, and for th3 by a quarter period.
"""

from __future__ import annotations

from flint import acb, arb

from polhode.closed_forms.balls.core import nearest_integer
from polhode.closed_forms.balls.theta_series import LEAST, ThetaSeries
from polhode.common.values import cached_property

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
            s = mean / k2.sqrt().agm(1)
            self.tau = acb(0, s)
            _, th2, th3, th4 = (th.real for th in acb.modular_theta(acb(0), self.tau))
            self.factors = th3 / th2, th4 / th2, th4 / th3  # of sn, cn, dn
            #: None where they are long.
            self.series = ThetaSeries(s) if s > LEAST else None

    def phase(self, sn0: arb, cn2: arb, dn2: arb) -> arb:
        """v in [-K, K] with sn v = ``sn0``; the squares of cn v and dn v are given."""
        return sn0 * carlson_rf(cn2, dn2)

    def shift(self, sn2: arb, cn2: arb, dn2: arb) -> arb:
        """a in [0, K'] from the squares of its functions to the modulus k'."""
        return sn2.sqrt() * carlson_rf(cn2, dn2)

    def at(self, v: arb) -> Place:
        """The functions at a phase."""
        if self.limit:
            return Place(self, 0, v)
        z = v / self._period
        n = nearest_integer(z)
        return Place(self, n, z - n)


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

    def at(self, place: Place) -> acb:
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

    def slope(self, place: Place) -> acb:
        """The quotient with its numerator differentiated: its derivative where it is 0."""
        jacobi = self.jacobi
        if jacobi.circle or (jacobi.limit and self.half):
            return acb(0)  # the numerator is constant
        if jacobi.limit:
            return acb(place.z, self.a).sinh() / place.z.cosh()
        below = place.th4 * 2 * jacobi.K
        z = acb(place.z, self.y)
        return acb.modular_theta(z, jacobi.tau, 1)[2 if self.half else 3] / below


class Place:
    """What the functions take at v = 2K (``n`` + ``z``), |z| <= 1/2 but for the ball's radius.

    On the separatrix, whose K is infinite, ``z`` is v itself.  ``sn`` and ``cn`` are those of the
    reduced phase: at the whole one they have the factor ``side`` = (-1)^n.
    """

    def __init__(self, jacobi: Jacobi, n: int, z: arb) -> None:
        self._jacobi, self.n, self.z = jacobi, n, z
        self.side = -1 if n % 2 else 1

    @property
    def sn(self) -> arb:
        """sn of the reduced phase."""
        return self._functions[0]

    @property
    def cn(self) -> arb:
        """cn of the reduced phase."""
        return self._functions[1]

    @property
    def dn(self) -> arb:
        """dn, of either phase."""
        return self._functions[2]

    @cached_property
    def _functions(self) -> tuple[arb, arb, arb]:
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


def carlson_rf(x: arb, y: arb, z: arb | int = 1) -> arb:
    """Carlson's R_F of numbers that are not negative."""
    return acb.elliptic_rf(acb(x), acb(y), acb(z)).real
