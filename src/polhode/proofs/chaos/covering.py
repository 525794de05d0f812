"""Covering relations and cone conditions of proved images.

Trusted.  With one unstable direction N covers N' if the second coordinate of the whole image of N
lies strictly inside N', the images of its two edges y_1 = middle +- width lie strictly beyond the
two edges of N', on opposite sides, either way round (P. Zgliczynski, M. Gidea 2004), and the
image's n' lies strictly inside |n'| <= eta': only then a point of the image over the rectangle of
N' is the point of N' there, and not one of another sheet of the level.

Cones: L = dy'/dy in the sizes of both sets; with Q = diag(1, -1), L^T Q L - Q is positive definite
for every L of a ball matrix that holds the derivatives at all points of N: these are means of L
between any two points, so the same holds for the differences of their images.
"""

from __future__ import annotations

from typing import NamedTuple

from flint import arb

from polhode.enclosures.fixed_point_problem import Refused
from polhode.proofs.chaos.h_set import HSet
from polhode.proofs.chaos.transit import Image
from polhode.proofs.level import largest


class Margins(NamedTuple):
    """How far the edges go over the width, how high the image is over the height; the cones."""

    stretch: float
    height: float
    depth: float
    cone: float


def covers(image: Image, target: HSet) -> Margins:
    """The proof that the source of an image covers a set, with cones; raises Refused."""
    if not target.usable or image.chart is not target.chart:
        raise Refused("an image and a set are in different charts")
    high = _rest(image, 1, ()) / arb(target.height)
    if not high < 1:
        raise Refused(f"an image is higher than the set that it is to cover, by {_factor(high)}")
    left, right = _edge(image, -1) - target.middle, _edge(image, 1) - target.middle
    width = arb(target.width)
    if left > right:
        left, right = right, left
    if not (left < -width and right > width):
        far = min((-left).lower(), right.lower()) / width
        raise Refused(f"an image does not reach over the set that it is to cover: {_factor(far)}")
    deep = largest([_rest(image, i, ()) for i in range(2, 6)])
    if not deep < arb(target.chart.eta):
        raise Refused("an image may lie on another sheet of the level")
    stretch = (-left).lower() / width, right.lower() / width
    return Margins(
        float(stretch[0] if stretch[0] < stretch[1] else stretch[1]),
        float(high.upper()),
        float((deep / arb(target.chart.eta)).upper()),
        cone(image, target),
    )


def cone(image: Image, target: HSet) -> float:
    """A lower bound of the determinant of L^T Q L - Q, which is positive definite; or Refused."""
    source = image.source
    across, up = arb(source.width), arb(source.height)
    wide, tall = arb(target.width), arb(target.height)
    a, b = image.slope[0, 0] * across / wide, image.slope[0, 1] * up / wide
    c, d = image.slope[1, 0] * across / tall, image.slope[1, 1] * up / tall
    first, mixed, last = a * a - c * c - 1, a * b - c * d, b * b - d * d + 1
    determinant = first * last - mixed * mixed
    if not (first > 0 and determinant > 0):
        raise Refused("the cone condition does not hold")
    return float(determinant.lower())


def _edge(image: Image, side: int) -> arb:
    """y'_1 of an edge of the source."""
    return image.shift[0, 0] + side * image.turn[0, 0] + arb(0, 1) * _rest(image, 0, (0,), False)


def _rest(image: Image, row: int, without: tuple[int, ...], shift: bool = True) -> arb:
    """A bound of |shift| + the sum of |turn| of a row, but for some columns."""
    found = image.shift[row, 0].abs_upper() if shift else arb(0)
    for j in range(image.turn.ncols()):
        if j not in without:
            found = found + image.turn[row, j].abs_upper()
    return found.upper()


def _factor(x: arb) -> str:
    return f"a factor {float(x.mid()):.3g}"
