"""The motion at any times in doubles: dearer digits are not needed to tell what a table means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.diagnosis.ways import Right
from polhode.judging.references.reference import by_sign
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene

FARTHEST = 1e6  # radians, to which the steps of a run do not go


def integrated(
    scene: Scene, times: Sequence[Fraction], attitude: bool = True, number: NumberType = DOUBLE
) -> Right | None:
    """The motion, its attitude too where it has one; None where it cannot be integrated so far.

    ``number``: the type in which it is integrated.
    """
    from polhode.runs.solve import solve

    if max((abs(to_double(t)) for t in times), default=0.0) * 10.0**scene.log10_rate > FARTHEST:
        return None
    found: dict[Fraction, tuple[Any, Any]] = {}
    turning = attitude and bool(scene.columns[3:])
    asked = _asked(scene, turning)
    try:
        for part in by_sign(times):
            run = solve(asked.at(part), number, interruptible=False)
            if len(run.times) < len(part):
                return None
            turns = run.attitude if run.attitude is not None else [None] * len(part)
            found |= dict(zip(part, zip(run.states, turns, strict=True), strict=True))
    except (BadInput, ImportError, ValueError, OverflowError):
        return None
    states = np.array([[float(x) for x in found[t][0]] for t in times])
    if not turning:
        return Right(states)
    turned = np.array([[float(x) for x in found[t][1]] for t in times])
    return Right(states, turned, matrices(turned))


def sampled(scene: Scene, times: Doubles, attitude: bool = False) -> Right | None:
    """The same at many times, in doubles: a run at no more times than there are different ones."""
    from polhode.runs.solve import solve

    turning = attitude and bool(scene.columns[3:])
    asked = _asked(scene, turning)
    states = np.empty((len(times), len(scene.columns)))
    turned = np.empty((len(times), 4))
    try:
        for there in (times >= 0, times < 0):
            part, places = np.unique(np.abs(times[there]), return_inverse=True)
            if not len(part):
                continue
            run = solve(
                asked.at(part if times[there][0] >= 0 else -part), DOUBLE, interruptible=False
            )
            if len(run.times) < len(part):
                return None
            states[there] = np.asarray(run.states, dtype=float)[places]
            if turning:
                turned[there] = np.asarray(run.attitude, dtype=float)[places]
    except (BadInput, ImportError, ValueError, OverflowError):
        return None
    return Right(states, turned, matrices(turned)) if turning else Right(states)


def _asked(scene: Scene, turning: bool) -> Scene:
    return replace(scene, outputs=("attitude",) if turning else (), events=())
