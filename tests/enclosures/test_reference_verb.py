"""``polhode reference --certified``: only proven digits are printed."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest

import polhode
from polhode import cli
from polhode.enclosures.result import rounded_up
from polhode.numbers.convert import exactly

CASE = "kovalevskaya/generic"


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = cli.main(arguments)
    out, err = capsys.readouterr()
    return code, out, err


def test_every_printed_digit_is_that_of_the_closed_form(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "reference", CASE, "--at", "1,30", "--digits", "25", "--certified")
    assert code == 0
    rows = [line.split() for line in out.splitlines()[1:]]
    exact = polhode.reference(CASE).at([1, 30], digits=60)
    for row, true in zip(rows, exact, strict=True):
        for text, x in zip(row[1:], true, strict=True):
            places = len(text.partition(".")[2])
            assert places >= 24  # the 25th may have a tie in its ball
            assert round(exactly(x) * 10**places) == Fraction(text) * 10**places
    assert "every digit is proven" in err


def test_json_has_balls_that_hold_the_truth(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ("--at", "-2,-7", "--digits", "18", "--certified", "--json")
    code, out, _ = run(capsys, "reference", CASE, *arguments)
    answer = json.loads(out)
    assert code == 0
    assert answer["proven"] is True
    assert answer["reference"] == "certified"
    assert min(answer["digits_proven"]) >= 18
    exact = polhode.reference(CASE).at([-2, -7], digits=60)
    for middles, radii, true in zip(answer["midpoints"], answer["radii"], exact, strict=True):
        for middle, radius, x in zip(middles, radii, true, strict=True):
            assert abs(Fraction(middle) - exactly(x)) <= Fraction(radius)
            assert Fraction(radius) < Fraction(1, 10**17)
    assert all(float(error) <= 1e-18 for error in answer["error"])


def test_more_digits_than_can_be_proven_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "reference", CASE, "--at", "1", "--digits", "400", "--certified")
    assert code == 2
    assert out == ""
    assert "digits = 400: expected 1 to 250" in err


def test_a_radius_is_rounded_up_and_never_down() -> None:
    for value in (1.0, 1.23456e-20, 9.99999e-7, 3.3333e-300):
        assert float(rounded_up([value])[0]) >= value
