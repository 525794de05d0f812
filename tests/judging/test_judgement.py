"""Correct digits, drift, references: definitions checked by hand-made errors."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import cli
from polhode.equations import integrals
from polhode.judging import correct_digits as correct_digits
from polhode.judging.conditioning.rounding_errors import Band
from polhode.judging.references.reference import Reference
from polhode.judging.tables.candidate import of_table
from polhode.judging.tables.table import Table
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import exact_number
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import DOUBLE
from polhode.output import description
from polhode.runs.trajectory import Trajectory
from polhode.scenes import scene_file
from polhode.scenes.vocabulary import STATE

TIMES = (Fraction(0), Fraction(1), Fraction(2), Fraction(5))


def exact_run(name: str, number=DOUBLE) -> Trajectory:
    """A trajectory whose states are the closed form's, rounded to the type: no integrator."""
    scene = polhode.load(name).at(TIMES)
    rows = polhode.reference(scene).at(TIMES, 60)
    states = rows if number.bits > 64 else np.array([[float(x) for x in row] for row in rows])
    return Trajectory(scene, number, TIMES, states, Outcome.REACHED_END, 1, TIMES[-1], 0.0)


@pytest.mark.parametrize("size", [1e-3, 1e-8, 1e-12])
@pytest.mark.parametrize("column", range(6))
def test_digits_are_those_of_an_error_put_in_by_hand(size, column):
    """An error of known size in one component at one time gives -log10(size / scale) there."""
    run = exact_run("euler/largest-axis")
    run.states[2, column] += size
    judged = polhode.compare(run)
    rows = polhode.reference(run.scene).at(TIMES, 30)
    largest = max(math.sqrt(sum(float(x) ** 2 for x in row[:3])) for row in rows)
    expected = -math.log10(size / (largest if column < 3 else 1))
    assert abs(judged.worst - expected) < 1e-3
    assert judged.worst_time == 2
    assert min(d for k, d in enumerate(judged.digits) if k != 2) > 15


def test_digits_never_exceed_what_the_type_has():
    judged = polhode.compare(exact_run("euler/largest-axis"))
    assert judged.worst <= DOUBLE.most_digits
    assert judged.worst > DOUBLE.most_digits - 0.7
    assert judged.limit == "rounding"


def test_the_scale_of_a_body_at_rest_is_the_pendulums_rate_then_one():
    heavy = scene_file.parse(
        "schema = 1\n[body]\nmoments = [2, 3, 4]\ncentre = [0, 0, 3]\nweight = 3\n"
        "[start]\nomega = [0, 0, 0]\ngamma = [0, 0, 1]\n"
    )
    free = replace(heavy, body=replace(heavy.body, weight=Fraction(0)))
    zero = [[mpmath.mpf(0)] * 6]
    assert correct_digits.rate_scale(zero, heavy, 80) == mpmath.mpf(3) / 2
    assert correct_digits.rate_scale(zero, free, 80) == 1


def test_a_row_of_another_length_is_not_judged_by_what_it_has():
    true = [[mpmath.mpf(k) for k in range(6)]]
    with pytest.raises(ValueError, match="longer than"):
        correct_digits.errors([[0, 1, 2]], true, 1, 80)


def test_a_state_that_is_not_finite_has_no_digits():
    assert correct_digits.digits_of(mpmath.inf, 16) == 0
    assert correct_digits.digits_of(mpmath.nan, 16) == 0
    assert correct_digits.digits_of(mpmath.mpf(3), 16) == 0


