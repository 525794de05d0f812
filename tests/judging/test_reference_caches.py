"""What a reference keeps: a proof to more digits serves a question for fewer."""

from __future__ import annotations

import pytest

import polhode


@pytest.mark.parametrize("word", ["at", "attitude"])
def test_a_proof_to_more_digits_is_not_made_again(word: str) -> None:
    proven = polhode.Certified(polhode.load("general/asymmetric-regular"))
    ask = getattr(proven, word)
    rows, agreement = ask([1], 30), proven.agreement
    assert 30 <= agreement < 45
    assert ask([1], 20) == rows  # a proof to 20 digits has other midpoints
    assert proven.agreement == agreement
    assert ask([1], 50) != rows
    assert proven.agreement >= 50
    assert ask([2], 20) != rows


def test_a_time_may_be_irrational() -> None:
    proven = polhode.Certified(polhode.load("euler/largest-axis"))
    exact = polhode.reference("euler/largest-axis").at(["sqrt(2)"], 30)
    rows = proven.at(["sqrt(2)"], 20)
    assert max(abs(x - y) for x, y in zip(rows[0], exact[0], strict=True)) < 1e-19
    assert proven.at(["sqrt(2)"], 20) == rows
