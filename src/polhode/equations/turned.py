"""What a motion turns by along panels of it: the spinor's phase, and whole turns of psi and phi.

On each panel the phase's rate (:mod:`polhode.equations.spinors`) is integrated in units of the
spinors that a direction a of the panel's own gives: that in which gamma stands in the middle, or
that about which the body turns there, whichever gamma stays farther from the opposite of.

psi and phi follow from spinor and gamma but for whole turns.  phi's are counted as gamma's path
from node to node crosses the half plane phi = pi; psi's come from psi ± phi, the one of which is
smooth at the pole that the path comes near to, and which is thus integrated well enough by the
same nodes.  A panel is settled where the nodes are enough for all of this; else it is to be halved.

Arrays of numpy in double or extended: a vector's components, panels, nodes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from polhode.equations import spinors
from polhode.numbers.lobatto import Lobatto

_CHORD = 3.0  # a path's distance from its chord, at most so many times that of a parabola
_PI = 4 * np.arctan(np.longdouble(1))


class Panels(NamedTuple):
    """Panels of a motion, each with a rule's nodes.

    ``begin``, ``length``: times.  ``omega``, ``gamma``: at the nodes.  ``shift``: by how much the
    nodes' times are late, None where they are not.
    """

    begin: Any
    length: Any
    omega: Any
    gamma: Any
    shift: Any | None


class Turned(NamedTuple):
    """What each panel turns by, in order.

    ``phase``: X/2's growth, of length one.  ``first``, ``last``: the spinors of gamma at the ends,
    in whose units it is.  ``psi``, ``phi``: what they grow by, to far less than a turn.
    ``across``: gamma2 + i gamma1 at the ends, whose argument is phi.  ``settled``: whether all of
    it is right.
    """

    begin: Any
    phase: Any
    first: Any
    last: Any
    psi: Any
    phi: Any
    across: Any
    settled: Any


def turned(panels: Panels, rule: Lobatto, turn: Any | None, counted: bool) -> Turned:
    """What these panels turn by.

    ``turn``: the matrix to the axes of psi and phi, None where they are those of gamma;
    ``counted``: whether psi and phi are wanted.
    """
    omega, gamma = panels.omega, panels.gamma
    kind = gamma.dtype
    weights, last = rule.weights.astype(kind), rule.last.astype(kind)
    middle = rule.weights.size // 2
    a, size = _direction(omega, gamma, middle)
    rate = spinors.rate(omega, gamma, a)
    inmost = rate[:, middle].copy()
    rate -= inmost[:, None]
    largest = np.maximum(np.abs(rate).max(axis=1), np.maximum(np.abs(inmost), size))
    tail = np.abs(rate @ last).max(axis=1)
    settled = tail * tail <= np.finfo(kind).eps * largest * largest
    grown = panels.length * (inmost.astype(np.longdouble) + rate @ weights)
    if panels.shift is not None:
        slopes = rate.astype(np.float64) @ rule.slopes.astype(np.float64)
        grown -= (slopes * panels.shift.astype(np.float64)) @ rule.weights.astype(np.float64)
    half = grown / 2
    phase = np.cos(half) + 1j * np.sin(half)
    k = spinors.of_direction(a)
    first, final = (spinors.section(k, gamma[:, :, i]) for i in (0, -1))
    psi = phi = np.zeros(len(half))
    across = np.zeros((2, len(half)))
    if counted:
        if turn is not None:
            omega, gamma = (np.tensordot(turn.T.astype(kind), x, 1) for x in (omega, gamma))
        psi, phi, sure = _angles(omega, gamma, panels.length, rule, weights)
        settled &= sure
        across = (gamma[1] + 1j * (gamma[0] + 0.0))[:, [0, -1]].T
    return Turned(panels.begin, phase, first, final, psi, phi, across, settled)


def _direction(omega: Any, gamma: Any, middle: int) -> tuple[Any, Any]:
    """Each panel's direction a, and how fast the body turns in its middle."""
    a, w, some = gamma[:, :, middle], omega[:, :, middle], gamma[:, :, :: max(1, middle // 2)]
    size = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    toward = w[0] * a[0] + w[1] * a[1] + w[2] * a[2]
    about = w / np.where(size > 0, np.where(toward < 0, -size, size), 1)
    nearest = [_dot(some, x).min(axis=1) for x in (a, about)]
    found = np.where(nearest[1] > nearest[0], about, a)
    return found / np.sqrt((found * found).sum(axis=0)), size


def _dot(vectors: Any, a: Any) -> Any:
    return vectors[0] * a[0][:, None] + vectors[1] * a[1][:, None] + vectors[2] * a[2][:, None]


def _angles(
    omega: Any, gamma: Any, length: Any, rule: Lobatto, weights: Any
) -> tuple[Any, Any, Any]:
    """By how much psi and phi grow on each panel, roughly, and whether the turns are sure."""
    (p, q, r), (g1, g2, g3) = omega, gamma
    panels = np.arange(len(g1))
    across = p * g1 + q * g2
    square = g1 * g1 + g2 * g2
    fastest = (p * p + q * q + r * r).max(axis=1)
    step = length * rule.gap
    upper = np.where(g3[panels, square.argmin(axis=1)] < 0, -1, 1).astype(g3.dtype)[:, None]
    near = square <= (fastest * step * step)[:, None]
    close = near.any(axis=1)
    sure = ~(near & (g3 * upper < 0)).any(axis=1)
    both = length * ((r * upper + across / (1 + g3 * upper)) @ weights)
    start, end = (np.arctan2(g1[:, i] + 0.0, g2[:, i]) for i in (0, -1))
    phi = end - start + 2 * _PI * _crossings(g1, g2)
    psi = both - upper[:, 0] * phi
    for k in np.flatnonzero(close).tolist():
        if not across[k].any():  # in a plane with the third axis, over the pole or not
            psi[k], phi[k], sure[k] = 0, length[k] * (r[k] @ weights), True
        elif sure[k]:
            sure[k] = _chords_pass(omega[:, k], gamma[:, k], length[k] * np.diff(rule.nodes))
    return psi, phi, sure


def _crossings(g1: Any, g2: Any) -> Any:
    """How often phi = atan2(g1, g2) comes over pi, counted with its sign, chord by chord."""
    negative = g1 < 0
    panel, node = np.nonzero(negative[:, 1:] != negative[:, :-1])
    a1, a2, b1, b2 = g1[panel, node], g2[panel, node], g1[panel, node + 1], g2[panel, node + 1]
    below = (a2 * b1 - b2 * a1) * (b1 - a1) < 0
    sense = np.where(negative[panel, node], -1, 1) * below
    return np.bincount(panel, sense, len(g1))


def _chords_pass(omega: Any, gamma: Any, step: Any) -> bool:
    """Whether gamma's path passes the pole on the side on which its chords do."""
    (p, q, r), (g1, g2, g3) = omega, gamma
    x, y = g1, g2
    speed = np.stack([g2 * r - g3 * q, g3 * p - g1 * r])
    bend = np.hypot(*np.diff(speed, axis=1)) * np.abs(step) / 8
    dx, dy = np.diff(x), np.diff(y)
    square = dx * dx + dy * dy
    along = np.clip(-(x[:-1] * dx + y[:-1] * dy) / np.where(square > 0, square, 1), 0, 1)
    away = np.hypot(x[:-1] + along * dx, y[:-1] + along * dy)
    return bool((away > _CHORD * bend).all())
