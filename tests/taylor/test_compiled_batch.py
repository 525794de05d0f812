"""A batch of lanes that is taken up again: what it gives has no trace of who used it before."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.common.progress import Stop
from polhode.dynamics.sections import coordinates, jobs
from polhode.dynamics.sections.starts import asked_of
from polhode.numbers.number_types import DOUBLE
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend.integrator_pool import Pool
from polhode.taylor.batches import batch_integrator
from polhode.taylor.batches.jobs import BatchJob, Lanes
from polhode.taylor.events import batch_crossings, batch_first_crossings
from polhode.taylor.integrator import prepared
from polhode.taylor.variations import tangent_batches

MANY = 11  # orbits: not as many as any machine has lanes

Solve = Callable[[np.ndarray, Stop | None], list[np.ndarray]]


def section_job() -> batch_crossings.CrossingJob:
    """Orbits on one level, their crossings of the extrema of |G|."""
    scene = polhode.load("general/asymmetric-chaotic")
    what = asked_of(scene, "momentum", "max", 3, Fraction(1, 2))
    on = coordinates.ground(scene, what.h, what.f)
    l, ratio = np.linspace(0.5, 5.5, MANY), np.linspace(-0.4, 0.4, MANY)
    starts = coordinates.momentum_states(on, l, ratio, True).states
    (job,) = jobs.jobs_of(what, on, jobs.zero_of(scene, on, "momentum"), -1, 4, starts)
    return job


JOB = section_job()
NAMES, NUMBERS = zip(*JOB.coefficients, strict=True)
SAME = np.tile(NUMBERS, (MANY, 1))


def sections(starts: np.ndarray, stop: Stop | None) -> list[np.ndarray]:
    found = batch_crossings.solve(JOB._replace(starts=starts), stop)
    return [found.states, found.times, found.slopes, found.found]


def first_zeros(starts: np.ndarray, stop: Stop | None) -> list[np.ndarray]:
    job = batch_first_crossings.FirstJob(
        NAMES, STATE, "gamma3 - t/8", 4.0, 1, 10**6, 70.0, 0, SAME, starts, None
    )
    found = batch_first_crossings.solve(job, stop)
    return [found.times, found.states, found.steps, found.unsure]


def tangents(starts: np.ndarray, stop: Stop | None) -> list[np.ndarray]:
    job = tangent_batches.TangentJob(
        NAMES, SAME, starts, np.ones((MANY, 6)), 40.0, 8, None, (4,), 6.0
    )
    return [*tangent_batches.solve(job, stop)]


def sweeps(starts: np.ndarray, stop: Stop | None) -> list[np.ndarray]:
    times = (Fraction(0), Fraction(7), Fraction(30))
    job = BatchJob(NAMES, DOUBLE, None, 10**6, times, 0, Lanes(SAME, starts))
    found = batch_integrator.solve(job, stop)
    return [found.states, found.steps, found.outcomes]


@pytest.mark.parametrize("solve", [sections, first_zeros, tangents, sweeps])
def test_a_batch_taken_up_again_has_no_trace_of_who_used_it_before(solve: Solve, monkeypatch):
    monkeypatch.setattr(prepared, "POOL", Pool())
    fresh = solve(JOB.starts, None)
    spoiled = JOB.starts.copy()
    spoiled[3] = np.nan
    solve(spoiled, None)
    solve(np.roll(JOB.starts, 4, axis=0), iter([False, True, True, True]).__next__)
    monkeypatch.setattr("heyoka.taylor_adaptive_batch", None)
    for one, other in zip(solve(JOB.starts, None), fresh, strict=True):
        assert np.array_equal(one, other, equal_nan=True)
    assert any(np.isfinite(x).any() for x in fresh)


@pytest.mark.parametrize("solve", [sections, first_zeros, tangents, sweeps])
def test_a_motion_that_is_lost_changes_no_other(solve: Solve):
    fresh = solve(JOB.starts, None)
    spoiled = JOB.starts.copy()
    spoiled[3] = np.nan
    for one, other in zip(solve(spoiled, None), fresh, strict=True):
        kept = np.arange(MANY) != 3
        assert np.array_equal(one[kept], other[kept], equal_nan=True)
