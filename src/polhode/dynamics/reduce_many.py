"""Sweeps of which some numbers a member are kept, and no state of all members at once.

They are asked for in words:

final            the last state
largest X        of an expression in the columns of a state, in t and theta over the output times,
smallest X       and the first of those times at which it is reached
first NAME       the first time after 0 of the scene's event NAME, and the state there
lyapunov         the largest Lyapunov exponent to the last time, as polhode.lyapunov tells it
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import each, of_kind, steps, whole, with_progress
from polhode.common.checkpoint import JobArrays, JobCheckpoint
from polhode.common.errors import BadInput, counted, nearest
from polhode.common.interrupts import Progress, StopRequest
from polhode.common.processes import run_jobs
from polhode.dynamics import lyapunov
from polhode.equations.section_functions import UNSURE, in_columns
from polhode.motion.outcomes import OUTCOMES, Outcome, code
from polhode.numbers import expression
from polhode.numbers.conversion import number_value, to_double
from polhode.numbers.expression import Algebra, ExpressionError, odd_part
from polhode.numbers.number_types import DOUBLE, AnyNumber, Doubles, NumberType, Stack, kind_of
from polhode.results.cells import TEXT
from polhode.results.table import Column, Fact, Table
from polhode.runs.ensemble import SweepResult
from polhode.runs.integrate_many import FlatJob, Plan, Reader, planned, reader, varied_of
from polhode.runs.members import Members
from polhode.runs.options import Options
from polhode.runs.trajectory import solve as solve_one
from polhode.scenes import library, vary
from polhode.scenes.scene import Event, Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, unit_of, varied_columns
from polhode.scenes.vocabulary import DIRECTIONS, READY_MADE, REQUESTS, STATE
from polhode.taylor import event_batches, variations
from polhode.taylor.batches import BatchMotions
from polhode.taylor.event_batches import SearchJob, Watched
from polhode.taylor.event_functions import TIME, identically_zero, size_of, typed_constant
from polhode.taylor.heyoka import EXPRESSIONS, hy
from polhode.taylor.variations import TangentJob

# --- words ----------------------------------------------------------------------------------------


FINAL, LARGEST, SMALLEST, FIRST, LYAPUNOV = "final", "largest", "smallest", "first", "lyapunov"
_EXPECTED = "final, largest X, smallest X, first EVENT or lyapunov"


class Reduction(NamedTuple):
    """What is asked for, and of what: an expression, or an event's name."""

    kind: str
    of: str = ""

    @property
    def text(self) -> str:
        """As it was asked for."""
        return f"{self.kind} {self.of}".strip()

    def names(self, columns: Sequence[str]) -> tuple[str, ...]:
        """Names of its numbers, of states with these columns."""
        if self.kind == FINAL:
            return tuple(f"final {name}" for name in columns)
        if self.kind == FIRST:
            return (f"t of {self.text}", *(f"{name} at {self.text}" for name in columns))
        if self.kind == LYAPUNOV:
            return LYAPUNOV, "lyapunov uncertainty", "lyapunov growth"
        return self.text, f"t of {self.text}"


def reductions_of(scene: Scene, keep: Any) -> tuple[Reduction, ...]:
    """Reductions from their words, each once; raises BadInput."""
    if isinstance(keep, str):
        keep = (keep,)

    texts = each(scene.name, "keep", keep, lambda text: text, _EXPECTED)
    for text in texts:
        of_kind(scene.name, "keep", text, str, _EXPECTED)
    reductions = tuple(dict.fromkeys(_read(scene, text) for text in texts))
    if not reductions:
        raise BadInput(scene.name, "keep", None, _EXPECTED)
    return reductions


