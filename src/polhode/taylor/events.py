"""Events of a run: the zeros of expressions along the motion, located to the run's precision.

heyoka finds the zeros of each expression's Taylor polynomial, step by step.  A callback then
polishes the time by Newton's method on the dense output, relative to the step's end, and reads the
state there.  What heyoka is given is scaled down by sqrt(eps), so that an event takes no part in
choosing the steps (its polynomial is still right to sqrt(eps), which is enough to start from): a
run with events takes the steps of a run without them, unless an expression varies far faster than
the motion.  Last bits may differ, where an event shares terms with the equations.

*Grazing*: where an expression comes within sqrt(eps) of zero at an extremum, or crosses zero at
a slope that small, rounding decides whether and how often it vanishes.  The extrema are watched
too, and such a contact is reported once, as undecided, at the extremum; it never ends a run.

A zero at t = 0, by the exact scene, is not an event of the run.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import heyoka as hy

from polhode.equations.readout import Readout
from polhode.numbers.exact import ZERO, sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Row
from polhode.scenes.scene import Scene
from polhode.taylor import heyoka_numbers
from polhode.taylor.event_expressions import TIME, event_expression
from polhode.taylor.event_limits import Limits
from polhode.taylor.event_polish import Mark, Place, is_start, polished, sorted_out
from polhode.taylor.event_sizes import sign_at_start, size_of
from polhode.taylor.event_steps import AfterStep, is_entire
from polhode.taylor.kinds import (
    CompiledFunction,
    Expression,
    HeyokaEvent,
    HeyokaIntegrator,
    HeyokaNumber,
)
from polhode.taylor.outcomes import EventTimes
from polhode.taylor.protocols import Found

_PROBES = 8  # steps over which an expression that starts at zero must leave it


class _Raw(NamedTuple):
    """A mark as the callback leaves it: conversions to exact numbers wait until the run is over."""

    offset: Fraction  # three parts of the time
    high: HeyokaNumber
    low: HeyokaNumber
    row: Row
    slope: int
    width: HeyokaNumber


class Watch:
    """The events of one scene while a run in one number type is under way.

    ``stop``: the time, in the run's unit, of the event that ended the run.  ``steering``: the
    events do choose the steps, since the state stands still.  Raises BadInput for an expression
    that has no value at t = 0 or is identically zero.
    """

    def __init__(
        self,
        scene: Scene,
        number: NumberType,
        tolerance: Fraction | None,
        steering: bool = False,
    ) -> None:
        self.scene, self.number = scene, number
        self.stop: Fraction | None = None
        self.muted = False
        self.forward = sign(scene.end) >= 0
        self.start = [sign_at_start(scene, k) for k in range(len(scene.events))]
        asked = any(e.stop or not is_entire(scene, e) for e in scene.events)
        self.after_step = AfterStep(lambda: self.stop is not None, number) if asked else None
        eps = max(number.eps, tolerance or ZERO)
        self.limits = [
            Limits(size_of(scene, event), number, eps, steering) for event in scene.events
        ]
        self.raw: list[list[_Raw]] = [[] for _ in scene.events]
        # Of the integrator attached last: itself, the exact time from which its own counts, and
        # what it hands to callbacks, with its dense output, a view of its memory.
        self.stepping: HeyokaIntegrator = None
        self.offset = ZERO
        self.heyoka: HeyokaIntegrator = None
        self.row: Row = None
        self.evaluate: list[CompiledFunction] = []  # expression and time derivative
        self.with_time: list[bool] = []

    # -- building -----------------------------------------------------------------------------

    def attach(
        self, variables: Sequence[Expression], rates: Sequence[Expression]
    ) -> list[HeyokaEvent]:
        """heyoka's events of an integrator about to be built, in its variables and its time."""
        events: list[HeyokaEvent] = []
        self.evaluate, self.with_time = [], []
        options = heyoka_numbers.type_options(self.number)
        kind = {name: x for name, x in options.items() if name == "fp_type"}
        clock = hy.time + hy.par[1] + hy.par[0]
        for k, event in enumerate(self.scene.events):
            value = event_expression(self.scene, event, self.number, variables)
            slope = sum(
                (hy.diff(value, x) * rate for x, rate in zip(variables, rates, strict=True)),
                hy.diff(value, TIME),
            )
            self.with_time.append("t" in hy.get_variables([value]))
            damping = hy.expression(self.limits[k].damping)
            events += [
                hy.nt_event(hy.subs(f * damping, {TIME: clock}), _Callback(self, k), **kind)
                for f in (value, slope)
                if hy.get_variables([f])  # a constant has no zeros
            ]
            both = hy.subs([value, slope], {TIME: clock})
            self.evaluate.append(hy.cfunc(both, vars=list(variables), **options))
        return events

    def counts_from(self, offset: Fraction, heyoka: HeyokaIntegrator) -> None:
        """Take note of the integrator and of where its time begins; tell it, where t is asked."""
        self.offset, self.stepping = offset, heyoka
        if any(self.with_time):
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
        if self.with_time[k]:
            value, slope = self.evaluate[k](self.row, pars=ta.pars, time=ta.time + ago)
        else:
            value, slope = self.evaluate[k](self.row)
        return value, slope

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

    def disturbed(self, state: Row, moved: Row) -> bool:
        """Whether moving the first components of the integrator's state would disturb an event.

        That is: carry its expression a quarter of the way to zero or further; next to a grazing
        contact the rate of its expression, too.
        """
        ta = self.stepping
        after = state.copy()
        after[: len(moved)] = moved
        for k, both in enumerate(self.evaluate):
            options = {"pars": ta.pars, "time": ta.time} if self.with_time[k] else {}
            value, slope = both(state, **options)
            new_value, new_slope = both(after, **options)
            if abs(new_value - value) > abs(value) / 4:
                return True
            grazing = abs(value) <= 2 * self.limits[k].contact
            if grazing and abs(new_slope - slope) > abs(slope) / 4:
                return True
        return False

    def marks(self) -> Found:
        """What was found so far, to be given to ``take_back``."""
        return Found(tuple(len(raw) for raw in self.raw), self.stop)

    def take_back(self, found: Found) -> None:
        """Forget what was found since."""
        self.stop = found.stop
        for raw, count in zip(self.raw, found.counts, strict=True):
            del raw[count:]

    # -- what was found -----------------------------------------------------------------------

    def found(self) -> tuple[EventTimes, ...]:
        """The events in scene axes and units, in order of integration."""
        read, unit = Readout(self.scene, self.number), Fraction(2) ** self.scene.time_unit
        answers = []
        for k, event in enumerate(self.scene.events):
            marks, complete = self._sorted_out(k)
            marks = [m for m in marks if event.counts(m.slope)]
            answers.append(
                EventTimes(
                    name=event.name,
                    times=tuple(self.number.rounded(m.time) * unit for m in marks),
                    states=read.states([heyoka_numbers.numbers(m.row, self.number) for m in marks]),
                    grazing=tuple(m.slope == 0 for m in marks),
                    complete=complete,
                )
            )
        return tuple(answers)

    def _sorted_out(self, k: int) -> tuple[list[Mark], bool]:
        """Each event once; and whether rising and falling alternate, as they do if none is lost."""
        marks = [
            Mark(
                self._time(raw),
                raw.row,
                raw.slope,
                ZERO if raw.slope else self._exactly(raw.width),
            )
            for raw in self.raw[k]
        ]
        before = self.start[k] if self.forward else -self.start[k]
        return sorted_out(marks, before, self.stop, self.number, ZERO)

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


class _Callback:
    """heyoka's call where an event is met; heyoka copies its callbacks, this one stays one."""

    def __init__(self, watch: Watch, k: int) -> None:
        self.watch, self.k = watch, k

    def __call__(self, ta: HeyokaIntegrator, t: HeyokaNumber, _: int) -> None:
        self.watch.met(self.k, ta, t)

    def __deepcopy__(self, _: object) -> _Callback:
        return self
