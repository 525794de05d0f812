"""Watching a run for events: what heyoka calls, what is noted, and when the run has to stop."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np

from polhode.common.values import waiting
from polhode.equations.form import equations
from polhode.equations.readout import Readout
from polhode.motion.outcomes import EventTimes
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import ZERO, Number, sign
from polhode.numbers.number_types import Array, Booleans, Functions, NumberType, Scalar, read_only
from polhode.scenes.scene import Event, Scene, middle_axis
from polhode.scenes.vocabulary import DIRECTIONS
from polhode.taylor import event_decision, event_functions
from polhode.taylor.engine import CLOCK, TINY, Desk, Engine
from polhode.taylor.event_decision import Decision, End, Happenings, Places, at_the_end, places
from polhode.taylor.event_functions import BAND, TIME, Formulas, Jet, Marks, jet_of, marks_at, rate
from polhode.taylor.heyoka import (
    EXPRESSIONS,
    Expression,
    HeyokaEvent,
    HeyokaIntegrator,
    HeyokaNumber,
    array,
    as_fraction,
    as_mpf,
    hy,
    scalar,
    scalars,
    type_options,
)

# --- callbacks ------------------------------------------------------------------------------------
#
# What heyoka calls in a run with events: where one is met, and after each step, to go on?


_PATIENCE = 8  # steps in a row that do not change the time; the last one before an end may be such


class AfterStep:
    """Go on?  Not after an event that stops the run, and not where steps stand still at a pole.

    Where an expression runs to infinity, so do its Taylor coefficients, and heyoka's steps shrink
    to zero.  Steps of zero count towards no limit: they would go on for ever.

    ``end``: of the run.  heyoka asks after every step, so that little is done after most.
    """

    def __init__(
        self, stopped: Callable[[HeyokaIntegrator], bool], end: Number, number: NumberType
    ) -> None:
        self.stopped, self.idle = stopped, 0
        self.eps = scalar(number.eps, number)
        self.long = scalar(abs(end) * 2, number) * self.eps  # such a step moves anywhere

    def __call__(self, ta: HeyokaIntegrator) -> bool:
        """Whether to go on."""
        length = abs(ta.last_h)
        if length > self.long or length > abs(ta.time) * self.eps:
            self.idle = 0
        else:
            self.idle += 1
        return not self.stopped(ta) and self.idle < _PATIENCE

    def __deepcopy__(self, _: object) -> AfterStep:
        return self


class Callback:
    """heyoka's call where an event is met; heyoka copies its callbacks, this one stays one.

    ``k``: which expression; in a batch the lane is told instead.
    """

    def __init__(self, desk: Desk, k: int, order: int) -> None:
        self.desk, self.k, self.order = desk, k, order

    def __call__(
        self, ta: HeyokaIntegrator, t: HeyokaNumber, _: int, lane: int | None = None
    ) -> None:
        """Tell whoever watches."""
        if self.desk.watch is not None:
            self.desk.watch.met(self.k if lane is None else lane, self.order, ta, t)

    def __deepcopy__(self, _: object) -> Callback:
        return self


# --- rules ----------------------------------------------------------------------------------------
#
# What the events of a scene are looked for by: made once for a scene.


class Rules:
    """What a run's watch goes by: made once for a scene, number type and tolerance.  Immutable.

    ``start``: the exact signs of the expressions at t = 0.  ``asks``: whether heyoka asks after
    each step.  ``key``: what tells the events from others along the same equations.  ``damping``:
    powers of two by which heyoka sees the expressions smaller.  ``band``: a rounding error of 1,
    times BAND.  ``still``: the state never changes, and the events do choose the steps.
    """

    def __init__(
        self, scene: Scene, number: NumberType, tolerance: Fraction | None, still: bool
    ) -> None:
        form, events = equations(scene), scene.events
        self.still, self.width = still, len(form.variables)
        turn = [str(scalar(x, number)) for row in form.frame.axes.rows for x in row]
        zeros = [event.expression or middle_axis(scene) for event in events]
        self.key = (*zeros,), form.frame.exponent, (*turn,)
        self.start = [event_functions.sign_at_start(scene, k) for k in range(len(scene.events))]
        eps = max(number.eps, tolerance or ZERO)
        self.band = BAND * eps / 2
        small = Fraction(1)
        if not still:
            small = Fraction(2) ** -(((1 / eps).numerator.bit_length() - 1) // 2)
        self.damping: list[Fraction] = []
        sizes = [event_functions.size_of(scene, event) for event in scene.events]
        self.asks = any(e.stop for e in scene.events) or not all(x.entire for x in sizes)
        for size in sizes:
            value, rate = exactly(size.value) or Fraction(1), exactly(size.rate) or Fraction(1)
            self.damping.append(small * Fraction(2) ** -exact.exponent_above(max(value, rate)))


# --- probe ----------------------------------------------------------------------------------------
#
# Other steps along a motion: for a crossing that was lost, and for what never leaves zero.


_PROBES = 8  # steps over which an expression that starts at zero must leave it
_OTHER_SEAMS = Fraction(1, 20)  # the longest step of a search, in the run's unit
_MOST_STEPS = 10_000  # of a search


def mark(
    heyoka: HeyokaIntegrator, parameters: Array, width: int, ago: HeyokaNumber | None = None
) -> Marks:
    """Where an integrator stands, or stood so long ago in its last step.

    ``parameters``: those of compiled functions, the time at which its own began in front.
    ``width``: how many of its variables are of the form.
    """
    row, (high, low) = heyoka.state, heyoka.dtime
    if ago is not None:
        heyoka.update_d_output(ago, rel_time=True)
        row, low = heyoka.d_output, low + ago
    times = np.array([high, low], dtype=parameters.dtype)
    return Marks(parameters[:, None], times[:1], times[1:], row[:width, None].copy())


class Probe:
    """Looks for crossings along steps of its own.

    ``heyoka``: the run's integrator, whose events nobody hears meanwhile; it is left alone.
    """

    def __init__(self, jet: Jet, heyoka: HeyokaIntegrator, width: int) -> None:
        self.jet, self.number, self.heyoka, self.width = jet, jet.number, heyoka, width

    def crossing(
        self,
        noted: Places,
        start: Places,
        end: Places,
        sense: int,
        side: int,
        since: int,
        before: int,
    ) -> Places | None:
        """The crossing to a side between two places: along other steps, and by bisection.

        ``since``: -1 for the start, ``before``: as many as there are places for the end.  It begins
        where the expression is nearer to zero: where steps are long for it, the motion from there
        on is the one that was seen there.
        """
        first = start if since < 0 else noted.those([since])
        last = end if before == len(noted.ahead) else noted.those([before])
        ways = [(first, last, side, sense), (last, first, -side, -sense)]
        if abs(last.values[0, 0]) < abs(first.values[0, 0]):
            ways.reverse()
        for begin, stop, target, onwards in ways:
            length = abs(stop.ahead[0] - begin.ahead[0])
            marks = self._along(begin.marks, length, target, onwards)
            if marks is not None:
                return places(self.jet, marks, sense, np.array([True]))
        return None

    def _along(self, begin: Marks, length: HeyokaNumber, target: int, sense: int) -> Marks | None:
        """Where the expression comes to a side along steps from a place, within some length."""
        probe, parameters = copy.deepcopy(self.heyoka), begin.parameters[:, 0].copy()
        if self.jet.timed:
            probe.pars[:2] = parameters[:2]
        (start,) = (begin.time + begin.rest).tolist()
        probe.time = start
        probe.state[: self.width] = begin.columns[:, 0]
        longest = scalar(_OTHER_SEAMS, self.number)
        for _ in range(_MOST_STEPS):
            left = length - abs(probe.time - start)
            if not left > 0:
                break
            probe.step(sense * min(longest, left), write_tc=True)
            if self._beyond(mark(probe, parameters, self.width), target):
                return self._bisected(probe, parameters, target)
        return None

    def _bisected(self, probe: HeyokaIntegrator, parameters: Array, side: int) -> Marks:
        """Where in a probe's last step the expression comes to a side."""
        low, high = -probe.last_h, probe.last_h - probe.last_h
        for _ in range(self.number.bits + 8):
            middle = (low + high) / 2
            if self._beyond(mark(probe, parameters, self.width, middle), side):
                high = middle
            else:
                low = middle
        return mark(probe, parameters, self.width, high)

    def _beyond(self, marks: Marks, side: int) -> bool:
        return bool(self.jet.at(marks)[0, 0] * side >= 0)


