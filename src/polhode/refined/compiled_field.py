"""The field and its derivative as compiled functions of whole arrays: heyoka is the compiler.

The equations are those of :mod:`polhode.equations.terms`, with x = (w1, w2, w3, g1, g2, g3) and
their coefficients k in the order of ``NAMES``.

Four functions of one node each, all of them times the length H of the node's interval.  The body's
constants are parameters, so that one compiled set serves every body.  heyoka neither simplifies
``(x + c) - c`` nor reassociates; tests compare the field with integers, to the bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

from polhode.equations.terms import NAMES, ROWS, SLOPES, Term
from polhode.refined.errors import CannotRefine
from polhode.refined.expansions import Limbs, LimbSums, product
from polhode.taylor.heyoka import hy

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
    names = [f"x{v}{i}" for v in range(VARIABLES) for i in range(n)]
    x = hy.make_vars(*names)
    limbs = _grouped(x, n)
    k = [[hy.par[c * n + i] for i in range(n)] for c in range(COEFFICIENTS + 1)]
    length = k.pop()
    rates = []
    for row in ROWS:
        first, *others = (_value(term, limbs, k, kind) for term in row)  # whose sign is 1
        for term, value in zip(row[1:], others, strict=True):
            first = first + value if term.sign > 0 else first - value
        rates.append(first)
    rows = [_times(rate, length, kind) for rate in rates]
    return hy.cfunc([e for row in rows for e in row], x, compact_mode=n >= _COMPACT_FROM)


def _value(term: Term, limbs: list[list[Any]], k: list[list[Any]], kind: Limbs) -> LimbSums:
    """A term but for its sign."""
    x, *y = (limbs[n] for n in term.factors)
    if term.coefficient is None:
        return product(x, y[0])
    return product(k[term.coefficient], product(x, y[0]).limbs(kind) if y else x)


def _times(rate: LimbSums, length: list[Any], kind: Limbs) -> list[Any]:
    return product(length, rate.limbs(kind)).limbs(kind.shifted(FIELD_SHIFT))


def _grouped(x: list[Any], n: int) -> list[list[Any]]:
    return [x[i : i + n] for i in range(0, len(x), n)]


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
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total