def test_drift_is_that_of_an_error_put_in_by_hand():
    """h moves by A p dp, f by A dp gamma1, relative to T(0) + Mg|r0| and |G(0)|."""
    run = exact_run("euler/largest-axis")
    clean = run.drift
    assert max(clean) < 4 * float(DOUBLE.eps)
    moved = exact_run("euler/largest-axis")
    size = 1e-6
    moved.states[1, 0] += size
    a = float(run.scene.body.moments[0])
    p, g1 = run.states[1, 0], run.states[1, 3]
    values = run.scene.integrals
    assert math.isclose(
        moved.drift.h,
        abs(a * p * size + a * size**2 / 2) / float(values.energy_scale),
        rel_tol=1e-8,
    )
    assert math.isclose(
        moved.drift.f,
        abs(a * size * g1)
        / float(exact.rounded(values.area_scale, 53)[0])
        / 2.0 ** exact.rounded(values.area_scale, 53)[1],
        rel_tol=1e-8,
    )


def test_drift_of_quad_states_is_seen_below_the_doubles_eps():
    run = polhode.integrate("euler/largest-axis", "quad", at=[10])
    assert 0 < run.drift.h < 1e-31
    assert 0 < run.drift.gamma < 1e-31


def test_a_start_from_rest_has_a_drift_all_the_same():
    scene = scene_file.parse(
        "schema = 1\n[body]\nmoments = [1, 2, 2.5]\ncentre = [0.1, 0.2, 0.3]\nweight = 3\n"
        "[start]\nomega = [0, 0, 0]\ngamma = [0.6, 0, 0.8]\n[run]\nend = 5\n"
    )
    drift = polhode.integrate(scene).drift
    assert 0 < drift.f < 1e-13
    assert integrals.scales(scene)[1] > 0


@pytest.mark.parametrize("start", ["0", "1e-30", "1e-8", "1e-2"])
def test_near_rest_the_drift_of_f_is_measured_by_the_swing_to_come(start):
    """The same body and motion, but for a start that is hardly one: no drift larger by 1/start."""
    scene = polhode.top(
        moments=[1, 2, "2.5"],
        centre=["0.1", "0.2", "0.3"],
        weight=3,
        omega=[start, 0, 0],
        gamma=["0.6", 0, "0.8"],
        end=5,
        samples=11,
    )
    swing = math.sqrt(3 * math.sqrt(0.14) * 2.5)
    assert float(integrals.scales(scene)[1]) == pytest.approx(swing)
    drift = polhode.integrate(scene).drift
    assert 1e-18 < drift.f < 1e-14
    many = polhode.integrate_many(scene, {"start.omega[1]": [start, "1e-20"]})
    assert many.drift[0, 1] == pytest.approx(drift.f, rel=1e-6)


def test_away_from_rest_the_drift_of_f_is_measured_by_the_momentum_at_the_start():
    """From a tenth of the pendulum's momentum on, exactly."""
    body = {"moments": [1, 1, 1], "centre": [0, 0, 1], "weight": 1, "gamma": [0, 0, 1]}
    for omega, scale in (("0.1", "0.1"), ("0.0999", "1"), ("3", "3")):
        scene = polhode.top(omega=[0, 0, omega], end=1, **body)
        assert str(integrals.scales(scene)[1]) == str(exact_number(scale))


@pytest.mark.slow
def test_rounding_the_inputs_alone_is_told_from_the_steps():
    """On a fast top the steps cost digits; on the separatrix the rounded inputs do."""
    fast = polhode.compare(polhode.integrate("euler/fast-spin", project=False))
    assert fast.inputs[-1] > fast.worst + 1
    assert fast.limit == "conditioning"
    apart = polhode.compare(polhode.integrate("euler/separatrix"))
    assert abs(apart.inputs[-1] - apart.worst) < 0.7


def test_a_loose_tolerance_is_named_as_the_limit():
    judged = polhode.compare(polhode.integrate("euler/largest-axis", at=[10], tol=1e-7))
    assert judged.limit == "method (tolerance 1.0e-07)"
    assert "limited by method (tolerance" in str(judged)


def test_a_run_is_judged_against_the_exact_scene_not_its_rounded_inputs():
    """One double of rounding in w leaves at most 16 digits: the closed form is not fed doubles."""
    scene = polhode.load("euler/largest-axis").at((Fraction(100),))
    rounded = replace(scene, omega=tuple(DOUBLE.rounded(x) for x in scene.omega))
    one, two = (polhode.reference(s).at([100], 40)[0] for s in (scene, rounded))
    with mpmath.workprec(150):
        difference = max(abs(x - y) for x, y in zip(one, two, strict=True))
    assert 1e-17 < difference < 1e-12
    run = polhode.integrate(scene)
    assert polhode.compare(run).reference.scene.omega == scene.omega


