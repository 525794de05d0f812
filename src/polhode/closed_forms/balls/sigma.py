"""Weierstrass' functions of a real lattice, in balls.

    y^2 = 4 (x - x0)(x - x1)(x - x2),    x = P(v),    y = P'(v),    x0 + x1 + x2 = 0,

with x0 > x1 > x2, or x0 real and a conjugate pair.  The real period T and the imaginary one i T'
are pi over arithmetic-geometric means of real numbers.  The lattice is spanned by T and i T' in the
first case, by T and (T + i T')/2 in the second (DLMF 23.22(ii); Cohen, A Course in Computational
Algebraic Number Theory, 7.4).
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits

_I = acb(0, 1)


class RealLattice:
    """The lattice of three roots at the precision in force, ``roots[0]`` real as said above.

    ``halves[j]`` is the half period at which P is ``roots[j]``.
    """

    def __init__(self, roots: Sequence[acb]) -> None:
        self._roots = x0, x1, x2 = [*roots]
        if x1.imag.is_zero():
            a, b, c = (z.real.sqrt() for z in (x0 - x2, x0 - x1, x1 - x2))
            self.period, across = arb.pi() / a.agm(b), arb.pi() / a.agm(c)
            self._tau = acb(0, across / self.period)
        else:
            one, other = (x0 - x1).sqrt(), (x1 - x0).sqrt()
            self.period, across = (arb.pi() / z.real.agm(abs(z)) for z in (one, other))
            self._tau = acb(0.5, across / (2 * self.period))
        one, two = acb(self.period) / 2, self._tau * self.period / 2
        both = one + two
        #: The growth of zeta over the period.
        self.eta = 2 * self.zeta(one)
        if x1.imag.is_zero():
            self.halves = one, both, two
            return
        height = self.P(two).imag * x1.imag
        if not (height > 0 or height < 0):
            raise TooFewBits
        self.halves = (one, two, both) if height > 0 else (one, both, two)

    def P(self, v: acb) -> acb:  # noqa: N802
        """P(v)."""
        return (v / self.period).elliptic_p(self._tau) / (self.period * self.period)

    def zeta(self, v: acb) -> acb:
        """Minus the integral of P, odd."""
        return (v / self.period).elliptic_zeta(self._tau) / self.period

    def sigma(self, v: acb) -> acb:
        """Its exponential integral."""
        return (v / self.period).elliptic_sigma(self._tau) * self.period

    def argument(self, x: arb) -> acb:
        """A v with P(v) = x, which is real and no root: half a period and a real or imaginary part.

        By Carlson's R_F of three numbers that are positive, or of one and a conjugate pair.
        """
        roots, above = self._roots, 0
        real = [root.real for root in roots if root.imag.is_zero()]
        for root in real:
            if not (x < root or x > root):
                raise TooFewBits
            above += x < root
        gaps = [x - root for root in roots]
        if above in (0, len(real)):
            start = acb(0)
        else:
            # P(v + half) = x_i + (x_i - x_j)(x_i - x_k)/(P(v) - x_i)
            i, j, k = (0, 1, 2) if above == 1 else (2, 0, 1)
            one, two, over = roots[i] - roots[j], roots[i] - roots[k], 1 / gaps[i]
            gaps = [one * two * over, one * gaps[k] * over, two * gaps[j] * over]
            start = self.halves[i]
        if above % 2 == 0:
            return start + acb.elliptic_rf(*gaps)
        return start + _I * acb.elliptic_rf(*(-gap for gap in gaps))


class Shifted:
    """exp(-zeta(v) z) sigma(z + v)/sigma(z), a number of which multiplies with each period."""

    def __init__(self, lattice: RealLattice, v: acb) -> None:
        self._lattice, self._v, self._zeta = lattice, v, lattice.zeta(v)
        self._grown = lattice.eta * v - self._zeta * lattice.period
        #: sigma(v).
        self.size = lattice.sigma(v)

    def at(self, z: acb, below: acb, n: int = 0) -> acb:
        """The value at z + n periods; ``below``: sigma(z)."""
        return (n * self._grown - self._zeta * z).exp() * self._lattice.sigma(z + self._v) / below
