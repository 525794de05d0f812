"""Batches in blocks of steps: the same bits, a signal's turn, and lanes that cannot go on."""

import heyoka as hy
import numpy as np
import pytest

from polhode import Outcome
from polhode.taylor import batches

END, LIMIT = Outcome.REACHED_END, Outcome.STEP_LIMIT


def oscillators(rates, event=None):
    x, v = hy.make_vars("x", "v")
    start = np.array([[0.0] * len(rates), [1.0] * len(rates)])
    events = [] if event is None else [hy.nt_event_batch(event(x), lambda *_: None)]
    system = [(x, hy.par[0] * v), (v, -hy.par[0] * x)]
    return hy.taylor_adaptive_batch(system, start, pars=np.array([rates]), nt_events=events)


@pytest.mark.parametrize("block", [1, 7, 10_000])
def test_blocks_change_no_bit(monkeypatch, block):
    ends = [10.0, 0.0, -20.0, 30.0]
    once, blocks = (oscillators([1.0, 2.0, 3.0, 50.0]) for _ in range(2))
    once.propagate_until(ends)
    monkeypatch.setattr(batches, "BLOCK", block)
    ended = batches.until(blocks, ends)
    assert np.array_equal(blocks.state, once.state)
    assert ended.outcomes == [END] * 4
    assert not ended.stopped
    counts = [result[3] for result in once.propagate_res]
    assert ended.steps.tolist() == [counts[0], 0, *counts[2:]]


def test_steps_that_a_pole_makes_zero_are_told():
    ta = oscillators([1.0, 2.0], lambda x: 1 / (x - hy.expression(0.5)))
    ended = batches.until(ta, [10.0, 0.01])
    assert ended.outcomes == [Outcome.STEP_UNDERFLOW, END]
    assert ta.time[0] == pytest.approx(np.pi / 6, rel=4e-16)
    assert 0.49 < ta.state[0, 0] <= 0.5


def test_a_limit_counts_over_blocks(monkeypatch):
    monkeypatch.setattr(batches, "BLOCK", 7)
    ended = batches.until(oscillators([1.0, 50.0]), [2.0, 100.0], 20)
    assert ended.outcomes == [END, LIMIT]
    assert ended.steps[1] == 20


def test_a_lane_that_is_lost_leaves_the_others_alone():
    x = hy.make_vars("x")
    start = np.array([[-1.0, 1.0, 2.0]])
    ta, alone = (hy.taylor_adaptive_batch([(x, x * x)], s) for s in (start, start[:, [0, 0, 2]]))
    ended = batches.until(ta, [10.0, 20.0, -3.0])
    assert ended.outcomes == [END, Outcome.NON_FINITE, END]
    alone.propagate_until([10.0, 10.0, -3.0])
    assert np.isnan(ta.state[0, 1])
    assert np.array_equal(ta.state[0, [0, 2]], alone.state[0, [0, 2]])
    lost = hy.taylor_adaptive_batch([(x, x * x)], np.array([[1.0, 2.0]]))
    assert batches.until(lost, [10.0, 20.0]).outcomes == [Outcome.NON_FINITE] * 2
    ta = hy.taylor_adaptive_batch([(x, x * x)], np.array([[-1.0, np.nan, 2.0]]))
    assert batches.until(ta, [10.0, 0.0, -3.0]).outcomes == [END, Outcome.NON_FINITE, END]
    assert np.array_equal(ta.state[0, [0, 2]], alone.state[0, [0, 2]])
    ta, alone = (oscillators(rates) for rates in ([1.0, 1e300, 2.0], [1.0, 1.0, 2.0]))
    assert batches.until(ta, [10.0, 20.0, -3.0]).outcomes == [END, Outcome.NON_FINITE, END]
    alone.propagate_until([10.0, 10.0, -3.0])
    assert np.array_equal(ta.state[:, [0, 2]], alone.state[:, [0, 2]])
