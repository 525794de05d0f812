"""The field and its derivative as compiled functions of whole arrays: heyoka is the compiler.

The Euler–Poisson equations in principal axes (3.29), with x = (w1, w2, w3, g1, g2, g3):

    w1' = k1 w2 w3 + k4 g2 + k5 g3,
    w2' = k2 w3 w1 + k6 g3 + k7 g1,
    w3' = k3 w1 w2 + k8 g1 + k9 g2,    gamma' = gamma × w,

k1 ... k9 in the order of :data:`polhode.equations.forms.principal.NAMES`.

Four functions of one node each, all of them times the length H of the node's interval.  The body's
constants are parameters, so that one compiled set serves every body.  heyoka neither simplifies
``(x + c) - c`` nor reassociates; :mod:`polhode.refined.self_test` sees to it that it is so here.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

from polhode.refined.expansions import Levels, Limbs, product
from polhode.taylor.backend.engine import hy

VARIABLES = 6
COEFFICIENTS = 9  # and H after them

#: Limbs of H f end two bits higher than those of the state: |H f| <= 4, so the first is as short.
FIELD_SHIFT = 2

_COMPACT_FROM = 7  # limbs from which on the kernel is compiled in heyoka's compact mode


class Kernels(NamedTuple):
    """Compiled functions; arguments and results are rows, one column per node.

    ``field``: 6 L limbs of x -> 6 L limbs of H f(x); parameters 10 L, limbs of k1 ... k9 and H.
    ``push``: x, a, b -> H J(x) (a + b) (6).  ``costate``: x, Y - 1 by rows -> -H Y J(x) (36).
    ``gather``: x, r, Y - 1 -> Y (H J(x) r) (6).  These three in double, parameters k1 ... k9, H.
    """

    field: Any
    push: Any
    costate: Any
    gather: Any


@cache
def kernels(limbs: Limbs) -> Kernels:
    """The compiled set for numbers of this kind; from heyoka's cache on the disk where it can."""
    return Kernels(_field(limbs), _push(), _costate(), _gather())


def _field(kind: Limbs) -> Any:
    n = kind.count
    names = [f"x{v}{i}" for v in range(VARIABLES) for i in range(n)]
    x = hy.make_vars(*names)
    w, g = _grouped(x[: 3 * n], n), _grouped(x[3 * n :], n)
    k = [[hy.par[c * n + i] for i in range(n)] for c in range(COEFFICIENTS + 1)]
    length = k.pop()
    rates = []
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        turning = product(k[a], product(w[b], w[c]).limbs(kind))
        rates.append(turning + product(k[3 + 2 * a], g[b]) + product(k[4 + 2 * a], g[c]))
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        rates.append(product(g[b], w[c]) - product(g[c], w[b]))
    found = [_times(rate, length, kind) for rate in rates]
    return hy.cfunc([e for row in found for e in row], x, compact_mode=n >= _COMPACT_FROM)


def _times(rate: Levels, length: list[Any], kind: Limbs) -> list[Any]:
    return product(length, rate.limbs(kind)).limbs(kind.shifted(FIELD_SHIFT))


def _grouped(x: list[Any], n: int) -> list[list[Any]]:
    return [x[i : i + n] for i in range(0, len(x), n)]


def _names(letter: str, count: int) -> list[str]:
    return [f"{letter}{i:02}" for i in range(count)]


def _jacobian(x: Sequence[Any]) -> dict[tuple[int, int], Any]:
    """The entries of J that are not zero, without H."""
    k = [hy.par[c] for c in range(COEFFICIENTS)]
    w, g = x[:3], x[3:]
    found = {}
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        found[a, b], found[a, c] = k[a] * w[c], k[a] * w[b]
        found[a, 3 + b], found[a, 3 + c] = k[3 + 2 * a], k[4 + 2 * a]
        # g_a' = g_b w_c - g_c w_b
        found[3 + a, 3 + b], found[3 + a, 3 + c] = w[c], -w[b]
        found[3 + a, b], found[3 + a, c] = -g[c], g[b]
    return found


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
    found = [
        _added([row[i] * entry for (i, j), entry in entries.items() if j == column])
        for row in _with_one(y)
        for column in range(VARIABLES)
    ]
    return hy.cfunc(found, [*x, *y])


def _gather() -> Any:
    x, r = (hy.make_vars(*_names(letter, VARIABLES)) for letter in "xr")
    y = hy.make_vars(*_names("y", VARIABLES**2))
    pushed = _pushed(x, r)
    found = [_added([a * b for a, b in zip(row, pushed, strict=True)]) for row in _with_one(y)]
    return hy.cfunc(found, [*x, *r, *y])


def _with_one(y: list[Any]) -> list[list[Any]]:
    """The rows of 1 + y."""
    return [
        [y[VARIABLES * i + j] + 1.0 if i == j else y[VARIABLES * i + j] for j in range(VARIABLES)]
        for i in range(VARIABLES)
    ]


def _added(terms: list[Any]) -> Any:
    found = terms[0]
    for term in terms[1:]:
        found = found + term
    return found
