"""The table of policy: what was measured for it, and what its columns owe each other."""

from __future__ import annotations

import math
import re
from pathlib import Path

import heyoka as hy
import numpy as np
import pytest

import polhode
from polhode import NumberType, Outcome
from polhode.numbers.number_types import NAMES, mp
from polhode.taylor import batches, defaults, heyoka
from shared.tools import DOUBLE, EXTENDED, QUAD, change_policy, tiers

TYPES = {"double": DOUBLE, "extended": EXTENDED, "quad": QUAD, "mp": mp()}


def chosen(title: str) -> str:
    """The chapter of choices.md of that beginning."""
    text = (Path(__file__).parents[2] / "reports/choices.md").read_text(encoding="utf-8")
    (section,) = [part for part in text.split("\n## ") if part.startswith(title)]
    return section


def bold(text: str) -> list[int]:
    """The choices in a text that begin a row of its tables."""
    return [int(x) for x in re.findall(r"^\| \*\*(\d+)\*\* \|", text, re.MULTILINE)]


def test_every_number_type_has_its_row():
    assert tuple(defaults.TABLE) == NAMES


def test_chunks_are_those_of_the_choices():
    text = chosen("Chunk length")
    assert bold(text) == [defaults.of(DOUBLE).chunk]
    assert {(name, int(steps)) for name, steps in re.findall(r"(\w+): (\d+) steps", text)} == {
        (name, defaults.of(number).chunk) for name, number in TYPES.items()
    }


def test_a_chunk_of_mp_takes_a_fifth_of_a_second_at_any_bits():
    """2 ms a step at 237 bits, growing like bits**2.7; one step at least."""
    assert defaults.of(NumberType("mp", 237)).chunk == 100
    for bits in (128, 332, 512):
        seconds = defaults.of(NumberType("mp", bits)).chunk * 2e-3 * (bits / 237) ** 2.7
        assert 0.2 * 0.95 < seconds <= 0.2
    assert defaults.of(NumberType("mp", 13_300)).chunk == 1


def test_projection_is_that_of_the_choices():
    text = chosen("Steps between two projections")
    for name in ("double", "extended"):
        table = text.split(f"\n{name}:\n")[1].split("\n\n")[0]
        assert bold(table) == [defaults.TABLE[name].project_every]
    assert "quad and mp are not projected unless asked" in text
    assert [row.projected for row in defaults.TABLE.values()] == [True, True, False, False]


def test_compact_mode_is_that_of_the_choices():
    text = chosen("Compact mode")
    rows = dict(re.findall(r"^\| (\w+) \| (\w+) \| .*\*\*chosen\*\* \|$", text, re.MULTILINE))
    assert rows == {
        name: "compact" if row.compact else "unrolled" for name, row in defaults.TABLE.items()
    }
    for name, number in TYPES.items():
        options = heyoka.type_options(number)
        assert options.get("compact_mode", False) is defaults.TABLE[name].compact


def test_cyclic_variables_are_divided_by_the_next_power_of_two():
    """A power of two rounds nothing; above the steps, so that they stay below about one."""
    for row in defaults.TABLE.values():
        assert row.divisor == 2 ** (math.floor(math.log2(row.set_back)) + 1)


@pytest.mark.parametrize("number", tiers(["double", "quad"], ["extended"]))
def test_runs_go_by_the_table(number, monkeypatch):
    scene = polhode.load("kovalevskaya/generic")
    assert polhode.integrate(scene, number, at=[1], project=True).projection.every == (
        defaults.TABLE[number].project_every
    )
    change_policy(monkeypatch, project_every=3, max_steps=2)
    run = polhode.integrate(scene, number, at=[10], project=True)
    assert run.projection.every == 3
    assert run.steps == 2
    assert "step limit" in run.outcome.value


# -- Batches in blocks of steps: the same bits, a signal's turn, and lanes that cannot go on -------

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
