"""The Gauss tables as the sweeps use them: as limbs, level by level, and in double."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from flint import arb

from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Doubles
from polhode.numbers.polynomials import middle
from polhode.refined.compiled_field import FIELD_SHIFT, CannotRefine, Limbs

# --- gauss legendre -------------------------------------------------------------------------------
#
# Gauss–Legendre nodes and the integrals of their Lagrange polynomials, to any number of bits.
#
# x_i the nodes on [-1, 1], P_k the Legendre polynomials, c = (x + 1)/2, b_i the weights on [0, 1].
# With D_k = P_{k+1} - P_{k-1}, (2k + 1) times the integral of P_k from -1,
#
#     A_ji = integral of l_i from 0 to c_j = b_i/2 [x_j + 1 + sum_{k=1}^{M-1} P_k(x_i) D_k(x_j)].
#
# All in integers, so many bits behind the point; Hairer, Wanner, Solving ODEs II, IV.5, has the
# collocation method that A and b make.


_GUARD = 24  # bits: products are cut, and M² of them enter a sum


@dataclass(frozen=True)
class Gauss:
    """The table of M nodes; integers, ``bits`` behind the point.

    ``nodes``: x_i, ascending.  ``weights``: b_i.  ``integrals``: M + 1 rows, A_ji and last b_i.
    ``legendre``: row i holds P_0(x_i) ... P_M(x_i).
    """

    bits: int
    nodes: tuple[int, ...]
    weights: tuple[int, ...]
    integrals: tuple[tuple[int, ...], ...]
    legendre: tuple[tuple[int, ...], ...]


@cache
def gauss(count: int, bits: int) -> Gauss:
    """The table of ``count`` nodes, every entry right to its last bits."""
    fine = bits + _GUARD
    unit = 1 << fine
    with ctx.workprec(fine + _GUARD):  # the zeros from 1 down to 0
        upper = [int(middle(arb.legendre_p_root(count, k)) * unit) for k in range(count // 2)]
    nodes = [-x for x in upper] + [0] * (count % 2) + upper[::-1]
    legendre = [_exact_legendre(x, count, fine) for x in nodes]
    weights = []
    for x, p in zip(nodes, legendre, strict=True):
        # b = (1 - x²)/(M P_{M-1})², half the weight on [-1, 1]
        scale = count * p[count - 1]
        weights.append(((unit * unit - x * x) << fine) // (scale * scale))
    rows = []
    for j in range((count + 1) // 2):
        p, x = legendre[j], nodes[j]
        d = [p[k + 1] - p[k - 1] for k in range(1, count)]
        row = []
        for i in range(count):
            total = sum(map(int.__mul__, legendre[i][1:count], d)) >> fine
            row.append((weights[i] * (x + unit + total)) >> (fine + 1))
        rows.append(row)
    for j in range((count + 1) // 2, count):  # by symmetry: from c_j to 1 as from 0 to 1 - c_j
        mirror = rows[count - 1 - j]
        rows.append([weights[i] - mirror[count - 1 - i] for i in range(count)])
    rows.append(weights)
    return Gauss(
        bits,
        tuple(x >> _GUARD for x in nodes),
        tuple(x >> _GUARD for x in weights),
        tuple(tuple(x >> _GUARD for x in row) for row in rows),
        tuple(tuple(x >> _GUARD for x in row) for row in legendre),
    )


def _exact_legendre(x: int, count: int, bits: int) -> list[int]:
    """P_0(x) ... P_count(x) by the three-term recurrence."""
    values = [1 << bits, x]
    for k in range(1, count):
        above = ((2 * k + 1) * x * values[k] >> bits) - k * values[k - 1]
        values.append(above // (k + 1))
    return values


# --- collocation tables ---------------------------------------------------------------------------


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
        count_of_levels = limbs if count is None else min(count, limbs)
        levels = [
            np.matmul(table, field[:, : i + 1].reshape(variables, (i + 1) * nodes, n))
            for i, table in enumerate(self.levels[:count_of_levels])
        ]
        if count_of_levels == limbs:
            whole = field.reshape(variables, limbs * nodes, n)
            levels.append(np.matmul(self.tail, whole))
        return levels

    @staticmethod
    def last_coefficients(levels: list[Doubles]) -> Doubles:
        """The larger of the last two Legendre coefficients of H f, over all components, (N,)."""
        rows = levels[-1][:, -2:].copy()
        for level in reversed(levels[:-1]):
            rows += level[:, -2:]
        largest: Doubles = np.abs(rows).max(axis=(0, 1)) * 2.0**_SMALLER
        return largest


@cache
def tables(limbs: Limbs, count: int) -> Tables:
    """The tables for ``count`` fine nodes; raises CannotRefine where there are too many."""
    bits = limbs.finest + _TABLE_BITS
    table = gauss(count, bits)
    unit = Fraction(1, 1 << bits)
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
        [[kind.split(x * unit) for x in row] for row in (*table.integrals, *last)]
    )  # (M + 3, M, L)
    _check(split, limbs)
    levels = tuple(
        np.concatenate([split[:, :, i] for i in range(top, -1, -1)], axis=1)
        for top in range(limbs.count - 1)
    )
    suffix = np.cumsum(split[:, :, ::-1], axis=2)  # smallest first
    tail = np.concatenate([suffix[:, :, i] for i in range(limbs.count)], axis=1)
    double = _doubles(table.integrals, float(unit))
    coarse, fine, thinned = _middle(table, gauss(count // 2, bits))
    return Tables(
        (_doubles(table.nodes, float(unit)) + 1) / 2,
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
        zero: Doubles = _legendre(np.zeros(1), n + 1)[0]  # P_0(0) ... P_n(0)
        d = d - (zero[2 : n + 1] - zero[: n - 1])
        return (points[:, None] + d @ coarse_p[:, 1:n].T) * (bc / 2)

    ends = np.array([-1.0, 1.0])
    ends_p = ends[:, None] ** np.arange(n + 1)
    everywhere = np.concatenate([x, ends]), np.concatenate([fine_p[:, : n + 1], ends_p])
    k = np.arange(len(x))
    thinned = (_legendre(xc, len(x)) * (2 * k + 1)) @ (fine_p[:, : len(x)].T * b)
    return integrals(xc, coarse_p), integrals(*everywhere), thinned


def _doubles(values: Any, scale: float) -> Doubles:
    doubles: Doubles = np.array(values, dtype=np.float64) * scale
    return doubles


def _legendre(x: Doubles, count: int) -> Doubles:
    """P_0 ... P_{count-1} at points, one row per point."""
    polynomials = [np.ones_like(x), x]
    for k in range(1, count - 1):
        polynomials.append(((2 * k + 1) * x * polynomials[k] - k * polynomials[k - 1]) / (k + 1))
    return np.stack(polynomials[:count], axis=1)
