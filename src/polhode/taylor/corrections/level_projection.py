"""Columns of states put back on the first integrals of their level, in numpy."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from polhode.equations.integrals import FirstIntegrals
from polhode.equations.section_functions import SectionZero
from polhode.numbers.rows import Complexes, Doubles, Flat, Indices
from polhode.numbers.scalars import Functions, Scalar
from polhode.taylor.corrections.integral_projection import least_norm

ARRAYS = Functions(0.0, np.sin, np.cos, np.sqrt)
TINY = 1e-30  # of a complex step

_NO_ROUNDING = 1e-8  # a step as large as that is none of rounding's, and is not made
_DAMPING, _FLOOR = 1 + 2.0**-18, 2.0**-256  # see polhode.taylor.corrections.integral_projection


class Level(NamedTuple):
    """The integrals to which states are put back, with their coefficients as longdoubles.

    ``targets``: of h, f and |gamma|^2 (shared); the fourth is each orbit's own.
    """

    integrals: FirstIntegrals
    coefficients: Mapping[str, np.longdouble]
    targets: tuple[np.longdouble, ...]


class Put:
    """Puts columns of states back on their level by one least-norm step of Newton's method.

    Residuals are longdoubles, the step is of doubles.  ``drift``: the largest residual met so far
    of h, f and |gamma|^2, relative.
    """

    def __init__(self, level: Level, starts: Doubles) -> None:
        self.level = level
        self.drift = 0.0
        self._plain = {name: float(x) for name, x in level.coefficients.items()}
        own = self._values(starts.astype(np.longdouble))
        shared = len(level.targets)
        self.targets = np.array([x + 0 * own[0] for x in level.targets] + own[shared:])
        h, f = np.abs(self.targets[:2].astype(float))
        around = np.abs(np.array(own[:1], dtype=float))[0]
        energy = np.maximum(h, around) + 1e-300
        self.scales = np.array([energy, np.maximum(f, np.sqrt(energy)), 1 + 0 * energy])

    def begin(self, lanes: list[int], starts: Doubles) -> None:
        """Other orbits begin in some lanes."""
        fresh = Put(self.level, starts)
        self.targets[:, lanes], self.scales[:, lanes] = fresh.targets, fresh.scales

    def of(self, orbits: Indices) -> Put:
        """The same for these orbits, one a column."""
        found = copy.copy(self)
        found.targets, found.scales = self.targets[:, orbits], self.scales[:, orbits]
        return found

    def back(self, state: Doubles) -> Doubles:
        """The states put back; as they are where the step is no rounding."""
        residuals = self._residuals(state)
        off = np.abs(residuals[:3]) / self.scales
        self.drift = max(self.drift, float(np.max(off, initial=0.0, where=np.isfinite(off))))
        return self._stepped(state, self._gradients(_moved(state)), [*residuals])

    def within(self, zero: SectionZero, state: Doubles) -> Doubles:
        """The states put back on level and section at once, so that they leave neither."""
        moved = _moved(state)
        with np.errstate(all="ignore"):
            across = np.imag(zero.value(list(moved), ARRAYS)) / TINY
            value = np.real(zero.value(list(state), ARRAYS))
        rows = [*self._gradients(moved), across]
        return self._stepped(state, rows, [*self._residuals(state), -value])

    def _residuals(self, state: Doubles) -> Doubles:
        values = self._values(state.astype(np.longdouble))
        found: Doubles = (self.targets - np.array(values)).astype(float)
        return found

    def _gradients(self, moved: Complexes) -> list[Doubles]:
        """Of the integrals, from complex steps along each component."""
        values = self.level.integrals.values(list(moved), self._plain, 0 * moved[0])
        return [np.imag(value) / TINY for value in values]

    def _stepped(
        self, state: Doubles, rows: Sequence[Doubles], residuals: Sequence[Doubles]
    ) -> Doubles:
        with np.errstate(all="ignore"):
            step = np.array(least_norm(rows, residuals, _DAMPING, _FLOOR, 0.0))
            size = np.sqrt((step * step).sum(axis=0))
        return np.where(size < _NO_ROUNDING, state + step, state)

    def _values(self, state: Flat) -> list[Scalar]:
        return self.level.integrals.values(list(state), self.level.coefficients, 0 * state[0])


def _moved(state: Doubles) -> Complexes:
    """Each column six times, a component of each beside itself by a complex step."""
    return state[:, None, :] + TINY * 1j * np.eye(6)[:, :, None]
