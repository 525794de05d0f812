"""Correct digits, drift, references: definitions checked by hand-made errors."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.equations import integrals
from polhode.judging import limits
from polhode.judging.compare import judgement
from polhode.judging.score import Answers, score
from polhode.judging.tables import explanations, motions
from polhode.judging.tables.table import of_run
from polhode.motion.outcomes import Outcome
from polhode.numbers import number_types
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import DOUBLE
from polhode.output import description
from polhode.runs.trajectory import Trajectory

TIMES = (Fraction(0), Fraction(1), Fraction(2), Fraction(5))


def exact_run() -> Trajectory:
    """A trajectory whose states are the closed form's, rounded to double: no integrator."""
    scene = polhode.load("euler/largest-axis").at(TIMES)
    states = np.array([[float(x) for x in row] for row in polhode.reference(scene).at(TIMES, 60)])
    return Trajectory(scene, DOUBLE, TIMES, states, Outcome.REACHED_END, 1, TIMES[-1], 0.0)


@pytest.mark.parametrize("size", [1e-3, 1e-8, 1e-12])
def test_digits_are_those_of_an_error_put_in_by_hand(size):
    """An error of known size in one component at one time gives -log10(size / scale) there."""
    for column in range(6):
        run = exact_run()
        run.states[2, column] += size
        judged = polhode.compare(run)
        largest = np.linalg.norm(exact_run().states[:, :3], axis=1).max()
        expected = -math.log10(size / (largest if column < 3 else 1))
        assert abs(judged.worst - expected) < 1e-3
        assert judged.worst_time == 2
        assert min(d for k, d in enumerate(judged.digits) if k != 2) > 15


def test_digits_never_exceed_what_the_type_has():
    run = exact_run()
    judged = polhode.compare(run)
    assert DOUBLE.most_digits - 0.7 < judged.worst <= DOUBLE.most_digits
    assert judged.limit == "rounding"
    run.states[2, 1] = 1e3
    assert polhode.compare(run).digits[2] == 0


@pytest.mark.parametrize(("weight", "scale"), [(3, 1.5), (0, 1.0)])
def test_the_scale_of_a_body_at_rest_is_the_pendulums_rate_then_one(weight, scale):
    """sqrt(Mg r0 / C) = sqrt(9/4), of a table at t = 0."""
    start = {"omega": [0, 0, 0], "gamma": [0, 0, 1]}
    top = polhode.top(moments=[2, 3, 4], centre=[0, 0, 3], weight=weight, **start)
    table = {"t": [0.0], "p": [1e-6], "q": [0.0], "r": [0.0]}
    assert abs(polhode.compare(table, top).worst + math.log10(1e-6 / scale)) < 1e-3


def test_drift_is_that_of_an_error_put_in_by_hand():
    """h moves by A p dp, f by A dp gamma1, relative to T(0) + Mg|r0| and |G(0)|."""
    run, moved, size = exact_run(), exact_run(), 1e-6
    assert max(run.drift) < 4 * float(DOUBLE.eps)
    moved.states[1, 0] += size
    moments = np.array([float(x) for x in run.scene.body.moments])
    omega = np.array([float(x) for x in run.scene.omega])
    a, p, g1 = moments[0], run.states[1, 0], run.states[1, 3]
    energy, area = moments @ omega**2 / 2, np.linalg.norm(moments * omega)
    assert moved.drift.h == pytest.approx(a * p * size / energy, rel=1e-5)
    assert moved.drift.f == pytest.approx(abs(a * size * g1) / area, rel=1e-5)


def test_drift_of_quad_states_is_seen_below_the_doubles_eps():
    run = polhode.integrate("euler/largest-axis", "quad", at=[10])
    assert 0 < run.drift.h < 1e-31
    assert 0 < run.drift.gamma < 1e-31


@pytest.mark.parametrize("start", ["0", "1e-30", "1e-8", "1e-2"])
def test_near_rest_the_drift_of_f_is_measured_by_the_swing_to_come(start):
    """The same body and motion, but for a start that is hardly one: no drift larger by 1/start."""
    body = {"moments": [1, 2, "2.5"], "centre": ["0.1", "0.2", "0.3"], "weight": 3}
    start_numbers = {"omega": [start, 0, 0], "gamma": ["0.6", 0, "0.8"], "end": 5, "samples": 11}
    scene = polhode.top(**body, **start_numbers)
    swing = math.sqrt(3 * math.sqrt(0.14) * 2.5)
    assert float(integrals.scales(scene)[1]) == pytest.approx(swing)
    drift = polhode.integrate(scene).drift
    assert 1e-18 < drift.f < 1e-14
    many = polhode.integrate_many(scene, {"start.omega[1]": [start, "1e-20"]})
    assert many.drift[0, 1] == pytest.approx(drift.f, rel=1e-6)


