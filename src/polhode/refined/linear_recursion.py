"""The recursion e_{n+1} = Phi_n e_n + delta_n over a block: the one thing in sequence."""

from __future__ import annotations

import math

import numpy as np

from polhode.numbers.rows import Doubles


class Chain:
    """The transition matrices of successive intervals, (K, 6, 6), cut into about sqrt(K) chunks.

    All chunks advance together; then their ends are joined, one after the other.
    """

    def __init__(self, transitions: Doubles) -> None:
        count, n, _ = transitions.shape
        self._count = count
        self._long = max(1, math.isqrt(count))
        self._chunks = -(-count // self._long)
        padded = np.broadcast_to(np.eye(n), (self._chunks * self._long, n, n)).copy()
        padded[:count] = transitions
        self._steps = padded.reshape(self._chunks, self._long, n, n)
        self._products = np.empty_like(self._steps)
        self._products[:, 0] = self._steps[:, 0]
        for i in range(1, self._long):
            np.matmul(self._steps[:, i], self._products[:, i - 1], out=self._products[:, i])

    def solve(self, sources: Doubles) -> Doubles:
        """e_1 ... e_K, (K, 6), from e_0 = 0 and delta_0 ... delta_{K-1}, (K, 6)."""
        n = sources.shape[1]
        delta = np.zeros((self._chunks * self._long, n, 1))
        delta[: self._count, :, 0] = sources
        found = delta.reshape(self._chunks, self._long, n, 1)
        for i in range(1, self._long):
            found[:, i] += self._steps[:, i] @ found[:, i - 1]
        begin = np.zeros((self._chunks, n, 1))
        for c in range(1, self._chunks):
            begin[c] = self._products[c - 1, -1] @ begin[c - 1] + found[c - 1, -1]
        found = found + self._products @ begin[:, None]
        return found.reshape(-1, n)[: self._count]
