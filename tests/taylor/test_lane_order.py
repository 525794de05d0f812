"""Systems that take as many steps as each other share a batch; what each gives is the same."""

from __future__ import annotations

import numpy as np
import pytest

import polhode
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE
from polhode.runs.sweep.plan import planned
from polhode.taylor.batches import batch_integrator, jobs, lane_order
from polhode.taylor.batches.compiled_batch import width
from shared.motions import heavy


def job_of(end: str, count: int = 61, **options):
    """Spins from slow to fast in no order, in one unit of time."""
    spins = [2 + (37 * k % count) / count for k in range(count)]
    varied = [{"start.omega[3]": spin, "start.omega[1]": spin / 3} for spin in spins]
    plan = planned(heavy(end, samples=3), varied, "double", None, None, options.get("steps"))
    assert len(set(plan.time_units)) == 1
    n = int(plan.time_units[0])
    return jobs.BatchJob(
        plan.names, DOUBLE, plan.tolerance, plan.max_steps, plan.times, n, plan.lanes
    )


@pytest.mark.parametrize("end", ["600", "-600"])
def test_the_same_bits_in_whichever_order(end, monkeypatch):
    job = job_of(end)
    called, order = [], lane_order.by_steps
    monkeypatch.setattr(lane_order, "by_steps", lambda *a: called.append(1) or order(*a))
    found = batch_integrator.solve(job)
    monkeypatch.setattr(lane_order, "_LONG", 1e9)
    plain = batch_integrator.solve(job)
    assert called == [1]
    for name in ("states", "outcomes", "steps", "reached"):
        assert np.array_equal(getattr(found, name), getattr(plain, name))
    assert len(np.unique(found.steps)) > 30


def test_lanes_idle_less():
    """Steps wanted over lanes times steps of the longest in each batch."""
    job, size = job_of("600", 64), width(DOUBLE)
    order = lane_order.by_steps(batch_integrator.prepared(job), job.lanes, 1.0)
    steps = batch_integrator.solve(job).steps

    def busy(order):
        return steps.sum() / (size * steps[order].reshape(-1, size).max(axis=1).sum())

    assert sorted(order) == list(range(64))
    assert busy(np.arange(64)) < 0.9
    assert 0.96 < busy(order) <= busy(np.argsort(steps)) <= 1


def test_a_short_way_is_not_tried_beforehand(monkeypatch):
    monkeypatch.setattr(lane_order, "by_steps", None)
    assert batch_integrator.solve(job_of("20")).done.all()
    assert batch_integrator.solve(job_of("600", width(DOUBLE))).done.all()


def test_a_member_that_fails_keeps_its_place():
    found = polhode.integrate_many(
        heavy("600"), {"body.weight": [*range(1, 12), 10**7, *range(12, 20)]}, max_steps=9000
    )
    failed = [k for k, outcome in enumerate(found.outcomes) if outcome is not Outcome.REACHED_END]
    assert failed == [11]


def test_what_is_put_in_order():
    order = np.array([2, 0, 1])
    number = np.arange(3)
    told = [(float(k),) for k in order]
    some = jobs.Solved(number[order, None, None], number[order], number[order], order, told)
    found = some.in_order(order)
    assert found.outcomes.tolist() == found.steps.tolist() == found.reached.tolist() == [0, 1, 2]
    assert found.states[:, 0, 0].tolist() == [0, 1, 2]
    assert found.errors == [(0.0,), (1.0,), (2.0,)]
