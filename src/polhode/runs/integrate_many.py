"""Many tops at once: initial conditions or body parameters of one scene varied."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import rows_of, steps, unit_rows, whole, with_progress
from polhode.common.checkpoint import JobArrays, JobCheckpoint
from polhode.common.errors import BadInput
from polhode.common.interrupts import Delay, Progress, StopRequest
from polhode.common.processes import run_jobs
from polhode.common.values import cached_property, refuse_too_much, waiting
from polhode.equations.readout import Readout
from polhode.motion.frame import Frame
from polhode.motion.outcomes import OUTCOMES, Outcome, code
from polhode.numbers.conversion import number_value, to_double
from polhode.numbers.decimals import strings
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import AnyNumber, Indices, NumberType, Stack, flat, kind_of
from polhode.runs.ensemble import Ensemble, no_states
from polhode.runs.members import Members, SweepNumbers, fastest, inside, numbers_of
from polhode.runs.options import Options, check_method, choose_number, rounded_tolerance
from polhode.runs.trajectory import solve
from polhode.scenes import library, vary
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS
from polhode.taylor import batches, defaults, lanes
from polhode.taylor.batches import LANES, BatchJob, BatchMotions, Solved
from polhode.taylor.system import refuse_other_rounding, rounded_times

# --- array starts ---------------------------------------------------------------------------------
#
# Starts of many members in one array: what is varied, in the keys of a scene file.


def varied_of(
    scene: Scene, starts: npt.ArrayLike | None, others: vary.Vary | None = None
) -> tuple[Scene, vary.Variation]:
    """The scene of a sweep and what is varied of it, by keys or by starts; raises BadInput.

    ``starts``: (N, 6), or (N, 3) of a scene without gamma; ``others``, beside them, are arrays of
    the body's numbers, and the scene's start is omega and gamma.
    """
    if starts is None:
        if others is None:
            raise BadInput(scene.name, "vary", None, "numbers to vary, or starts")
        return scene, vary.grid(others, scene.name, scene.units)
    rows = rows_of(scene.name, "starts", starts, len(scene.columns))
    if others is not None and not isinstance(others, Mapping):
        raise BadInput(scene.name, "vary", "a list", "arrays of the body's numbers, beside starts")
    for key in others or ():
        if key.startswith("start.") and key != "start.psi":
            raise BadInput(scene.name, "vary", key, "numbers of the body, beside starts")
    own = numbers_of(scene)[0]["start"]
    if "omega" not in own or ("gamma" in own) != (scene.gamma is not None):  # angles, a level
        scene = replace(scene, source="")
    return scene, vary.grid(others or {}, scene.name, scene.units, rows)


# --- plan -----------------------------------------------------------------------------------------
#
# A sweep, checked before anything is integrated: its members in numbers of one type.


_BYTES = 40  # of a number of the states, while they are gathered and written


@dataclass(frozen=True, eq=False)
class Plan:
    """A sweep, checked: what there is to integrate.

    ``times``: rounded to the number type; ``exact_times``: before that.
    """

    members: Members
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: tuple[Fraction, ...]
    exact_times: Sequence[Exact]
    numbers: SweepNumbers

    @cached_property
    def shared(self) -> BatchJob:
        """What the jobs of members have in common, of a type that numpy holds."""
        numbers, number = self.numbers, self.number
        grid = np.array([number_value(t, number) for t in self.times], kind_of(number))
        how = numbers.names, number, self.tolerance, self.max_steps, grid, Fraction(1)
        job = BatchJob(*how, BatchMotions(numbers.coefficients, numbers.starts[:0]))
        job = job._replace(exponents=numbers.exponents)
        return job._replace(sure=lanes.surely(job, float(numbers.rates.max(initial=0.0))))

    def job(self, members: Indices) -> BatchJob:
        """The job of some members, which have a unit of time in common or are sure to arrive."""
        numbers = self.numbers
        job = self.shared.of(numbers.motions(members), numbers.exponents[members])
        if not job.sure:
            with np.errstate(over="ignore"):  # of a rate that is only known to be so small
                rate = np.ldexp(numbers.rates[members].max(), numbers.exponents[members[0]])
            job = job._replace(sure=lanes.surely(job, float(rate)))
        return job

    def groups(self, size: int, most: int, mixed: bool = False) -> Iterator[Indices]:
        """The members in groups of about the same rate, and of one unit of time if not ``mixed``.

        Each is a multiple of ``size`` members but the last of a unit; about ``most`` groups.
        """
        units, rates = self.numbers.exponents, self.numbers.rates
        size *= max(1, -(-len(rates) // (size * most)))
        if mixed or (len(units) and (units == units[0]).all()):
            alike = [(-rates).argsort(kind="stable")]
        else:
            order = np.lexsort((-rates, units))
            alike = np.split(order, np.flatnonzero(np.diff(units[order])) + 1)
        for members in alike:
            for first in range(0, len(members), size):
                yield members[first : first + size]


def planned(
    scene: Scene,
    varied: vary.Variation,
    number: str | NumberType | None,
    digits: int | None,
    tol: AnyNumber | None,
    max_steps: int | None,
    kept: bool = True,
) -> Plan:
    """The plan of a sweep, see :func:`polhode.integrate_many`; raises BadInput.

    ``kept``: whether the states of all members are held at once.
    """
    refuse_other_rounding(scene)
    if scene.events:
        expected = "none in a sweep: a step size of its own for each event; run members singly"
        raise BadInput(scene.name, "events", scene.events[0].name, expected)
    members = Members(scene, varied)
    count = len(members)
    size = (count if kept else 1) * len(scene.times) * len(scene.columns)
    amount = f"{count} members at {len(scene.times)} times"
    words = "numbers of states; fewer samples, or split the sweep"
    refuse_too_much(scene.name, "vary", amount, size, _BYTES, words)
    _ = members.tables  # a key that is none is refused before anything else
    chosen = choose_number(scene, number, None)
    if digits is not None and count:
        member = fastest(members).at(scene.times)
        chosen = choose_number(member, number, digits)
        needed = choose_number(member, chosen.name, digits)  # nobody checks the digits of a sweep
        if chosen.bits < needed.bits:
            expected = f"fewer in {chosen.bits} bits; {needed.bits} hold them"
            raise BadInput(scene.name, "digits", digits, expected)
    if members.arrays:
        _check_arrays(members, chosen)
    times = tuple(rounded_times(scene, chosen))
    tolerance = None if tol is None else rounded_tolerance(scene, chosen, tol)
    numbers = SweepNumbers(members, chosen)
    if chosen.flat:
        numbers.check(times)
    limit = max_steps if max_steps is not None else defaults.of(chosen).max_steps
    return Plan(members, chosen, tolerance, limit, times, scene.times, numbers)


def _check_arrays(members: Members, number: NumberType) -> None:
    """Refuse arrays that are not of the run's number type; raises BadInput.

    Gamma is of length 1 to 8 eps of it.
    """
    name = members.scene.name
    if not number.flat:
        expected = "double or extended with arrays; other values, or members one by one, are exact"
        raise BadInput(name, "number", number.name, expected)
    for key, values in members.arrays.items():
        if number.name == "double" and values.dtype.itemsize > 8:
            raise BadInput(name, key, f"numbers of {values.dtype}", "float64, or number = extended")
    if members.gammas is not None:
        unit_rows(name, "start.gamma", members.gammas, number.eps)


# --- flat members ---------------------------------------------------------------------------------
#
# Members of a sweep in double or extended: steps of many at a time, read in the scene's axes.


@dataclass(frozen=True, eq=False)
class Reader:
    """Reads rows of some members in scene axes and units: plain data, to be sent anywhere.

    ``bodies``: members that have principal axes and a unit of time in common, with a scene of such
    axes; none where axes need no turn.  ``exponents``: of their units of time.
    """

    number: NumberType
    exponents: npt.NDArray[np.int64]
    bodies: tuple[tuple[npt.NDArray[np.int64], Scene], ...]

    def states(self, rows: Stack) -> Stack:
        """States, not a number where a member did not come; of flat types, where rows were.

        ``rows``: (members, times, columns) inside the members' frames.
        """
        states = flat(rows)
        for alike, scene in self.bodies:  # one readout reads all of them
            frame = Frame(scene.body.axes, int(self.exponents[alike[0]]))
            at = np.zeros(rows.shape[:2], dtype=bool)
            at[alike] = ~np.isnan(rows[alike, :, 0])
            if at.any():
                states[at] = flat(Readout(scene, self.number, frame).states(flat(rows[at])))
        if not self.bodies and self.exponents.any():
            states[:, :, :3] = np.ldexp(states[:, :, :3], -self.exponents[:, None, None])
        return states


def reader(plan: Plan, members: npt.NDArray[np.int64]) -> Reader:
    """What reads the rows of some members of a sweep."""
    exponents, base = plan.numbers.exponents[members], plan.members.scene
    stay, varied = plan.members.axes_stay, plan.members.varied
    if stay and base.body.axes.trivial:  # a reading knows the axes alone
        return Reader(plan.number, exponents, ())
    which = [exponents]
    if not stay:  # which value of each of the body's keys
        each = zip(varied.keys, varied.rows.columns, varied.rows.repeats, strict=True)
        which += [members // n % len(x) for key, x, n in each if key.startswith("body.")]
    _, first, alike = np.unique(
        np.stack(which, axis=1), axis=0, return_index=True, return_inverse=True
    )
    own = [base if stay else plan.members[int(members[k])] for k in first]
    bodies = tuple(
        (np.flatnonzero(alike.ravel() == n), replace(scene, form="principal"))
        for n, scene in enumerate(own)
    )
    return Reader(plan.number, exponents, bodies)


class FlatJob(NamedTuple):
    """Members, and what reads their rows."""

    steps: BatchJob
    read: Reader

    def solved(self, stop: StopRequest | None = None) -> Solved:
        """What became of the members, in the scene's axes and units; ``stop`` ends it sooner."""
        solved = batches.solve(self.steps, stop)
        return replace(solved, states=self.read.states(solved.states))


