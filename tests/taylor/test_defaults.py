"""The table of policy: what was measured for it, and what its columns owe each other."""

import math
import re
from pathlib import Path

import pytest

import polhode
from polhode import NumberType
from polhode.numbers.number_types import NAMES, mp
from polhode.taylor import defaults
from shared.tools import DOUBLE, EXTENDED, QUAD, change_policy, tiers

TYPES = {"double": DOUBLE, "extended": EXTENDED, "quad": QUAD, "mp": mp()}


def test_every_number_type_has_its_row():
    assert tuple(defaults.TABLE) == NAMES


def test_the_table_is_that_of_the_choices():
    """What was measured for it, in bold or by name in the chapters of the report."""
    text = (Path(__file__).parents[2] / "reports/choices.md").read_text(encoding="utf-8")

    def chapter(title):
        (part,) = (part for part in text.split("\n## ") if part.startswith(title))
        return part

    steps = dict(re.findall(r"(\w+): (\d+) steps", chapter("Chunk length")))
    assert steps == {name: str(defaults.of(number).chunk) for name, number in TYPES.items()}
    for name in ("double", "extended"):
        table = chapter("Steps between two projections").split(f"\n{name}:\n")[1].split("\n\n")[0]
        every = re.findall(r"^\| \*\*(\d+)\*\* \|", table, re.MULTILINE)
        assert every == [str(defaults.TABLE[name].project_every)]
    row = re.compile(r"^\| (\w+) \| (\w+) \| .*\*\*chosen\*\* \|$", re.MULTILINE)
    assert dict(row.findall(chapter("Compact mode"))) == {
        name: "compact" if row.compact else "unrolled" for name, row in defaults.TABLE.items()
    }
    starts = re.findall(r"\*\*(\d+)\*\*", chapter("Arrays of starts"))
    assert starts == [str(defaults.ARRAYS.starts)]


def test_a_chunk_of_mp_takes_a_fifth_of_a_second_at_any_bits():
    """2 ms a step at 237 bits, growing like bits**2.7; one step at least."""
    assert defaults.of(NumberType("mp", 237)).chunk == 100
    for bits in (128, 332, 512):
        seconds = defaults.of(NumberType("mp", bits)).chunk * 2e-3 * (bits / 237) ** 2.7
        assert 0.2 * 0.95 < seconds <= 0.2
    assert defaults.of(NumberType("mp", 13_300)).chunk == 1


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
