"""Scene, number type and options to a trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from polhode.common.interrupts import Progress
from polhode.common.values import waiting
from polhode.motion.outcomes import Events
from polhode.numbers.number_types import NumberType, read_only
from polhode.runs.methods import followed
from polhode.runs.options import USUAL, Options
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE


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
    motion, times, rows, outcome, seconds, failed = followed(
        scene, number, options, progress, interruptible=interruptible
    )
    read = motion.read
    states, attitude, angles = read.states(rows), None, None
    if scene.modelled:
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
        provenance=waiting(partial(_made_of, scene, seconds, {**failed, **motion.remarks})),
        dense=motion,
        method=motion.method,
        errors=motion.errors,
    )


def _made_of(
    scene: Scene, seconds: Mapping[str, float], more: Mapping[str, str]
) -> Mapping[str, object]:
    """A trajectory's provenance, made when it is wanted: it takes as long as a short run."""
    return {**scene.provenance(), "seconds": seconds, **more}
