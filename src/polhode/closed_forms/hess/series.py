"""One period of Hess's motion with f not 0, as Taylor series in integers.

In axes that turn about e1 so that w has no part along it (units with b = 1),

    z' = -iPg,   g' = iuz,   u' = Im(conj(g) z),
    U' = i(a12/2) z V,   V' = -i(a12/2) conj(z) U,   q' = q (0, 0, z1, z2)/2,

q the quaternion of these axes.  Every coefficient is that of a step of its own length, an integer
in units of 2^-bits; a step is as long as the last terms allow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul

from polhode.closed_forms.functions.fourier import fixed, floating
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_GUARD = 48


@dataclass(frozen=True)
class Step:
    """The series of all components from ``begin`` over ``length``."""

    begin: Scalar
    length: Scalar
    rows: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class Period:
    """The solution over [0, end]."""

    steps: tuple[Step, ...]
    bits: int

    def at(self, t: Scalar) -> list[Scalar]:
        """z1, z2, g1, g2, u, U1, U2, V1, V2, q0, q1, q2, q3 at t."""
        low, high = 0, len(self.steps) - 1
        while low < high:
            middle = (low + high + 1) // 2
            if self.steps[middle].begin <= t:
                low = middle
            else:
                high = middle - 1
        step = self.steps[low]
        return _summed(step.rows, fixed((t - step.begin) / step.length, self.bits), self.bits)


def period(start: Sequence[Scalar], P: Scalar, a12: Scalar, end: Scalar) -> Period:
    """The series from time 0 to ``end``, from the components at 0, at the precision in force."""
    prec = mpmath.prec
    bits = prec + _GUARD
    order = math.ceil(0.35 * bits) + 12  # terms fall by e^-2
    now, state, steps = mpf(0), list(start), []
    with mpmath.workprec(bits):
        numbers = fixed(P, bits), fixed(a12, bits)
        while now < end:
            rows = _series([fixed(x, bits) for x in state], *numbers, order, bits)
            length = min(_share(rows), end - now)
            shrunk = _shrunk(rows, length, bits)
            steps.append(Step(now, length, shrunk))
            state = _summed(shrunk, 1 << bits, bits)
            now = now + length if length < end - now else end
    return Period(tuple(steps), bits)


def _series(start: list[int], P: int, a12: int, order: int, bits: int) -> list[list[int]]:
    """Taylor coefficients over a unit of time, by Cauchy products."""
    rows = [[x] for x in start]
    z1, z2, g1, g2, u, U1, U2, V1, V2, q0, q1, q2, q3 = rows
    for n in range(order):
        x, y = z1[::-1], z2[::-1]
        new = [P * g2[n], -P * g1[n], -_times(u, y), _times(u, x), _times(g1, y) - _times(g2, x)]
        zV = _times(V1, x) - _times(V2, y), _times(V2, x) + _times(V1, y)
        zU = _times(U1, x) + _times(U2, y), _times(U2, x) - _times(U1, y)
        half = a12 >> 1
        new += [-(half * zV[1] >> bits), half * zV[0] >> bits]
        new += [half * zU[1] >> bits, -(half * zU[0] >> bits)]
        new += [
            (-_times(q2, x) - _times(q3, y)) >> 1,
            (_times(q2, y) - _times(q3, x)) >> 1,
            (_times(q0, x) - _times(q1, y)) >> 1,
            (_times(q0, y) + _times(q1, x)) >> 1,
        ]
        for row, term in zip(rows, new, strict=True):
            row.append((term >> bits) // (n + 1))
    return rows


def _times(a: list[int], back: list[int]) -> int:
    """A coefficient of a product, the second factor in reverse order."""
    return sum(map(mul, a, back))


def _share(rows: list[list[int]]) -> Scalar:
    """The length over which the last terms are below the unit, at most a unit of time."""
    order = len(rows[0]) - 1
    share = mpf(1)
    for n in (order - 1, order):
        last = max(abs(row[n]) for row in rows)
        if last:
            share = min(share, mpf(last) ** (mpf(-1) / n))
    return share


def _shrunk(rows: list[list[int]], length: Scalar, bits: int) -> tuple[tuple[int, ...], ...]:
    """The coefficients for a step of that length."""
    powers, factor = [1 << bits], fixed(length, bits)
    for _ in rows[0][1:]:
        powers.append((powers[-1] * factor) >> bits)
    return tuple(
        tuple((x * power) >> bits for x, power in zip(row, powers, strict=True)) for row in rows
    )


def _summed(rows: Sequence[Sequence[int]], s: int, bits: int) -> list[Scalar]:
    """The sums at s, a share of the step."""
    found = []
    for row in rows:
        total = 0
        for x in reversed(row):
            total = ((total * s) >> bits) + x
        found.append(floating(total, bits))
    return found
