"""A body's motion from any start to any time, again and again: nothing but the engine each time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from threading import get_ident
from typing import Any, cast
from weakref import finalize

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import is_unit, not_taken, numbers_given, rows_of, unit_rows, whole
from polhode.common.errors import BadInput, plain
from polhode.common.values import cached_property, refuse_too_much
from polhode.motion.outcomes import OUTCOMES, Outcome, code
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, EXTENDED, AnyNumber, Doubles, Extendeds, Flat, flat
from polhode.runs.options import Options, cadence, checked_options, choose_number
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.taylor import defaults, lanes
from polhode.taylor.batches import BatchJob, BatchMotions
from polhode.taylor.engine import Engine, order_of
from polhode.taylor.heyoka import TIME_LIMIT, OutOfRange
from polhode.taylor.long_steps import LongSteps, TimeGrid
from polhode.taylor.motion import Motion
from polhode.taylor.projection import Projector, StartTarget
from polhode.taylor.system import System, system_of, time_array

_REACHED_END = Outcome.REACHED_END
_REACHED = code(_REACHED_END)
_THERE = TIME_LIMIT.value
_UNIT = 4  # where |gamma|² is 1 to so many eps, rounded, it surely is to 8
_FLOATS = frozenset({float, np.float64, np.float32})  # kinds of numbers that are doubles,
_PLAIN = _FLOATS | {int, np.int64}
_WHOLE = 2**53  # integers of at most this size among them
_BLOCK = 1024  # rows that are scaled at once: numpy's loops over six numbers are slow
_BYTES = 24  # of a number of the states of many starts, while they are put in order
_SPLIT = "numbers of states; fewer times, or starts in parts"


class Propagator:
    """The motions of one body from any start, by one prepared integrator.

    ``go(start, t)``: ``start`` six numbers p q r gamma1 gamma2 gamma3 in the scene's body axes and
    units (three without gamma), the scene's own start if left out; ``t`` one time, or several.  It
    returns an array of shape (6,), or (n, 6) for n times; nan where the time was not reached.  An
    array of starts, (N, 6), gives (N, 6) or (N, n, 6): eight of them at a time, in threads where
    that is faster.  Made by :func:`polhode.propagator`, for the thread that made it; ``copy.copy``
    gives another thread its own.

    Attributes
    ----------
    scene : Scene
        The scene with the body, and with the start that is used if none is given.
    number : NumberType
        double or extended.
    outcome : Outcome
        How the last call ended; of an array of starts the first that did not reach the end.
    outcomes : tuple of Outcome
        How each start of the last call ended.
    steps : int or None
        The Taylor steps of the last call; None of an array, whose steps are not counted.

    Examples
    --------
    >>> import polhode
    >>> go = polhode.propagator("euler/largest-axis")
    >>> go
    <Propagator of euler/largest-axis: double>
    >>> there = go(t=100.0)
    >>> abs(go(there, t=-100.0) - go(t=0.0)).max() < 1e-12  # and back again
    np.True_
    >>> there = go([1, 0.5, 0, 0, 0, 1], t=[1, 10, 100])  # another start, several times
    >>> there.shape, go.steps > 100, go.outcome.done
    ((3, 6), True, True)
    >>> starts = [[1, 0.5, r, 0, 0, 1] for r in range(100)]
    >>> go(starts, t=10.0).shape, go(starts, t=[1, 10, 100]).shape, go.outcome.done
    ((100, 6), (100, 3, 6), True)
    """

    steps: int | None

    def __init__(self, system: System, every: int | None) -> None:
        self.scene, self.number = system.scene, system.number
        self.outcome, self.steps = _REACHED_END, 0
        self._ended: npt.NDArray[np.uint8] | None = None  # how the last array's starts did
        self._system, self._every = system, every
        self._owner = get_ident()
        self._engine = system.engine()
        finalize(self, self._engine.release).atexit = False  # another body's from then on
        self._state = self._engine.state
        #: several times by value, their grid, which long steps are for so many, how far these are
        self._last: tuple[bytes, TimeGrid | None, LongSteps | None, float] = b"", None, None, 0.0
        self._memory: Any = memoryview(self._state)  # which takes an array of its own kind alone
        self._first: Flat = self._state.copy()
        self._kind, self._shape = self._first.dtype, self._first.shape
        self._long = self.number.name == "extended"
        self._slack = _UNIT * float(self.number.eps)
        frame = system.frame
        self._turn = None if frame.axes.trivial else frame.matrix(EXTENDED)
        unit = np.ldexp(self._kind.type(1), frame.exponent)
        self._back_unit = unit.item()
        self._scale = np.ones(self._shape, self._kind)
        self._scale[:3] = unit
        self._back = 1 / self._scale
        self._backs = np.tile(self._back, (_BLOCK, 1))
        self._plain = unit == 1 and self._turn is None
        back = None if self._plain or self._turn is not None else self._back
        # the tolerance where it is above eps and it alone decides, no projection; else 0
        loose = 0.0
        if system.tolerance is not None and self.number == DOUBLE and every is None:
            loose = float(system.tolerance) if system.tolerance > DOUBLE.eps else 0.0
        self._long_steps = [
            LongSteps(system, choice, np.asarray(self._state, np.float64), back)
            for choice in defaults.long_steps(loose)
        ]
        self._far = math.inf  # (radians)**2 from where on heyoka's own order is not the fastest
        if loose > defaults.ABOVE:
            self._far, self._order = defaults.FAR**2, order_of(loose) + defaults.MORE
        self._unit = (1 / unit).item()  # Python's own number: a product too large is inf, unsaid
        choices = defaults.of(self.number)
        self._most = choices.max_steps
        #: (rate t)**2 of a call that needs no limit; none is, where the state is projected
        self._sure = (choices.chunk / lanes.STEPS) ** 2 if every is None else 0.0
        body = self.scene.body
        with np.errstate(all="ignore"):  # inf or nan of a body beyond the range: never sure
            bound = lanes.Bound.of(_doubles(body.moments), _doubles(body.torque))
            if self._turn is not None:
                bound = bound.about_any_axes()
            least = float(self._unit * self._unit) * 2.0**-900
            #: (rate)**2 of a start as it is given: of w squared, of gamma, and the rest
            self._terms = *bound.terms.tolist(), max(float(bound.rest), least)
            fastest = lanes.rates(self._first[None], self._bound).item() * float(self._unit)
        self._rate = max(fastest * fastest, least)

    def __call__(
        self,
        start: npt.ArrayLike | None = None,
        *,
        t: AnyNumber | npt.ArrayLike,
        workers: int | None = None,
    ) -> Doubles | Extendeds:
        """The state at time ``t``, or the states at several times; of one start or of many.

        Parameters
        ----------
        start : array_like, shape (6,), (3,), (N, 6) or (N, 3), optional
            p q r gamma1 gamma2 gamma3 at t = 0 in the scene's axes and units, omega alone of a
            scene without gamma; the scene's own start where it is left out.  Numbers of the
            propagator's type or a narrower one; |gamma|² is 1 to 8 eps of the propagator's type.
        t : number or sequence of numbers
            The time, or times of one sign that lead away from 0, in the scene's unit.
        workers : int, optional
            Threads for an array of starts; by default as many as there are cores, if they gain
            anything.

        Returns
        -------
        ndarray, shape (6,), (len(t), 6), (N, 6) or (N, len(t), 6)
            The states, an array of its own; nan where a time was not reached, which ``outcome`` and
            ``outcomes`` then say.

        Raises
        ------
        BadInput
            A start that is not finite, of another shape or of a wider type, or whose gamma is no
            unit vector, the first such row of an array; more numbers than there is memory for; a
            time that is not finite; a call from another thread.

        Notes
        -----
        A row of an array has the same bits whatever rows are beside it, in whatever order, and with
        any number of threads.  It is computed in the lanes of a batch, a start alone is not: the
        last bits of the two differ.  In extended, and where the state is projected, the rows go one
        by one.

        With a tolerance of 1e-12 or more and one time, arrays of 1024 starts or more go by steps of
        equal length, so many as the row itself asks for; whose error is then larger than the
        tolerance allows goes in a batch.  So a row of such an array and the same row of a smaller
        one, or at several times, differ by errors of the size that the tolerance stands for.
        """
        if get_ident() != self._owner:
            raise self._bad("thread", "another one", "its own, or a copy.copy of the propagator")
        self._ended = None
        if type(t) is not float and type(t) in _PLAIN and -_WHOLE <= cast(float, t) <= _WHOLE:
            t = float(cast(float, t))
        try:
            if start is None:
                rate = self._rate
                self._state[...] = self._first
            else:
                if type(start) is not np.ndarray:
                    row = _plain_numbers(start, self._kind)
                    if row is None and _rows_given(start):
                        return self._many(start, t, workers)
                    start = self._array(start) if row is None else row
                try:
                    self._memory[:] = start
                except (ValueError, NotImplementedError):  # of another type or shape
                    if start.ndim > 1:
                        return self._many(start, t, workers)
                    start = self._array(start)
                    self._memory[:] = start
                numbers = start.tolist()
                p, q, r, a, b, c = numbers if len(numbers) == 6 else (*numbers, 1.0, 0.0, 0.0)
                off = not -self._slack <= a * a + b * b + c * c - 1.0 <= self._slack
                if off and not is_unit((a, b, c), self.number.eps):
                    raise self._bad("start", plain(start), "gamma of length 1, to 8 eps")
                if self._long:
                    p, q, r = float(p), float(q), float(r)  # whose squares are inf, unsaid
                of_p, of_q, of_r, of_a, of_b, of_c, rate = self._terms
                rate += of_p * p * p + of_q * q * q + of_r * r * r + of_a * a + of_b * b + of_c * c
                if self._turn is not None:
                    self._state[...] = self._inside(start)
                elif self._long:
                    np.multiply(start, self._scale, self._state)
                elif not self._plain:
                    memory, unit = self._memory, self._back_unit
                    memory[0], memory[1], memory[2] = p * unit, q * unit, r * unit
            engine = self._engine
            if type(t) is float:
                if (square := t * t * rate) < self._sure:  # not where any of them is not finite
                    if square > self._far:
                        engine = self._higher_at_start()
                    engine.begin()
                    ended, _, _, self.steps, _, _ = engine.heyoka.propagate_until(t * self._unit)
                    if ended.value == _THERE:
                        self.outcome = _REACHED_END
                        if self._turn is not None:
                            return self._read(engine.state)
                        state: Flat = (
                            engine.state.copy() if self._plain else engine.state * self._back
                        )
                        return state
            elif (grid := self._grid(t)) is not None and (
                square := grid.square * rate
            ) < self._sure:
                _, _, long_steps, far = self._last
                if long_steps and (attempt := long_steps.rows(grid, square)) is not None:
                    outputs, self.steps = attempt
                    self.outcome = _REACHED_END
                    return outputs if self._turn is None else self._read(outputs)
                if square > far:
                    engine = self._higher_at_start()
                engine.begin()
                ended, _, _, self.steps, _, rows = engine.heyoka.propagate_grid(grid.ahead)
                if ended.value == _THERE:
                    self.outcome = _REACHED_END
                    if engine is not self._engine:
                        rows = rows[:, : engine.columns].copy()
                    states: Flat = rows if len(rows) == grid.size else rows[1:]
                    return states if self._plain else self._read(states)
            time_list, several = numbers_given(t)
            if self._long_steps and _plain_numbers(time_list, self._kind) is None:
                times, unit = self._times(t)[0], self._unit
                rounded = [x / unit for x in times.tolist()]  # the way is that of these
                if [x * unit for x in rounded] == times.tolist():
                    return self(start, t=rounded if several else rounded[0])
            rows = self._at_times(start, cast(Sequence[AnyNumber], time_list))
            return rows if several else rows[0]
        except KeyboardInterrupt:
            self.steps, self.outcome = None, Outcome.INTERRUPTED
            raise

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        """How each start of the last call ended."""
        if self.steps is not None or self._ended is None:
            return (self.outcome,)
        return tuple(OUTCOMES[k] for k in self._ended.tolist())

    def _many(
        self, starts: npt.ArrayLike, t: AnyNumber | npt.ArrayLike, workers: int | None
    ) -> Doubles | Extendeds:
        """States of an array of starts."""
        name, width = self.scene.name, self._shape[0]
        rows: Flat = rows_of(name, "start", starts, width, self._kind)
        if width == 6:
            unit_rows(name, "start", rows[:, 3:], self.number.eps)
        if workers is not None:
            workers = whole(name, "workers", workers, 1)
        if isinstance(t, Iterator):  # it is looked at more than once
            t = [*t]
        times, several = self._times(t)
        amount = f"{len(rows)} starts at {len(times)} times"
        refuse_too_much(name, "start", amount, rows.size * len(times), _BYTES, _SPLIT)
        if not self._long and self._every is None:
            inside = rows if self._plain else self._inside(rows)
            motions = BatchMotions(self._job.motions.coefficients, inside)
            job = self._job._replace(max_steps=self._most, times=times, motions=motions)
            inner, ended = lanes.states(job, lanes.rates(inside, self._bound), workers)
            states = self._read(inner)
        else:
            states = np.empty((len(rows), len(times), width), self._kind)
            ended = np.empty(len(rows), dtype=np.uint8)
            for k, row in enumerate(rows):
                states[k] = self(row, t=t)
                ended[k] = code(self.outcome)
        self.steps, self.outcome, self._ended = None, _REACHED_END, ended
        short = ended[ended != _REACHED]
        if len(short):
            self.outcome = OUTCOMES[short[0]]
        return states if several else states[:, 0]

    @cached_property
    def _job(self) -> BatchJob:
        """What the motions of an array have in common."""
        k = self._system.coefficients
        numbers = {name: to_double(k[name]) for name in sorted(k)}
        motions = BatchMotions(np.array([[*numbers.values()]]), np.empty((0, self._shape[0])))
        tolerance, order = self._system.tolerance, 0
        if tolerance is not None and tolerance > self.number.eps:
            order, own = defaults.ARRAYS.highest, order_of(float(tolerance))
            order = min(order, round(defaults.ARRAYS.factor * own)) if own < order else 0
        fields = (*numbers,), self.number, tolerance, self._most, np.zeros(1)
        return BatchJob(*fields, self._system.frame.unit, motions, order=order)

    @cached_property
    def _bound(self) -> lanes.Bound:
        """What bounds the rates of motions, in principal axes and the run's own unit of time."""
        body = self._system.form.scene.body
        return lanes.Bound.of(_doubles(body.moments), _doubles(body.torque))

    def _times(self, t: AnyNumber | npt.ArrayLike) -> tuple[Flat, bool]:
        """Times in the run's own unit as an array, and whether several were given."""
        if type(t) is float and t and isfinite(end := t * self._unit):
            return np.array([end], self._kind), False
        if (grid := self._grid(t)) is not None:
            return grid.times, True
        several = numbers_given(t)[1]  # other numbers; or what is wrong with them is told
        try:
            scene = self.scene.at(cast(Sequence[AnyNumber], t if several else [t]))
            return time_array(self._system.times(scene).inside, self.number), several
        except OutOfRange as fault:
            raise fault.refusal(self.scene.name, self.number) from None

    def _grid(self, t: object) -> TimeGrid | None:
        """The grid of several plain numbers, kept until others come; None of all else."""
        times = t
        if type(times) is not np.ndarray or times.dtype is not self._kind:
            times = _plain_numbers(t.tolist() if type(t) is np.ndarray else t, self._kind)
        if times is None or times.ndim != 1 or not times.size:
            return None
        value = times.tobytes()
        if value != self._last[0]:
            grid, long_steps, far = TimeGrid.of(times, self._unit), None, self._far
            if grid is not None:
                far = max(far, (grid.size / defaults.FAR_OUTPUTS) ** 2)
                if self._long_steps:
                    long_steps = self._long_steps[grid.size >= defaults.LONG_MANY]
            self._last = value, grid, long_steps, far
        return self._last[1]

    def _higher_at_start(self) -> Engine:
        """The engine of a higher order, where the other one stands."""
        self._higher.state[:] = self._state
        return self._higher

    @cached_property
    def _higher(self) -> Engine:
        """An engine of an order above heyoka's own."""
        part = defaults.PART * (self._system.tolerance or 0)
        engine = self._system.engine(order=self._order, tolerance=part)
        finalize(self, engine.release).atexit = False
        return engine

    def __copy__(self) -> Propagator:
        return Propagator(self._system, self._every)

    def __reduce__(self) -> tuple[object, ...]:
        return Propagator, (self._system, self._every)

    def __repr__(self) -> str:
        return f"<Propagator of {self.scene.name}: {self.number.name}>"

    def _bad(self, key: str, value: object, expected: str) -> BadInput:
        return BadInput(self.scene.name, key, value, expected)

    def _inside(self, rows: Flat) -> Flat:
        """Rows in principal axes and the run's own unit."""
        return (rows if self._turn is None else turned(rows, self._turn)) * self._scale

    def _read(self, rows: Flat) -> Flat:
        """Rows of any shape back in the scene's axes and units, in place where that is exact."""
        if self._turn is not None:
            several = rows.reshape(-1, rows.shape[-1])
            return flat(self._system.read.states(several)).reshape(rows.shape)
        if self._plain:
            return rows
        backs = self._backs
        if rows.ndim == 2 and len(rows) <= _BLOCK:  # most calls: the views below cost as much again
            return np.multiply(rows, backs[: len(rows)], rows)
        flat_rows = rows.reshape(-1, rows.shape[-1])
        for k in range(0, len(flat_rows), _BLOCK):
            part = flat_rows[k : k + _BLOCK]
            np.multiply(part, backs[: len(part)], part)  # by powers of two
        return flat_rows.reshape(rows.shape)

    def _array(self, start: npt.ArrayLike) -> Flat:
        """A start as an array of the propagator's type and shape; raises BadInput."""
        widths = "p q r gamma1 gamma2 gamma3" if self._shape == (6,) else "p q r"
        try:
            array = np.asarray(start)
        except ValueError:  # rows of different lengths
            array = np.empty(0)
        if array.shape != self._shape or np.any(getattr(start, "mask", False)):
            raise self._bad("start", plain(start), f"the {self._shape[0]} numbers {widths}")
        narrower = f"numbers of {self.number.name} or narrower"
        if not np.can_cast(array.dtype, self._kind, "safe"):
            raise self._bad("start", plain(start), narrower)
        state: Flat = array.astype(self._kind)
        if not_taken(start, state).any():
            raise self._bad("start", plain(start), narrower)
        return state

    def _at_times(self, start: Flat | None, numbers: Sequence[AnyNumber]) -> Flat:
        """States at several times, or with corrections: as a run has them."""
        if start is not None and not np.isfinite(start).all():
            raise self._bad("start", plain(start), "finite numbers")
        self._state[...] = self._first if start is None else self._inside(start)
        self._engine.begin()
        times = self._system.times(self.scene.at(numbers)).inside
        corrector = None
        if self._every is not None:
            corrector = Projector(StartTarget(self._system.target, self._state.copy()), self._every)
        motion = Motion(self._system)
        motion.begin(self._system, corrector=corrector, engine=self._engine)
        rows = self._state[None].copy()[: times[0] == 0]
        try:
            inside, self.outcome = motion.advance(times, self._most, rows)
        except OutOfRange as fault:
            raise fault.refusal(self.scene.name, self.number) from None
        self.steps = motion.steps
        states = np.full((len(times), *self._shape), np.nan, self._kind)
        states[: len(inside)] = self._read(flat(inside))
        if self.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        return states