# --- wide members ---------------------------------------------------------------------------------
#
# Members of a sweep in quad or mp: each by itself, as a single run is solved.


class WideJob(NamedTuple):
    """Members with their times, to be integrated one after the other."""

    members: tuple[Scene, ...]
    number: NumberType
    options: Options

    def solved(self, stop: StopRequest | None = None) -> Solved:
        """What became of the members, in the scene's axes and units; ``stop`` ends it sooner."""

        def heard(*_: object) -> None:
            if stop is not None and stop():
                raise KeyboardInterrupt  # the run's own way to be stopped

        number, (first, *_) = self.number, self.members
        shape = len(self.members), len(first.times), len(first.columns)
        results = Solved.undone(no_states(number, shape))
        errors = results.errors = [None] * len(self.members)
        for k, member in enumerate(self.members):
            if stop is not None and stop():
                break
            options = self.options
            if options.method == "refined" and options.hindrance(member, number):
                options = options._replace(method="taylor")
            run = solve(member, number, options, heard)
            if run.outcome is Outcome.INTERRUPTED:
                break
            results.states[k, : len(run.states)] = run.states
            results.outcomes[k], results.steps[k] = code(run.outcome), run.steps
            results.reached[k], errors[k] = run.reached, run.errors
        return results


def wide_job(plan: Plan, group: npt.NDArray[np.int64], method: str) -> WideJob:
    """The job of some members; raises BadInput for one that the number type cannot hold."""

    def ready(index: int) -> Scene:
        inside(plan.members, index, plan.number)  # or says what is wrong
        return replace(plan.members[index], times=plan.exact_times, form="principal")

    options = Options(method, plan.max_steps, False, plan.tolerance)
    return WideJob(tuple(map(ready, group.tolist())), plan.number, options)