# -- references -------------------------------------------------------------------------------


def test_a_closed_form_and_an_integration_agree():
    scene = polhode.load("euler/largest-axis").at((Fraction(20),))
    closed = polhode.reference(scene)
    assert isinstance(closed, Reference)
    rows = closed.at([20], 40)[0], polhode.integrate(scene, "mp", digits=42).states[-1]
    with mpmath.workprec(200):
        difference = max(abs(x - y) for x, y in zip(*rows, strict=True))
    assert difference < mpmath.mpf(10) ** -40


def test_a_time_that_is_none_is_refused_in_the_name_of_the_scene():
    proven = polhode.Certified(polhode.load("general/asymmetric-chaotic"))
    with pytest.raises(polhode.BadInput, match=r"^general/asymmetric-chaotic: t\[1\] = soon"):
        proven.at(["soon"])


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", ["auto", "certified"])
def test_a_scene_without_closed_form_is_judged_by_a_proven_enclosure(kind: str):
    scene = replace(polhode.load("general/asymmetric-chaotic"), reference=kind)
    proven = polhode.reference(scene)
    assert proven.kind == "certified"
    run = polhode.integrate(scene.at((Fraction(30),)), "mp", digits=40)
    rows = proven.at([30], 25)[0], run.states[-1]
    assert 25 <= proven.agreement < 35
    with mpmath.workprec(200):
        difference = max(abs(x - y) for x, y in zip(*rows, strict=True))
    assert difference < mpmath.mpf(10) ** -24
    found = polhode.compare(polhode.integrate(scene.at((Fraction(30),))), proven)
    assert 9 < found.worst < 16
    assert "proven to" in str(found)


def test_a_scene_of_an_earlier_version_is_told_its_reference():
    scene = replace(polhode.load("general/asymmetric-chaotic"), reference="two-precisions")
    with pytest.raises(polhode.BadInput, match=r"= two-precisions: expected certified, which fits"):
        polhode.reference(scene)


def test_a_closed_form_is_enclosed_where_a_scene_asks_for_that():
    scene = polhode.load("kovalevskaya/generic").at((Fraction(20),))
    proven = polhode.reference(replace(scene, reference="certified"))
    rows = [truth.at([20], 30)[0] for truth in (proven, polhode.reference(scene))]
    with mpmath.workprec(200):
        difference = max(abs(x - y) for x, y in zip(*rows, strict=True))
    assert difference < mpmath.mpf(10) ** -29


def test_more_digits_than_an_enclosure_gives_are_refused():
    scene = polhode.load("general/asymmetric-regular")
    with pytest.raises(polhode.BadInput, match="a whole number, 1 to 250"):
        polhode.Certified(scene).at([1], 300)


def test_a_closed_form_that_does_not_fit_is_refused():
    scene = replace(polhode.load("general/near-upright"), reference="euler")
    with pytest.raises(polhode.BadInput, match="certified, which fits"):
        polhode.reference(scene)


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


