"""Integrals of one over square roots of products of linear functions, in balls, errors proven.

Two of them make every period of a hyperelliptic curve and every image under Abel's map:

    :func:`circle`:  over phi from 0 to pi of (1, cos phi), y = (1 - cos phi)/2,
    :func:`unit`:    over x from 0 to 1 of (1, x^2),        y = x^2,

both times the product of (first + slope y)^(-1/2), principal roots.  The line from ``first`` to
``last`` must keep clear of the negative numbers.

The errors.  A linear function is |slope| |cos phi - cos g|/2 in modulus, its zero at phi = g; where
|Im phi| <= eta < rho = |Im g|, that is at least |slope| sinh^2((rho - eta)/2), for |sin z| >= sinh
|Im z|.  So the integrand has a bound M in a strip, and

* the midpoint rule of n points on (0, pi), half of one with 2n points on the circle, is off by at
  most 2 pi M/(exp(2 n eta) - 1);
* Gauss's rule of n points on (-1, 1), x = cos t with |Im t| <= eta, by at most
  64/15 M exp(-2 n eta)/(1 - exp(-2 eta)) (Rabinowitz 1969); of an even integrand half of it counts.

Where a zero is too near to an end of the way, :func:`unit` cuts the way into panels that keep off
it: doubles choose them, balls bound the error, and what is not proven raises TooFewBits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits
from polhode.numbers.flint_context import ctx

#: Two complex balls.
Pair: TypeAlias = tuple[acb, acb]

WIDEST = 2.2  # half of a strip
SHARE = 0.9  # of the way to the nearest zero that a strip takes
_MOST = 400  # points of one rule
_SPARE = 10  # nats beyond the bits in force
_PANEL = 1.0  # rho that every zero keeps from a panel
_PANEL_ETA = 0.8
_SHRINK = 0.7
_FAR = 2.8  # |x|^2 next to a panel is less


@dataclass(frozen=True)
class Linear:
    """A linear function by its values at both ends and their difference.

    All three are asked for, since a difference of what is nearly the same would cost digits.
    """

    first: acb
    last: acb
    slope: acb

    @property
    def real(self) -> bool:
        """Whether it is real, and so positive all the way."""
        return all(x.imag.is_zero() for x in (self.first, self.last, self.slope))

    def reversed(self) -> Linear:
        """The same from the other end."""
        return Linear(self.last, self.first, -self.slope)

    @property
    def flat(self) -> bool:
        """Whether it is so far from 0 that no strip meets its zero."""
        middle = abs(self.first + self.last) / 2
        return bool(middle > 2 * abs(self.slope) * arb(WIDEST).cosh())

    @property
    def rho(self) -> arb:
        """How far its zero g is from the real phi: |Im g|."""
        return ellipse((self.first + self.last) / self.slope)

    def least(self, eta: arb) -> arb:
        """A lower bound where |Im phi| <= eta; TooFewBits where none is proven."""
        if self.flat:
            return abs(self.first + self.last) / 2 - abs(self.slope) * eta.cosh() / 2
        room = self.rho - eta
        # Its sign first: the square would hide it.
        if not room > 0:
            raise TooFewBits
        return abs(self.slope) * square((room / 2).sinh())


def circle(factors: Sequence[Linear]) -> Pair:
    """The integrals over phi from 0 to pi of 1 and cos phi times the inverse roots."""
    eta = strip(factors)
    n = math.ceil((ctx.prec * math.log(2) + _SPARE) / (2 * eta)) + 1 if eta > 0 else _MOST + 1
    if n > _MOST:
        return _from_both_ends(factors)
    total, moment = acb(0), acb(0)
    root = InverseRoots(factors)
    for k in range(n):
        angle = arb(2 * k + 1) / (4 * n)
        sin, cos = arb.sin_cos_pi(angle)
        term = root(sin * sin)
        total += term
        moment += term * (cos * cos - sin * sin)
    wide = arb(eta)
    error = 2 * arb.pi() * bound(factors, wide) / ((2 * n * wide).exp() - 1)
    width = arb.pi() / n
    return total * width + around(error), moment * width + around(error * wide.cosh())


def _from_both_ends(factors: Sequence[Linear]) -> Pair:
    """:func:`circle` from each end to the middle.

    cos phi = 1 - x^2 and dphi = 2 dx/sqrt(2 - x^2), and the same mirrored.
    """
    root = Linear(acb(2), acb(1), acb(-1))
    halves = []
    for way in (factors, [factor.reversed() for factor in factors]):
        half = []
        for factor in way:
            slope = factor.slope / 2
            half.append(Linear(factor.first, (factor.first + factor.last) / 2, slope))
        halves.append(unit([*half, root]))
    (one, first), (two, second) = halves
    return 2 * (one + two), 2 * (one - first) - 2 * (two - second)


def unit(factors: Sequence[Linear]) -> Pair:
    """The integrals over x from 0 to 1 of 1 and x^2 times the inverse roots of what x^2 gives."""
    eta = strip(factors) / 2
    half = math.ceil((ctx.prec * math.log(2) + _SPARE) / (4 * eta)) + 1 if eta > 0 else _MOST + 1
    if half > _MOST:
        return _panels(factors)
    n = 2 * _rounded(half)
    total, moment = acb(0), acb(0)
    root = InverseRoots(factors)
    for x, weight in gauss(n, ctx.prec):
        y = x * x
        term = weight * root(y)
        total += term
        moment += term * y
    wide = arb(eta)
    error = _gauss_error(bound(factors, 2 * wide), n, wide) / 2
    return total + around(error), moment + around(error * square(wide.cosh()))


def _panels(factors: Sequence[Linear]) -> Pair:
    """:func:`unit` on panels that grow away from the zeros, one rule for all."""
    roots = [None if f.flat else (-f.first / f.slope).sqrt() for f in factors]
    zeros = [z for root in roots if root is not None for z in (root, -root)]
    if not all(z.is_finite() for z in zeros):
        raise TooFewBits
    flat = [complex(z) for z in zeros]
    eta = arb(_PANEL_ETA)
    n = 2 * _rounded(math.ceil((ctx.prec * math.log(2) + 3 * _SPARE) / (4 * _PANEL_ETA)))
    rule = gauss(n, ctx.prec)
    value = InverseRoots(factors)
    total, moment = acb(0), acb(0)
    for u, v in _ways(flat):
        middle, half = (arb(u) + arb(v)) / 2, (arb(v) - arb(u)) / 2
        most = arb(1)
        for factor, root in zip(factors, roots, strict=True):
            most /= _least_on_panel(factor, root, middle, half, eta).sqrt()
        error = _gauss_error(most, n, eta) * half
        one, two = acb(0), acb(0)
        for node, weight in rule:
            for x in (middle + half * node, middle - half * node):
                y = x * x
                term = weight * value(y)
                one += term
                two += term * y
        total += half * one + around(error)
        moment += half * two + around(error * _FAR)
    return total, moment


def _ways(zeros: Sequence[complex]) -> list[tuple[float, float]]:
    """Panels (u, v) from 0 to 1, each as long as all zeros allow."""
    ways, u = [], 0.0
    while u < 1:
        v = 1.0
        while any(_flat_ellipse((z - (u + v) / 2) / ((v - u) / 2)) < _PANEL for z in zeros):
            shorter = u + (v - u) * _SHRINK
            if not u < shorter < v or v - u < 1e-300:
                raise TooFewBits
            v = shorter
        ways.append((u, v))
        u = v
    return ways


def _least_on_panel(factor: Linear, root: acb | None, middle: arb, half: arb, eta: arb) -> arb:
    """A lower bound of a factor on the ellipse of size eta round a panel."""
    if root is None:
        return abs(factor.first) - _FAR * abs(factor.slope)
    least = abs(factor.slope)
    for zero in (root, -root):
        room = ellipse((zero - middle) / half) - eta
        if not room > 0:
            raise TooFewBits
        least *= 2 * half * square((room / 2).sinh())
    return least


def strip(factors: Sequence[Linear]) -> float:
    """Half of the width of a strip that keeps off all zeros, by doubles."""
    width = WIDEST
    for factor in factors:
        if not factor.flat:
            room = factor.rho
            width = min(width, SHARE * float(room.mid()) if room.is_finite() else 0.0)
    return width


def bound(factors: Sequence[Linear], eta: arb) -> arb:
    """A bound of the product of inverse roots where |Im phi| <= eta."""
    most = arb(1)
    for factor in factors:
        least = factor.least(eta)
        if not least > 0:
            raise TooFewBits
        most /= least.sqrt()
    return most


class InverseRoots:
    """The product of (first + slope y)^(-1/2), for y from 0 to 1."""

    def __init__(self, factors: Sequence[Linear]) -> None:
        real = [f for f in factors if f.real]
        self._real = [(f.first.real, f.slope.real) for f in real]
        self._complex = [(f.first, f.slope) for f in factors if not f.real]

    def __call__(self, y: arb) -> acb:
        """The product at one y."""
        product = arb(1)
        for first, slope in self._real:
            product *= first + slope * y
        value = acb(product.rsqrt())
        for base, way in self._complex:
            value *= (base + way * y).rsqrt()
        return value


def ellipse(w: acb) -> arb:
    """|Im acos w|: w lies on the ellipse of this size with the foci -1 and 1."""
    half = (abs(w - 1) + abs(w + 1)) / 2
    # At least 1; a ball that goes below 1 by its radius has no acosh.
    return half.max(arb(1)).acosh()


def _flat_ellipse(w: complex) -> float:
    return math.acosh(max(1.0, (abs(w - 1) + abs(w + 1)) / 2))


@lru_cache(maxsize=256)
def gauss(n: int, bits: int) -> tuple[tuple[arb, arb], ...]:
    """The positive nodes and the weights of Gauss's rule of n points, n even, at ``bits`` bits."""
    with ctx.workprec(bits):
        return tuple(arb.legendre_p_root(n, k, weight=True) for k in range(n // 2))


def _gauss_error(most: arb, n: int, eta: arb) -> arb:
    return arb(64) / 15 * most * (-2 * n * eta).exp() / (1 - (-2 * eta).exp())


def _rounded(n: int) -> int:
    """Up to a multiple of 8: nearby wishes share their nodes."""
    return 8 * math.ceil(n / 8)


def square(x: arb) -> arb:
    """x^2; ``x ** 2`` is not a number where a ball has its middle at 0."""
    return x * x


def around(radius: arb) -> acb:
    """A ball around 0 that holds all complex numbers of at most this modulus."""
    r = radius.abs_upper()
    return acb(arb(0, r), arb(0, r))
