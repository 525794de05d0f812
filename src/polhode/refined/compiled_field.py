"""Numbers as sums of a few doubles, and the field of the equations compiled for them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from polhode.equations.terms import NAMES, ROWS, SLOPES, Term
from polhode.motion.outcomes import CannotSolve
from polhode.numbers.number_types import Doubles
from polhode.taylor.heyoka import hy

# --- what a refinement may meet -------------------------------------------------------------------


class CannotRefine(CannotSolve):
    """A run that cannot be refined; the message says why.  Take heyoka's own steps instead."""


class Stalled(CannotRefine):
    """Sweeps that do not converge; with more limbs, whose noise is less, they may."""


class TooFarOff(Exception):
    """The run in double has drifted too far within a block; ``good``: intervals still near."""

    def __init__(self, good: int) -> None:
        super().__init__(f"only {good} intervals are near")
        self.good = good


class IntervalsTooLong(Exception):
    """Some intervals of a block are too long; ``which``: a mask of its intervals."""

    def __init__(self, which: Any) -> None:
        super().__init__(f"{int(which.sum())} intervals are too long")
        self.which = which


# --- expansions -----------------------------------------------------------------------------------
#
# Numbers as sums of a few doubles, and the places in them at which rounding happens.
#
# x = x1 + x2 + ... + xL.  Every limb but the last is an integer multiple of 2**-(B i - shift), i
# counted from 1, and at most half of the unit of the limb before it: limbs have B bits with their
# sign.  The last limb is any double, at most half a unit of the limb before.
#
# Products of limbs of short length are exact in double, and so are sums of many of them: that is
# what all of this is for.  What bounds make it so stands beside each line that relies on it.
#
# The functions here work on Python floats, numpy arrays and heyoka's expressions alike, by
# ``+ - *`` alone, and rely on each operation being rounded on its own, to nearest, as IEEE 754 has
# it.


_LAST = 54  # bits kept of the last limb: at most half a unit of the one before, so 53 of its own


@dataclass(frozen=True)
class Limbs:
    """How many limbs, of how many bits, and how many bits higher than 2**-B the first one ends."""

    count: int
    width: int
    shift: int = 0

    def place(self, i: int) -> int:
        """The exponent p of the unit 2**-p of limb i, counted from 1."""
        return self.width * i - self.shift

    @property
    def bits(self) -> int:
        """Bits behind the point to which products are right.

        They neglect what has an index sum above count + 2, 2**-(width·(count + 1)) and less.
        """
        return self.width * (self.count + 1) - 4

    @property
    def finest(self) -> int:
        """Bits behind the point at which numbers are cut when split."""
        return self.place(self.count - 1) + _LAST

    def shifted(self, by: int) -> Limbs:
        """Limbs that end so many bits higher."""
        return Limbs(self.count, self.width, self.shift + by)

    def split(self, x: Fraction) -> list[float]:
        """The limbs of a rational, rounded to ``finest`` bits behind the point."""
        return self.split_integer(_nearest(x.numerator << self.finest, x.denominator))

    def split_integer(self, whole: int) -> list[float]:
        """The limbs of whole·2**-finest."""
        limbs, finest = [], self.finest
        for i in range(1, self.count):
            place = self.place(i)
            below = finest - place
            limb = (whole + (1 << (below - 1))) >> below
            limbs.append(limb * 2.0**-place)
            whole -= limb << below
        return [*limbs, whole * 2.0**-finest]

    def value(self, limbs: Iterable[float]) -> Fraction:
        """The exact sum of limbs."""
        return sum((Fraction(float(x)) for x in limbs), Fraction(0))

    def integer(self, limbs: Iterable[float]) -> int:
        """The sum of limbs in units of 2**-finest; of the last one, what is below is dropped."""
        unit = 2.0**self.finest
        return sum([int(x * unit) for x in limbs])

    def renormalised(self, x: Doubles) -> Doubles:
        """Numbers of which adjustments have made the limbs too long, (n, L), as they should be."""
        return np.array([self.split_integer(self.integer(row)) for row in x.tolist()])

    def split_doubles(self, x: Doubles) -> Doubles:
        """The limbs of an array of doubles, exactly, along a new first axis."""
        limbs, rest = [], x
        for i in range(1, self.count):
            limb = rounded(rest, self.place(i))
            rest = rest - limb  # exact: limb is the head of rest
            limbs.append(limb)
        return np.stack([*limbs, rest])

    def adjust(self, x: Doubles, small: Doubles) -> None:
        """Add small doubles, less than a unit of the first limb, to numbers whose limbs are the
        rows of x; in place.  Exact but for the last limb's rounding."""
        rest = x[-1] + small
        for i in range(2, self.count):
            head = rounded(rest, self.place(i))
            x[i - 1] += head  # both multiples of the same unit, and short
            rest = rest - head
        x[-1] = rest