@pytest.mark.parametrize(
    ("body", "kind"),
    [
        ("moments = [2, 2, 1]\ncentre = [0, 0, 1]\nweight = 1", "Lagrange top"),
        ("moments = [2, 1, 2]\ncentre = [0, 1, 0]\nweight = 1", "Lagrange top"),
        (
            "moments = [1, 1, 1]\ncentre = [1, 2, 3]\nweight = 1",
            "Lagrange top (three equal moments)",
        ),
        ("moments = [2, 2, 1]\ncentre = [1, 1, 0]\nweight = 1", "Kovalevskaya top"),
        ("moments = [1, 2, 2]\ncentre = [0, 1, 1]\nweight = 1", "Kovalevskaya top"),
        ("moments = [4, 4, 1]\ncentre = [1, 0, 0]\nweight = 1", "Goryachev-Chaplygin body"),
        (
            "moments = [2, 2, 1]\ncentre = [1, 0, 1]\nweight = 1",
            "heavy symmetric body, centre of mass off its axis",
        ),
        ("moments = [3, 2, 2.5]\ncentre = [1, 0, 1]\nweight = 1", "heavy asymmetric body"),
        ("moments = [3, 2, 2.5]\ncentre = [1, 0, 1]\nweight = 0", "Euler top"),
    ],
)
def test_bodies_are_named_by_their_exact_structure(body, kind):
    from polhode.scenes.classification import kind_of_body

    text = f"schema = 1\n[body]\n{body}\n[start]\nomega = [1, 2, 3]\ngamma = [0, 0, 1]\n"
    assert kind_of_body(scene_file.parse(text).body) == kind


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", ["euler/separatrix", "lagrange/cusped", "kovalevskaya/type-e-ee"])
@pytest.mark.parametrize("digits", [20, 50])
def test_the_error_estimate_bounds_the_true_error_and_is_not_slack(name, digits):
    truth = polhode.reference(name)
    estimate = truth.error([1, 7], digits)
    rows, finer = truth.at([1, 7], digits), truth.at([1, 7], digits + 30)
    scale = correct_digits.rate_scale(finer, truth.scene, 300)
    true = max(correct_digits.errors(rows, finer, scale, 300))
    assert true <= estimate * (1 + mpmath.mpf(10) ** -6)
    assert mpmath.mpf(10) ** (-digits - 12) < estimate < mpmath.mpf(10) ** -digits


def test_the_curve_of_a_kovalevskaya_top_is_shown(monkeypatch):
    monkeypatch.setattr(description, "SECONDS", 60)  # the machine may have others to serve
    facts = description.described(polhode.load("kovalevskaya/type-e-ee"))
    assert facts["regime"] == "e-ee+"
    assert len(facts["curve"]["e"]) == 3
    assert len(facts["curve"]["tau"]) == 3
    assert set(facts["frequencies"]) == {"period", "s1", "s2"}
    assert description.described(polhode.load("kovalevskaya/delaunay"))["curve"]["tau"] is None
    assert "curve" not in description.described(polhode.load("lagrange/cusped"))


# -- files, arrays and runs are judged by one judgement ------------------------------------------


def test_a_run_its_file_and_its_array_are_judged_alike(tmp_path, capsys):
    """A file of doubles read as doubles, the array and the run hold the same numbers."""
    path = tmp_path / "x.csv"
    assert cli.main(["run", "euler/largest-axis", "--no-project", "-o", str(path)]) == 0
    run = polhode.integrate("euler/largest-axis", project=False)
    by_run = polhode.compare(run)
    by_file = polhode.compare(path, "euler/largest-axis", number="double")
    by_array = polhode.compare(run.states, run.scene, at=run.times)
    assert by_run.digits == by_file.digits == by_array.digits
    assert by_run.expected == by_file.expected == by_array.expected
    assert by_run.inputs == by_file.inputs == by_array.inputs
    assert by_file.drift == by_array.drift == pytest.approx(by_run.drift, rel=1e-3)
    assert by_run.limit == by_array.limit
    capsys.readouterr()
    assert cli.main(["compare", str(path), "euler/largest-axis", "--number", "double"]) == 0
    assert capsys.readouterr().out == f"{by_file}\n"


def test_some_columns_of_an_array_are_judged():
    run = polhode.integrate("euler/largest-axis")
    judged = polhode.compare(run.states[:, 3:], run.scene, at=run.times, columns=STATE[3:])
    assert judged.subject.columns == STATE[3:]
    whole = polhode.compare(run)
    assert all(d >= w for d, w in zip(judged.digits, whole.digits, strict=True))
    assert "column p is not in the file" in judged.notes


