"""Runs by refinement as ``integrate`` hands them out: choice, errors, fallback, dense output."""

import json
import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
import polhode.verbs.run as run_verb
from polhode.cli import main
from polhode.common.errors import BadInput
from polhode.motion.outcomes import Outcome
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.refined import refinement as refined_motion
from polhode.refined import self_test
from polhode.refined.errors import Stalled
from polhode.refined.refinement import refine
from polhode.runs.methods import refined as refined_method
from polhode.runs.methods.refined_motion import RefinedMotion
from polhode.scenes.event import Event

SCENE = "kovalevskaya/generic"


def errors(run, digits=45):
    """The largest error of each state by the closed form."""
    exact = polhode.reference(run.scene).at(run.times, digits)
    return [
        max(abs(float(exactly(a) - exactly(b))) for a, b in zip(row, true, strict=True))
        for row, true in zip(run.states, exact, strict=True)
    ]


@pytest.mark.parametrize("name", [SCENE, "euler/turned-axes", "euler/no-gamma", "euler/backward"])
def test_quad_runs_are_refined_and_tell_their_errors(name):
    scene = polhode.load(name)
    run = polhode.integrate(scene, "quad", at=[scene.end / 3, scene.end], method="refined")
    assert run.method == "refined"
    assert run.outcome is Outcome.REACHED_END
    for true, told in zip(errors(run), run.errors, strict=True):
        assert true <= told < 1e6 * true
    assert polhode.compare(run).worst > 33


def test_a_method_asked_for_is_taken():
    refined, steps = (
        polhode.integrate(SCENE, "quad", at=[50], method=method) for method in ("refined", "taylor")
    )
    assert (refined.method, steps.method) == ("refined", "taylor")
    assert steps.errors is None
    assert max(errors(refined)) < max(errors(steps)) / 4  # the inputs' rounding alone costs more


def test_what_cannot_be_refined_takes_steps_or_is_refused():
    scene = polhode.load(SCENE)
    for options in (
        {"number": "double"},
        {"number": "quad", "tol": "1e-20"},
        {"number": "quad", "project": True},
    ):
        assert polhode.integrate(scene, at=[1], **options).method == "taylor"
        with pytest.raises(BadInput, match=r"method = refined: expected .*taylor"):
            polhode.integrate(scene, at=[1], method="refined", **options)
    with pytest.raises(BadInput, match="at most 13"):
        polhode.integrate(scene, at=[1], method="refined", digits=300)
    pole = polhode.Scene(scene.body, scene.omega, (0, 0, 1), outputs=("angles",))
    for other in (replace(scene, form="lagrangian"), pole):
        with pytest.raises(BadInput, match=r"method = refined: expected .*taylor"):
            polhode.integrate(other, "quad", at=[6], method="refined")
    with pytest.raises(BadInput, match="method = fast: expected auto, taylor, refined"):
        polhode.integrate(scene, "quad", at=[1], method="fast")


def test_a_short_run_takes_heyokas_own_steps():
    """Short: 120 radians, here of 1.16 a unit of time."""
    assert polhode.integrate(SCENE, "quad", at=[103]).method == "taylor"
    assert polhode.integrate(SCENE, "quad", at=[104]).method == "refined"
    assert polhode.integrate(SCENE, "quad", at=["1/10"], method="refined").method == "refined"


def test_a_refinement_that_fails_falls_back_and_says_so(monkeypatch):
    monkeypatch.setattr(self_test, "field_error", lambda *_: 1e-30)
    self_test.trusted_kernels.cache_clear()
    try:
        run = polhode.integrate(SCENE, "quad", at=[10], method="refined")
    finally:
        self_test.trusted_kernels.cache_clear()
    assert run.method == "taylor"
    assert run.provenance["not refined"] == "the compiled field fails its self-test"
    assert max(errors(run)) < 1e-31


def test_the_state_at_any_time():
    run = polhode.integrate(SCENE, "quad", at=[300])
    assert len(run.dense._motion._marks) > 1
    times = [Fraction(t) for t in ("250", "1/3", "0", "299.5", "140")]
    dense = replace(run, times=tuple(times), states=run(times))
    assert max(errors(dense)) < max(run.errors)
    assert run("250").tolist() == run([250])[0].tolist() == run(np.array(250)).tolist()
    with pytest.raises(BadInput, match="a time from 0 to 300"):
        run(301)
    back = polhode.integrate("euler/backward", "quad", at=[-30], method="refined")
    dense = replace(back, times=(Fraction(-7),), states=[back(-7)])
    assert max(errors(dense)) < max(back.errors)


