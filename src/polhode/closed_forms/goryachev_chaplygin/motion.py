"""One Goryachev-Chaplygin motion at one precision: the state from u, v and the halves.

    p = sg sqrt(uv)/2 sin((et - xi)/2),   q = sg sqrt(uv)/2 cos((et - xi)/2),   r = u - v,
    g1 = -(u cos xi + v cos et)/(u + v),  g2 = -(u sin xi - v sin et)/(u + v),
    g3 = sg 2 sqrt(uv) sin((xi + et)/2)/(u + v),   sg = +1 or -1 throughout.

(Goryachev 1900, Chaplygin 1901, in the halves of the angles.)  All in the motion's axes and units.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.goryachev_chaplygin import explicit, regimes
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import (
    Clock,
    Halves,
    Oscillating,
    Standing,
    oscillating,
)
from polhode.closed_forms.goryachev_chaplygin.axes import GoryachevStart
from polhode.closed_forms.goryachev_chaplygin.double_root import tending
from polhode.closed_forms.goryachev_chaplygin.explicit import HalvesPoint, positive
from polhode.closed_forms.goryachev_chaplygin.separation_variables import (
    lost_bits,
    started,
    u_variable,
    v_part,
    v_whole,
)
from polhode.closed_forms.goryachev_chaplygin.torus_quadrature import Torus
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar


class Path(Protocol):
    """u, v and the halves as functions of time."""

    def at(self, t: Scalar, fn: SeriesFunctions) -> HalvesPoint:
        """The point at t."""
        ...


@dataclass(frozen=True)
class Separated:
    """A motion with G > 0."""

    torus: Torus
    a: Scalar

    def at(self, t: Scalar, fn: SeriesFunctions) -> HalvesPoint:
        """The point at t."""
        _, one, other = self.torus.at(t)
        return self.joined(one, other, fn)

    def joined(self, one: Halves, other: Halves, fn: SeriesFunctions) -> HalvesPoint:
        """The point from the two variables."""
        return joined(one, other, self.a, fn)


def joined(one: Halves, other: Halves, a: Scalar, fn: SeriesFunctions) -> HalvesPoint:
    """The point from u's and v's halves."""
    xi, et = (one.sine, one.cosine), (other.sine, other.cosine)
    return positive(one.z, other.z, xi, et, a, fn)


@dataclass(frozen=True)
class GoryachevMotion:
    """A path with the sign sg."""

    path: Path
    sg: int
    defect: Scalar  # by how much the start is missed, relative to |w| and 1

    def at(self, t: Scalar, fn: SeriesFunctions) -> tuple[HalvesPoint, list[Scalar]]:
        """The point and p, q, r, g1, g2, g3."""
        point = self.path.at(t, fn)
        return point, state(point, self.sg)


def state(point: HalvesPoint, sg: int) -> list[Scalar]:
    """p, q, r, g1, g2, g3 from the variables and the halves."""
    (sx, cx), (se, ce) = point.xi, point.et
    one, two, both = point.shares
    half = sg * point.root / 2
    return [
        half * (se * cx - ce * sx),
        half * (cx * ce + sx * se),
        point.u - point.v,
        -(one * (cx - sx) * (cx + sx) + two * (ce - se) * (ce + se)),
        -2 * (one * sx * cx - two * se * ce),
        2 * sg * both * (sx * ce + cx * se),
    ]


def motion(start: GoryachevStart, regime: str, bits: int) -> GoryachevMotion:
    """The constants of a motion, at ``bits`` bits."""
    with mpmath.workprec(bits):
        w, gamma = start.numbers(bits)
        a, H = number(start.a, bits), number(start.H, bits)
        if regime in regimes.EXPLICIT:
            make: Any = {
                regimes.LIBRATING: explicit.libration,
                regimes.ROTATING: explicit.rotation,
                regimes.SEPARATRIX: explicit.separatrix,
            }[regime]
            path: Path = make(a, H, _angles(start, bits))
        else:
            path = Separated(_torus(start, regime, bits), a)
        given = [*w, *gamma]
        found = state(path.at(mpf(0), MP), 1)
        lead = max((0, 1, 5), key=lambda i: abs(given[i]))
        sg = 1 if found[lead] * given[lead] >= 0 else -1
        found = [x * sg if i in (0, 1, 5) else x for i, x in enumerate(found)]
        scale = max(*(abs(x) for x in w), mpmath.sqrt(a))
        misses = [abs(x - y) for x, y in zip(found, given, strict=True)]
        return GoryachevMotion(path, sg, max(max(misses[:3]) / scale, *misses[3:]))


def _variables(start: GoryachevStart, bits: int) -> tuple[Scalar, Scalar]:
    """u and v at the start; the smaller one without cancellation."""
    (p, q, r), _ = start.numbers(bits)
    flat = 4 * (p * p + q * q)
    larger = (abs(r) + mpmath.sqrt(r * r + 4 * flat)) / 2
    smaller = flat / larger if larger else mpf(0)
    return (larger, smaller) if r >= 0 else (smaller, larger)


def _sines(start: GoryachevStart, bits: int) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """u, v, sin xi and sin et at a start that is not at rest."""
    (_, q, _), (_, g2, g3) = start.numbers(bits)
    u, v = _variables(start, bits)
    return u, v, 2 * q * g3 / u - g2, 2 * q * g3 / v + g2


def _angles(
    start: GoryachevStart, bits: int
) -> tuple[Scalar, Scalar, Scalar | None, Scalar | None, Scalar | None]:
    """u, v, xi, et, and l of a start from rest (else None); G = 0."""
    a, H = number(start.a, bits), number(start.H, bits)
    if all(not x for x in start.numbers(bits)[0]):
        _, (_, g2, g3) = start.numbers(bits)
        return mpf(0), mpf(0), None, None, -g2 / mpmath.hypot(g2, g3)
    u, v, sin_xi, sin_et = _sines(start, bits)
    xi, et = (mpmath.atan2(s, (z * z - H) / (2 * a)) for z, s in ((u, sin_xi), (v, sin_et)))
    return u, v, xi, et, None


def _torus(start: GoryachevStart, regime: str, bits: int) -> Torus:
    a = number(start.a, bits)
    u0, v0, sin_xi, sin_et = _sines(start, bits)
    one = u_variable(start, bits)
    spoiled = math.ceil(lost_bits(start))
    u = oscillating(one, spoiled)
    x = u.chart.inverse(started(one, u0, sin_xi, a))
    v: Clock
    if regime in regimes.TWO_FREQUENCIES:
        if regime == regimes.GENERIC_WHOLE:
            other = v_whole(start, bits)
        else:
            other = v_part(start, bits, high=regime == regimes.GENERIC_HIGH)
        made: Oscillating = oscillating(other, spoiled)
        return Torus(u, made, (x, made.chart.inverse(started(other, v0, sin_et, a))), a)
    if regime in regimes.CONSTANT:
        zero = regime == regimes.CONSTANT_ZERO
        side = 2 if zero else -2
        z = mpmath.sqrt((number(start.H, bits) + side * a) / 3)
        v = Standing(z, 0 if zero else 1, 1 if zero else 0)
        return Torus(u, v, (x, mpf(0)), a)
    v = tending(start, bits, low=regime == regimes.ASYMPTOTIC_LOW)
    return Torus(u, v, (x, v.started(v0, sin_et)), a)


def frequencies(found: GoryachevMotion) -> Sequence[Scalar]:
    """The rates of the turns of x and y, radians a unit of time; none but for a torus."""
    assert isinstance(found.path, Separated)
    return found.path.torus.rates
