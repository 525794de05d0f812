"""Many motions at once in double, by Taylor series: guesses for the search.

Not trusted.  States are (6, n); where a motion is wanted backward, w has its sign changed, which
turns the time round.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.enclosures.fixed_point_problem import Motion
from polhode.equations.terms import LAYERS, LEFT, RIGHT, layered
from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles
from polhode.numbers.vectors import cross

Whole = npt.NDArray[np.intp]

_DEGREE = 20
_SHORTER = 0.15  # of the radius of convergence that the last coefficients tell
_ROUGH, _ROUGHLY = 12, 0.22  # degree and step where guesses are looked for: right to 1e-8
_LONGEST = 1.0
_HALVED = 24  # times, of half a step in which a maximum lies
_BACK = np.array([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0])[:, None]


class Crossings(NamedTuple):
    """Where lanes met the section: lane, count on it, time, state (6, m)."""

    lane: Whole
    number: Whole
    time: Doubles
    state: Doubles


@dataclass(frozen=True)
class Lanes:
    """A body's motions in the proof's unit of time."""

    constants: tuple[float, ...]
    moments: Doubles
    torque: Doubles

    @classmethod
    def of(cls, what: Motion) -> Lanes:
        """Those of an exact motion's body."""
        constants = tuple(to_double(x) for x in what.constants)
        moments, torque = ([to_double(x) for x in row] for row in (what.moments, what.torque))
        return cls(constants, np.array(moments), np.array(torque))

    def series(self, states: Doubles, degree: int = _DEGREE) -> Doubles:
        """Taylor coefficients by the time, (degree + 1, 6, n)."""
        of_layers = [layer.coefficients(self.constants) for layer in LAYERS]
        coefficients = [None if c is None else np.array(c)[:, None] for c in of_layers]
        found = np.zeros((degree + 1, *states.shape))
        left = np.zeros((degree + 1, len(LEFT), states.shape[1]))
        right = np.zeros_like(left)
        found[0] = states
        for k in range(degree):
            left[k], right[k] = found[k][LEFT], found[k][RIGHT]
            products = np.einsum("kin,kin->in", left[: k + 1], right[k::-1])
            found[k + 1, :3], found[k + 1, 3:] = layered(products, found[k], coefficients)
            found[k + 1] /= k + 1
        return found

    def field(self, states: Doubles) -> Doubles:
        """The right-hand sides, (6, n)."""
        return np.asarray(self.series(states, 1)[1])

    def gradients(self, state: Doubles) -> Doubles:
        """Those of energy, vertical momentum and |gamma|^2, each a constant times it: (3, 6)."""
        w, gamma = state[:3], state[3:]
        momentum, scale = self.moments * w, max(self.moments)
        energy = np.concatenate([momentum, self.torque]) / scale
        area = np.concatenate([self.moments * gamma, momentum]) / scale
        return np.array([energy, area, [*np.zeros(3), *gamma]])

    def after(self, states: Doubles, times: Doubles) -> Doubles:
        """The states after times of their own, of any sign."""
        signs = np.where(times < 0.0, -1.0, 1.0)
        turn = np.where(signs < 0.0, _BACK, 1.0)
        now, left = states * turn, np.abs(times)
        while np.any(left > 0.0):
            found = self.series(now)
            step = np.minimum(left, _step(found))
            now = _value(found, step)
            left = left - step
        return np.asarray(now * turn)

    def crossings(self, states: Doubles, span: float) -> Crossings:
        """Maxima of the height of the centre of mass within a time."""
        lanes = np.arange(states.shape[1])
        now, time = states.copy(), np.zeros(states.shape[1])
        counts = np.zeros(states.shape[1], dtype=np.intp)
        found: list[tuple[Whole, Whole, Doubles, Doubles]] = []
        while np.any(time < span):
            series = self.series(now, _ROUGH)
            step = np.minimum(span - time, _step(series, _ROUGHLY))
            begin = self._rise(now)
            for part in (0.5, 1.0):
                end = self._rise(_value(series, part * step))
                met = np.nonzero((begin > 0.0) & (end <= 0.0))[0]
                begin = end
                if not met.size:
                    continue
                low, high = (part - 0.5) * step[met], part * step[met]
                some = series[:, :, met]
                for _ in range(_HALVED):
                    middle = (low + high) / 2
                    up = self._rise(_value(some, middle)) > 0.0
                    low, high = np.where(up, middle, low), np.where(up, high, middle)
                found.append((lanes[met], counts[met], time[met] + low, _value(some, low)))
                counts[met] += 1
            now, time = _value(series, step), time + step
        if not found:
            empty = np.zeros(0, dtype=np.intp)
            return Crossings(empty, empty, np.zeros(0), np.zeros((6, 0)))
        return Crossings(
            np.concatenate([row[0] for row in found]),
            np.concatenate([row[1] for row in found]),
            np.concatenate([row[2] for row in found]),
            np.concatenate([row[3] for row in found], axis=1),
        )

    def derivative(self, states: Doubles, times: Doubles) -> Doubles:
        """The derivatives of the flow, (n, 6, 6), by central differences."""
        count, off = states.shape[1], 1e-6
        steps = off * np.hstack([np.eye(6), -np.eye(6)])
        many = (states[:, :, None] + steps[:, None, :]).reshape(6, -1)
        ends = self.after(many, np.repeat(times, 12)).reshape(6, count, 12)
        return np.asarray((ends[..., :6] - ends[..., 6:]).transpose(1, 0, 2) / (2 * off))

    def _rise(self, states: Doubles) -> Doubles:
        """The rate of the height."""
        rates = cross(states[3:], states[:3])
        return np.asarray(sum(k * rate for k, rate in zip(self.torque, rates, strict=True)))


def backward(states: Doubles) -> Doubles:
    """The states whose motions are these run backward."""
    return np.asarray(states * _BACK)


def _step(series: Doubles, part: float = _SHORTER) -> Doubles:
    """Lengths of steps, a part of the radius of convergence."""
    last = np.maximum(np.max(np.abs(series[-1]), axis=0), 1e-300)
    before = np.maximum(np.max(np.abs(series[-2]), axis=0), 1e-300)
    degree = series.shape[0] - 1
    radius = np.minimum(last ** (-1.0 / degree), before ** (-1.0 / (degree - 1)))
    return np.asarray(np.minimum(_LONGEST, part * radius))


def _value(series: Doubles, step: Doubles) -> Doubles:
    found = series[-1]
    for row in series[-2::-1]:
        found = found * step + row
    return np.asarray(found)
