"""Scene, number type and options to trajectory: methods in turn, until one serves."""

from __future__ import annotations

import logging
import time
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from polhode.common.arguments import numbers_given
from polhode.common.errors import BadInput, plain
from polhode.common.interrupts import Progress
from polhode.motion.outcomes import CannotSolve, Events, Interpolant, Outcome, RowReader
from polhode.numbers.conversion import TIME, reader
from polhode.numbers.decimals import shown
from polhode.numbers.exact import sign
from polhode.numbers.number_types import (
    AnyNumber,
    Given,
    GivenRow,
    NumberType,
    Reread,
    Row,
    read_only,
)
from polhode.runs.options import USUAL, Options, cadence, hindrance_to_refinement, refinement_pays
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE
from polhode.taylor import defaults
from polhode.taylor.heyoka import OutOfRange
from polhode.taylor.motion import Motion
from polhode.taylor.system import System, system_of

if TYPE_CHECKING:
    from polhode.runs.refined_motion import RefinedMotion


_LOG = logging.getLogger("polhode")


def solve(
    scene: Scene,
    number: NumberType,
    options: Options = USUAL,
    progress: Progress | None = None,
    *,
    interruptible: bool = True,
) -> Trajectory:
    """Solve the Euler–Poisson equations (3.29) of a scene in one number type, once.

    Ctrl-C ends the run within a second, and the trajectory holds what was reached; of a run on the
    way to something else, not ``interruptible``, it goes on as KeyboardInterrupt.  Raises BadInput
    for what cannot be integrated.
    """
    system = system_of(scene, number, options.tolerance, options.inputs)
    times = system.times(scene)
    failed: dict[str, str] = {}
    for motion in _motions(system, scene, options):
        began = time.perf_counter()
        try:
            rows, outcome = motion.run(times.inside, progress)
        except CannotSolve as fault:
            _LOG.info("%s: not %s: %s", scene.name, motion.method, fault)
            failed[f"not {motion.method}"] = str(fault)
            continue
        if outcome is Outcome.INTERRUPTED and not interruptible:
            raise KeyboardInterrupt
        seconds, building = time.perf_counter() - began, motion.build_seconds
        if _LOG.isEnabledFor(logging.INFO):
            _LOG.info(
                "%s: %s (%d bits), %s after %d steps, %.3g s of which %.3g s compiling",
                *(scene.name, number.name, number.bits, outcome.value, motion.steps),
                *(seconds, building),
            )
        parts = {"build": building, "run": seconds - building}
        read, outside = motion.read, times.outside
        states, attitude, angles = read.states(rows), None, None
        if scene.modelled:
            attitude, angles = read.attitude(rows, states), read.angles(rows, states)
        return Trajectory(
            scene=scene,
            number=number,
            times=outside if len(rows) == len(outside) else outside[: len(rows)],
            states=read_only(states, len(scene.columns)),
            attitude=None if attitude is None else read_only(attitude, len(ATTITUDE)),
            angles=None if angles is None else tuple(map(tuple, angles)),
            events=Events(motion.events),
            projection=motion.projection,
            outcome=outcome,
            steps=motion.steps,
            reached=motion.reached,
            tolerance=float(options.tolerance or 2.0 ** (1 - number.bits)),
            digits=options.digits,
            provenance=partial(  # type: ignore[arg-type]  # which may wait
                _made_of, scene, parts, {**failed, **motion.remarks}
            ),
            dense=motion,
            method=motion.method,
            errors=motion.errors,
        )
    raise AssertionError("the last method serves")


def _motions(system: System, scene: Scene, options: Options) -> Iterator[RefinedMotion | Motion]:
    """Those to try, in order; raises BadInput where the method that was named does not serve."""
    named, number = options.method == "refined", system.number
    if named or (options.method == "auto" and number.bits > 64):
        hindrance = hindrance_to_refinement(scene, number, options)
        if hindrance is not None and named:
            expected = f"{hindrance}, or the method taylor"
            raise BadInput(scene.name, "method", options.method, expected)
        if hindrance is None and (named or refinement_pays(scene, number)):
            from polhode.runs.refined_motion import RefinedMotion

            yield RefinedMotion(system, scene, options)
    yield Motion(system, scene, cadence(scene, number, options), options.max_steps)


def _made_of(
    scene: Scene, seconds: Mapping[str, float], more: Mapping[str, str]
) -> Mapping[str, object]:
    """A trajectory's provenance, made when it is wanted: it takes as long as a short run."""
    return {**scene.provenance(), "seconds": seconds, **more}


# --- reevaluate -----------------------------------------------------------------------------------
#
# State, attitude and angles of a run at any time: its own rows, or rows made when asked for.