def test_an_interrupt_leaves_what_was_reached(monkeypatch):
    def stop(done, steps):
        if done > 0.4:
            raise KeyboardInterrupt

    run = polhode.integrate(SCENE, "quad", at=range(1, 301), progress=stop)
    assert run.outcome is Outcome.INTERRUPTED
    assert 100 < len(run.times) < 300
    assert 0 < run.times[-1] <= run.reached < 300
    assert max(errors(replace(run, times=run.times[-1:], states=run.states[-1:]))) < 1e-31


def test_a_limit_on_the_steps():
    run = polhode.integrate(SCENE, "quad", at=[10, 300], max_steps=200)
    assert run.outcome is Outcome.STEP_LIMIT
    assert run.steps == 200
    assert run.times == (10,)


def test_digits_asked_for_are_digits_had():
    """A motion that multiplies errors: with quad's own accuracy 28 digits would be lacking."""
    run = polhode.integrate(
        "hard/dzhanibekov-1e-12", digits=31, at=[70], number="quad", method="refined"
    )
    assert run.method == "refined"
    plain = polhode.integrate("hard/dzhanibekov-1e-12", "quad", at=[70], method="refined")
    assert plain.errors[0] > 1e-29 > 1e-31 > run.errors[0]
    assert max(errors(run)) < 1e-31


@pytest.mark.slow
def test_where_no_estimate_can_be_had_a_second_run_tells_the_error():
    scene = polhode.load("hard/chaotic-long").at([30, 330])
    run = polhode.integrate(scene, "quad")
    assert refine(scene, scene.times).estimate.errors[1].max() == math.inf
    true = refine(scene, scene.times, refined_motion.accuracy(60), m=5)
    off = [
        max(abs(float(exactly(a) - b)) for a, b in zip(row, true.exactly(i), strict=True))
        for i, row in enumerate(run.states)
    ]
    assert 1e-35 < off[0] < run.errors[0]
    assert off[1] < run.errors[1] < 3 * off[1]  # twice as much, to the second run's own error
    assert off[1] > 1e-22


def test_no_errors_from_where_two_runs_have_parted():
    run = polhode.integrate("hard/chaotic-long", "quad", at=[330, 900])
    assert run.method == "refined"
    assert run.errors[0] is not None
    assert run.errors[1] is None


@pytest.mark.slow
def test_sweeps_that_stall_are_made_with_more_limbs():
    scene = polhode.load("hard/dzhanibekov-1e-12").at([300])
    with pytest.raises(Stalled):
        refine(scene, scene.times)
    run = polhode.integrate(scene, "quad")
    assert run.method == "refined"
    assert errors(run)[0] < run.errors[0] < 1e-30


@pytest.mark.parametrize("form", ["general", "inertia-axes", "momentum", "gyration-axes"])
def test_linear_forms_are_refined_in_principal_axes(form):
    scene = replace(polhode.load("euler/turned-axes"), form=form, events=(), outputs=())
    run = polhode.integrate(scene, "quad", at=[5, 30], method="refined")
    assert run.method == "refined"
    assert run.scene.form == form
    assert run.provenance["refined in"] == "principal axes, the same states"
    assert max(errors(run)) < 2e-33
    plain = polhode.integrate(
        replace(scene, form="principal"), "quad", at=[5, 30], method="refined"
    )
    assert np.array_equal(run.states, plain.states)
    assert np.array_equal(run("7/3"), plain("7/3"))