def rounded(v: Any, place: int) -> Any:
    """v to the nearest multiple of 2**-place, for |v| < 2**(51 - place).

    v + c lies where doubles are 2**-place apart, so the sum is v rounded, and c taken away again
    leaves no error.
    """
    c = 1.5 * 2.0 ** (52 - place)
    return (v + c) - c


class LimbSums:
    """A sum of products of limbs before it is one number: by the sum of the limbs' indices.

    ``exact``: the sums for index sums 2 to L, each exact.  ``tail``: what index sums L + 1 and
    L + 2 add up to, in double.  Those above are neglected.
    """

    def __init__(self, exact: list[Any], tail: Any) -> None:
        self.exact, self.tail = exact, tail

    def __add__(self, other: LimbSums) -> LimbSums:
        pairs = zip(self.exact, other.exact, strict=True)
        return LimbSums([a + b for a, b in pairs], self.tail + other.tail)

    def __sub__(self, other: LimbSums) -> LimbSums:
        pairs = zip(self.exact, other.exact, strict=True)
        return LimbSums([a - b for a, b in pairs], self.tail - other.tail)

    def limbs(self, kind: Limbs) -> list[Any]:
        """The number again as limbs.

        Each remainder is a multiple of the next level's unit and, its head being taken away, as
        short as that level: the sums below are exact, up to the tail's.
        """
        rest, limbs = self.exact[0], []
        for i, following in enumerate([*self.exact[1:], self.tail], start=1):
            limb = rounded(rest + following, kind.place(i))
            rest = (rest - limb) + following
            limbs.append(limb)
        return [*limbs, rest]


def product(x: Sequence[Any], y: Sequence[Any]) -> LimbSums:
    """x·y by levels.

    A level of index sum l is a sum of l - 1 products, each a multiple of 2**-(B l) of at most
    2 B - 1 bits, and a bit or two more where a factor is larger than 1.
    """
    count = len(x)
    exact = [_sum(x, y, total) for total in range(2, count + 1)]
    return LimbSums(exact, _sum(x, y, count + 2) + _sum(x, y, count + 1))


def _sum(x: Sequence[Any], y: Sequence[Any], total: int) -> Any:
    """The sum of x_i y_j, i + j = total, counted from 1."""
    count = len(x)
    indices = range(max(1, total - count), min(count, total - 1) + 1)
    return _added([x[i - 1] * y[total - i - 1] for i in indices])


def _nearest(top: int, bottom: int) -> int:
    """The integer nearest to top/bottom, bottom > 0."""
    return (2 * top + bottom) // (2 * bottom)


# --- compiled field -------------------------------------------------------------------------------
#
# The field and its derivative as compiled functions of whole arrays: heyoka is the compiler.
#
# The equations are those of :mod:`polhode.equations.terms`, with x = (w1, w2, w3, g1, g2, g3) and
# their coefficients k in the order of ``NAMES``.
#
# Four functions of one node each, all of them times the length H of the node's interval.  The
# body's constants are parameters, so that one compiled set serves every body.  heyoka neither
# simplifies ``(x + c) - c`` nor reassociates; tests compare the field with integers, to the bit.


VARIABLES = len(ROWS)
COEFFICIENTS = len(NAMES)  # and H after them

#: Limbs of H f end two bits higher than those of the state: |H f| <= 4, so the first is as short.
FIELD_SHIFT = 2

_COMPACT_FROM = 7  # limbs from which on the kernel is compiled in heyoka's compact mode


class Kernels(NamedTuple):
    """Compiled functions; arguments and results are rows, one column per node.

    ``field``: 6 L limbs of x -> 6 L limbs of H f(x); parameters limbs of the k, and of H.
    ``push``: x, a, b -> H J(x) (a + b) (6).  ``costate``: x, Y - 1 by rows -> -H Y J(x) (36).
    ``gather``: x, r, Y - 1 -> Y (H J(x) r) (6).  These three in double, parameters k, H.
    """

    field: Any
    push: Any
    costate: Any
    gather: Any


