"""Any scene in any form: the same states, angles, events; and singular sets as outcomes."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import Body, Event, Outcome, Scene, cli
from polhode.checks import check_report
from polhode.equations.form import equations
from polhode.numbers import conversion
from polhode.numbers.mpmath_context import mpmath
from shared.form_trials import BITS, numbers, state
from shared.motions import asymmetric, in_other_units, same_bits
from shared.tools import FORMS, exactly, of_table, tiers

F = Fraction
OTHERS = [name for name in FORMS if name != "principal"]
IN_ANGLES = ("lagrangian", "hamiltonian", "routhian")
ALONE = ("omega-only", "momentum-only")
REGULAR = asymmetric(psi=F(1, 3))
#: A full inertia matrix with irrational principal moments and axes, a regular motion.
IRRATIONAL = Scene(
    Body(((3, F(1, 2), F(1, 4)), (F(1, 2), 4, F(1, 8)), (F(1, 4), F(1, 8), 5)), (1, 2, 4), 1),
    (F(1, 10), F(1, 5), 3),
    (F(2, 7), F(3, 7), F(6, 7)),
)


def digits_of(first: polhode.Trajectory, second: polhode.Trajectory) -> float:
    """The digits to which two runs agree."""
    pairs = zip(first.states.ravel().tolist(), second.states.ravel().tolist(), strict=True)
    off = max(float(abs(exactly(a) - exactly(b))) for a, b in pairs)
    return min(-np.log10(off), second.number.most_digits) if off else second.number.most_digits


@pytest.mark.parametrize(
    ("name", "exponent"),
    tiers(
        [("general", -40), ("routhian", -40), ("momentum", 7)],
        [("inertia-axes", -40), ("omega-only", -40), ("gyration-axes", 7)],
    ),
)
def test_scaling_by_powers_of_two_changes_no_bit(name, exponent):
    scene = replace(IRRATIONAL, form=name).at((F(1), F(4)))
    scaled = in_other_units(scene, exponent)
    assert same_bits(polhode.integrate(scene), polhode.integrate(scaled), exponent)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["general", "hamiltonian"])
def test_a_run_in_any_form_has_what_a_run_in_the_principal_form_has(name):
    """Angles, attitude, events, states in between; a start that is the scene's own."""
    events = (
        *(Event("nutation"), Event("flip"), Event("high", "gamma3 - 4/5", "rising")),
        Event("late", "p*gamma1 + t - 2"),
    )
    scene = replace(IRRATIONAL, outputs=("angles", "attitude"), events=events)
    first, second = (
        polhode.integrate(replace(scene, form=f), "quad", at=[0, 3], method="taylor")
        for f in ("principal", name)
    )
    for x, exact in zip(second.states[0], scene.start, strict=True):
        error = abs(exactly(x) - second.number.rounded(exact))
        assert error <= second.number.eps * (abs(exactly(x)) + F(1, 1000))
    for column in ("angles", "attitude"):
        pairs = zip(getattr(first, column)[1], getattr(second, column)[1], strict=True)
        assert max(abs(a - b) for a, b in pairs) < 1e-31
    assert sum(len(e.times) for e in first.events) >= 3
    for mine, theirs in zip(first.events, second.events, strict=True):
        assert len(mine.times) == len(theirs.times)
        assert all(abs(a - b) < 1e-31 for a, b in zip(mine.times, theirs.times, strict=True))
        for a, b in zip(mine.states, theirs.states, strict=True):
            assert max(abs(x - y) for x, y in zip(a, b, strict=True)) < 1e-30
    between = zip(first(F(10, 7)), second(F(10, 7)), strict=True)
    assert max(abs(x - y) for x, y in between) < 1e-31
    assert np.abs(np.array(second(3) - second.states[1], float)).max() < 1e-32


@pytest.mark.parametrize("name", tiers(["lagrangian"], ["hamiltonian"]))
def test_times_of_events_are_those_of_the_forms_own_motion(name):
    """Angles and rates are rounded where p q r are exact: each form has errors of its own, and its
    events move with them.  What is left is within their uncertainty."""
    scene = replace(REGULAR, events=(Event("e", "q"),), outputs=())
    true = polhode.integrate(scene, "quad", at=[20], method="taylor").events[0]
    run = polhode.integrate(replace(scene, form=name), at=[20], method="taylor", project=False)
    h = F(1, 2**20)
    beside = [t + x for t in true.times for x in (-h, h)]
    q = [exactly(row[1]) for row in polhode.integrate(scene, "quad", at=beside).states]
    event, moved = run.events[0], F(0)
    for k, (t, own) in enumerate(zip(true.times, event.times, strict=True)):
        slope = (q[2 * k + 1] - q[2 * k]) / (2 * h)
        error = exactly(run(t)[1]) / slope
        moved = max(moved, abs(own - t))
        assert abs(own - t + error) < event.uncertainty[k]
    assert moved > 20 * run.number.eps


