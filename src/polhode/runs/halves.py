"""Panels of a motion whose nodes are not enough: integrated once more, in halves of halves."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.equations.turned import Panels, Turned, turned
from polhode.numbers.lobatto import Lobatto
from polhode.runs.setup import Setup, bare

_DEEPEST = 12  # halvings of a panel: then a pole is a millionth of a radian away


class Halves:
    """What panels of a run turn by, from the states at their nodes or at more of them."""

    def __init__(self, made: Setup) -> None:
        self._made, self._counted = made, "angles" in made.whole.outputs

    def settled(self, panels: Panels, rule: Lobatto, depth: int = 0) -> list[Turned | None]:
        """What these panels turn by, in parts of any order; None is the last where it fails."""
        found = turned(panels, rule, self._made.turn, self._counted)
        if found.settled.all():
            return [found]
        if depth == _DEEPEST:
            return [None]
        halves = self._halves(panels, rule, found.split)
        done = found.settled
        whole = Turned(*(x[..., done] for x in found))
        return [whole, *self.settled(halves, rule, depth + 1)]

    def _halves(self, panels: Panels, rule: Lobatto, split: Any) -> Panels:
        """Both parts of the panels to be split, integrated from where those begin."""
        from polhode.taylor.integrator import Integrator

        which = np.flatnonzero(split)
        kind = panels.gamma.dtype
        nodes, count = rule.nodes.astype(kind), len(rule.nodes)
        both = np.array([np.arange(count), np.arange(count) + count - 1])
        at = np.empty((6, 2 * len(which), count), dtype=kind)
        first = panels.length[which] * split[which].astype(kind)
        rest = panels.length[which] - first
        again = Integrator(bare(self._made).blueprint)
        for i, k in enumerate(which.tolist()):
            again.heyoka.time = kind.type(0)
            again.state[:3], again.state[3:] = panels.omega[:, k, 0], panels.gamma[:, k, 0]
            grid = np.concatenate([nodes * first[i], first[i] + nodes[1:] * rest[i]])
            states = again.heyoka.propagate_grid(grid)[-1]
            states[-1, :3], states[-1, 3:] = panels.omega[:, k, -1], panels.gamma[:, k, -1]
            at[:, 2 * i : 2 * i + 2] = states.T[:, both]
        again.release()
        long = np.stack([first, rest], axis=1).ravel()
        begin = np.repeat(panels.begin[which], 2)
        begin[1::2] += first
        return Panels(begin, long, at[:3], at[3:], None)
