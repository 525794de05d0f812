"""The tangents that a growth is followed from, one a motion."""

from __future__ import annotations

import numpy as np

from polhode.numbers.rows import Doubles

SEED = 18


def tangents_of(
    starts: Doubles, moments: Doubles, torques: Doubles, alike: bool = False
) -> Doubles:
    """Unit tangents across the flow and the gradients of h, f and |gamma|^2, else at random.

    ``alike``: the random part is the same for all, so that none depends on the others.
    """
    shape = starts.shape[1:] if alike else starts.shape
    tangents = np.random.default_rng(SEED).normal(size=shape) + 0 * starts
    w, g = starts[:, :3], starts[:, 3:]
    G = w * moments
    zero = np.zeros_like(g)
    flow = np.concatenate(
        [(np.cross(g, torques) - np.cross(w, G)) / moments, np.cross(g, w)], axis=1
    )
    across = [
        np.concatenate([G, torques], axis=1),
        np.concatenate([g * moments, G], axis=1),
        np.concatenate([zero, g], axis=1),
        flow,
    ]
    basis: list[Doubles] = []
    for vector in across:  # Gram and Schmidt, twice
        for _ in range(2):
            for other in basis:
                vector = vector - (vector * other).sum(axis=1)[:, None] * other
        size = np.sqrt((vector * vector).sum(axis=1))[:, None]
        basis.append(np.where(size > 1e-12, vector / np.maximum(size, 1e-300), 0.0))
    for _ in range(2):
        for other in basis:
            tangents = tangents - (tangents * other).sum(axis=1)[:, None] * other
    unit: Doubles = tangents / np.sqrt((tangents * tangents).sum(axis=1))[:, None]
    return unit