@pytest.mark.parametrize("number", ["double", "extended"])
def test_states_are_read_out_in_more_precision_than_the_run_has(number):
    """At t = 0 nothing but reading out happens: half an ulp of each type, times what it costs."""
    scene = replace(IRRATIONAL, form="omega-only")
    run = polhode.integrate(scene, number, at=[0, F(1, 10**6)])
    with mpmath.workprec(BITS):
        form = equations(run.scene)
        values = [conversion.to_mpf(run.number.rounded(x), BITS) for x in form.start]
        for x, y in zip(run.states[0], state(form, values, numbers(form)[1]), strict=True):
            error = abs(conversion.to_mpf(exactly(x), BITS) - y)
            assert error <= float(run.number.eps) * (abs(y) * 0.501 + 1e-3)


# -- singular sets and refusals -------------------------------------------------------------------

UPRIGHT = replace(REGULAR, gamma=(0, 0, 1))
NO_GAMMA = Scene(Body.of_moments((3, 2, 1)), (1, 2, 3))
NO_LEVER = replace(REGULAR, body=Body.of_moments((3, 2, 2)))
NO_WEIGHT = replace(REGULAR, body=Body.of_moments((3, 2, 2), (1, 0, 0), 0))
ALONG = replace(REGULAR, omega=(F(3, 20), F(2, 15), F(1, 2)))  # I w = r0


@pytest.mark.parametrize(
    ("forms", "scene", "reason"),
    [
        (IN_ANGLES, UPRIGHT, r"principal: .*sin theta = 0"),
        (IN_ANGLES, NO_GAMMA, r"principal for a scene without start\.gamma"),
        (ALONE, NO_LEVER, "principal: the weight has no moment"),
        (ALONE, NO_WEIGHT, "principal: the weight has no moment"),
        (ALONE, replace(REGULAR, omega=(0, 0, 0)), "principal: .*is parallel to the centre r0"),
        (ALONE, ALONG, "principal: .*I w is parallel to the centre r0"),
        (("quaternion",), NO_GAMMA, ".*the attitude begins from it"),
    ],
)
def test_a_start_that_a_form_cannot_take_is_refused_with_the_form_to_use(forms, scene, reason):
    for name in forms:
        with pytest.raises(polhode.BadInput, match=f"form = {name}: expected {reason}"):
            polhode.integrate(replace(scene, form=name), at=[1])


@pytest.mark.parametrize("name", [x for x in OTHERS if x not in (*IN_ANGLES, *ALONE, "quaternion")])
def test_a_torque_free_scene_without_gamma_has_three_equations(name):
    scene = polhode.load("euler/no-gamma")
    run, trusted = (
        polhode.integrate(replace(scene, form=form), "quad", at=[5], method="taylor")
        for form in (name, "principal")
    )
    assert run.states.shape == (1, 3)
    assert 31 < digits_of(run, trusted) < 36


def passing(form: str, miss: F) -> Scene:
    """A symmetric top that rises from 53 degrees and passes the upper pole at about ``miss``.

    f - C r = miss, and the start has the kinetic energy to pass; 0: it meets the pole.
    """
    body, gamma = Body.of_moments((1, 1, F(1, 2)), (0, 0, 1), 1), (F(4, 5), 0, F(3, 5))
    p = (F(1, 2) * (1 - gamma[2]) + miss) / gamma[0]
    return Scene(body, omega=(p, 3, 1), gamma=gamma, form=form)


def swinging(form: str, _: F) -> Scene:
    """p = 0 at each turning point: the momentum lies along the centre, exactly or nearly so."""
    body = Body.of_moments((2, 2, 1), (0, 0, 1), 1)
    return Scene(body, (F(1, 2), 0, 0), (0, F(3, 5), F(-4, 5)), form=form)


MEETING = [(name, passing) for name in IN_ANGLES] + [(name, swinging) for name in ALONE]
SINGULAR = [(number, *row) for number in ("double", "quad") for row in MEETING]


@pytest.mark.parametrize(
    ("number", "name", "make"),
    of_table(SINGULAR, ("double", "lagrangian", passing), ("quad", "routhian", passing)),
)
def test_a_singular_set_met_is_an_outcome_that_names_the_form_to_use_instead(name, make, number):
    """The rows before it are right, and nothing after it is given."""
    times = [F(k, 6) for k in range(1, 61)]
    run = polhode.integrate(make(name, F(0)), number, at=times, method="taylor")
    whole = polhode.integrate(make("principal", F(0)), number, at=times, method="taylor")
    assert run.outcome is Outcome.SINGULAR
    assert name in run.cause
    assert run.advice == "use --form principal"
    assert 0 < len(run.states) < len(times)
    assert run.times[-1] <= run.reached < run.times[-1] + F(1, 6)
    part = replace(whole, states=whole.states[: len(run.states)], times=run.times)
    lost = run.number.most_digits - digits_of(run, part)
    assert lost < run.number.most_digits / 4 + 1.5