# --- results --------------------------------------------------------------------------------------
#
# What became of the members of a sweep: put together, and as arrays that a file keeps.


def put_together(
    plan: Plan, groups: Sequence[npt.NDArray[np.int64]], results: Sequence[Solved | None]
) -> tuple[Solved, dict[int, tuple[float | None, ...]]]:
    """The results of all members in their order, and the errors of those that have any."""
    shape = len(plan.members), len(plan.times), len(plan.members.scene.columns)
    whole = Solved.undone(no_states(plan.number, shape))
    errors: dict[int, tuple[float | None, ...]] = {}
    for group, some in zip(groups, results, strict=True):
        if some is not None:
            whole.put(group, some)
            for k, error in zip(group.tolist(), some.errors or (), strict=False):
                if error is not None:
                    errors[k] = error
    return whole, errors


def packed(results: Solved, number: NumberType) -> Mapping[str, npt.ArrayLike]:
    """A job's result as arrays that need no pickle; states above extended as decimals."""
    states: npt.NDArray[np.generic] = results.states
    if not number.flat:
        text = [
            strings([row], number)[0] if row[0] == row[0] else ["nan"] * len(row)
            for row in states.reshape(-1, states.shape[-1]).tolist()
        ]
        states = np.array(text).reshape(states.shape)
    return {
        "states": states,
        "outcomes": np.array([outcome.value for outcome in OUTCOMES])[results.outcomes],
        "steps": results.steps,
        "reached": np.array([str(t) for t in results.reached]),
        "errors": np.array(json.dumps(results.errors)),
    }