def turned(rows: Flat, turn: Flat) -> Flat:
    """Rows in principal axes, each number rounded once."""
    wide = rows.astype(np.longdouble).reshape(-1, 3)
    principal_rows = (wide @ turn.T).reshape(rows.shape)
    return principal_rows.astype(np.float64) if rows.dtype == np.float64 else principal_rows


def _doubles(values: Iterable[Exact]) -> Doubles:
    """The nearest doubles."""
    return np.array([to_double(x) for x in values])


def _plain_numbers(values: object, kind: np.dtype[Any]) -> Flat | None:
    """A list of plain numbers that doubles hold as an array; None of all else."""
    if not isinstance(values, (list, tuple)) or not values:
        return None
    kinds = set(map(type, values))
    if not kinds <= _PLAIN:
        return None
    if not kinds <= _FLOATS and not -_WHOLE <= min(values) <= max(values) <= _WHOLE:
        return None
    return np.array(values, kind)


def _rows_given(start: npt.ArrayLike) -> bool:
    """Whether something that is no array may be rows of numbers: a list of lists, a table."""
    if isinstance(start, (list, tuple)):
        return len(start) > 0 and all(np.ndim(x) == 1 for x in start)
    return getattr(start, "ndim", 1) > 1


def propagator(
    scene: Scene | str | Path,
    *,
    number: str = "double",
    tol: AnyNumber | None = None,
    project: bool | int = False,
) -> Propagator:
    """Prepare a scene's equations for many motions of its body, from any starts.

    A call costs little more than heyoka's steps: it makes nothing of what a
    :class:`polhode.Trajectory` holds, and checks the start alone.  For outputs, events, more digits
    or an estimate of them use :func:`polhode.integrate`.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case: in the principal form, without events.  Its outputs
        are left out, as in a sweep.
    number : {"double", "extended"}
        The number type.
    tol : number, optional
        The tolerance of a step; the type's eps by default.  Above eps a row depends, within the
        tolerance, on which others are asked for: see ``polhode guide short-runs``.
    project : bool or int
        Project the state onto the first integrals of its own start every so many steps; True: as
        often as :func:`polhode.integrate` does.

    Returns
    -------
    Propagator
        Called with a start (omega, gamma in the scene's body axes) and a time, it returns the state
        as an array of shape (6,), or (n, 6) for n times; of N starts (N, 6), or (N, n, 6).

    Raises
    ------
    BadInput
        A scene with events or in another form, a wider number type.

    Examples
    --------
    >>> import polhode
    >>> go = polhode.propagator("general/asymmetric-regular")
    >>> start = [0.5, -0.25, 1, 0.6, 0, 0.8]
    >>> [round(float(x), 12) for x in go(start, t=1.0)[:3]]
    [0.272099643471, -0.615744716446, 1.104732461961]
    >>> go(start, t=[1, 2, 3]).shape, go.outcome.done
    ((3, 6), True)
    """
    scene = library.load(scene, takes=("outputs",))
    if scene.outputs:
        scene = replace(scene, outputs=())
    kind = choose_number(scene, number, None)
    if not kind.flat:
        raise BadInput(scene.name, "number", kind.name, "double or extended")
    if project is None:
        raise BadInput(scene.name, "project", None, "True, False or a number of steps")
    options = checked_options(scene, kind, Options(project=project), tol)
    try:
        return Propagator(system_of(scene, kind, options.tolerance), cadence(scene, kind, options))
    except OutOfRange as fault:
        raise fault.refusal(scene.name, kind) from None