@pytest.mark.parametrize(("miss", "least"), [(F(1, 10), 13), (F(1, 1000), 11.5)])
@pytest.mark.parametrize("name", IN_ANGLES)
def test_a_pole_that_is_passed_costs_the_digits_of_the_miss(name, miss, least):
    """Routh's equations do without psi, and lose none of them."""
    run, true = (
        polhode.integrate(passing(form, miss), number, at=[1])
        for form, number in ((name, "double"), ("principal", "quad"))
    )
    assert run.outcome.done
    error = max(
        abs(float(exactly(a) - exactly(b))) for a, b in zip(*run.states, *true.states, strict=True)
    )
    assert (14 if name == "routhian" else least) < -np.log10(error) < 16.5


def test_a_start_too_near_for_a_type_is_an_outcome_and_a_wider_type_runs():
    tiny = F(1, 10**5)
    side = 2 * tiny / (1 + tiny**2)
    scene = replace(REGULAR, gamma=(side, 0, (1 - tiny**2) / (1 + tiny**2)))
    for name in IN_ANGLES:
        near = replace(scene, form=name)
        run = polhode.integrate(near, at=[1])
        assert run.outcome is Outcome.SINGULAR
        assert (run.steps, len(run.states)) == (0, 0)
        assert polhode.integrate(near, "quad", at=[1]).outcome.done


def test_the_norm_of_the_quaternion_is_held_by_corrections_that_are_reported():
    scene = replace(polhode.load("kovalevskaya/generic"), form="quaternion", outputs=())
    run = polhode.integrate(scene, at=[2000])
    corrections, eps = run.projection, float(run.number.eps)
    assert corrections.onto == ("|q|",)
    assert corrections.count == run.steps // corrections.every
    assert eps / 4 < corrections.largest < 100 * eps
    assert corrections.largest <= corrections.sum <= corrections.count * corrections.largest
    assert "|q|" not in polhode.integrate(replace(scene, form="principal"), at=[20]).projection.onto
    off = np.abs(run(1234) - polhode.integrate(scene, at=[1234, 2000]).states[0]).max()
    assert off < 1e-14  # dense output makes the same corrections


# -- the command line -----------------------------------------------------------------------------


def test_forms_on_the_command_line(capsys, tmp_path, refusal):
    (tmp_path / "over.toml").write_text(polhode.as_toml(passing("hamiltonian", F(0)).at([1, 2, 3])))

    def output(*arguments, code=0):
        assert cli.main([*arguments, "--json"]) == code
        out, err = capsys.readouterr()
        return json.loads(out), err

    answer, err = output("run", "over.toml", code=3)
    assert answer["outcome"] == "singular set"
    assert "the form hamiltonian met its singular set; use --form principal" in err
    answer, _ = output("run", "over.toml", "--form", "momentum")
    assert (answer["form"], answer["outcome"]) == ("momentum", "reached end")
    answer, _ = output("show", "over.toml")
    assert (answer["form"], answer["variables"][1]) == ("hamiltonian", "nutation")
    assert answer["source"].startswith("3.47")
    assert "weight has no moment" in refusal("run", "euler/sphere", "--form", "omega-only")


@pytest.mark.slow
def test_a_wrong_equation_in_one_form_fails_the_cross_checks(monkeypatch):
    from polhode.equations.forms import matrices

    honest = matrices.across

    def corrupted(vector):
        return tuple(tuple(x * (1 + F(1, 10**28)) for x in row) for row in honest(vector))

    monkeypatch.setattr(check_report, "SCENES", ("kovalevskaya/generic",))
    monkeypatch.setattr(check_report, "FORMS", ("principal", "momentum", "hamiltonian"))
    monkeypatch.setattr(matrices, "across", corrupted)
    assert [c.passed for c in check_report.cross_checks(lambda _: None)] == [False, True]


@pytest.mark.slow
def test_every_cross_check_passes(monkeypatch, capsys):
    """Of one scene, a free body in turned axes; ``polhode check --forms`` takes three."""
    monkeypatch.setattr("polhode.checks.check_report.SCENES", ("euler/turned-axes",))
    assert cli.main(["check", "--forms", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["columns"]["scene"] == []
    forms, digits = answer["forms"]["form"], answer["forms"]["digits"]
    assert len(forms) == len(FORMS) - 1
    assert {form for form, x in zip(forms, digits, strict=True) if x is None} == {*ALONE}