def unpacked(arrays: JobArrays, number: NumberType) -> Solved:
    """The same back."""
    errors = json.loads(str(arrays["errors"]))
    return Solved(
        flat(arrays["states"]) if number.flat else _numbers(arrays["states"], number),
        np.array([code(Outcome(text)) for text in arrays["outcomes"].tolist()], dtype=np.uint8),
        np.asarray(arrays["steps"], dtype=np.int64),
        np.array([Fraction(text) for text in arrays["reached"].tolist()], dtype=object),
        None if errors is None else [None if x is None else tuple(x) for x in errors],
    )


def _numbers(texts: npt.NDArray[np.generic], number: NumberType) -> Stack:
    stack = no_states(number, texts.shape)
    for index in np.argwhere(texts != "nan"):
        stack[tuple(index)] = number_value(Fraction(str(texts[tuple(index)])), number)
    return stack


# --- integrate many -------------------------------------------------------------------------------


_JOBS = 16, 1024  # so many at least and at most
_JOB = 0.05  # seconds that one should take
_SHORTEST = 0.002  # seconds that one takes at least, of threads here: it costs a part of one
_STEPS_PER_RADIAN = 2.0  # about, at the fastest rate, in double
_SHARE = 0.25  # of a scalar step that a lane's costs


@with_progress
def integrate_many(
    scene: Scene | str | Path,
    vary: vary.Vary | None = None,
    *,
    starts: npt.ArrayLike | None = None,
    number: str | NumberType | None = None,
    digits: int | None = None,
    at: Iterable[AnyNumber] | None = None,
    tol: AnyNumber | None = None,
    max_steps: int | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    parts: str | Path | None = None,
    method: str = "auto",
    progress: Progress | bool | None = None,
) -> Ensemble:
    """Integrate many variants of a scene with one compiled code.

    States are *not* projected onto the first integrals, as those of single runs are, and digits are
    *not* checked.  In double several members at a time are integrated in the machine's SIMD lanes.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    vary : mapping or list of mappings, optional
        Numbers of the scene file by key, such as ``{"start.omega[1]": ["0.1", 0.2], "body.weight":
        "0:1:11"}``: exact values, or FROM:TO:N, every combination being a member; or a list of
        mappings with one value for each key, the members one by one; or arrays with a row for each
        member, ``{"start.omega": (N, 3), "start.gamma": (N, 3), "body.moments": (N, 3)}``, an (N,
        1) array for a key that is one number.
    starts : array_like, shape (N, 6) or (N, 3), optional
        p q r gamma1 gamma2 gamma3 at t = 0 of each member, omega alone of a scene without gamma, in
        the scene's body axes and units: the same as arrays of ``start.omega`` and ``start.gamma``.
        Numbers of the run's type or a narrower one; |gamma|² is 1 to 8 eps of the type.
    number : str or NumberType, optional
        The number type, as in :func:`polhode.integrate`.
    digits : int, optional
        Chooses the number type by how far the fastest member turns, and is not checked: members
        whose motion multiplies errors may have fewer correct digits.
    at : iterable of numbers, optional
        Output times in the scene's unit; the scene's own by default.
    tol : number, optional
        The tolerance of a step; the type's eps by default.
    max_steps : int, optional
        A limit on the steps of each member.
    executor : Executor, optional
        An executor of ``concurrent.futures``, such as a process pool, dask's
        ``Client.get_executor()`` or mpi4py's, instead of threads.  Jobs are plain data both ways;
        those lost with a worker are run again here.
    workers : int, optional
        Threads; by default as many as there are cores.
    parts : str or Path, optional
        A folder to which finished jobs are written about once a second, so that the same call
        continues from there after a kill, with the same results to the bit.  It is made if the
        sweep takes longer than that, and kept until ``ensemble.kept.remove()``.
    method : {"auto", "taylor", "refined"}
        "auto" refines, in quad and mp, each member for which that is possible and faster; "refined"
        each for which it is possible.
    progress : callable or bool, optional
        Called with the fraction of members done and how many; True for a bar.

    Returns
    -------
    Ensemble
        The members in the order of ``vary``: states in the scene's body axes and units, and outputs
        of the scene that are made of states alone.  Ctrl-C keeps the members whose jobs, of a
        fraction of a second, are finished; the others have the outcome NOT_RUN.

    Raises
    ------
    BadInput
        Before anything is integrated: an impossible member, a scene with events, too many numbers
        for the memory, or ``parts`` with anything but jobs of the same call.  JobArrays with a row
        that is not finite, of another width or a wider type, or whose gamma is no unit vector, in
        quad or mp, or beside values that are no arrays.

    Notes
    -----
    Members in quad and mp are runs of their scenes, to the bit what :func:`polhode.integrate` gives
    with the same method and ``project=False``; those in extended, too, unless they stand still or
    turn by more than some thousand radians.

    Members begin at the floats of an array.  ``ensemble[k]`` and ``ensemble.members`` make exact
    scenes of them when asked for: there gamma, which is a unit vector to rounding alone, is divided
    by its length.  The equations are (3.29) of Yehia, *Rigid Body Dynamics: A Lagrangian Approach*.

    Examples
    --------
    >>> import polhode
    >>> many = polhode.integrate_many(
    ...     "lagrange/nutation", {"start.omega[3]": [2, 3], "body.weight": "1:2:3"}, at=[0, 1]
    ... )
    >>> len(many), many.varied.keys, many.complete
    (6, ('start.omega[3]', 'body.weight'), True)
    >>> starts = [[0.5, 0, k, 0, 0, 1] for k in range(100)]  # any array (N, 6)
    >>> polhode.integrate_many("lagrange/nutation", starts=starts, at=[1, 2]).states.shape
    (100, 2, 6)
    """
    assert not isinstance(progress, bool)  # it is a bar's
    called_at = time.perf_counter()
    scene = library.load(scene, takes=REQUESTS)
    if at is not None:
        scene = scene.at(at)
    if max_steps is not None:
        max_steps = steps(scene.name, max_steps)
    if workers is not None:
        workers = whole(scene.name, "workers", workers, 1)
    check_method(scene, method)
    scene, varied = varied_of(scene, starts, vary)
    plan = planned(scene, varied, number, digits, tol, max_steps)
    if method == "refined" and plan.number.flat:
        raise BadInput(scene.name, "method", method, "quad or more digits, or the method taylor")
    prepared = time.perf_counter()
    here = executor is None and parts is None
    size, most = LANES if plan.number.name == "double" else 1, _most_jobs(plan, here)
    single = most == 1 and plan.number.flat and plan.shared.sure
    groups = list(plan.groups(size, most, single))
    if here and most == 1:  # not worth a second thread
        workers = workers or 1
    checkpoint = None
    if parts is not None:  # writing a scene as text takes longer than a small sweep
        key = scene.text, plan.times, method, varied, plan.number, plan.tolerance
        checkpoint = JobCheckpoint(parts, "sweep", *key, plan.max_steps, *groups)
    jobs: list[Any] = [
        FlatJob(plan.job(group), reader(plan, group))
        if plan.number.flat
        else wide_job(plan, group, method)
        for group in groups
    ]
    finished = run_jobs(
        FlatJob.solved if plan.number.flat else WideJob.solved,
        jobs,
        [len(group) for group in groups],
        workers,
        executor,
        checkpoint,
        partial(packed, number=plan.number),
        partial(unpacked, number=plan.number),
        progress,
    )
    with Delay() as delay:  # what is finished is not lost
        results, errors = put_together(plan, groups, finished.results)
        delay.forget()
    plan.members.speak()
    seconds = {
        "scenes": prepared - called_at,
        "run": time.perf_counter() - prepared,
    }
    tolerance = plan.tolerance or plan.number.eps
    return Ensemble(
        scene=scene,
        varied=varied,
        members=plan.members,
        number=plan.number,
        times=plan.times,
        states=results.states,
        endings=results.outcomes,
        counts=results.steps,
        arrived=results.reached,
        tolerance=float(tolerance),
        digits=digits,
        estimates=errors,
        provenance=waiting(partial(_provenance, plan.members, seconds)),
        kept=checkpoint,
    )


def _provenance(members: Members, seconds: Mapping[str, float]) -> Mapping[str, object]:
    """A sweep's provenance, made when it is wanted: it takes as long as a small sweep."""
    return {**members.provenance(), "seconds": seconds}


def _most_jobs(plan: Plan, here: bool) -> int:
    """In about how many jobs a sweep is cut; ``here``: for threads of this process, none kept."""
    least, most = _JOBS
    if not plan.number.flat:
        return most
    radians = float(plan.numbers.rates.sum()) * abs(to_double(plan.times[-1]))
    share = _SHARE if plan.number.name == "double" else 1.0
    seconds = share * defaults.seconds(plan.number, _STEPS_PER_RADIAN * radians)
    if here:
        least = max(1, math.ceil(min(least, seconds / _SHORTEST)))
    return int(min(most, max(least, seconds / _JOB)))
