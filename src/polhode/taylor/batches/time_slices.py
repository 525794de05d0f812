"""The times of a sweep's members, cut where a check for Ctrl-C is due."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Doubles
from polhode.taylor.backend import defaults, heyoka_numbers
from polhode.taylor.backend.types import HeyokaNumber
from polhode.taylor.batches.compiled_batch import LANES
from polhode.taylor.batches.jobs import BatchJob

#: Internal time units (a radian or two of the fastest rate) between two checks for Ctrl-C, for
#: each step between them: at two or three steps a unit, a fifth of a second.
_UNITS_PER_STEP = Fraction(1, 4)


def longest(number: NumberType) -> Fraction:
    """How long a stretch may be, in the run's unit: what is no longer is not cut."""
    return defaults.of(number).chunk * _UNITS_PER_STEP


class Stretch(NamedTuple):
    """A part of the way: its end, the outputs in it, and where it stops, as heyoka takes them.

    ``targets``: from the stretch's beginning, in the run's unit, the last one being its end.
    ``grid``: for a batch of doubles the beginning and several targets, a column for each lane.
    """

    to: Fraction
    first: int
    last: int  # of the outputs, not included
    targets: list[HeyokaNumber]
    grid: Doubles | None


class Stretches:
    """The stretches of a job, each made once, and none beyond those that are come to."""

    def __init__(self, job: BatchJob) -> None:
        self._made: list[Stretch] = []
        self._more = _stretches(job)

    def __iter__(self) -> Iterator[Stretch]:
        n = 0
        while (stretch := self.at(n)) is not None:
            yield stretch
            n += 1

    def at(self, n: int) -> Stretch | None:
        """The one of index n, after that before it; None where the way is over."""
        if n < len(self._made):
            return self._made[n]
        stretch = next(self._more, None)
        if stretch is not None:
            self._made.append(stretch)
        return stretch


def _stretches(job: BatchJob) -> Iterator[Stretch]:
    """Stretches of a fifth of a second's work; they depend on the unit of time alone."""
    done = 1 if job.times[0] == 0 else 0
    if done == len(job.times):
        return
    end, unit = job.times[-1], Fraction(2) ** job.time_unit
    count = -(-abs(end) / unit // longest(job.number))
    j, since = 0, Fraction(0)
    while done < len(job.times):
        j += 1
        to = end if j == count else job.number.rounded(end * Fraction(j, count))
        first = done
        while done < len(job.times) and abs(job.times[done]) <= abs(to):
            done += 1
        at = list(job.times[first:done])
        targets = at if at and at[-1] == to else [*at, to]
        scaled = [heyoka_numbers.scalar((t - since) / unit, job.number) for t in targets]
        grid = None
        if job.number.name == "double" and len(scaled) > 1:
            grid = np.repeat(np.array([[0.0, *scaled]]).T, LANES, axis=1)
        yield Stretch(to, first, done, scaled, grid)
        since = to
