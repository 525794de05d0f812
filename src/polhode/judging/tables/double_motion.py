"""The motion at any times in doubles: dearer digits are not needed to tell what a table means."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.judging.reference import in_double
from polhode.numbers.number_types import DOUBLE, Doubles, NumberType
from polhode.scenes.scene import Scene


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
    turning = attitude and bool(scene.columns[3:])
    rows = in_double(scene, times, ("attitude",) if turning else (), number)
    if not rows:
        return None
    states = np.asarray(rows["states"], dtype=float)
    if not turning:
        return Right(states)
    quaternions = np.asarray(rows["attitude"], dtype=float)
    return Right(states, quaternions, matrices(quaternions))
