"""The motion at any times in doubles: dearer digits are not needed to tell what a table means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.diagnosis.ways import Right
from polhode.judging.references.reference import by_sign
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.scenes.scene import Scene

FARTHEST = 1e6  # radians, to which the steps of a run do not go


def integrated(
    scene: Scene, times: Sequence[Fraction], attitude: bool = True, number: NumberType = DOUBLE
) -> Right | None:
    """The motion, its attitude too where it has one; None where it cannot be integrated so far.

    ``number``: the type in which it is integrated.
    """
    if max((abs(to_double(t)) for t in times), default=0.0) * 10.0**scene.log10_rate > FARTHEST:
        return None
    from polhode.runs.solve import solve

    turning = attitude and bool(scene.columns[3:])
    asked = replace(scene, outputs=("attitude",) if turning else (), events=())
    parts = by_sign(times)
    states, turned = [], []
    try:
        for part in parts:
            run = solve(asked.at(part), number, interruptible=False)
            if len(run.times) < len(part):
                return None
            states.append(np.asarray(run.states, dtype=float))
            if turning:
                turned.append(np.asarray(run.attitude, dtype=float))
    except (BadInput, ImportError, ValueError, OverflowError):
        return None
    places = {t: k for k, t in enumerate(chain(*parts))}
    order = [places[t] for t in times]
    rows = np.concatenate(states)[order]
    if not turning:
        return Right(rows)
    quaternions = np.concatenate(turned)[order]
    return Right(rows, quaternions, matrices(quaternions))
