"""Where a sum of Jacobi's functions takes a value: every place in a period, none missed.

In a quarter of the period sn, cn and dn are monotone, so that their values at both ends of a part
bound the sum and its slope there.  A part is halved until one of the two has a sign.  On the
separatrix, whose period is infinite, the line is cut where the functions are their limits.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from polhode.closed_forms._winding.argument_of_sum import Crossing
from polhode.closed_forms.functions.jacobi import MP, Jacobi
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

_NOISE = 16  # last bits of a sum that are not trusted
_STEPS = 200  # of a bracketed Newton iteration
_POINT = -20  # log2 of the longest part that a touched value may take up


class _Node(NamedTuple):
    u: Scalar
    waves: tuple[Scalar, Scalar, Scalar]  # cn, sn, dn
    above: Scalar  # the sum less the value; 0 where it is not more than noise


def crossings(
    elliptic: Jacobi, row: Sequence[Scalar], value: Scalar
) -> tuple[bool, tuple[Crossing, ...]]:
    """Whether row.(cn, sn, dn) >= ``value`` at first, and where in a period that changes.

    The period is [0, 4K), on the separatrix the whole line.  A value that is met but not passed is
    no crossing.  Raises ArithmeticError where the precision in force does not tell.
    """
    found = _Crossings(elliptic, row, value)
    places = tuple(found.places())
    if mpmath.isfinite(elliptic.K):
        nowhere = not any(node.above for node in found.ends)
        if len(places) % 2 or (found.hidden and not nowhere):
            raise ArithmeticError("two terms are too nearly equal")
    if any(a.rises == b.rises for a, b in itertools.pairwise(places)):
        raise ArithmeticError("two terms are too nearly equal")
    if places:
        return not places[0].rises, places
    return max((node.above for node in found.ends), key=abs) >= 0, ()


class _Crossings:
    def __init__(self, elliptic: Jacobi, row: Sequence[Scalar], value: Scalar) -> None:
        self._elliptic, self._row, self._value = elliptic, row, value
        self.hidden = False  # whether a part of the period lies too near the value to tell
        K = elliptic.K
        if mpmath.isfinite(K):
            self._k2 = 1 - self._waves(K)[2] ** 2
            self.ends = [self._node(K * n) for n in range(4)]
            self.ends.append(self.ends[0]._replace(u=4 * K))
        else:
            self._k2, far = mpmath.one, mpmath.prec * mpmath.ln2
            self.ends = [self._node(far * n) for n in (-1, 0, 1)]

    def places(self) -> list[Crossing]:
        """In order; a place that is not told from the value is passed if its sides differ."""
        found = []
        first = last = self.ends[0]
        for node in self._nodes():
            if last.above and (last.above > 0) != (node.above > 0):
                found.append(self._solved(last, node))
            first, last = first if first.above else node, node
        if mpmath.isfinite(self._elliptic.K) and first.above * last.above < 0:
            found.insert(0, Crossing(mpmath.zero, self._slope(self.ends[0].waves)))
        return found

    def _nodes(self) -> Iterator[_Node]:
        """Ends of parts with no crossing or one, in order, where the sum is not the value."""
        for one, two in itertools.pairwise(self.ends):
            pending = [(one, two)]
            while pending:
                a, b = pending.pop()
                if self._clear(a, b) or self._monotone(a, b):
                    if b.above:
                        yield b
                    continue
                middle = self._node((a.u + b.u) / 2)
                pending += [(middle, b), (a, middle)]

    def _waves(self, u: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        waves = self._elliptic.waves(u, MP)
        sn, cn, dn = self._elliptic.functions(waves)
        return (-cn, -sn, dn) if waves.turns % 2 else (cn, sn, dn)

    def _node(self, u: Scalar) -> _Node:
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
        if max(high, -low) <= noise:
            self.hidden |= bool(b.u - a.u > mpmath.ldexp(1, _POINT))
            return True
        return bool(low > noise or high < -noise)

    def _monotone(self, a: _Node, b: _Node) -> bool:
        low = high = mpmath.zero
        for x, (i, j) in zip(self._slopes, _PAIRS, strict=True):
            ends = [x * p * q for p in (a.waves[i], b.waves[i]) for q in (a.waves[j], b.waves[j])]
            low, high = low + min(ends), high + max(ends)
        return bool(low > 0 or high < 0)

    @property
    def _slopes(self) -> tuple[Scalar, Scalar, Scalar]:
        x, y, z = self._row
        return -x, y, -self._k2 * z

    def _slope(self, waves: tuple[Scalar, Scalar, Scalar]) -> Scalar:
        pairs = zip(self._slopes, _PAIRS, strict=True)
        return sum(x * waves[i] * waves[j] for x, (i, j) in pairs)

    def _solved(self, a: _Node, b: _Node) -> Crossing:
        """The crossing between two nodes, by Newton's method within ever closer bounds."""
        rises, u = b.above > 0, (a.u + b.u) / 2
        low, high = a.u, b.u
        for _ in range(_STEPS):
            node = self._node(u)
            if not node.above:
                break
            if (node.above > 0) == rises:
                high = u
            else:
                low = u
            slope = self._slope(node.waves)
            after = u - node.above / slope if slope else low
            if not low < after < high:
                after = (low + high) / 2
            step, u = abs(after - u), after
            if step <= mpmath.ldexp(1 + abs(u), 8 - mpmath.prec):
                break
        return Crossing(u, self._slope(self._waves(u)))


#: sn dn, cn dn, sn cn: the slopes of cn, sn, dn but for their factors -1, 1, -k^2.
_PAIRS = ((1, 2), (0, 2), (1, 0))
