"""Jacobi's functions and quotients of theta functions, in balls.

With the modulus k, its complement k', the quarter periods K and K', tau = i K'/K and z = v/2K, the
theta functions th1(z), ..., th4(z) of :meth:`acb.modular_theta` have pi in their argument, and

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
        self.K = arb.pi() / (2 * mean)
        if not self.circle:
            self.tau = acb(0, mean / k2.sqrt().agm(1))
            _, th2, th3, th4 = (th.real for th in acb.modular_theta(acb(0), self.tau))
            self.factors = th3 / th2, th4 / th2, th4 / th3  # of sn, cn, dn

    def phase(self, sn0: arb, cn2: arb, dn2: arb) -> arb:
        """v in [-K, K] with sn v = ``sn0``; the squares of cn v and dn v are given."""
        return sn0 * carlson_rf(cn2, dn2)

    def shift(self, sn2: arb, cn2: arb, dn2: arb) -> arb:
        """a in [0, K'] from the squares of its functions to the modulus k'."""
        return sn2.sqrt() * carlson_rf(cn2, dn2)

    def at(self, v: arb) -> Place:
        """The functions at a phase."""
        n = 0
        if not self.limit:
            n = nearest_integer(v / (2 * self.K))
            v = v - 2 * n * self.K
        return Place(self, n, v)

    def rate(self, a: arb, half: bool) -> arb:
        """L of the quotient's phase."""
        if self.circle:
            return a.tanh() if half else a.coth()
        if self.limit:
            return arb(0) if half else a.cot()
        y, which = acb(0, a / (2 * self.K)), 1 if half else 0
        slope, value = (acb.modular_theta(y, self.tau, n)[which] for n in (1, 0))
        return (_I * slope / value).real / (2 * self.K)


class Place:
    """What the functions take at v = 2K ``n`` + ``v``, |v| <= K but for the ball's radius.

    ``sn`` and ``cn`` are those of the reduced v: at the whole phase they have the factor
    ``side`` = (-1)^n.
    """

    def __init__(self, jacobi: Jacobi, n: int, v: arb) -> None:
        self._jacobi, self.n, self.v = jacobi, n, v
        self.side = -1 if n % 2 else 1
        if jacobi.circle:
            self.sn, self.cn = v.sin_cos()
            self.dn = arb(1)
        elif jacobi.limit:
            self.sn, self.cn = v.tanh(), v.sech()
            self.dn = self.cn
        else:
            self._z = acb(v / (2 * jacobi.K))
            th1, th2, th3, self._th4 = (th.real for th in acb.modular_theta(self._z, jacobi.tau))
            a, b, c = jacobi.factors
            self.sn, self.cn, self.dn = (
                a * th1 / self._th4,
                b * th2 / self._th4,
                c * th3 / self._th4,
            )

    def quotient(self, a: arb, half: bool) -> acb:
        """Th(v + i a)/Th(v), or Th(v + K + i a)/Th(v) if ``half``, ``a`` of either sign."""
        jacobi = self._jacobi
        if jacobi.circle:
            return acb(1)
        if jacobi.limit:
            return (acb(1) if half else acb(self.v, a).cosh()) / self.v.cosh()
        z = self._z + acb(0, a / (2 * jacobi.K))
        return acb.modular_theta(z, jacobi.tau)[2 if half else 3] / self._th4

    def slope(self, a: arb, half: bool) -> acb:
        """The quotient with its numerator differentiated: its derivative where it is 0."""
        jacobi = self._jacobi
        if jacobi.circle or (jacobi.limit and half):
            return acb(0)  # the numerator is constant
        if jacobi.limit:
            return acb(self.v, a).sinh() / self.v.cosh()
        z = self._z + acb(0, a / (2 * jacobi.K))
        below = self._th4 * 2 * jacobi.K
        return acb.modular_theta(z, jacobi.tau, 1)[2 if half else 3] / below


def carlson_rf(x: arb, y: arb, z: arb | int = 1) -> arb:
    """Carlson's R_F of numbers that are not negative."""
    return acb.elliptic_rf(acb(x), acb(y), acb(z)).real
