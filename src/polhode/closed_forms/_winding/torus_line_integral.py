"""The integral of a smooth function on a torus along a straight line: two frequencies.

W(al, be) on the torus, al' = rate_x, be' = rate_y: the sum of c_jk exp(i((j + h)al + (k + g)be)),
h and g each 0 or 1/2, has the integral

    sum c_jk (exp(i phase_jk(t)) - exp(i phase_jk(0)))/(i Om_jk),
    Om_jk = (j + h) rate_x + (k + g) rate_y.

Where Om_jk is small the quotient is t sinc(Om_jk t/2) times the middle phase: resonances cost
nothing.  Coefficients come from a two-dimensional fast transform on integers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from polhode.closed_forms.functions.fourier import TooManyTerms, fixed, floating, transform
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Objects
from polhode.numbers.scalars import Scalar

_GUARD = 40
_FIRST = 32
_MOST = 1 << 17  # samples of the torus
_SLOW = 12  # a combination of the rates below 2^-_SLOW of them is slow

#: Values on the grid al_j = 2 pi j/n, be_k = 2 pi k/m, in units of 2^-bits.
Grid = Callable[[int, int, int], Scalar]


@dataclass(frozen=True)
class Slow:
    """A coefficient 2 c with its phase numbers, whose phase goes slowly."""

    j: Scalar
    k: Scalar
    re: Scalar
    im: Scalar
    rate: Scalar


@dataclass(frozen=True)
class DoubleSeries:
    """The integral along the line, as a function of the phases and the time."""

    shift: tuple[Fraction, Fraction]  # h, g
    rows: tuple[
        tuple[int, int, Objects, Objects], ...
    ]  # j, first k, real and imaginary parts of 2 c/(i Om)
    slow: tuple[Slow, ...]
    bits: int

    def at(self, al: Scalar, be: Scalar) -> Scalar:
        """The part that is a function on the torus, up to a constant."""
        if not self.rows:
            return mpf(0)
        bits = self.bits
        first, last = min(k for _, k, *_ in self.rows), max(k + len(r) for _, k, r, _ in self.rows)
        turn_re, turn_im = _powers(be, first, last, self.shift[1], bits)
        total = 0
        lead = _powers(al, 0, self.rows[-1][0] + 1, self.shift[0], bits)
        for j, k, re, im in self.rows:
            part = slice(k - first, k - first + len(re))
            c, s = turn_re[part], turn_im[part]
            x = (int(np.dot(re, c)) - int(np.dot(im, s))) >> bits
            y = (int(np.dot(re, s)) + int(np.dot(im, c))) >> bits
            total += (x * int(lead[0][j]) - y * int(lead[1][j])) >> bits
        return floating(total, bits)

    def slowly(self, start: tuple[Scalar, Scalar], t: Scalar) -> Scalar:
        """The part of the slow combinations, from time 0 to t; ``start``: the phases at time 0."""
        total = mpf(0)
        for term in self.slow:
            half = term.rate * t / 2
            c, s = mpmath.cos_sin(term.j * start[0] + term.k * start[1] + half)
            total += t * mpmath.sinc(half) * (term.re * c - term.im * s)
        return total


def _powers(
    angle: Scalar, first: int, last: int, shift: Fraction, bits: int
) -> tuple[Objects, Objects]:
    """cos and sin of (k + shift) angle for first <= k < last, as integers."""
    begin = mpmath.cos_sin(angle * (first + mpf(shift.numerator) / shift.denominator))
    c, s = (fixed(x, bits) for x in mpmath.cos_sin(angle))
    x, y = (fixed(z, bits) for z in begin)
    re, im = [], []
    for _ in range(first, last):
        re.append(x)
        im.append(y)
        x, y = (x * c - y * s) >> bits, (x * s + y * c) >> bits
    return np.array(re, dtype=object), np.array(im, dtype=object)


def plane(
    grid: Grid, rates: tuple[Scalar, Scalar], shift: tuple[Fraction, Fraction], most: int = _MOST
) -> DoubleSeries:
    """The series for a real function whose grids ``grid(n, m, bits)`` gives.

    Raises TooManyTerms where ``most`` samples of the torus are too few.
    """
    prec = mpmath.prec
    n = m = _FIRST
    while True:
        bits = prec + _GUARD + (n * m).bit_length()
        re, im = _coefficients(grid(n, m, bits), n, m, shift, bits)
        size = abs(re) + abs(im)
        limit = max(int(size.max()) >> (prec - 8), 1 << (bits - prec))
        worst_x = int(size[n // 2 - n // 16 - 1 : n // 2 + n // 16 + 1].max())
        worst_y = int(size[:, m // 2 - m // 16 - 1 : m // 2 + m // 16 + 1].max())
        if max(worst_x, worst_y) <= limit:
            return _gathered(re, im, rates, shift, bits)
        if worst_x > limit:
            n *= 2
        if worst_y > limit:
            m *= 2
        if n * m > most:
            raise TooManyTerms("a double Fourier series with too many terms")


def _coefficients(
    values: Objects, n: int, m: int, shift: tuple[Fraction, Fraction], bits: int
) -> tuple[Objects, Objects]:
    """c_jk as integers: j and k as the fast transform orders them."""
    re, im = values, 0 * values
    for axis, (count, part) in enumerate(zip((n, m), shift, strict=True)):
        if part:
            turns = [
                mpf(2 * i) / count * mpf(part.numerator) / part.denominator for i in range(count)
            ]
            shape = (count, 1) if axis == 0 else (1, count)
            c = np.array([fixed(mpmath.cospi(x), bits) for x in turns], dtype=object).reshape(shape)
            s = np.array([fixed(-mpmath.sinpi(x), bits) for x in turns], dtype=object).reshape(
                shape
            )
            re, im = (re * c - im * s) >> bits, (re * s + im * c) >> bits
    re, im = transform(re, im, bits)
    re, im = transform(np.ascontiguousarray(re.T), np.ascontiguousarray(im.T), bits)
    return re.T // (n * m), im.T // (n * m)


def _gathered(
    re: Objects,
    im: Objects,
    rates: tuple[Scalar, Scalar],
    shift: tuple[Fraction, Fraction],
    bits: int,
) -> DoubleSeries:
    """The half of the coefficients that a real function needs, divided by i Om."""
    n, m = re.shape
    h, g = (mpf(x.numerator) / x.denominator for x in shift)
    prec = mpmath.prec
    small = 1 << (bits - prec - 12)
    fast = max(abs(rates[0]), abs(rates[1]))
    rows, slow = [], []
    for j in range(n // 2):
        found: dict[int, tuple[int, int]] = {}
        for k in range(-(m // 2), m // 2):
            x, y = 2 * int(re[j, k % m]), 2 * int(im[j, k % m])
            if max(abs(x), abs(y)) < small:
                continue
            rate = (j + h) * rates[0] + (k + g) * rates[1]
            if not shift[0] and j == 0:  # both signs of k are there: each counts once
                x, y = x // 2, y // 2
            if abs(rate) < mpmath.ldexp(fast, -_SLOW):
                slow.append(Slow(j + h, k + g, floating(x, bits), floating(y, bits), rate))
                continue
            over = fixed(1 / rate, bits)
            found[k] = (y * over) >> bits, (-x * over) >> bits
        if found:
            first, last = min(found), max(found) + 1
            parts = [found.get(k, (0, 0)) for k in range(first, last)]
            real, imaginary = (np.array([p[i] for p in parts], dtype=object) for i in (0, 1))
            rows.append((j, first, real, imaginary))
    return DoubleSeries(shift, tuple(rows), tuple(slow), bits)