def test_the_command_line_tells_method_and_errors(capsys):
    refined = ["--method", "refined"]
    assert main(["run", SCENE, "--number", "quad", "--at", "5,20", "--json", *refined]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["method"] == "refined"
    assert answer["proven"] is False
    assert [float(x) < 1e-31 for x in answer["error"]] == [True, True]
    assert main(["run", SCENE, "--number", "quad", "--at", "20", "--method", "taylor"]) == 0
    assert "drift" in capsys.readouterr().err
    assert main(["run", SCENE, "--number", "quad", "--at", "20", *refined]) == 0
    assert "refined, estimated error " in capsys.readouterr().err
    assert main(["run", SCENE, "--number", "double", "--at", "20", "--method", "refined"]) == 2


@pytest.mark.parametrize(
    ("errors", "told"),
    [
        ((0.0, 1e-34, 3e-34), "refined, estimated error 3.0e-34"),
        ((0.0, 1e-34, None), "refined, estimated error 1.0e-34 to t = 5, no estimate beyond it"),
        ((0.0, None, None), "refined, without an estimate of the error"),
    ],
)
def test_an_estimate_is_told_only_where_there_is_one(errors, told):
    """Without any but the start's, "estimated error 0.0e+00" was told."""
    found = polhode.integrate(SCENE, "quad", at=[0, 5, 20])
    assert run_verb._accuracy(replace(found, errors=errors)) == told


def test_about_tells_whether_the_self_test_passed(capsys, monkeypatch):
    assert main(["about", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["refined"] == "self-test passed"
    monkeypatch.setattr(self_test, "field_error", lambda *_: 1e-30)
    self_test.trusted_kernels.cache_clear()
    assert main(["about"]) == 0
    told = capsys.readouterr().out
    self_test.trusted_kernels.cache_clear()
    assert "refined      not here: the compiled field fails its self-test" in told


def test_a_cache_that_breaks_the_compiler_falls_back(monkeypatch):
    def damaged(limbs):
        raise RuntimeError("damaged")

    monkeypatch.setattr(self_test, "kernels", damaged)
    self_test.trusted_kernels.cache_clear()
    run = polhode.integrate(SCENE, "quad", at=[10], method="refined")
    self_test.trusted_kernels.cache_clear()
    assert run.method == "taylor"
    assert run.provenance["not refined"] == "the field cannot be compiled: damaged"


def test_what_is_worth_refining():
    near, far = (polhode.load(SCENE).at((Fraction(t),)) for t in (30, 110))
    assert not refined_method.worth_it(near, number_types.QUAD)
    assert refined_method.worth_it(near, number_types.QUAD, loaded=True)
    assert refined_method.worth_it(near, number_types.mp(34), loaded=True)
    assert not refined_method.worth_it(near, number_types.mp(35), loaded=True), "a limb more"
    assert not refined_method.worth_it(near, number_types.mp(), loaded=True)
    assert refined_method.worth_it(far, number_types.mp())
    assert refined_motion.MOST_DIGITS >= 130


def test_members_of_a_sweep_are_refined():
    vary = {"start.omega[3]": ["1", "3/2"], "body.weight": [1, "1/3"]}
    many = polhode.integrate_many(SCENE, vary, number="quad", at=[2, 30], workers=1)
    assert many.done
    for k, member in enumerate(many.members):
        alone = polhode.integrate(member, "quad", at=[2, 30], method="refined")
        assert (many[k].method, alone.method) == ("refined", "refined")
        assert many[k].errors == alone.errors
        assert np.array_equal(many[k].states, alone.states)
    steps = polhode.integrate_many(SCENE, vary, number="quad", at=[2, 30], method="taylor")
    assert steps[0].method == "taylor"
    assert steps[0].errors is None
    assert max(errors(many[0])) < max(errors(steps[0]))
    with pytest.raises(BadInput, match="method = fast"):
        polhode.integrate_many(SCENE, vary, method="fast")


def test_members_that_cannot_be_refined_take_steps(monkeypatch):
    vary = {"start.omega[3]": ["1", "0"], "start.omega[1]": ["1", "0"], "start.omega[2]": [0]}
    scene = polhode.load("euler/largest-axis")
    many = polhode.integrate_many(scene, vary, number="quad", at=[40])
    assert [many[k].method for k in range(4)] == [
        "taylor" if k == 3 else "refined" for k in range(4)
    ]
    assert many.done
    monkeypatch.setattr(self_test, "field_error", lambda *_: 1e-30)
    self_test.trusted_kernels.cache_clear()
    try:
        failed = polhode.integrate_many(scene, vary, number="quad", at=[40])
    finally:
        self_test.trusted_kernels.cache_clear()
    assert [failed[k].method for k in range(4)] == ["taylor"] * 4
    assert failed.done


def test_a_second_try_with_more_digits_looks_for_events_anew(monkeypatch):
    scene = replace(polhode.load("hard/dzhanibekov-1e-12"), events=(Event("q", "q"),))
    tries, run = [], RefinedMotion._run
    monkeypatch.setattr(
        RefinedMotion,
        "_run",
        lambda self, *given: (tries.append(given[1]), run(self, *given))[1],
    )
    asked = {"digits": 31, "at": [70], "number": "quad"}
    found = polhode.integrate(scene, **asked, method="refined").events[0]
    assert len(tries) == 2
    plain = polhode.integrate(scene, "quad", at=[70], method="taylor").events[0]
    assert len(found.times) == len(plain.times) > 0
    assert max(abs(s - t) for s, t in zip(found.times, plain.times, strict=True)) < 1e-18