def stays(jet: Jet, heyoka: HeyokaIntegrator, parameters: Array, width: int) -> bool:
    """Whether an expression stays within rounding of zero for some steps."""
    probe, longest = copy.deepcopy(heyoka), scalar(Fraction(1), jet.number)
    for _ in range(_PROBES):
        probe.step(longest)
        if not places(jet, mark(probe, parameters, width), 1, np.array([True])).near[0]:
            return False
    return True


# --- watch ----------------------------------------------------------------------------------------
#
# Events of a run: crossings and contacts of expressions along the motion.
#
# heyoka finds the zeros of each expression's Taylor polynomial and of its rate's, step by step. A
# callback notes the state there; when the run is over all of them are polished together, and what
# they mean is decided in one pass (:mod:`polhode.taylor.event_decision`). What heyoka is given is
# scaled down by sqrt(eps), so that an event takes no part in choosing the steps: a run with events
# takes the steps of a run without them, unless an expression varies far faster than the motion, or
# a step would be longer than the run's unit of time. Last bits may differ, where an event shares
# terms with the equations.
#
# A zero at t = 0, to the rounding of the start's numbers, is not an event of the run.


_ROOM = 64  # for the first notes


class Notes:
    """Zeros of a function as heyoka met them, by one clock: the times, and the variables there."""

    def __init__(self) -> None:
        self.times: list[HeyokaNumber] = []
        self.rows: Array = np.empty(0)  # with room for more

    def add(self, t: HeyokaNumber, variables: Array) -> None:
        """Take note of a time and of the variables, which are copied."""
        count = len(self.times)
        if count == len(self.rows):
            rows = np.empty((2 * count or _ROOM, len(variables)), variables.dtype)
            if count:
                rows[:count] = self.rows
            self.rows = rows
        self.rows[count] = variables
        self.times.append(t)

    def settled(self, parameters: Array, number: NumberType) -> Marks:
        """All of them as marks; from now on there are none."""
        columns = self.rows[: len(self.times)].T.copy()
        marks = marks_at(array(self.times, number), columns, parameters)
        self.times.clear()
        return marks


