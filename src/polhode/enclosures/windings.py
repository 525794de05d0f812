"""How often psi and phi have gone round: complex numbers followed about 0, interval by interval.

Trusted.  sin(theta) exp(i phi) = gamma2 + i gamma1 and sin(theta) exp(i psi) = i n1 - n2, n the
body's third axis in space, move no faster than |w|.  Over an interval of length l in which an end
is farther from 0 than l |w|, the number stays in a disc without 0, so its argument grows by the
principal difference of the ends.  Where that cannot be said the interval is halved, until it is no
longer than what the ends are known to: the motion then passes a pole, and the angles are lost from
there on.

A number c that is 0 at t = 0 and leaves with c' differs from t c' by at most t**2/2 sup |c''|, so
up to t = |c'|/sup |c''| it stays within 30 degrees of c'.  For both numbers |c'| = |w x axis| and
|c''| <= |w|**2 + |w'|.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

MOST = 100_000  # points of a step
_FIRST = 8
_LEAST = 1e-11  # more than what doubles lose


class Leaving(NamedTuple):
    """How a motion leaves a pole at t = 0: the directions of the two numbers, and their speed.

    ``bend``, ``pull``: |w'| <= bend |w|**2 + pull.
    """

    directions: Any
    slope: float
    bend: float
    pull: float


class Followed:
    """psi and phi along the motion to within a turn's fraction, by growth from the start.

    ``leaving``: of a start at a pole; psi and phi are then those just after it.
    """

    def __init__(self, psi: float, phi: float, known: bool, leaving: Leaving | None = None) -> None:
        self.leaving = leaving
        self.total = np.array([psi, phi])
        self.slack = 1e-9 * (1.0 + abs(psi))  # of what was added up
        self.known = known

    def step(self, at: Any, length: float, speed: float, doubt: float, asked: Any) -> Any:
        """The angles at the points ``asked`` of a step; None where they are lost.

        ``at``: an array of tau in [0, 1] to the two complex numbers, (2, n), each right to
        ``doubt``; ``speed``: a bound of |w|.
        """
        if not self.known:
            return None
        doubt = _LEAST + doubt
        first = self._first(length, speed)
        even = np.linspace(0.0, 1.0, _FIRST + 1)
        nodes = np.unique(np.concatenate([even, asked, [] if first is None else [first]]))
        while True:
            values = at(nodes)
            if first is not None and self.leaving is not None:
                values[:, 0] = self.leaving.directions
            sizes = np.abs(values) - doubt
            reach = 1.01 * length * speed * np.diff(nodes) + doubt
            sure = np.maximum(sizes[:, :-1], sizes[:, 1:]) > reach
            if first is not None:
                sure[:, 0] = nodes[1] <= first
            sure &= np.minimum(sizes[:, :-1], sizes[:, 1:]) > 2.0 * doubt
            bad = ~np.all(sure, axis=0)
            if not np.any(bad):
                break
            if nodes.size > MOST or not np.all(reach[bad] > 2.0 * doubt):
                self.known = False
                return None
            middle = 0.5 * (nodes[:-1] + nodes[1:])[bad]
            nodes = np.sort(np.concatenate([nodes, middle]))
        grown = np.angle(values[:, 1:] * np.conj(values[:, :-1]))
        self.slack += float(np.sum(4.0 * doubt / sizes)) + 1e-15 * nodes.size
        if not self.slack < 0.5:
            self.known = False
            return None
        along = np.concatenate([np.zeros((2, 1)), np.cumsum(grown, axis=1)], axis=1)
        along += self.total[:, None]
        self.total = along[:, -1].copy()
        if not math.isfinite(float(np.sum(self.total))):
            self.known = False
            return None
        self.leaving = None
        return along[:, np.searchsorted(nodes, asked)].T

    def _first(self, length: float, speed: float) -> float | None:
        """Up to which tau a motion that leaves a pole is near its first direction."""
        if self.leaving is None:
            return None
        _, slope, bend, pull = self.leaving
        return min(1.0, slope / (1.01 * (speed * speed * (1.0 + bend) + pull) * length))
