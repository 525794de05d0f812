"""The table of policy: runs go by it, and what its columns owe each other."""

import math

import pytest

import polhode
from polhode.taylor import defaults
from shared.tools import change_policy, tiers


def test_cyclic_variables_are_divided_by_the_next_power_of_two():
    """A power of two rounds nothing; above the steps, so that they stay below about one."""
    for row in defaults.TABLE.values():
        assert row.divisor == 2 ** (math.floor(math.log2(row.set_back)) + 1)


@pytest.mark.parametrize("number", tiers(["double", "quad"], ["extended"]))
def test_runs_go_by_the_table(number, monkeypatch):
    scene = polhode.load("kovalevskaya/generic")
    every = {"double": 320, "extended": 32, "quad": 1}[number]
    assert polhode.integrate(scene, number, at=[1], project=True).projection.every == every
    change_policy(monkeypatch, project_every=3, max_steps=2)
    run = polhode.integrate(scene, number, at=[10], project=True)
    assert run.projection.every == 3
    assert run.steps == 2
    assert "step limit" in run.outcome.value
