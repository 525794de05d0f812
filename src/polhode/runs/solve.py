"""Scene, number type and options to trajectory: methods in turn, until one serves."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.motion.outcomes import Events, Outcome
from polhode.motion.protocols import CannotSolve
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import read_only
from polhode.runs.methods import refined
from polhode.runs.methods.taylor import TaylorMotion, system_of
from polhode.runs.problem.options import USUAL, Options
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE

if TYPE_CHECKING:
    from polhode.runs.methods.refined_motion import RefinedMotion

#: What begins a motion of a system: see :class:`polhode.runs.methods.taylor.TaylorMotion`.
Method: TypeAlias = "type[TaylorMotion] | type[RefinedMotion]"

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
    ahead = system.times(scene)
    failed: dict[str, str] = {}
    for method in _methods(scene, number, options):
        began = time.perf_counter()
        motion = method(system, scene, options)
        try:
            rows, outcome = motion.advance(ahead, progress)
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
        read, times = motion.read, ahead.outside
        states = read.states(rows)
        attitude, angles = read.attitude(rows, states), read.angles(rows, states)
        return Trajectory(
            scene=scene,
            number=number,
            times=times if len(rows) == len(times) else times[: len(rows)],
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


def _methods(scene: Scene, number: NumberType, options: Options) -> Iterator[Method]:
    """Those to try, in order; raises BadInput where the one that was named does not serve."""
    named = options.method == "refined"
    if options.method != "taylor":
        hindrance = refined.hindrance(scene, number, options)
        if hindrance is not None and named:
            wanted = f"{hindrance}, or the method taylor"
            raise BadInput(scene.name, "method", options.method, wanted)
        if hindrance is None and (named or refined.worth_it(scene, number)):
            from polhode.runs.methods.refined_motion import RefinedMotion

            yield RefinedMotion
    yield TaylorMotion


def _made_of(
    scene: Scene, seconds: Mapping[str, float], more: Mapping[str, str]
) -> Mapping[str, object]:
    """A trajectory's provenance, made when it is wanted: it takes as long as a short run."""
    return {**scene.provenance(), "seconds": seconds, **more}
