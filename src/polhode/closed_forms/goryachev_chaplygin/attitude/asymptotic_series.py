"""chi where v tends to a double root: a double series beyond some place, Taylor's pieces before it.

In the time sigma, dsigma = dt/(u + v), u moves periodically and v - w dies away exponentially:

    dchi/dsigma = F(al, q),    al = sigma/S_0 + const,    q = exp(-2Y),    Y = g_w sigma/4 + const,

F changes its sign with a turn of al and is a power series in q (v before its turning point, Y < 0,
is v after it with al reversed).  So the integral is, term by term,

    chi = const + Re sum_{k, n >= 0} 2 f_kn q^k e^{i(n + 1/2) al}/(i(n + 1/2)/S_0 - k g_w/2).

v - w = de is the solution of (q d/dq)^2 de = a polynomial, for (q d/dq de)^2 = de^2 W(de), W of
degree 4.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from polhode.closed_forms.functions.fourier import TooManyTerms, fixed, floating, transform
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import Oscillating
from polhode.closed_forms.goryachev_chaplygin.double_root import Tending
from polhode.closed_forms.goryachev_chaplygin.torus_quadrature import Torus
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Objects
from polhode.numbers.scalars import Scalar

_GUARD = 24  # bits of the integers beyond the precision in force
_SHARE = 0.06  # of the radius of convergence in q that is used
_PROBE = 40  # terms from which the radius is told
_TRIALS = 8
_LEAST = 64  # samples of a turn of al tried first
_MOST = 1 << 12
_SILENT = 1 << 8  # what is less is rounding

Places = Callable[[Scalar], Scalar]


@dataclass(frozen=True)
class Approach:
    """chi but for a constant where Y >= ``edge``; the terms hold q^k at Y = ``edge``."""

    cosines: tuple[Objects, ...]  # of k: an array over n
    sines: tuple[Objects, ...]
    edge: Scalar
    bits: int

    def at(self, al: Scalar, Y: Scalar) -> Scalar:
        """At al and Y >= edge."""
        share = mpmath.exp(2 * (self.edge - Y))
        q = fixed(share, self.bits)
        used = 1
        if q:
            used = min(len(self.cosines), 1 + int(self.bits / max(1e-9, -mpmath.log(share, 2))))
        c, s = mpmath.cos_sin(al / 2)
        twice = fixed((c - s) * (c + s), self.bits) * 2
        total = mpf(0)
        for rows, side, factor in ((self.cosines, -1, c), (self.sines, 1, s)):
            first, second = 0, 0
            for term in reversed(_horner(rows[:used], q, self.bits)):
                first, second = term + ((twice * first) >> self.bits) - second, first
            total += factor * floating(first + side * second, self.bits)
        return total


def _horner(rows: Sequence[Objects], q: int, bits: int) -> Objects:
    """The sum of the rows, each longer than or as long as the next, by Horner's rule in q."""
    total = rows[-1]
    for row in reversed(rows[:-1]):
        longer = row.copy()
        longer[: len(total)] += (total * q) >> bits
        total = longer
    return total


def approach(torus: Torus, v: Tending, a: Scalar, place: Places) -> Approach:
    """The series at the precision in force; ``place``: the phase of u where S/S_0 is given.

    Raises TooManyTerms where either sum is too long.
    """
    assert isinstance(torus.u, Oscillating)
    bits = mpmath.prec + _GUARD
    ends = torus.u.variable.low, torus.u.variable.middle, torus.u.variable.high
    q = mpf(_SHARE) * _radius(v, ends)
    for _ in range(_TRIALS):
        powers = _powers(v, q, int(bits / -mpmath.log(_SHARE, 2)) + 6)
        across = _halves(v, powers, a)
        if max(abs(row[-1]) for row in (powers[0], *across)) < mpmath.ldexp(1, -bits):
            rows = _rows(torus.u, ([v.w, *powers[0][1:]], *across), place, bits)
            if rows is not None:
                slope = 1 / torus.u.S.mean, v.gw / 2
                return Approach(*_integrals(rows, slope, bits), -mpmath.log(q) / 2, bits)
        q /= 4
    raise TooManyTerms("too near a degenerate motion: v comes near its limit too late")