def event_of(scene: Scene, name: str) -> Event:
    """An event by its name: the scene's, or one known by name; raises BadInput."""
    events = {word: Event(word) for word in READY_MADE}
    events |= {event.name: event for event in scene.events}
    if name not in events:
        raise BadInput(scene.name, f"keep: {FIRST}", name, f"an event: {nearest(name, [*events])}")
    event = events[name]
    if scene.gamma is None and event.expression is not None and not event.zero:
        raise BadInput(scene.name, f"keep: {FIRST}", name, "an event of omega: there is no gamma")
    if event.expression is None or not size_of(scene, event).entire:
        expected = "an event with an expression, without roots and division by a variable"
        raise BadInput(scene.name, f"keep: {FIRST}", name, expected)
    if identically_zero(event.expression, (*scene.columns, "t")):
        expected = f"an event that is not zero everywhere, as {event.expression} is"
        raise BadInput(scene.name, f"keep: {FIRST}", name, expected)
    return event


def extremes(
    which: Sequence[Reduction],
    states: Stack,
    times: Stack,
    columns: Sequence[str],
    kind: NumberType,
) -> dict[str, Any]:
    """What states (members, times, columns) tell: arrays by name, one number per member."""
    numbers: dict[str, Any] = {}
    for reduction in which:
        names = reduction.names(columns)
        if reduction.kind == FINAL:
            numbers |= zip(names, states[:, -1].T, strict=True)
        else:
            values = _values(reduction.of, states, times, columns, kind)
            at = (np.argmax if reduction.kind == LARGEST else np.argmin)(values, axis=1)
            best = np.take_along_axis(values, at[:, None], axis=1)[:, 0]
            numbers |= zip(names, (best, times[at]), strict=True)
    return numbers


def _values(
    text: str, states: Stack, times: Stack, columns: Sequence[str], kind: NumberType
) -> Any:
    """An expression at all times of all members, nan or infinite where it has no value."""
    names: dict[str, Any] = {name: states[:, :, i] for i, name in enumerate(columns)}
    if "gamma3" in names:
        across = np.hypot(names["gamma1"], names["gamma2"])
        names["theta"] = np.arctan2(across, names["gamma3"])
    names["t"] = np.broadcast_to(times, states.shape[:2])
    functions = {"sqrt": np.sqrt, "sin": np.sin, "cos": np.cos}
    algebra = Algebra(lambda x: number_value(x, kind), functions)
    with np.errstate(all="ignore"):
        value = expression.evaluate(text, names, algebra)
    return np.broadcast_to(value, states.shape[:2])


def _read(scene: Scene, text: str) -> Reduction:
    kind, _, of = text.strip().partition(" ")
    of = " ".join(of.split())
    if kind in (FINAL, LYAPUNOV) and not of:
        return Reduction(kind)
    if kind == FIRST and of:
        event_of(scene, of)
        return Reduction(kind, of)
    if kind in (LARGEST, SMALLEST) and of:
        sample = {name: np.full((1, 1), 0.5 + 0.1 * STATE.index(name)) for name in scene.columns}
        states = np.stack(list(sample.values()), axis=2)
        try:
            _values(of, states, np.ones(1), scene.columns, DOUBLE)
        except ExpressionError as fault:
            raise BadInput(scene.name, f"keep: {kind}", of, f"an expression ({fault})") from None
        return Reduction(kind, of)
    raise BadInput(scene.name, "keep", text, _EXPECTED)


# --- jobs -----------------------------------------------------------------------------------------
#
# The jobs of a sweep that keeps some numbers of each member: plain data, and how it is done.


STRETCH = 32.0  # of the motions' unit of time, a radian or two, between two looks at an event
_LOOKS = lyapunov.BLOCKS * lyapunov.LOOKS


