"""Every digit that ``reference`` prints is right to half a unit of its last place."""

from __future__ import annotations

import json
from decimal import Decimal
from fractions import Fraction

import pytest

import polhode
from polhode.cli import main
from polhode.judging.reference_rows import right_rows
from polhode.numbers.conversion import to_mpf
from shared.tools import exactly


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
