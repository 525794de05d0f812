"""The table of faults: what once was wrong, silent, dead or slow, a row each, by users' doors.

Rooms test the kinds of these faults with many values; here is what was reported.
"""

import json
import math
import re
import time
import warnings
from dataclasses import replace
from decimal import Decimal

import mpmath
import numpy as np
import pandas as pd
import pytest

import polhode
from polhode import cli
from polhode.testing import assert_digits
from shared import tables
from shared.motions import free_file, light_pendulum, scene_of

SECONDS = 2.0  # of processor time, for a refusal that once took minutes


# -- events ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("zero", "pole"), [("1/(t - 0.5)", 0.5), ("sqrt(gamma1 - 0.58)", 0.908334788792443)]
)
def test_an_event_with_a_pole_ends_there(zero, pole):
    """It hung for ever: at a pole heyoka's steps are 0 and count towards no limit."""
    scene = scene_of(free_file("at = [0.25, 2]"), "top.toml")
    run = polhode.integrate(replace(scene, events=(polhode.Event("x", zero),)))
    assert run.outcome is polhode.Outcome.NON_FINITE
    assert "events that stay finite" in run.advice
    assert abs(float(run.reached) - pole) < 1e-12
    assert run.times == (0.25,)  # what lay before it is kept
    assert min(polhode.compare(run).digits) > 14


def test_an_event_that_stays_finite_is_followed_past_what_looks_like_a_pole():
    scene = scene_of(free_file("at = [5]"), "top.toml")
    run = polhode.integrate(replace(scene, events=(polhode.Event("x", "1/(p - 1) + 2"),)))
    assert run.outcome.done  # p < 1/2
    assert run.events[0].times == ()


# -- numbers and texts that people give ------------------------------------------------------------


FREE = scene_of(free_file("at = [0, 1]"), "top.toml")
ROW = [0.3, -0.4, 1.1, 0.6, 0, 0.8]


#: A top at rest whose pendulum swings in 1e341 of its units of time; and its own weight, varied.
SLOW = light_pendulum("1e-680")
WEIGHTS = {"body.weight": ["1e-680"]}


def sweep_of(number: polhode.NumberType) -> polhode.Ensemble:
    """One member, of which 30 digits are wanted."""
    return polhode.integrate_many(FREE, {"start.omega[3]": [1]}, number=number, digits=30)


def tiny() -> polhode.Scene:
    """A top whose moments are zero as doubles: its unit of time was a division by zero."""
    small = "1e-300"
    part = polhode.Part("cylinder", mass=small, radius=small, height=small)
    return polhode.top(parts=[part], angles=[0, "1/3", 0], rates=[0, 0, small], g=small, end=small)


#: What judges by proofs, which have limits of their own.
PROVEN = polhode.reference(FREE, "certified")
#: Columns of its start; of the third no name is known.
COLUMNS = {"t": [0.0], "p": [0.3], "foo": [7.0]}


class Nothing:
    """Of no kind that anything takes."""


def call_of(name, *values, **more):
    """A call of the front door, and how it is written."""
    written = re.sub(" object at 0x[0-9a-f]+", "", f"{name} {values[-1:]} {more}")
    return pytest.param(getattr(polhode, name), values, more, id=written[:70])


