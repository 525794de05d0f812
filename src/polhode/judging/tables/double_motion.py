"""The motion at any times in doubles: dearer digits are not needed to tell what a table means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.reference import by_sign
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE, Doubles, NumberType
from polhode.scenes.scene import Scene

FARTHEST = 1e6  # radians, to which the steps of a run do not go


def matrices(quaternions: Any) -> Doubles:
    """R (body -> space) of quaternions, scalar first, of any length but 0; shape (n, 3, 3)."""
    with np.errstate(invalid="ignore", divide="ignore"):
        length = np.linalg.norm(quaternions, axis=1, keepdims=True)
        a, b, c, d = (quaternions / np.where(length == 0, 1, length)).T
    rows = [
        [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
    ]
    return np.array(rows).transpose(2, 0, 1)


class Right(NamedTuple):
    """What the reference has at the rows' times."""

    states: Doubles
    attitude: Doubles | None = None  # None where not known
    matrices: Doubles | None = None  # body -> space, likewise

    def part(self, name: str) -> Doubles:
        """A part's numbers; of attitudes and angles the elements of the matrices."""
        if name in ("omega", "gamma"):
            return self.states[:, :3] if name == "omega" else self.states[:, 3:]
        assert self.matrices is not None
        return self.matrices.reshape(len(self.matrices), -1)

    def moved(self, part: str) -> Doubles:
        """How far a part is from its first row, in the measure that its errors are told in."""
        values = self.part(part)
        return errors_of_rows(values, values[0]) / size_of_motion(values, part == "omega")


def errors_of_rows(values: Any, true: Any) -> Doubles:
    """The largest difference in each row."""
    largest: Doubles = np.abs(values - true).reshape(len(values), -1).max(axis=1)
    return largest


def size_of_motion(true: Any, relative: bool) -> float:
    """What errors are told in."""
    return (float(np.max(np.linalg.norm(true, axis=1))) if relative else 1.0) or 1.0


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
    plain = replace(scene, outputs=("attitude",) if turning else (), events=())
    parts = by_sign(times)
    states, attitudes = [], []
    try:
        for part in parts:
            run = solve(plain.at(part), number, interruptible=False)
            if len(run.times) < len(part):
                return None
            states.append(np.asarray(run.states, dtype=float))
            if turning:
                attitudes.append(np.asarray(run.attitude, dtype=float))
    except (BadInput, ImportError, ValueError, OverflowError):
        return None
    places = {t: k for k, t in enumerate(chain(*parts))}
    order = [places[t] for t in times]
    rows = np.concatenate(states)[order]
    if not turning:
        return Right(rows)
    quaternions = np.concatenate(attitudes)[order]
    return Right(rows, quaternions, matrices(quaternions))
