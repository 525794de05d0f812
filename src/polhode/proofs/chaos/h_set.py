"""Sets of the level in a plane, on which three integrals are exact.

Trusted.  A chart has a centre c, matrices E (6 x 2) and K (6 x 4), a covector a, all exact, and
eta > 0.  Of a rectangle R of y the set is

    N = {c + E y + K n(y): y in R},  n(y) the solution of G(y, n) = 0 with |n| <= eta,
    G(y, n) = (H(x) - level, a·(x - c)),  x = c + E y + K n.

Krawczyk's test with every y of R at once proves that there is exactly one n(y) for each; it is
analytic in y, so N is a disk of the level in the plane.  With G(y, 0) by the mean value of H
between c and c + E y, n is of the second order of the size where E is tangent to the level.  A ball
that holds all n(y) gives a smaller one: what lies in a box and is a zero lies in Krawczyk's image
of that box.  n' = -(G_n)^-1 G_y.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat

from polhode.enclosures.fixed_point_problem import Refused
from polhode.numbers.rows import Doubles
from polhode.proofs import krawczyk
from polhode.proofs.flow_tube import exactly
from polhode.proofs.level import LevelBalls

_TIGHTENED = 3


@dataclass(frozen=True, eq=False)
class Chart:
    """``centre``: c, integers times 2**-fine; ``wide``: E, ``deep``: K, ``plane``: a, doubles."""

    fine: int
    centre: tuple[int, ...]
    wide: Doubles
    deep: Doubles
    plane: Doubles
    eta: float

    @property
    def point(self) -> list[arb]:
        """c."""
        return [exactly(x, self.fine) for x in self.centre]

    @property
    def frame(self) -> arb_mat:
        """[E | K]."""
        return matrix(np.hstack([self.wide, self.deep]))

    @property
    def row(self) -> arb_mat:
        """a."""
        return matrix(self.plane[None, :])


@dataclass(frozen=True, eq=False)
class HSet:
    """The rectangle |y_1 - middle| <= width, |y_2| <= height of a chart."""

    chart: Chart
    middle: float
    width: float
    height: float

    @property
    def usable(self) -> bool:
        """Whether the numbers are those of a rectangle."""
        numbers = [self.middle, self.width, self.height, self.chart.eta]
        return bool(np.all(np.isfinite(numbers)) and min(numbers[1:]) > 0.0)


class Disk(NamedTuple):
    """A set that exists: balls around all n(y), around n'(y) (4 x 2), and around its points."""

    depth: list[arb]
    slope: arb_mat
    box: list[arb]


def disk(level: LevelBalls, what: HSet) -> Disk:
    """The proof that a set is a disk of the level; raises Refused."""
    chart = what.chart
    if not what.usable:
        raise Refused("a set has no size")
    c, e, k, a = chart.point, matrix(chart.wide), matrix(chart.deep), chart.row
    y = column([arb(what.middle) + arb(0, what.width), arb(0, what.height)])
    about_0 = column([arb(0, (abs(arb(what.middle)) + what.width).upper()), y[1, 0]])
    flat = shifted(c, e * about_0)
    off = [x - v for x, v in zip(level.integrals(c), level.values, strict=True)]
    rise = arb_mat(level.gradients(flat)) * e * y
    value = [x + rise[i, 0] for i, x in enumerate(off)] + [(a * e * y)[0, 0]]
    radii = [arb(chart.eta)] * 4
    inverse: Doubles | None = None
    depth: list[arb] = []
    for tried in range(1 + _TIGHTENED):
        n = column([arb(0, r) for r in radii])
        points = shifted(shifted(c, e * y), k * n)
        left = equations(level, chart, points)
        slope = left * k
        if inverse is None:
            middle = np.array([float(x.mid()) for x in slope.entries()]).reshape(4, 4)
            if not np.all(np.isfinite(middle)) or abs(np.linalg.det(middle)) < 1e-12:
                raise Refused("a set's plane may touch its level")
            inverse = np.linalg.inv(middle)
        tested = krawczyk.contraction(value, slope, inverse, radii)
        if not tried and not tested.passed:
            raise Refused(
                f"a set is no graph over its rectangle, by a factor {max(tested.ratios):.2g}"
            )
        depth = tested.moved
        radii = [x.abs_upper() + arb((1, -900)) for x in depth]
    try:
        turned = -(slope.solve(left * e))
    except ZeroDivisionError:
        raise Refused("a set's slope has no bound") from None
    points = shifted(shifted(c, e * y), k * column(depth))
    along = arb_mat([chart.plane.tolist()]) * column(level.field(points))
    if not abs(along[0, 0]) > 0:
        raise Refused("a set's plane may touch the motion")
    return Disk(depth, turned, points)


def equations(level: LevelBalls, chart: Chart, points: list[arb]) -> arb_mat:
    """The derivative of G by x."""
    return arb_mat([*level.gradients(points), [arb(x) for x in chart.plane.tolist()]])


def apart(one: HSet, other: HSet) -> bool:
    """Whether two sets of one chart are certainly disjoint."""
    if one.chart is not other.chart:
        return False
    gap = abs(arb(one.middle) - arb(other.middle)) - arb(one.width) - arb(other.width)
    return bool(gap > 0)


def matrix(values: Doubles) -> arb_mat:
    """Doubles as exact balls."""
    return arb_mat([[arb(x) for x in row] for row in values.tolist()])


def column(values: list[arb]) -> arb_mat:
    """Balls as a column."""
    return arb_mat([[x] for x in values])


def shifted(point: list[arb], by: arb_mat) -> list[arb]:
    """A point plus a column."""
    return [x + by[i, 0] for i, x in enumerate(point)]
