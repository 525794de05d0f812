"""Crossings of a batch search: which of them are some, where exactly, and what rounding leaves."""

from __future__ import annotations

import numpy as np

from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Booleans, Doubles, Indices
from polhode.taylor.events.batch_zeros import Crossings, Watched
from polhode.taylor.events.jets import Jet, Marks
from polhode.taylor.events.polishing import MULTIPLE, ZEROS, Places, places, refined
from polhode.taylor.events.roundoff import BAND

_CERTAIN = 2.0**-20  # of a section's function: extrema further from zero are no contacts
_SMALL = 1e-9  # of an expression's size: above it nothing is within rounding of zero
_TWICE = 2.0**-46  # times max(1, t): so near together two crossings are one, told twice
_BAND = BAND * DOUBLE.eps / 2


class Judge:
    """What crossings of an expression are, on motions that have ``numbers``, a column each."""

    def __init__(self, watched: Watched, jet: Jet, numbers: Doubles) -> None:
        self.watched, self._jet, self.numbers = watched, jet, numbers

    def jet(self, which: Indices) -> Jet:
        """The expression's jet on some motions."""
        return self._jet._replace(numbers=self.numbers[:, which])

    def near(self, which: Indices, values: Doubles, marks: Marks) -> Booleans:
        """Where the expression is within its rounding error of zero, on some motions."""
        near: Booleans = np.abs(values) < _SMALL * self.watched.size
        at = np.flatnonzero(near)
        if len(at):
            noise = self.jet(which[at]).noise(marks.those(at))
            near[at] = ~(np.abs(values[at]) > float(_BAND) * noise)
        return near

    def placed(self, which: Indices, marks: Marks, way: int) -> tuple[Places, Booleans]:
        """Polished crossings, and which of them are some for certain."""
        with np.errstate(all="ignore"):
            place = places(self.jet(which), marks, way, np.full(len(marks.time), True))
            return place, place.steep & (np.abs(place.values[0]) <= place.noise)

    def polished(self, which: Indices, marks: Marks, kind: int = ZEROS) -> Marks:
        """Crossings on some motions taken to their last digits."""
        with np.errstate(all="ignore"):
            return refined(self.jet(which), marks, np.full(len(marks.time), kind))

    def each_once(self, which: Indices, marks: Marks, met: Crossings) -> Crossings:
        """Crossings of a stretch in order, each once and without contacts.

        Of those without a certain slope the signs are put right.
        """
        if len(which) == 0:
            return met
        width = self._width(which, marks, met.signs)
        order = np.lexsort((np.abs(met.times), met.lanes))
        order = order[width[order] < np.inf]
        met, width = met.those(order), width[order]
        times = np.abs(met.times)
        apart = np.fmax(width[1:], width[:-1]) + _TWICE * np.fmax(1.0, times[1:])
        twice = (met.lanes[1:] == met.lanes[:-1]) & (np.diff(times) <= apart)
        return met.those(np.flatnonzero(np.insert(~twice, 0, True)[: len(width)]))

    def _width(self, which: Indices, marks: Marks, signs: Doubles) -> Doubles:
        """How wide crossings are, 0 with a certain slope, infinite for a contact."""
        width = np.zeros(len(which))
        with np.errstate(all="ignore"):
            _, slopes, bends, _ = self.jet(which).at(marks)
        small = np.flatnonzero(~(slopes * slopes > _CERTAIN * self.watched.size * np.abs(bends)))
        if len(small) == 0:
            return width
        which = which[small]
        marks = self.polished(which, marks.those(small))
        _, certain = self.placed(which, marks, 1)
        flat = self.polished(which, marks, MULTIPLE)
        place, _ = self.placed(which, flat, 1)
        jet = self.jet(which)
        with np.errstate(all="ignore"):
            apart = np.fmax(2 * place.width, _TWICE * np.fmax(1.0, np.abs(flat.since_start)))
            sides = [jet.relative(jet.moved(flat, way * apart))[0] for way in (-1, 1)]
        before, after = sides
        crosses = (np.minimum(np.abs(before), np.abs(after)) > place.noise) & (before * after < 0)
        width[small] = np.where(certain, 0.0, np.where(crosses, 4 * place.width, np.inf))
        signs[small] = np.where(certain, signs[small], np.sign(after))
        return width
