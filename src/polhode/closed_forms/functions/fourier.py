"""Fourier series of smooth periodic functions, to any number of digits.

The samples of an analytic periodic function give its coefficients by trapezoid sums with an error
that falls geometrically (Trefethen and Weideman, SIAM Review 56 (2014) 385).  Transforms are fast
(radix 2, Cooley and Tukey 1965) and run on integers: a number x stands for round(x 2^bits), kept in
numpy's arrays of Python integers.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import libmp

from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Objects
from polhode.numbers.scalars import Scalar

_GUARD = 32  # bits of the integers beyond the precision in force
_LEAST = 16  # samples tried first
_MOST = 1 << 14  # samples of one turn


class TooManyTerms(ArithmeticError):
    """A series that does not end within the terms allowed."""


def transform(real: Objects, imaginary: Objects, bits: int) -> tuple[Objects, Objects]:
    """The sums over j of x_j exp(-2 pi i j k/N) along the first axis, N a power of two.

    Real and imaginary parts are arrays of integers in units of 2^-bits; so are the answers.
    """
    count, rest = real.shape[0], real.shape[1:]
    re, im = real.reshape(1, count, *rest), imaginary.reshape(1, count, *rest)
    size = 1
    while size < count:
        half = re.shape[1] // 2
        turns = [mpf(k) / size for k in range(size)]
        shape = (size,) + (1,) * (re.ndim - 1)
        c = np.array([fixed(mpmath.cospi(x), bits) for x in turns], dtype=object).reshape(shape)
        s = np.array([fixed(-mpmath.sinpi(x), bits) for x in turns], dtype=object).reshape(shape)
        odd_re, odd_im = re[:, half:], im[:, half:]
        turned_re = (c * odd_re - s * odd_im) >> bits
        turned_im = (c * odd_im + s * odd_re) >> bits
        re, im = (
            np.concatenate([even[:, :half] + turned, even[:, :half] - turned])
            for even, turned in ((re, turned_re), (im, turned_im))
        )
        size *= 2
    return re.reshape(count, *rest), im.reshape(count, *rest)


def fixed(x: Scalar, bits: int) -> int:
    """x in units of 2^-bits, to the nearest one."""
    return int(libmp.to_fixed(x._mpf_, bits)) if x else 0


def floating(n: int, bits: int) -> Scalar:
    """n units of 2^-bits as a number at the precision in force."""
    return mpmath.make_mpf(libmp.from_man_exp(n, -bits, mpmath.prec, "n"))


@dataclass(frozen=True)
class Cosines:
    """The bounded part of an integral: the sum over k >= 1 of a_k sin(k x)/k, and the mean a_0.

    F(x) = a_0 + sum a_k cos(k x) has the integral a_0 x + :meth:`bounded` from 0 to x.
    """

    mean: Scalar
    terms: tuple[int, ...]  # a_k/(k scale), k = 1, 2, ...
    scale: Scalar
    bits: int

    def bounded(self, x: Scalar) -> Scalar:
        """The sum of a_k sin(k x)/k (Clenshaw 1955)."""
        cos, sin = mpmath.cos_sin(x)
        twice = fixed(cos, self.bits) * 2
        first, second = 0, 0
        for term in reversed(self.terms):
            first, second = term + ((twice * first) >> self.bits) - second, first
        return self.scale * sin * floating(first, self.bits)

    def times_cosine(self) -> OddSines:
        """The integral of F(2 x) cos x: a sum of b_m sin((2m + 1) x)."""
        rows = [k * term for k, term in enumerate(self.terms, start=1)]  # a_k/scale
        rows = [fixed(self.mean / self.scale, self.bits) * 2, *rows, 0]
        found = [(a + b) // (2 * (2 * m + 1)) for m, (a, b) in enumerate(itertools.pairwise(rows))]
        return OddSines(tuple(found), self.scale, self.bits)

    def times_sine(self) -> WaveSeries:
        """The integral of F(x) sin x."""
        rows = [k * term for k, term in enumerate(self.terms, start=1)]  # a_k/scale
        rows = [fixed(self.mean / self.scale, self.bits) * 2, *rows, 0, 0]
        found = [
            (b - a) // (2 * n) for n, (a, b) in enumerate(zip(rows[:-2], rows[2:], strict=True), 1)
        ]
        return WaveSeries(mpf(0), (), (0, *found), self.scale, self.bits)

    def doubles(self) -> Doubles:
        """The same in doubles; terms below a double's reach are left out."""
        scale, found = float(self.scale), []
        for term in self.terms:
            found.append(scale * float(mpmath.ldexp(term, -self.bits)))
        largest = max([abs(float(self.mean)), *map(abs, found)])
        while found and abs(found[-1]) < 1e-17 * largest:
            found.pop()
        return Doubles(float(self.mean), tuple(found))


@dataclass(frozen=True)
class Doubles:
    """:class:`Cosines` in doubles, for arrays of x."""

    mean: float
    terms: tuple[float, ...]

    def bounded(self, x: Scalar) -> Scalar:
        """The sum of a_k sin(k x)/k."""
        twice, first, second = 2 * np.cos(x), 0.0, 0.0
        for term in reversed(self.terms):
            first, second = term + twice * first - second, first
        return np.sin(x) * first