@pytest.mark.parametrize(("omega", "scale"), [("0.1", "1/10"), ("0.0999", "1"), ("3", "3")])
def test_away_from_rest_the_drift_of_f_is_measured_by_the_momentum_at_the_start(omega, scale):
    """From a tenth of the pendulum's momentum on, exactly."""
    body = {"moments": [1, 1, 1], "centre": [0, 0, 1], "weight": 1, "gamma": [0, 0, 1]}
    assert integrals.scales(polhode.top(omega=[0, 0, omega], end=1, **body))[1] == Fraction(scale)


def test_a_run_is_judged_against_the_exact_scene_not_its_rounded_inputs():
    """One double of rounding in w leaves at most 16 digits: the closed form is not fed doubles."""
    scene = polhode.load("euler/largest-axis").at([100])
    rounded = replace(scene, omega=tuple(DOUBLE.rounded(x) for x in scene.omega))
    first, two = (polhode.reference(s).at([100], 40)[0] for s in (scene, rounded))
    assert 1e-17 < max(abs(float(x - y)) for x, y in zip(first, two, strict=True)) < 1e-12
    judged = polhode.compare([[float(x) for x in two]], scene, at=[100])
    assert judged.reference.scene.omega == scene.omega
    assert judged.worst < 15


# -- references -------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["auto"])
def test_a_scene_without_closed_form_is_judged_by_a_proven_enclosure(kind):
    scene = replace(polhode.load("general/asymmetric-chaotic").at([10]), reference=kind)
    proven = polhode.reference(scene)
    assert proven.kind == "certified"
    rows = proven.at([10], 25)[0], polhode.integrate(scene, "mp", digits=40).states[-1]
    assert 25 <= proven.agreement < 35
    assert max(abs(float(x - y)) for x, y in zip(*rows, strict=True)) < 1e-24
    judgement = polhode.compare(polhode.integrate(scene), proven)
    assert 11 < judgement.worst < 16
    assert "proven to" in judgement.details()


def test_a_closed_form_is_enclosed_where_a_scene_asks_for_that():
    scene = polhode.load("kovalevskaya/generic").at([5])
    proven = polhode.reference(replace(scene, reference="certified"))
    first, two = (truth.at([5], 30)[0] for truth in (proven, polhode.reference(scene)))
    assert max(abs(float(x - y)) for x, y in zip(first, two, strict=True)) < 1e-29


CHAOTIC = "general/asymmetric-chaotic"


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: polhode.reference(CHAOTIC, "certified").at(["soon"]),
            rf"^{CHAOTIC}: t\[1\] = so",
        ),
        (
            lambda: polhode.reference(CHAOTIC, "certified").at([1], 300),
            "a whole number, 1 to 250",
        ),
        (
            lambda: polhode.reference(replace(polhode.load(CHAOTIC), reference="two-precisions")),
            "= two-precisions: expected certified, which fits",
        ),
        (
            lambda: polhode.reference(replace(polhode.load(CHAOTIC), reference="euler")),
            "certified, which fits",
        ),
    ],
)
def test_what_no_reference_answers_is_refused(call, said):
    with pytest.raises(polhode.BadInput, match=said):
        call()


def test_times_are_taken_exactly_whatever_their_kind():
    truth = polhode.reference("euler/largest-axis")
    kinds = [[Fraction(1, 2)], [0.5], ["0.5"], ["1/2"], [mpmath.mpf(0.5)]]
    rows = [truth.at(times, 30)[0] for times in kinds]
    assert all(row == rows[0] for row in rows)
    assert truth.at([0.1], 30) != truth.at(["0.1"], 30)  # the double 0.1 is another number


@pytest.mark.parametrize("digits", [15, 50, 120])
def test_the_closed_form_gives_the_digits_asked_for_and_not_many_more(digits):
    truth = polhode.reference("euler/largest-axis")
    few, many = truth.at(["12.5"], digits)[0], truth.at(["12.5"], digits + 60)[0]
    with mpmath.workprec(number_types.bits_for(digits + 80)):
        error = max(abs(x - y) for x, y in zip(few, many, strict=True))
    assert digits < -mpmath.log10(error) < digits + 8


def test_the_curve_of_a_kovalevskaya_top_is_shown(monkeypatch):
    monkeypatch.setattr(description, "SECONDS", 60)  # the machine may have others to serve
    facts = description.described(polhode.load("kovalevskaya/type-e-ee"))
    assert facts["regime"] == "e-ee+"
    assert [len(facts["curve"][name]) for name in ("e", "tau")] == [3, 3]
    assert set(facts["frequencies"]) == {"period", "s1", "s2"}
    assert description.described(polhode.load("kovalevskaya/delaunay"))["curve"]["tau"] is None
    assert "curve" not in description.described(polhode.load("lagrange/cusped"))


