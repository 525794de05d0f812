"""Rows that belong to other times: those of a clock, or of a program that was started later.

The first row is looked for along the scene's motion, in double: near where the motion passes it,
Newton's method on the motion's own rate finds the time, and the rows that follow tell the unit and
which passage it is.  The offset between the times is the shortest decimal that fits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.equations.integrals import departures
from polhode.equations.plain_field import field
from polhode.judging.diagnosis.motion_in_double import sampled
from polhode.judging.diagnosis.other_times import UNITS, clock_words, from_first_row
from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.diagnosis.ways import Right
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
_MOST = 40  # times at which the first row is looked for
_FITS = 6  # Newton's steps
_AS_GOOD = 1.0  # digits by which a time nearer to 0 may be behind the best
_FEWEST = 9  # numbers that a time is fitted to
_SAME = 1e-2  # of integrals: the first row is on the scene's level
_ROUNDING = 4 * 2.0**-52
_SPARED = 3  # decimal places that a short offset does not need

#: What is compared with the motion: the parts of it whose numbers are.
Signal: TypeAlias = tuple[str, ...]


class Clock(NamedTuple):
    """Times at which rows hold instead, in words, and by how much the offset may be off: 0 of one
    that is a short decimal; None of the first time itself.

    ``entire``: whether all numbers of the state are the motion's then, and not some of them.
    """

    words: str
    change: TimeChange
    off: float | None
    entire: bool = False


def clock(
    parts: Mapping[str, Doubles], times: Sequence[Fraction], error: float, scene: Scene
) -> Clock | None:
    """The offset at which rows, the first ones of a table, belong to the scene's motion; None
    where there is none, or where they belong to the times that they have.

    ``times``: the nearest to 0 first.  ``error``: by how much they may be off.
    """
    if any(np.max(np.abs(values)) > _LARGEST for values in parts.values()):
        return None
    rate = 10.0**scene.log10_rate
    if not rate:  # a body at rest tells no time
        return None
    wanted = [*_signals(parts)]
    far = REACHES if _on_level(parts, scene) else REACHES[:2]
    for reach in far if wanted else ():
        count = math.ceil(reach / _STEP)
        grid = np.arange(-count, count + 1) * (_STEP / rate)
        motion = sampled(scene, grid, "attitude" in parts)
        if motion is None:
            return None
        for number, (signal, values) in enumerate(wanted):
            path = _Path(scene, signal, rate)
            place = path.place(values, times, grid[_starts(path.values(motion), values[0])])
            if place is not None:
                off = place.off + error * to_double(place.unit)
                found = _clock(Fraction(place.time), off, place.unit, times)
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


def _clock(time: Fraction, off: float, unit: Fraction, times: Sequence[Fraction]) -> Clock | None:
    """The clock of rows of which the one that is nearest to t = 0 belongs to a time that is off by
    so much at most."""
    offset, ordered = unit * times[0] - time, sorted(times)
    step = unit * (ordered[1] - ordered[0]) if len(times) > 1 else Fraction(0)
    if abs(offset) <= step + Fraction(off):  # told as a step late or early, or as a cause
        return None
    first = unit * ordered[0]
    if abs(first - offset) <= off:
        words = from_first_row(ordered[0], unit)
        return Clock(words, TimeChange(unit=unit, shift=first), None)
    shift, short = _shortest(offset, Fraction(off))
    change = TimeChange(unit=unit, shift=shift)
    return Clock(clock_words(change), change, 0.0 if short else off)


def _shortest(x: Fraction, off: Fraction) -> tuple[Fraction, bool]:
    """The shortest decimal that is near enough, and whether it is shorter than any would be."""
    last = math.ceil(-math.log10(off))
    for places in range(-math.ceil(math.log10(1 + abs(x))), last + 2):
        unit = Fraction(10) ** -places
        rounded = round(x / unit) * unit
        if abs(rounded - x) <= off:
            return rounded, places <= last - _SPARED
    return x, False


def _on_level(parts: Mapping[str, Doubles], scene: Scene) -> bool:
    """Whether the first row has the scene's integrals, so that it is worth while to look far."""
    if not {"omega", "gamma"} <= {*parts}:
        return False
    state = _joined([parts["omega"][:1], parts["gamma"][:1]])
    return all(abs(float(x[0])) < _SAME for x in departures(scene, state).values())


