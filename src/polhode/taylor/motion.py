"""A motion on its way by heyoka's Taylor steps: exact coefficients in, exact states out."""

from __future__ import annotations

import math
import time
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, cast

import numpy as np

from polhode.common.errors import BadInput, ConstantZero
from polhode.common.interrupts import Progress
from polhode.common.values import Recent, cached_property
from polhode.equations import kinematics, readout
from polhode.motion.outcomes import EventTimes, Outcome, Projection
from polhode.numbers import number_types
from polhode.numbers.conversion import ExactNumbers, exactly, joined, number_value, to_extended
from polhode.numbers.double_double import two_sum
from polhode.numbers.exact import ZERO
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import Array, Flat, Numbers, NumberType, Row, Rows, flat
from polhode.scenes.scene import Scene
from polhode.taylor import defaults, heyoka
from polhode.taylor.engine import TINY, Engine
from polhode.taylor.heyoka import HeyokaNumber, OutOfRange, array, as_mpf, ending, scalar, scalars
from polhode.taylor.projection import Corrector, Projector, UnitNorm
from polhode.taylor.system import System, time_array

if TYPE_CHECKING:
    from polhode.taylor.event_watch import Rules, Watch

#: Monotone times inside a frame.
Times: TypeAlias = ExactNumbers[Fraction]

#: The longest step, in the run's unit, of a run with events.  Where all that moves is small beside
#: what rests, steps are long by that, and products of small things have no polynomial over them.
_LONGEST = Fraction(1)

#: Output times ahead are looked at to so many times the longest advance.
_REACH = 1.25

#: Where a start at a pole is left, inside the run's frame: a fraction of a radian on.
_OFF_THE_POLE = Fraction(1, 2)
_PART = 800  # of the steps that take a fifth of a second: a quarter of a millisecond for a row
_rules: Recent[Rules] = Recent(1)


class Anchor(NamedTuple):
    """Where steps of a system began: the exact time, and as heyoka has them the times since
    ``offset`` (high and low part) and the state; ``grown``: the offsets of cyclic variables."""

    system: System
    time: Fraction
    offset: Fraction
    dtime: tuple[HeyokaNumber, HeyokaNumber]
    state: tuple[HeyokaNumber, ...]
    grown: tuple[int, ...]


