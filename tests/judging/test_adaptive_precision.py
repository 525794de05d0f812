"""Digits asked for are digits had; what a plain run is expected to have is told."""

import json
import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import pytest

import polhode
from polhode import Outcome, cli
from polhode.judging import digit_check
from polhode.judging.digit_check import checked
from shared.motions import light_pendulum
from shared.tools import DOUBLE, mp, tiers

MOST = DOUBLE.most_digits


@pytest.mark.slow
def test_digits_of_a_chaotic_motion_are_had():
    """Before: 36 digits printed, none of them right."""
    options = {"digits": 15, "at": [100], "method": "taylor"}
    run = polhode.integrate("general/asymmetric-chaotic", **options, prove=True)
    assert run.outcome is Outcome.REACHED_END
    assert run.checked_by == "proof"
    true = polhode.integrate(run.scene, mp(70)).states
    (error,) = polhode.state_errors(run.states, true, run.scene)
    # a bound: the balls of a proof for 15 digits are wider than the run's error
    assert 15 <= run.correct_digits < 15 + 8
    assert run.correct_digits <= -math.log10(error)


@pytest.mark.slow
def test_one_run_suffices_where_all_digits_of_its_type_are_lost():
    """At a late time it was told to ask for more (extended), and then again."""
    run = polhode.integrate("euler/separatrix", digits=15, at=[300])
    assert (run.outcome, run.checked_by) == (Outcome.REACHED_END, "closed form")
    assert 15 <= run.correct_digits < 15 + 8


def test_where_the_digits_cannot_be_had_the_exit_code_is_3(capsys):
    tight = ["--digits", "15", "--number", "extended", "--at", "20,400"]
    assert cli.main(["run", "euler/separatrix", *tight, "--json"]) == 3
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert answer["outcome"] == "too few digits"
    assert 0 <= answer["correct_digits"] < 1
    assert f"15 digits were asked for, {answer['correct_digits']} are right" in err


@pytest.mark.slow
def test_a_motion_beyond_computation_is_refused_in_seconds():
    run = polhode.integrate("general/asymmetric-chaotic", digits=15, at=[30_000])
    assert run.outcome is Outcome.TOO_FEW_DIGITS
    assert run.number.name == "double"
    assert (run.correct_digits, run.checked_by) == (0.0, "expected error")


@pytest.mark.parametrize(
    ("name", "at", "warned"),
    [("euler/separatrix", "30,400", True), ("kovalevskaya/generic", "2,20", False)],
)
def test_a_plain_run_says_from_when_on_no_digit_is_left(capsys, name, at, warned):
    """Before: 17 digits, none right, and not a word."""
    assert cli.main(["run", name, "--at", at, "--json"]) == 0
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert ("printed digits are expected to be correct" in err) == warned
    assert ("and none from t = 10" in err) == warned
    if warned:  # kappa·eps reaches 1 at t = 100
        assert answer["digits_expected"] == 0
        assert 80 < answer["lost_after"] < 120
    else:
        assert 12.5 < answer["digits_expected"] < MOST
        assert answer["lost_after"] is None


@pytest.mark.parametrize(
    "name",
    tiers(
        ["euler/separatrix", "kovalevskaya/generic", "hard/near-homoclinic"],
        ["euler/near-separatrix", "lagrange/nutation"],
    ),
)
def test_what_is_expected_is_what_is_had(name):
    """Within a digit and a half: one tangent, and roundings at random."""
    run = polhode.integrate(name, project=False, method="taylor")
    had = polhode.compare(run).digits[-1]
    assert -0.5 < had - run.expected.digits[-1] < 1.5


@pytest.mark.parametrize(
    ("name", "end"),
    tiers([("euler/long", 1000)], [("lagrange/nutation", 1000), ("euler/long", 10000)]),
)
def test_a_run_kept_on_its_torus_is_expected_to_lose_less(name, end):
    """Not the 3/2 power of the time, by which half of the digits would be gone at 240 000."""
    run = polhode.integrate(name, at=[end])
    assert run.projection.count > 0
    assert -0.8 < polhode.compare(run).digits[-1] - run.expected.digits[-1] < 1.9
    bare = polhode.integrate(name, at=[end], project=False)
    assert run.expected.digits[-1] > bare.expected.digits[-1] + (0.3 if end == 1000 else 1.0)


