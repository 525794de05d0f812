"""Points along an arc of permanent rotations in the plane of f and h, in doubles, for a figure."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb

from polhode.dynamics.levels.permanent_rotations import Arc
from polhode.dynamics.levels.rotation_arcs import FIRST, RationalBody, Segment
from polhode.numbers.rows import Doubles

SAMPLES = 257  # points of a curve's piece
_CLUSTER = 14.0  # pieces are followed to e^-14 of their length from an open end


def points(arc: Arc, segment: Segment) -> Doubles:
    """f and h on a piece, denser towards its ends."""
    rising = np.linspace(-_CLUSTER, _CLUSTER, SAMPLES)
    first, last = (None if x is None else float(x) for x in (segment.first, segment.last))
    body = arc.body
    if first is not None and last is not None:
        nearer = 1 / (1 + np.exp(np.abs(rising)))  # the part of the length to the nearer end
        at = np.where(rising < 0, first + (last - first) * nearer, last - (last - first) * nearer)
    elif last is not None:  # first family, s -> -inf
        at = last - (abs(last) or 1.0) * np.exp(-rising)
    else:
        assert first is not None
        length = first or _om_scale(body)
        at = first + length * np.exp(rising if arc.family == FIRST else rising / 2)
    f, h = _f_and_h(arc, at)
    closed = _closed_ends(arc, segment)
    rows = [*closed[0], *zip(f, h, strict=True), *closed[1]]
    return np.array([row for row in rows if all(map(np.isfinite, row))], dtype=float).reshape(-1, 2)


def _om_scale(body: RationalBody) -> float:
    """A rate of turning, where nothing but the unit of time says one."""
    largest = max(map(abs, body.torque))
    if largest == 0:
        return 1.0
    length = float(sum((t * t / largest**2 for t in body.torque), Fraction(0))) ** 0.5
    return float((length * float(largest / max(body.moments))) ** 0.5)


def _f_and_h(arc: Arc, at: Doubles) -> tuple[Doubles, Doubles]:
    """f and h at many parameters, in doubles."""
    body = arc.body
    size = _power(max(body.moments))  # all is of order one in units of it, and of a rate
    rate = (_power(max(map(abs, body.torque))) - size) // 2
    moments = np.array([float(x / Fraction(2) ** size) for x in body.moments])
    torque = np.array([float(x / Fraction(2) ** (size + 2 * rate)) for x in body.torque])
    at = np.ldexp(at, -size if arc.family == FIRST else -rate)
    f, h = _plain_f_and_h(arc, at, moments, torque)
    return np.ldexp(f, size + rate), np.ldexp(h, size + 2 * rate)


def _power(x: Fraction) -> int:
    """About log2 of a number, 0 of zero."""
    return x.numerator.bit_length() - x.denominator.bit_length() if x else 0


def _plain_f_and_h(
    arc: Arc, at: Doubles, moments: Doubles, torque: Doubles
) -> tuple[Doubles, Doubles]:
    with np.errstate(all="ignore"):
        if arc.family == FIRST:
            heavy = torque != 0
            v = torque[heavy] / (moments[heavy] - at[:, None])
            square = (v * v).sum(axis=1)
            inertia = (moments[heavy] * v * v).sum(axis=1)
            f = inertia / square**0.75
            return f, (inertia / 2 + (torque[heavy] * v).sum(axis=1)) / np.sqrt(square)
        a = moments[arc.axis]
        others = (torque != 0) & (moments != a)
        excess = float((torque[others] ** 2 / (moments[others] - a)).sum())
        return at * a + excess / at**3, at**2 * a / 2 + 1.5 * excess / at**2


def _closed_ends(arc: Arc, segment: Segment) -> tuple[list[Any], list[Any]]:
    """The ends that belong to the piece, as rows (f, h): special points, and a family's start."""
    ends: list[list[Any]] = [[], []]
    for k, end in enumerate((segment.first, segment.last)):
        for special in arc.special:
            if end is special.at.parameter or (
                end is not None and _same(end, special.at.parameter)
            ):
                ends[k] = [(float(special.at.f), float(special.at.h))]
        if k == 0 and arc.family != FIRST and end is not None and end > 0:
            point = arc.at(end)
            ends[k] = [(float(point.f), float(point.h))]
    return ends[0], ends[1]


def _same(a: arb, b: arb) -> bool:
    return bool(a.overlaps(b))