#: Wrong kinds gave TypeErrors from deep inside; some numbers took minutes.
KINDS = [
    call_of("load", None),
    call_of("load", Nothing()),
    call_of("load_run", 1.5),
    call_of("load_result", None),
    call_of("integrate", FREE, 3),
    call_of("integrate", FREE, "quad", digits="10"),
    call_of("integrate", FREE, max_steps=0),
    call_of("integrate", FREE, max_steps="5"),
    call_of("integrate", FREE, project="often"),
    call_of("integrate", FREE, at=1),
    call_of("integrate", FREE, at=["1", None]),
    call_of("integrate", FREE, at=[np.bytes_(b"1")]),
    call_of("compare", Nothing(), FREE, at=[0]),
    call_of("compare", [ROW], Nothing(), at=[0]),
    call_of("compare", [ROW], FREE, at=0),
    call_of("compare", [ROW], FREE, at=[0], columns=3),
    call_of("compare", [ROW], FREE, at=[0], columns=[]),
    call_of("compare", [ROW[:3]], FREE, at=[0], columns=np.eye(3)),
    call_of("compare", [ROW[:2]], FREE, at=[0], columns={"p", "q"}),
    call_of("compare", [ROW], FREE, at=[0], number=3),
    call_of("compare", [ROW], FREE, at=[0], as_it_stands=pd.NA),
    call_of("compare", pd.Series([1.0, 2.0]), FREE, at=[0, 1]),
    call_of("compare", FREE, FREE),
    call_of("integrate_many", FREE, 3, at=[0]),
    call_of("integrate_many", FREE, iter([1]), at=[0]),
    call_of("lyapunov", FREE, float("inf")),
    call_of("rolling", None),
    call_of("compare_field", None, FREE),
    call_of("compare_field", int, FREE),
    call_of("compare_field", lambda t, y: y, FREE, ["omega"]),
    call_of("compare_field", lambda t, y: y, Nothing()),
    call_of("as_toml", 1),
    call_of("top", moments=np.bytes_(b"1"), omega=[1, 1, 1]),
    call_of("Body", [[1, 0], [0, 1]]),
    call_of("section", FREE, by=1.5),
    call_of("section", FREE, extremum=np.array(["max"])),
    call_of("chaos_map", FREE, (2, 2), end=1, parts="folder"),
]
#: A call, and words of the refusal.
CALLS = [
    (lambda: polhode.integrate(FREE, at=[0])(np.array(True)), "expected"),
    (lambda: replace(FREE, form=np.array([1, 2])), "form"),
    (lambda: replace(FREE, events=(None,)), "events"),
    (lambda: replace(FREE, events=(polhode.Event("x", "p", "up"),)), "direction = up: expected"),
    (lambda: replace(FREE, events=(polhode.Event("\x1b[31m", "p"),)), "of one line"),
    (lambda: polhode.Body.of_moments([1, 1]), "moments"),
    (lambda: polhode.integrate(FREE, at=[0]).save(b"run.npz"), "expected"),
    (lambda: polhode.view(FREE).save(2), "expected"),
    (lambda: polhode.certify(FREE, at=[1]).save(5), "path = 5: expected the path of a file"),
    (lambda: polhode.prove_orbits(FREE, digits=201), "digits = 201: expected a whole number, 1 to"),
    (lambda: polhode.load(""), "'': SCENE: expected a path"),
    (lambda: polhode.top(moments=[1, 1, 1], omega=[0, 0, Decimal("1e999999")]), "exponent"),
    (lambda: polhode.integrate("euler/sphere", at=[Decimal("1e999999")]), "exponent"),
    (lambda: polhode.top(moments=[1, 1, 1], omega=[0, 0, Decimal("1e5000")]), "exponent"),
    (lambda: polhode.load("x" * 5000), "name of a case"),
    (lambda: polhode.top(moments=[1, 2, 3, 1, 2, 3], omega=[0, 0, 1]), "3 numbers"),
    (lambda: polhode.top(inertia=[[2, 0, 0], [1, 2, 0], [0, 0, 2]]), "symmetric"),
    (lambda: polhode.integrate(tiny(), max_steps=20), "outside the range of double"),
    # of an array of starts it was refused, of one start the check was rounded
    (lambda: polhode.propagator(FREE)([0, 0, 1, 0, 0, 1 + 2.0**-50], t=0), "length 1, to 8 eps"),
    # arguments that have another name here
    (lambda: polhode.integrate(FREE, rtol=1e-9), "rtol = 1e-09: expected tol, as it"),
    (lambda: polhode.integrate(FREE, t_eval=[1]), "t_eval = [1]: expected at, as it"),
    (lambda: polhode.integrate(FREE, outputs=["angles"]), "a key of the scene"),
    (lambda: polhode.integrate(FREE, end=2), "expected times as at=[...]"),
    (lambda: polhode.integrate(FREE, digit=30), "(did you mean 'digits'?)"),
    (lambda: polhode.integrate(FREE, dps=9, progress=True), "expected digits, as it"),
    (lambda: polhode.compare("a.toml", "b.csv"), "polhode compare b.csv a.toml"),
    (lambda: polhode.compare("x.csv", FREE, at_least=9), "polhode.testing.assert_digits(run"),
    (lambda: polhode.compare([ROW], FREE, dtype="quad"), "dtype = quad: expected number, as it"),
    # they were taken, and nothing came of them
    (lambda: polhode.compare(polhode.integrate(FREE), number="quad"), "none beside a run, which"),
    (lambda: polhode.compare({"t": [0], "p": [0]}, FREE, at=[0]), "none beside a table, which"),
    (lambda: polhode.compare("x.csv", FREE, at=[0]), "at = [0]: expected none beside a table"),
    (lambda: polhode.compare([ROW], PROVEN, at=[0], max_seconds=1), "none beside a certified ref"),
    (lambda: polhode.compare([ROW], PROVEN, at=[0], forecast=print), "none beside a certified ref"),
    (lambda: polhode.top(moments=[1, 1, 1], omga=[1, 1, 1]), "(did you mean 'omega'?)"),
    # it was taken, and handed on to the search for the first orbit; others were told its names
    (lambda: polhode.orbit_family(FREE, "h", 1, digits=30), "orbit_family: digits = 30: expected"),
    (lambda: polhode.prove_stability(FREE, tol=1), "prove_stability: tol = 1: expected"),
    # a TypeError once the work was under way; of some no call came
    (lambda: polhode.certify(FREE, progress=3), "certify: progress = 3: expected a function"),
    (lambda: polhode.integrate(FREE, progress="bar"), "True for a bar, or False"),
    (lambda: polhode.verify("proof.json", 3), "verify: progress = 3: expected a function"),
    (lambda: polhode.chaos_map(FREE, progress=True), "progress = True: expected a function"),
    # columns beyond the shorter row were left out, and a true nan was Python's ValueError
    (lambda: polhode.state_errors([ROW], [ROW[:3]], FREE), "row 1 = 6 numbers: expected 3"),
    (lambda: polhode.state_errors([ROW], [[*ROW[:5], np.nan]], FREE), "true, row 1 = [0.3,"),
    # an OverflowError
    (lambda: polhode.integrate(FREE, "quad", at=["1e400", "1e400+1"]), "run.at[2] = 1.0"),
    (lambda: polhode.integrate_many(SLOW, WEIGHTS, at=["1e341"]), "10**341 is outside the range"),
    # of a type's own bits alone its files are read; nothing checks the digits of a sweep
    (lambda: polhode.integrate(FREE, polhode.NumberType("double", 24)), "double of 24 bits"),
    (lambda: polhode.integrate(FREE, polhode.NumberType("quad", 112)), "expected 113 bits, or"),
    (lambda: polhode.integrate(FREE, polhode.NumberType("mp", 0)), "bits = 0: expected a whole"),
    (lambda: sweep_of(polhode.NumberType("double", 53)), "fewer in double; quad holds them"),
    (lambda: sweep_of(polhode.NumberType("mp", 70)), "expected fewer in 70 bits; 1"),
    # a column p was dropped for one that is not there, and the last one of a name was taken
    (lambda: polhode.compare(COLUMNS, FREE, columns=["P=p"]), "--columns = P: expected a name of"),
    (lambda: polhode.report(FREE, COLUMNS, COLUMNS, columns=["P=p"]), "of its header: t, p, foo"),
    (lambda: polhode.compare(COLUMNS, FREE, columns=["foo=q,foo=r"]), "foo=r: expected each name"),
    # a number was a TypeError, a text was taken as the times that its letters are
    (lambda: assert_digits(lambda t: ROW, FREE, 9, at=1.0), "at = 1.0: expected a list of times"),
    (lambda: assert_digits(lambda t: ROW, FREE, 9, at="12"), "at = 12: expected a list of times"),
    (lambda: assert_digits(lambda t: ROW, FREE, 9, at=["x"]), "at[1] = x: expected a number ("),
    (lambda: polhode.compare([ROW, ROW], FREE, at="12"), "at = 12: expected a list of times"),
    (lambda: polhode.reference(FREE).column("angles", 1), "t = 1: expected a list of times"),
    (lambda: polhode.reference(FREE).column("hodographs", "12"), "t = 12: expected a list of t"),
]


