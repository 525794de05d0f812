"""Events of a refined run: places found along the run in double, decided from refined states.

At each place the state is refined as at an output time; from there its Taylor series leads to the
zero or the extremum.  What they mean is decided as in a run of steps
(:mod:`polhode.taylor.events.watch`), with the rounding errors of the same number type.

An event is lost only where the run in double has no place for it: where the expression and its rate
and its bend all are smaller than 1e-8 of their sizes at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from polhode.numbers.exact import ZERO
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array
from polhode.refined.errors import CannotRefine
from polhode.refined.event_candidates import Candidates
from polhode.refined.taylor_series import Series
from polhode.scenes.scene import Scene
from polhode.taylor.backend.heyoka_numbers import array, as_fraction, scalar
from polhode.taylor.events.decision import End
from polhode.taylor.events.jets import Marks, of_scene
from polhode.taylor.events.polishing import Places, in_order, joined, refined
from polhode.taylor.events.rules import Rules
from polhode.taylor.events.watch import Note, Watch

if TYPE_CHECKING:
    from polhode.refined.double_run import Base

_FARTHEST = 0.125  # from an extremum to the zeros beside it, in the run's own unit
_ALIKE = 2.0**-34  # times 64: within it two zeros of one slope are one, found along two runs


class EventSide(NamedTuple):
    """The value of an event far from zero, at a time ahead of the start (run's own unit)."""

    ahead: Fraction
    event: int
    value: float


class Search(Watch):
    """The events of one scene during one refined run in a number type.

    ``stop``: the time (run's own unit) of the event that ended the run.  ``sides``: what the
    present run in double tells of the time ahead.
    """

    def __init__(self, scene: Scene, number: NumberType) -> None:
        super().__init__(scene, number, Rules(scene, number, None, False))
        self.backward = self.way < 0
        self.alike = _ALIKE
        self.candidates = Candidates(scene, self.backward)
        self.sides: list[EventSide] = []
        self._series: dict[tuple[str, str], Series] = {}
        self._end_note: Note | None = None
        self.jets = of_scene(scene, number, self._hop)

    def begin(self, series: Series) -> None:
        """Take note of the start."""
        self._end_note = self._note(ZERO, series)
        self.starts_at(self._last())

    def refuse_what_never_moves(self, now: Base) -> None:
        """Raise CannotRefine for an event that starts at zero and stays there along a base."""
        for k, before in enumerate(self.rules.start):
            if before == 0 and self.candidates.still(now.polynomials, k):
                raise CannotRefine("an event is zero at all times of the motion")

    def look(self, time: Fraction, series: Series, places: Sequence[tuple[int, bool]]) -> None:
        """Note places of events: ``time`` (own unit), ``series`` from the state then."""
        note = self._note(time, series)
        for k, extremum in places:
            self._notes[k][extremum].append(note)
            if extremum:  # or an end of a run in double, beside which a zero may lie
                self._notes[k][0].append(note)

    def passed(self, time: Fraction, series: Series) -> None:
        """Decide about the events that may end the run: it has come to a time."""
        self._end_note = self._note(time, series)
        for side in self.sides:
            if side.ahead <= abs(time):
                self._notes[side.event][2].append(self._side(side))
        self.sides[:] = [side for side in self.sides if side.ahead > abs(time)]
        for k in self._ends:
            if self._noted(k) != self._known.records[k].noted or self._known.records[k].open:
                self.decide(k, self._last())

    def _last(self) -> Marks:
        if self._known.at is not None:
            return self._known.at
        assert self._end_note is not None
        return self._marks(self._end_note)

    def _side(self, side: EventSide) -> Note:
        zero = scalar(ZERO, self.number)
        return Note(
            side.ahead * self.way, zero, array([zero] * self.width, self.number), side.value
        )

    def _polished(self, k: int, notes: Sequence[list[Note]]) -> Places:
        met = super()._polished(k, notes)
        return in_order(joined([met, self._told(notes[2])])) if notes[2] else met

    def _told(self, sides: list[Note]) -> Places:
        """The sides that the run in double tells, as places."""
        marks = self._gathered(sides)
        none, away = np.zeros(len(sides)), np.zeros(len(sides), dtype=bool)
        values = np.zeros((4, len(sides)))
        values[0] = [side.value / float(self.rules.band) for side in sides]
        ahead = marks.since_start if self.way > 0 else -marks.since_start
        return Places(marks, ahead, values, none, away, away, none, none)

    def _note(self, time: Fraction, series: Series) -> Note:
        high, low = self._clock(time).tolist()
        self._series[str(high), str(low)] = series
        row = array(_row(series, ZERO, self.width, self.number), self.number)
        return Note(time, scalar(ZERO, self.number), row)

    def _marks(self, note: Note) -> Marks:
        return self._gathered([note])

    def _hop(self, marks: Marks, step: Array) -> Array:
        rest = (marks.rest + step).tolist()
        rows = [
            _row(
                self._series[str(high), str(low)],
                as_fraction(ahead, self.number),
                self.width,
                self.number,
            )
            for high, low, ahead in zip(marks.high.tolist(), marks.low.tolist(), rest, strict=True)
        ]
        columns = array([x for row in zip(*rows, strict=True) for x in row], self.number)
        return columns.reshape(self.width, len(rest))

    def _search(
        self, k: int, known: Places, end: End, side: int, since: int, before: int
    ) -> Places | None:
        """The crossing to a side between two places: beside the extremum that is nearer to zero."""
        jet, guesses = self.jets[k], []
        with np.errstate(all="ignore"):
            for place, way in ((since, self.way), (before, -self.way)):
                if (
                    0 <= place < len(known.ahead)
                    and known.noise[place] > 0
                    and not known.root[place]
                ):
                    extremum = known.those([place])
                    value, _, bend, _ = jet.at(extremum.marks)
                    step = np.sqrt(abs((value + value) / bend))
                    guesses.append((float(step[0]), extremum.marks, way * step))
        for away, marks, step in sorted(guesses, key=lambda guess: guess[0]):
            if away < _FARTHEST:
                zero = self._places(k, refined(jet, jet.moved(marks, step), "zeros"), True)
                first = ZERO if since < 0 else known.ahead[since]
                last = (end.place if before == len(known.ahead) else known.those([before])).ahead[0]
                near = abs(zero.values[0, 0]) <= zero.noise[0]
                if near and first < zero.ahead[0] < last:
                    return zero
        return None


def _row(series: Series, ahead: Fraction, width: int, number: NumberType) -> list[object]:
    """The state so much later than a series' own, in a number type."""
    state = series.at(int(ahead * (1 << series.bits)))[:width]
    return [scalar(Fraction(x, 1 << series.bits), number) for x in state]
