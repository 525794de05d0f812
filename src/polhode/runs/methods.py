"""The methods of integration in turn, until one serves: a scene's motion, followed to its end."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.motion.outcomes import CannotSolve, Outcome
from polhode.numbers.conversion import ExactNumbers
from polhode.numbers.number_types import NumberType, Rows
from polhode.runs.options import Options, cadence, refinement_pays
from polhode.scenes.scene import Scene
from polhode.taylor.motion import Motion
from polhode.taylor.system import System, system_of

if TYPE_CHECKING:
    from polhode.runs.refined_motion import RefinedMotion


_LOG = logging.getLogger("polhode")


class FollowedMotion(NamedTuple):
    """A motion that was followed: its ``rows`` at the first of the ``times``, and how it ended.

    ``times``: in the scene's unit.  ``seconds``: of building and of the run.  ``failed``: why
    others did not serve, for the provenance.
    """

    motion: RefinedMotion | Motion
    times: ExactNumbers[Fraction]
    rows: Rows
    outcome: Outcome
    seconds: Mapping[str, float]
    failed: Mapping[str, str]


def followed_motion(
    scene: Scene,
    number: NumberType,
    options: Options,
    progress: Progress | None = None,
    *,
    interruptible: bool = True,
) -> FollowedMotion:
    """The motion of a scene in one number type, by the first method that serves.

    ``interruptible``: see :func:`polhode.runs.trajectory.solve`.  Raises BadInput for what cannot
    be integrated.
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
        return FollowedMotion(motion, times.outside, rows, outcome, parts, failed)
    raise AssertionError("the last method serves")


def _motions(system: System, scene: Scene, options: Options) -> Iterator[RefinedMotion | Motion]:
    """Those to try, in order; raises BadInput where the method that was named does not serve."""
    named, number = options.method == "refined", system.number
    if named or (options.method == "auto" and number.bits > 64):
        hindrance = options.hindrance(scene, number)
        if hindrance is not None and named:
            expected = f"{hindrance}, or the method taylor"
            raise BadInput(scene.name, "method", options.method, expected)
        if hindrance is None and (named or refinement_pays(scene, number)):
            from polhode.runs.refined_motion import RefinedMotion

            yield RefinedMotion(system, scene, options)
    yield Motion(system, scene, cadence(scene, number, options), options.max_steps)
