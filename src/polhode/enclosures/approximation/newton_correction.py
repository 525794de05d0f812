"""Newton's corrections of a window's polynomials, and the matrices of its linear flow.

Not trusted: what it finds wrong costs digits or a refusal.  All steps are treated at once.
"""

from __future__ import annotations

import numpy as np

from polhode.numbers.rows import Doubles

LEAST_TERM = 2.0**-48  # the last coefficient of a matrix V is smaller, if the degree allows
_FEWEST = 8


def matrices(a: Doubles) -> Doubles:
    """V with V' = A V, V(0) = I, to the degree at which it ends, at most that of A.

    ``a``: (W, p + 1, 6, 6).  Returns (W, m + 1, 6, 6).
    """
    steps, count = a.shape[:2]
    flat = _flat(a)
    turned = np.zeros((steps, 6 * count, 6))  # V_k in reversed order
    turned[:, 6 * (count - 1) :] = np.eye(6)
    degree = count - 1
    for k in range(count - 1):
        low = 6 * (count - 1 - k)
        row = np.matmul(flat[:, :, : 6 * (k + 1)], turned[:, low:]) / (k + 1)
        turned[:, low - 6 : low] = row
        if k + 1 >= _FEWEST and float(np.max(np.abs(row))) < LEAST_TERM:
            degree = k + 1
            break
    found = turned.reshape(steps, count, 6, 6)[:, ::-1]
    return np.ascontiguousarray(found[:, : degree + 1])


def correction(a: Doubles, defects: Doubles, v: Doubles, gaps: Doubles) -> Doubles:
    """e with e' = A e - d on every step, and without jumps from step to step.

    ``defects``: (W, K, 6); ``gaps``: the jumps of the polynomials, (W, 6).  Returns (W, p + 1, 6).
    """
    steps = a.shape[0]
    found = forced(a, defects, np.zeros(6))
    ends, flows = np.sum(found, axis=1), np.sum(v, axis=1)
    starts = np.zeros((steps, 6))
    starts[0] = gaps[0]
    for n in range(1, steps):
        starts[n] = flows[n - 1] @ starts[n - 1] + ends[n - 1] + gaps[n]
    found[:, : v.shape[1]] += np.einsum("wkij,wj->wki", v, starts)
    return found


def forced(a: Doubles, defects: Doubles, start: Doubles) -> Doubles:
    """e with e' = A e - d and e(0) = ``start`` on every step, each by itself: (W, p + 1, n).

    ``a``: (W, p + 1, n, n); ``defects``: (W, K, n), zero from K on.
    """
    steps, count, rows = a.shape[:3]
    flat = _flat(a)
    turned = np.zeros((steps, rows * count, 1))  # e_k in reversed order
    turned[:, rows * (count - 1) :, 0] = start
    for k in range(count - 1):
        low = rows * (count - 1 - k)
        row = np.matmul(flat[:, :, : rows * (k + 1)], turned[:, low:])[..., 0]
        if k < defects.shape[1]:
            row = row - defects[:, k]
        turned[:, low - rows : low, 0] = row / (k + 1)
    return np.ascontiguousarray(turned.reshape(steps, count, rows)[:, ::-1])


def _flat(a: Doubles) -> Doubles:
    """The coefficients of A side by side, (W, n, n (p + 1))."""
    steps, count, rows = a.shape[:3]
    return np.ascontiguousarray(a.transpose(0, 2, 1, 3)).reshape(steps, rows, rows * count)