def refused(call, words="expected"):
    """In one line, and at once."""
    begin = time.process_time()
    with pytest.raises(polhode.BadInput) as refusal:
        call()
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 1000
    assert time.process_time() - begin < SECONDS


@pytest.mark.parametrize(("function", "values", "more"), KINDS)
def test_a_wrong_kind_is_refused(function, values, more):
    refused(lambda: function(*values, **more))


@pytest.mark.parametrize(("call", "words"), CALLS)
def test_it_is_refused_in_one_line_at_once(call, words):
    refused(call, words)


def test_what_is_changed_of_a_provenance_is_that_of_no_other_result(capsys):
    """All results of a process had the versions of one dictionary."""
    polhode.integrate(FREE, at=[0]).provenance["versions"]["numpy"] = "of somebody else"
    assert polhode.integrate(FREE, at=[0]).provenance["versions"]["numpy"] == np.__version__
    assert cli.main(["about", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["versions"]["numpy"] == np.__version__


def test_progress_may_be_false_at_every_door():
    """It was none at some doors and refused at others."""
    assert polhode.compare([ROW], FREE, at=[0], progress=False).has_digits
    with pytest.raises(polhode.BadInput, match=r"proof\.json: file"):
        polhode.verify("proof.json", False)


@pytest.mark.parametrize("place", range(6))
def test_a_state_that_is_not_known_has_no_error(place):
    """It had that of its other numbers."""
    states = np.array([ROW, ROW])
    states[0, place] = np.nan
    first, second = polhode.state_errors(states, [ROW, ROW], FREE)
    assert np.isnan(first)
    assert second == 0


@pytest.mark.parametrize("digits", [0, -1, 1.5, True, "10", None, 10**6])
@pytest.mark.parametrize(("scene", "most"), [(FREE, 5000), ("general/asymmetric-regular", 250)])
def test_digits_are_a_whole_number_within_bounds(scene, most, digits):
    reference = polhode.reference(scene)
    refused(lambda: reference.at([1], digits=digits), f": expected a whole number, 1 to {most}")


@pytest.mark.parametrize("steps", [1, 2, 10, 10**450])
def test_a_limit_on_steps_is_one(steps):
    """What was left of it reached 0, which to heyoka is no limit; the last was a TypeError."""
    result = polhode.lyapunov(FREE, 1, max_steps=steps)
    assert (abs(result.end) == 1) == (steps > 10)
    if steps > 10:
        varied = {"start.omega[3]": [1]}
        assert polhode.integrate_many(FREE, varied, at=[1], max_steps=steps).complete


@pytest.mark.parametrize("digits", [1, 5, 15])
def test_mp_of_few_digits_is_run_with_as_many_bits_as_it_takes(digits):
    """heyoka's ValueError came through below 64 bits."""
    run = polhode.integrate(FREE, "mp", digits=digits, at=[1])
    assert run.outcome.done
    assert run.number.bits >= 64
    assert min(polhode.compare(run).digits) >= digits


@pytest.mark.parametrize("number", ["double", "quad"])
def test_a_step_of_no_length_ends_the_run_where_it_began(number):
    body = {"moments": [1, 1, "1e-300"], "centre": ["0.1", 0, 1], "weight": 1}
    top = polhode.top(**body, omega=["0.1", "0.2", 3], gamma=["3/5", 0, "4/5"])
    run = polhode.integrate(top, number, at=[0, 10])
    assert run.outcome is polhode.Outcome.NON_FINITE
    assert run.times == (0,)
    assert 0 <= run.reached < 1


def test_a_sweep_over_numbers_beyond_doubles_has_members():
    varied = {"body.weight": ["1e400", "2e400"]}
    many = polhode.integrate_many("lagrange/nutation", varied, at=[1], max_steps=50)
    assert [outcome.value for outcome in many.outcomes] == ["step limit"] * 2


@pytest.mark.parametrize("end", [10, -10])
def test_times_beyond_doubles_are_those_of_a_slow_top(end):
    """Of its events and sweeps there were none, for an OverflowError; t was inf, back, too."""
    unit, level = 10**340, (polhode.Event("level", "gamma3"),)
    slow = replace(SLOW, events=level)
    run = polhode.integrate(slow, "extended", at=[end * unit])
    plain = replace(slow, body=SLOW.body.replaced(weight=1))
    same = polhode.integrate(plain, "extended", at=[end])
    assert run.t.tolist() == [math.copysign(math.inf, end)]
    assert abs(run.states - same.states)[:, 3:].max() < 1e-16
    times, others = run.events[0].times, same.events[0].times
    assert len(times) == len(others) > 0
    assert max(abs(float(t / unit - x)) for t, x in zip(times, others, strict=True)) < 1e-16
    assert {*run.events[0].t.tolist()} == {*run.t.tolist()}
    (member,) = many = polhode.integrate_many(SLOW, WEIGHTS, number="extended", at=run.times)
    assert many.complete
    assert many.t.tolist() == run.t.tolist()
    assert abs(member.states - run.states).max() < 1e-16


# -- verdicts --------------------------------------------------------------------------------------


def test_one_long_cell_costs_no_reference_of_as_many_digits(monkeypatch, tmp_path):
    precisions = []
    exact = polhode.reference(FREE)
    at = exact.at
    monkeypatch.setattr(exact, "at", lambda t, digits: precisions.append(digits) or at(t, digits))
    file = tmp_path / "long.csv"
    file.write_text(f"t,p\n0,0.3\n1,0.{'3' * 3000}\n")
    verdict = polhode.compare(file, exact)
    assert verdict.worst < 2
    assert max(precisions) == 100
    assert verdict.digits[0] == 1000  # the start is exact, and known as such


def test_a_table_of_many_right_digits_is_given_them_all(tmp_path):
    exact = polhode.reference(FREE)
    file = tmp_path / "right.csv"
    file.write_text(f"t,p\n1,{mpmath.nstr(exact.at([1], 420)[0][0], 410)}\n")
    assert 405 < polhode.compare(file, exact).worst < 413


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        ("lagrange/nutation", "where lagrange/nutation has p = 0.16, q = 0.3, r = 4.1"),
        ("euler/largest-axis", "where euler/largest-axis has"),
        ("lagrange/looping", ""),
    ],
)
def test_a_right_table_of_another_scene_is_told_first(scene, words):
    """It had its digits, all 0, and only then that it was wrong in the first one."""
    run = polhode.integrate("lagrange/looping", at=[0, 1, 2, 3])
    table = {"t": run.t, **{name: run.states[:, k] for k, name in enumerate(run.columns)}}
    first, *_ = str(polhode.compare(table, scene)).splitlines()
    assert words in first
    assert ("lagrange/looping" in first) == ("begin" in first) == bool(words)


