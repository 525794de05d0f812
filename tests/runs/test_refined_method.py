"""Runs by refinement as ``integrate`` hands them out: choice, errors, fallback, dense output."""

import json
import math
import pickle
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import Event, Outcome
from polhode.cli import main
from shared.tools import exactly, python, tiers

SCENE = "kovalevskaya/generic"
UNSTABLE = "hard/dzhanibekov-1e-12"


def refined(scene, at, number="quad", **options):
    run = polhode.integrate(scene, number, at=at, method="refined", **options)
    assert run.method == "refined"
    return run


def apart(rows, others):
    """The largest difference of two tables, row by row."""
    pairs = [zip(row, second, strict=True) for row, second in zip(rows, others, strict=True)]
    return [max(abs(float(exactly(a) - exactly(b))) for a, b in row) for row in pairs]


def errors(run, digits=45):
    """The largest error of each state by the closed form."""
    return apart(run.states, polhode.reference(run.scene).at(run.times, digits))


CLOSED = [  # case, end, digits asked for, least and most correct ones
    (SCENE, 20, None, 33, 34.1),
    ("euler/turned-axes", 50, None, 33, 34.1),
    ("euler/no-gamma", 20, None, 33, 34.1),
    ("euler/backward", -100, None, 33, 34.1),
    ("euler/tiny-units", 100, None, 33, 34.1),
    ("euler/dzhanibekov", 30, None, 30, 33),
    ("lagrange/spherical-pendulum", 40, None, 33, 34.1),
    ("lagrange/spherical-pendulum", 5, 50, 50, 60),
    ("kovalevskaya/bobylev-steklov", 20, None, 33, 34.1),
    ("hard/near-homoclinic", 40, None, 25, 29),
]


@pytest.mark.parametrize(("name", "end", "digits", "least", "most"), CLOSED)
def test_refined_runs_tell_their_errors(name, end, digits, least, most):
    """And are called at any time, as well."""
    scene = polhode.load(name).at([Fraction(end, 7), end])
    run = refined(scene, scene.times, "quad" if digits is None else None, digits=digits)
    assert run.outcome is Outcome.REACHED_END
    for true, estimate in zip(errors(run, 75), run.errors, strict=True):
        assert true <= estimate < 1e6 * true
    assert least < polhode.compare(run).worst < most
    times = tuple(scene.end * Fraction(k, 7) for k in (6, 1, 0, 3))
    assert max(errors(replace(run, times=times, states=run(times)), 75)) < max(run.errors)
    with pytest.raises(polhode.BadInput, match="a time from 0 to"):
        run(scene.end * 2)


def test_the_state_at_any_time_of_a_long_run():
    run = polhode.integrate(SCENE, "quad", at=[300])
    assert run.method == "refined"
    times = [Fraction(t) for t in ("250", "1/3", "0", "299.5", "140")]
    assert max(errors(replace(run, times=tuple(times), states=run(times)))) < max(run.errors)
    assert run("250").tolist() == run([250])[0].tolist() == run(np.array(250)).tolist()


def test_outputs_do_not_change_the_motion():
    """Few or a crowd of them: the sums in double, not the levels, know of others."""
    last = refined(SCENE, [30]).states
    for times in (range(31), [*(1 + Fraction(k, 10**6) for k in range(700)), 30]):
        assert apart(refined(SCENE, times).states[-1:], last)[0] < 2e-34


