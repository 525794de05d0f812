"""Events of a run: the zeros of expressions along the motion, located to the run's precision.

heyoka finds the zeros of each expression's Taylor polynomial, step by step.  A callback notes the
state there; when the run is over Newton's method takes all times to their last digits at once
(polhode.taylor.events.vectorized_roots), and looks at what is no plain crossing one by one.  What
heyoka is given is scaled down by sqrt(eps), so that an event takes no part in choosing the steps
(its polynomial is still right to sqrt(eps), which is enough to start from): a run with events takes
the steps of a run without them, unless an expression varies far faster than the motion.  Last bits
may differ, where an event shares terms with the equations.

Long runs in double mostly have their events found beside them (polhode.taylor.events.dense_search);
heyoka then looks like this only at what is left open.

*Grazing*: where an expression comes within sqrt(eps) of zero at an extremum, or crosses zero at
a slope that small, rounding decides whether and how often it vanishes.  The extrema are watched
too, and such a contact is reported once, as undecided, at the extremum; it never ends a run.

A zero at t = 0, by the exact scene, is not an event of the run.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np

from polhode.common.value_semantics import waiting
from polhode.equations.readout import Readout
from polhode.motion.outcomes import EventTimes
from polhode.numbers.exact import ZERO, sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Flat, Given, Numbers, read_only
from polhode.scenes.scene import Scene
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.types import (
    Expression,
    HeyokaEvent,
    HeyokaIntegrator,
    HeyokaNumber,
)
from polhode.taylor.events.callbacks import AfterStep, Callback
from polhode.taylor.events.functions import TIME, event_expression, jet, rate
from polhode.taylor.events.root_refinement import Mark, Place, is_start, polished, sorted_out
from polhode.taylor.events.rules import Rules
from polhode.taylor.events.vectorized_roots import (
    Met,
    Zeros,
    after_start,
    crossings,
    exact_times,
    gathered,
    in_order,
    joined,
    since_start,
    those,
)
from polhode.taylor.events.vectorized_roots import marks as plain_marks
from polhode.taylor.integrator.protocols import Desk, Found
from polhode.taylor.integrator.specification import TINY

_PROBES = 8  # steps over which an expression that starts at zero must leave it


class _Raw(NamedTuple):
    """A mark as the callback leaves it: conversions to exact numbers wait until the run is over."""

    offset: Fraction  # three parts of the time
    high: HeyokaNumber
    low: HeyokaNumber
    row: Numbers
    slope: int
    width: HeyokaNumber


class Watch:
    """The events of one scene while a run in one number type is under way.

    ``stop``: the time, in the run's unit, of the event that ended the run.  ``steering``: the
    events do choose the steps, since the state stands still.  Raises BadInput for an expression
    that has no value at t = 0 or is identically zero.

    What is met is noted, and polished when the run is over, all together.  It is polished where it
    is met in a run that an event may end, where it depends on t, and in types that numpy lacks.
    """

    def __init__(
        self,
        scene: Scene,
        number: NumberType,
        rules: Rules,
    ) -> None:
        self.scene, self.number = scene, number
        self.stop: Fraction | None = None
        self.muted = False
        self.forward = sign(scene.end) >= 0
        self.rules = rules
        self.start, self.limits = self.rules.start, self.rules.limits
        self.after_step = (
            AfterStep(lambda: self.stop is not None, number) if self.rules.asked else None
        )
        self.raw: list[list[_Raw]] = [[] for _ in scene.events]
        self.seen: list[list[Met]] = [[] for _ in scene.events]
        self.settled: list[list[Mark]] = [[] for _ in scene.events]  # met by an earlier integrator
        self.known: list[list[Zeros]] = [
            [] for _ in scene.events
        ]  # plain crossings found otherwise
        # Of the integrator attached last: itself, the exact time from which its own counts, and
        # what it hands to callbacks, with its dense output, a view of its memory.
        self.stepping: HeyokaIntegrator = None
        self.offset = ZERO
        self.heyoka: HeyokaIntegrator = None
        self.row: Array
        self.desk = Desk()
        self.later: list[bool] = []  # which events are polished when the run is over

    # -- building -----------------------------------------------------------------------------

    def attach(
        self,
        variables: Sequence[Expression],
        rates: Sequence[Expression],
        known: Sequence[Expression],
    ) -> tuple[list[HeyokaEvent], Desk]:
        """heyoka's events of an integrator about to be built, in its variables and its time."""
        events: list[HeyokaEvent] = []
        desk = Desk()
        options = heyoka_numbers.type_options(self.number)
        kind = {name: x for name, x in options.items() if name == "fp_type"}
        clock = hy.time + hy.par[1] + hy.par[0]

        for k, event in enumerate(self.scene.events):
            value = event_expression(self.scene, event, self.number, variables)
            values = jet([value], variables, known, 2 if self.number.flat else 1)
            desk.with_time.append("t" in hy.get_variables([value]))
            damping = hy.expression(self.limits[k].damping)
            events += [
                hy.nt_event(
                    hy.subs(f * damping, {TIME: clock}) + hy.par[TINY], Callback(desk, k), **kind
                )
                for f in (value, rate(value, variables, rates))
                if hy.get_variables([f])  # a constant has no zeros
            ]
            values = hy.subs(values, {TIME: clock})
            desk.evaluate.append(hy.cfunc(values, vars=list(variables), **options))
        if self.number.flat:
            motion = jet(known, variables, known, 1)
            desk.motion = hy.cfunc(motion, vars=list(variables), **options)
        return events, desk

    def sit_down(self, desk: Desk) -> None:
        """Take over the desk of the integrator that a run goes on with."""
        self.desk, desk.watch = desk, self
        ends = any(event.stop for event in self.scene.events)
        self.later = [self.number.flat and not (ends or timed) for timed in desk.with_time]

    def counts_from(self, offset: Fraction, heyoka: HeyokaIntegrator) -> None:
        """Take note of the integrator and of where its time begins; tell it, where t is asked."""
        self.offset, self.stepping = offset, heyoka
        if any(self.desk.with_time):
            high = self.number.rounded(offset)
            for i, part in enumerate((high, self.number.rounded(offset - high))):
                heyoka.pars[i] = heyoka_numbers.scalar(part, self.number)

    # -- callbacks ----------------------------------------------------------------------------

    def met(self, k: int, ta: HeyokaIntegrator, t: HeyokaNumber) -> None:
        """A zero of expression k or of its rate, at heyoka's time t in the step just taken."""
        if self.muted:
            return
        if ta is not self.heyoka:
            self.heyoka, self.row = ta, ta.d_output
        if self.later[k]:
            self.seen[k].append((self.offset, t, ta.update_d_output(t).copy()))
            return
        high, low = ta.dtime
        ago = (t - high) - low  # since the step's end: it holds digits that t has no room for
        place = polished(lambda when: self._at(k, when), ago, self.limits[k])
        if place is not None:
            ta.update_d_output(place.time, rel_time=True)
            self._mark(k, place)

    def _at(self, k: int, ago: HeyokaNumber) -> tuple[HeyokaNumber, HeyokaNumber]:
        """Expression k and its time derivative, at a time relative to the step's end."""
        ta = self.heyoka
        ta.update_d_output(ago, rel_time=True)
        if self.desk.with_time[k]:
            clock = ta.pars[:TINY]
            found = self.desk.evaluate[k](self.row, pars=clock, time=ta.time + ago)
        else:
            found = self.desk.evaluate[k](self.row)
        return found[0], found[1]

    def _mark(self, k: int, place: Place) -> None:
        high, low = self.heyoka.dtime
        row = self.row.copy() if self.number.flat else self.row.tolist()
        mark = _Raw(self.offset, high, low + place.time, row, place.slope, place.width)
        self.raw[k].append(mark)
        event = self.scene.events[k]
        if event.stop and place.slope and event.counts(place.slope):
            time = self._time(mark)
            if not is_start(time, place.slope, self.start[k], self.number) and (
                self.stop is None or abs(time) < abs(self.stop)
            ):
                self.stop = time

    # -- corrections of the state -------------------------------------------------------------

    def disturbed(self, state: Array, moved: Array) -> bool:
        """Whether moving the first components of the integrator's state would disturb an event.

        That is: carry its expression a quarter of the way to zero or further; next to a grazing
        contact the rate of its expression, too.
        """
        ta = self.stepping
        after = state.copy()
        after[: len(moved)] = moved
        for k, evaluate in enumerate(self.desk.evaluate):
            options = {"pars": ta.pars[:TINY], "time": ta.time} if self.desk.with_time[k] else {}
            value, slope = evaluate(state, **options)[:2]
            new_value, new_slope = evaluate(after, **options)[:2]
            if abs(new_value - value) > abs(value) / 4:
                return True
            grazing = abs(value) <= 2 * self.limits[k].contact
            if grazing and abs(new_slope - slope) > abs(slope) / 4:
                return True
        return False

    def marks(self) -> Found:
        """What was found so far, to be given to ``take_back``."""
        counts = tuple((len(raw), len(seen)) for raw, seen in zip(self.raw, self.seen, strict=True))
        return Found(counts, self.stop)

    def take_back(self, found: Found, all_but: int | None = None) -> None:
        """Forget what was found since, but of one event where that is said."""
        self.stop = found.stop
        for k, (raw, seen) in enumerate(found.counts):
            if k != all_but:
                del self.raw[k][raw:], self.seen[k][seen:]

    # -- what was found -----------------------------------------------------------------------

    def found(self) -> tuple[EventTimes, ...]:
        """The events in scene axes and units, in order of integration; ends the watch's work."""
        read, unit = Readout(self.scene, self.number), Fraction(2) ** self.scene.time_unit
        width, answers = len(read.form.variables), []
        for k, event in enumerate(self.scene.events):
            before = self.start[k] if self.forward else -self.start[k]
            zeros = after_start(self._zeros(k), before, self.number)
            found = zeros[1]
            noted = self.raw[k] or self.settled[k] or self.stop is not None
            plain = None if noted else in_order(zeros, before)
            if plain is not None:
                slopes, met, complete = found.slopes, found.rows, True
                if event.direction != "any":
                    counted = np.array([event.counts(slope) for slope in slopes.tolist()], bool)
                    plain, slopes, met = plain[counted], slopes[counted], met[counted]
                times = waiting(partial(self._exact_times, plain))
                rows: Given = met
                grazing = (False,) * len(slopes)
            else:
                marks = [*map(self._exact, self.raw[k]), *self.settled[k], *self._marks(k, zeros)]
                marks, complete = sorted_out(marks, before, self.stop, self.number, ZERO)
                marks = [m for m in marks if event.counts(m.slope)]
                times = tuple(self.number.rounded(m.time) * unit for m in marks)
                # cut: where a run begins with a bridge, that integrates other variables beside
                rows = [heyoka_numbers.numbers(m.row[:width], self.number) for m in marks]
                grazing = tuple(m.slope == 0 for m in marks)
            states = read_only(read.states(rows), read.columns)
            answers.append(EventTimes(event.name, times, states, grazing, complete))
        return tuple(answers)

    def settle(self) -> None:
        """Polish what was met so far, while the integrator that met it is there."""
        for k, met in enumerate(self.seen):
            self.settled[k] += self._marks(k, self._zeros(k))
            met.clear()

    def _marks(self, k: int, zeros: Zeros) -> list[Mark]:
        """What was met of an event with its exact times: plain crossings and others."""
        plain = zeros[1].plain
        return plain_marks(those(zeros, plain)) + self._one_by_one(k, those(zeros, ~plain))

    def _exact_times(self, times: Flat) -> tuple[Fraction, ...]:
        return tuple(exact_times(times, self.scene.time_unit, self.number))

    def _zeros(self, k: int) -> Zeros:
        """What was noted of an event and may be a zero, polished."""
        parts = self.known[k].copy()
        if self.seen[k]:
            seen = gathered(self.seen[k], self.number)
            found = crossings(seen, self.desk.evaluate[k], self.desk.motion, self.limits[k])
            parts.append(those((seen, found), ~found.none))
        return joined(parts)

    def _exact(self, raw: _Raw) -> Mark:
        """A mark with its exact time."""
        width = ZERO if raw.slope else self._exactly(raw.width)
        return Mark(self._time(raw), raw.row, raw.slope, width)

    def _one_by_one(self, k: int, zeros: Zeros) -> list[Mark]:
        """Places that are no plain crossings, each looked at along a step from there."""
        seen, marks = zeros[0], []
        if len(seen.rows) == 0:
            return []
        self.muted, self.heyoka = True, self.stepping
        self.row = self.heyoka.d_output
        for since, row in zip(since_start(seen), seen.rows, strict=True):
            self.heyoka.time = self.limits[k].zero
            self.heyoka.state[:] = row
            self.heyoka.step(write_tc=True)
            found = polished(lambda when: self._at(k, when), -self.heyoka.time, self.limits[k])
            if found is not None:
                self.heyoka.update_d_output(found.time, rel_time=True)
                high, low = self.heyoka.dtime
                raw = _Raw(since, high, low + found.time, self.row.copy(), *found[1:])
                marks.append(self._exact(raw))
        self.muted = False
        return marks

    def _time(self, raw: _Raw) -> Fraction:
        time = self._exactly(raw.high) + self._exactly(raw.low)
        return raw.offset + time if raw.offset else time

    def _exactly(self, value: HeyokaNumber) -> Fraction:
        return heyoka_numbers.as_fraction(value, self.number)

    def still(self) -> list[int]:
        """The events that start at zero and stay within rounding of it for some steps."""
        suspects = {k for k, value in enumerate(self.start) if value == 0}
        if not suspects:
            return []
        self.muted = True
        self.heyoka = probe = copy.deepcopy(self.stepping)
        self.row = probe.d_output
        for _ in range(_PROBES):
            probe.step(heyoka_numbers.scalar(1, self.number), write_tc=True)
            suspects -= {
                k
                for k in suspects
                if abs(self._at(k, self.limits[k].zero)[0]) > self.limits[k].noise
            }
        self.muted = False
        return sorted(suspects)
