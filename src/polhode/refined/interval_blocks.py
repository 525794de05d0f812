"""Blocks: successive intervals of a run in double, and the output times that lie in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.numbers.rows import Doubles, Integers
from polhode.refined.deferred_correction import Intervals
from polhode.refined.double_run import Base, on_grid
from polhode.refined.expansions import Limbs

WIDTH = 160  # intervals of a chain; the arrays of more would leave the cache
_ROOM = 2 * WIDTH  # intervals of a block, those that lead to outputs included


@dataclass(frozen=True, eq=False)
class Block:
    """A chain between ``edges``, and an interval of its own from an edge to each output time.

    ``clocks``: the output times by the base's clock, exact; ``parents``: the edges before them,
    counted from the block's first.  ``state``: limbs (6, L) of the exact state at the first edge.
    """

    base: Base
    edges: Doubles
    clocks: tuple[Fraction, ...]
    parents: Integers
    state: Doubles
    limbs: Limbs

    @property
    def chain(self) -> int:
        """Intervals of the chain."""
        return len(self.edges) - 1

    def intervals(self, nodes: Doubles) -> Intervals:
        """All intervals with the guesses of the run in double; ``nodes``: c_j."""
        limbs, chain = self.limbs, self.chain
        starts = np.concatenate([np.arange(chain), self.parents])
        begin = self.edges[starts]
        chained = limbs.split_doubles(np.diff(self.edges))  # exact: edges lie on a grid
        sides = [
            limbs.split(t - Fraction(start))
            for t, start in zip(self.clocks, begin[chain:].tolist(), strict=True)
        ]
        lengths = np.concatenate([chained, np.array(sides).reshape(-1, limbs.count).T], axis=1)
        times = begin + nodes[:, None] * lengths.sum(axis=0)
        outputs = np.array([float(t) for t in self.clocks])
        ends = self.base.states(np.concatenate([self.edges[1:], outputs]))
        states = np.empty((6, limbs.count, 1 + ends.shape[1]))
        states[:, :, 0] = self.state
        states[:, :, 1:] = limbs.split_doubles(ends).swapaxes(0, 1)
        return Intervals(states, 1, starts, chain, self.base.states(times), lengths)

    def halves(self, which: Any, first: int) -> tuple[Any, Any]:
        """Where to insert which edges, ``first`` being the index of the block's first one.

        ``which``: of the intervals those that are too long.  One that leads to an output has
        the interval halved in which the output lies.
        """
        chain = self.chain
        long = {*np.flatnonzero(which[:chain]).tolist(), *self.parents[which[chain:]].tolist()}
        ends = [*self.edges.tolist(), float(self.clocks[-1]) if self.clocks else 0.0]
        places = sorted(long)
        middles = on_grid(np.array([(ends[i] + ends[i + 1]) / 2 for i in places]))
        return np.array([first + i + 1 for i in places]), middles


def cut(
    base: Base,
    edges: Doubles,
    at: int,
    width: int,
    clocks: Sequence[Fraction],
    state: Doubles,
    limbs: Limbs,
) -> Block:
    """The block from the edge ``at``, of so many intervals or as many as the outputs leave room.

    ``clocks``: the output times ahead.  Behind the last edge of a final run they belong to it.
    """
    window = edges[at : at + width + 1]
    ahead = np.array([float(t) for t in clocks[:_ROOM]])
    before = np.searchsorted(ahead, window, side="left")  # outputs before each edge
    before[0] = 0
    chain = int(np.flatnonzero(np.arange(len(window)) + before <= _ROOM)[-1])
    count = int(before[chain])
    at_last_edge = base.final and at + chain == len(edges) - 1
    if at_last_edge or chain == 0:
        count = min(len(ahead), _ROOM - chain)
        if chain == 0 and not at_last_edge:  # a crowd of outputs before the next edge
            count = min(count, int(np.searchsorted(ahead, window[1], side="left")))
    window = window[: chain + 1]
    parents = np.maximum(np.searchsorted(window, ahead[:count], side="right") - 1, 0)
    return Block(base, window, tuple(clocks[:count]), parents, state, limbs)
