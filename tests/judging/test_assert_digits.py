"""Assertions of correct digits, as other programs' tests use them."""

from __future__ import annotations

import pytest

import polhode
from polhode import cli

SCENE = "lagrange/nutation"


@pytest.fixture(scope="module")
def run():
    return polhode.integrate(SCENE)


@pytest.mark.slow
def test_what_has_the_digits_passes_whatever_it_is(run, tmp_path):
    path = tmp_path / "x.csv"
    assert cli.main(["run", SCENE, "-o", str(path)]) == 0
    columns = {"t": run.t, **{n: run.states[:, k] for k, n in enumerate(run.columns)}}
    digits = polhode.compare(run).worst
    for mine in (run, path, str(path), columns):
        assert polhode.testing.assert_digits(mine, SCENE, at_least=12).worst >= min(12, digits)
    found = polhode.testing.assert_digits(lambda t: run(t), SCENE, at_least=12, at=[1, "0.25"])
    assert [float(t) for t in found.times] == [1, 0.25]


def test_the_error_tells_the_first_wrong_time_and_the_judgement(run):
    def mine(t):
        return run(t) + (1e-6 if t > 1.5 else 0)

    with pytest.raises(AssertionError) as error:
        polhode.testing.assert_digits(mine, SCENE, at_least=9, at=[1, 2, 3])
    first, *rest = str(error.value).splitlines()
    assert first == "6.00 correct digits at t = 2, where at least 9 are wanted"
    assert "\n".join(rest).startswith("states against lagrange of lagrange/nutation")
    assert "limited by more than rounding" in str(error.value)


def test_another_convention_is_wrong_unless_it_is_allowed(run):
    columns = {"t": run.t, **{n: run.states[:, k] for k, n in enumerate(run.columns)}}
    columns |= {"p": columns["q"], "q": columns["p"]}
    with pytest.raises(AssertionError, match="correct digits at t = "):
        polhode.testing.assert_digits(columns, SCENE, at_least=9)
    found = polhode.testing.assert_digits(columns, SCENE, at_least=9, as_it_stands=False)
    assert found.reading == "omega p q r = q p r"


@pytest.mark.parametrize("digits", ["12", float("nan")])
def test_digits_that_are_no_number_are_refused_in_one_line(run, digits):
    with pytest.raises(polhode.BadInput, match=r"^assert_digits: at_least = .* a number of digits"):
        polhode.testing.assert_digits(run, SCENE, at_least=digits)
