"""The plans of a run: what is integrated, at which times, and what is told beside it."""

from __future__ import annotations

from typing import NamedTuple

from polhode.common.recent import Recent
from polhode.runs._observers.protocol import Way
from polhode.runs.problem.problem import Problem, Schedule
from polhode.scenes.scene import Scene
from polhode.taylor.backend.time_grid import Times


class Plan(NamedTuple):
    """One way to run a problem.

    ``times``: of the outputs, and of a way's own.  ``variables``: integrated beside the state.
    ``watched``: whether events are looked for as steps are taken.  ``way``: what tells beside the
    run that which is not integrated in it.
    """

    times: Times
    variables: tuple[str, ...]
    watched: bool
    way: Way | None = None


_kept: Recent[tuple[Plan, ...]] = Recent(1)


def plans(problem: Problem, scene: Scene, schedule: Schedule) -> tuple[Plan, ...]:
    """The plans for a scene's schedule, fastest first; the last, all in one system, always works.

    They are kept as long as the schedule is.
    """
    if not (scene.events or scene.modelled):
        return (Plan(schedule.inside, (), False),)
    return _kept.get(schedule, None, lambda: _planned(problem, scene, schedule.inside))


def _planned(problem: Problem, scene: Scene, times: Times) -> tuple[Plan, ...]:
    ways: list[Way] = []
    if scene.modelled:
        from polhode.runs._observers import attitude

        ways += attitude.ways(problem, times)
    whole = Plan(times, scene.modelled, bool(scene.events))
    return (*(Plan(way.times, (), False, way) for way in ways), whole)
