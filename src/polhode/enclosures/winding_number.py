"""How often psi and phi have gone round: complex numbers followed about 0, interval by interval.

Trusted.  sin(theta) exp(i phi) = gamma2 + i gamma1 and sin(theta) exp(i psi) = i n1 - n2, n the
body's third axis in space, are the numbers c; |c'| <= |w| and |c''| <= |w|**2 + |w'|.  Over an
interval of length l the argument of c grows by the principal difference of the ends

    if an end is farther from 0 than l |w|: c stays in a disc without 0;
    if the chord of the ends is farther from 0 than l**2/8 sup |c''|, by which c leaves the chord.

Where neither can be said the interval is halved, until it is no longer than what the ends are known
to: the motion then passes a pole, and the angles are lost from there on.

A number c that is 0 at t = 0 and leaves with c' differs from t c' by at most t**2/2 sup |c''|, so
up to t = |c'|/sup |c''| it stays within 30 degrees of c'.  One that leaves with c'' differs from
t**2/2 c'' by at most t**3/6 sup |c'''|, and stays within 30 degrees of c'' up to
t = 3/2 |c''|/sup |c'''|.  For both numbers |c'| = |w x axis|, and then |c''| = |w' x axis|.

In the second case w is along the third axis at t = 0.  With W >= |w|, v its part across the axis,
Y >= |w'| up to t, and K = 1 + W t exp(W t)/2,

    |c'| <= v + W |c|,    v <= t Y,    hence    |c|, |gamma x w| <= v + W |c| <= t K Y;
    |w''| <= sqrt(2) b W |w'| + pull |gamma x w|,    hence
    Y <= |w'(0)|/(1 - sqrt(2) b W t - pull t**2 K)    while that is positive;
    |c'''| <= W**2 t K Y + 2 W Y + 2 t K Y**2 + |w''|.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from polhode.enclosures.fixed_point_problem import UP
from polhode.enclosures.step_bound import gamma

MOST = 100_000  # points of a step
_FIRST = 8


class Pace(NamedTuple):
    """Bounds on a step: of |w|, and of |w'| <= gyration |w|**2 + pull.

    ``gyration``: the largest |(B - C)/A|; ``pull``: of I^-1 (gamma x Mg r0), |gamma| = 1.
    """

    speed: float
    gyration: float
    pull: float

    @property
    def bend(self) -> float:
        """A bound of |c''|: |w|**2 + |w'|."""
        return self.speed**2 * (1.0 + self.gyration) + self.pull


class Leaving(NamedTuple):
    """How a motion leaves a pole at t = 0: the directions of the two numbers, and how they grow.

    ``order``: that of their first derivative that is not 0, 1 or 2; ``size``: its modulus.
    ``rate``: of order 2, |w'|.
    """

    directions: Any
    order: int
    size: float
    rate: float = 0.0

    def until(self, pace: Pace) -> float:
        """A time up to which both numbers are within 30 degrees of their directions."""
        if self.order == 1:
            return self.size / (1.01 * pace.bend)
        time = 1.0 / pace.speed if pace.speed > 0.0 else 1.0
        while 1.01 * time * self._third(pace, time) > 1.5 * self.size:
            time *= 0.5
        return time

    def _third(self, pace: Pace, time: float) -> float:
        """sup |c'''| up to a time."""
        speed, gyration, pull = pace
        grown = 1.0 + 0.5 * speed * time * math.exp(speed * time)  # K
        gyration *= math.sqrt(2.0) * speed
        left = 1.0 - gyration * time - pull * time * time * grown
        if left <= 0.0:
            return math.inf
        rate = self.rate / left
        moved = time * grown * rate
        return speed**2 * moved + (2.0 * speed + gyration + 2.0 * moved) * rate + pull * moved


class Followed:
    """psi and phi along the motion to within a turn's fraction, by growth from the start.

    ``lost``: the time at whose step they were, in the proof's unit; None while they are not.
    ``leaving``: of a start at a pole; psi and phi are then those just after it.
    """

    def __init__(self, psi: float, phi: float, known: bool, leaving: Leaving | None = None) -> None:
        self.leaving = leaving
        self.total = np.array([psi, phi])
        self.slack = 1e-9 * (1.0 + abs(psi))  # of what was added up
        self.known = known
        self.walked, self.lost = 0.0, None if known else 0.0

    def step(self, at: Any, length: float, pace: Pace, doubt: float, asked: Any) -> Any:
        """The angles at the points ``asked`` of a step; None where they are lost.

        ``at``: an array of tau in [0, 1] to the two complex numbers, (2, n), each right to
        ``doubt``, which holds the rounding of :func:`_chords` as well: a few units of 1.
        """
        if not self.known:
            return None
        doubt += UP * gamma(8) * length * pace.speed  # tau is a double
        first = None if self.leaving is None else min(1.0, self.leaving.until(pace) / length)
        even = np.linspace(0.0, 1.0, _FIRST + 1)
        nodes = np.unique(np.concatenate([even, asked, [] if first is None else [first]]))
        while True:
            values = at(nodes)
            if first is not None and self.leaving is not None:
                values[:, nodes < first] = self.leaving.directions[:, None]
            sizes = np.abs(values) - doubt
            reach = 1.01 * length * pace.speed * np.diff(nodes) + doubt
            sure = np.maximum(sizes[:, :-1], sizes[:, 1:]) > reach
            bow = 1.01 * pace.bend * (length * np.diff(nodes)) ** 2 / 8.0 + doubt
            sure |= _chords(values) - doubt > bow
            if first is not None:
                sure[:, nodes[1:] <= first] = True
            sure &= np.minimum(sizes[:, :-1], sizes[:, 1:]) > 2.0 * doubt
            bad = ~np.all(sure, axis=0)
            if not np.any(bad):
                break
            if nodes.size > MOST or not np.all(reach[bad] > 2.0 * doubt):
                return self._lost()
            middle = 0.5 * (nodes[:-1] + nodes[1:])[bad]
            nodes = np.sort(np.concatenate([nodes, middle]))
        grown = np.angle(values[:, 1:] * np.conj(values[:, :-1]))
        self.slack += float(np.sum(4.0 * doubt / sizes)) + 1e-15 * nodes.size
        if not self.slack < 0.5:
            return self._lost()
        along = np.concatenate([np.zeros((2, 1)), np.cumsum(grown, axis=1)], axis=1)
        along += self.total[:, None]
        self.total = along[:, -1].copy()
        if not math.isfinite(float(np.sum(self.total))):
            return self._lost()
        self.leaving, self.walked = None, self.walked + length
        return along[:, np.searchsorted(nodes, asked)].T

    def _lost(self) -> None:
        """From this step on they are not known."""
        self.known, self.lost = False, self.walked


def _chords(values: Any) -> Any:
    """The distances from 0 of the chords between neighbours of (2, n) complex numbers."""
    begin, chord = values[:, :-1], np.diff(values, axis=1)
    square = np.maximum(np.abs(chord) ** 2, np.finfo(float).tiny)
    foot = np.clip(-(chord.conj() * begin).real / square, 0.0, 1.0)
    return np.abs(begin + foot * chord)
