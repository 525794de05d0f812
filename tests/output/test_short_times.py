"""The t of a CSV: of doubles as short as it round-trips, read again as the time that it was."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

import polhode
from polhode.cli import main
from polhode.judging.tables.table_file import read_table
from polhode.numbers.decimals import decimal_string, shortest
from polhode.numbers.number_types import mp
from polhode.results.writer import beside
from shared.tools import DOUBLE, EXTENDED, QUAD, tiers

SCENE = "lagrange/nutation"
TIMES = ["0", "0.1", "1/3", "10", "20.1", "sqrt(2)*20"]
TYPES = [DOUBLE, EXTENDED, QUAD, mp(60)]


def significant(text: str) -> int:
    return len(text.lower().partition("e")[0].replace(".", "").strip("-0"))


@given(
    st.fractions(min_value=-(10**9), max_value=10**9, max_denominator=10**9),
    st.integers(-40, 40),
    st.sampled_from(TYPES),
)
def test_no_shorter_decimal_rounds_to_the_number(x, power, number):
    rounded = number.rounded(x * Fraction(10) ** power)
    text = shortest(rounded, number)
    assert number.rounded(Fraction(text)) == rounded
    digits = significant(text)
    alone = rounded.numerator & (rounded.numerator - 1)  # below a power of two the next are nearer
    if digits > 1 and alone and Fraction(text) != rounded:
        assert number.rounded(Fraction(decimal_string(rounded, digits - 1))) != rounded


def test_short_numbers_stand_as_they_are():
    for x, text in ((100, "100"), (0.5, "0.5"), (-3, "-3"), (0, "0"), (1e5 + 0.25, "100000.25")):
        assert {shortest(Fraction(x), number) for number in TYPES} == {text}
    assert shortest(DOUBLE.rounded(Fraction(1, 3)), DOUBLE) == "0.3333333333333333"
    assert shortest(Fraction(0.1), DOUBLE) == "0.1"
    assert shortest(EXTENDED.rounded(Fraction(1, 10)), EXTENDED) == "0.1"
    assert len(shortest(Fraction(0.1), QUAD)) > 30  # another number in quad


@pytest.mark.parametrize("number", tiers(["double", "quad"], ["extended"]))
def test_a_file_is_read_as_the_times_of_its_run(tmp_path, number):
    path = tmp_path / "x.csv"
    assert main(["run", SCENE, "--at", ",".join(TIMES), "--number", number, "-o", str(path)]) == 0
    run = polhode.integrate(SCENE, number, at=TIMES)
    texts = [line.partition(",")[0] for line in path.read_text().splitlines()[1:]]
    if number == "double":
        assert texts[:5] == ["0.0", "0.1", "0.3333333333333333", "10.0", "20.1"]
    else:
        assert [*map(Fraction, texts)] == [*run.times]
    assert read_table(path, None).times == run.times
    # more bits than the file's change no time of it
    assert read_table(path, mp(90)).times == run.times


@pytest.mark.slow
@pytest.mark.parametrize("number", ["extended"])
def test_without_its_json_a_right_file_is_not_blamed(tmp_path, number):
    """Its digits tell the type that its numbers are of."""
    path = tmp_path / "x.csv"
    command = ["run", SCENE, "--number", number, "--at", "0.1,1/3,500.7", "-o", str(path)]
    assert main(command) == 0
    with_it = polhode.compare(path, SCENE)
    beside(path).unlink()
    alone = polhode.compare(path, SCENE)
    assert alone.subject.number == with_it.subject.number
    assert (alone.readings, with_it.readings) == ((), ())
    assert {alone.limit, with_it.limit} <= {"conditioning", "rounding"}


def test_a_stream_has_every_digit(capfd):
    assert main(["run", SCENE, "--at", "0.1", "-o", "/dev/stdout"]) == 0
    t = capfd.readouterr().out.splitlines()[1].partition(",")[0]
    assert Fraction(t) == Fraction(0.1)


def test_a_sweep_is_as_short(tmp_path, capsys):
    path = tmp_path / "s.csv"
    command = ["sweep", SCENE, "--vary", "start.omega[3]=2:4:2", "--at", "0.1,0.3"]
    assert main([*command, "-o", str(path)]) == 0
    assert [line.split(",")[1] for line in path.read_text().splitlines()[1:]] == ["0.1", "0.3"] * 2
    capsys.readouterr()
