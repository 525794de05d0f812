"""Turns of a moving complex number about 0, counted by a certified march in doubles.

A point that moves by at most ``reach`` between two samples, and starts or ends farther than that
from 0, does not leave a half plane: the argument grows by the principal difference.  Where that
cannot be said, the interval is cut; very near 0 high precision takes over.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Complexes, Doubles
from polhode.numbers.scalars import Scalar

MOST_SAMPLES = 20_000_000
_REACH = 0.25  # of one step of the march
_CHUNK = 1 << 15
_PIECES = 4
_FINEST = 1e-5  # reach below which doubles are not asked any more
_DOUBT = 1e-6  # more than the error of a double in the march

#: al and bt at one time, and at an array of times.
Fine = Callable[[mpf], tuple[Scalar, Scalar]]
Coarse = Callable[[Scalar], tuple[Scalar, Scalar]]


def longest() -> int:
    """The longest time that a march can reach, in the units of :func:`growth`."""
    return int(2 * _REACH * MOST_SAMPLES)


def too_far(reach: Scalar) -> ValueError:
    """The refusal of turns that must be counted beyond a time."""
    return ValueError(
        "psi and phi of this motion in these axes are not closed: their turns must be counted, "
        f"which is possible here for |t| up to {mpmath.nstr(reach, 3)}"
    )


def fine_parameters(q: Quaternion) -> tuple[Scalar, Scalar]:
    """al = q0 + i q3 and bt = q1 + i q2 of a quaternion of mpf."""
    return mpmath.mpc(q[0], q[3]), mpmath.mpc(q[1], q[2])


def coarse_parameters(q: Quaternion) -> tuple[Complexes, Complexes]:
    """The same of arrays of doubles."""
    return q[0] + 1j * q[3], q[1] + 1j * q[2]


def growth(
    fine: Fine,
    coarse: Coarse,
    times: Sequence[mpf],
    since: Any | None = None,
) -> list[tuple[float, float]]:
    """Growth of (arg al, arg bt) from time 0 to each of ``times``, which go away from 0.

    ``since``: the time to count from instead, no farther from 0 than they are.

    Times are in units in which al and bt move at most by half a unit of time.  ``fine`` gives the
    two parameters at one time, at the precision in force, ``coarse`` at an array of times in
    doubles.  From an exact 0 at time 0 the argument grows from its limit there.
    """
    import numpy as np

    def marched(start: float, end: float) -> Doubles:
        """Growth between two doubles."""
        pieces = max(1, int(abs(end - start) / (2 * _REACH)) + 1)
        total = np.zeros(2)
        for first in range(0, pieces, _CHUNK):
            last = min(first + _CHUNK, pieces)
            nodes = start + (end - start) * (np.arange(first, last + 1) / pieces)
            total += refined(nodes[:-1], nodes[1:])
        return total

    def refined(left: Doubles, right: Doubles) -> Doubles:
        """Growth over intervals, summed."""
        ends = coarse(left), coarse(right)
        reach = np.abs(right - left) / 2 + _DOUBT
        good = np.ones(len(left), dtype=bool)
        for a, b in zip(*ends, strict=True):
            good &= np.maximum(np.abs(a), np.abs(b)) > reach
        total = np.array(
            [np.angle(b[good] * np.conj(a[good])).sum() for a, b in zip(*ends, strict=True)]
        )
        left, right = left[~good], right[~good]
        if len(left) == 0:
            return total
        if reach.max() < _FINEST:
            return total + sum(
                np.array(bisected(fine, mpf(float(a)), mpf(float(b))))
                for a, b in zip(left, right, strict=True)
            )
        cuts = left + (right - left) * (np.arange(_PIECES + 1)[:, None] / _PIECES)
        cuts[-1] = right
        return total + refined(cuts[:-1].ravel(), cuts[1:].ravel())

    found, total, now = [], np.zeros(2), 0.0
    if since:
        now = float(since)
        total = np.array(bisected(fine, since, mpf(now)))
    for time in times:
        # The first and last steps go from the exact start and to the exact time.
        near = float(time)
        total = total + marched(now, near)
        extra = bisected(fine, mpf(near), time)
        found.append((float(total[0] + extra[0]), float(total[1] + extra[1])))
        now = near
    return found


def bisected(fine: Fine, left: mpf, right: mpf, bend: Scalar | None = None) -> list[float]:
    """Growth of the two arguments over one interval, by bisection in high precision.

    With a bound of the second derivative, the path is also known to stay near its chord.  Through
    an exact 0 the argument jumps by pi, counted upwards.
    """
    known: dict[Any, tuple[Any, Any]] = {}

    def at(t: Scalar) -> tuple[Scalar, Scalar]:
        if t not in known:
            known[t] = fine(t)
        return known[t]

    grown = []
    for which in (0, 1):
        total = 0.0
        pending = [(left, right)]
        while pending:
            a, b = pending.pop()
            p, q = at(a)[which], at(b)[which]
            reach = abs(b - a) / 2
            certain = max(abs(p), abs(q)) > reach or (
                bend is not None and _from_origin(p, q) > bend * reach * reach / 2
            )
            if certain or reach < mpmath.ldexp(1, -mpmath.prec // 3):
                total += _difference(p, q)
                continue
            middle = (a + b) / 2
            pending += [(middle, b), (a, middle)]
        grown.append(total)
    return grown


def _from_origin(p: Scalar, q: Scalar) -> Scalar:
    """The distance of 0 from the segment from p to q."""
    way = q - p
    along = -(p * way.conjugate()).real
    if along <= 0 or not way:
        return abs(p)
    if along >= (way * way.conjugate()).real:
        return abs(q)
    return abs((p * way.conjugate()).imag) / abs(way)


def _difference(p: Scalar, q: Scalar) -> float:
    tiny = mpmath.ldexp(1, -2 * mpmath.prec // 3)
    if abs(p) < tiny or abs(q) < tiny:
        return 0.0
    angle = float(mpmath.arg(q * p.conjugate()))
    return angle + 2 * float(mpmath.pi) if angle < -3.14159265 else angle