class Motion:
    """A motion of a system in one number type, from its start.

    ``run`` is the whole of it, with what is special at the start: a state that rests, angles that
    begin at a pole.  ``begin`` takes an engine, and ``advance`` goes on with it: from chunk to
    chunk (between two it tells the progress, gives up what has no hope and hears Ctrl-C), and in a
    chunk from pause to pause, at which cyclic variables are set back and the state is corrected.
    In the steps between two pauses heyoka tells the watch of events, and anchors are noted.

    Time is kept as an exact offset plus heyoka's own time since the chunk's start: output times
    are rounded relative to that, never to zero.

    ``scene``: the system's own, with the times and events of this run.  ``every``: steps between
    two projections onto the first integrals, None for none.  ``most``: steps, the type's own limit
    where it is None.  ``spacing``: steps between two ``anchors``, of a motion that is made once
    more, without looking for its events; 0 for no anchors.

    ``steps``: those taken.  ``reached``: the exact time come to, in the scene's unit.
    ``build_seconds``: the time that compiling took.  ``remarks``: for the provenance.
    """

    method = "taylor"
    errors: tuple[float | None, ...] | None = None
    remarks: Mapping[str, str] = {}

    def __init__(
        self,
        system: System,
        scene: Scene | None = None,
        every: int | None = None,
        most: int | None = None,
        spacing: int = 0,
    ) -> None:
        self.system, self.number, self.read = system, system.number, system.read
        self.scene = system.scene if scene is None else scene
        self.every, self.most, self.spacing = every, most, spacing
        self.steps, self.reached, self.build_seconds = 0, ZERO, 0.0
        self.events: tuple[EventTimes, ...] = ()
        self.projection: Projection | None = None
        self.outcome = Outcome.NOT_RUN
        self.anchors: list[Anchor] = []
        self.watch: Watch | None = None

    def __getstate__(self) -> dict[str, object]:
        """What ``at`` needs."""
        names = "system", "scene", "every", "most", "reached"
        return {name: getattr(self, name) for name in names}

    def __setstate__(self, state: dict[str, Any]) -> None:
        reached = state.pop("reached")
        self.__init__(**state)  # type: ignore[misc]
        self.reached = reached

    # -- the whole run --------------------------------------------------------------------------

    def run(self, times: Times, progress: Progress | None = None) -> tuple[Rows, Outcome]:
        """Rows at the times, inside the frame, as far as they were reached; the outcome."""
        system, origin = self.system, ZERO
        try:
            if self.scene.events:
                self.watch = self._new_watch(muted=self.spacing > 0)
            if system.rests:
                rows, outcome = self._at_rest(times, progress)
            else:
                began = time.perf_counter()
                rows, outcome = system.first[: times[0] == 0], Outcome.REACHED_END
                self.build_seconds += time.perf_counter() - began
                if len(rows) < len(times) and system.singular:
                    outcome = Outcome.SINGULAR
                elif len(rows) < len(times):
                    if "angles" in self.scene.modelled and self.scene.starts_at_pole:
                        system, origin = self._off_the_pole(system)
                        if not isinstance(rows, list):  # what stays at the pole has no angles
                            rows = rows[:, : len(system.start)]
                    rows, outcome = self._leg(system, origin, times, rows, progress)
        except (OutOfRange, ExpressionError) as fault:  # of the system, of an event's number
            expected = f"a type of wider range ({fault})"
            raise BadInput(self.scene.name, "number", self.number.name, expected) from None
        if self.watch is not None and not self.watch.muted:
            self.events = self.watch.events()
            if outcome is Outcome.NON_FINITE:  # a contact may be polished to beyond a pole
                self.events = tuple(event.until(self.reached) for event in self.events)
        if "engine" in vars(self):
            self.release(outcome.done or outcome is Outcome.SINGULAR)
        self.outcome, self.watch = outcome, None
        return rows, outcome

    def _at_rest(self, times: Times, progress: Progress | None) -> tuple[Rows, Outcome]:
        """The same of a state that rests: only its events, those of t, need an integrator."""
        system, outside = self.system, self.system.frame.time_outside
        self.reached = outside(times[-1])
        rows = self._rows_at_rest([*map(outside, times)])
        if self.watch is None or not self.reached:
            return rows, Outcome.REACHED_END
        system = replace(system.with_outputs(()), still=True)
        first = system.rows([row[: len(system.start)] for row in rows[: times[0] == 0]])
        passed, outcome = self._leg(system, ZERO, times, first, progress)
        return rows[: len(passed)], outcome

    def _leg(
        self,
        system: System,
        origin: Fraction,
        times: Times,
        rows: Rows,
        progress: Progress | None,
    ) -> tuple[Rows, Outcome]:
        """Go through a system that stands at time ``origin``; ``rows`` and those to come."""
        watch, frame, outcome = self.watch, self.system.frame, Outcome.STOPPED_AT_EVENT
        if watch is None or watch.stop is None:
            corrector: Corrector | None = None
            if system.form.unit is not None:
                corrector = UnitNorm(system.form.unit, self.number)
            elif self.every is not None and not system.still:
                corrector = Projector(self.system.target, self.every, watch)
            steps = self.steps  # on the way off a pole
            self.begin(system, origin, corrector)
            most = defaults.of(self.number).max_steps if self.most is None else self.most
            rows, outcome = self.advance(times, most, rows, progress)
            self.steps += steps
            if corrector is not None:
                self.projection = corrector.projection
                self.build_seconds += corrector.seconds
            # the end itself, not its rounding relative to where the last chunk began
            last = times[-1] if outcome is Outcome.REACHED_END else self.time
            self.reached = frame.time_outside(last)
        if watch is not None and watch.stop is not None:
            stop = self.number.rounded(watch.stop)
            self.reached = frame.time_outside(stop)
            rows = rows[: bisect_right(times, abs(stop), hi=len(rows), key=abs)]
        return rows, outcome

    def _rows_at_rest(self, times: Sequence[Fraction]) -> Rows:
        """Rows of a state that never changes, at times in the scene's unit."""
        exact = (readout.variables(self.scene, t) for t in times)
        return self.system.rows([[number_value(x, self.number) for x in row] for row in exact])

    def _new_watch(self, muted: bool) -> Watch:
        """What looks for the scene's events, or, muted, lets heyoka take the steps as if it did."""
        from polhode.taylor.event_watch import Rules, Watch

        of, scene = self.system, self.scene

        def rules_of_events() -> Rules:
            return Rules(scene, of.number, of.tolerance, of.rests)

        timed = any(event.timed for event in scene.events)  # t in one is as large as the end
        rules = _rules.get(of, of.times(scene).outside[-1] if timed else None, rules_of_events)
        return Watch(scene, self.number, rules, muted)

    # -- a start at a pole, where psi' is 0/0 ---------------------------------------------------

    def _off_the_pole(self, system: System) -> tuple[System, Fraction]:
        """The system a moment after a start at a pole, and that moment.

        The attitude leads over the pole, to before the first output.  A motion that stays at the
        pole has no psi and phi at all.
        """
        times = self.system.times(self.scene).inside
        first = times[0] or times[1]
        moment = max(-_OFF_THE_POLE, min(_OFF_THE_POLE, first / 2))
        self.begin(system.with_outputs(("attitude",)))
        parts: list[Rows] = []
        _, outcome = self._chunk(ExactNumbers((moment,)), 10**6, parts)
        if self.watch is None and outcome.done:
            self.engine.release()
        if self.watch is not None and self.watch.stop is not None:
            return system, moment
        row = parts[0][0]
        if all(x == 0 for x in self.read.states([row])[0][3:5]):
            self.anchors.clear()
            outputs = tuple(name for name in system.outputs if name != "angles")
            names, start = system.names[:-2], system.start[:-2]
            return replace(system, names=names, outputs=outputs, start=start), ZERO
        return replace(system, start=tuple(self._with_angles(row, moment))), moment

    def _with_angles(self, row: Row, t: Fraction) -> list[Fraction]:
        """A row of the state and the attitude soon after a pole, as one with psi and phi.

        Those begin at their one-sided limits, the one of psi ± phi that has a meaning at the pole
        staying continuous.
        """
        variables = len(self.system.form.variables)
        leaving = kinematics.phi_leaving_the_pole(self.scene, 1 if t > 0 else -1)
        gamma = self.read.states([row])[0][3:]
        psi, phi = kinematics.angles_off_the_pole(
            [*row[variables:]], gamma, self.scene.psi, leaving, self.number.bits
        )
        return [*(exactly(x) for x in row), psi, phi]

    # -- steps ------------------------------------------------------------------------------------

    def begin(
        self,
        system: System,
        origin: Fraction = ZERO,
        corrector: Corrector | None = None,
        engine: Engine | None = None,
    ) -> None:
        """Stand at the start of a system at time ``origin``, no step taken.

        ``corrector``: corrects the state every so many steps.  ``engine``: stands at the start; one
        from the pool where none is given.  Raises BadInput for an event that is zero all along the
        motion, for all that the type can tell.
        """
        began = time.perf_counter()
        self.engine = system.engine(self.watch) if engine is None else engine
        self.heyoka, self.state = self.engine.heyoka, self.engine.state
        self._leg_system, self.offset, self.steps = system, origin, 0
        self.corrector, self._due = corrector, 0 if corrector is None else corrector.every
        self._cyclic = None if system.cyclic is None else system.cyclic.at_start()
        self._reach = math.inf
        #: heyoka's options of all steps
        self._options: dict[str, Any] = {}
        watch = self.watch
        if watch is not None:
            if not watch.any_step:
                self._options["max_delta_t"] = scalar(_LONGEST, self.number)
            if watch.after_step is not None:
                self._options["callback"] = watch.after_step
            watch.sit_down(self.engine, system.parameters[: len(system.equations.pattern)], origin)
        self.build_seconds += time.perf_counter() - began
        for k in [] if watch is None or watch.muted else watch.still():
            event = self.scene.events[k]
            key, text = f"events[{k + 1}].zero", event.expression or event.name
            expected = "an expression that is not zero at all times of the motion, to rounding"
            raise ConstantZero(self.scene.name, key, text, expected)

    def release(self, usable: bool = True) -> None:
        """Leave the engine to the next run of such equations, if it is of use; no step follows."""
        if usable:
            self.engine.release()
        del self.engine, self.heyoka, self.state, self.corrector, self._options

    @property
    def time(self) -> Fraction:
        """The exact time reached, inside the frame."""
        high, low = self.heyoka.dtime
        if not high:
            return self.offset
        inside = heyoka.as_fraction(high, self.number)
        if low:
            inside += heyoka.as_fraction(low, self.number)
        return self.offset + inside if self.offset else inside

    def advance(
        self,
        times: Times,
        most: float,
        rows: Rows | None = None,
        progress: Progress | None = None,
    ) -> tuple[Rows, Outcome]:
        """Go on to the last of the times: rows at those reached, and how it ended.

        ``times``: monotone, ahead of the current one but those of the ``rows`` that are there.
        ``most``: of all steps.  Ctrl-C ends it with INTERRUPTED.
        """
        parts = [self._leg_system.rows([]) if rows is None else rows]
        end, count, outcome = times[-1], len(parts[0]), Outcome.REACHED_END
        chunk = defaults.of(self.number).chunk
        try:
            while count < len(times):
                steps = int(min(chunk, most - self.steps))
                if steps <= 0:
                    outcome = Outcome.STEP_LIMIT
                    break
                rest = times[count:] if count else times
                times_passed, outcome = self._chunk(rest, steps, parts)
                count += times_passed
                if outcome is not Outcome.STEP_LIMIT:
                    break
                now = self.time
                passed = abs(now - self.offset)
                if passed <= steps * abs(now) * self.number.eps:
                    outcome = Outcome.STEP_UNDERFLOW
                    break
                ahead = abs(end - now) / passed * steps
                if self.steps + ahead > 10 * most:  # hopeless: no need to try the limit out
                    break
                if progress is not None:
                    progress(float(now / end), self.steps)
            else:
                outcome = Outcome.REACHED_END
        except KeyboardInterrupt:
            outcome = Outcome.INTERRUPTED
        parts = [*filter(len, parts)] or parts[:1]
        rows = parts[0] if len(parts) == 1 else joined(parts, self.number)
        if outcome is Outcome.NON_FINITE:
            finite = [k for k, row in enumerate(rows) if all(x - x == 0 for x in row)]
            rows = [rows[k] for k in finite] if isinstance(rows, list) else rows[finite]
        return rows, outcome

    def _chunk(self, times: Times, steps: int, parts: list[Rows]) -> tuple[int, Outcome]:
        """Take up to ``steps`` steps towards the last time: how many times were passed, and how
        they ended; rows at these are appended to ``parts``.

        STEP_LIMIT where so many were taken and the last time lies ahead.
        """
        if self.heyoka.time:
            self.offset = self.time
            self.heyoka.time = scalar(0, self.number)
        if self.watch is not None:
            self.watch.counts_from(self.offset)
        ahead = _ahead(times, self.offset, self.number)
        passed, last = 0, self.steps + steps
        cyclic, corrector, engine = self._cyclic, self.corrector, self.engine
        while True:
            pause = last if corrector is None else min(self._due, last)
            if cyclic is not None:
                pause = min(pause, (self.steps // cyclic.every + 1) * cyclic.every)
            rows, ended = self._to_pause(ahead, passed, pause - self.steps)
            if len(rows):
                parts.append(self._completed(rows))
                passed += len(rows)
            # the last step may be the last one allowed, too: heyoka then reports the latter
            if ended is not Outcome.STEP_LIMIT or passed == len(times):
                break
            if cyclic is not None and self.steps % cyclic.every == 0:
                cyclic.set_back(self.state)
            if corrector is not None and self.steps == self._due:
                self._due += corrector.every if corrector.correct(self.state) else 1
                engine.tell_kept()
            if self.steps == last:
                break
        if self.watch is not None:
            if self.watch.stop is None:
                if ended is Outcome.STOPPED_AT_EVENT:
                    ended = Outcome.NON_FINITE  # steps stand still: an expression has a pole
            elif ended not in (Outcome.NON_FINITE, Outcome.SINGULAR):
                ended = Outcome.STOPPED_AT_EVENT
        return passed, ended

    def _completed(self, rows: Array) -> Rows:
        """heyoka's rows with the whole of the cyclic variables, in the run's numbers."""
        if self._cyclic is not None:
            rows = self._cyclic.completed(rows)
        if self.number.flat:
            return cast("Rows", rows)
        return [as_mpf(row, self.number) for row in rows]

    def _to_pause(self, ahead: Numbers, reached: int, steps: int) -> tuple[Array, Outcome]:
        """Up to ``steps`` steps; before a pause no output times are looked at that it comes before.

        ``ahead``: the chunk's times, after one place to spare; ``reached`` of them are passed.
        Reach is some times the longest advance so far: heyoka takes longer for a grid, the more
        times it has.  Should an output time be passed all the same, the advance is taken back and
        made again with an eye on all of them.
        """
        ta, count, watch = self.heyoka, len(ahead) - 1, self.watch
        take = self._steps
        if watch is not None and not ta.time and not self.offset:
            take = self._first_step
        if reached == count - 1 or (self.corrector is None and self._cyclic is None):
            return take(ahead[reached:], steps)
        start_time, start_state, before = ta.dtime, self.state.copy(), self.steps
        marks = None if watch is None else watch.marks()
        reach = abs(float(start_time[0])) + self._reach
        beyond = bisect_right(ahead, reach, lo=reached + 1, key=abs)  # its place
        short = beyond < count
        if short:
            near, last = ahead[reached:beyond], ahead[-1:]
            parts = [*near, *last] if isinstance(ahead, list) else np.concatenate([near, last])
            rows, ended = take(parts, steps)
        if short and abs(ta.time) > abs(ahead[beyond]):
            self.state[:], ta.dtime, self.steps, short = start_state, start_time, before, False
            if watch is not None and marks is not None:
                watch.take_back(marks)
        if not short:
            rows, ended = take(ahead[reached:], steps)
        advance = _REACH * float(abs(ta.time) - abs(start_time[0]))
        if advance > self._reach or self._reach == math.inf:
            self._reach = advance
        return rows, ended

    def _first_step(self, ahead: Numbers, steps: int) -> tuple[Array, Outcome]:
        """The same where a run with events begins: a step with a number added, then others."""
        tiny = self.heyoka.pars[TINY : TINY + 1]  # added to all that heyoka watches
        tiny[:] = array([scalar(defaults.first_step_offset(self.number), self.number)], self.number)
        rows, ended = self._steps(ahead, 1)
        tiny[:] = array([scalar(ZERO, self.number)], self.number)
        count = len(rows)
        if ended is not Outcome.STEP_LIMIT or steps == 1 or count == len(ahead) - 1:
            return rows, ended
        more, ended = self._steps(ahead[count:].copy(), steps - 1)
        return np.concatenate([rows, more]), ended

    def _steps(self, ahead: Numbers, steps: int) -> tuple[Array, Outcome]:
        """Up to ``steps`` steps towards the last time; rows at the times passed and outcome.

        ``ahead``: a place for the time at which it begins, then the times.
        """
        ta = self.heyoka
        start_time, now = ta.dtime, ta.time
        if ahead[1] == now:  # a step ended there: heyoka has not given that row
            here = self.state.copy()[None]
            if len(ahead) == 2:
                return here, Outcome.REACHED_END
            rows, ended = self._steps(ahead[1:], steps)
            return np.concatenate([here, rows]), ended
        if len(ahead) == 2:
            # As a grid begins: the step that leaves no low part of the time.  So output times
            # change no bit of the motion.
            outcome = ta.propagate_until(now)
            if ending(outcome[0]) is not Outcome.NON_FINITE:
                take = self._anchoring if self.spacing else ta.propagate_until
                outcome = take(ahead[1], max_steps=steps, **self._options)
            ended = ending(outcome[0])
            rows = self.state[None]
            rows = rows.copy() if ended is Outcome.REACHED_END else rows[:0]
        else:
            ahead[0] = now
            times = ahead if self.number.flat else array(ahead, self.number)
            outcome = ta.propagate_grid(times, max_steps=steps, **self._options)
            rows, ended = outcome[-1][1:], ending(outcome[0])
        self.steps += int(outcome[3])
        if ended is Outcome.NON_FINITE and not math.isfinite(float(ta.time)):
            ta.dtime = start_time  # a step of no length: nothing is known after it began
        return rows, ended

    # -- any time of the motion -------------------------------------------------------------------

    def at(self, times: Sequence[Fraction]) -> tuple[Sequence[Row], Outcome, Fraction]:
        """Rows at exact times in the scene's unit up to ``reached``, in the order of the motion.

        As many as are reached; how the motion ended, and when.  Each is integrated from the anchor
        before it, by the steps of the run, of which only the last is shorter: as accurate as the
        run's own.
        """
        system = self.system
        if system.rests:
            return [*self._rows_at_rest(times)], Outcome.REACHED_END, self.reached
        rows: list[Row] = []
        path = self._once_more if any(times) else self
        walk = Motion(system, self.scene)
        walk.watch = self._new_watch(muted=True) if self.scene.events else None
        for t in times:
            if not t:
                rows.append(system.first[0])
                continue
            if abs(t) > abs(path.reached):
                break
            inside = system.frame.time(t)
            anchor = path.anchors[bisect_right(path._starts, abs(inside)) - 1]
            row = walk._row_after(anchor, inside)
            if "angles" in self.scene.modelled and anchor.system is not path.anchors[-1].system:
                exact = self._with_angles(row, inside)
                row = system.rows([[number_value(x, self.number) for x in exact]])[0]
            rows.append(row)
        return rows, path.outcome, path.reached

    @cached_property
    def _once_more(self) -> Motion:
        """The same steps once more, with anchors; events are there, and nobody looks for them."""
        spacing = max(1, defaults.of(self.number).chunk // _PART)
        again = Motion(self.system, self.scene, self.every, self.most, spacing)
        again.run(ExactNumbers((self.system.frame.time(self.reached),)))
        if again.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        return again

    @cached_property
    def _starts(self) -> list[Fraction]:
        """|t| of the anchors of a motion that is over."""
        return [abs(anchor.time) for anchor in self.anchors]

    def _anchoring(
        self, end: HeyokaNumber, max_steps: int, **options: Any
    ) -> tuple[heyoka.HeyokaOutcome, HeyokaNumber, HeyokaNumber, int]:
        """heyoka's steps to a time, with an anchor before every so many of them."""
        ta, grown = self.heyoka, () if self._cyclic is None else self._cyclic.grown
        steps, ended = 0, Outcome.STEP_LIMIT
        while ended is Outcome.STEP_LIMIT and steps < max_steps:
            state = tuple(self.state.tolist())
            start = self.time, self.offset, ta.dtime, state, grown
            self.anchors.append(Anchor(self._leg_system, *start))
            most = min(self.spacing, max_steps - steps)
            outcome = ta.propagate_until(end, max_steps=most, **options)
            ended, steps = ending(outcome[0]), steps + int(outcome[3])
        return (*outcome[:3], steps)

    def _row_after(self, anchor: Anchor, t: Fraction) -> Row:
        """The row at a time inside the frame, by the steps from the anchor before it.

        They lead to the time of the type nearest to it, and the rest is less than its last bit.
        """
        system = anchor.system
        self.begin(system)
        self.offset, self.heyoka.dtime = anchor.offset, anchor.dtime
        for i, x in enumerate(anchor.state):
            self.state[i] = x
        self.engine.tell_kept()
        if self.watch is not None:
            self.watch.counts_from(self.offset)
        ahead = scalar(self.number.rounded(t - anchor.offset), self.number)
        self.heyoka.propagate_until(ahead, **self._options)
        if self._cyclic is not None:
            self._cyclic.stand_at(anchor.grown)
        row: Row = self._completed(self.state[None].copy())[0]
        nearest = self.time
        self.release()
        return row if t == nearest else _moved(row, t - nearest, system)


def _ahead(times: Times, offset: Fraction, number: NumberType) -> Numbers:
    """A place to spare, and what has passed at each time since ``offset``, as heyoka's numbers.

    Each is rounded once; in double and extended the offset is the sum of two such numbers.
    """
    if not number.flat:
        passed = scalars([t - offset for t in times.exact], number)
        return [passed[0], *passed]
    grid = time_array(times, number)
    ahead: Flat = np.empty(len(grid) + 1, grid.dtype)
    if not offset:
        ahead[1:] = grid
        return ahead
    high = number_value(offset, number)
    low = number_value(offset - exactly(high), number)
    near, rest = two_sum(grid, -high)
    ahead[1:] = near + (rest - low)
    return ahead


def _moved(row: Row, by: Fraction, system: System) -> Row:
    """A row moved on by less than the last bit of its time."""
    if system.number.flat:
        k = {name: to_extended(x) for name, x in system.coefficients.items()}
        wide = flat(row).astype(np.longdouble)
        slopes = np.array(system.field([*wide], k, number_types.of_extended()), dtype=np.longdouble)
        moved: Flat = (wide + to_extended(by) * slopes).astype(flat(row).dtype)
        return moved
    from polhode.numbers.mpmath_context import mpmath, ordinary, own

    with mpmath.workprec(system.number.bits):
        k = {name: own(number_value(x, system.number)) for name, x in system.coefficients.items()}
        zero, step = (own(number_value(x, system.number)) for x in (Fraction(0), by))
        fn = number_types.of_mpmath()._replace(zero=zero)
        state = [own(x) for x in row]
        rates = system.field(state, k, fn)
        return [ordinary(x + step * rate) for x, rate in zip(state, rates, strict=True)]
