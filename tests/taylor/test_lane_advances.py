"""Members that take many more steps than foreseen: in blocks, between which they can be stopped."""

from __future__ import annotations

import numpy as np
import pytest

from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import EXTENDED, QUAD, NumberType, extended_here, named
from polhode.runs.sweep.plan import planned
from polhode.taylor.batches import batch_integrator, jobs, lane_advances, step_blocks
from shared.motions import heavy

MANY = 5
DOUBLE = named("double")


def job_of(number: NumberType, samples: int, steps: int | None = None) -> jobs.BatchJob:
    """Some tops to t = 20 in one stretch."""
    varied = [{"start.omega[3]": 2 + k / 7} for k in range(MANY)]
    plan = planned(heavy("20", samples=samples), varied, number.name, None, None, steps)
    unit = int(plan.time_units[0])
    return jobs.BatchJob(
        plan.names, number, plan.tolerance, plan.max_steps, plan.times, unit, plan.lanes
    )


@pytest.fixture
def short(monkeypatch):
    """Blocks of few steps."""

    def cut(steps: int) -> None:
        for module in (batch_integrator, lane_advances):
            monkeypatch.setattr(module, "block", lambda number: steps)
        monkeypatch.setattr(step_blocks, "BLOCK", steps)

    return cut


X87 = pytest.mark.skipif(not extended_here(), reason="no long double of 64 bits here")
TYPES = [DOUBLE, pytest.param(EXTENDED, marks=X87), QUAD]


@pytest.mark.parametrize("number", TYPES, ids=lambda number: number.name)
@pytest.mark.parametrize("samples", [2, 9])
@pytest.mark.parametrize("block", [1, 7])
def test_blocks_change_no_row(short, number, samples, block):
    job = job_of(number, samples)
    once = batch_integrator.solve(job)
    short(block)
    found = batch_integrator.solve(job)
    assert found.done.all()
    # at a grid heyoka drops the low part of its time: steps may end a rounding apart
    assert abs(found.steps - once.steps).max() <= 1
    assert found.reached.tolist() == once.reached.tolist()
    if samples == 2 and number is DOUBLE:
        assert np.array_equal(found.states, once.states)
    off = np.abs((found.states - once.states).astype(float)).max()
    assert off <= 200 * 2.0**-number.bits


@pytest.mark.parametrize("number", [DOUBLE, QUAD], ids=lambda number: number.name)
@pytest.mark.parametrize("samples", [2, 9])
def test_who_says_stop_is_heard_within_a_stretch(short, number, samples):
    job = job_of(number, samples)
    short(5)
    said = [0]

    def stop() -> bool:
        said[0] += 1
        return said[0] > 4

    found = batch_integrator.solve(job, stop)
    assert said[0] >= 5
    assert (found.outcomes == code(Outcome.NOT_RUN)).any()


@pytest.mark.parametrize("samples", [2, 9])
def test_a_limit_counts_over_blocks(short, samples):
    limited = job_of(DOUBLE, samples, 20)
    once = batch_integrator.solve(limited)
    short(6)
    found = batch_integrator.solve(limited)
    assert (found.outcomes == code(Outcome.STEP_LIMIT)).all()
    assert found.steps.tolist() == once.steps.tolist() == [20] * MANY
    assert found.reached.tolist() == once.reached.tolist()
    assert np.array_equal(np.isnan(found.states), np.isnan(once.states))