def test_short_runs_take_heyokas_own_steps_unless_told():
    """Short: 20 radians, here of 1.16 a unit of time; alone and in a sweep."""
    runs = [polhode.integrate(SCENE, "quad", at=[t], project=False) for t in (17, 18)]
    assert [run.method for run in runs] == ["taylor", "refined"]
    for run, t in zip(runs, (17, 18), strict=True):
        (member,) = polhode.integrate_many(SCENE, {"body.weight": [1]}, number="quad", at=[t])
        assert (member.method, member.states.tolist()) == (run.method, run.states.tolist())
    fine, steps = refined(SCENE, [50]), polhode.integrate(SCENE, "quad", at=[50], method="taylor")
    assert (steps.method, steps.errors) == ("taylor", None)
    assert max(errors(fine)) < max(errors(steps)) / 4  # the inputs' rounding alone costs more
    runs = [polhode.integrate(SCENE, at=[t], digits=50) for t in (30, 110)]
    assert [run.method for run in runs] == ["taylor", "refined"]


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        ({}, {"number": "double"}, r"method = refined: expected .*taylor"),
        ({}, {"number": "quad", "tol": "1e-20"}, r"method = refined: expected .*taylor"),
        ({}, {"number": "quad", "project": True}, r"method = refined: expected .*taylor"),
        ({}, {"digits": 300}, "at most 13"),
        ({"form": "lagrangian"}, {"number": "quad"}, r"method = refined: expected .*taylor"),
        ({"events": (Event("q", "q"),)}, {"number": "quad"}, "expected no events, or .*taylor"),
        (
            {"omega": (1, 0, 1), "gamma": (0, 0, 1), "outputs": ("angles",)},
            {"number": "quad"},
            r"method = refined: expected .*taylor",
        ),
        ({"omega": (0, 0, 0), "gamma": (-1, 0, 0)}, {"number": "quad"}, "does not stand still, or"),
        ({}, {"number": "quad", "method": "fast"}, "expected auto, taylor, refined"),
    ],
)
def test_what_cannot_be_refined_takes_steps_or_is_refused(changes, options, message):
    scene = replace(polhode.load(SCENE), **changes)
    with pytest.raises(polhode.BadInput, match=message):
        polhode.integrate(scene, at=[1], **{"method": "refined", **options})
    if "method" not in options and "digits" not in options:
        assert polhode.integrate(scene, at=[1], **options).method == "taylor"


#: A process in which no field can be compiled.
DAMAGED = """
import heyoka
def damaged(*_, **__):
    raise RuntimeError("damaged")
heyoka.cfunc = damaged
import polhode
from polhode.cli import main
run = polhode.integrate("kovalevskaya/generic", "quad", at=[10], method="refined")
vary = {"body.weight": [1, 2]}
many = polhode.integrate_many("kovalevskaya/generic", vary, number="quad", at=[40])
print(*(x.method for x in (run, *many)), min(polhode.compare(run).digits) > 31.3)
print(run.provenance["not refined"])
main(["about"])
"""


def test_a_refinement_that_fails_falls_back_and_says_so(capsys):
    reason = "the field cannot be compiled: damaged"
    assert main(["about", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["refined"] == "compiled"
    methods, told, *about = python("-c", DAMAGED).stdout.splitlines()
    assert (methods, told) == ("taylor taylor taylor True", reason)
    assert f"refined      not here: {reason}" in about


def test_an_interrupt_leaves_what_was_reached():
    def stop(share, steps):
        if share > 0.4:
            raise KeyboardInterrupt

    run = polhode.integrate(SCENE, "quad", at=range(1, 301), progress=stop)
    assert (run.method, run.outcome) == ("refined", Outcome.INTERRUPTED)
    assert 100 < len(run.times) < 300
    assert 0 < run.times[-1] <= run.reached < 300
    assert max(errors(replace(run, times=run.times[-1:], states=run.states[-1:]))) < 1e-31


@pytest.mark.parametrize("number", ["quad", "mp"])
def test_the_start_alone_and_progress(number):
    calls = []
    options = {"number": number, "at": [0], "method": "refined"}
    run = polhode.integrate(SCENE, **options, progress=lambda *share: calls.append(share))
    assert (run.outcome, len(run.states)) == (Outcome.REACHED_END, 1)
    assert [share for share, _ in calls] == [1.0] * len(calls)
    many = polhode.integrate_many(SCENE, {"body.weight": [1]}, **options)
    assert np.array_equal(many.states[0], run.states)


def test_a_limit_on_the_steps():
    run = polhode.integrate(SCENE, "quad", at=[10, 300], max_steps=200)
    assert (run.outcome, run.steps, run.times) == (Outcome.STEP_LIMIT, 200, (10,))


@pytest.mark.parametrize(("power", "is_told"), [(340, True), (345, False)])
def test_errors_of_a_fast_body_are_told_where_doubles_hold_them(power, is_told):
    """An OverflowError came after the whole refinement."""
    omega = [f"1e{power}", f"2e{power - 1}", f"3e{power - 1}"]
    run = refined(polhode.top(moments=[1, 2, "2.5"], omega=omega), [f"1e{1 - power}"])
    ((true,),) = [errors(run)] if is_told else [[math.inf]]
    assert true <= run.errors[0] < 1e6 * true if is_told else run.errors == (None,)


def test_digits_asked_for_are_digits_had():
    """A motion that multiplies errors: with quad's own accuracy 28 digits would be lacking."""
    run, plain = refined(UNSTABLE, [70], digits=31), refined(UNSTABLE, [70])
    assert plain.errors[0] > 1e-29 > 1e-31 > run.errors[0]
    assert max(errors(run)) < 1e-31


@pytest.mark.slow
def test_where_no_estimate_can_be_had_a_second_run_tells_the_error():
    scene = polhode.load("hard/chaotic-long").at([30, 330])
    run, true = (polhode.integrate(scene, **how) for how in ({"number": "quad"}, {"digits": 30}))
    off = apart(run.states, true.states)
    assert true.errors[1] < 1e-28
    assert 1e-35 < off[0] < run.errors[0]
    assert off[1] < run.errors[1] < 3 * off[1]  # twice as much, to the second run's own error
    assert off[1] > 1e-22


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 330])
def test_no_errors_from_where_two_runs_have_parted(first, tmp_path, capsys):
    """Without any but the start's, "estimated error 0.0e+00" was told."""
    path, times = tmp_path / "run.npz", f"{first},900"
    command = ["run", "hard/chaotic-long", "--number", "quad", "--at", times, "-o", str(path)]
    assert main(command) == 0
    run = polhode.load_run(path)
    assert run.method == "refined"
    assert run.errors[1] is None
    estimate = f"estimated error {run.errors[0]:.1e} to t = 330, no estimate beyond it"
    text = estimate if first else "without an estimate of the error"
    assert f"refined, {text}\n" in capsys.readouterr().err


