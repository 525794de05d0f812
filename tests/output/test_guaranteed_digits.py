"""Digits that are printed: those of ``reference`` are right, times are as short as they can be."""

import json
import re
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

import polhode
from polhode.cli import main
from polhode.judging.reference_table import right_rows
from polhode.numbers.conversion import to_mpf
from polhode.numbers.decimals import decimal_string, shortest
from shared.results import result_of_kind, watched
from shared.tools import DOUBLE, EXTENDED, QUAD, exactly, mp, tiers


@pytest.mark.parametrize(
    ("name", "at"),
    [
        ("euler/dzhanibekov", None),  # it was 0.5 to 0.64 units off, as the next ones
        ("euler/fast-spin", None),
        ("kovalevskaya/type-e-ee", None),
        ("lagrange/planar-librating", None),  # noise of 1e-39 for zeros: off a pendulum's plane
        ("lagrange/planar-rotating", None),
        ("euler/separatrix", "400"),  # p falls like e^-lambda t: small, and no zero
    ],
)
def test_the_last_printed_digit_is_right(name, at, capsys):
    reference = polhode.reference(name)
    scene, digits = reference.scene, 20
    times = at or f"{scene.times[len(scene.times) // 2]},{scene.end}"
    assert main(["reference", name, "--at", times, "--digits", str(digits), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    columns = answer["columns"]
    finer = reference.at([Fraction(t) for t in columns["t"]], digits + 80)
    states = zip(*(columns[name] for name in scene.columns), strict=True)
    for row, true in zip(states, finer, strict=True):
        for text, x in zip(row, true, strict=True):
            printed, right = Decimal(text), exactly(x)
            if abs(right) < Fraction(10) ** -100:  # an exact zero
                assert text == "0"
                continue
            unit = Fraction(10) ** printed.as_tuple().exponent
            assert abs(Fraction(printed) - right) <= Fraction(501, 1000) * unit


def test_an_answer_right_to_what_was_asked_and_no_more_is_printed_right():
    """A ten-thousandth of the last place beside the half that rounding takes."""
    third = Fraction(1, 3)

    def ask(times, digits):
        return [[to_mpf(third + Fraction(1, 10**digits), 200)] for _ in times]

    ((text,),) = right_rows(ask, [Fraction(1)], 20)
    assert 0 < exactly(text) - third < Fraction(11, 10**25)


# -- times of files: of doubles as short as they round-trip ----------------------------------------

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
    # more bits than the file's change no time of it
    for how in ({}, {"number": "mp", "digits": 26}):
        assert polhode.compare(path, SCENE, **how).subject.times == run.times


@pytest.mark.slow
@pytest.mark.parametrize("number", ["extended"])
def test_without_its_json_a_right_file_is_not_blamed(tmp_path, number):
    """Its digits tell the type that its numbers are of."""
    path = tmp_path / "x.csv"
    command = ["run", SCENE, "--number", number, "--at", "0.1,1/3,500.7", "-o", str(path)]
    assert main(command) == 0
    with_it = polhode.compare(path, SCENE)
    (tmp_path / "x.csv.json").unlink()
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


# -- times of events, and certificates ------------------------------------------------------------


@pytest.mark.parametrize(("number", "printed"), [("double", 17), ("extended", 21), ("quad", 36)])
def test_times_of_events_have_the_digits_of_their_type_wherever_they_are_printed(
    number, printed, tmp_path, capsys
):
    scene = tmp_path / "scene.toml"
    scene.write_text(polhode.as_toml(watched().at((10,))))
    command = ["run", str(scene), "--number", number]
    assert main([*command, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    first = answer["events"]["t"][0]
    assert main(command) == 0
    said = capsys.readouterr().err
    time = re.search(r"at t = ([0-9.]+)", said)[1]
    assert len(time) == printed + 1 + (time[0] == "0")  # and the point
    assert abs(Fraction(time) - Fraction(first)) <= Fraction(1, 2 * 10**printed)
    run = polhode.integrate(str(scene), number)
    assert repr(run.events[0]).endswith(f"the first at t = {time}>")


def test_a_certificate_is_no_result_and_says_what_it_is(tmp_path):
    path = tmp_path / "proof.json"
    result_of_kind("Enclosure").save(path)
    with pytest.raises(polhode.BadInput, match=r"certificate, which polhode\.verify checks"):
        polhode.load_result(path)