def test_a_table_that_begins_right_is_of_no_other_scene():
    rows = [[0.16, 0.3, 4.1, 0.8, 0, 0.6], [4, 4, 4, 0, 0, 1]]
    assert "begin" not in str(polhode.compare(rows, "lagrange/nutation", at=[0, 1]))


def test_a_drift_beyond_doubles_is_said_in_words(tmp_path):
    file = tmp_path / "huge.csv"
    file.write_text("t,p,q,r,gamma1,gamma2,gamma3\n1,1e400,0,0,0,0,1\n")
    assert "drift h over 1.8e+308" in polhode.compare(file, FREE).details()


@pytest.mark.parametrize("size", [1.7e308, 1e160])
def test_a_number_that_no_motion_has_is_judged_without_warnings(size):
    """Overflow was warned of, an error to many test suites, and what is left called infinite."""
    table = tables.right("lagrange/nutation", range(6))
    table["p"][3] = size
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        judgement = polhode.compare(table, "lagrange/nutation", details=True)
        assert "0.00 correct digits at worst (t = 3)" in str(judgement)
    of_p, of_q, *_ = judgement.residuals
    assert of_p.rms == pytest.approx(size * (5**0.5 / 6), rel=1e-15)
    assert of_p.bias == pytest.approx(size / 6, rel=1e-15)
    assert 0 < of_q.rms < 1e-16


@pytest.mark.parametrize("size", [1e17, 1e30])
def test_a_wrong_number_is_not_explained_by_rounded_times(size):
    """By a motion of that speed, times rounded to doubles would have moved it by as much."""
    table = tables.right("lagrange/nutation", range(6))
    table["p"][3] = size
    judgement = polhode.compare(table, "lagrange/nutation")
    assert judgement.worst == 0
    assert judgement.limit == ""
    assert "rounding" not in judgement.verdict
