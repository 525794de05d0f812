"""The linear equation y' = i (a12/2) z conj(y) over one period of a spherical pendulum, in balls.

y and conj(y) go from 0 to t by a matrix M(t) of complex numbers with rows (U, conj V), (V, conj U),

    U' = i (a12/2) z V,    V' = -i (a12/2) conj(z) U,    |U|^2 - |V|^2 = 1.

Over the period t1 of u = g3, z turns: z(t + t1) = c^2 z(t) with |c| = 1.  With N = diag(conj c, c)
M(t1) therefore y(n t1 + s) = c^n [M(s) N^n (1, 1)]_1.  |tr N| > 2: the motion tends to a periodic
one; < 2: it has two frequencies (Nekrasov 1896 reduced it to such an equation).  No closed form of
N is known: M is a product of Taylor series about centres, from

    z' = -iPg,    g' = iuz,    u' = Im(conj(g) z),    P = a/2 = Mg |r0|/B.

*Their tails.*  Where |z| <= s0 and 2P|g|, 2P|u| <= s0^2 at the centre, the coefficients of z, Pg
and Pu are at most those of s = s0/(1 - s0 t/2) and s^2/2: s' = s^2/2 and (s^2/2)' = s^3/2 are what
the equations make of them.  Those of U and V, from 1 and 0, are then at most those of the m with
m' = (|a12|/2) s m, m = (1 - s0 t/2)^-|a12|, whose k-th is c_k (s0/2)^k with c_k = |a12| (|a12| + 1)
... (|a12| + k - 1)/k!.  With x = s0 |t|/2 the terms from the n-th on are below

    c_n x^n/(1 - r x),    r = max(1, (|a12| + n)/(n + 1)).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul
from typing import Any

from flint import acb, acb_mat, acb_poly, arb

from polhode.closed_forms.balls.core import TooFewBits, around, either_root, nearest_integer
from polhode.closed_forms.lagrange.motion import Nutating
from polhode.common.values import cached_property
from polhode.numbers.flint_context import ctx

_I = acb(0, 1)
_REACH = 1 / 6  # x at the ends of a series
_BEYOND = 1 + 2**-10  # how far past its ends it holds
_MIDDLE = arb(0.5)
_SPARE = 8  # bits of a tail below the precision
_ONE = acb_mat([[1, 0], [0, 1]])


@dataclass(frozen=True)
class Expansion:
    """M about a centre: series of U and V from there, their tails, and M up to there."""

    U: acb_poly
    V: acb_poly
    tail: acb
    before: acb_mat

    def at(self, x: arb) -> acb_mat:
        """M at a time from the centre, in units of half a step."""
        if not abs(x) < _BEYOND:
            raise TooFewBits
        U, V = self.U(x) + self.tail, self.V(x) + self.tail
        return acb_mat([[U, V.conjugate()], [V, U.conjugate()]]) * self.before


class PeriodMap:
    """y, from one period of the motion ``sphere``, whose P is ``a``/2.

    The series about (2k + 1) half a step, k of either sign, are made when a time needs them: from 0
    outwards, half a period to each side at most.
    """

    def __init__(self, sphere: Nutating, a: arb, a12: arb) -> None:
        self._sphere, self._P, self._pull = sphere, a / 2, a12 / 2
        self.period = 2 * sphere.elliptic.K / sphere.rate
        s0 = largest(sphere, a)
        self._half = (2 * _REACH / s0).mid()
        self._terms = math.ceil((ctx.prec + _SPARE) / -math.log2(_REACH))
        self._tail = tail(abs(a12), s0 * self._half / 2 * _BEYOND, self._terms)
        self._known: dict[int, Expansion] = {}

    @cached_property
    def _turn(self) -> acb:
        """c."""
        first, last = (self._start(t)[0] for t in (arb(0), self.period))
        turn = either_root(last / first)
        return turn / abs(turn)

    @cached_property
    def map(self) -> acb_mat:
        """N, from -t1/2 to t1/2: at both ends y is the same but for c."""
        ahead = acb_mat([[self._turn.conjugate(), 0], [0, self._turn]])
        half = self.period / 2
        return _inverse(self._matrix(-half)) * ahead * self._matrix(half)

    @property
    def trace(self) -> arb:
        """|tr N|."""
        return abs(2 * self.map[0, 0].real)

    def at(self, t: arb) -> acb:
        """y at a time."""
        n = nearest_integer(t / self.period)
        begin, turn = acb_mat([[1], [1]]), acb(1)
        if n:
            once, turn = (self.map if n > 0 else _inverse(self.map)), self._turn**n
            begin = once ** abs(n) * begin
        return turn * (self._matrix(t - n * self.period) * begin)[0, 0]

    def _matrix(self, t: arb) -> acb_mat:
        """M at a time within half a period from 0."""
        k = nearest_integer(t / (2 * self._half) - _MIDDLE)
        if k not in self._known:
            self._extend(k)
        return self._known[k].at(t / self._half - (2 * k + 1))

    def _extend(self, last: int) -> None:
        """Make the series up to the one of that number."""
        side = 1 if last >= 0 else -1
        begin = _ONE
        for k in range(0, last + 1) if side > 0 else range(-1, last - 1, -1):
            if k not in self._known:
                U, V = self._expanded((2 * k + 1) * self._half)
                back = _inverse(Expansion(U, V, self._tail, _ONE).at(arb(-side)))
                self._known[k] = Expansion(U, V, self._tail, back * begin)
            begin = self._known[k].at(arb(side))

    def _start(self, t: arb) -> tuple[acb, acb, arb]:
        """z, g and u."""
        p, q, _, g1, g2, u = self._sphere.at(t)
        return acb(p, q), acb(g1, g2), u

    def _expanded(self, centre: arb) -> tuple[acb_poly, acb_poly]:
        """U and V, from 1 and 0 at the centre, but for their tails; half a step is the unit."""
        z, g, u0 = self._start(centre)
        p, q, g1, g2, u = [z.real], [z.imag], [g.real], [g.imag], [u0]
        w, conjugate, U, V = [z], [z.conjugate()], [acb(1)], [acb(0)]
        for k in range(self._terms - 1):
            share = self._half / (k + 1)
            x, y = p[::-1], q[::-1]
            term = share * self._pull * _I * _product(V, w[::-1])
            V.append(share * self._pull * -_I * _product(U, conjugate[::-1]))
            U.append(term)
            p.append(share * self._P * g2[k])
            q.append(-share * self._P * g1[k])
            lift = share * (_product(g1, y) - _product(g2, x))
            g1.append(-share * _product(u, y))
            g2.append(share * _product(u, x))
            u.append(lift)
            w.append(acb(p[-1], q[-1]))
            conjugate.append(acb(p[-1], -q[-1]))
        return acb_poly(U), acb_poly(V)


def largest(sphere: Nutating, a: arb) -> arb:
    """An s0 for every centre: |z| <= speed, and |g|, |u| <= 1."""
    return sphere.speed.max(a.sqrt())


def tail(a12: arb, x: arb, n: int) -> acb:
    """A ball that holds what the terms of U, or of V, from the n-th on add up to."""
    ratio = x * ((a12 + n) / (n + 1)).max(arb(1))
    if not ratio < 1:
        raise TooFewBits
    term = arb(1)
    for k in range(n):
        term *= x * (a12 + k) / (k + 1)
    return around(term / (1 - ratio))


def _product(a: Sequence[Any], back: Sequence[Any]) -> Any:
    """A coefficient of a product, the second factor in reverse order."""
    return sum(map(mul, a, back))


def _inverse(m: acb_mat) -> acb_mat:
    """Of a matrix with the rows (U, conj V), (V, conj U) and the determinant 1."""
    return acb_mat([[m[1, 1], -m[0, 1]], [-m[1, 0], m[0, 0]]])