def _signals(parts: Mapping[str, Doubles]) -> Iterator[tuple[Signal, Doubles]]:
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
    near = (away <= before) & (away <= after) & (away <= _NEAR * step) & (step > 0)
    kept = sorted(np.flatnonzero(near), key=lambda k: float(away[k] / step[k]))
    return [int(k) for k in kept[:_MOST]]


class _Place(NamedTuple):
    """The time of the first row on the motion, the unit of the rows' times, and by how much the
    time may be off."""

    time: float
    unit: Fraction
    off: float


class _Path(NamedTuple):
    """The motion, as far as rows tell of it; ``rate``: of the scene, radians per unit of time."""

    scene: Scene
    signal: Signal
    rate: float

    def place(self, rows: Doubles, times: Sequence[Fraction], starts: Doubles) -> _Place | None:
        """Where rows begin, near one of several times: of those places that fit about as well as
        the best one the nearest to 0; None where none fits."""
        places, speeds = self._passages(rows[0], starts)
        found: list[tuple[float, _Place]] = []
        for unit in (Fraction(1), *(unit.length for unit in UNITS)):
            since = np.array([to_double(unit * (t - times[0])) for t in times])
            if not len(places) or np.max(np.abs(since)) * self.rate > 2 * REACHES[-1]:
                continue
            motion = self._at(np.add.outer(places, since).ravel())
            if motion is None:
                continue
            there = self.values(motion).reshape(len(places), -1)
            worst = np.max(np.abs(there - rows.ravel()), axis=1) / self._size(there)
            for place, error, speed in zip(places, worst, speeds, strict=True):
                left = max(float(error), _ROUNDING)
                off = 2 * left / speed + _ROUNDING * abs(place)
                found.append((-math.log10(left), _Place(float(place), unit, float(off))))
        most = max((digits for digits, _ in found), default=0.0)
        fits = [one for digits, one in found if digits >= max(most - _AS_GOOD, WRONG)]
        return min(fits, key=lambda one: abs(one.time), default=None)

    def _passages(self, row: Doubles, times: Doubles) -> tuple[Doubles, Doubles]:
        """The times near others at which the motion passes a row, and its relative speeds there."""
        for _ in range(_FITS):
            motion = self._at(times) if len(times) else None
            if motion is None:
                return np.array([]), np.array([])
            here, rates = self.values(motion), self._rates(motion)
            square = np.einsum("nk,nk->n", rates, rates)
            moves = square > 0
            times, here, rates, square = times[moves], here[moves], rates[moves], square[moves]
            change = np.einsum("nk,nk->n", rates, row - here) / square
            times = times + np.clip(change, -_STEP / self.rate, _STEP / self.rate)
        return times, np.sqrt(square) / self._size(here) if len(times) else times

    def values(self, motion: Right) -> Doubles:
        """What the rows have of the motion."""
        return _joined(motion.part(name) for name in self.signal)

    def _rates(self, motion: Right) -> Doubles:
        """The rates of these."""
        if self.signal != ("attitude",):
            return self.values(Right(field(self.scene)(0.0, motion.states.T).T))
        assert motion.matrices is not None
        rates = np.cross(motion.matrices, motion.states[:, None, :3])  # of rows, as gamma's: 3.17
        return rates.reshape(len(rates), -1)

    def _at(self, times: Doubles) -> Right | None:
        return sampled(self.scene, times, self.signal == ("attitude",))

    def _size(self, values: Doubles) -> float:
        """What differences are told in."""
        least = 1.0 if self.signal == ("attitude",) else 0.0
        return max(least, float(np.max(np.abs(values)))) or 1.0
