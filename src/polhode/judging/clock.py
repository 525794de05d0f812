"""Rows that belong to other times: those of a clock, or of a program that was started later.

The first rows are looked for along the scene's motion, in double: near where it passes the first
one, the time is fitted to those that follow.  The offset between the times is the shortest decimal
that fits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.equations.integrals import departures
from polhode.judging.diagnosis.conventions import whole_parts
from polhode.judging.diagnosis.motion_in_double import sampled
from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.diagnosis.time_unit import UNITS, clock_words
from polhode.judging.tables.reading import WRONG, TimeChange
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import brief
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene

REACHES = (1e2, 1e3, 4e3)  # radians on either side of t = 0 in which rows are looked for
_LARGEST = 1e100  # numbers that are looked for
_FAR = 1e5  # radians: few programs go so far, and none begins there
_STEP = 0.2  # radians between two times that are looked at
_NEAR = 2.0  # such steps from the motion to the first row, at most
_MOST = 40  # times that a fit begins at
_FITTED = 8  # of them that are fitted to more rows than the first
_FITS = 6  # Newton's steps
_ALIKE = 0.3  # of 1: how much the speed of rows may differ from the motion's
_SMALL = 1e-6  # radians: a change of time that a derivative is taken by
_AS_GOOD = 1.0  # digits by which a time nearer to 0 may be behind the best
_FEWEST = 9  # numbers that a time is fitted to
_SAME = 1e-2  # of integrals: the first row is on the scene's level
_ROUNDING = 4 * 2.0**-52
_SPARED = 3  # decimal places that a short offset does not need

#: What is compared with the motion: the parts of it whose numbers are.
Signal: TypeAlias = tuple[str, ...]


class Clock(NamedTuple):
    """Times at which rows hold instead, the digits of the first ones then, and by how much the
    offset may be off: 0 of one that is a short decimal; None of the first time itself.

    ``entire``: whether all numbers of the rows are the motion's then, and not some of them.
    """

    change: TimeChange
    digits: float
    off: float | None
    entire: bool = False

    @property
    def words(self) -> str:
        """The reading in words."""
        if self.off is None:
            return f"from its first row on ({brief(self.change.shift)})"
        return clock_words(self.change)


def clock(rows: Table, scene: Scene) -> Clock | None:
    """The offset at which rows, the first ones of a table, belong to the scene's motion; None
    where there is none, or where they belong to the times that they have."""
    parts, times = whole_parts(rows)
    if any(np.max(np.abs(values)) > _LARGEST for values in parts.values()):
        return None
    rate = 10.0**scene.log10_rate
    wanted = [*_signals(parts)]
    far = REACHES if _on_level(parts, scene) else REACHES[:2]
    for reach in far if wanted else ():
        count = math.ceil(reach / _STEP)
        grid = np.arange(-count, count + 1) * (_STEP / rate)
        motion = sampled(scene, grid, "attitude" in parts)
        if motion is None:
            return None
        for number, (signal, values) in enumerate(wanted):
            path = _joined(motion.part(name) for name in signal)
            starts = _starts(path, values[0])
            for unit in _units(path, starts, values, [t - times[0] for t in times], _STEP / rate):
                since = np.array([to_double(unit * (t - times[0])) for t in times])
                fit = _Fit(scene, signal, values, since, rate)
                best = fit.best(grid[starts])
                if best is not None and best[1] >= WRONG:
                    found = _clock(*best, unit, rows, times[0])
                    return found and found._replace(entire=number == 0)
    return None


def unknown_clock(subject: Table, scene: Scene, is_sought: bool = True) -> tuple[str, ...]:
    """That times that are far and close together look like a clock's, in words.

    ``is_sought``: whether the offset was looked for.
    """
    first, last = (to_double(end(subject.times)) for end in (min, max))
    nearest = min(abs(first), abs(last))
    if nearest * 10.0**scene.log10_rate < _FAR or last - first > nearest / 10:
        return ()
    began = f"t looks like a clock's ({brief(min(subject.times), 12)} to {last - first:.3g} later)"
    if not is_sought:
        named = "--read 't of another clock: rows belong to t - OFFSET' names one"
        return (f"{began}; no other origin of t is tried here ({named})",)
    return (f"{began}, and no offset was found at which its first rows belong to the motion",)


def _units(
    path: Doubles, starts: Sequence[int], values: Doubles, since: Sequence[Fraction], step: float
) -> Iterator[Fraction]:
    """The scene's unit of time, and those in which the rows change as fast as the motion."""
    yield Fraction(1)
    if len(since) == 1 or not starts:
        return
    change = float(np.linalg.norm(values[1] - values[0])) / abs(to_double(since[1]))
    speeds = np.linalg.norm(np.diff(path, axis=0), axis=1)[[min(k, len(path) - 2) for k in starts]]
    for unit in UNITS:
        ratios = change / (to_double(unit.length) / step * speeds[speeds > 0])
        if np.any(np.abs(ratios - 1) < _ALIKE):
            yield unit.length


