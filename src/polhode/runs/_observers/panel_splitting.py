"""Panels of a motion whose nodes are not enough: split and integrated once more."""

from __future__ import annotations

import numpy as np

from polhode.equations.attitude_phase import Panels, Turned, turned
from polhode.numbers.gauss_lobatto import Lobatto
from polhode.numbers.rows import Doubles
from polhode.runs._observers.protocol import CannotObserve
from polhode.runs.problem.problem import Problem

_DEEPEST = 12  # splits of a panel
_SPLITS = 4  # for each panel of a run, on the average


class Halves:
    """What panels of a run turn by, from the states at their nodes or at more of them."""

    def __init__(self, problem: Problem) -> None:
        self._turn, self._counted = problem.turn, "angles" in problem.scene.modelled
        self._plain = problem.prepared().blueprint
        self._left = 0

    def enough(self, panels: Panels, rule: Lobatto) -> float:
        """The fraction of these panels that are settled by their nodes."""
        return float(turned(panels, rule, self._turn, self._counted).settled.mean())

    def settled(self, panels: Panels, rule: Lobatto, depth: int = 0) -> list[Turned]:
        """What these panels turn by, in parts of any order; raises CannotObserve."""
        found = turned(panels, rule, self._turn, self._counted)
        if found.settled.all():
            return [found]
        splits = int(np.count_nonzero(found.split))
        self._left += 0 if depth else _SPLITS * len(found.split)
        if depth == _DEEPEST or splits > self._left:
            raise CannotObserve("panels that cannot be settled")
        self._left -= splits
        halves = self._halves(panels, rule, found.split)
        done = found.settled
        whole = Turned._make(x[..., done] for x in found)
        return [whole, *self.settled(halves, rule, depth + 1)]

    def _halves(self, panels: Panels, rule: Lobatto, split: Doubles) -> Panels:
        """Both parts of the panels to be split, integrated from where those begin."""
        from polhode.taylor.integrator.compiled import Compiled

        which = np.flatnonzero(split)
        kind = panels.gamma.dtype
        nodes, count = rule.nodes.astype(kind), len(rule.nodes)
        both = np.array([np.arange(count), np.arange(count) + count - 1])
        at = np.empty((6, 2 * len(which), count), dtype=kind)
        first = panels.length[which] * split[which].astype(kind)
        rest = panels.length[which] - first
        again = Compiled(self._plain)
        for i, k in enumerate(which.tolist()):
            again.stand(np.concatenate([panels.omega[:, k, 0], panels.gamma[:, k, 0]]))
            grid = np.concatenate([nodes * first[i], first[i] + nodes[1:] * rest[i]])
            states = again.grid(grid)
            states[-1, :3], states[-1, 3:] = panels.omega[:, k, -1], panels.gamma[:, k, -1]
            at[:, 2 * i : 2 * i + 2] = states.T[:, both]
        again.release()
        long = np.stack([first, rest], axis=1).ravel()
        begin = np.repeat(panels.begin[which], 2)
        begin[1::2] += first
        return Panels(begin, long, at[:3], at[3:], None)