def test_half_of_the_digits_are_told_to_be_gone_where_they_are():
    """A state that stands still loses none."""
    said = polhode.integrate("euler/separatrix", at=[400]).expected
    assert said.halved_after < said.lost_after < 400
    (left,) = polhode.integrate("euler/separatrix", at=[said.halved_after]).expected.digits
    assert abs(left - MOST / 2) < 0.5
    assert min(polhode.integrate("euler/rest").expected.digits) == MOST


@pytest.mark.slow
def test_digits_are_told_where_no_double_holds_the_time():
    """A pendulum so light that 1e340 is the beginning of its first swing."""
    light = light_pendulum("1e-700", end="1e340")
    assert 14 < polhode.integrate(light).expected.digits[-1] < 16
    assert 10 <= polhode.integrate(light, digits=10).correct_digits < 150  # by runs made again
    spun = replace(light, omega=(Fraction(0), Fraction(0), Fraction(1)))
    with pytest.raises(polhode.BadInput, match=r"number = double: expected a type of wider range"):
        polhode.integrate(spun, digits=10)


# -- Three ways to check the digits of a run: they agree with each other and with the truth

#: What a run is told to be checked by, and what checks it.
WAYS = [(None, "closed form"), (True, "proof"), (False, "second run")]


def scene(proved: bool | None) -> polhode.Scene:
    """A motion with a closed form, which is not used where another way is wanted."""
    top = polhode.load("kovalevskaya/generic").at([5, 40])
    return top if proved is None else replace(top, reference="certified")


@pytest.mark.parametrize(
    ("method", "proved", "by"),
    tiers(
        [("taylor", None, "closed form"), ("refined", True, "proof")],
        [("refined", None, "closed form"), ("taylor", False, "second run")],
    ),
)
def test_the_digits_are_those_against_the_closed_form(method, proved, by):
    run = polhode.integrate(scene(proved), digits=28, method=method, prove=proved)
    assert run.checked_by == by
    assert 28 <= run.correct_digits < 28 + 8
    true = polhode.compare(replace(run, scene=scene(None))).worst
    if proved:  # no more than are right, and hardly more than were wanted
        assert 28 <= run.correct_digits <= true
        assert run.correct_digits < 28 + 6
    else:
        assert abs(run.correct_digits - true) < 0.01


@pytest.mark.parametrize(("proved", "by"), WAYS)
@pytest.mark.parametrize("off", ["1e-9", "1e-21"])
def test_a_run_that_is_off_is_noticed(off, proved, by):
    run = polhode.integrate(scene(proved), "quad")
    *rest, (p, *others) = run.states
    with mpmath.workdps(40):
        p += mpmath.mpf(off)
    checked_run = checked(replace(run, states=[*rest, [p, *others]]), 28, proved)
    assert checked_run.checked_by == by
    assert abs(checked_run.correct_digits + float(off[2:])) < 1.0


def test_what_cannot_be_proved_or_is_interrupted_is_not_said_to_be_right(monkeypatch):
    run = polhode.integrate("general/asymmetric-chaotic", "quad", at=[3])
    assert checked(run, 28, True).correct_digits > 28
    monkeypatch.setattr(digit_check, "MOST_SECONDS", 1e-6)
    checked_run = checked(run, 28, True)
    assert (checked_run.checked_by, checked_run.correct_digits) == ("proof, which failed", 0.0)
    run = polhode.integrate(scene(False), "quad")
    stopped = replace(run, outcome=Outcome.INTERRUPTED)
    monkeypatch.setattr(digit_check, "solve", lambda *_: stopped)
    assert checked(run, 28, False).outcome is Outcome.INTERRUPTED


def test_digits_are_checked_only_where_they_are_asked_for(capsys):
    with pytest.raises(polhode.BadInput, match="prove = True: expected digits"):
        polhode.integrate("euler/sphere", prove=True)
    assert cli.main(["run", "euler/sphere", "--no-prove"]) == 2
    capsys.readouterr()
    words = ["run", "general/asymmetric-regular", "--digits", "20", "--at", "3", "--prove"]
    assert cli.main(words) == 0
    assert "are right by the proof" in capsys.readouterr().err