@pytest.mark.parametrize(
    ("rows", "options", "said"),
    [
        ([[1, 2, 3]], {"at": [1]}, "6 numbers in each row"),
        ([[1, 2, 3]], {"at": [1, 2], "columns": ["p", "q", "r"]}, "a time for each of 1 rows"),
        ([[1, 2, 3]], {"columns": ["p", "q", "r"]}, "a time for each of 1 rows"),
        ([["x", 2, 3]], {"at": [1], "columns": ["p", "q", "r"]}, "rows of finite numbers"),
        ([[math.inf, 2, 3]], {"at": [1], "columns": ["p", "q", "r"]}, "rows of finite numbers"),
        ([[1]], {"at": [1], "columns": ["s"]}, "columns = s"),
        (3, {"at": [1]}, "rows of finite numbers"),
    ],
)
def test_rows_that_cannot_be_judged_are_refused(rows, options, said):
    with pytest.raises(polhode.BadInput, match=said):
        polhode.compare(rows, "euler/largest-axis", **options)


def test_a_file_needs_what_it_is_judged_against(tmp_path):
    with pytest.raises(polhode.BadInput, match="a reference, or a scene"):
        polhode.compare(tmp_path / "x.csv")


def test_the_attitude_of_a_run_is_judged_with_either_sign_of_the_quaternion(tmp_path):
    """q and -q are one attitude; the sign may not change along the way."""
    scene = polhode.load("euler/attitude")
    run = polhode.integrate(scene)
    found = polhode.compare(run)
    assert set(found.parts) == set(scene.outputs)
    assert 13 < found.parts["attitude"] < 16
    turned = polhode.compare(replace(run, attitude=-run.attitude))
    assert turned.parts["attitude"] == found.parts["attitude"]
    half = run.attitude.copy()
    half[len(half) // 2 :] *= -1
    assert polhode.compare(replace(run, attitude=half)).parts["attitude"] == 0
    few = polhode.integrate(scene.at([1, 2, 3]))  # judged one by one
    turned = polhode.compare(replace(few, attitude=-few.attitude))
    assert turned.parts["attitude"] == polhode.compare(few).parts["attitude"] > 13


def test_whether_the_digits_asked_for_were_reached_is_told():
    held = polhode.compare(polhode.integrate("euler/largest-axis", digits=12))
    assert held.asked == 12
    assert held.reached
    steps = polhode.integrate("euler/separatrix", "quad", digits=30, at=[30], method="taylor")
    lost = polhode.compare(steps)
    assert not lost.reached
    assert polhode.compare(polhode.integrate("euler/largest-axis")).reached is None


def test_columns_about_the_vertical_are_named_where_the_scene_has_none():
    table = Table(
        "rows", (Fraction(0),), {n: (Fraction(1),) for n in ("p", "gamma1", "psi")}, (), 1
    )
    missing = [f"column {name} is not in the file" for name in "qr"]
    found = of_table(table, polhode.load("euler/no-gamma"))
    unjudged = [f"column {n} was not judged: the scene has no gamma" for n in ("gamma1", "psi")]
    assert found.notes == (*unjudged, *missing)
    assert (found.columns, found.angles, found.attitude) == (("p",), None, None)
    there = of_table(table, polhode.load("euler/largest-axis"))
    assert there.notes == (*missing, *(f"column gamma{i} is not in the file" for i in (2, 3)))
    assert there.angles == [[1, None, None]]


# -- columns by name ------------------------------------------------------------------------------


def columns_of_a_run():
    run = polhode.integrate("lagrange/nutation", at=[0.5, 1, 2])
    names = ("wx", "wy", "wz", "gamma1", "gamma2", "gamma3")
    return {"time": [0.5, 1, 2], **dict(zip(names, np.array(run.states).T, strict=True))}


def test_columns_by_name_are_judged_as_a_file_with_that_header_is():
    given = columns_of_a_run()
    given["time"] = np.array(given["time"])
    judged = polhode.compare(given, "lagrange/nutation")
    assert (
        judged.digits
        == polhode.compare(
            np.array([given[k] for k in list(given)[1:]]).T, "lagrange/nutation", at=given["time"]
        ).digits
    )
    assert judged.subject.number.name == "double"
    degrees = {k if k != "wx" else "wx [deg/s]": v for k, v in given.items()}
    degrees["wx [deg/s]"] = np.degrees(degrees["wx [deg/s]"])
    assert polhode.compare(degrees, "lagrange/nutation").worst > 13
    given["wy"] = given["wy"] + 1e-6
    assert 6 < polhode.compare(given, "lagrange/nutation").worst < 7.5
    given["wy"] = np.array([math.nan, *given["wy"][1:]])
    assert "empty cells were not judged" in polhode.compare(given, "lagrange/nutation").notes


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"time": None}, "a column t among them"),
        ({"t": [1, 2, 3]}, "columns = t: expected each column once"),
        ({"wx": [1.0]}, "columns as long as t"),
        ({"wx": ["a", 1, 2]}, r"wx\[1\] = a: expected a number"),
    ],
)
def test_columns_that_cannot_be_judged_are_refused(change, said):
    given = columns_of_a_run() | change
    given = {key: value for key, value in given.items() if value is not None}
    with pytest.raises(polhode.BadInput, match=said):
        polhode.compare(given, "lagrange/nutation")