def check(scene: Scene, plan: Plan, which: tuple[Reduction, ...]) -> None:
    """Refuse what cannot be told in the plan's number type; raises BadInput."""
    name = plan.number.name
    if not plan.number.flat:
        raise BadInput(scene.name, "number", name, "double or extended, where numbers are kept")
    for reduction in which:
        if reduction.kind in (FIRST, LYAPUNOV):
            if name != "double":
                raise BadInput(scene.name, "number", name, f"double, for {reduction.text}")
            if plan.tolerance is not None:
                raise BadInput(scene.name, "tol", None, f"none, for {reduction.text}")
            if plan.times[-1] == 0:
                raise BadInput(scene.name, "at", 0, f"a time other than 0, for {reduction.text}")
        if reduction.kind == FIRST:
            zero = event_of(scene, reduction.of).expression or ""
            names, constant = scene.columns, typed_constant(plan.number)
            try:  # its numbers, before anything is integrated
                in_columns(zero, names, hy.make_vars(*names), TIME, constant, EXPRESSIONS)
            except ExpressionError as fault:
                expected = f"a type of wider range ({fault}), for {reduction.text}"
                raise BadInput(scene.name, "number", name, expected) from None


def job_of(
    scene: Scene, plan: Plan, which: tuple[Reduction, ...], group: npt.NDArray[np.int64]
) -> Job:
    """The job of some members that have a unit of time in common."""
    read, n = reader(plan, group), int(plan.numbers.exponents[group[0]])
    motions, kinds = plan.numbers.motions(group), {reduction.kind for reduction in which}
    states = FlatJob(plan.job(group), read) if kinds - {FIRST, LYAPUNOV} else None
    end = float(plan.times[-1] / Fraction(2) ** n)
    firsts = tuple(
        (reduction, *_of_event(scene, plan, event_of(scene, reduction.of), group, end), read)
        for reduction in which
        if reduction.kind == FIRST
    )
    follow = any(reduction.kind == LYAPUNOV for reduction in which)
    exponents = Exponents(_tangents(plan, motions, end), plan.members, group) if follow else None
    return Job(which, scene.columns, states, firsts, exponents, n)


def _of_event(
    scene: Scene, plan: Plan, event: Event, group: npt.NDArray[np.int64], end: float
) -> tuple[SearchJob, Singles]:
    """The job of an event, and what it needs where lanes are not sure."""
    assert event.expression is not None
    odd = odd_part(event.expression)  # it crosses zero where the expression does
    size, motions = size_of(scene, event._replace(zero=odd)), plan.numbers.motions(group)
    largest = math.frexp(max(float(size.value), float(size.rate)) or 1.0)[1]
    turns = _turns(plan, group)
    watched = Watched(plan.numbers.names, scene.columns, odd, 2.0**largest, turns is not None)
    job = SearchJob(
        *(watched, DIRECTIONS[event.direction], 1, end, STRETCH),
        *(_doubles(motions.rows), _doubles(motions.starts)),
        *(int(plan.numbers.exponents[group[0]]), turns),
        max_steps=plan.max_steps,
    )
    stopping = event._replace(stop=True)
    return job, Singles(
        plan.members, stopping, (Fraction(0), plan.times[-1]), group, plan.max_steps
    )


def _turns(plan: Plan, group: npt.NDArray[np.int64]) -> Doubles | None:
    """From principal axes to the scene's, one row per member; None where there is no turn."""

    def row(scene: Scene) -> list[float]:
        return [to_double(x) for axis in scene.body.axes.rows for x in axis]

    if plan.members.axes_stay:
        base = plan.members.scene
        return None if base.body.axes.trivial else np.tile(row(base), (len(group), 1))
    return np.array([row(plan.members[int(k)]) for k in group])


def _tangents(plan: Plan, motions: BatchMotions, end: float) -> TangentJob:

    six = np.zeros((motions.many, 6))
    columns = motions.starts.shape[1]
    six[:, :columns] = motions.starts
    tangents = np.zeros_like(six)
    tangents[:, :columns] = lyapunov.TANGENT[:columns]
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    return TangentJob(
        plan.numbers.names, _doubles(motions.rows), six, tangents, end, _LOOKS, None, (), 0.0
    )


