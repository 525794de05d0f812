"""Any scene in any form: the same states, angles, events; and singular sets as outcomes."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import cli
from polhode.equations.form import equations, source
from polhode.judging.correct_digits import worst_digits
from polhode.motion.outcomes import Outcome
from polhode.numbers import conversion, number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.mpmath_context import mpmath
from polhode.scenes.body import Body
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import FORMS
from polhode.taylor.integrator.singularities import nearest
from shared.form_trials import turned
from shared.motions import ASYMMETRIC, asymmetric, in_other_units, same_bits
from shared.policies import change_policy

F = Fraction
OTHERS = [name for name in FORMS if name != "principal"]
IN_ANGLES = ("lagrangian", "hamiltonian", "routhian")
TURNED = asymmetric(psi=F(1, 3))
TURN = [[F(2, 3), F(-2, 3), F(1, 3)], [F(1, 3), F(2, 3), F(2, 3)], [F(-2, 3), F(-1, 3), F(2, 3)]]


def irrational() -> Scene:
    """A full inertia matrix with irrational principal moments and axes, a regular motion."""
    body = Body(((3, F(1, 2), F(1, 4)), (F(1, 2), 4, F(1, 8)), (F(1, 4), F(1, 8), 5)), (1, 2, 4), 1)
    return Scene(body, (F(1, 10), F(1, 5), 3), (F(2, 7), F(3, 7), F(6, 7)))


MOTIONS = {"irrational": irrational, "asymmetric": lambda: TURNED}


@pytest.fixture(scope="module")
def trusted() -> dict[str, polhode.Trajectory]:
    return {
        name: polhode.integrate(make(), digits=40, at=[5, 10]) for name, make in MOTIONS.items()
    }


def same(one: polhode.Trajectory, other: polhode.Trajectory) -> float:
    """The digits to which two runs agree."""
    return worst_digits(one.states, other.states, other.scene, other.number.most_digits)


@pytest.mark.sample(3, slow=6)
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", OTHERS)
def test_every_form_gives_38_of_40_digits_at_t_10(name, motion, trusted):
    run = polhode.integrate(replace(MOTIONS[motion](), form=name), digits=40, at=[5, 10])
    assert run.outcome is Outcome.REACHED_END
    assert run.number == trusted[motion].number
    assert 38 <= same(run, trusted[motion]) < 46


@pytest.mark.slow
@pytest.mark.sample(3, rest="campaign")
@pytest.mark.parametrize(
    "case",
    [
        *("euler/turned-axes", "lagrange/nutation", "lagrange/second-axis", "kovalevskaya/generic"),
        *("kovalevskaya/irrational-centre", "general/asymmetric-regular", "lagrange/turned-axes"),
    ],
)
def test_every_form_gives_38_of_40_digits_in_the_library(case):
    scene = replace(polhode.load(case), outputs=(), events=())
    first = polhode.integrate(scene, digits=40, at=[10])
    told = []
    for name in OTHERS:
        try:
            run = polhode.integrate(replace(scene, form=name), digits=40, at=[10])
        except polhode.BadInput as refusal:
            told.append((name, str(refusal)))
            continue
        assert run.outcome.done, name
        assert same(run, first) >= 38, name
    refused = {"omega-only", "momentum-only"} if scene.body.torque_free else set()
    assert {name for name, _ in told} == refused
    assert all("has no moment" in text for _, text in told)


@pytest.mark.sample(5)
@pytest.mark.parametrize("name", OTHERS)
def test_backward_runs_agree(name):
    one = polhode.integrate(replace(TURNED, form=name), "quad", at=[-3])
    assert 31 <= same(one, polhode.integrate(TURNED, "quad", at=[-3])) <= 34.1


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("number", ["double", "extended"])
@pytest.mark.parametrize("name", ["momentum", "lagrangian", "omega-only"])
def test_states_are_read_out_in_more_precision_than_the_run_has(name, number):
    """At t = 0 nothing but reading out happens: half an ulp of each type, times what it costs."""
    scene = replace(irrational(), form=name)
    run = polhode.integrate(scene, number, at=[0, F(1, 10**6)])
    form = equations(scene)
    with mpmath.workprec(200):
        # the rounded variables at t = 0, read out exactly
        k = {key: conversion.to_mpf(x, 200) for key, x in form.coefficients.items()}
        values = [conversion.to_mpf(run.number.rounded(x), 200) for x in form.start]
        from shared.form_trials import state

        wanted = state(form, values, k)
        for x, y in zip(run.states[0], wanted, strict=True):
            error = abs(conversion.to_mpf(exactly(x), 200) - y)
            assert error <= float(run.number.eps) * (abs(y) * 0.501 + 1e-3)


def test_the_general_form_of_a_body_turned_rationally_gives_the_turned_states():
    scene = TURNED
    rows = scene.body.inertia
    half = [[sum(TURN[i][m] * rows[m][j] for m in range(3)) for j in range(3)] for i in range(3)]
    inertia = [[sum(half[i][m] * TURN[j][m] for m in range(3)) for j in range(3)] for i in range(3)]
    other = Scene(
        Body(tuple(map(tuple, inertia)), turned(TURN, scene.body.centre), 1),
        turned(TURN, scene.omega),
        turned(TURN, scene.gamma),
        form="general",
    )
    runs = [
        polhode.integrate(s, digits=40, at=[10]) for s in (replace(scene, form="general"), other)
    ]
    with mpmath.workprec(200):
        row = [conversion.to_mpf(exactly(x), 200) for x in runs[0].states[0]]
        spun = [[mpmath.mpf(x.numerator) / x.denominator for x in line] for line in TURN]
        expected = [*turned(spun, row[:3]), *turned(spun, row[3:])]
        worst = max(abs(a - b) for a, b in zip(expected, runs[1].states[0], strict=True))
    assert 0 < worst < 1e-39


@pytest.mark.sample(3, slow=5)
@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("exponent", [-40, 7])
def test_scaling_by_powers_of_two_changes_no_bit(name, exponent):
    scene = replace(irrational(), form=name).at((F(1), F(4)))
    other = in_other_units(scene, exponent)
    assert same_bits(polhode.integrate(scene), polhode.integrate(other), exponent)


@pytest.mark.sample(1, slow=4)
@pytest.mark.parametrize("name", OTHERS)
def test_angles_attitude_and_events_are_those_of_the_principal_form(name):
    events = (
        *(Event("nutation"), Event("flip"), Event("high", "gamma3 - 4/5", "rising")),
        Event("late", "p*gamma1 + t - 2"),
    )
    scene = replace(irrational(), outputs=("angles", "attitude"), events=events)
    one, two = (
        polhode.integrate(replace(scene, form=f), "quad", at=[3]) for f in ("principal", name)
    )
    for column in ("angles", "attitude"):
        pairs = zip(getattr(one, column)[0], getattr(two, column)[0], strict=True)
        assert max(abs(a - b) for a, b in pairs) < 1e-31
    assert sum(len(e.times) for e in one.events) >= 3
    for mine, theirs in zip(one.events, two.events, strict=True):
        assert len(mine.times) == len(theirs.times)
        assert all(abs(a - b) < 1e-31 for a, b in zip(mine.times, theirs.times, strict=True))
        for a, b in zip(mine.states, theirs.states, strict=True):
            assert max(abs(x - y) for x, y in zip(a, b, strict=True)) < 1e-30


# -- singular sets ----------------------------------------------------------------------------


def swinging_over(form: str) -> Scene:
    """A pendulum that turns over: its third axis passes the vertical exactly."""
    body = Body.of_moments(ASYMMETRIC.moments, (0, 0, 1), 1)
    return Scene(body, (3, 0, 0), (0, F(3, 5), F(4, 5)), form=form)


@pytest.mark.sample(1, first=2)
@pytest.mark.parametrize("number", ["double", "quad"])
@pytest.mark.parametrize("name", IN_ANGLES)
def test_a_pole_passed_is_an_outcome_that_names_the_form_to_use_instead(name, number):
    """The rows before it are right, and nothing after it is given."""
    times = [F(k, 10) for k in range(1, 31)]
    run = polhode.integrate(swinging_over(name), number, at=times)
    whole = polhode.integrate(swinging_over("principal"), number, at=times)
    assert run.outcome is Outcome.SINGULAR
    assert not run.outcome.done
    assert name in run.cause
    assert "--form principal" in run.advice
    assert 0 < len(run.states) < len(times)
    assert run.times[-1] <= run.reached < run.times[-1] + F(1, 10)
    part = replace(whole, states=whole.states[: len(run.states)], times=run.times)
    lost = run.number.most_digits - same(run, part)
    assert lost < run.number.most_digits / 4 + 1.5


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", ["omega-only", "momentum-only"])
def test_a_momentum_that_comes_to_lie_along_the_centre_is_an_outcome(name):
    """Iw starts across r0 and is turned onto it by the weight: w along r0 is hit exactly."""
    body = Body.of_moments((1, 1, 1), (0, 0, 1), 1)
    scene = Scene(body, (0, 1, 1), (0, F(3, 5), F(4, 5)))  # G' = gamma x r0 = (3/5, 0, 0)
    away = polhode.integrate(replace(scene, form=name), at=[3])
    assert away.outcome.done  # passes by at a distance
    body = Body.of_moments((2, 2, 1), (0, 0, 1), 1)
    swing = Scene(body, (F(1, 2), 0, 0), (0, F(3, 5), F(-4, 5)))  # p = 0 at each turning point
    run = polhode.integrate(replace(swing, form=name), at=[10])
    assert run.outcome is Outcome.SINGULAR
    assert name in run.cause


def test_a_start_too_near_for_a_type_is_an_outcome_and_a_wider_type_runs():
    tiny = F(1, 10**5)
    side = 2 * tiny / (1 + tiny**2)
    scene = replace(TURNED, gamma=(side, 0, (1 - tiny**2) / (1 + tiny**2)))
    for name in IN_ANGLES:
        near = replace(scene, form=name)
        run = polhode.integrate(near, at=[1])
        assert run.outcome is Outcome.SINGULAR
        assert run.steps == 0
        assert len(run.states) == 0
        assert polhode.integrate(near, "quad", at=[1]).outcome.done


def test_the_nearest_distance_is_the_square_root_of_eps():
    for number in (number_types.DOUBLE, number_types.QUAD, number_types.mp(50)):
        assert F(1, 2) <= nearest(number) ** 2 / number.eps <= 2


def test_forms_on_the_command_line(capsys, tmp_path):
    file = tmp_path / "over.toml"
    file.write_text(
        'schema = 1\n[body]\nmoments = [2, "3/2", 1]\ncentre = [0, 0, 1]\nweight = 1\n'
        '[start]\nomega = [3, 0, 0]\ngamma = [0, "3/5", "4/5"]\n'
        '[run]\nend = 3\nsamples = 4\nform = "hamiltonian"\n'
    )
    assert cli.main(["run", str(file), "--json"]) == 3
    out, err = capsys.readouterr()
    assert json.loads(out)["outcome"] == "singular set"
    assert "the form hamiltonian met its singular set; use --form principal" in err
    assert cli.main(["run", str(file), "--form", "momentum", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["form"], found["outcome"]) == ("momentum", "reached end")
    assert cli.main(["show", str(file), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown["form"], shown["source"]) == ("hamiltonian", source("hamiltonian"))
    assert shown["variables"][1] == "nutation"
    assert cli.main(["run", str(file), "--form", "momentums"]) == 2
    assert "did you mean 'momentum'" in capsys.readouterr().err
    assert cli.main(["run", "euler/sphere", "--form", "omega-only"]) == 2
    assert "the weight has no moment" in capsys.readouterr().err


# -- the regression's cross-checks ------------------------------------------------------------


@pytest.mark.slow
def test_a_wrong_equation_in_one_form_fails_the_cross_checks(monkeypatch):
    from polhode.checks import form_cross_checks
    from polhode.equations.forms import matrices

    honest = matrices.across
    monkeypatch.setattr(form_cross_checks, "SCENES", ("kovalevskaya/generic",))
    monkeypatch.setattr(form_cross_checks, "FORMS", ("principal", "momentum", "hamiltonian"))
    assert [c.passed for c in form_cross_checks.cross_checks()] == [True, True]

    def corrupted(vector):
        return tuple(tuple(x * (1 + F(1, 10**36)) for x in row) for row in honest(vector))

    monkeypatch.setattr(matrices, "across", corrupted)
    assert [c.passed for c in form_cross_checks.cross_checks()] == [False, True]


@pytest.mark.slow
def test_every_cross_check_passes(capsys):
    assert cli.main(["check", "--forms", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["cases"] == []
    assert len(found["forms"]) == 3 * (len(FORMS) - 1)
    assert {c["form"] for c in found["forms"] if c["digits"] is None} == {
        "omega-only",
        "momentum-only",
    }


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["quaternion", "hamiltonian", "momentum"])
def test_a_run_is_callable_between_its_times_in_any_form(name, monkeypatch):
    """The states of the output times again, and those between them, across corrections of |q|."""
    change_policy(monkeypatch, unit_norm_every=7)
    scene = replace(TURNED, form=name)
    run = polhode.integrate(scene, at=[5, 10])
    between = polhode.integrate(scene, "quad", at=[F(10, 3), 10]).states[0]
    assert np.max(np.abs(run(10) - run.states[1])) < 8e-16
    assert max(abs(a - b) for a, b in zip(run(F(10, 3)), between, strict=True)) < 2e-14
