"""Theta functions of genus two with their first derivatives, in balls.

With N = 2n + a, a and b in {0, 1}^2,

    th[a, b](z | tau) = sum over n of exp(pi i N tau N/4 + pi i N.(z + b/2)),

and, for whole l and k,

    th[a, b](z + l + tau k) = (-1)^(a.l + b.k) exp(-pi i k tau k - 2 pi i k.z) th[a, b](z)

(Mumford, Tata Lectures on Theta I, II.1).  Values and derivatives are products u M v of a matrix
M that only tau decides and of powers of exp(pi i z1), exp(pi i z2).

What is left out: with c real and Im z = Y c, Y = Im tau, a term is exp(pi c Y c) times
exp(-pi (n + c) Y (n + c)) in modulus, and (n + c) Y (n + c) >= share (y11 v1^2 + y22 v2^2) with
v = n + c, share = 1 - |y12|/sqrt(y11 y22): a product of one-dimensional sums.  z is reduced to
|c_i| <= 1/2 first, so these are the same for all z.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import product
from typing import NamedTuple, TypeAlias

from flint import acb, acb_mat, arb

from polhode.closed_forms.balls.clocks import Pair
from polhode.closed_forms.balls.core import TooFewBits, around, nearest_integer, powers_of
from polhode.numbers.flint_context import ctx

#: a1, a2, b1, b2.
Characteristic: TypeAlias = tuple[int, int, int, int]

#: tau11, tau12, tau22.
SymmetricMatrix: TypeAlias = tuple[acb, acb, acb]

#: A value, its derivatives by z1 and by z2.
Jet: TypeAlias = tuple[acb, acb, acb]

#: All of them, in the order of their numbers.
CHARACTERISTICS: tuple[Characteristic, ...] = tuple(product((0, 1), repeat=4))  # type: ignore[arg-type]

_REACH = arb(0.5) + arb(2) ** -10  # |c_i| of a reduced z; the rest is for radii
_SPARE = 4  # nats beyond the bits in force


def added(*characteristics: Characteristic) -> Characteristic:
    """The sum modulo 2."""
    a, b, c, d = (sum(column) % 2 for column in zip(*characteristics, strict=True))
    return a, b, c, d


def is_odd(characteristic: Characteristic) -> bool:
    """Whether the theta function is an odd one."""
    a1, a2, b1, b2 = characteristic
    return (a1 * b1 + a2 * b2) % 2 == 1


class Lattice(NamedTuple):
    """The lattice of all l + tau k, l and k whole."""

    tau: SymmetricMatrix

    def coordinates(self, z: Pair) -> tuple[tuple[arb, arb], tuple[arb, arb]]:
        """x and y, real, of z = x + tau y."""
        t11, t12, t22 = self.tau
        det = t11.imag * t22.imag - t12.imag * t12.imag
        y1 = (t22.imag * z[0].imag - t12.imag * z[1].imag) / det
        y2 = (t11.imag * z[1].imag - t12.imag * z[0].imag) / det
        x = (
            z[0].real - t11.real * y1 - t12.real * y2,
            z[1].real - t12.real * y1 - t22.real * y2,
        )
        return x, (y1, y2)

    def times(self, k: Sequence[int]) -> Pair:
        """tau k."""
        t11, t12, t22 = self.tau
        return t11 * k[0] + t12 * k[1], t12 * k[0] + t22 * k[1]

    def reduced(self, z: Pair, step: int = 1) -> tuple[Pair, tuple[int, int], tuple[int, int]]:
        """z - step (l + tau k) next to 0, with l and k."""
        x, y = self.coordinates(z)
        l = nearest_integer(x[0] / step), nearest_integer(x[1] / step)
        k = nearest_integer(y[0] / step), nearest_integer(y[1] / step)
        if not any((*l, *k)):
            return z, l, k
        along = self.times(k)
        return (z[0] - step * (l[0] + along[0]), z[1] - step * (l[1] + along[1])), l, k


class Jets(NamedTuple):
    """Theta functions at one z: exp(``log``) times ``values`` and derivatives."""

    values: list[Jet]
    log: acb

    def along(self, v: Pair) -> list[Pair]:
        """Values and derivatives along a direction, over exp(log)."""
        return [(value, d1 * v[0] + d2 * v[1]) for value, d1, d2 in self.values]


class Theta2:
    """The theta functions of some characteristics, for one tau, at the precision in force.

    tau ought to be next to Siegel-reduced, which keeps the sums short.  Raises TooFewBits where
    its imaginary part is not proven positive.
    """

    def __init__(self, tau: SymmetricMatrix, characteristics: Iterable[Characteristic]) -> None:
        self.lattice = Lattice(tau)
        self._wanted = list(characteristics)
        y11, y12, y22 = (t.imag for t in tau)
        if not (y11 > 0 and y11 * y22 > y12 * y12):
            raise TooFewBits("the imaginary part of the period matrix")
        share = 1 - abs(y12) / (y11 * y22).sqrt()
        self._decay = [arb.pi() * share * y for y in (y11, y22)]
        nats = ctx.prec * math.log(2) + _SPARE
        self._sizes = [math.ceil(math.sqrt(nats / float(d.mid())) + 0.01) for d in self._decay]
        self._ranges = [[_halves(size, a) for a in (0, 1)] for size in self._sizes]
        self._tables = self._made()
        self._errors = self._left_out()

    def _made(self) -> dict[tuple[int, int], tuple[acb_mat, acb_mat]]:
        """exp(pi i N tau N/4) for the a's needed: of even (N1 - a1)/2, and of odd."""
        t11, t12, t22 = self.lattice.tau
        turn = acb(0, arb.pi() / 4)
        most = [2 * size for size in self._sizes]
        squares = [
            [(turn * t * (n * n)).exp() for n in range(m + 1)]
            for t, m in zip((t11, t22), most, strict=True)
        ]
        crossed = _powers((2 * turn * t12).exp(), most[0] * most[1])
        tables = {}
        for a1, a2 in {(c[0], c[1]) for c in self._wanted}:
            columns = [n for half in self._ranges[1][a2] for n in half]
            even, odd = (
                acb_mat(
                    [
                        [squares[0][abs(m)] * squares[1][abs(n)] * crossed[m * n] for n in columns]
                        for m in rows
                    ]
                )
                for rows in self._ranges[0][a1]
            )
            tables[a1, a2] = even, odd
        return tables

    def at(self, z: Pair) -> Jets:
        """The functions asked for, with both derivatives."""
        rest, l, k = self.lattice.reduced(z)
        _, c = self.lattice.coordinates(rest)
        if not all(abs(x) <= _REACH for x in c):
            raise TooFewBits("a place on the Jacobian")
        rows = [self._rows(a, rest[0]) for a in (0, 1)]
        columns = [self._columns(a, rest[1]) for a in (0, 1)]
        parts = {}
        for (a1, a2), tables in self._tables.items():
            parts[a1, a2] = [
                row * table * columns[a2] for row, table in zip(rows[a1], tables, strict=True)
            ]
        i_pi = acb(0, arb.pi())
        along = self.lattice.times(k)
        shift = -2 * i_pi * k[0], -2 * i_pi * k[1]
        values = []
        for a1, a2, b1, b2 in self._wanted:
            even, odd = parts[a1, a2]
            side = -1 if (a1 * l[0] + a2 * l[1] + b1 * k[0] + b2 * k[1]) % 2 else 1
            turns = (a1 * b1 + a2 * b2) % 4
            value, d1, d2 = (
                _rotated(side * _mixed(even, odd, (b1, b2), i, j), turns)
                for i, j in ((0, 0), (1, 0), (0, 1))
            )
            value += self._errors[0]
            d1, d2 = i_pi * d1 + self._errors[1], i_pi * d2 + self._errors[2]
            values.append((value, d1 + shift[0] * value, d2 + shift[1] * value))
        log = -i_pi * (k[0] * (along[0] + 2 * rest[0]) + k[1] * (along[1] + 2 * rest[1]))
        return Jets(values, log)

    def _rows(self, a: int, z: acb) -> tuple[acb_mat, acb_mat]:
        """exp(pi i N z) and N times it, for even (N - a)/2 and for odd."""
        wave = _powers((acb(0, arb.pi()) * z).exp(), _top(self._ranges[0][a]))
        even, odd = (
            acb_mat([[wave[n] for n in half], [n * wave[n] for n in half]])
            for half in self._ranges[0][a]
        )
        return even, odd

    def _columns(self, a: int, z: acb) -> acb_mat:
        """The same as columns: two of even (N - a)/2, two of odd, 0 elsewhere."""
        even, odd = self._ranges[1][a]
        wave = _powers((acb(0, arb.pi()) * z).exp(), _top((even, odd)))
        nil = acb(0)
        rows = [[wave[n], n * wave[n], nil, nil] for n in even]
        rows += [[nil, nil, wave[n], n * wave[n]] for n in odd]
        return acb_mat(rows)

    def _left_out(self) -> tuple[acb, acb, acb]:
        """Balls around 0 of what the sums leave out: of a value and of both derivatives."""
        y11, y12, y22 = (t.imag for t in self.lattice.tau)
        lift = (arb.pi() * _REACH * _REACH * (y11 + 2 * abs(y12) + y22)).exp()
        tails, slopes, wholes, steep = [], [], [], []
        two_pi = 2 * arb.pi()
        for d, size in zip(self._decay, self._sizes, strict=True):
            # |N/2| >= size + 1/2 is left out; (r + j)^2 >= r^2 + 2 r j.
            r = size + arb(0.5) - _REACH
            ratio = (-2 * d * r).exp()
            first = 2 * (-d * r * r).exp() / (1 - ratio)
            tails.append(first)
            # |n| <= (r + reach)(1 + j), for r + reach >= 1.
            slopes.append(two_pi * (r + _REACH) * first / (1 - ratio))
            # A sum of unit steps of what rises and falls once: at most the largest + the integral.
            whole = 1 + (arb.pi() / d).sqrt()
            wholes.append(whole)
            steep.append(two_pi * (_REACH * whole + 2 / (2 * arb(1).exp() * d).sqrt() + 1 / d))
        radii = (
            tails[0] * wholes[1] + tails[1] * wholes[0],
            slopes[0] * wholes[1] + tails[1] * steep[0],
            slopes[1] * wholes[0] + tails[0] * steep[1],
        )
        value, d1, d2 = (around(lift * x) for x in radii)
        return value, d1, d2