def at_times(run: Trajectory, output: str, t: AnyNumber | Iterable[AnyNumber]) -> Reread:
    """States, attitude or angles at time t, or rows of them; raises BadInput beyond what was
    reached.

    At a time of the run's outputs they are that row.  psi and phi count whole turns from the start
    on, so they are integrated from there.
    """
    scene = run.scene
    if output != "states" and scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, f"a unit vector, for {output}")
    numbers, several = numbers_given(t)
    times = [_time(run, x) for x in numbers]
    own: Given | None = getattr(run, output)
    rows: dict[Fraction, Any] = {}
    if own is not None:
        places = ((x, bisect_left(run.times, abs(x), key=abs)) for x in times)
        rows |= {x: own[k] for x, k in places if k < len(run.times) and run.times[k] == x}
    others = sorted({x for x in times if x not in rows}, key=abs)
    if others:
        rows |= zip(others, _rows(run, output, others), strict=True)
    answers = [rows[x] for x in times]
    return answers if several else answers[0]


def made_again(run: Trajectory, scene: Scene, *, interruptible: bool = True) -> Trajectory:
    """A run of its own scene, or of that with other outputs, as it was made."""
    return solve(scene, run.number, _options(run), interruptible=interruptible)


def _options(run: Trajectory) -> Options:
    """How a run was made; one that steps did not bring to the end ends soon after it did."""
    every = None if run.projection is None else run.projection.every
    tolerance = None if run.at_full_tolerance else Fraction(run.tolerance)
    most = None
    if run.method == "taylor" and run.outcome in (Outcome.STEP_LIMIT, Outcome.INTERRUPTED):
        most = run.steps + defaults.of(run.number).chunk  # the last may have gone uncounted
    return Options(run.method, most, every or False, tolerance, None, run.digits)


def _rows(run: Trajectory, output: str, times: list[Fraction]) -> Sequence[GivenRow]:
    """Rows at times of which none is one of the run's own, in the order of the motion."""
    rows: Sequence[GivenRow]
    if output != "states" and run.method == "refined":
        again = made_again(run, _with_output(run, output, times), interruptible=False)
        rows, outcome, reached = getattr(again, output), again.outcome, again.reached
    else:
        motion = _motion(run, output)
        try:
            raw, outcome, reached = motion.at(times)
        except OutOfRange as fault:
            expected = f"a time that {run.number.name} holds ({fault})"
            raise BadInput(run.scene.name, "t", shown(times[0]), expected) from None
        rows = _read(motion.read, output, raw)
    if len(rows) < len(times):  # angles are singular where the state is not
        expected = f"a time at which there are {output}; {outcome.cause} at t = {shown(reached)}"
        raise BadInput(run.scene.name, "t", shown(times[len(rows)]), expected)
    return rows


def _read(read: RowReader, output: str, rows: Sequence[Row]) -> Sequence[GivenRow]:
    """A motion's rows as states, attitude or angles."""
    states = read.states(rows)
    if output == "states":
        return cast("Sequence[GivenRow]", states)
    read_rows = read.attitude if output == "attitude" else read.angles
    return cast("Sequence[GivenRow]", read_rows(rows, states))


def _motion(run: Trajectory, output: str) -> Interpolant:
    """What tells rows of this kind: the run's own motion, or one with it to the same time."""
    if output == "states" or (run.dense is not None and output in run.scene.modelled):
        if run.dense is None:
            raise ValueError("states at the output times only: nothing was integrated here")
        return run.dense
    if output not in run.others:
        scene, options = _with_output(run, output, run.times), _options(run)
        system = system_of(scene, run.number, options.tolerance)
        every = cadence(scene, run.number, options)
        motion = Motion(system, scene, every, options.max_steps)
        motion.reached = run.reached
        run.others[output] = motion
    return run.others[output]


def _with_output(run: Trajectory, output: str, times: Sequence[Fraction]) -> Scene:
    """The scene of a run with one output, without events."""
    return replace(run.scene, outputs=(output,), events=(), times=tuple(times))


def _time(run: Trajectory, t: object) -> Fraction:
    """A time that was reached, exact, or to far more bits than a row has."""
    try:
        exact = reader(run.scene.units, TIME)(t)
    except ValueError:
        raise _beyond(run, plain(t)) from None
    if sign(exact) * sign(run.reached) < 0 or sign(abs(exact) - abs(run.reached)) > 0:
        raise _beyond(run, shown(exact))
    if isinstance(exact, Fraction):
        return exact
    return NumberType("mp", 2 * run.number.bits + 128).rounded(exact)


def _beyond(run: Trajectory, t: str) -> BadInput:
    expected = f"a time from 0 to {shown(run.reached)}, what the run reached"
    return BadInput(run.scene.name, "t", t, expected)
