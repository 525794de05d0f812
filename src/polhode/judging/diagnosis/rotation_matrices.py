"""Rotation matrices in doubles: of quaternions, of turns about axes, and of axes renamed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from polhode.numbers.rows import Doubles

SAME = (0, 1, 2)
#: Orders and signs of three axes: all 48, the axes as they are first, few changes before many.
AXES = sorted(
    itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3)),
    key=lambda axes: (sum(a != b for a, b in zip(axes[0], SAME, strict=True)), axes[1].count(-1)),
)
NEAR = 0.1  # how near to 0 or ±1 the entries of a matrix that renames axes are at once


def matrices(quaternions: Any) -> Doubles:
    """R (body -> space) of quaternions, scalar first, of any length but 0; shape (n, 3, 3)."""
    with np.errstate(invalid="ignore", divide="ignore"):
        length = np.linalg.norm(quaternions, axis=1, keepdims=True)
        a, b, c, d = (quaternions / np.where(length == 0, 1, length)).T
    found = [
        [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
    ]
    return np.array(found).transpose(2, 0, 1)


def turns(sequence: str, angles: Any) -> Doubles:
    """The product of turns about body axes, one after the other: R = R1(a1) R2(a2) R3(a3)."""
    found = np.broadcast_to(np.eye(3), (len(angles), 3, 3))
    for axis, angle in zip(sequence, angles.T, strict=True):
        i = "xyz".index(axis)
        j, k = (i + 1) % 3, (i + 2) % 3
        one = np.zeros((len(angle), 3, 3))
        one[:, i, i] = 1
        one[:, j, j] = one[:, k, k] = np.cos(angle)
        one[:, k, j], one[:, j, k] = np.sin(angle), -np.sin(angle)
        found = found @ one
    return found


def renaming(order: Sequence[int], signs: Sequence[int]) -> Doubles:
    """The matrix that takes a vector v to the one with ``signs[k] v[order[k]]``."""
    found = np.zeros((3, 3))
    for k, (source, sign) in enumerate(zip(order, signs, strict=True)):
        found[k, source] = sign
    return found


def nearest_renaming(matrix: Doubles) -> Doubles | None:
    """The axes' renaming that a matrix is nearly; None where it is none."""
    found = np.round(matrix)
    return found if np.max(np.abs(matrix - found)) < NEAR and not np.isnan(found).any() else None


def in_words(matrix: Doubles) -> str:
    """A renaming as ``x y z = x -z y``; empty where the axes stay."""
    order, signs = np.argmax(np.abs(matrix), axis=1), matrix.sum(axis=1)
    held = ["-" * bool(s < 0) + "xyz"[k] for s, k in zip(signs, order, strict=True)]
    return "" if held == ["x", "y", "z"] else f"x y z = {' '.join(held)}"


def rotation_in_words(matrix: Doubles) -> str:
    """A rotation as ``78.46° about (0.267, 0.535, 0.802)``, by 0 to 180 degrees."""
    m, trace = matrix, float(np.trace(matrix))
    twice = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    sine = float(np.linalg.norm(twice))
    axis = twice
    if trace < 1:  # more than a right angle: from the symmetric part, (1 - cos) n nᵀ
        symmetric = m + m.T + (1 - trace) * np.eye(3)
        axis = symmetric[:, int(np.argmax(np.diag(symmetric)))]
        axis = -axis if float(axis @ twice) < 0 else axis
    axis = (axis / (float(np.linalg.norm(axis)) or 1.0)).round(3) + 0.0
    angle = math.degrees(math.atan2(sine, trace - 1))
    return f"{angle:.4g}° about ({', '.join(f'{x:.3g}' for x in axis)})"


#: The 24 renamings that are turns, the axes as they are first.
TURNED = [m for m in (renaming(*axes) for axes in AXES) if np.linalg.det(m) > 0]


def quaternion(matrix: Doubles) -> tuple[int, ...]:
    """The quaternion of a renaming that is a turn, of some length, in small whole numbers."""
    trace = np.trace(matrix)
    m = matrix
    candidates = [
        (1 + trace, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]),
        (m[2, 1] - m[1, 2], 1 + 2 * m[0, 0] - trace, m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]),
        (m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 1 + 2 * m[1, 1] - trace, m[1, 2] + m[2, 1]),
        (m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1 + 2 * m[2, 2] - trace),
    ]
    best = max(candidates, key=lambda q: sum(x * x for x in q))
    least = min(abs(x) for x in best if x)
    return tuple(round(float(x / least)) for x in best)
