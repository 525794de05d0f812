"""What a motion turns by along panels of it: the spinor's phase, and whole turns of psi and phi.

On each panel the phase's rate (:mod:`polhode.equations.spinors`) is integrated in units of the
spinors that a direction a of the panel's own gives: that in which gamma stands in the middle, that
about which the body turns there, or an axis.

psi and phi follow from spinor and gamma but for whole turns.  phi's are counted as gamma's path
from node to node crosses the half plane phi = pi; psi's come from psi ± phi, the one of which is
smooth at the pole that the path comes near to, and which is thus integrated well enough by the
same nodes.  A panel is settled where the nodes are enough for all of this; else it is to be halved.

Arrays of numpy in double or extended: a vector's components, panels, nodes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.equations import spinors
from polhode.numbers.gauss_lobatto import Lobatto
from polhode.numbers.rows import Doubles, Extendeds, Integers, LongComplexes

_TAIL = 16.0  # in eps: an integral's error is a twentieth of the square of its rule's last terms
_NEARER = 0.2  # in 1 + gamma·a: by this much the second direction has to be better
_NEWTON = 3
_EDGE = 1e-9  # of a panel
_CHORD = 3.0  # a path's distance from its chord, at most so many times that of a parabola


class Panels(NamedTuple):
    """Panels of a motion, each with a rule's nodes.

    ``begin``, ``length``: times.  ``omega``, ``gamma``: at the nodes.  ``shift``: by how much the
    nodes' times are late, None where they are not.
    """

    begin: Extendeds
    length: Extendeds
    omega: Extendeds
    gamma: Extendeds
    shift: Extendeds | None


class Turned(NamedTuple):
    """What each panel turns by, in order.

    ``phase``: X/2's growth, of length one.  ``first``, ``last``: the spinors of gamma at the ends,
    in whose units it is.  ``psi``, ``phi``: what they grow by, to far less than a turn.
    ``across``: gamma2 + i gamma1 at the ends, whose argument is phi.  ``split``: where in the panel
    to split it, as a fraction; 0 where it is settled: all of this is right.
    """

    begin: Extendeds
    phase: LongComplexes
    first: LongComplexes
    last: LongComplexes
    psi: Doubles
    phi: Doubles
    across: LongComplexes | Doubles
    split: Doubles

    @property
    def settled(self) -> npt.NDArray[np.bool_]:
        """Which panels need not be split."""
        found: npt.NDArray[np.bool_] = self.split == 0
        return found


def turned(panels: Panels, rule: Lobatto, turn: Extendeds | None, counted: bool) -> Turned:
    """What these panels turn by.

    ``turn``: the matrix to the axes of psi and phi, None where they are those of gamma;
    ``counted``: whether psi and phi are wanted.
    """
    omega, gamma = panels.omega, panels.gamma
    kind = gamma.dtype
    weights = rule.weights.astype(kind)
    a, rate, inmost, enough = _best(omega, gamma, rule)
    grown = panels.length * (inmost.astype(np.longdouble) + rate @ weights)
    if panels.shift is not None:
        shift = panels.shift.astype(np.float64)
        slopes = rate.astype(np.float64) @ rule.slopes.astype(np.float64)
        grown -= (slopes * shift) @ rule.weights.astype(np.float64)
        for end, sense in ((0, -1), (-1, 1)):  # from one end's state to the other's
            grown += sense * shift[:, end] * (rate[:, end] + inmost)
    half = grown / 2
    phase: LongComplexes = np.asarray(np.cos(half) + 1j * np.sin(half), dtype=np.clongdouble)
    k = spinors.of_direction(a)
    first, final = (spinors.section(k, gamma[:, :, i]) for i in (0, -1))
    psi = phi = np.zeros(len(half))
    split = np.where(enough, 0, 0.5)
    across: LongComplexes | Doubles = np.zeros((2, len(half)))
    if counted:
        if turn is not None:
            omega, gamma = (np.tensordot(turn.T.astype(kind), x, 1) for x in (omega, gamma))
        w, g, length = (x.astype(np.float64) for x in (omega, gamma, panels.length))
        psi, phi, where = _angles(w, g, length, rule)
        split = np.where(enough, where, split)
        across = (gamma[1] + 1j * (gamma[0] + 0.0))[:, [0, -1]].T
    return Turned(panels.begin, phase, first, final, psi, phi, across, split)


def _best(
    omega: Extendeds, gamma: Extendeds, rule: Lobatto
) -> tuple[Extendeds, Extendeds, Extendeds, npt.NDArray[np.bool_]]:
    """Directions, the phase's rate by them from its value in the middle on, that value.

    And whether the nodes are enough for its integral, as they mostly are by the first directions.
    """
    last, middle = rule.last.astype(gamma.dtype), rule.weights.size // 2
    w = omega[:, :, middle]
    size = np.sqrt((w * w).sum(axis=0))
    limit = math.sqrt(_TAIL * np.finfo(gamma.dtype).eps)

    def tried(
        k: Integers | slice, a: Extendeds
    ) -> tuple[Extendeds, Extendeds, npt.NDArray[np.bool_]]:
        rate = spinors.rate(omega[:, k], gamma[:, k], a)
        inmost = rate[:, middle].copy()
        rate -= inmost[:, None]
        largest = np.maximum(np.abs(rate).max(axis=1), np.maximum(np.abs(inmost), size[k]))
        return rate, inmost, np.abs(rate @ last).max(axis=1) <= limit * largest

    first, others = _directions(gamma, w, size, middle)
    a = first
    rate, inmost, enough = tried(slice(None), a)
    for other in others:
        k = np.flatnonzero(~enough)
        if not k.size:
            break
        rate[k], inmost[k], enough[k] = tried(k, other[:, k])
        a = a.copy()
        a[:, k] = other[:, k]
    return a, rate, inmost, enough


def _directions(
    gamma: Extendeds, w: Extendeds, size: Extendeds, middle: int
) -> tuple[Extendeds, tuple[Extendeds, Extendeds]]:
    """Of each panel the most promising direction a, and others."""
    a, some = gamma[:, :, middle], gamma[:, :, :: max(1, middle // 2)]
    a = a / np.sqrt((a * a).sum(axis=0))
    toward = w[0] * a[0] + w[1] * a[1] + w[2] * a[2]
    about = np.where(size > 0, w / np.where(size > 0, np.where(toward < 0, -size, size), 1), a)
    nearest = [_dot(some, x).min(axis=1) for x in (a, about)]
    better = nearest[1] > nearest[0] + _NEARER
    low, high = some.min(axis=2), some.max(axis=2)
    axis = np.maximum(low, -high).argmax(axis=0)
    along = np.zeros_like(a)
    panel = np.arange(a.shape[1])
    along[axis, panel] = np.where(low[axis, panel] > -high[axis, panel], 1, -1)
    return np.where(better, about, a), (along, np.where(better, a, about))


def _dot(vectors: Extendeds, a: Extendeds) -> Extendeds:
    x, y, z = (vectors[i] * a[i][:, None] for i in range(3))
    found: Extendeds = x + y + z
    return found


def _angles(
    omega: Doubles, gamma: Doubles, length: Doubles, rule: Lobatto
) -> tuple[Doubles, Doubles, Doubles]:
    """By how much psi and phi grow on each panel, roughly, and where to split it, or 0."""
    (p, q, r), (g1, g2, g3) = omega, gamma
    panels, weights = np.arange(len(g1)), rule.weights.astype(np.float64)
    across = p * g1 + q * g2
    square = g1 * g1 + g2 * g2
    fastest = (p * p + q * q + r * r).max(axis=1)
    step = length * rule.gap
    upper = np.where(g3[panels, square.argmin(axis=1)] < 0, -1.0, 1.0)[:, None]
    near = square <= (fastest * step * step)[:, None]
    close = near.any(axis=1)
    split = np.where((near & (g3 * upper < 0)).any(axis=1), 0.5, 0)
    both = length * ((r * upper + across / (1 + g3 * upper)) @ weights)
    start, end = (np.arctan2(g1[:, i] + 0.0, g2[:, i]) for i in (0, -1))
    phi = end - start + 2 * math.pi * _crossings(g1, g2)
    psi = both - upper[:, 0] * phi
    k = np.flatnonzero(close)
    if k.size:
        flat = ~across[k].any(axis=1)  # in a plane with the third axis, over the pole or not
        doubt = _doubtful(omega[:, k], gamma[:, k], length[k], rule)
        split[k] = np.where(doubt > 0, doubt, split[k])
        k = k[flat]
        psi[k], phi[k], split[k] = 0, length[k] * (r[k] @ weights), 0
    return psi, phi, split


def _crossings(g1: Doubles, g2: Doubles) -> Doubles:
    """How often phi = atan2(g1, g2) comes over pi, counted with its sign, chord by chord."""
    negative = g1 < 0
    panel, node = np.nonzero(negative[:, 1:] != negative[:, :-1])
    a1, a2, b1, b2 = g1[panel, node], g2[panel, node], g1[panel, node + 1], g2[panel, node + 1]
    below = (a2 * b1 - b2 * a1) * (b1 - a1) < 0
    sense = np.where(negative[panel, node], -1, 1) * below
    return np.bincount(panel, sense, len(g1)).astype(np.float64)


def _doubtful(omega: Doubles, gamma: Doubles, length: Doubles, rule: Lobatto) -> Doubles:
    """Where on each panel gamma's path may pass the pole on another side than its chords do.

    A fraction of the panel, at the path's nearest approach to the pole; 0 where there is no doubt.
    """
    (p, q, r), (x, y, g3) = omega, gamma
    nodes = rule.nodes.astype(x.dtype)
    step = length[:, None] * np.diff(nodes)
    a = np.stack([x, y])
    speed = np.stack([y * r - g3 * q, g3 * p - x * r])
    d = np.diff(a, axis=2)
    a, slopes = a[:, :, :-1], (speed[:, :, :-1] * step, speed[:, :, 1:] * step)
    square = _square(d)
    # a parabola with these slopes leaves its chord by s (1 - s) of this
    bend = (_CHORD / 2) ** 2 * _square(slopes[1] - slopes[0])
    nearest = np.clip(-(a * d).sum(axis=0) / np.where(square > 0, square, 1), 0, 1)
    doubt = np.zeros(square.shape, dtype=bool)
    for s in (nearest, 0.1, 0.3, 0.5, 0.7, 0.9):
        doubt |= _square(a + s * d) <= (s * (1 - s)) ** 2 * bend
    away = np.where(doubt, _square(a + nearest * d), np.inf)
    worst = away.argmin(axis=1)
    row = np.arange(len(worst))
    a, d, s = a[:, row, worst], d[:, row, worst], nearest[row, worst]
    u, v = (x[:, row, worst] for x in slopes)
    for _ in range(_NEWTON):  # on the cubic with these slopes
        at = a + s * u + s * s * ((3 * d - 2 * u - v) + s * (u + v - 2 * d))
        to = u + s * (2 * (3 * d - 2 * u - v) + 3 * s * (u + v - 2 * d))
        s = np.clip(s - (at * to).sum(axis=0) / (to * to).sum(axis=0), 0, 1)
    found = nodes[worst] + s * np.diff(nodes)[worst]
    inside = (found > _EDGE) & (found < 1 - _EDGE)
    return np.where(doubt.any(axis=1), np.where(inside, found, 0.5), 0)


def _square(vector: Doubles) -> Doubles:
    found: Doubles = vector[0] * vector[0] + vector[1] * vector[1]
    return found
