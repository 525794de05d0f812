"""The table of policy: what was measured for it, and what its columns owe each other."""

import math
import re
from pathlib import Path

import pytest

import polhode
from polhode import NumberType
from polhode.numbers.number_types import NAMES, mp
from polhode.taylor import defaults, heyoka
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
