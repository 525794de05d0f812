"""Where a sum of Jacobi's functions takes a value: every place in a period, none missed.

In a quarter of the period sn, cn and dn are monotone, so that their values at both ends of a part
bound the sum and its slope there.  A part is halved until one of the two has a sign.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from polhode.closed_forms.functions.jacobi import MP, Jacobi
from polhode.numbers.private import mpmath

_NOISE = 16  # last bits of a sum that are not trusted
_STEPS = 200  # of a bracketed Newton iteration


class Crossing(NamedTuple):
    """A phase u in [0, 4K) where the sum passes the value, and the sum's slope there."""

    u: Any
    slope: Any

    @property
    def rises(self) -> bool:
        """Whether the sum grows through the value."""
        return bool(self.slope > 0)


class _Node(NamedTuple):
    u: Any
    waves: tuple[Any, Any, Any]  # cn, sn, dn
    above: Any  # the sum less the value; 0 where it is not more than noise


def crossings(
    elliptic: Jacobi, row: Sequence[Any], value: Any
) -> tuple[bool, tuple[Crossing, ...]]:
    """Whether row.(cn, sn, dn) >= ``value`` at u = 0+, and where in [0, 4K) that changes.

    A value that is met but not passed is no crossing.
    """
    found = _Crossings(elliptic, row, value)
    places = tuple(found.places())
    if len(places) % 2 or any(a.rises == b.rises for a, b in zip(places, places[1:], strict=False)):
        raise ArithmeticError("places where two terms are equal are too near each other")
    if places:
        return not places[0].rises, places
    return max((node.above for node in found.quarters), key=abs) >= 0, ()


class _Crossings:
    def __init__(self, elliptic: Jacobi, row: Sequence[Any], value: Any) -> None:
        self._elliptic, self._row, self._value = elliptic, row, value
        K = elliptic.K
        self._k2 = 1 - self._waves(K)[2] ** 2
        self.quarters = [self._node(K * n) for n in range(4)]
        self.quarters.append(self.quarters[0]._replace(u=4 * K))

    def places(self) -> Iterator[Crossing]:
        """In order."""
        for one, two in zip(self.quarters, self.quarters[1:], strict=False):
            pending = [(one, two)]
            while pending:
                a, b = pending.pop()
                if self._clear(a, b):
                    continue
                if self._monotone(a, b):
                    if (a.above > 0) != (b.above > 0):
                        yield self._solved(a, b)
                    continue
                middle = self._node((a.u + b.u) / 2)
                pending += [(middle, b), (a, middle)]

    def _waves(self, u: Any) -> tuple[Any, Any, Any]:
        waves = self._elliptic.waves(u, MP)
        sn, cn, dn = self._elliptic.functions(waves)
        return (-cn, -sn, dn) if waves.turns % 2 else (cn, sn, dn)

    def _node(self, u: Any) -> _Node:
        waves = self._waves(u)
        terms = [x * y for x, y in zip(self._row, waves, strict=True)]
        above = sum(terms) - self._value
        noise = mpmath.ldexp(max(abs(x) for x in (*terms, self._value)), _NOISE - mpmath.prec)
        return _Node(u, waves, above if abs(above) > noise else mpmath.zero)

    def _clear(self, a: _Node, b: _Node) -> bool:
        """Whether the sum does not reach the value between two nodes, or is not told from it."""
        low = high = -self._value
        size = abs(self._value)
        for x, p, q in zip(self._row, a.waves, b.waves, strict=True):
            ends = x * p, x * q
            low, high = low + min(ends), high + max(ends)
            size = max(size, *(abs(y) for y in ends))
        noise = mpmath.ldexp(size, _NOISE - mpmath.prec)
        return bool(low > noise or high < -noise or max(high, -low) <= noise)

    def _monotone(self, a: _Node, b: _Node) -> bool:
        low = high = mpmath.zero
        for x, (i, j) in zip(self._slopes, _PAIRS, strict=True):
            ends = [x * p * q for p in (a.waves[i], b.waves[i]) for q in (a.waves[j], b.waves[j])]
            low, high = low + min(ends), high + max(ends)
        return bool(low > 0 or high < 0)

    @property
    def _slopes(self) -> tuple[Any, Any, Any]:
        x, y, z = self._row
        return -x, y, -self._k2 * z

    def _slope(self, waves: tuple[Any, Any, Any]) -> Any:
        pairs = zip(self._slopes, _PAIRS, strict=True)
        return sum(x * waves[i] * waves[j] for x, (i, j) in pairs)

    def _solved(self, a: _Node, b: _Node) -> Crossing:
        """The crossing between two nodes, by Newton's method within ever closer bounds."""
        rises, u = b.above > 0, (a.u + b.u) / 2
        low, high = a.u, b.u
        for _ in range(_STEPS):
            node = self._node(u)
            if (node.above > 0) == rises:
                high = u
            else:
                low = u
            slope = self._slope(node.waves)
            after = u - node.above / slope if slope else low
            if not low < after < high:
                after = (low + high) / 2
            step, u = abs(after - u), after
            if step <= mpmath.ldexp(1 + abs(u), 8 - mpmath.prec) or not node.above:
                break
        return Crossing(u, self._slope(self._waves(u)))


#: sn dn, cn dn, sn cn: the slopes of cn, sn, dn but for their factors -1, 1, -k^2.
_PAIRS = ((1, 2), (0, 2), (1, 0))
