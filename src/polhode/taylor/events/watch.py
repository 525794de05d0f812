"""Events of a run: crossings and contacts of expressions along the motion.

heyoka finds the zeros of each expression's Taylor polynomial and of its rate's, step by step.  A
callback notes the state there; when the run is over all of them are polished together
(polhode.taylor.events.polishing), and what they mean is decided in one pass
(polhode.taylor.events.decision).  What heyoka is given is scaled down by sqrt(eps), so that an
event takes no part in choosing the steps: a run with events takes the steps of a run without them,
unless an expression varies far faster than the motion, or a step would be longer than the run's
unit of time.  Last bits may differ, where an event shares terms with the equations.

A zero at t = 0, by the exact scene, is not an event of the run.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np

from polhode.common.value_semantics import waiting
from polhode.equations import kinematics
from polhode.equations.form import equations
from polhode.equations.readout import Readout
from polhode.motion.outcomes import EventTimes
from polhode.numbers.exact import ZERO, Number, sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, read_only
from polhode.numbers.scalars import Functions, Scalar
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.types import Expression, HeyokaEvent, HeyokaIntegrator, HeyokaNumber
from polhode.taylor.events.callbacks import AfterStep, Callback
from polhode.taylor.events.decision import Decision, End, Happening, Standing, at_the_start, depths
from polhode.taylor.events.functions import TIME, rate, typed_constant, value_of
from polhode.taylor.events.jets import Formulas, Jet, Marks, jet_of
from polhode.taylor.events.magnitudes import middle_axis
from polhode.taylor.events.polishing import Places, exact_times, joined, places, polished
from polhode.taylor.events.rules import Rules
from polhode.taylor.integrator.protocols import Desk
from polhode.taylor.integrator.specification import CLOCK, TINY

_PROBES = 8  # steps over which an expression that starts at zero must leave it
_OTHER_SEAMS = Fraction(1, 20)  # the longest step of a search, in the run's unit
_MOST_STEPS = 10_000  # of a search


class Note(NamedTuple):
    """A zero as heyoka met it: an exact offset, the time since then, the form's variables there."""

    offset: Fraction
    time: HeyokaNumber
    row: Array


@dataclass(frozen=True)
class Record:
    """What is known of one event while a run is under way.

    ``noted``: how many zeros and extrema, of which ``taken`` are polished: ``places``.
    ``happened``: what is decided, up to ``standing``; ``open``: a zero is in sight.
    """

    standing: Standing
    noted: tuple[int, ...] = (0, 0)
    taken: tuple[int, ...] = (0, 0)
    places: Places | None = None
    happened: tuple[Happening, ...] = ()
    complete: bool = True
    open: bool = False


@dataclass(frozen=True)
class Found:
    """All that a watch knows at some moment; ``at``: where an event ended the run."""

    records: tuple[Record, ...] = ()
    stop: Fraction | None = None
    at: Marks | None = None