def test_a_data_frame_is_judged_with_its_index_as_time():
    pandas = pytest.importorskip("pandas")
    given = columns_of_a_run()
    frame = pandas.DataFrame(given)
    digits = polhode.compare(frame, "lagrange/nutation").digits
    assert polhode.compare(frame.set_index("time"), "lagrange/nutation").digits == digits
    assert min(digits) > 13


def test_a_run_without_rows_is_refused_with_what_ended_it():
    """It was told 15.95 correct digits of angles, of none."""
    scene = replace(polhode.load("lagrange/lower-pole").at([50]), outputs=("angles",))
    run = polhode.integrate(scene)
    assert not run.times
    with pytest.raises(polhode.BadInput, match="rows: expected a time that the run reached"):
        polhode.compare(run)


def test_empty_columns_have_no_digits(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("t,p,q,r,psi,theta,phi\n1,0,0,0,,,\n")
    found = polhode.compare(path, "euler/separatrix")
    assert found.parts == {}
    assert "angles were not judged: none of them has a value" in found.notes


@pytest.mark.parametrize("number", ["double", "extended", "quad"])
def test_a_runs_file_is_judged_as_the_run(tmp_path, number):
    """The JSON beside it names the type, unless its decimals have more digits than that."""
    run = polhode.integrate("lagrange/nutation", number, at=[4, 20])
    path = tmp_path / "x.csv"
    asked = ["lagrange/nutation", "--number", number, "--at", "4,20", "-o", str(path)]
    assert cli.main(["run", *asked]) == 0
    found, own = polhode.compare(path, "lagrange/nutation"), polhode.compare(run)
    assert found.subject.number == run.number
    assert found.digits == own.digits
    path.write_text(path.read_text().rstrip() + "1" * 9 + "\n")
    assert polhode.compare(path, "lagrange/nutation").subject.number.name == "mp"


def test_of_a_run_that_reached_no_time_no_digits_are_expected():
    run = polhode.integrate("lagrange/nutation", at=[1, 2], max_steps=2)
    assert (run.times, run.expected.digits) == ((), ())
    assert run.expected.lost_after is None


def test_what_is_expected_is_told_as_a_band():
    """To hundredths, outward, and no more digits than the type has."""
    band = Band(11.266, 12.0, 13.041)
    assert band.shown(DOUBLE) == "11.26-13.05"
    assert band._replace(most=DOUBLE.most_digits).shown(DOUBLE) == "11.26-15.95"
    assert Band(*[DOUBLE.most_digits] * 3).shown(DOUBLE) == "15.95-15.95"
    assert band._replace(least=0.0, most=0.0).shown(DOUBLE) == "none"