@pytest.mark.slow
def test_sweeps_that_stall_are_made_with_more_limbs():
    scene = polhode.load(UNSTABLE).at([300])
    run = polhode.integrate(scene, "quad")
    assert run.method == "refined"
    assert errors(run)[0] < run.errors[0] < 1e-30


@pytest.mark.parametrize("form", tiers(["general", "momentum"], ["inertia-axes", "gyration-axes"]))
def test_linear_forms_are_refined_in_principal_axes(form):
    scene = replace(polhode.load("euler/turned-axes"), form=form, events=(), outputs=())
    run, plain = (refined(s, [5, 30]) for s in (scene, replace(scene, form="principal")))
    assert run.scene.form == form
    assert run.provenance["refined in"] == "principal axes, the same states"
    assert max(errors(run)) < 2e-33
    assert np.array_equal(run.states, plain.states)
    there = run("7/3")
    assert np.array_equal(there, plain("7/3"))
    assert np.array_equal(pickle.loads(pickle.dumps(run))("7/3"), there)


def test_the_command_line_tells_method_and_errors(capsys):
    command = ["run", SCENE, "--number", "quad", "--at", "5,20"]
    assert main([*command, "--json", "--method", "refined"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["method"] == "refined"
    assert [0 < x < 1e-31 for x in answer["columns"]["error"]] == [True, True]
    for method, said in (("taylor", "drift"), ("refined", "refined, estimated error ")):
        assert main([*command, "--method", method]) == 0
        assert said in capsys.readouterr().err
    assert main(["run", SCENE, "--number", "double", "--at", "20", "--method", "refined"]) == 2


def test_members_of_a_sweep_are_refined_or_take_steps():
    vary = {"start.omega[3]": ["1", "3/2"], "body.weight": [1, "1/3"]}
    many, steps = (
        polhode.integrate_many(SCENE, vary, number="quad", at=[2, 30], workers=1, method=method)
        for method in ("auto", "taylor")
    )
    assert many.complete
    for k, member in enumerate(many.members):
        alone = refined(member, [2, 30])
        assert (many[k].method, many[k].errors) == ("refined", alone.errors)
        assert np.array_equal(many[k].states, alone.states)
    assert (steps[0].method, steps[0].errors) == ("taylor", None)
    assert max(errors(many[0])) < max(errors(steps[0]))
    vary = {"start.omega[3]": ["1", "0"], "start.omega[1]": ["1", "0"], "start.omega[2]": [0]}
    many = polhode.integrate_many("euler/largest-axis", vary, number="quad", at=[40])
    methods = [many[k].method for k in range(4)]
    assert methods == ["refined"] * 3 + ["taylor"]  # the last one stands still
    with pytest.raises(polhode.BadInput, match="method = fast"):
        polhode.integrate_many(SCENE, vary, method="fast")


# -- attitude and angles: closed forms, heyoka's steps, windings near poles ------------------------

TURNS = ("angles", "attitude", "hodographs")


def turning(scene, at, number="quad"):
    return refined(replace(polhode.load(scene), outputs=TURNS), at, number)


@pytest.mark.parametrize(
    ("name", "number", "at", "worst"),
    [  # psi is rounded at 113 bits, to 2e-33 beyond 16
        pytest.param("kovalevskaya/generic", "quad", ["1/3", 20], 4e-33, marks=pytest.mark.slow),
        ("euler/backward", "quad", [-1, -50], 4e-33),
        ("euler/turned-axes", "quad", [0, 1, 50], 4e-33),
        ("lagrange/nutation", "quad", [1, 5, 10], 4e-33),
        ("lagrange/spherical-pendulum", "quad", [1, 40], 4e-33),
        ("euler/dzhanibekov", "quad", [1, 30], 4e-31),
        ("lagrange/nutation", "mp", [2, 7], 1e-49),
    ],
)
def test_attitude_and_angles_of_refined_runs_are_those_of_the_closed_form(name, number, at, worst):
    run = turning(name, at, number)
    true = polhode.reference(run.scene)
    assert 0 < max(apart(run.angles, true.angles(run.times, 62))) < worst
    assert 0 < max(apart(run.attitude, true.attitude(run.times, 62))) < worst / 4
    assert 0 < max(apart(run.hodographs.space, true.hodographs(run.times, 62).space)) < worst


def test_turns_are_counted_over_several_runs_in_double(monkeypatch):
    monkeypatch.setattr("polhode.refined.refinement.STEPS", 40)
    run = turning("euler/turned-axes", [10, 30, 60])
    assert 0 < max(apart(run.angles, polhode.reference(run.scene).angles(run.times, 45))) < 1e-32
    assert abs(run.angles[-1][0]) > 10


@pytest.mark.parametrize("end", [15, -30])
def test_heyokas_own_run_in_quad(end):
    kind = "chaotic" if end > 0 else "regular"
    scene = replace(polhode.load(f"general/asymmetric-{kind}"), outputs=TURNS)
    ours, steps = (
        polhode.integrate(scene, "quad", at=[end / 5, end], method=method)
        for method in ("refined", "taylor")
    )
    assert ours.method == "refined"
    assert 0 < max(apart(ours.angles, steps.angles)) < 2e-30
    assert 0 < max(apart(ours.attitude, steps.attitude)) < 1e-30


def sphere(near):
    """A free sphere that turns about its first axis; gamma passes the pole at such a distance."""
    length = (1 + near**2) / (1 - near**2)  # rational: gamma1 = 2 near/(1 + near²)
    gamma1, rest = 2 * near / (1 + near**2), 1 / length
    gamma = gamma1, Fraction(3, 5) * rest, Fraction(4, 5) * rest
    return polhode.top(moments=[1, 1, 1], omega=[1, 0, 0], gamma=gamma, end=1, outputs=TURNS)


@pytest.mark.parametrize("near", [Fraction(1, 10), Fraction(1, 10**4), -Fraction(1, 10**9)])
def test_windings_past_both_poles(near):
    run = turning(sphere(near), [5, 33])
    true = polhode.reference(run.scene).angles(run.times, 60)
    assert max(apart(run.angles, true)) < 1e-32 / abs(near)
    assert abs(run.angles[1][0]) > 10  # psi turns by pi at each pole


def test_a_motion_through_a_pole_takes_heyokas_steps():
    scene = sphere(Fraction(0))
    run, attitude = (
        polhode.integrate(replace(scene, outputs=outputs), "quad", at=[5], method="refined")
        for outputs in (TURNS, ("attitude",))
    )
    assert (run.method, attitude.method) == ("taylor", "refined")
    assert "pole" in run.provenance["not refined"]
