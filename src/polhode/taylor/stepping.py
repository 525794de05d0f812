"""heyoka's Taylor integrator in four number types: exact coefficients in, exact states out."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.common.interrupts import Progress
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import joined
from polhode.numbers.exact import ZERO
from polhode.numbers.number_types import Array, Numbers, Row, Rows
from polhode.taylor import defaults
from polhode.taylor.defaults import first_step_offset
from polhode.taylor.engine import TINY, Engine
from polhode.taylor.heyoka import array, as_fraction, as_mpf, ending, scalar
from polhode.taylor.system import System
from polhode.taylor.time_grid import Times
from polhode.taylor.types import Corrector, HeyokaNumber, HeyokaOutcome, Watcher

#: The longest step, in the run's unit, of a run with events.  Where all that moves is small beside
#: what rests, steps are long by that, and products of small things have no polynomial over them.
_LONGEST = Fraction(1)

#: Output times ahead are looked at to so many times the longest advance.
_REACH = 1.25


class Anchor(NamedTuple):
    """Where steps began: the exact time, and as heyoka has them the times since ``offset``
    (high and low part) and the state; ``grown``: the offsets of cyclic variables."""

    time: Fraction
    offset: Fraction
    dtime: tuple[HeyokaNumber, HeyokaNumber]
    state: tuple[HeyokaNumber, ...]
    grown: tuple[int, ...]


class Integrator:
    """An integrator of one autonomous system from its start at time ``origin``.

    ``advance`` goes chunk by chunk; between two of them it tells the progress, gives up what has no
    hope and hears Ctrl-C.  ``chunk`` puts heyoka's clock back to 0, then goes from pause to pause;
    at a pause it sets cyclic variables back and corrects the state.  In the steps from a pause to
    the next, heyoka tells the watcher of events, and anchors are noted.

    Time is kept as an exact offset plus heyoka's own time since the chunk's start: output times
    are rounded relative to that, never to zero.

    ``watcher`` gives heyoka events and may end the run.  ``corrector`` corrects the state every so
    many steps.  ``engine``: stands at the start; one from the pool where none is given.
    ``anchored``: steps between two ``anchors``, which are noted where that is not 0.
    """

    def __init__(
        self,
        equations: System,
        origin: Fraction = Fraction(0),
        watcher: Watcher | None = None,
        corrector: Corrector | None = None,
        engine: Engine | None = None,
        anchored: int = 0,
    ) -> None:
        self.number, self.anchored = equations.number, anchored
        self.watcher, self.corrector = watcher, corrector
        self.offset = origin
        self.steps = 0
        self._due = 0 if corrector is None else corrector.every
        self._reach = math.inf
        self._cyclic = None if equations.cyclic is None else equations.cyclic.at_start()
        #: heyoka's options of all steps
        self._options: dict[str, Any] = {}
        if watcher is not None and not watcher.any_step:
            self._options["max_delta_t"] = scalar(_LONGEST, equations.number)
        self.anchors: list[Anchor] = []
        self.engine = engine or equations.engine(watcher)
        self.heyoka, self.state = self.engine.heyoka, self.engine.state
        if watcher is not None and self.engine.desk is not None:
            count = len(equations.equations.pattern)
            watcher.sit_down(self.engine.desk, equations.parameters[:count])
            watcher.counts_from(origin, self.heyoka)

    def release(self) -> None:
        """Leave the compiled code to the next run of the same equations; the last call of all."""
        self.engine.release()
        del self.engine, self.heyoka, self.state

    @property
    def time(self) -> Fraction:
        """The exact time reached."""
        high, low = self.heyoka.dtime
        if not high:
            return self.offset
        inside = self._exactly(high) + self._exactly(low) if low else self._exactly(high)
        return self.offset + inside if self.offset else inside

    def advance(
        self, times: Times, rows: Rows, limit: int, progress: Progress | None = None
    ) -> tuple[Rows, Outcome]:
        """Chunk by chunk: ``rows``, of the first times, and one for each time reached; the outcome.

        ``limit``: of all steps.  Ctrl-C ends it with INTERRUPTED.
        """
        end, parts, count = times[-1], [rows], len(rows)
        most = defaults.of(self.number).chunk
        try:
            while count < len(times):
                steps = min(most, limit - self.steps)
                if steps <= 0:
                    outcome = Outcome.STEP_LIMIT
                    break
                more, outcome = self.chunk(times[count:] if count else times, steps)
                if outcome is Outcome.NON_FINITE:
                    finite = [k for k, row in enumerate(more) if all(x - x == 0 for x in row)]
                    more = [more[k] for k in finite] if isinstance(more, list) else more[finite]
                parts.append(more)
                count += len(more)
                if outcome is not Outcome.STEP_LIMIT:
                    break
                passed = abs(self.time - self.offset)
                if passed <= steps * abs(self.time) * self.number.eps:
                    outcome = Outcome.STEP_UNDERFLOW
                    break
                ahead = abs(end - self.time) / passed * steps
                if self.steps + ahead > 10 * limit:  # hopeless: no need to try the limit out
                    break
                if progress is not None:
                    progress(float(self.time / end), self.steps)
            else:
                outcome = Outcome.REACHED_END
        except KeyboardInterrupt:
            outcome = Outcome.INTERRUPTED
        return joined([*filter(len, parts)] or [rows], self.number), outcome

    def chunk(self, times: Sequence[Fraction], steps: int) -> tuple[Rows, Outcome]:
        """Take up to ``steps`` steps towards the last time; states at the times that were passed.

        ``times``: ahead of the current time, monotone.  Returns rows of the run's numbers, and how
        the steps ended: STEP_LIMIT where they were taken and the last time lies ahead.
        """
        if self.heyoka.time:
            self.offset = self.time
            self.heyoka.time = scalar(0, self.number)
        if self.watcher is not None:
            self.watcher.counts_from(self.offset, self.heyoka)
        if not isinstance(times, Times):
            times = Times(times, self.number)
        ahead = times.ahead(self.offset)
        parts: list[Array] = []
        passed, last = 0, self.steps + steps
        while True:
            rows, ended = self._to_pause(ahead, passed, self._pause(last) - self.steps)
            if len(rows):
                parts.append(rows if self._cyclic is None else self._cyclic.completed(rows))
                passed += len(rows)
            # the last step may be the last one allowed, too: heyoka then reports the latter
            if ended is not Outcome.STEP_LIMIT or passed == len(times):
                break
            if self._cyclic is not None and self.steps % self._cyclic.every == 0:
                self._cyclic.set_back(self.state)
            if self.corrector is not None and self.steps == self._due:
                self._due += self.corrector.every if self._correct(self.corrector) else 1
            if self.steps == last:
                break
        if self.watcher is not None:
            if self.watcher.stop is None:
                if ended is Outcome.STOPPED_AT_EVENT:
                    ended = Outcome.NON_FINITE  # steps stand still: an expression has a pole
            elif ended not in (Outcome.NON_FINITE, Outcome.SINGULAR):
                ended = Outcome.STOPPED_AT_EVENT
        return self._rows(parts), ended

    def _pause(self, last: int) -> int:
        """The step after which something is due; the last one at most."""
        pause = last if self.corrector is None else min(self._due, last)
        if self._cyclic is not None:
            every = self._cyclic.every
            pause = min(pause, (self.steps // every + 1) * every)
        return pause

    def at(self, anchor: Anchor, t: Fraction) -> tuple[Row, Fraction]:
        """The row at the time of the type nearest to t, by the steps from the anchor before it.

        Not beyond the next anchor.  And that time itself.
        """
        self.offset, self.heyoka.dtime = anchor.offset, anchor.dtime
        for i, x in enumerate(anchor.state):
            self.state[i] = x
        self.engine.tell_kept()
        if self.watcher is not None:
            self.watcher.counts_from(self.offset, self.heyoka)
        ahead = scalar(self.number.rounded(t - anchor.offset), self.number)
        self.heyoka.propagate_until(ahead, **self._options)
        part = self.state[None].copy()
        if self._cyclic is not None:
            self._cyclic.stand_at(anchor.grown)
            part = self._cyclic.completed(part)
        row: Row = self._rows([part])[0]
        return row, self.time

    def _correct(self, corrector: Corrector) -> bool:
        corrected = corrector.correct(self.state)
        self.engine.tell_kept()
        return corrected

    def _to_pause(self, ahead: Numbers, reached: int, steps: int) -> tuple[Array, Outcome]:
        """Up to ``steps`` steps; before a pause no output times are looked at that it comes before.

        ``ahead``: the chunk's times, after one place to spare; ``reached`` of them are passed.
        Reach is some times the longest advance so far: heyoka takes longer for a grid, the more
        times it has.  Should an output time be passed all the same, the advance is taken back and
        made again with an eye on all of them.
        """
        ta, count = self.heyoka, len(ahead) - 1
        take = self._steps
        if self.watcher is not None and not self.heyoka.time and not self.offset:
            take = self._first_step
        if reached == count - 1 or (self.corrector is None and self._cyclic is None):
            return take(ahead[reached:], steps)
        start_time, start_state, before = ta.dtime, self.state.copy(), self.steps
        marks = None if self.watcher is None else self.watcher.marks()
        reach = abs(float(start_time[0])) + self._reach
        beyond = bisect_right(ahead, reach, lo=reached + 1, key=abs)  # its place
        short = beyond < count
        if short:
            near, last = ahead[reached:beyond], ahead[-1:]
            parts = [*near, *last] if isinstance(ahead, list) else np.concatenate([near, last])
            rows, ended = take(parts, steps)
        if short and abs(ta.time) > abs(ahead[beyond]):
            self.state[:], ta.dtime, self.steps, short = start_state, start_time, before, False
            if self.watcher is not None and marks is not None:
                self.watcher.take_back(marks)
        if not short:
            rows, ended = take(ahead[reached:], steps)
        advance = _REACH * float(abs(ta.time) - abs(start_time[0]))
        if advance > self._reach or self._reach == math.inf:
            self._reach = advance
        return rows, ended

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
        options = {"max_steps": steps, **self._options}
        if self.watcher is not None and self.watcher.after_step is not None:
            options["callback"] = self.watcher.after_step
        if len(ahead) == 2:
            # As a grid begins: the step that leaves no low part of the time.  So output times
            # change no bit of the motion.
            result = ta.propagate_until(now)
            if ending(result[0]) is not Outcome.NON_FINITE:
                result = (self._anchoring if self.anchored else ta.propagate_until)(
                    ahead[1], **options
                )
            ended = ending(result[0])
            rows = self.state[None]
            rows = rows.copy() if ended is Outcome.REACHED_END else rows[:0]
        else:
            ahead[0] = now
            grid = ahead if self.number.flat else array(ahead, self.number)
            result = ta.propagate_grid(grid, **options)
            rows, ended = result[-1][1:], ending(result[0])
        self.steps += int(result[3])
        if ended is Outcome.NON_FINITE and not math.isfinite(float(ta.time)):
            ta.dtime = start_time  # a step of no length: nothing is known after it began
        return rows, ended

    def _first_step(self, ahead: Numbers, steps: int) -> tuple[Array, Outcome]:
        """The same where a run with events begins: a step with a number added, then others."""
        self._add(first_step_offset(self.number))
        rows, ended = self._steps(ahead, 1)
        self._add(ZERO)
        count = len(rows)
        if ended is not Outcome.STEP_LIMIT or steps == 1 or count == len(ahead) - 1:
            return rows, ended
        more, ended = self._steps(ahead[count:].copy(), steps - 1)
        return np.concatenate([rows, more]), ended

    def _add(self, tiny: Fraction) -> None:
        """Add a number to all that heyoka watches."""
        self.heyoka.pars[TINY : TINY + 1] = array([scalar(tiny, self.number)], self.number)

    def _anchoring(
        self, end: HeyokaNumber, max_steps: int, **options: Any
    ) -> tuple[HeyokaOutcome, HeyokaNumber, HeyokaNumber, int]:
        """The same steps, with an anchor before every so many of them."""
        ta, grown = self.heyoka, () if self._cyclic is None else self._cyclic.grown
        steps, ended = 0, Outcome.STEP_LIMIT
        while ended is Outcome.STEP_LIMIT and steps < max_steps:
            state = tuple(self.state.tolist())
            self.anchors.append(Anchor(self.time, self.offset, ta.dtime, state, grown))
            most = min(self.anchored, max_steps - steps)
            result = ta.propagate_until(end, max_steps=most, **options)
            ended, steps = ending(result[0]), steps + int(result[3])
        return (*result[:3], steps)

    def _rows(self, parts: Sequence[Array]) -> Rows:
        if self.number.flat:
            rows: Rows = joined(parts or [self.state[None][:0]], self.number)
            return rows
        return [as_mpf(row, self.number) for part in parts for row in part]

    def _exactly(self, value: HeyokaNumber) -> Fraction:
        return as_fraction(value, self.number)