def _doubles(rows: Stack) -> Doubles:
    return np.asarray(rows, dtype=np.float64)


class Reduced(NamedTuple):
    """What a job's members were reduced to: arrays with one entry per member."""

    endings: npt.NDArray[np.uint8]
    counts: npt.NDArray[np.int64]
    numbers: JobArrays

    @classmethod
    def of(cls, arrays: JobArrays) -> Reduced:
        """From its arrays by name, those of the numbers by their own."""
        endings = np.asarray(arrays.pop("endings"), dtype=np.uint8)
        return cls(endings, np.asarray(arrays.pop("counts"), dtype=np.int64), arrays)


class Job(NamedTuple):
    """Members and all that is asked of them: plain data.

    ``states``: for what states tell, if anything; ``firsts``: a job an event, and the members'
    scenes by which those are done that lanes are not sure of.  ``time_exponent``: of two, that of
    their unit of time.
    """

    which: tuple[Reduction, ...]
    columns: tuple[str, ...]
    states: FlatJob | None
    firsts: tuple[tuple[Reduction, SearchJob, Singles, Reader], ...]
    exponents: Exponents | None
    time_exponent: int


class Exponents(NamedTuple):
    """Tangents to be followed, and the members that they belong to."""

    job: TangentJob
    members: Members
    group: npt.NDArray[np.int64]


class Singles(NamedTuple):
    """Members one by one: their scenes with one event that ends the run."""

    members: Members
    event: Event
    times: tuple[Fraction, ...]
    group: npt.NDArray[np.int64]
    max_steps: int

    def scene(self, k: int) -> Scene:
        """The scene of the group's member k."""
        member = self.members[int(self.group[k])]
        return replace(member, times=self.times, events=(self.event,), outputs=())


def solve(job: Job, stop: StopRequest | None = None) -> Reduced:
    """A job's members reduced; with ``stop`` the result may be unfinished, and is to be left."""
    parts = list(_parts(job, stop))
    endings, counts = parts[0].endings.copy(), parts[0].counts.copy()
    reached = code(Outcome.REACHED_END)
    numbers: JobArrays = {}
    for part in parts[1:]:
        endings = np.where(endings == reached, part.endings, endings)
        counts = counts + part.counts
    for part in parts:
        numbers |= {n: np.where(endings == reached, x, np.nan) for n, x in part.numbers.items()}
    return Reduced(endings, counts, numbers)


def _parts(job: Job, stop: StopRequest | None) -> Iterator[Reduced]:
    """What is told by states, by events and by tangents."""
    if job.states is not None:
        steps = job.states.steps
        times = np.ldexp(steps.times, job.time_exponent)
        solved = job.states.solved(stop)
        of_states = [
            reduction for reduction in job.which if reduction.kind not in (FIRST, LYAPUNOV)
        ]
        numbers = extremes(of_states, solved.states, times, job.columns, steps.number)
        yield Reduced(solved.outcomes, solved.steps, numbers)
    for reduction, first, singles, read in job.firsts:
        yield _first(reduction, first, singles, read, stop)
    if job.exponents is not None:
        yield _exponents(job.exponents, job.time_exponent, stop)


