"""Assertions of correct digits, as other programs' tests use them."""

from __future__ import annotations

import pytest

import polhode
from shared.tables import of_run

SCENE = "lagrange/nutation"


@pytest.fixture(scope="module")
def run():
    return polhode.integrate(SCENE)


def test_a_function_of_t_is_asked_at_the_times(run):
    found = polhode.testing.assert_digits(lambda t: run(t), SCENE, at_least=12, at=[1, "0.25"])
    assert [float(t) for t in found.times] == [1, 0.25]


def test_the_error_tells_the_first_wrong_time_and_the_judgement(run):
    def mine(t):
        return run(t) + (1e-6 if t > 1.5 else 0)

    with pytest.raises(AssertionError) as error:
        polhode.testing.assert_digits(mine, SCENE, at_least=9, at=[1, 2, 3])
    first, *rest = str(error.value).splitlines()
    assert first == "6.00 correct digits at t = 2, where at least 9 are wanted"
    assert "\n".join(rest).startswith("t  correct digits")
    assert "fewer than double precision allows" in str(error.value)


def test_another_convention_is_wrong_unless_it_is_allowed(run):
    columns = of_run(run)
    columns |= {"p": columns["q"], "q": columns["p"]}
    with pytest.raises(AssertionError, match="correct digits at t = "):
        polhode.testing.assert_digits(columns, SCENE, at_least=9)
    found = polhode.testing.assert_digits(columns, SCENE, at_least=9, as_it_stands=False)
    assert found.reading == "omega p q r = q p r"
