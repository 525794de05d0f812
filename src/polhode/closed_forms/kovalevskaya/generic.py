"""Generic motion of the Kovalevskaya top: quotients of genus-2 theta functions of z0 + t V.

With g_j^2 = 2(e_j + H), f_j^2 = e_j^2 + b, f_j g_j = 2m, S'_j = S'(e_j) and
P_j = sqrt((s1 - e_j)(s2 - e_j)) = c_j th_j/th_0 (Kowalevski 1889, sections 4-7; Koetter, Acta Math.
17 (1893) 209), C_j = c_j/S'_j and D = sum g_j C_j th_j,

    p = sum f_j C_j th_j/D,    q = i th_0/D,
    r = -2i sum_{j<l} (f_j g_l - f_l g_j) C_j C_l K_jl th_jl/D,
    G3 = i sum_{j<l} (e_j - e_l) g_j g_l C_j C_l K_jl th_jl/D,
    G1 = H - p^2 - q^2 - r^2/2,    G2 = -r'.

th_0 has the characteristic del, th_j del + eta_j, th_jl del + eta_j + eta_l.  c_j^2 is known from
z at two branch points, K_jl = (th_j' th_l - th_j th_l')/(th_0 th_jl) likewise.  The three signs of
the c_j are those that reproduce the start; what then is left, ``defect``, certifies the set-up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya.abel_map import starts
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.curve import KovalevskayaCurve, Unresolved, curve
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair
from polhode.closed_forms.kovalevskaya.theta.riemann_theta import Thetas, added, thetas
from polhode.numbers.mpmath_context import mpc, mpmath
from polhode.numbers.scalars import Scalar

PAIRS = ((0, 1), (0, 2), (1, 2))


@dataclass(frozen=True)
class Generic:
    """The constants of one motion at one precision.

    States p, q, r, G1, G2, G3 are in the top's axes and units.
    """

    curve: KovalevskayaCurve
    thetas: Thetas  # del, del + eta_j, del + eta_j + eta_l
    z0: Pair
    velocity: Pair  # V
    H: Scalar
    over: Sequence[Scalar]  # g_j C_j
    p: Sequence[Scalar]  # f_j C_j
    r: Sequence[Scalar]
    G3: Sequence[Scalar]
    defect: Scalar

    def at(self, t: Scalar) -> tuple[list[Scalar], Scalar]:
        """The state at t, and the largest imaginary part: it ought to be 0."""
        found = self.complex_at(t)
        return [x.real for x in found], max(abs(x.imag) for x in found)

    def complex_at(self, t: Scalar) -> list[Scalar]:
        """The state at t as the complex numbers that the quotients give."""
        z = self.z0[0] + t * self.velocity[0], self.z0[1] + t * self.velocity[1]
        return self.state(z)

    def state(self, z: Pair) -> list[Scalar]:
        """That of a point of the Jacobian."""
        return _state(self, self.thetas.at(z))


def generic(start: KovalevskayaStart, bits: int, backend: str | None = None) -> Generic:
    """The constants at ``bits`` bits; raises Unresolved where these are too few."""
    with mpmath.workprec(bits):
        made = curve(start, bits)
        tau = made.periods[2]
        if not (tau[0].imag > 0 and tau[0].imag * tau[2].imag > tau[1].imag ** 2):
            raise Unresolved
        etas, delta = made.characteristics, made.delta
        velocity = made.reduced((mpc(0), mpc(1)))
        wanted = [delta, *(added(delta, etas[j]) for j in range(3))]
        wanted += [added(delta, etas[j], etas[l]) for j, l in PAIRS]
        functions = thetas(tau, velocity, wanted, backend)
        H, m, b = (number(x, bits) for x in (start.H, start.m, start.b))
        e = made.points[:3]
        slopes = [(e[j] - e[j - 1]) * (e[j] - e[j - 2]) for j in range(3)]
        f, g = [], []
        for x in e:
            one, other = mpmath.sqrt(x * x + b), mpmath.sqrt(2 * (x + H))
            if abs(other) > abs(one):
                one = 2 * m / other if other else one
            elif one:
                other = 2 * m / one
            f.append(one)
            g.append(other)
        c = _constants(made, functions)
        K = _brackets(made, functions)
        w, G = start.numbers(bits)
        speed, weight = max(1, *(abs(x) for x in w)), number(start.weight, bits)
        best: Generic | None = None
        for u in starts(made, start):
            z0 = made.reduced(u)
            values = functions.at(z0)
            for signs in product((1, -1), repeat=3):
                C = [s * x / d for s, x, d in zip(signs, c, slopes, strict=True)]
                mixed = [C[j] * C[l] * k for (j, l), k in zip(PAIRS, K, strict=True)]
                found = Generic(
                    curve=made,
                    thetas=functions,
                    z0=z0,
                    velocity=velocity,
                    H=H,
                    over=[x * y for x, y in zip(g, C, strict=True)],
                    p=[x * y for x, y in zip(f, C, strict=True)],
                    r=[
                        -2j * (f[j] * g[l] - f[l] * g[j]) * k
                        for (j, l), k in zip(PAIRS, mixed, strict=True)
                    ],
                    G3=[
                        1j * (e[j] - e[l]) * g[j] * g[l] * k
                        for (j, l), k in zip(PAIRS, mixed, strict=True)
                    ],
                    defect=None,
                )
                try:
                    state = _state(found, values)
                except ZeroDivisionError:
                    continue
                miss = max(
                    *(abs(x - y) / speed for x, y in zip(state[:3], w, strict=True)),
                    *(abs(x - y) / weight for x, y in zip(state[3:], G, strict=True)),
                )
                if best is None or miss < best.defect:
                    best = replace(found, defect=miss)
        if best is None:
            raise Unresolved
        return best


def _state(motion: Generic, values: Sequence[tuple[Scalar, Scalar]]) -> list[Scalar]:
    """p, q, r, G1, G2, G3 from the thetas and their derivatives."""
    zero, *rest = values
    singles, doubles = rest[:3], rest[3:]
    D = _dot(motion.over, singles, 0)
    over = 1 / D
    p = _dot(motion.p, singles, 0) * over
    q = 1j * zero[0] * over
    r = _dot(motion.r, doubles, 0) * over
    G3 = _dot(motion.G3, doubles, 0) * over
    G2 = -(_dot(motion.r, doubles, 1) - r * _dot(motion.over, singles, 1)) * over
    return [p, q, r, motion.H - p * p - q * q - r * r / 2, G2, G3]


def _dot(row: Sequence[Scalar], values: Sequence[tuple[Scalar, Scalar]], which: int) -> Scalar:
    total: Any = 0
    for x, value in zip(row, values, strict=True):
        total = total + x * value[which]
    return total


def _constants(made: KovalevskayaCurve, functions: Thetas) -> list[Scalar]:
    """c_j up to signs: c_j^2 = (e_l - e_j)(e_n - e_j)(th_0/th_j)^2 at A_l + A_n."""
    e, found = made.points, []
    for j in range(3):
        l, n = (i for i in range(3) if i != j)
        values = functions.at(_point(made, l, n))
        square = (e[l] - e[j]) * (e[n] - e[j]) * (values[0][0] / values[1 + j][0]) ** 2
        found.append(mpmath.sqrt(square))
    return found


def _brackets(made: KovalevskayaCurve, functions: Thetas) -> list[Scalar]:
    """K_jl at A_j + A_n, n another finite branch point: the one with the largest denominator."""
    found = []
    for i, (j, l) in enumerate(PAIRS):
        rows = [functions.at(_point(made, j, n)) for n in range(5) if n not in (j, l)]
        row = max(rows, key=lambda v: abs(v[0][0] * v[4 + i][0]) / _size(v) ** 2)
        (a, da), (b, db) = row[1 + j], row[1 + l]
        found.append((da * b - a * db) / (row[0][0] * row[4 + i][0]))
    return found


def _size(values: Sequence[tuple[Scalar, Scalar]]) -> Scalar:
    return max(abs(value) for value, _ in values)


def _point(made: KovalevskayaCurve, j: int, n: int) -> Pair:
    one, other = made.images[j], made.images[n]
    return made.reduced((one[0] + other[0], one[1] + other[1]))