@cache
def kernels(limbs: Limbs) -> Kernels:
    """The compiled set for numbers of this kind; from heyoka's cache on the disk where it can.

    Raises CannotRefine where it cannot be compiled.
    """
    try:
        return Kernels(_field(limbs), _push(), _costate(), _gather())
    except (RuntimeError, ValueError) as fault:
        raise CannotRefine(f"the field cannot be compiled: {fault}") from None


def _field(kind: Limbs) -> Any:
    n = kind.count
    x = hy.make_vars(*(f"x{v}{i}" for v in range(VARIABLES) for i in range(n)))
    limbs = [x[i : i + n] for i in range(0, len(x), n)]
    k = [[hy.par[c * n + i] for i in range(n)] for c in range(COEFFICIENTS + 1)]
    length = k.pop()
    rates = []
    for row in ROWS:
        first, *others = (_value(term, limbs, k, kind) for term in row)  # whose sign is 1
        for term, value in zip(row[1:], others, strict=True):
            first = first + value if term.sign > 0 else first - value
        rates.append(first)
    rows = over_intervals(rates, length, kind)
    return hy.cfunc([e for row in rows for e in row], x, compact_mode=n >= _COMPACT_FROM)


def _value(term: Term, limbs: list[list[Any]], k: list[list[Any]], kind: Limbs) -> LimbSums:
    """A term but for its sign."""
    x, *y = (limbs[n] for n in term.factors)
    if term.coefficient is None:
        return product(x, y[0])
    return product(k[term.coefficient], product(x, y[0]).limbs(kind) if y else x)


def over_intervals(rates: list[LimbSums], length: list[Any], kind: Limbs) -> list[list[Any]]:
    """Rates times the length H of the interval, in limbs."""
    shifted = kind.shifted(FIELD_SHIFT)
    return [product(length, rate.limbs(kind)).limbs(shifted) for rate in rates]


def _names(letter: str, count: int) -> list[str]:
    return [f"{letter}{i:02}" for i in range(count)]


def _jacobian(x: Sequence[Any]) -> dict[tuple[int, int], Any]:
    """The entries of J that are not zero, without H."""
    entries: dict[tuple[int, int], Any] = {}
    for row, column, term, factor in SLOPES:
        if term.coefficient is None:
            assert factor is not None
            value = x[factor] if term.sign > 0 else -x[factor]
        else:
            value = hy.par[term.coefficient]
            value = value if factor is None else value * x[factor]
        at = row, column
        entries[at] = entries[at] + value if at in entries else value
    return entries


def _pushed(x: Sequence[Any], e: Sequence[Any]) -> list[Any]:
    """H J(x) e."""
    length = hy.par[COEFFICIENTS]
    entries = _jacobian(x)
    return [
        length * _added([entry * e[j] for (i, j), entry in entries.items() if i == row])
        for row in range(VARIABLES)
    ]


def _push() -> Any:
    x, a, b = (hy.make_vars(*_names(letter, VARIABLES)) for letter in "xab")
    return hy.cfunc(_pushed(x, [p + q for p, q in zip(a, b, strict=True)]), [*x, *a, *b])


def _costate() -> Any:
    x, y = hy.make_vars(*_names("x", VARIABLES)), hy.make_vars(*_names("y", VARIABLES**2))
    length = -hy.par[COEFFICIENTS]
    entries = {at: length * entry for at, entry in _jacobian(x).items()}
    sums = [
        _added([row[i] * entry for (i, j), entry in entries.items() if j == column])
        for row in _with_one(y)
        for column in range(VARIABLES)
    ]
    return hy.cfunc(sums, [*x, *y])


def _gather() -> Any:
    x, r = (hy.make_vars(*_names(letter, VARIABLES)) for letter in "xr")
    y = hy.make_vars(*_names("y", VARIABLES**2))
    pushed = _pushed(x, r)
    sums = [_added([a * b for a, b in zip(row, pushed, strict=True)]) for row in _with_one(y)]
    return hy.cfunc(sums, [*x, *r, *y])


def _with_one(y: list[Any]) -> list[list[Any]]:
    """The rows of 1 + y."""
    return [
        [y[VARIABLES * i + j] + 1.0 if i == j else y[VARIABLES * i + j] for j in range(VARIABLES)]
        for i in range(VARIABLES)
    ]


def _added(terms: list[Any]) -> Any:
    return sum(terms[1:], terms[0])  # from no 0, which an expression would keep