def _first(
    reduction: Reduction,
    job: SearchJob,
    singles: Singles,
    read: Reader,
    stop: StopRequest | None,
) -> Reduced:

    crossings = event_batches.solve(job, stop)
    times = np.ldexp(crossings.times[:, 0], job.exponent)
    states = read.states(crossings.states)[:, 0]
    ended, steps = np.array(crossings.outcomes), crossings.steps.copy()
    not_run, reached = code(Outcome.NOT_RUN), code(Outcome.REACHED_END)
    outcomes = np.where(ended == event_batches.STOPPED, not_run, reached).astype(np.uint8)

    def heard(*_: object) -> None:
        if stop is not None and stop():
            raise KeyboardInterrupt  # the run's own way to be stopped

    options = Options(max_steps=singles.max_steps, project=False)
    for k in np.flatnonzero(ended == UNSURE).tolist():
        if stop is not None and stop():
            break
        run = solve_one(singles.scene(k), DOUBLE, options, heard)
        steps[k] = run.steps
        met = run.events[0]
        stopped = run.outcome is Outcome.STOPPED_AT_EVENT  # by the last: a contact stops nothing
        times[k] = float(met.times[-1]) if stopped else np.nan
        states[k] = met.states[-1] if stopped else np.nan
        outcomes[k] = code(Outcome.REACHED_END if run.outcome.done else run.outcome)
    names = reduction.names(job.watched.columns)
    return Reduced(outcomes, steps, dict(zip(names, (times, *states.T), strict=True)))


def _exponents(of: Exponents, time_exponent: int, stop: StopRequest | None) -> Reduced:
    """As :func:`polhode.lyapunov` tells them.

    Those of chaotic members with their neighbours'; of known motions that doubles cannot follow by
    that function itself.
    """
    job = of.job
    tangents = variations.solve(job, stop)
    fits = np.full((3, len(job.starts)), np.nan)
    whole = tangents.last == job.looks
    for k in np.flatnonzero(whole).tolist():
        fits[:, k] = lyapunov.fitted(tangents.sizes[k].tolist(), abs(job.end))
    chaotic = [
        k
        for k in np.flatnonzero(whole).tolist()
        if lyapunov.is_chaotic(of.members[int(of.group[k])], fits[2, k], fits[0, k], fits[1, k])
    ]
    if chaotic:
        fits[1, chaotic] = _scatter(job, np.array(chaotic), fits[0, chaotic], stop)
    fits[:2] = np.ldexp(fits[:2], -time_exponent)
    grown = tangents.sizes.max(axis=1) - tangents.sizes[:, 0] > lyapunov.DOUBLES_TRUE
    end = Fraction(job.end) * Fraction(2) ** time_exponent
    for k in np.flatnonzero(whole & grown).tolist():
        if stop is not None and stop():
            break
        member = of.members[int(of.group[k])]
        if k not in chaotic and lyapunov.is_known(member):
            known = lyapunov.lyapunov(member, end)
            fits[:, k] = known.exponent, known.uncertainty, known.growth
    outcomes = np.where(whole, code(Outcome.REACHED_END), code(Outcome.NON_FINITE))
    names = Reduction(LYAPUNOV).names(())
    return Reduced(outcomes, np.zeros(len(whole), np.int64), dict(zip(names, fits, strict=True)))


def _scatter(
    job: TangentJob, which: npt.NDArray[np.int64], exponents: Doubles, stop: StopRequest | None
) -> Doubles:
    """The uncertainty of the exponents of some of a job's motions, from their neighbours."""

    starts = np.concatenate([job.starts[which] * by for by in lyapunov.MOVED])
    again = np.tile(which, len(lyapunov.MOVED))
    moved = job._replace(
        coefficients=job.coefficients[again], starts=starts, tangents=job.tangents[again]
    )
    tangents = variations.solve(moved, stop)
    ends = [
        lyapunov.fitted(sizes[: last + 1].tolist(), abs(job.end))[0]
        for sizes, last in zip(tangents.sizes, tangents.last.tolist(), strict=True)
    ]
    rows = np.array(ends).reshape(len(lyapunov.MOVED), len(which)).T
    together = np.column_stack([exponents, rows])
    return np.array([lyapunov.scatter(row.tolist()) for row in together])


# --- reduce many ----------------------------------------------------------------------------------


MOST_AT_ONCE = 1 << 22  # numbers of states that one job may hold: 32 MB of doubles
_JOBS = 256  # at most, but for that
LANES = 8  # a job has a multiple of so many members


