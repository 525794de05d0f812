"""The branch points of the Kovalevskaya curve in balls, their type and their order.

    w^2 = -2 (s^2 - k^2) S(s),    S(s) = (s + H)(s^2 + b) - 2m^2 = (s - e1)(s - e2)(s - e3)

(Kowalevski 1889; symbols as in :mod:`polhode.closed_forms.kovalevskaya.axes`), with the finite
branch points e1, e2, e3, k, -k and the sixth at infinity.  How many e's are real is decided by the
exact discriminant.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable, Sequence
from functools import cmp_to_key
from itertools import combinations, pairwise
from typing import TypeVar

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits, ball, either_root, root
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.numbers.exact import Exact, sign
from polhode.numbers.flint_context import ctx

T = TypeVar("T")

_TILTS = 31  # directions tried
_FIRST_BITS, _MOST_BITS = 128, 1 << 15


def discriminant(start: KovalevskayaStart) -> Exact:
    """disc S; S = s^3 + H s^2 + c s + d."""
    H, c = start.H, start.b
    d = H * c - 2 * start.m2
    return 18 * H * c * d - 4 * H * H * H * d + H * H * c * c - 4 * c * c * c - 27 * d * d


def branch_points(start: KovalevskayaStart, disc: Exact | None = None) -> list[acb]:
    """e1, e2, e3, k and -k at the precision in force; ``disc``: the discriminant, if known.

    The real e's are in ascending order; of a conjugate pair the one above the axis is first.
    """
    disc = discriminant(start) if disc is None else disc
    H, b, m2 = ball(start.H), ball(start.b), ball(start.m2)
    shift = H / 3
    p = b - H * shift
    q = 2 * shift * shift * shift - shift * b + H * b - 2 * m2
    if sign(disc) > 0:
        size = 2 * (-p / 3).sqrt()
        angle = arb.atan2((ball(disc) / 27).sqrt(), -q) / 3
        third = 2 * arb.pi() / 3
        e = [acb(size * (angle - third * n).cos() - shift) for n in (2, 1, 0)]
    else:
        # The larger of Cardano's two cube roots, which is no difference.
        side = 1 if q.mid() > 0 else -1
        cube = side * q / 2 + (ball(-disc) / 108).sqrt()
        if not cube > 0:
            raise TooFewBits
        u = -side * cube.root(3)
        v = -p / (3 * u)
        pair = acb(-(u + v) / 2 - shift, abs(u - v) * arb(3).sqrt() / 2)
        e = [acb(u + v - shift), pair, pair.conjugate()]
    k = root(start.k2)
    return [*e, acb(k), acb(-k)]


def square_roots(e: acb, H: arb, m: arb, b: arb) -> tuple[acb, acb]:
    """f and g at a root e of S: f^2 = e^2 + b, g^2 = 2 (e + H), f g = 2m, of either sign.

    The larger one by its root.
    """
    f, g = e * e + b, 2 * (e + H)
    if abs(f).mid() > abs(g).mid():
        f = either_root(f)
        return f, 2 * m / f
    g = either_root(g)
    return 2 * m / g, g


def kind(start: KovalevskayaStart) -> str:
    """The type of a curve with five different finite branch points: their order on the real line.

    "-" and "+" are the points -k and k, "e" a root of S.
    """
    disc = discriminant(start)
    names = "eee+-" if sign(disc) > 0 else "e  +-"

    def order() -> str:
        points = branch_points(start, disc)
        values = [x.real for x in points]
        line = ascending(values, [i for i, name in enumerate(names) if name != " "])
        if not all(values[i] < values[j] for i, j in pairwise(line)):
            raise TooFewBits
        return "".join(names[i] for i in line)

    return _decided(order) + ("" if sign(disc) > 0 else " (complex pair)")


def _decided(question: Callable[[], T]) -> T:
    """An answer that more bits will prove."""
    bits = _FIRST_BITS
    while True:
        try:
            with ctx.workprec(bits):
                return question()
        except TooFewBits:
            bits *= 2
            if bits > _MOST_BITS:
                raise


def ascending(values: Sequence[arb], numbers: Iterable[int]) -> list[int]:
    """The numbers in the order of the middles of their values; nothing is proven of it."""

    def compare(i: int, j: int) -> int:
        return -1 if values[i].mid() < values[j].mid() else 1

    return sorted(numbers, key=cmp_to_key(compare))


def numbered(points: Sequence[acb]) -> list[int]:
    """The order of the points along exp(i tilt), |tilt| < pi/2, proven.

    The tilt is 0 if all are real, else the one with the largest least gap.  Each square root of a
    difference is then continuous between neighbours.
    """
    tilt = 0.0
    if not all(x.imag.is_zero() for x in points):
        gaps = [complex(x - y) for x, y in combinations(points, 2)]
        tilts = [math.pi * (n / (_TILTS + 1) - 0.5) for n in range(1, _TILTS + 1)]
        tilt = max(tilts, key=lambda a: min(abs((cmath.rect(1, -a) * g).real) for g in gaps))
    turn = acb(0, -tilt).exp()
    along = [(turn * x).real for x in points]
    # By balls, not by doubles: gaps of 1e-26 are told apart.
    order = ascending(along, range(len(points)))
    if not all((turn * (points[j] - points[i])).real > 0 for i, j in pairwise(order)):
        raise TooFewBits
    return order
