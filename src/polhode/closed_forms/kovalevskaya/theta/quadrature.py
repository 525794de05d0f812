"""Two rules for integrals between branch points, with exact distances from both ends.

With s = a + L x, the integral over dx/sqrt(x (1-x)) from 0 to 1 is taken

- by the midpoint rule in th, x = sin^2(th/2): it converges as R^(-2N), R the sum of the half axes
  of the ellipse with foci 0, 1 through the nearest singularity (Trefethen & Weideman, SIAM Rev. 56
  (2014) 385);
- by a double-exponential rule x = 1/(1 + e^(-2y)), y = ta + (e^(ta - y1) - e^(-ta - y2))/2, step h
  in ta: it converges as exp(-2 pi d/h), d the distance of the nearest singularity from the real ta
  (Takahasi & Mori 1974).  A singularity at a distance from the end b that is small against L has a
  large real part of y, next to which y1 is laid: up to there y is linear in ta, and d stays of the
  order of 1, so that the number of nodes grows with the logarithm of the distance only.

Nodes are triples (weight, x, 1 - x) of FLINT's balls; both ends keep their digits.
"""

from __future__ import annotations

import cmath
import functools
import math
from collections.abc import Iterable

import flint

from polhode.closed_forms.kovalevskaya.theta.balls import SPARE, Ball, ball, more_bits
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

Nodes = tuple[tuple[Ball, Ball, Ball], ...]

_EXTRA = 12  # bits that the rules are made for beyond the precision in force
MOST_NODES = 60_000
_COARSE = 2.0
_NEWTON = 50
_STAIRS = 8


class TooManyNodes(ArithmeticError):
    """An integral whose singularities are too near for the digits asked for."""

    def __init__(self) -> None:
        super().__init__("so near a degenerate motion its integrals need too many nodes")


#: x and 1 - x in doubles: next to either end both keep their digits.
Place = tuple[complex, complex]


def place(from_a: Scalar, from_b: Scalar, length: Scalar) -> Place:
    """The x of a point at a distance from the end a and from the end b = a + length."""
    return complex(from_a / length), complex(-from_b / length)


def nodes(singularities: Iterable[Place], *, periodic: bool = True) -> Nodes:
    """Nodes at the precision in force for singularities at these places.

    ``periodic`` allows the midpoint rule: the integrand is analytic in cos th.
    """
    points = list(singularities)
    wanted = (mpmath.prec + _EXTRA) * math.log(2)
    heights = [_height(point) for point in points]
    # Rounded, so that nodes are made once for several integrals.
    y1 = _COARSE * math.ceil(max([0.0, *(y.real for y in heights)]) / _COARSE)
    y2 = _COARSE * math.ceil(max([0.0, *(-y.real for y in heights)]) / _COARSE)
    strip = min(_strip(y, y1, y2) for y in (*heights, 1j * math.pi / 2))
    step = 2 * math.pi * 0.95 * strip / wanted
    reach = y1 + y2 + 2 * math.log(2 * wanted)
    if periodic:
        speed = min([20.0, *map(_ellipse, points)])
        midpoints = wanted / (2 * speed) + 4 if speed > 0 else math.inf
        if midpoints <= MOST_NODES and midpoints * step <= reach:
            return _midpoint(_grown(math.ceil(midpoints)), mpmath.prec)
    if reach > MOST_NODES * step:
        raise TooManyNodes
    return _double_exponential(math.ceil(-8 * math.log2(step)), y1, y2, mpmath.prec)


def _grown(count: int) -> int:
    """A count at least as large out of a coarse ladder."""
    unit = 1 << max(0, count.bit_length() - 3)
    return -(-count // unit) * unit


def _ellipse(where: Place) -> float:
    """log R for a singularity: R + 1/R = |x| + |1 - x| times 2."""
    nearer = min(where, key=abs)
    return 2 * abs(cmath.asinh(cmath.sqrt(-nearer)).real)


def _height(where: Place) -> complex:
    """The y of a place, that with the least imaginary part."""
    x, rest = where
    if not x or not rest:
        raise TooManyNodes
    if not (cmath.isfinite(x) and cmath.isfinite(rest)):  # beyond doubles: x = -rest in effect
        return 1j * math.pi / 2
    y = (cmath.log(x) - cmath.log(rest)) / 2
    return y - 1j * math.pi * round(y.imag / math.pi)


def _strip(y: complex, y1: float, y2: float) -> float:
    """The distance from the real axis of the ta that belongs to y, followed from Re y upwards."""

    def followed(ta: complex, goal: complex) -> complex:
        for _ in range(_NEWTON):
            up, down = cmath.exp(ta - y1) / 2, cmath.exp(-ta - y2) / 2
            change = (ta + up - down - goal) / (1 + up + down)
            ta -= change
            if abs(change) < 1e-9:
                break
        return ta

    ta = followed(complex(y.real), complex(y.real))
    for n in range(1, _STAIRS + 1):
        ta = followed(ta, complex(y.real, y.imag * n / _STAIRS))
    return abs(ta.imag)


@functools.lru_cache(maxsize=64)
def _midpoint(count: int, prec: int) -> Nodes:
    with mpmath.workprec(prec), more_bits():
        weight = flint.arb.pi() / count
        found = []
        for m in range(count):
            s, c = (flint.arb(2 * m + 1) / (4 * count)).sin_cos_pi()
            found.append((weight, s * s, c * c))
    return tuple(found)


@functools.lru_cache(maxsize=64)
def _double_exponential(ladder: int, y1: float, y2: float, prec: int) -> Nodes:
    with mpmath.workprec(prec + SPARE):
        h = ball(mpmath.mpf(2) ** (-mpmath.mpf(ladder) / 8))
        tiny = ball(mpmath.ldexp(1, -prec))
    with mpmath.workprec(prec), more_bits():
        growth, ends = h.exp(), ((-flint.arb(y1)).exp() / 2, (-flint.arb(y2)).exp() / 2)
        found: list[tuple[Ball, Ball, Ball]] = []
        for sense in (1, -1):
            count = 0
            if sense < 0:
                count, ends = 1, (ends[1], ends[0])
            e = growth**count
            while True:
                up, down = ends[0] * e, ends[1] / e
                root = (count * h + up - down).exp()  # e^y, y counted towards this end
                weight = 2 * h * (1 + up + down) / (root + 1 / root)
                if weight < tiny:
                    break
                z = root * root
                near = 1 / (1 + z)
                far = z * near
                found.append((weight, far, near) if sense > 0 else (weight, near, far))
                e *= growth
                count += 1
    return tuple(found)
