"""Scene and number type to trajectory: the main job."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import cast

from polhode.common.arguments import steps
from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.common.provenance import provenance
from polhode.equations.readout import Readout
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Rows
from polhode.numbers.scalars import AnyNumber
from polhode.runs._observers import attitude_lanes
from polhode.runs._observers import events as event_observer
from polhode.runs.methods import refined as refined_method
from polhode.runs.methods.dense_output import Dense
from polhode.runs.methods.taylor import Run
from polhode.runs.problem.options import cadence, choose_number, rounded_tolerance
from polhode.runs.problem.problem import Problem, Schedule, problem
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.scene import Scene

_LOG = logging.getLogger("polhode")


def integrate(
    scene: Scene | str | Path,
    number: str | NumberType | None = None,
    *,
    digits: int | None = None,
    at: Sequence[AnyNumber] | None = None,
    tol: AnyNumber | None = None,
    max_steps: int | None = None,
    inputs: NumberType | None = None,
    project: bool | int | None = None,
    method: str = "auto",
    progress: Progress | None = None,
) -> Trajectory:
    """Integrate the Euler–Poisson equations (3.29) of a scene with heyoka's Taylor method, once.

    :func:`polhode.judging.adaptive_precision.integrate`, which is polhode.integrate, also sees to
    it that digits asked for are had.

    ``number``: double (default), extended, quad or mp (50 digits), or a NumberType.  ``digits``:
    the digits wanted, which choose the number type by the angle turned alone.  ``at``: output times
    instead of the scene's.
    ``tol``: the tolerance of a step, the type's eps unless given.  ``inputs``: round start and
    coefficients to this narrower type first, to see what that rounding alone does.  ``project``:
    put the state back on the exact scene's first integrals every so many steps, True as often as
    costs about a tenth of the run's time, False never; left out, as True in double and extended at
    full tolerance, else never (a form other than the principal one never).  ``method``: "taylor",
    steps in the number type; "refined", a run in double corrected by exact arithmetic
    (:mod:`polhode.refined`), for quad and more digits; "auto", refined where that can be done and
    is faster.  Where a refinement does not succeed the steps are taken: the trajectory's
    ``method`` tells which it was.  ``progress``: called now and then with the fraction of the time
    done and the steps taken.

    The trajectory can be called at any time that it reached, see
    :class:`polhode.runs.methods.dense_output.Dense`. Ctrl-C ends the run within a second; the
    trajectory then holds what was reached.  Raises BadInput for what cannot be integrated.
    """
    scene = library.load(scene)
    if at is not None:
        scene = scene.at(at)
    chosen = choose_number(scene, number, digits)
    tolerance = rounded_tolerance(scene, chosen, tol)
    ready = problem(scene, chosen, tolerance, inputs)
    times = ready.schedule(scene)
    every = None if inputs is not None else cadence(scene, chosen, tolerance, project)
    if max_steps is not None:
        max_steps = steps(scene.name, max_steps)
    refined, failed = _refined(
        scene, chosen, times.exact, digits, tolerance, max_steps, inputs, project, method, progress
    )
    if refined is not None:
        return refined
    run, outcome, rows = _stepped(scene, ready, times, max_steps, every, progress)
    _LOG.info(
        "%s: %s (%d bits), %s after %d steps, %.3g s of which %.3g s compiling",
        *(scene.name, chosen.name, chosen.bits, outcome.value, run.steps),
        *(run.seconds, run.build_seconds),
    )
    read = ready.read
    return Trajectory(
        scene=scene,
        number=chosen,
        times=times.exact[: len(rows)],
        states=read.states(rows),
        attitude=read.attitude(rows),
        angles=read.angles(rows),
        events=run.events,
        projection=run.projection,
        outcome=outcome,
        steps=run.steps,
        reached=run.reached,
        tolerance=float(tolerance or chosen.eps),
        digits=digits,
        provenance=_made_of(
            scene,
            {"build": run.build_seconds, "run": run.seconds - run.build_seconds},
            failed,
        ),
        dense=Dense(run),
    )


def _stepped(
    scene: Scene,
    ready: Problem,
    times: Schedule,
    max_steps: int | None,
    every: int | None,
    progress: Progress | None,
) -> tuple[Run, Outcome, Rows]:
    """A run, how it ended, and its rows: the state's, then quaternion, psi and phi."""
    if event_observer.fits(ready, times):
        run = Run(ready.bare, max_steps, every)
        seen = event_observer.rows(run, scene, ready, times, progress)
        if seen is not None:
            return run, *seen
    found = None
    if attitude_lanes.fits(ready, times):
        run = Run(ready.bare, max_steps, every)
        found = attitude_lanes.rows(run, ready, attitude_lanes.plan(ready, times), progress)
    elif ready.number.name == "extended":
        from polhode.runs._observers import attitude_quadrature

        wanted = attitude_quadrature.plan(ready, times)
        if wanted is not None:
            run = Run(ready.bare, max_steps, every)
            found = attitude_quadrature.rows(run, ready, wanted, progress)
    if found is not None:
        return run, *found
    run = Run(ready, max_steps, every, scene)
    return run, *run.to(times, progress)


def undisturbed(run: Trajectory) -> Trajectory:
    """A run made on the way to something else; the Ctrl-C that ended it goes on."""
    if run.outcome is Outcome.INTERRUPTED:
        raise KeyboardInterrupt
    return run


def _refined(
    scene: Scene,
    number: NumberType,
    times: Sequence[Fraction],
    digits: int | None,
    tolerance: Fraction | None,
    max_steps: int | None,
    inputs: NumberType | None,
    project: bool | int | None,
    method: str,
    progress: Progress | None,
) -> tuple[Trajectory | None, dict[str, str]]:
    """The trajectory by refinement, None where it is to be integrated; why a refinement failed."""
    refined_method.check_method(scene, method)
    if method == "taylor":
        return None, {}
    hindrance = refined_method.why_not(scene, number, tolerance, inputs, project)
    if hindrance is not None and method == "refined":
        raise BadInput(scene.name, "method", method, f"{hindrance}, or the method taylor")
    if hindrance is not None or (method == "auto" and not refined_method.worth_it(scene, number)):
        return None, {}
    from polhode.refined.errors import CannotRefine

    began = time.perf_counter()
    try:
        plain = refined_method.in_principal_axes(scene)
        found = refined_method.refinement(plain, number, times, digits, max_steps, progress)
    except CannotRefine as fault:
        _LOG.info("%s: not refined: %s", scene.name, fault)
        return None, {"not refined": str(fault)}
    seconds = time.perf_counter() - began
    read = Readout(plain, number)
    turned = {} if plain is scene else {"refined in": "principal axes, the same states"}
    rows = [a + b for a, b in zip(found.rows, found.beside, strict=False)]
    return Trajectory(
        scene=scene,
        number=number,
        times=found.times,
        states=read.states(found.rows),
        attitude=read.attitude(rows),
        angles=read.angles(rows),
        events=found.events,
        outcome=found.outcome,
        steps=found.steps,
        reached=found.reached,
        tolerance=float(number.eps),
        digits=digits,
        provenance=_made_of(scene, {"build": 0.0, "run": seconds}, turned),
        dense=found.dense,
        method="refined",
        errors=found.errors,
    ), {}


def _made_of(
    scene: Scene, seconds: Mapping[str, float], more: Mapping[str, str]
) -> Mapping[str, object]:
    """A trajectory's provenance, made when it is asked for: it takes as long as a short run."""

    def found() -> dict[str, object]:
        return {**provenance(scene.text), "seconds": seconds, **more}

    return cast(Mapping[str, object], found)