def _clock(
    time: float, digits: float, off: float, unit: Fraction, rows: Table, nearest: Fraction
) -> Clock | None:
    """The clock of rows of which the one ``nearest`` to t = 0 belongs to a time that is off by so
    much at most."""
    off += rows.time_errors[0] * to_double(unit) if rows.time_errors else 0.0
    offset = unit * nearest - Fraction(time)
    step = unit * abs(rows.times[1] - rows.times[0]) if len(rows.times) > 1 else Fraction(0)
    if abs(offset) <= step + Fraction(off):  # told as a step late or early, or as a cause
        return None
    if abs(unit * rows.times[0] - offset) <= off:
        return Clock(TimeChange(unit=unit, shift=unit * rows.times[0]), digits, None)
    shift, short = _shortest(offset, Fraction(off))
    return Clock(TimeChange(unit=unit, shift=shift), digits, 0.0 if short else off)


def _shortest(x: Fraction, off: Fraction) -> tuple[Fraction, bool]:
    """The shortest decimal that is near enough, and whether it is shorter than any would be."""
    last = math.ceil(-math.log10(off))
    for places in range(-math.ceil(math.log10(1 + abs(x))), last + 2):
        unit = Fraction(10) ** -places
        rounded = round(x / unit) * unit
        if abs(rounded - x) <= off:
            return rounded, places <= last - _SPARED
    return x, False


def _on_level(parts: dict[str, Doubles], scene: Scene) -> bool:
    """Whether the first row has the scene's integrals, so that it is worth while to look far."""
    if not {"omega", "gamma"} <= {*parts}:
        return False
    state = _joined([parts["omega"][:1], parts["gamma"][:1]])
    return all(abs(float(x[0])) < _SAME for x in departures(scene, state).values())


def _signals(parts: dict[str, Doubles]) -> Iterator[tuple[Signal, Doubles]]:
    """What the rows have of the motion, in usual units: all of the state first."""

    held = dict(parts)
    if "attitude" in held:
        held["attitude"] = matrices(held["attitude"]).reshape(len(held["attitude"]), -1)
    for signal in (("omega", "gamma"), ("omega",), ("gamma",), ("attitude",)):
        if not {*signal} <= held.keys():
            continue
        values = _joined(held[name] for name in signal)
        if values.size >= _FEWEST:
            yield signal, values
            if signal == ("omega",):
                yield signal, np.radians(values)


def _joined(parts: Iterable[Doubles]) -> Doubles:
    """Arrays of the same rows side by side."""
    return np.concatenate([*parts], axis=1)


def _starts(motion: Doubles, row: Doubles) -> list[int]:
    """Places of a motion that are nearest to a row, and near."""
    scale = np.max(np.abs(motion), axis=0)
    scale[scale == 0] = 1.0
    away = np.max(np.abs(motion - row) / scale, axis=1)
    step = np.max(np.abs(np.diff(motion, axis=0)) / scale, axis=1)
    step = np.maximum(np.append(step, 0.0), np.insert(step, 0, 0.0))
    before, after = np.append(np.inf, away[:-1]), np.append(away[1:], np.inf)
    near = (away <= before) & (away <= after) & (away <= _NEAR * step)
    kept = sorted(np.flatnonzero(near), key=lambda k: float(away[k] / step[k]))
    return [int(k) for k in kept[:_MOST]]


class _Fit(NamedTuple):
    """Times of the first row that are fitted to rows ``since`` it, of which the motion tells."""

    scene: Scene
    signal: Signal
    values: Doubles
    since: Doubles
    rate: float

    def best(self, times: Doubles) -> tuple[float, float, float] | None:
        """The time of the first row that is nearest to 0 of those that fit best, the digits of the
        rows there, and by how much it may be off; None where no time can be fitted."""
        small = _SMALL / self.rate
        if not len(times) or float(np.max(np.abs(self.since))) * self.rate > 2 * REACHES[-1]:
            return None
        first = self._errors(times)
        if first is None:
            return None
        times = times[np.argsort(np.max(np.abs(first), axis=1))[:_FITTED]]
        for _ in range(_FITS):
            here, later = self._errors(times), self._errors(times + small)
            if here is None or later is None:
                return None
            slope = (later - here) / small
            square = np.einsum("nk,nk->n", slope, slope)
            square[square == 0] = np.inf
            change = -np.einsum("nk,nk->n", slope, here) / square
            times = times + np.clip(change, -_STEP / self.rate, _STEP / self.rate)
            if np.max(np.abs(change)) <= _ROUNDING * (np.max(np.abs(times)) + 1 / self.rate):
                break
        left = self._errors(times)
        if left is None:
            return None
        worst = np.maximum(np.max(np.abs(left), axis=1), _ROUNDING)
        digits = -np.log10(worst)
        best = min(np.flatnonzero(digits >= np.max(digits) - _AS_GOOD), key=lambda k: abs(times[k]))
        off = 2 * worst[best] / math.sqrt(square[best]) + _ROUNDING * abs(times[best])
        return float(times[best]), float(digits[best]), float(off)

    def _errors(self, times: Doubles) -> Doubles | None:
        """The differences of the rows from the motion where the first one is at each time."""
        wanted = np.add.outer(times, self.since).ravel()
        right = sampled(self.scene, wanted, self.values.shape[1] > 6)
        if right is None:
            return None
        motion = _joined(right.part(name) for name in self.signal)
        scale = np.maximum(1.0 if self.values.shape[1] > 6 else 0.0, np.max(np.abs(motion)))
        off = motion.reshape(len(times), *self.values.shape) - self.values
        found: Doubles = (off / scale).reshape(len(times), -1)
        return found
