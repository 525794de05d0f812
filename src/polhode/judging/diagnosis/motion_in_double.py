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
from polhode.numbers.number_types import DOUBLE
from polhode.scenes.scene import Scene


def integrated(scene: Scene, times: Sequence[Fraction], attitude: bool = True) -> Right | None:
    """The motion, its attitude too where it has one; None where it cannot be integrated so far."""
    from polhode.runs.solve import solve

    found: dict[Fraction, tuple[Any, Any]] = {}
    turning = attitude and bool(scene.columns[3:])
    asked = replace(scene, outputs=("attitude",) if turning else (), events=())
    try:
        for part in by_sign(times):
            run = solve(asked.at(part), DOUBLE, interruptible=False)
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
