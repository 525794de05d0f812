"""Gauss–Legendre nodes and the integrals of their Lagrange polynomials, to any number of bits.

x_i the nodes on [-1, 1], P_k the Legendre polynomials, c = (x + 1)/2, b_i the weights on [0, 1].
With D_k = P_{k+1} - P_{k-1}, (2k + 1) times the integral of P_k from -1,

    A_ji = integral of l_i from 0 to c_j = b_i/2 [x_j + 1 + sum_{k=1}^{M-1} P_k(x_i) D_k(x_j)].

All in integers, so many bits behind the point; Hairer, Wanner, Solving ODEs II, IV.5, has the
collocation method that A and b make.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import cos, pi

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
    one = 1 << fine
    upper = [_node(count, k, fine) for k in range((count + 1) // 2)]  # from 1 down to 0
    middle = [0] if count % 2 else []
    nodes = [-x for x in upper[: count // 2]] + middle + upper[: count // 2][::-1]
    legendre = [_legendre(x, count, fine) for x in nodes]
    weights = []
    for x, p in zip(nodes, legendre, strict=True):
        # b = (1 - x²)/(M P_{M-1})², half the weight on [-1, 1]
        scale = count * p[count - 1]
        weights.append(((one * one - x * x) << fine) // (scale * scale))
    rows = []
    for j in range((count + 1) // 2):
        p, x = legendre[j], nodes[j]
        d = [p[k + 1] - p[k - 1] for k in range(1, count)]
        row = []
        for i in range(count):
            total = sum(map(int.__mul__, legendre[i][1:count], d)) >> fine
            row.append((weights[i] * (x + one + total)) >> (fine + 1))
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


def _legendre(x: int, count: int, bits: int) -> list[int]:
    """P_0(x) ... P_count(x) by the three-term recurrence."""
    values = [1 << bits, x]
    for k in range(1, count):
        above = ((2 * k + 1) * x * values[k] >> bits) - k * values[k - 1]
        values.append(above // (k + 1))
    return values


def _node(count: int, k: int, bits: int) -> int:
    """The k-th zero of P_count from above, by Newton's method from its asymptotic value."""
    x = int(cos(pi * (k + 0.75) / (count + 0.5)) * 2**53) << bits >> 53
    one = 1 << bits
    for _ in range(bits.bit_length() + 2):
        p = _legendre(x, count, bits)
        slope = (count * ((x * p[count] >> bits) - p[count - 1]) << bits) // ((x * x >> bits) - one)
        step = (p[count] << bits) // slope
        x -= step
        if abs(step) < 1 << (bits // 2 - 8):  # the next one would be below the last bit
            break
    return x
