"""Generic motion of the Kovalevskaya top in balls: quotients of theta functions of z0 + t V.

With g_j^2 = 2(e_j + H), f_j^2 = e_j^2 + b, f_j g_j = 2m, S'_j = S'(e_j) and
P_j = sqrt((s1 - e_j)(s2 - e_j)) = c_j th_j/th_0 (Kowalevski 1889, sections 4-7; Koetter, Acta Math.
17 (1893) 209), C_j = c_j/S'_j and D = sum g_j C_j th_j,

    p = sum f_j C_j th_j/D,    q = i th_0/D,
    r = -2i sum_{j<l} (f_j g_l - f_l g_j) C_j C_l K_jl th_jl/D,
    G3 = i sum_{j<l} (e_j - e_l) g_j g_l C_j C_l K_jl th_jl/D,
    G1 = H - p^2 - q^2 - r^2/2,    G2 = -r'.

P_j is such a quotient because its square is a function on the Jacobian with a double zero and a
double pole.  Where the two points are the branch points e_l and e_n it is known, which gives c_j^2
= (e_l - e_j)(e_n - e_j) (th_0/th_j)^2 there.  Where th_0 = 0, s1 is infinite, w1/s1^3 and w2/(s2 -
s1) are 0, so that (P_j/P_l)' = 0: th_j' th_l - th_j th_l' is divisible by th_0, and what is left is
a theta function of first order with the characteristic of th_jl, of which there is one up to a
factor: K_jl = (th_j' th_l - th_j th_l')/(th_0 th_jl), read where both points are branch points.

th_0 has the characteristic del, th_j del + eta_j, th_jl del + eta_j + eta_l.  Of the signs of the
c_j each choice is dropped that is proven to miss the start; the truth is in the union of the rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple, TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.clocks import Pair
from polhode.closed_forms.balls.core import ball, certainly, either_root
from polhode.closed_forms.balls.frames import Latest, SolvedMotion
from polhode.closed_forms.balls.theta2 import Theta2, added
from polhode.closed_forms.kovalevskaya.jacobian import Jacobian, rates
from polhode.closed_forms.kovalevskaya.place import (
    KovalevskayaStart,
    SeparationState,
    branch_points,
    square_roots,
)
from polhode.common.values import cached_property
from polhode.numbers.exact import sign

PAIRS = ((0, 1), (0, 2), (1, 2))
_MOST_CHOICES = 4  # of which the union is taken

_I = acb(0, 1)

#: Values and derivatives along V.
Values: TypeAlias = Sequence[Pair]


class Quotients(NamedTuple):
    """The numbers before the theta functions, for one choice of signs."""

    over: Sequence[acb]  # g_j C_j
    p: Sequence[acb]  # f_j C_j
    r: Sequence[acb]
    G3: Sequence[acb]

    def products(self, values: Values) -> tuple[Sequence[acb], acb, acb]:
        """D times 1, p, q, r and G3; D' and (D r)'."""
        single, double = values[1:4], values[4:]
        q, r, G3 = _I * values[0][0], dot(self.r, double, 0), dot(self.G3, double, 0)
        row = dot(self.over, single, 0), dot(self.p, single, 0), q, r, G3
        return row, dot(self.over, single, 1), dot(self.r, double, 1)

    def state(self, H: arb, values: Values) -> list[acb]:
        """p, q, r, G1, G2, G3 of the theta functions at a place."""
        (D, *row), D1, r1 = self.products(values)
        over = 1 / D
        p, q, r, G3 = (x * over for x in row)
        return [p, q, r, H - p * p - q * q - r * r / 2, -(r1 - r * D1) * over, G3]

    def misses(self, start: Sequence[arb], values: Values) -> bool:
        """Whether the values at z0 prove that this is not the start; multiplied out, no 0/0."""
        (p, q, r, _, G2, G3), ((D, *row), D1, r1) = start, self.products(values)
        rests = [D * x - y for x, y in zip((p, q, r, G3), row, strict=True)]
        rests.append(D * G2 + r1 - r * D1)
        certainly(all(x.is_finite() for x in rests))
        return any(not x.contains(0) for x in rests)


def dot(row: Sequence[acb], values: Values, which: int) -> acb:
    """The combination of values (0) or of derivatives (1)."""
    total = acb(0)
    for x, value in zip(row, values, strict=True):
        total += x * value[which]
    return total


class ThetaState(SolvedMotion):
    """The state as a function of time, in the top's axes and units, at the precision in force."""

    def __init__(self, start: KovalevskayaStart) -> None:
        self.start, self.speed = start, start.speed_bound()
        self.jacobian = Jacobian(branch_points(start))
        self.H, self.m, self.b = ball(start.H), ball(start.m), ball(start.b)
        self.velocity = self.jacobian.reduced((acb(0), acb(1)))
        delta, etas = self.jacobian.delta, self.jacobian.characteristics
        characteristics = [delta, *(added(delta, etas[j]) for j in range(3))]
        characteristics += [added(delta, etas[j], etas[l]) for j, l in PAIRS]
        self._thetas = Theta2(self.jacobian.lattice.tau, characteristics)
        #: z at t = 0.
        self.z0 = self.jacobian.reduced(self._first_place())
        self.choices = self._fitting()
        self._state = Latest(self._state_at)

    @cached_property
    def weight(self) -> arb:
        """|G|."""
        return ball(self.start.a2).sqrt()

    def at(self, t: arb) -> list[arb]:
        """p, q, r, G1, G2, G3."""
        return self._state(t)

    def rates(self) -> Mapping[str, arb]:
        """The mean rates at which the separation variables go through their cycles.

        w and gamma repeat when both have made an even number of turns.
        """
        return dict(zip(("s1", "s2"), rates(self.jacobian.points), strict=True))

    def _state_at(self, t: arb) -> list[arb]:
        values = self.values_at(self.place(t)[0])
        first, *others = ([x.real for x in c.state(self.H, values)] for c in self.choices)
        for state in others:
            first = [x.union(y) for x, y in zip(first, state, strict=True)]
        return first

    def place(self, t: arb) -> tuple[Pair, tuple[int, int]]:
        """z of z0 + t V = z + 2(l + tau k), and k: all quotients have these periods."""
        z0, V = self.z0, self.velocity
        z, _, k = self.jacobian.lattice.reduced((z0[0] + t * V[0], z0[1] + t * V[1]), 2)
        return z, k

    def values_at(self, z: Pair) -> Values:
        """The theta functions, over one factor that no quotient has."""
        return self._thetas.at(z).along(self.velocity)

    def _first_place(self) -> Pair:
        """A(s1, w1) + A(s2, w2) at t = 0, which moves as u(0) + t (0, 1).

        Where q = 0, s1 is infinite and A of it 0.  Next to q = 0 the form loses some five digits
        for a decade of q; more bits pay for them.
        """
        image, state = self.jacobian.image, SeparationState(*(ball(x) for x in self.start.state))
        if sign(self.start.state.q) == 0:
            s, w = state.finite_point()
            return image(acb(s), acb(w))
        (R, R1), (T1, N1), q2 = state.polars(), state.rates(), state.q * state.q
        root = (R * R / 4 - q2 * R1).sqrt()
        larger = -(R / 2 + (root if R.mid() >= 0 else -root)) / 2  # q^2 s1, no difference
        first, second = (image(acb(s), acb(T1 * s - N1)) for s in (larger / q2, R1 / (4 * larger)))
        return first[0] + second[0], first[1] + second[1]

    def _fitting(self) -> list[Quotients]:
        """The choices that are not proven wrong."""
        e = self.jacobian.points[:3]
        f, g = zip(*(square_roots(x, self.H, self.m, self.b) for x in e), strict=True)
        c, K = self._constants()
        first = [ball(x) for x in (*self.start.omega, *self.start.G)]
        slopes = [(e[j] - e[j - 1]) * (e[j] - e[j - 2]) for j in range(3)]
        choices = []
        values = self.values_at(self.z0)
        for signs in product((1, -1), repeat=3):
            C = [s * x / d for s, x, d in zip(signs, c, slopes, strict=True)]
            mixed = [(j, l, C[j] * C[l] * k) for (j, l), k in zip(PAIRS, K, strict=True)]
            choice = Quotients(
                over=[x * y for x, y in zip(g, C, strict=True)],
                p=[x * y for x, y in zip(f, C, strict=True)],
                r=[-2 * _I * (f[j] * g[l] - f[l] * g[j]) * k for j, l, k in mixed],
                G3=[_I * (e[j] - e[l]) * g[j] * g[l] * k for j, l, k in mixed],
            )
            if not choice.misses(first, values):
                choices.append(choice)
        if not choices:
            raise ArithmeticError("no choice of signs has the start: a fault")
        certainly(len(choices) <= _MOST_CHOICES)
        return choices

    def _constants(self) -> tuple[list[acb], list[acb]]:
        """c_j up to signs, and K_jl from the place with the largest denominator."""
        e, by_key = self.jacobian.points, {}

        def at(j: int, n: int) -> Values:
            key = min(j, n), max(j, n)
            if key not in by_key:
                first, second = (self.jacobian.images[i] for i in key)
                by_key[key] = self.values_at(
                    self.jacobian.reduced((first[0] + second[0], first[1] + second[1]))
                )
            return by_key[key]

        c, K = [], []
        for j in range(3):
            l, n = (i for i in range(3) if i != j)
            values = at(l, n)
            ratio = values[0][0] / values[1 + j][0]
            c.append(either_root((e[l] - e[j]) * (e[n] - e[j]) * ratio * ratio))
        for i, (j, l) in enumerate(PAIRS):
            rows = [at(j, n) for n in range(5) if n not in (j, l)]
            row = max(rows, key=lambda v: _share(v, 4 + i))
            (a, da), (b, db) = row[1 + j], row[1 + l]
            K.append((da * b - a * db) / (row[0][0] * row[4 + i][0]))
        return c, K


def _share(values: Values, i: int) -> arb:
    """The size of the denominator of a K_jl, beside the largest value."""
    size = abs(values[0][0]).mid()
    for value, _ in values:
        size = size.max(abs(value).mid())
    return (abs(values[0][0]) * abs(values[i][0])).mid() / (size * size).mid()
