"""The Gauss tables as the sweeps use them: as limbs, level by level, and in double."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from polhode.numbers.rows import Doubles
from polhode.refined.compiled_field import FIELD_SHIFT
from polhode.refined.errors import CannotRefine
from polhode.refined.expansions import Limbs
from polhode.refined.gauss_legendre import Gauss, gauss

LARGEST_FIELD = 4.0  # of |H f|, for which the products below are exact
_TABLE_BITS = 64  # beyond the limbs' own

#: The rows that give Legendre coefficients are kept this much smaller, to be as short as the rest.
_SMALLER = 6


@dataclass(frozen=True, eq=False)
class Tables:
    """For M fine and Mc coarse nodes on each interval; arrays in double unless said otherwise.

    ``levels``: for index sums l = 2 ... L, [A_{l-1} ... A_1] of the limbs A_i of the rows of
    :attr:`rows`; ``tail``: [suffix sums of the limbs, the last one first].
    ``nodes``: c_j; ``weights``: b_j; ``integrals``: A.
    ``coarse``: integrals from the middle over coarse nodes, at coarse nodes, (Mc, Mc); ``fine``:
    the same at the M fine nodes and both ends, (M + 2, Mc); ``thinned``: values at the coarse
    nodes from those at the fine ones, (Mc, M).
    """

    nodes: Doubles
    weights: Doubles
    integrals: Doubles
    levels: tuple[Doubles, ...]
    tail: Doubles
    coarse: Doubles
    fine: Doubles
    thinned: Doubles

    def integrated(self, field: Doubles, count: int | None = None) -> list[Doubles]:
        """All rows times H f: field (6, L, M, N) in limbs -> levels 2 to L, tail: (6, M + 3, N).

        Rows 0 to M - 1: from the interval's start to a node; M: to its end; M + 1 and M + 2: the
        last two Legendre coefficients of H f, times 2**-6.  The levels are exact, in whatever
        order they are summed: :func:`tables` has checked the bound.  ``count``: so many of them
        alone, the tail counted; what is left out is 2**-(B count) in size.
        """
        variables, limbs, nodes, n = field.shape
        wanted = limbs if count is None else min(count, limbs)
        found = [
            np.matmul(table, field[:, : i + 1].reshape(variables, (i + 1) * nodes, n))
            for i, table in enumerate(self.levels[:wanted])
        ]
        if wanted == limbs:
            whole = field.reshape(variables, limbs * nodes, n)
            found.append(np.matmul(self.tail, whole))
        return found

    @staticmethod
    def last_coefficients(levels: list[Doubles]) -> Doubles:
        """The larger of the last two Legendre coefficients of H f, over all components, (N,)."""
        rows = levels[-1][:, -2:].copy()
        for level in reversed(levels[:-1]):
            rows += level[:, -2:]
        found: Doubles = np.abs(rows).max(axis=(0, 1)) * 2.0**_SMALLER
        return found


@cache
@cache
def tables(limbs: Limbs, count: int) -> Tables:
    """The tables for ``count`` fine nodes; raises CannotRefine where there are too many."""
    bits = limbs.finest + _TABLE_BITS
    table = gauss(count, bits)
    one = Fraction(1, 1 << bits)
    last = [
        [
            (2 * k + 1) * (table.weights[i] * table.legendre[i][k] >> bits) >> _SMALLER
            for i in range(count)
        ]
        for k in (count - 2, count - 1)
    ]
    # two bits lower than the state's, as the field's are two bits higher: levels fit together
    kind = limbs.shifted(-FIELD_SHIFT)
    split = np.array(
        [[kind.split(x * one) for x in row] for row in (*table.integrals, *last)]
    )  # (M + 3, M, L)
    _check(split, limbs)
    levels = tuple(
        np.concatenate([split[:, :, i] for i in range(top, -1, -1)], axis=1)
        for top in range(limbs.count - 1)
    )
    suffix = np.cumsum(split[:, :, ::-1], axis=2)  # smallest first
    tail = np.concatenate([suffix[:, :, i] for i in range(limbs.count)], axis=1)
    double = np.array([[float(x * one) for x in row] for row in table.integrals])
    coarse, fine, thinned = _middle(table, gauss(count // 2, bits))
    return Tables(
        (np.array([float(x * one) for x in table.nodes]) + 1) / 2,
        double[-1].copy(),
        double[:-1].copy(),
        levels,
        tail,
        coarse,
        fine,
        thinned,
    )


def _check(split: Doubles, limbs: Limbs) -> None:
    """Refuse a table whose products could be inexact: sums of absolute values above 2**53 units."""
    for total in range(2, limbs.count + 1):
        bound = 0.0
        for i in range(1, total):
            j = total - i
            field = limbs.shifted(FIELD_SHIFT)
            largest = LARGEST_FIELD if j == 1 else 2.0 ** -(field.place(j - 1) + 1)
            bound = bound + np.abs(split[:, :, i - 1]).sum(axis=1).max() * largest
        if bound * 2.0 ** (limbs.width * total) >= 2.0**53:
            raise CannotRefine(
                f"{split.shape[1]} nodes are too many for limbs of {limbs.width} bits"
            )


def _middle(table: Gauss, coarse: Gauss) -> tuple[Doubles, Doubles, Doubles]:
    """Integrals from the middle over coarse nodes, at coarse and fine ones; and interpolation."""
    scale = 2.0**-table.bits
    x, fine_p = _doubles(table.nodes, scale), _doubles(table.legendre, scale)
    xc, coarse_p = _doubles(coarse.nodes, scale), _doubles(coarse.legendre, scale)
    b, bc = _doubles(table.weights, scale), _doubles(coarse.weights, scale)
    n = len(xc)

    def integrals(points: Doubles, p: Doubles) -> Doubles:
        d = p[:, 2 : n + 1] - p[:, : n - 1]  # D_k, k = 1 ... n - 1
        zero = _at_zero(n)
        d = d - (zero[2 : n + 1] - zero[: n - 1])
        return (points[:, None] + d @ coarse_p[:, 1:n].T) * (bc / 2)

    ends = np.array([-1.0, 1.0])
    ends_p = ends[:, None] ** np.arange(n + 1)
    everywhere = np.concatenate([x, ends]), np.concatenate([fine_p[:, : n + 1], ends_p])
    k = np.arange(len(x))
    thinned = (_legendre(xc, len(x)) * (2 * k + 1)) @ (fine_p[:, : len(x)].T * b)
    return integrals(xc, coarse_p), integrals(*everywhere), thinned


def _doubles(values: Any, scale: float) -> Doubles:
    if isinstance(values[0], tuple):
        return np.array([[float(x) * scale for x in row] for row in values])
    return np.array([float(x) * scale for x in values])


def _legendre(x: Doubles, count: int) -> Doubles:
    """P_0 ... P_{count-1} at points, one row per point."""
    found = [np.ones_like(x), x]
    for k in range(1, count - 1):
        found.append(((2 * k + 1) * x * found[k] - k * found[k - 1]) / (k + 1))
    return np.stack(found[:count], axis=1)


def _at_zero(count: int) -> Doubles:
    """P_0(0) ... P_count(0)."""
    found: Doubles = _legendre(np.zeros(1), count + 1)[0]
    return found
