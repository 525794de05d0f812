"""The unit of a table's times: how far its first row after the start has come tells.

The scene says how fast omega, gamma and the attitude change at the start.  Where a table changes by
a thousandth of that in its first row, for each part alike, its t looks like milliseconds.  Words
for other times stand here, too.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.equations.plain_field import field
from polhode.judging.tables.reading import TimeChange
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.decimals import in_full
from polhode.numbers.expression import decimal
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, STATE

_NEAR = 1e-3  # a first row to the start
_OFF = 0.3  # of 1: by how much a chord of the first row may differ from the start's speed


class TimeUnit(NamedTuple):
    """A unit by its name, in the scene's."""

    name: str
    length: Fraction


UNITS = (
    TimeUnit("milliseconds", Fraction(1, 1000)),
    TimeUnit("microseconds", Fraction(1, 1_000_000)),
    TimeUnit("nanoseconds", Fraction(1, 1_000_000_000)),
    TimeUnit("minutes", Fraction(60)),
)


_TOLD = re.compile(
    rf"t of another clock(?: in ({'|'.join(unit.name for unit in UNITS)}))?:"
    r" rows belong to t ([-+]) (\d+(?:\.\d+)?)"
)


def clock_words(change: TimeChange) -> str:
    """What rows of another clock are called.

    >>> clock_words(TimeChange(shift=Fraction(25, 2)))
    'of another clock: rows belong to t - 12.5'
    """
    unit = next((f" in {unit.name}" for unit in UNITS if unit.length == change.unit), "")
    sign = "-" if change.shift > 0 else "+"
    return f"of another clock{unit}: rows belong to t {sign} {in_full(abs(change.shift))}"


def told_clock(words: str) -> TimeChange | None:
    """The change of times that the words of a clock tell; None where they tell none.

    >>> told_clock("t of another clock: rows belong to t - 12.5").of(Fraction(15))
    Fraction(5, 2)
    """
    found = _TOLD.fullmatch(words)
    if found is None:
        return None
    unit = next((x.length for x in UNITS if x.name == found[1]), Fraction(1))
    shift = decimal(found[3])
    return TimeChange(unit=unit, shift=shift if found[2] == "-" else -shift)


def time_unit(subject: Table, scene: Scene) -> TimeUnit | None:
    """The unit in which the times look right that are not the scene's; None where there is none."""
    later = [k for k, t in enumerate(subject.times) if t != 0]
    if not later:
        return None
    row = min(later, key=lambda k: abs(subject.times[k]))
    try:
        with np.errstate(all="ignore"):
            ratios = [*_ratios(subject, scene, row)]
    except (OverflowError, ZeroDivisionError):  # numbers beyond doubles
        return None
    for unit in UNITS:
        if ratios and all(abs(x / float(unit.length) - 1) < _OFF for x in ratios):
            return unit
    return None


def begins_at_start(subject: Table, row: int, scene: Scene) -> bool:
    """Whether a row is nearly the scene's state at t = 0, or there is none of the state."""
    found = []
    for here, there, _ in _halves(subject, scene, row):
        size = float(np.linalg.norm(there)) or 1.0
        found.append(float(np.linalg.norm(here - there)) < _NEAR * size)
    return all(found) if found else bool({*ATTITUDE} & subject.columns.keys())


def _ratios(subject: Table, scene: Scene, row: int) -> Iterator[float]:
    """Changes to a row over those by the start's speed, of each part that is there."""
    t = abs(to_double(subject.times[row]))
    if not 0 < t < math.inf:  # no double
        return
    for here, before, speeds in _halves(subject, scene, row):
        speed = float(np.linalg.norm(speeds))
        if speed > 0:
            yield float(np.linalg.norm(here - before)) / (t * speed)
    if 0 in subject.times:
        q = [_numbers(subject, ATTITUDE, k) for k in (row, subject.times.index(0))]
        speed = float(np.linalg.norm([to_double(x) for x in scene.omega]))
        if q[0] is not None and q[1] is not None and speed > 0:
            sizes = float(np.linalg.norm(q[0])) * float(np.linalg.norm(q[1])) or 1.0
            cosine = min(1.0, abs(float(q[0] @ q[1])) / sizes)
            yield 2 * math.acos(cosine) / (t * speed)


def _halves(subject: Table, scene: Scene, row: int) -> Iterator[tuple[Doubles, Doubles, Doubles]]:
    """omega and gamma in a row, where they are there, at the start, and their rates there."""
    start = np.array([to_double(x) for x in scene.start])
    rates = field(scene)(0.0, start)
    for half in (slice(0, 3), slice(3, 6)):
        here = _numbers(subject, STATE[half], row)
        if here is not None and len(start[half]) == 3:
            yield here, start[half], rates[half]


def _numbers(subject: Table, names: Iterable[str], row: int) -> Doubles | None:
    """Some columns in a row; None where a cell is not there."""
    cells = [subject.columns[name][row] for name in names if name in subject.columns]
    whole = len(cells) == len([*names]) and None not in cells
    return np.array([to_double(exactly(x)) for x in cells]) if whole else None
