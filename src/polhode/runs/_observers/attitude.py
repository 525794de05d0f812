"""Attitude and angles: the ways to tell them beside a plain run, where they need not be in it."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.runs._observers import attitude_lanes
from polhode.runs._observers.protocol import Way
from polhode.runs.problem.problem import Problem
from polhode.taylor.backend.time_grid import Times


def ways(problem: Problem, times: Times) -> Iterator[Way]:
    """Fastest first; none where all is to be integrated as one system."""
    if not apart(problem):
        return
    if attitude_lanes.fits(problem, times):
        yield attitude_lanes.planned(problem, times)
    if problem.number.name == "extended":
        from polhode.runs._observers import attitude_quadrature

        fits = attitude_quadrature.fits(problem)
        if fits and (way := attitude_quadrature.planned(problem, times)) is not None:
            yield way


def apart(problem: Problem) -> bool:
    """Whether attitude and angles may be had from a plain run's states.

    In double and extended, in the principal form, of a scene with gamma.  Not beside events, whose
    expressions take part in choosing the steps; nor of a body at rest; no angles from a pole on.
    """
    scene = problem.scene
    return (
        problem.number.flat
        and bool(scene.modelled)
        and scene.form == "principal"
        and scene.gamma is not None
        and not scene.events
        and not problem.still
        and not ("angles" in scene.modelled and scene.starts_at_pole)
    )