@dataclass(frozen=True, eq=False, repr=False)
class Reductions(SweepResult):
    """Some numbers of each member of a sweep, without its states.

    >>> import polhode
    >>> found = polhode.reduce_many(
    ...     "lagrange/nutation", {"start.omega[3]": "2:4:3"}, keep=["largest theta", "final"]
    ... )
    >>> found
    <Reductions of lagrange/nutation: 3 members in double, 8 numbers each, all reached the end>
    >>> found["largest theta"].shape, found.names[:3]
    ((3,), ('largest theta', 't of largest theta', 'final p'))

    ``numbers``: arrays (members,) by name, float64 or longdouble, in the scene's body axes and
    units; nan for members that did not reach the end, and for a first event that does not happen.
    ``kept``: the folder of finished jobs, to be removed.  ``endings``: indices into
    ``polhode.motion.outcomes.OUTCOMES``; ``counts``: steps.
    """

    scene: Scene
    varied: vary.Variation
    members: Members
    number: NumberType
    keep: tuple[str, ...]
    numbers: Mapping[str, Stack]
    endings: npt.NDArray[np.uint8]
    counts: npt.NDArray[np.int64]
    provenance: Mapping[str, object] = field(default_factory=dict, compare=False)
    kept: JobCheckpoint | None = field(default=None, compare=False)

    def __len__(self) -> int:
        return len(self.members)

    def __getitem__(self, name: str) -> Stack:
        return self.numbers[name]

    def __repr__(self) -> str:
        members = counted(len(self), "member")
        return (
            f"<Reductions of {self.scene.name}: {members} in {self.number.name}, "
            f"{counted(len(self.numbers), 'number')} each, {self._reached()}>"
        )

    @property
    def names(self) -> tuple[str, ...]:
        """What the numbers are called."""
        return tuple(self.numbers)

    def table(self) -> Table:
        """One row per member: what is varied, how it ended, and its numbers."""
        member, digits = np.arange(len(self)), self.number.printed_digits
        return Table(
            [
                Column("member", member + 1),
                *varied_columns(self.varied, member),
                Column("outcome", [OUTCOMES[k].value for k in self.endings.tolist()], type=TEXT),
                Column("steps", self.counts),
                *(Column(name, x, digits=digits) for name, x in self.numbers.items()),
            ]
        )

    def facts(self) -> list[Fact]:
        """What was varied and kept, and how the members were integrated."""
        return [
            *scene_facts(self.scene),
            Fact("vary", list(self.varied.keys), "what is varied"),
            Fact("keep", list(self.keep), "what was kept of each member"),
            Fact("number", self.number.name, "the type of the numbers"),
            Fact("bits", self.number.bits, "of its significand"),
            Fact("end", self.scene.end, "the last time", unit_of(self.scene, "t")),
            Fact("projected", False, "whether put back on the first integrals"),
            Fact("complete", self.complete, "whether every member reached the end"),
            provenance_fact(self.provenance),
        ]


