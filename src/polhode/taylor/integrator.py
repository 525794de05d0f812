"""heyoka's Taylor integrator in four number types: exact coefficients in, exact states out."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from polhode.numbers.exact import Number
from polhode.numbers.number_types import NumberType
from polhode.taylor import policy
from polhode.taylor.heyoka_numbers import (
    array,
    as_fraction,
    disk_cache,
    numbers,
    scalar,
    scalars,
    type_options,
)
from polhode.taylor.pool import Idle

_IDLE = Idle()


class Piece(NamedTuple):
    """heyoka's continuous output from a time on, counted from where the chunk began."""

    begun: Any
    output: Any

    def at(self, time: Any, number: NumberType) -> Any:
        """The state at one time."""
        row = self.output(time)
        return row.copy() if number.flat else numbers(row.tolist(), number)

    @property
    def bytes(self) -> int:
        """About the memory that it takes."""
        x = self.output.tcs.flat[0]
        return int(self.output.tcs.size) * (48 + x.prec // 8 if isinstance(x, hy.real) else 16)


class Mark(NamedTuple):
    """Where a chunk began: exact time, state as heyoka's numbers; where to, in how many steps.

    Then the steps taken before, those at which a correction is due, and the projector's memory.
    """

    offset: Fraction
    state: tuple[Any, ...]
    end: Fraction
    steps: int
    taken: int
    due: int
    memory: tuple[Any, ...]


class Taylor:
    """An integrator of one autonomous system from its start, in one number type.

    ``field``: rates from a list of variables and the coefficients; the start holds at time
    ``origin``.  Time is kept as an exact offset plus heyoka's own time, which is put back to 0 at
    each chunk's end: output times are rounded relative to the chunk's start, never to zero.
    ``watch`` (polhode.taylor.events) gives heyoka events and may end the run.  ``distance``, of the
    variables and the coefficients, ends the run where it falls to :func:`nearest`.
    ``projector`` (polhode.taylor.projection, polhode.taylor.unit_norm) corrects the state every so
    many steps.
    ``cyclic``: so many of the last variables, on which no rate depends, grow without bounds
    (angles).  They are kept as time is, an offset of more than twice the bits plus heyoka's own
    part, which is small: heyoka's steps are as accurate as its largest variable asks, and neglect
    the others.
    ``marks``: where each chunk began, for :meth:`again`.  ``equations``: what tells this field and
    this distance from others of the same names and coefficients; an integrator of the same
    equations that is idle is then taken up again.
    """

    def __init__(
        self,
        names: Sequence[str],
        field: Callable[[Sequence[Any], Mapping[str, Any]], list[Any]],
        coefficients: Mapping[str, Number],
        start: Sequence[Number],
        number: NumberType,
        tolerance: Number | None = None,
        origin: Fraction = Fraction(0),
        watch: Any = None,
        distance: Callable[[Sequence[Any], Mapping[str, Any]], Any] | None = None,
        projector: Any = None,
        equations: Hashable = None,
        cyclic: int = 0,
    ) -> None:
        self.number = number
        self.watch, self.projector = watch, projector
        self.offset = origin
        self.steps = 0
        self._due = 0 if projector is None else projector.every
        self._reach = math.inf
        self._fine = 2 * number.bits + 64  # bits behind the point of the offsets, which are ints
        whole = [number.rounded(x) for x in start[len(start) - cyclic :]]
        self._grown = [(x.numerator << self._fine) // x.denominator for x in whole]
        start = [*start[: len(start) - cyclic], *[Fraction(0)] * cyclic]
        self.marks: list[Mark] = []
        self._pieces: list[Piece] | None = None
        state = scalars(start, number)
        values = scalars([*coefficients.values()], number)
        self._key: Hashable = None
        if equations is not None and watch is None and number.flat:
            tol = None if tolerance is None else scalar(tolerance, number)
            self._key = (equations, *names, *coefficients, *values, number.name, tol)
        idle = None if self._key is None else _IDLE.take(self._key)
        if idle is None:
            k = {name: hy.expression(x) for name, x in zip(coefficients, values, strict=True)}
            idle = self._built(names, field, k, state, tolerance, distance)
        else:
            idle.state[:] = state
            idle.time = scalar(0, number)
        self.heyoka = idle
        self.state = self.heyoka.state  # a view of its memory

    def _built(
        self,
        names: Sequence[str],
        field: Callable[[Sequence[Any], Mapping[str, Any]], list[Any]],
        k: Mapping[str, Any],
        state: list[Any],
        tolerance: Number | None,
        distance: Callable[[Sequence[Any], Mapping[str, Any]], Any] | None,
    ) -> Any:
        number, variables = self.number, hy.make_vars(*names)
        rates = field(variables, k)
        if self._grown:
            unit = hy.expression(scalar(Fraction(1, policy.of(number).divisor), number))
            first = len(rates) - len(self._grown)
            rates[first:] = [rate * unit for rate in rates[first:]]
        options: dict[str, Any] = {}
        if tolerance is not None:
            options["tol"] = scalar(tolerance, number)
        with disk_cache(number):
            if self.watch is not None:
                options["nt_events"] = self.watch.attach(self, variables, rates)
            away = None if distance is None else distance(variables, k)
            if away is not None:
                self._key = None  # a terminal event leaves traces in an integrator
                # scaled down, so that it takes no part in choosing the steps
                near, damping = (scalar(x, number) for x in (nearest(number), _damping(number)))
                kind = {name: x for name, x in type_options(number).items() if name == "fp_type"}
                met = hy.expression(damping) * (away - hy.expression(near))
                options["t_events"] = [hy.t_event(met, **kind)]
            return hy.taylor_adaptive(
                list(zip(variables, rates, strict=True)),
                array(state, number),
                **type_options(number),
                **options,
            )

    def release(self) -> None:
        """Leave the compiled code to the next run of the same equations; the last call of all."""
        if self._key is not None:
            _IDLE.put(self._key, self.heyoka)
        del self.heyoka, self.state

    @property
    def decomposition(self) -> Any:
        """heyoka's Taylor decomposition, for tests of the constants in it."""
        return self.heyoka.decomposition

    @property
    def time(self) -> Fraction:
        """The exact time reached."""
        high, low = self.heyoka.dtime
        inside = self.exactly(high) + self.exactly(low) if low else self.exactly(high)
        return self.offset + inside if self.offset else inside

    def chunk(self, times: Sequence[Fraction], steps: int) -> tuple[Any, Any]:
        """Take up to ``steps`` steps towards the last time; states at the times that were passed.

        ``times``: ahead of the current time, monotone.  Returns rows of the run's numbers and
        heyoka's outcome.
        """
        self._rebase()
        memory = () if self.projector is None else self.projector.memory()
        kept = tuple(self.state.tolist())
        self.marks.append(Mark(self.offset, kept, times[-1], steps, self.steps, self._due, memory))
        ahead = [t - self.offset for t in times] if self.offset else times
        return self._through(scalars(ahead, self.number), steps)

    def again(self, mark: Mark) -> list[Piece]:
        """The polynomials of a chunk, taken again with the same steps to the bit."""
        self.offset, self.steps, self._due = mark.offset, mark.taken, mark.due
        self.heyoka.time = scalar(0, self.number)
        for i, x in enumerate(mark.state):
            self.state[i] = x
        if self.projector is not None:
            self.projector.recall(mark.memory)
        if self.watch is not None:
            self.watch.rebased(self)
        pieces: list[Piece] = []
        self._pieces = pieces
        self._through([scalar(mark.end - mark.offset, self.number)], mark.steps)
        return pieces

    def _through(self, grid: list[Any], steps: int) -> tuple[Any, Any]:
        """A chunk's steps, with its corrections; rows of the run's numbers, and the outcome."""
        if self.projector is None and not self._grown:
            rows, ended = self._onwards(grid, steps)
            return self._rows([rows]), ended
        found, done, last = [], 0, self.steps + steps
        every = policy.of(self.number).set_back
        while True:
            pause = last if self.projector is None else min(self._due, last)
            if self._grown:
                pause = min(pause, (self.steps // every + 1) * every)
            rows, ended = self._advance(grid, done, pause - self.steps)
            if len(rows):
                found.append(self._with_whole(rows))
                done += len(rows)
            # the last step may be the last one allowed, too: heyoka then reports the latter
            if ended != hy.taylor_outcome.step_limit or done == len(grid):
                break
            if self._grown and self.steps % every == 0:
                self._set_back()
            if self.projector is not None and self.steps == self._due:
                self._due += self.projector.every if self.projector.correct(self) else 1
            if self.steps == last:
                break
        return self._rows(found), ended

    def _advance(self, grid: list[Any], done: int, steps: int) -> tuple[Any, Any]:
        """Up to ``steps`` steps; output times that are out of reach are not looked at.

        Reach is four times the longest advance so far.  Should an output time be passed all the
        same, the advance is taken back and made again with an eye on all of them.
        """
        ta, count = self.heyoka, len(grid)
        if done == count - 1:
            return self._onwards(grid[-1:], steps)
        begun, kept, before = ta.dtime, self.state.copy(), self.steps
        marks = None if self.watch is None else self.watch.marks()
        reach = abs(float(begun[0])) + self._reach
        beyond = done
        while beyond < count and abs(grid[beyond]) <= reach:
            beyond += 1
        if beyond == done:
            rows, ended = self._onwards(grid[-1:], steps)
        elif beyond < count - 1:
            rows, ended = self._onwards([*grid[done:beyond], grid[-1]], steps)
        else:
            rows, ended = self._onwards(grid[done:], steps)
        passed = abs(ta.time)
        if beyond < count - 1 and passed > abs(grid[beyond]):
            self.state[:], ta.dtime, self.steps = kept, begun, before
            if self.watch is not None:
                self.watch.take_back(marks)
            rows, ended = self._onwards(grid[done:], steps)
        advance = 4 * float(passed - abs(begun[0]))
        if advance > self._reach or self._reach == math.inf:
            self._reach = advance
        return rows, ended

    def _onwards(self, times: list[Any], steps: int) -> tuple[Any, Any]:
        """Up to ``steps`` steps towards the last time; rows at the times passed and outcome."""
        ta = self.heyoka
        if times[0] == ta.time:  # a step ended there: heyoka has not given that row
            here = self.state.copy()[None]
            if len(times) == 1:
                return here, hy.taylor_outcome.time_limit
            rows, ended = self._onwards(times[1:], steps)
            return np.concatenate([here, rows]), ended
        options: dict[str, Any] = {"max_steps": steps}
        if self.watch is not None and self.watch.after_step is not None:
            options["callback"] = self.watch.after_step
        if len(times) == 1:
            # As a grid begins: the step that leaves no low part of the time.  So output times
            # change no bit of the motion.
            ta.propagate_until(ta.time)
            begun, dense = ta.time, self._pieces is not None
            result = ta.propagate_until(times[0], c_output=dense, **options)
            if self._pieces is not None and result[4] is not None:
                self._pieces.append(Piece(begun, result[4]))
            rows = self.state.copy()[None] if at_end(result[0]) else self.state[None][:0]
        else:
            result = ta.propagate_grid(array([ta.time, *times], self.number), **options)
            rows = result[-1][1:]
        self.steps += int(result[3])
        return rows, result[0]

    @property
    def stopped(self) -> bool:
        """Whether an event has ended the run."""
        return self.watch is not None and self.watch.stop is not None

    def _set_back(self) -> None:
        """Move what the cyclic variables have grown by to their offsets."""
        first = len(self.state) - len(self._grown)
        self._grown = [self._whole(i, x) for i, x in enumerate(self.state[first:])]
        for i in range(first, len(self.state)):
            self.state[i] = scalar(0, self.number)

    def _with_whole(self, rows: Any) -> Any:
        """Rows of heyoka's numbers with the whole of the cyclic variables."""
        for row in rows if self._grown else ():
            for i, x in enumerate(row[len(row) - len(self._grown) :], -len(self._grown)):
                row[i] = scalar(Fraction(self._whole(i, x), 1 << self._fine), self.number)
        return rows

    def _whole(self, i: int, part: Any) -> int:
        """A cyclic variable, of which heyoka has this part, as the offsets are kept."""
        x = self.exactly(part)
        more = (x.numerator * policy.of(self.number).divisor << self._fine) // x.denominator
        return self._grown[i] + more

    def _rebase(self) -> None:
        if self.heyoka.time:
            self.offset = self.time
            self.heyoka.time = scalar(0, self.number)
        if self.watch is not None:
            self.watch.rebased(self)

    def _rows(self, parts: list[Any]) -> list[Any]:
        if self.number.flat:
            return [row for part in parts for row in part]
        return [numbers(row, self.number) for part in parts for row in part.tolist()]

    def exactly(self, value: Any) -> Fraction:
        """The exact value of a number of heyoka's."""
        return as_fraction(value, self.number)


def finite(outcome: Any) -> bool:
    """Whether heyoka's outcome is other than a non-finite state."""
    return bool(outcome != hy.taylor_outcome.err_nf_state)


def at_end(outcome: Any) -> bool:
    """Whether heyoka's outcome is that the last time was reached."""
    return bool(outcome == hy.taylor_outcome.time_limit)


def at_singular_set(outcome: Any) -> bool:
    """Whether heyoka's outcome is that the distance to the singular set became too small."""
    return int(outcome) == -1  # the first and only terminal event


def nearest(number: NumberType) -> Fraction:
    """The smallest distance to a form's singular set, about sqrt(eps): a run ends there.

    A distance is a square (sin² theta), so the set is met within about eps**(1/4).  A passage at
    d was measured to cost log10(1/d) digits: a run that goes on keeps three quarters of its own.
    """
    return Fraction(2) ** -((number.bits - 1) // 2)


def _damping(number: NumberType) -> Fraction:
    return Fraction(2) ** -(number.bits // 2)
