"""A variable that goes to and fro between two branch points, by an angle that grows for ever.

Points of the line, infinity among them, are s = S/z with [a, b] = S_a z_b - S_b z_a.  Between u and
v, with ka > 0 of which nothing depends,

    (S, z) = cos^2(x/2) u + ka sin^2(x/2) v,    [s, u] = ka sin^2(x/2) [v, u],
    [s, v] = cos^2(x/2) [u, v],    ds = ka [v, u] sin x dx/2z^2.

So of w^2 = -2 times the product of all [s, a], over z^6, two factors are known, and of ds/w the
rest remains, which has no zeros.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from polhode.closed_forms.textbook.periodic import PeriodicIntegral
from polhode.numbers.mpmath_context import mpc, mpf, mpmath

#: S and z of a point S/z, which may be infinity.
Point: TypeAlias = tuple[Any, Any]


class Cycle:
    """One separation variable between the branch points ``u`` and ``v``, of all those ``points``.

    ds/w has the sign of [v, u] where w > 0 on the way from u to v.
    """

    def __init__(self, u: Point, v: Point, points: Sequence[Point]) -> None:
        self._u, self._v = u, v
        self._others = [a for a in points if a not in (u, v)]
        self._wide = _bracket(v, u)
        ratios = [_bracket(u, a) / _bracket(v, a) for a in self._others]
        sizes = [*map(abs, ratios)]
        # [s, a] = 0 where tan^2(x/2) = -ratio/ka: the nearest of these x is then farthest away
        self._balance = mpmath.sqrt(min(sizes) * max(sizes))
        zeros = [2 * mpmath.atan(mpmath.sqrt(-ratio / self._balance)) for ratio in ratios]
        #: ds/w, and s ds/w as its imaginary part, from x = 0.
        self.sums = PeriodicIntegral(self.rate, min(abs(mpmath.im(x)) for x in zeros))

    def point(self, x: mpf) -> Point:
        """s at an angle."""
        one, two = mpmath.cos(x / 2) ** 2, self._balance * mpmath.sin(x / 2) ** 2
        return one * self._u[0] + two * self._v[0], one * self._u[1] + two * self._v[1]

    def rate(self, x: mpf) -> mpc:
        """ds/w, and s ds/w as its imaginary part, over dx."""
        s, z = self.point(x)
        size = mpmath.sqrt(self._balance / (2 * self._rest((s, z))))
        return mpmath.sign(self._wide) * size * mpc(z, s)

    def w(self, x: mpf) -> mpf:
        """w z at an angle."""
        point = self.point(x)
        size = mpmath.sqrt(2 * self._balance * self._rest(point))
        return abs(self._wide) * size * mpmath.sin(x) / (2 * point[1] ** 2)

    def root(self, a: Point, x: mpf) -> Any:
        """A square root of [s, a] or its opposite, without a jump; of either sign at an end."""
        if a == self._u:
            return mpmath.sqrt(self._balance * abs(self._wide)) * mpmath.sin(x / 2)
        if a == self._v:
            return mpmath.sqrt(abs(self._wide)) * mpmath.cos(x / 2)
        return mpmath.sqrt(mpmath.sign(self._wide) * _bracket(self.point(x), a))

    def angle(self, s: Point, side: mpf) -> mpf:
        """The angle of a point; ``side`` has the sign of w there."""
        low, high = (mpmath.sqrt(abs(_bracket(s, end))) for end in (self._u, self._v))
        x = 2 * mpmath.atan2(low, high * mpmath.sqrt(self._balance))
        return x if side >= 0 else -x

    def _rest(self, point: Point) -> mpf:
        """The product of all [s, a] but those of the ends."""
        return mpmath.re(mpmath.fprod(_bracket(point, a) for a in self._others))


def _bracket(a: Point, b: Point) -> Any:
    return a[0] * b[1] - b[0] * a[1]