@with_progress
def reduce_many(
    scene: Scene | str | Path,
    vary: vary.Vary | None = None,
    keep: Sequence[str] | str = (),
    *,
    starts: npt.ArrayLike | None = None,
    number: str | NumberType | None = None,
    at: Iterable[AnyNumber] | None = None,
    tol: AnyNumber | None = None,
    max_steps: int | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    parts: str | Path | None = None,
    progress: Progress | bool | None = None,
) -> Reductions:
    """Integrate many variants of a scene and keep some numbers of each.

    States are not projected onto the first integrals.  Memory does not grow with the number of
    output times.  Ctrl-C keeps the finished members.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    vary : mapping or list of mappings
        Numbers of the scene file by key, as in :func:`polhode.integrate_many`; beside ``starts``
        arrays of the body's numbers alone.
    keep : str or sequence of str
        "final" (the last state); "largest X" and "smallest X", X an expression in p q r gamma1
        gamma2 gamma3 t theta: its extreme over the output times, and the first of them at which it
        is reached; "first NAME": time and state of the first zero after 0 of an event of the scene,
        or of nutation or equator, also between output times; "lyapunov": the largest exponent to
        the last time, its uncertainty and growth, as in :func:`polhode.lyapunov`.
    starts : array_like, shape (N, 6) or (N, 3), optional
        A start in each row, as in :func:`polhode.integrate_many`.
    number : str or NumberType, optional
        double or extended; events and exponents in double only.
    at : iterable of numbers, optional
        Output times in the scene's unit; the scene's own unless given.
    tol : number, optional
        The tolerance of a step; the type's eps by default.
    max_steps : int, optional
        A limit on the steps of each member.
    executor : Executor, optional
        An executor of ``concurrent.futures`` instead of threads.
    workers : int, optional
        Threads; as many as there are cores unless given.
    parts : str or Path, optional
        A folder for finished jobs, from which the same call continues after a kill.
    progress : callable or bool, optional
        Called with the fraction of members done and how many; True for a bar.

    Returns
    -------
    Reductions
        A table: one row per member, columns by ``keep``.  Numbers that are made of the states at
        output times are the same to the bit as from :func:`polhode.integrate_many`.

    Raises
    ------
    BadInput
        A member that cannot be integrated, an unknown name in ``keep``.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.reduce_many("lagrange/nutation", {"body.weight": [1, 2]}, "smallest gamma3")
    >>> found["smallest gamma3"].round(3).tolist()
    [0.213, -0.212]
    >>> starts = [[0, 0, k, 0.6, 0, 0.8] for k in (2.0, 3.0, 4.0)]  # any array (N, 6)
    >>> polhode.reduce_many("lagrange/nutation", starts=starts, keep="final")["final r"]
    array([2., 3., 4.])
    """
    assert not isinstance(progress, bool)  # it is a bar's
    scene = library.load(scene, takes=REQUESTS)
    if at is not None:
        scene = scene.at(at)
    which = reductions_of(scene, keep)
    scene, varied = varied_of(scene, starts, vary)
    plan = planned(
        replace(scene, events=()),
        varied,
        number,
        None,
        tol,
        None if max_steps is None else steps(scene.name, max_steps),
        kept=False,
    )
    if workers is not None:
        workers = whole(scene.name, "workers", workers, 1)
    check(scene, plan, which)
    size = len(plan.members) * len(plan.times) * len(scene.columns)
    groups = list(plan.groups(LANES, max(_JOBS, -(-size // MOST_AT_ONCE))))
    jobs = [job_of(scene, plan, which, group) for group in groups]
    key = scene.text, scene.events, scene.times, which, varied, plan.number, tol, plan.max_steps
    checkpoint = JobCheckpoint.at(parts, "sweep", *key)
    finished = run_jobs(
        solve,
        jobs,
        [len(group) for group in groups],
        workers,
        executor,
        checkpoint,
        lambda reduced: {"endings": reduced.endings, "counts": reduced.counts, **reduced.numbers},
        Reduced.of,
        progress,
    )
    endings = np.full(len(plan.members), code(Outcome.NOT_RUN), dtype=np.uint8)
    counts = np.zeros(len(plan.members), dtype=np.int64)
    names = [name for reduction in which for name in reduction.names(scene.columns)]
    kind = np.dtype(kind_of(plan.number))
    numbers = {name: np.full(len(plan.members), np.nan, kind) for name in names}
    for group, reduced in zip(groups, finished.results, strict=True):
        if reduced is None:
            continue
        endings[group], counts[group] = reduced.endings, reduced.counts
        for name in names:
            numbers[name][group] = reduced.numbers[name]
    plan.members.speak()
    return Reductions(
        scene,
        varied,
        plan.members,
        plan.number,
        tuple(reduction.text for reduction in which),
        numbers,
        endings,
        counts,
        plan.members.provenance(),
        checkpoint,
    )
