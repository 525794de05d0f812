"""Worlds: the motions that a table may be of, beside the scene's at the times as they stand.

Each is the scene's motion at other times (:mod:`other_times`), or that of another scene, with a
sign or an order of numbers that is often another; all in double.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.diagnosis.motion_in_double import integrated
from polhode.judging.diagnosis.other_times import other_times
from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.diagnosis.ways import Right
from polhode.judging.tables.reading import TimeChange
from polhode.numbers.exact import Exact
from polhode.numbers.vectors import Matrix
from polhode.scenes.body import exact_vector
from polhode.scenes.scene import Scene

_FARTHEST = (1e4, 1e5)  # radians or so, to which motions at other times are followed
_FEWEST = 2  # rows that tell other times
_POLE = 1e-9  # the sine of theta where psi and phi are one angle


class World(NamedTuple):
    """What a table may be a motion of, in words: the scene's motion at times that are changed, or
    another scene's.

    ``right``: the motion at the first of the rows, as far as it is followed.  ``change``: of the
    times; None of another scene, which no table is read as.
    """

    words: str
    right: Right
    change: TimeChange | None = None


def other_worlds(
    times: Sequence[Fraction], all_times: Sequence[Fraction], scene: Scene
) -> Iterator[World]:
    """The motion at other times, and those of other scenes that may be meant."""
    yield from at_times(other_times(all_times), times, scene)
    for words, other in other_scenes(scene):
        right = integrated(other, times)
        if right is not None:
            yield World(words, right)


def at_times(
    changes: Mapping[str, TimeChange], times: Sequence[Fraction], scene: Scene
) -> Iterator[World]:
    """The motion at changed times, as far as it is followed, near times before far ones."""
    rate = 10.0**scene.log10_rate
    moved = {words: [change.of(t) for t in times] for words, change in changes.items()}
    for words in sorted(moved, key=lambda words: max(map(abs, moved[words]))):
        some = moved[words]
        for farthest in _FARTHEST:
            far = [k for k, t in enumerate(some) if abs(t) * rate > farthest]
            there = some[: far[0]] if far else some
            if len(there) >= _FEWEST:
                break
        right = integrated(scene, there) if len(there) >= _FEWEST else None
        if right is not None:
            yield World(words, right, changes[words])


def other_scenes(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Scenes with a sign or an order of numbers that is often another."""
    body = scene.body
    if body.weight:
        yield "a weight of the other sign", with_body(scene, body.inertia, -body.weight)
    products = [(i, j) for i in range(3) for j in range(i) if body.inertia[i][j] != 0]
    some = [products, *([one] for one in products)] if len(products) > 1 else [products]
    for signs in filter(None, some):
        x, y, z = (
            exact_vector([-m if {(i, j), (j, i)} & {*signs} else m for j, m in enumerate(row)])
            for i, row in enumerate(body.inertia)
        )
        names = ", ".join("I" + "xyz"[j] + "xyz"[i] for i, j in signs)
        words = f"products of inertia of the other sign ({names})"
        with suppress(BadInput, ValueError):  # moments of no body
            yield words, with_body(scene, (x, y, z), body.weight)
    if scene.columns[3:] and "quaternion" in scene.source:
        start = integrated(scene, [Fraction(0)])
        if start is not None and start.attitude is not None:
            a, b, c, d = start.attitude[0]
            turned = _with_attitude(scene, (d, a, b, c))
            yield "the scene's quaternion taken as scalar-last", turned


def with_body(scene: Scene, inertia: Matrix, weight: Exact | None = None) -> Scene:
    """The scene of another inertia, and of another weight unless it is None."""
    weight = scene.body.weight if weight is None else weight
    return replace(scene, body=scene.body.replaced(inertia=inertia, weight=weight))


def _with_attitude(scene: Scene, given: Sequence[float]) -> Scene:
    """The scene from another attitude, a quaternion, scalar first."""
    (turned,) = matrices(np.array([given]))
    x, y = turned[0, 2], -turned[1, 2]  # the sine of theta times those of psi
    if math.hypot(x, y) < _POLE:
        x, y = turned[1, 0], turned[0, 0]
    gamma = exact_vector([float(z) for z in turned[2]])
    return replace(scene, gamma=gamma, psi=Fraction(math.atan2(x, y)), normalise=True)