def _halves(size: int, a: int) -> tuple[list[int], list[int]]:
    """N = 2n + a of |N/2| <= size, by even and odd n."""
    numbers = range(-2 * size + a, 2 * size + 1 - a, 2)
    return [n for n in numbers if (n - a) // 2 % 2 == 0], [n for n in numbers if (n - a) // 2 % 2]


def _top(halves: tuple[list[int], list[int]]) -> int:
    return max(abs(n) for half in halves for n in half)


def _powers(base: acb, most: int) -> dict[int, acb]:
    """base^n for |n| <= most."""
    up, down = powers_of(base, most + 1), powers_of(1 / base, most + 1)
    return {-n: x for n, x in enumerate(down)} | dict(enumerate(up))


def _mixed(even: acb_mat, odd: acb_mat, b: tuple[int, int], i: int, j: int) -> acb:
    """The sum with the signs (-1)^(n.b); rows i and columns j are derivatives where they are 1."""
    first = even[i, j] + (-even[i, j + 2] if b[1] else even[i, j + 2])
    second = odd[i, j] + (-odd[i, j + 2] if b[1] else odd[i, j + 2])
    return first - second if b[0] else first + second


def _rotated(x: acb, turns: int) -> acb:
    """i^turns x."""
    if turns % 2:
        x = acb(-x.imag, x.real)
    return -x if turns // 2 else x
