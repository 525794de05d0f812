"""Solutions of y'^2 = f(y), f a quartic, from a start (y0, y0'), by Weierstrass' function in
balls.

    y = y0 + [-y0' P' + f'(P - f''/24)/2 + f f'''/24] / [2 (P - f''/24)^2 - f f''''/48],

f and its derivatives at y0, P = P(t; g2, g3) of the invariants of f (Biermann 1865; Whittaker &
Watson, A Course of Modern Analysis, 20.6). No sign of a root is chosen; y0 and t may be complex
while g2 and g3 are real. P comes from Jacobi's functions (DLMF 23.6):

    P = e3 + (e1 - e3)/sn^2,    or P = e + size (1 + cn)/(1 - cn) if only e is real.

With s = sn, the numbers P s^2 and P' s^3 are polynomials in sn, cn, dn, and so are numerator
and denominator times s^4 (with 1 - cn for s^2 in the other case): the poles of P are no
exceptions.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import ball, certainly, nearest_integer
from polhode.closed_forms.balls.jacobi import Jacobi
from polhode.numbers.exact import Exact, sign

# --- sigma ----------------------------------------------------------------------------------------
#
# Weierstrass' functions of a real lattice, in balls.
#
#     y^2 = 4 (x - x0)(x - x1)(x - x2),    x = P(v),    y = P'(v),    x0 + x1 + x2 = 0,
#
# with x0 > x1 > x2, or x0 real and a conjugate pair.  The real period T and the imaginary one i T'
# are pi over arithmetic-geometric means of real numbers.  The lattice is spanned by T and i T' in
# the first case, by T and (T + i T')/2 in the second (DLMF 23.22(ii); Cohen, A Course in
# Computational Algebraic Number Theory, 7.4).


class RealLattice:
    """The lattice of three roots at the precision in force, ``roots[0]`` real as said above.

    ``halves[j]`` is the half period at which P is ``roots[j]``.
    """

    def __init__(self, roots: Sequence[acb]) -> None:
        x0, x1, x2 = roots
        if x1.imag.is_zero():
            a, b, c = (z.real.sqrt() for z in (x0 - x2, x0 - x1, x1 - x2))
            self.period, across = arb.pi() / a.agm(b), arb.pi() / a.agm(c)
            self._tau = acb(0, across / self.period)
        else:
            first, mirrored = (x0 - x1).sqrt(), (x1 - x0).sqrt()
            self.period, across = (arb.pi() / z.real.agm(abs(z)) for z in (first, mirrored))
            self._tau = acb(0.5, across / (2 * self.period))
        first, second = acb(self.period) / 2, self._tau * self.period / 2
        both = first + second
        #: The growth of zeta over the period.
        self.eta = 2 * self.zeta(first)
        if x1.imag.is_zero():
            self.halves = first, both, second
            return
        height = self.P(second).imag * x1.imag
        certainly(height > 0 or height < 0)
        self.halves = (first, second, both) if height > 0 else (first, both, second)

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
        """A v with P(v) = x."""
        return (x * self.period * self.period * acb(1)).elliptic_inv_p(self._tau) * self.period


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


# --- weierstrass ----------------------------------------------------------------------------------


#: sn, cn, dn.
Functions: TypeAlias = tuple[acb, acb, acb]


class Quartic(NamedTuple):
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
    def has_period(self) -> bool:
        """Whether real solutions repeat; others tend to a double root of f, which is exact."""
        g2, g3 = self.invariants
        return sign(g2 * g2 * g2 - 27 * g3 * g3) != 0 or sign(g3) > 0

    def derivatives(self, y: acb) -> list[acb]:
        """f, f', f'', f''', f'''' at y."""
        a0, a1, a2, a3, a4 = (acb(ball(x)) for x in self.a)
        return [
            (((a0 * y + 4 * a1) * y + 6 * a2) * y + 4 * a3) * y + a4,
            4 * (((a0 * y + 3 * a1) * y + 3 * a2) * y + a3),
            12 * ((a0 * y + 2 * a1) * y + a2),
            24 * (a0 * y + a1),
            24 * a0,
        ]


class Weierstrass:
    """P of a quartic's invariants at the precision in force.

    ``functions`` are Jacobi's of rate t, None where P = 1/t^2; ``paired``: only one e is real.
    """

    def __init__(self, quartic: Quartic) -> None:
        self.quartic, (g2, g3) = quartic, quartic.invariants
        self.g2 = ball(g2)
        self.functions: Jacobi | None = None
        self.paired, self.base, self.size, self.rate = False, arb(0), arb(1), arb(1)
        exact = g2 * g2 * g2 - 27 * g3 * g3
        kind = sign(exact)
        if kind < 0:
            self._one_real_root(g3, ball(-exact))
        elif kind > 0:
            self._three_real_roots(ball(g3), ball(exact))
        elif sign(g2):
            self._double_root(g2, g3)

    @property
    def period(self) -> arb | None:
        """The real period; None where there is none."""
        if self.functions is None or self.functions.limit:
            return None
        return (4 if self.paired else 2) * self.functions.K / self.rate

    def at(self, t: acb) -> Functions:
        """sn, cn and dn of rate t."""
        assert self.functions is not None
        return complex_functions(self.functions, self.rate * t)

    def _double_root(self, g2: Exact, g3: Exact) -> None:
        """The roots d, d, -2d."""
        d = ball(-3 * g3 / (2 * g2))
        width = 3 * abs(d)
        upper = sign(g3) < 0  # the double root
        self.base, self.size, self.rate = (-2 * d if upper else d), width, width.sqrt()
        self.functions = Jacobi(arb(1), arb(0)) if upper else Jacobi(arb(0), arb(1))

    def _three_real_roots(self, g3: arb, disc: arb) -> None:
        """Gaps of the roots by sines: no differences."""
        size, third = (self.g2 / 3).sqrt(), (disc / 27).sqrt()
        angle, mirrored = arb.atan2(third, g3) / 3, arb.atan2(third, -g3) / 3
        lower, upper = angle.sin(), mirrored.sin()
        width = arb(3).sqrt() * size * (lower + upper)
        self.base = size * (angle + 2 * arb.pi() / 3).cos()
        self.size, self.rate = width, width.sqrt()
        self.functions = Jacobi(lower / (lower + upper), upper / (lower + upper))

    def _one_real_root(self, g3: Exact, disc: arb) -> None:
        side = 1 if sign(g3) > 0 else -1
        cube = side * ball(g3) / 8 + (disc / 1728).sqrt()
        certainly(cube > 0)
        u = side * cube.root(3)
        real = u + self.g2 / (12 * u)
        size = (3 * real * real - self.g2 / 4).sqrt()
        share = 3 * real / (4 * size)
        self.paired, self.base, self.size, self.rate = True, real, size, 2 * size.sqrt()
        self.functions = Jacobi(arb(0.5) - share, arb(0.5) + share)


class WeierstrassSolution:
    """y as a function of complex time, at the precision in force."""

    def __init__(self, P: Weierstrass, y0: acb, slope: acb) -> None:
        self.P, self._f = P, P.quartic.derivatives(y0)
        self._y0, self._slope = y0, slope

    def value(self, t: acb) -> tuple[acb, acb]:
        """y and y'."""
        Y, Z, Y1 = self.quotient(t)
        return Y / Z, Y1 / (Z * Z)

    def quotient(self, t: acb) -> tuple[acb, acb, acb]:
        """Y, Z and Y' Z - Y Z' of y = Y/Z."""
        return self._with_pair(t) if self.P.paired else self._with_sine(t)

    def _with_sine(self, t: acb) -> tuple[acb, acb, acb]:
        f, f1, f2, f3, f4 = self._f
        P = self.P
        if P.functions is None:
            s, top, slope = t, acb(1), acb(-2)
        else:
            s, cn, dn = P.at(t)
            top, slope = P.base * s * s + P.size, -2 * P.size * P.rate * cn * dn
        s2 = s * s
        x = top - f2 / 24 * s2
        Z = 2 * x * x - f * f4 / 48 * s2 * s2
        N = -self._slope * slope + s * (f1 * x / 2 + f * f3 / 24 * s2)
        N1 = -self._slope * (6 * top * top - P.g2 / 2 * s2 * s2) + f1 * slope * s / 2
        return self._y0 * Z + s * N, Z, N1 * Z - 4 * N * x * slope

    def _with_pair(self, t: acb) -> tuple[acb, acb, acb]:
        f, f1, f2, f3, f4 = self._f
        P = self.P
        sn, cn, dn = P.at(t)
        less = sn * sn / (1 + cn) if cn.real.mid() > 0 else 1 - cn
        top, slope = P.base * less + P.size * (1 + cn), -2 * P.size * P.rate * dn
        x = top - f2 / 24 * less
        Z = 2 * x * x - f * f4 / 48 * less * less
        A, B = -self._slope * slope, f1 * x / 2 + f * f3 / 24 * less
        N1 = -self._slope * (6 * top * top - P.g2 / 2 * less * less) + f1 * sn * slope / 2
        moved = N1 * Z - 4 * x * slope * (A * (1 + cn) + B * sn)
        return self._y0 * Z + sn * A + less * B, Z, moved


def complex_functions(functions: Jacobi, v: acb) -> Functions:
    """sn, cn and dn of a complex number."""
    if functions.circle:
        return v.sin(), v.cos(), acb(1)
    if functions.limit:
        return v.tanh(), v.sech(), v.sech()
    z = v / (2 * functions.K)
    n = nearest_integer(z.real)
    th1, th2, th3, th4 = acb.modular_theta(z - n, functions.tau)
    a, b, c = functions.factors
    side = -1 if n % 2 else 1
    return side * a * th1 / th4, side * b * th2 / th4, c * th3 / th4