@dataclass(frozen=True)
class OddSines:
    """The sum over m >= 0 of b_m sin((2m + 1) x), bounded."""

    terms: tuple[Scalar, ...]
    scale: Scalar
    bits: int | None  # None: terms are doubles, and arrays may be asked for

    def at(self, cos: Scalar, sin: Scalar) -> Scalar:
        """The value from cos x and sin x."""
        if self.bits is None:
            twice, one, two = 2 * (cos - sin) * (cos + sin), 0.0, 0.0
            for term in reversed(self.terms):
                one, two = term + twice * one - two, one
            return sin * (one + two)
        turn = fixed((cos - sin) * (cos + sin), self.bits) * 2
        first, second = 0, 0
        for term in reversed(self.terms):
            first, second = term + ((turn * first) >> self.bits) - second, first
        return self.scale * sin * floating(first + second, self.bits)

    def doubles(self) -> OddSines:
        """The same in doubles."""
        assert self.bits is not None
        bits, scale = self.bits, float(self.scale)
        found = [scale * float(mpmath.ldexp(term, -bits)) for term in self.terms]
        return OddSines(tuple(found), 1.0, None)


def cosines(
    function: Callable[[Scalar], Sequence[Scalar]],
    first: int = _LEAST,
    most: int = _MOST,
    spoiled: int = 0,
) -> list[Cosines]:
    """The series of several even functions of period 2 pi, evaluated together.

    ``function(x)`` gives their values; ``first`` is a guess of the samples that one turn needs.
    They are doubled until the last coefficients are below the precision in force; beyond ``most``
    TooManyTerms is raised.  ``spoiled``: the last bits of the values that are not right.
    """
    prec = mpmath.prec
    known: dict[Any, Sequence[Any]] = {}
    count = _LEAST
    while count < first:
        count *= 2
    while True:
        bits = prec + _GUARD + count.bit_length()
        for j in range(count // 2 + 1):
            share = mpf(2 * j) / count
            if share not in known:
                known[share] = function(mpmath.pi * share)
        rows = [known[mpf(2 * j) / count] for j in range(count // 2 + 1)]
        found = [_series([row[i] for row in rows], bits, spoiled) for i in range(len(rows[0]))]
        if all(series is not None for series in found):
            return [series for series in found if series is not None]
        count *= 2
        if count > most:
            raise TooManyTerms(
                f"too near a degenerate motion: a Fourier series of {most} samples is too short"
            )


@dataclass(frozen=True)
class WaveSeries:
    """The integral of a periodic function: mean x + sum of (a_k sin(k x) - b_k cos(k x))/k."""

    mean: Scalar
    sines: tuple[Any, ...]  # a_k/(k scale)
    cosines: tuple[Scalar, ...]  # -b_k/(k scale)
    scale: Scalar
    bits: int

    def at(self, x: Scalar) -> Scalar:
        """The integral, up to a constant."""
        cos, sin = mpmath.cos_sin(x)
        turn, total = fixed(cos, self.bits) * 2, self.mean * x
        for row, odd in ((self.sines, True), (self.cosines, False)):
            first, second = 0, 0
            for term in reversed(row):
                first, second = term + ((turn * first) >> self.bits) - second, first
            value = floating(first, self.bits)
            part = value * sin if odd else value - cos * floating(second, self.bits)
            total += self.scale * part
        return total


def waves(function: Callable[[Scalar], Scalar], most: int = _MOST) -> WaveSeries:
    """The series of the integral of a function of period 2 pi, at the precision in force.

    Raises TooManyTerms beyond ``most`` samples.
    """
    prec = mpmath.prec
    known: dict[Any, Any] = {}
    count = _LEAST
    while count <= most:
        bits = prec + _GUARD + count.bit_length()
        for j in range(count):
            share = mpf(2 * j) / count
            if share not in known:
                known[share] = function(mpmath.pi * share)
        values = [known[mpf(2 * j) / count] for j in range(count)]
        largest = max(abs(x) for x in values)
        scale = mpmath.ldexp(1, mpmath.mag(largest)) if largest else mpf(1)
        units = np.array([fixed(x / scale, bits) for x in values], dtype=object)
        re, im = transform(units, 0 * units, bits)
        half = count // 2
        edge = max(abs(int(x)) for part in (re, im) for x in part[half - half // 8 - 1 : half + 1])
        if edge <= (half << bits) >> (prec - 8):
            mean = floating(int(re[0]), bits) * scale / count
            # x_k = (a_k - i b_k) half
            sines = tuple(int(re[k]) // (half * k) for k in range(1, half))
            others = tuple(int(im[k]) // (half * k) for k in range(1, half))
            return WaveSeries(mean, sines, (0, *others), scale, bits)
        count *= 2
    raise TooManyTerms(
        f"too near a degenerate motion: a Fourier series of {most} samples is too short"
    )


def _series(values: Sequence[Scalar], bits: int, spoiled: int) -> Cosines | None:
    """One series from the samples on half a turn; None where they are too few."""
    half = len(values) - 1
    scale = mpmath.ldexp(1, max(mpmath.mag(x) for x in values if x)) if any(values) else mpf(1)
    units = [fixed(x / scale, bits) for x in values]
    whole = np.array([*units, *units[-2:0:-1]], dtype=object)
    found, _ = transform(whole, np.zeros(2 * half, dtype=object), bits)
    mean = floating(int(found[0]), bits) * scale / (2 * half)
    terms = [int(x) // (half * k) for k, x in enumerate(found[1:half], start=1)]
    edge = half // 8 + 1
    last = max(abs(int(x)) for x in found[half - edge : half + 1])
    if last > (half << bits) >> (mpmath.prec - spoiled - 8):
        return None
    small = 1 << max(0, bits - mpmath.prec + spoiled)  # what is below is rounding
    while terms and abs(terms[-1]) < small:
        terms.pop()
    return Cosines(mean, tuple(terms), scale, bits)