class Record:
    """What is known of one event while a run is under way.

    ``notes``: of zeros and of extrema, by the clock of today; ``marks``: those from before.
    ``counts``: how many there are; so many were there when it was last ``seen`` whether the run
    stops.  ``open``: a zero is in sight; ``side``: of the expression then.
    """

    def __init__(self, side: int) -> None:
        self.notes = Notes(), Notes()
        self.marks: tuple[list[Marks], list[Marks]] = [], []
        self.counts, self.seen = [0, 0], [0, 0]
        self.open, self.side = False, side

    def settle(self, parameters: Array, number: NumberType) -> None:
        """Take the notes for marks, before the clock changes or when these are asked for."""
        for notes, marks in zip(self.notes, self.marks, strict=True):
            if notes.times:
                marks.append(notes.settled(parameters, number))

    def joined(self, order: int, width: int) -> Marks:
        """All zeros (0), or extrema (1), once they are settled."""
        marks = self.marks[order]
        if not marks:
            none = np.empty(0)
            return Marks(np.empty((2, 0)), none, none, np.empty((width, 0)))
        marks[:] = [event_functions.joined_marks(marks)]
        return marks[0]

    def first(self, counts: Sequence[int], side: int) -> Record:
        """The first of each, once they are settled, with the side at the start."""
        record = Record(side)
        for order, count in enumerate(counts):
            if count:
                record.marks[order].append(
                    event_functions.joined_marks(self.marks[order]).those(slice(count))
                )
            record.counts[order] = count
        return record