# -- runs -------------------------------------------------------------------------------------


@pytest.mark.parametrize("times", [None, [1, 2, 3]])  # all at once, and one by one
def test_the_attitude_of_a_run_is_judged_with_either_sign_of_the_quaternion(times):
    """q and -q are one attitude."""
    run = polhode.integrate(polhode.load("euler/attitude"), at=times)
    judgement = polhode.compare(run)
    assert set(judgement.parts) == set(run.scene.outputs)
    assert 13 < judgement.parts["attitude"] < 16
    opposite = polhode.compare(replace(run, attitude=-run.attitude))
    assert opposite.parts["attitude"] == judgement.parts["attitude"]
    half = run.attitude.copy()
    half[len(half) // 2 :] *= -1
    assert (
        polhode.compare(replace(run, attitude=half)).parts["attitude"]
        == judgement.parts["attitude"]
    )


def test_what_a_judgement_asked_judges_runs_in_narrower_types_too():
    """The same rows of the reference, to the digits that the widest type needs; of no other one."""
    scene, end = polhode.load("kovalevskaya/generic"), [1, 5]
    runs = [polhode.integrate(scene, number, at=end) for number in ("quad", "double")]
    against = polhode.reference(scene)
    wide, conditions = score(of_run(runs[0]), against), polhode.conditioning(scene, end, "quad")
    narrow, alone = (score(of_run(runs[1]), against, earlier=x) for x in (wide, None))
    assert narrow.comparison.answers is wide.comparison.answers
    assert alone.comparison.answers is not wide.comparison.answers
    assert narrow.worst == pytest.approx(alone.worst, abs=1e-8)
    bands = limits.expectation(narrow, conditions).bands, judgement(alone, details=True).expected
    by_known, anew = ([band.shown(runs[1].number) for band in row] for row in bands)
    assert by_known == anew
    again = score(of_run(runs[0]), against, earlier=alone)  # which has too few digits for it
    assert again.worst == pytest.approx(wide.worst, abs=1e-8)
    later = polhode.integrate(scene, at=[1, 6])
    for run, truth in ((later, against), (runs[1], polhode.reference(scene, "certified"))):
        narrower = score(of_run(run), truth, earlier=wide)
        assert narrower.comparison.answers is not wide.comparison.answers
        assert 14 < narrower.worst <= 16


# -- a judgement is whole --------------------------------------------------------------------------


@pytest.fixture
def computes_nothing(monkeypatch):
    """A function after which nobody asks a reference, follows a motion or fits a number."""

    def refuse(*args, **options):
        raise AssertionError("something was computed")

    def stop():
        for home, name in (
            (Answers, "rows"),
            (limits, "conditioning"),
            (explanations, "integrated"),
            (motions, "integrated"),
        ):
            monkeypatch.setattr(home, name, refuse)

    return stop


@pytest.mark.parametrize("factor", [1, 1 + 1e-5, 180 / np.pi])
@pytest.mark.parametrize("details", [False, True])
def test_a_judgement_is_read_and_nothing_is_computed(factor, details, computes_nothing):
    run = polhode.integrate("lagrange/nutation", at=[0, 1, 2, 3, 4])
    columns = {"t": [0, 1, 2, 3, 4], **dict(zip(run.columns, run.states.T, strict=True))}
    columns |= {name: columns[name] * factor for name in "pqr"}
    judged = polhode.compare(columns, run.scene, details=details)
    computes_nothing()
    again = pickle.loads(pickle.dumps(judged))
    assert again.to_json() == judged.to_json()
    assert (str(again), again.details()) == (str(judged), judged.details())
    assert again.limit.name == judged.limit.name
    assert bool(judged.residuals) == details


def test_digits_that_are_demanded_are_scored_and_no_more(computes_nothing, monkeypatch):
    run = polhode.integrate("euler/separatrix", at=[1, 20])
    monkeypatch.setattr(limits, "conditioning", None)
    score_of_run = polhode.testing.assert_digits(run, run.scene, 12)
    assert 12.5 < score_of_run.worst < 14.5
    assert not hasattr(score_of_run, "limit")
    assert "worst 13." in repr(score_of_run)


def test_a_limit_is_a_text_with_a_name():
    limit = pickle.loads(pickle.dumps(limits.Limit("method", "tolerance 1e-07")))
    assert limit == "method (tolerance 1e-07)"
    assert (limit.name, limit.detail) == ("method", "tolerance 1e-07")
    assert not limits.NO_LIMIT