class Watch:
    """The events of one scene while a run in one number type is under way.

    ``stop``: the time, in the run's unit, of the event that ended the run.  Raises BadInput for an
    expression that has no value at t = 0 or is identically zero.
    """

    def __init__(self, scene: Scene, number: NumberType, rules: Rules) -> None:
        self.scene, self.number, self.rules = scene, number, rules
        self.muted = False
        self.any_step = rules.still
        self.way = 1 if sign(scene.end) >= 0 else -1
        self.width = len(equations(scene).variables)
        self.after_step = AfterStep(self._stops, number) if rules.asked else None
        # zeros and extrema that were met
        self._notes: list[tuple[list[Note], ...]] = [([], []) for _ in scene.events]
        self._known = Found()
        self._ends = [k for k, event in enumerate(scene.events) if event.stop]
        self._starts: list[End] = []
        # Of the integrator attached last: itself, the exact time from which its own counts, and
        # what it hands to callbacks, with its dense output, a view of its memory.
        self._stepping: HeyokaIntegrator = None
        self._offset = ZERO
        self._met: HeyokaIntegrator = None
        self._row: Array
        self.jets: list[Jet] = []

    @property
    def stop(self) -> Fraction | None:
        """The time of the event that ended the run; None while none has."""
        return self._known.stop

    # -- building -----------------------------------------------------------------------------

    @property
    def key(self) -> tuple[object, ...]:
        """What tells the events from others along the same equations."""
        axes, events = equations(self.scene).axes.rows, self.scene.events
        turn = tuple(str(heyoka_numbers.scalar(x, self.number)) for row in axes for x in row)
        zeros = tuple(event.expression or middle_axis(self.scene) for event in events)
        return zeros, self.scene.time_unit, turn

    @property
    def damping(self) -> list[Fraction]:
        """Numbers that an integrator with these events takes as parameters, one for each."""
        return self.rules.damping

    def attach(
        self,
        variables: Sequence[Expression],
        rates: Sequence[Expression],
        pattern: Mapping[str, Expression],
    ) -> tuple[list[HeyokaEvent], Desk]:
        """heyoka's events of an integrator about to be built, in its variables and its time."""
        variables, rates = list(variables[: self.width]), list(rates[: self.width])
        events: list[HeyokaEvent] = []
        desk = Desk()
        options = heyoka_numbers.type_options(self.number)
        kind = {name: x for name, x in options.items() if name == "fp_type"}
        clock = {TIME: hy.time + hy.par[1] + hy.par[0]}
        constant = typed_constant(self.number)
        jets: dict[str | None, Jet] = {}
        for k, event in enumerate(self.scene.events):
            formulas, text = self._formulas(event, pattern), event.expression
            numbers = formulas.numbers(constant)
            value = formulas.value(variables, TIME, numbers, constant, heyoka_numbers.EXPRESSIONS)
            if text not in jets:
                like = next(iter(jets.values()), None)
                given = formulas, variables, self.number, self.rules.band, constant, like
                jets[text] = jet_of(*given)
            desk.jets.append(jets[text])
            for order, f in enumerate((value, rate(value, variables, rates))):
                if hy.get_variables([f]):  # a constant has no zeros
                    seen = hy.subs(f, clock) * hy.par[CLOCK + k] + hy.par[TINY]
                    events.append(hy.nt_event(seen, Callback(desk, k, order), **kind))
        return events, desk

    def _formulas(self, event: Event, pattern: Mapping[str, Expression]) -> Formulas:
        """An event's expression and the motion; ``pattern``: coefficients that are parameters."""
        scene, form = self.scene, equations(self.scene)

        def field(
            state: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
        ) -> Sequence[Scalar]:
            return [fn.zero] * self.width if self.rules.still else form.field(state, k, fn)

        def numbers(constant: Callable[[Number], Expression]) -> Mapping[str, Expression]:
            exact = {**form.coefficients, **kinematics.turn_coefficients(form.axes)}
            return {name: constant(x) for name, x in exact.items()} | pattern

        return Formulas(partial(value_of, scene, event), field, numbers)

    def sit_down(self, desk: Desk, numbers: Array) -> None:
        """Take over the desk of the integrator that a run goes on with, with its coefficients."""
        self.jets = [jet._replace(numbers=numbers) for jet in desk.jets]
        desk.watch = self

    def counts_from(self, offset: Fraction, heyoka: HeyokaIntegrator) -> None:
        """Take note of the integrator and of where its time begins; tell it, where t is asked."""
        self._offset, self._stepping = offset, heyoka
        if any(jet.timed for jet in self.jets):
            heyoka.pars[:2] = self._clock(offset)
        if not self._starts:
            here = self._here(heyoka)
            self._starts = [
                End(before, self._places(k, here)) for k, before in enumerate(self.rules.start)
            ]
            self._known = Found(tuple(Record(at_the_start(start)) for start in self._starts))

    def _clock(self, offset: Fraction) -> Array:
        """An exact time as two numbers of the run's."""
        high = self.number.rounded(offset)
        parts = high, self.number.rounded(offset - high)
        return heyoka_numbers.array(heyoka_numbers.scalars(parts, self.number), self.number)

    # -- callbacks ----------------------------------------------------------------------------

    def met(self, k: int, order: int, ta: HeyokaIntegrator, t: HeyokaNumber) -> None:
        """A zero of expression k, or of its rate, at heyoka's time t in the step just taken."""
        if self.muted:
            return
        if ta is not self._met:
            self._met, self._row = ta, ta.d_output
        ta.update_d_output(t)
        self._notes[k][order].append(Note(self._offset, t, self._row[: self.width].copy()))

    def _stops(self, ta: HeyokaIntegrator) -> bool:
        """Whether an event ends the run in the step just taken."""
        for k in () if self.muted else self._ends:
            record = self._known.records[k]
            if self._noted(k) != record.noted or record.open:
                self._look(k, ta)
        return self.stop is not None

    def _noted(self, k: int) -> tuple[int, ...]:
        return tuple(map(len, self._notes[k]))

    def _look(self, k: int, ta: HeyokaIntegrator) -> None:
        """Decide about an event that may end the run, unless nothing can have happened."""
        noted, record = self._noted(k), self._known.records[k]
        here = self._here(ta)
        if not record.open and noted[0] == record.noted[0]:
            value = self.jets[k].at(here)[0, 0]
            if not value * record.standing.side < 0:  # on the same side, and no zero was met
                self._keep(k, replace(record, noted=noted))
                return
        self._decide(k, here)

    def _decide(self, k: int, here: Marks) -> None:
        """Decide what happened of an event up to a place, and whether that ends the run."""
        end = self._end(k, here)
        found, record = self._decided(k, end)
        if end.near:  # a zero counts when the other side is reached
            self._keep(k, replace(self._known.records[k], noted=self._noted(k), open=True))
            return
        self._keep(k, record)
        for happening in found:
            if happening.sign and self.scene.events[k].counts(happening.sign * self.way):
                self._stop_at(_place(happening, _known(record)).marks)
                return

    def _keep(self, k: int, record: Record) -> None:
        records = list(self._known.records)
        records[k] = record
        self._known = replace(self._known, records=tuple(records))

    def _stop_at(self, marks: Marks) -> None:
        (time,) = marks.since_start.tolist()
        exact = heyoka_numbers.as_fraction(time, self.number)
        if self.stop is None or abs(exact) < abs(self.stop):
            self._known = replace(self._known, stop=exact, at=marks)

    # -- corrections of the state, and steps that are taken back --------------------------------

    def disturbed(self, state: Array, moved: Array) -> bool:
        """Whether moving the first components of the integrator's state would disturb an event.

        That is: carry its expression a quarter of the way to zero or further.
        """
        marks = self._here(self._stepping)
        before = marks._replace(columns=state[: self.width, None].copy())
        after = before._replace(columns=before.columns.copy())
        after.columns[: len(moved), 0] = moved
        for jet in self.jets:
            value = jet.at(before)[0, 0]
            if abs(jet.at(after)[0, 0] - value) > abs(value) / 4:
                return True
        return False

    def marks(self) -> Found:
        """What is known so far, to be given to ``take_back``."""
        records = (
            replace(record, noted=self._noted(k)) for k, record in enumerate(self._known.records)
        )
        return replace(self._known, records=tuple(records))

    def take_back(self, found: object) -> None:
        """Forget what was found since."""
        assert isinstance(found, Found)
        self._known = found
        for notes, record in zip(self._notes, found.records, strict=True):
            for several, count in zip(notes, record.noted, strict=True):
                del several[count:]

    # -- what was found -----------------------------------------------------------------------

    def found(self) -> tuple[EventTimes, ...]:
        """The events in scene axes and units, in order of integration; ends the watch's work."""
        return tuple(map(self._found, range(len(self.scene.events))))

    def _found(self, k: int) -> EventTimes:
        event, read = self.scene.events[k], Readout(self.scene, self.number)
        if not self._starts:  # no step was taken
            return EventTimes(event.name, (), read_only(read.states([]), read.columns), ())
        last = self._known.at or self._here(self._stepping)
        before, end = self._known.records[k].happened, self._end(k, last)
        more, record = self._decided(k, end)
        happened = [*before, *more]
        counted = [
            i
            for i, happening in enumerate(happened)
            if event.counts(happening.sign * self.way) and not self._beyond(record, happening)
        ]
        deep = depths(happened, _known(record), self._starts[k], end)[counted]
        happened = [happened[i] for i in counted]
        where = _gathered(happened, _known(record))
        times, unit = where.marks.since_start, 2.0**self.scene.time_unit
        sizes = np.array([abs(float(t)) for t in times.tolist()])
        spreads = np.array([happening.spread for happening in happened])
        widths = where.width + spreads / 2 + sizes * float(self.number.eps / 2)
        rows = where.marks.columns.T
        if not self.number.flat:
            rows = [heyoka_numbers.numbers(row, self.number) for row in rows.tolist()]
        return EventTimes(
            event.name,
            waiting(partial(exact_times, times, self.scene.time_unit, self.number)),
            read_only(read.states(rows), read.columns),
            tuple(happening.sign * self.way for happening in happened),
            tuple((widths * unit).astype(float).tolist()),
            tuple((deep * float(self.rules.band)).astype(float).tolist()),
            record.complete,
        )

    def _beyond(self, record: Record, happening: Happening) -> bool:
        """Whether an event lies behind the one that ended the run."""
        if self._known.at is None:
            return False
        stopped = self._known.at.since_start[0] * self.way
        return bool(_place(happening, _known(record)).ahead[0] > stopped)

    def _decided(self, k: int, end: End) -> tuple[list[Happening], Record]:
        """What happened of an event since its standing, up to an end."""
        record, noted = self._known.records[k], self._noted(k)
        notes = zip(self._notes[k], record.taken, strict=True)
        new = self._polished(k, [several[taken:] for several, taken in notes])
        known = new if record.places is None else joined([record.places, new])
        since, last = record.standing.since, end.place.ahead[0]
        if self.stop is not None:
            if since >= 0 and known.ahead[since] > last:  # all of it is decided
                return [], replace(record, places=known)
            known = known.those(known.ahead <= last)
        search = partial(self._search, k, known, end)
        start, way = self._starts[k], self.way
        alike = float(self.number.eps)
        decision = Decision(known, record.standing, start, end, way, alike, search)
        found = decision.found
        return found, replace(
            record,
            standing=decision.standing,
            noted=noted,
            taken=noted,
            places=known,
            happened=(*record.happened, *found),
            complete=record.complete and decision.complete,
            open=False,
        )

    def _polished(self, k: int, notes: Sequence[list[Note]]) -> Places:
        """Zeros and extrema that were met, polished."""
        met = [self._gathered(several) for several in notes]
        return polished(self.jets[k], met, self.way)

    def _gathered(self, notes: Sequence[Note]) -> Marks:
        """What heyoka met, as arrays."""
        if not notes:
            none = np.empty(0)
            return Marks(none, none, none, none, np.empty((self.width, 0)))
        clocks = {id(note.offset): self._clock(note.offset) for note in notes}
        high, low = np.stack([clocks[id(note.offset)] for note in notes], axis=1)
        time: Scalar = heyoka_numbers.array([note.time for note in notes], self.number)
        rows = np.concatenate([note.row for note in notes]).reshape(len(notes), -1)
        return Marks(high, low, time, time - time, rows.T.copy())

    def _here(self, ta: HeyokaIntegrator, ago: HeyokaNumber | None = None) -> Marks:
        """Where an integrator stands, or stood so long ago in its last step."""
        high, low = ta.dtime
        row = ta.state
        if ago is not None:
            ta.update_d_output(ago, rel_time=True)
            row, low = ta.d_output, low + ago
        parts = *self._clock(self._offset).tolist(), high, low
        before, beside, time, rest = (heyoka_numbers.array([x], self.number) for x in parts)
        return Marks(before, beside, time, rest, row[: self.width, None].copy())

    def _places(self, k: int, marks: Marks, root: bool = False) -> Places:
        return places(self.jets[k], marks, self.way, np.array([root]))

    def _end(self, k: int, marks: Marks) -> End:
        place = self._places(k, marks, True)
        value = place.values[0, 0]
        return End(int(np.sign(value)) if np.isfinite(value) else 0, place)

    def _search(
        self, k: int, known: Places, end: End, side: int, since: int, before: int
    ) -> Places | None:
        """The crossing to a side between two places: along other steps, and by bisection.

        It begins where the expression is nearer to zero: where steps are long for it, the motion
        from there on is the one that was seen there.
        """
        first = self._starts[k].place if since < 0 else known.those([since])
        last = end.place if before == len(known.ahead) else known.those([before])
        ways = [(first, last, side, self.way), (last, first, -side, -self.way)]
        if abs(last.values[0, 0]) < abs(first.values[0, 0]):
            ways.reverse()
        for begin, stop, wanted, way in ways:
            found = self._along(k, begin.marks, abs(stop.ahead[0] - begin.ahead[0]), wanted, way)
            if found is not None:
                return found
        return None

    def _along(
        self, k: int, begin: Marks, length: HeyokaNumber, wanted: int, way: int
    ) -> Places | None:
        """Where the expression comes to a side along steps from a place, within some length."""
        muted, offset, self.muted = self.muted, self._offset, True
        probe = copy.deepcopy(self._stepping)
        clock = heyoka_numbers.array([begin.high[0], begin.low[0]], self.number)
        if self.jets[k].timed:
            probe.pars[:2] = clock
        self._offset = sum((heyoka_numbers.as_fraction(x, self.number) for x in clock), ZERO)
        (start,) = (begin.time + begin.rest).tolist()
        probe.time = start
        probe.state[: self.width] = begin.columns[:, 0]
        longest, found = heyoka_numbers.scalar(_OTHER_SEAMS, self.number), None
        for _ in range(_MOST_STEPS):
            left = length - abs(probe.time - start)
            if not left > 0:
                break
            probe.step(way * min(longest, left), write_tc=True)
            if self.jets[k].at(self._here(probe))[0, 0] * wanted >= 0:
                found = self._bisected(k, probe, wanted)
                break
        self.muted, self._offset = muted, offset
        return found

    def _bisected(self, k: int, probe: HeyokaIntegrator, side: int) -> Places:
        """Where in a probe's last step the expression comes to a side."""
        low, high = -probe.last_h, probe.last_h - probe.last_h
        for _ in range(self.number.bits + 8):
            middle = (low + high) / 2
            if self.jets[k].at(self._here(probe, middle))[0, 0] * side >= 0:
                high = middle
            else:
                low = middle
        return self._places(k, self._here(probe, high), True)

    def still(self) -> list[int]:
        """The events that start at zero and stay within rounding of it for some steps."""
        suspects = {k for k, before in enumerate(self.rules.start) if before == 0}
        if not suspects:
            return []
        self.muted = True
        probe = copy.deepcopy(self._stepping)
        for _ in range(_PROBES):
            probe.step(heyoka_numbers.scalar(Fraction(1), self.number))
            here = self._here(probe)
            suspects -= {k for k in suspects if not self._end(k, here).near}
        self.muted = False
        return sorted(suspects)


def _known(record: Record) -> Places:
    assert record.places is not None
    return record.places


def _place(happening: Happening, known: Places) -> Places:
    return known.those([happening.at]) if happening.own is None else happening.own


def _gathered(happened: Sequence[Happening], known: Places) -> Places:
    """The places of what happened, in this order."""
    if all(happening.own is None for happening in happened):
        return known.those([happening.at for happening in happened])
    return joined([_place(happening, known) for happening in happened])