class StopEvent(NamedTuple):
    """An event that ended the run: which, what happened of it up to then, and where."""

    event: int
    happenings: Happenings
    complete: bool
    marks: Marks


class Watch:
    """The events of one scene while a run in one number type is under way.

    ``muted``: heyoka takes the steps of a run with these events, and nothing is noted.
    Raises BadInput for an expression that has no value at t = 0 or is identically zero.
    """

    def __init__(self, scene: Scene, number: NumberType, rules: Rules, muted: bool = False) -> None:
        self.scene, self.number, self.rules, self.muted = scene, number, rules, muted
        self.any_step = rules.still
        self.way = 1 if sign(scene.end) >= 0 else -1
        self.key, self.damping, self.width = rules.key, rules.damping, rules.width
        end = equations(scene).frame.time(scene.end)
        self.after_step = AfterStep(self._stops, end, number) if rules.asks else None
        self.jets: list[Jet] = []
        self._of = [*map(Record, rules.start)]
        self._ends = [k for k, event in enumerate(scene.events) if event.stop]
        self._stop: StopEvent | None = None
        self._first: Marks | None = None  # the start
        # The integrator attached last, views of its state and of its dense output, and the
        # parameters of the jets, the time from which it counts in front.
        self._stepping: HeyokaIntegrator = None
        self._state: Array
        self._dense: Array
        self._parameters: Array

    @property
    def stop(self) -> Fraction | None:
        """The time, in the run's unit, of the event that ended the run; None while none has."""
        if self._stop is None:
            return None
        (time,) = self._stop.marks.since_start.tolist()
        return as_fraction(time, self.number)

    # -- building -----------------------------------------------------------------------------

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
        options = type_options(self.number)
        kind = {name: x for name, x in options.items() if name == "fp_type"}
        clock = {TIME: hy.time + hy.par[1] + hy.par[0]}
        constant = event_functions.typed_constant(self.number)
        jets: dict[str | None, Jet] = {}
        for k, event in enumerate(self.scene.events):
            formulas, text = self._formulas(event, pattern), event.expression
            numbers = formulas.numbers(constant)
            value = formulas.value(variables, TIME, numbers, constant, EXPRESSIONS)
            if text not in jets:
                like = next(iter(jets.values()), None)
                arguments = formulas, variables, self.number, self.rules.band, constant, like
                jets[text] = jet_of(*arguments)
            desk.jets.append(jets[text])
            for order, f in enumerate((value, rate(value, variables, rates))):
                if hy.get_variables([f]):  # a constant has no zeros
                    shifted = hy.subs(f, clock) * hy.par[CLOCK + k] + hy.par[TINY]
                    events.append(hy.nt_event(shifted, Callback(desk, k, order), **kind))
        return events, desk

    def _formulas(self, event: Event, pattern: Mapping[str, Expression]) -> Formulas:
        """An event's expression and the motion; ``pattern``: coefficients that are parameters."""
        scene, form = self.scene, equations(self.scene)

        def field(state: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
            return [fn.zero] * self.width if self.rules.still else form.field(state, k, fn)

        def numbers(constant: Callable[[Number], Expression]) -> Mapping[str, Expression]:
            exact = {**form.coefficients, **form.frame.turn}
            return {**{name: constant(x) for name, x in exact.items()}, **pattern}

        return Formulas(partial(event_functions.value_of, scene, event), field, numbers)

    def sit_down(self, engine: Engine, numbers: Array, origin: Fraction) -> None:
        """Take over the desk of the engine that a run goes on with, from an exact time on.

        ``numbers``: the coefficients that are parameters.
        """
        self._settle()
        desk, heyoka = engine.desk, engine.heyoka
        assert desk is not None
        self.jets, desk.watch = desk.jets, None if self.muted else self
        self._parameters = np.concatenate([np.zeros(2, numbers.dtype), numbers])
        self._stepping = heyoka
        self._state, self._dense = heyoka.state[: self.width], heyoka.d_output[: self.width]
        self.counts_from(origin)

    def counts_from(self, offset: Fraction) -> None:
        """Take note of the exact time at which heyoka's begins; tell it, where t is asked."""
        self._settle()
        heyoka, high = self._stepping, self.number.rounded(offset)
        clock = scalars((high, self.number.rounded(offset - high)), self.number)
        self._parameters = self._parameters.copy()  # marks know those from before
        self._parameters[:2] = array(clock, self.number)
        if any(jet.timed for jet in self.jets):
            heyoka.pars[:2] = self._parameters[:2]
        if self._first is None:
            self._first = self._here(heyoka)

    def _settle(self) -> None:
        for record in self._of if self._stepping is not None else ():
            record.settle(self._parameters, self.number)

    # -- callbacks ----------------------------------------------------------------------------

    def met(self, k: int, order: int, ta: HeyokaIntegrator, t: HeyokaNumber) -> None:
        """A zero of expression k, or of its rate, at heyoka's time t in the step just taken."""
        if ta is self._stepping:  # and not one of a search
            ta.update_d_output(t)
            record = self._of[k]
            record.notes[order].add(t, self._dense)
            record.counts[order] += 1

    def _stops(self, ta: HeyokaIntegrator) -> bool:
        """Whether an event ends the run in the step just taken."""
        for k in self._ends:
            record = self._of[k]
            if record.open or record.counts != record.seen:
                self._look(k, ta)
        return self._stop is not None

    def _look(self, k: int, ta: HeyokaIntegrator) -> None:
        """Decide about an event that may end the run: a zero counts on the other side alone."""
        record = self._of[k]
        again = record.open or record.counts[0] > record.seen[0]
        record.seen = [*record.counts]
        if not again:
            value = self.jets[k].value(self._state, ta.time, self._parameters)
            if not value * record.side < 0:  # nothing can have happened
                return
        noted, start, end = self._polished(k, self._here(ta))
        record.open = end.near
        if end.near:
            return
        decision = self._decided(k, noted, start, end)
        record.side = end.side
        happenings = decision.happenings
        counted = self._counted(k, happenings) & (happenings.signs != 0)
        for n in np.flatnonzero(counted)[:1].tolist():
            at = happenings.those(np.array([n])).located(noted)
            if self._stop is None or at.ahead[0] < self._stop.marks.since_start[0] * self.way:
                before = happenings.those(np.arange(n + 1))
                self._stop = StopEvent(k, before, decision.complete, at.marks)

    def _counted(self, k: int, happenings: Happenings) -> Booleans:
        """Which are of the direction that an event asks for."""
        wanted = DIRECTIONS[self.scene.events[k].direction] * self.way
        return happenings.signs * wanted >= 0  # a contact always

    # -- corrections of the state, and steps that are taken back --------------------------------

    def disturbed(self, state: Array, moved: Array) -> bool:
        """Whether moving the first components of the integrator's state would disturb an event.

        That is: carry its expression a quarter of the way to zero or further.
        """
        time, parameters = self._stepping.time, self._parameters
        before = state[: self.width].copy()
        after = before.copy()
        after[: len(moved)] = moved
        for jet in self.jets:
            value = jet.value(before, time, parameters)
            if abs(jet.value(after, time, parameters) - value) > abs(value) / 4:
                return True
        return False

    def marks(self) -> list[list[int]]:
        """How much is noted so far, to be given to ``take_back``."""
        return [[*record.counts] for record in self._of]

    def take_back(self, noted: object) -> None:
        """Forget what was noted since, in steps that were not the last ones of the run."""
        assert isinstance(noted, list)
        self._settle()
        self._stop = None
        starts = self.rules.start
        self._of = [r.first(*first) for r, *first in zip(self._of, noted, starts, strict=True)]

    # -- what was found -----------------------------------------------------------------------

    def events(self) -> tuple[EventTimes, ...]:
        """The events in scene axes and units, in order of integration; ends the watch's work."""
        read = Readout(self.scene, self.number)
        if self._first is None:  # no step was taken
            none = read_only(read.states([]), read.columns)
            return tuple(EventTimes(event.name, (), none, ()) for event in self.scene.events)
        last = self._here(self._stepping) if self._stop is None else self._stop.marks
        return tuple(self._event(k, last, read) for k in range(len(self.scene.events)))

    def _event(self, k: int, last: Marks, read: Readout) -> EventTimes:
        event = self.scene.events[k]
        noted, start, end = self._polished(k, last)
        if self._stop is not None:
            noted = noted.those(noted.ahead <= end.place.ahead)
        if self._stop is not None and self._stop.event == k:
            _, happenings, complete, _ = self._stop
        else:
            decision = self._decided(k, noted, start, end)
            happenings, complete = decision.happenings, decision.complete
        counted = np.flatnonzero(self._counted(k, happenings))
        deep = event_decision.depths(happenings, noted, start, end)[counted]
        happenings = happenings.those(counted)
        where = happenings.located(noted)
        times = where.marks.since_start
        rows = where.marks.columns.T
        if self.number.flat:
            sizes = np.abs(times).astype(float)
        else:
            sizes = np.array([abs(float(t)) for t in times.tolist()])
            rows = [as_mpf(row, self.number) for row in rows.tolist()]
        widths = where.width + happenings.spreads / 2 + sizes * float(self.number.eps / 2)
        with np.errstate(over="ignore"):  # of times that no double holds
            widths = np.ldexp(widths.astype(float), read.frame.exponent)
        return EventTimes(
            event.name,
            waiting(partial(event_decision.exact_times, times, read.frame, self.number)),
            read_only(read.states(rows), read.columns),
            tuple((happenings.signs * self.way).tolist()),
            tuple(widths.tolist()),
            tuple((deep * float(self.rules.band)).astype(float).tolist()),
            complete,
        )

    def _polished(self, k: int, last: Marks) -> tuple[Places, End, End]:
        """All that was noted of an event, polished; the start and an end."""
        assert self._first is not None
        self._settle()
        record, span = self._of[k], event_functions.joined_marks([self._first, last])
        met = record.joined(0, self.width), record.joined(1, self.width)
        places, ends = event_decision.polished(self.jets[k], met, span, self.way)
        start, end = ends.those(slice(1)), ends.those(slice(1, 2))
        noted = places.those(places.order)
        side = 0 if start.own[0] else self.rules.start[k]
        return noted, End(side, start), at_the_end(end)

    def _decided(self, k: int, noted: Places, start: End, end: End) -> Decision:
        """What happened of an event up to an end."""
        probe = Probe(self.jets[k], self._stepping, self.width)
        search = partial(probe.crossing, noted, start.place, end.place, self.way)
        return Decision(noted, start, end, self.way, float(self.number.eps), search)

    def _here(self, ta: HeyokaIntegrator) -> Marks:
        return mark(ta, self._parameters, self.width)

    def still(self) -> list[int]:
        """The events that start at zero and stay within rounding of it for some steps."""
        if 0 not in self.rules.start:
            return []
        motion = self._stepping, self._parameters, self.width
        suspects = [k for k, before in enumerate(self.rules.start) if before == 0]
        return [k for k in suspects if stays(self.jets[k], *motion)]