def _radius(v: Tending, ends: Sequence[Scalar]) -> Scalar:
    """About the radius of convergence in q of v and of 1/(u + v), u at ``ends``."""
    unit = _first(v)
    (de, *_) = _powers(v, 1 / unit, _PROBE)
    rows = [de[1:], *(_inverse([z + v.w + de[0], *de[1:]]) for z in ends)]
    size = max(
        mpmath.root(abs(row[k] / row[0]), k) for row in rows for k in range(_PROBE // 2, len(row))
    )
    return 1 / (unit * size)


def _first(v: Tending) -> Scalar:
    """4 exp(2(Y - y)) far away: v - w is (ve - w) times this q, nearly."""
    return 4 * mpmath.exp(v.gw / 2 * v.S.at(mpf(0), mpf(1)))


def _powers(v: Tending, q: Scalar, count: int) -> list[list[Scalar]]:
    """The coefficients of de, de^2, ... de^5 by powers of q, each times its power of ``q``."""
    rule = [0, *(w * (1 + mpf(j) / 2) for j, w in enumerate(_quartic(v)))]
    rows: list[list[Any]] = [
        [mpf(0), _first(v) * q * (v.ve - v.w)],
        *([mpf(0)] * 2 for _ in "2345"),
    ]
    for k in range(2, count + 1):
        for n in range(1, 5):
            rows[n].append(mpmath.fdot(zip(rows[0][1:], rows[n - 1][k - 1 : 0 : -1], strict=True)))
        more = sum(x * row[k] for x, row in zip(rule[2:], rows[1:], strict=True))
        rows[0].append(more / (k * k - 1))
    return rows


def _quartic(v: Tending) -> list[Scalar]:
    """W(de) = (1 - de/(ve - w)) L(w + de)/L(w), L as in :mod:`.tending`."""
    total = v.ve + v.vo
    found = [mpf(1)]
    for root in (v.ve - v.w, v.vo - v.w, -3 * v.w, -total - v.w):
        found = [x - y / root for x, y in zip([*found, 0], [0, *found], strict=True)]
    return found


def _halves(
    v: Tending, powers: Sequence[Sequence[Scalar]], a: Scalar
) -> tuple[list[Scalar], list[Scalar]]:
    """sqrt(v) sin(et/2) and sqrt(v) cos(et/2) after the turning point, as series in q.

    They are k sqrt(dl k (vo - v)(v + v1 + v2)(1 - de/(ve - w))/4a) and
    dl de/(ve - w) sqrt((v + 2w)/4a).
    """
    dl, E = abs(v.ve - v.w), v.ve - v.w
    cubic = [dl * v.k * (v.vo - v.w) * (v.w + v.ve + v.vo) / (4 * a)]
    for root in (E, v.vo - v.w, -(v.w + v.ve + v.vo)):
        cubic = [x - y / root for x, y in zip([*cubic, 0], [0, *cubic], strict=True)]
    count = len(powers[0])
    square = [
        sum(c * row[k] for c, row in zip(cubic[1:], powers, strict=False)) for k in range(count)
    ]
    sine = _root([cubic[0], *square[1:]])
    root = _root([3 * v.w / (4 * a), *(x / (4 * a) for x in powers[0][1:])])
    return [v.k * x for x in sine], [dl / E * x for x in _product(powers[0], root)]


def _product(one: Sequence[Scalar], other: Sequence[Scalar]) -> list[Scalar]:
    return [mpmath.fdot(zip(one[: k + 1], other[k::-1], strict=True)) for k in range(len(one))]


def _root(row: Sequence[Scalar]) -> list[Scalar]:
    """The square root of a power series."""
    found = [mpmath.sqrt(row[0])]
    for k in range(1, len(row)):
        inner = mpmath.fdot(zip(found[1:], found[:0:-1], strict=True))
        found.append((row[k] - inner) / (2 * found[0]))
    return found


def _inverse(row: Sequence[Scalar]) -> list[Scalar]:
    """The reciprocal of a power series."""
    found = [1 / row[0]]
    for k in range(1, len(row)):
        found.append(-found[0] * mpmath.fdot(zip(row[1 : k + 1], found[::-1], strict=True)))
    return found


def _rows(
    u: Oscillating, series: Sequence[Sequence[Scalar]], place: Places, bits: int
) -> tuple[Objects, Objects] | None:
    """2 f_kn as arrays of integers, real and imaginary parts, k along the second axis.

    None where the powers of q do not end; TooManyTerms where the waves do not.
    """
    known: dict[Any, tuple[Any, Any, Any]] = {}
    count, small = _LEAST, 1 << _GUARD
    while count <= _MOST:
        table = [_of_u(u, mpf(2 * j) / count, place, known) for j in range(count)]
        # The limiting motion, k = 0, tells whether the samples are enough, nearly always.
        for depth in (1, len(series[0])):
            F = _flow(table, [row[:depth] for row in series], bits)
            re, im = _waves(F, bits)
            last = [part[len(part) - len(part) // 8 - 1 :] for part in (re, im)]
            enough = max(abs(int(x)) for part in last for x in part.flat) < small
            if not enough:
                break
        if enough:
            return (re, im) if max(abs(int(x)) for x in F[-1]) < small else None
        count *= 2
    raise TooManyTerms(f"too near a degenerate motion: a series of {_MOST} samples is too short")


def _waves(F: Objects, bits: int) -> tuple[Objects, Objects]:
    """2 f_n, n along the first axis, of the functions F with al along their second axis."""
    count = F.shape[1]
    turns = [mpf(j) / count for j in range(count)]  # e^{-i al/2} F has the period of al
    c = np.array([fixed(mpmath.cospi(x), bits) for x in turns], dtype=object)
    s = np.array([fixed(-mpmath.sinpi(x), bits) for x in turns], dtype=object)
    re, im = transform(((F * c) >> bits).T, ((F * s) >> bits).T, bits)
    half = count // 2
    return re[:half] // half, im[:half] // half


def _of_u(
    u: Oscillating, al: Scalar, place: Places, known: dict[Any, Any]
) -> tuple[Scalar, Scalar, Scalar]:
    """u, sqrt(u) sin(xi/2) and sqrt(u) cos(xi/2) at al in [0, 2) times pi; even and odd ones."""
    if al > 1:
        z, sine, cosine = _of_u(u, 2 - al, place, known)
        return z, -sine, cosine
    if al not in known:
        point = u.at(place(mpmath.pi * al), MP)
        root = mpmath.sqrt(point.z)
        known[al] = point.z, root * point.sine, root * point.cosine
    z, sine, cosine = known[al]
    return z, sine, cosine


def _flow(
    table: Sequence[Sequence[Scalar]], series: Sequence[Sequence[Scalar]], bits: int
) -> Objects:
    """F/2a by powers of q (first axis) and al: (A sqrt(u)cos - B sqrt(u)sin)/(u + w + de)."""
    base, sine, cosine = (
        np.array([fixed(x, bits) for x in row], dtype=object) for row in zip(*table, strict=True)
    )
    v, A, B = (np.array([fixed(x, bits) for x in row], dtype=object) for row in series)
    base = base + v[0]
    found = np.zeros((len(v), len(base)), dtype=object)
    for k in range(len(v)):
        above = A[k] * cosine - B[k] * sine
        if k:
            above = above - (v[k:0:-1, None] * found[:k]).sum(axis=0)
        found[k] = above // base
    return found


def _integrals(
    rows: tuple[Objects, Objects], slope: tuple[Scalar, Scalar], bits: int
) -> tuple[tuple[Objects, ...], tuple[Objects, ...]]:
    """The coefficients of q^k cos(n + 1/2)al and q^k sin(n + 1/2)al, trailing zeros left out."""
    re, im = rows
    length = re.shape[1]
    quick = fixed(slope[0] / 2, bits)
    slow = fixed(slope[1], bits)
    cosines, sines, width = [], [], 1
    for k in range(length - 1, -1, -1):
        loud = np.nonzero(abs(re[:, k]) + abs(im[:, k]) > _SILENT)[0]
        width = max(width, int(loud[-1]) + 1 if len(loud) else 1)
        x, y = re[:width, k], im[:width, k]
        odd = np.array([(2 * n + 1) * quick for n in range(width)], dtype=object)
        size = odd * odd + (k * slow) ** 2
        # (x + i y)/(i odd - k slow) = (x + i y)(-k slow - i odd)/size
        cosines.append(((y * odd - x * (k * slow)) << bits) // size)
        sines.append(((x * odd + y * (k * slow)) << bits) // size)
    return tuple(reversed(cosines)), tuple(reversed(sines))
