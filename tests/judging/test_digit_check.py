"""Three ways to check the digits of a run: they agree with each other and with the truth."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import pytest

import polhode
from polhode import cli
from polhode.judging import digit_check
from polhode.judging.digit_check import checked
from polhode.motion.outcomes import Outcome

#: What a run is told to be checked by, and what checks it.
WAYS = [(None, "closed form"), (True, "proof"), (False, "second run")]


def scene(proved: bool | None) -> polhode.Scene:
    """A motion with a closed form, which is not used where another way is wanted."""
    top = polhode.load("kovalevskaya/generic").at([5, 40])
    return top if proved is None else replace(top, reference="certified")


@pytest.mark.sample(2, slow=2)
@pytest.mark.parametrize("method", ["taylor", "refined"])
@pytest.mark.parametrize(("proved", "by"), WAYS)
def test_the_digits_are_those_against_the_closed_form(method, proved, by):
    run = polhode.integrate(scene(proved), digits=28, method=method, prove=proved)
    assert run.checked_by == by
    assert 28 <= run.correct_digits < 28 + 8
    true = checked(replace(run, scene=scene(None)), 28)
    assert true.checked_by == "closed form"
    if proved:  # no more than are right, and hardly more than were wanted
        assert 28 <= run.correct_digits <= true.correct_digits
        assert run.correct_digits < 28 + 6
    else:
        assert abs(run.correct_digits - true.correct_digits) < 0.01


@pytest.mark.parametrize(("proved", "by"), WAYS)
@pytest.mark.parametrize("off", ["1e-9", "1e-21"])
def test_a_run_that_is_off_is_noticed(off, proved, by):
    run = polhode.integrate(scene(proved), "quad")
    *rest, (p, *others) = run.states
    with mpmath.workdps(40):
        p += mpmath.mpf(off)
    found = checked(replace(run, states=[*rest, [p, *others]]), 28, proved)
    assert found.checked_by == by
    assert abs(found.correct_digits + float(off[2:])) < 1.0


def test_what_cannot_be_proved_is_not_said_to_be_right(monkeypatch):
    run = polhode.integrate("general/asymmetric-chaotic", "quad", at=[3])
    assert checked(run, 28, True).correct_digits > 28
    monkeypatch.setattr(digit_check, "MOST_SECONDS", 1e-6)
    found = checked(run, 28, True)
    assert (found.checked_by, found.correct_digits) == ("proof, which failed", 0.0)


def test_digits_are_checked_only_where_they_are_asked_for(capsys):
    with pytest.raises(polhode.BadInput, match="prove = True: expected digits"):
        polhode.integrate("euler/sphere", prove=True)
    assert cli.main(["run", "euler/sphere", "--no-prove"]) == 2
    capsys.readouterr()
    assert (
        cli.main(["run", "general/asymmetric-regular", "--digits", "20", "--at", "3", "--prove"])
        == 0
    )
    assert "are right by the proof" in capsys.readouterr().err


def test_an_interrupted_check_is_an_interrupted_run(monkeypatch):
    run = polhode.integrate(scene(False), "quad")
    stopped = replace(run, outcome=Outcome.INTERRUPTED)
    monkeypatch.setattr(digit_check, "solve", lambda *_: stopped)
    assert checked(run, 28, False).outcome is Outcome.INTERRUPTED
