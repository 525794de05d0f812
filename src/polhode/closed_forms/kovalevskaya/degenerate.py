"""Motions on a degenerate curve: the mean of neighbours, extrapolated.

The state at t is an analytic function of the start.  With M(eps) the mean of the motions from the
start moved by eps and -eps along a generic direction,

    state = (4 M(eps) - M(2 eps))/3 + O(x^4),    M(eps) - state = O(x^2),

x = eps times the growth of a deviation to the time t (at most linear in t on a quasi-periodic
motion, exponential on an asymptotic one).  The square of their difference is the error's estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.generic import Generic, generic
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.scalars import Scalar


@dataclass(frozen=True)
class Averaged:
    """The four neighbours at one precision: at eps, -eps, 2 eps, -2 eps."""

    starts: Sequence[KovalevskayaStart]
    neighbours: Sequence[Generic]
    speed: Scalar  # the units of w and G in the estimate
    weight: Scalar
    closeness: int  # -log2 eps

    @property
    def defect(self) -> Scalar:
        """The largest defect of a neighbour."""
        return max(motion.defect for motion in self.neighbours)

    def at(self, t: Scalar) -> tuple[list[Scalar], Scalar]:
        """The state at t and an estimate of its error from the extrapolation."""
        sizes = [self.speed] * 3 + [self.weight] * 3
        return combined([motion.at(t)[0] for motion in self.neighbours], sizes)


def combined(
    rows: Sequence[Sequence[Scalar]], sizes: Sequence[Scalar]
) -> tuple[list[Scalar], Scalar]:
    """What the neighbours' values tell about the motion between them, and the error's estimate.

    ``sizes``: the unit of each value in the estimate.
    """
    found, estimate = [], mpf(0)
    for (a, b, c, d), size in zip(zip(*rows, strict=True), sizes, strict=True):
        near, far = (a + b) / 2, (c + d) / 2
        found.append((4 * near - far) / 3)
        estimate = max(estimate, (abs(near - far) / size) ** 2 * 4)
    return found, estimate


def averaged(
    start: KovalevskayaStart, bits: int, closeness: int, backend: str | None = None
) -> Averaged:
    """The neighbours at eps = 2^-closeness, at ``bits`` bits; raises Unresolved if too few."""
    starts = [
        start.moved(Fraction(share, 1 << closeness), 4 * closeness + bits)
        for share in (1, -1, 2, -2)
    ]
    neighbours = [generic(moved, bits, backend) for moved in starts]
    speed = mpf(2) ** int(start.log2_scale)
    return Averaged(starts, neighbours, speed, mpf(2) ** round(start.log2_weight), closeness)
