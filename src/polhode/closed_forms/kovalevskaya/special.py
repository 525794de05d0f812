"""The special motions of a Kovalevskaya top, and degenerate curves, that another is near to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import Condition, equal, missing, positive
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart, top_axes
from polhode.closed_forms.kovalevskaya.curve import Unresolved, branch_points
from polhode.closed_forms.kovalevskaya.regimes import (
    APPELROT,
    DELAUNAY,
    ONE_FREQUENCY,
    STEADY,
    discriminant,
    passes_poles,
    regime,
)
from polhode.numbers.conversion import exact_number
from polhode.numbers.exact import ZERO, Exact, sign, sqrt
from polhode.numbers.mpmath_context import mpmath
from polhode.scenes.body import dot

_MOST_BITS = 1 << 15


def special(scene: PrincipalScene) -> Iterator[tuple[str, Misfit | None]]:
    """Each special motion and by how much this one misses it.

    Symbols as in :mod:`.axes` and :mod:`.regimes`.  w^2 and G are relative to the larger of w^2 at
    the start and n^2; distances of branch points are relative to the largest.
    """
    if scene.gamma is None:
        return
    start = top_axes(scene.moments, scene.torque, None).start(scene.omega, scene.gamma)
    kind = regime(start)
    if kind in STEADY:
        return
    size = max(dot(start.omega, start.omega), start.weight)
    yield DELAUNAY, missing(equal("(p + iq)^2 = G1 + iG2", sqrt(start.k2), ZERO, size))
    if kind != APPELROT:
        misses = [missing(*_appelrot(start, xh, size)) for xh in _centres(start)]
        found = [miss for miss in misses if miss is not None and miss.worst is not None]
        yield APPELROT, min(found, key=lambda miss: miss.worst or ZERO, default=None)
    if kind in ONE_FREQUENCY:
        return
    if not passes_poles(start):
        yield "degenerate curve", missing(Condition("an e is k or -k", _gap(start, _AT_K)))
    if sign(discriminant(start)) != 0:
        yield "degenerate curve", missing(Condition("two of e1, e2, e3 are equal", _gap(start, _E)))


#: Pairs of the points e1, e2, e3, k, -k.
_AT_K = tuple((i, j) for i in range(3) for j in (3, 4))
_E = ((0, 1), (1, 2), (2, 0))


def _gap(start: KovalevskayaStart, pairs: Sequence[tuple[int, int]]) -> Exact:
    """The least distance of two of the curve's branch points, over the largest of the five."""
    prec = 128
    while prec <= _MOST_BITS:
        with mpmath.workprec(prec):
            points = branch_points(start, prec)
            largest = max(abs(x) for x in points)
            least = min(abs(points[i] - points[j]) for i, j in pairs) / largest
            if least > mpmath.ldexp(1, -prec // 3):
                return exact_number(least)
        prec *= 2
    raise Unresolved


def _centres(start: KovalevskayaStart) -> Iterator[Exact]:
    """What the constant G3/r of Appelrot's motion may be, from either way to find it."""
    (p, q, r), (G1, G2, G3) = start.omega, start.G
    if sign(r) != 0:
        yield G3 / r
    if sign(G2) != 0:
        yield p - G1 * q / G2


def _appelrot(start: KovalevskayaStart, xh: Exact, size: Exact) -> Iterator[Condition]:
    """r xh = G3 and G1 + iG2 = 2 xh (1 + xh (p - xh)/ro^2)(p - xh + iq), times ro^2."""
    (p, q, r), (G1, G2, G3) = start.omega, start.G
    x = p - xh
    ro2 = x * x + q * q
    factor = 2 * xh * (ro2 + xh * x)
    yield equal("G3 = r xh", G3, r * xh, size)
    both = size * ro2 + abs(factor) * sqrt(ro2)
    yield positive("ro > 0", ro2)
    if sign(ro2) != 0:
        yield equal("ro^2 G1 = 2 xh (ro^2 + xh (p - xh)) (p - xh)", G1 * ro2, factor * x, both)
        yield equal("ro^2 G2 = 2 xh (ro^2 + xh (p - xh)) q", G2 * ro2, factor * q, both)
