"""Correct digits, drift, references: definitions checked by hand-made errors."""

import math
import pickle
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode import Body, Outcome, Scene, Trajectory
from polhode.judging import limits
from polhode.judging.correct_digits import log10_differences
from polhode.judging.score import Comparison
from polhode.judging.tables import explanations
from polhode.judging.tables import hypotheses as motions
from shared.tables import of_run
from shared.tools import DOUBLE, exactly

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
    drift = polhode.integrate(scene).drift
    assert 1e-18 < drift.f < 1e-14
    many = polhode.integrate_many(scene, {"start.omega[1]": [start, "1e-20"]})
    assert many.drift[0, 1] == pytest.approx(drift.f, rel=1e-6)


@pytest.mark.parametrize(("omega", "scale"), [("0.1", "1/10"), ("0.0999", "1"), ("3", "3")])
def test_away_from_rest_the_drift_of_f_is_measured_by_the_momentum_at_the_start(omega, scale):
    """From a tenth of the pendulum's momentum on."""
    body = {"moments": [1, 1, 1], "centre": [0, 0, 1], "weight": 1, "gamma": [0, 0, 1]}
    scene = polhode.top(omega=[0, 0, omega], end=1, **body)
    off = 2.0**-20
    departures = polhode.departures(scene, [[0, 0, float(omega) + off, 0, 0, 1]])
    assert float(departures["f"][0]) == pytest.approx(off / float(Fraction(scale)), rel=1e-9)


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


CHAOTIC = "general/asymmetric-chaotic"


@pytest.mark.parametrize(
    ("kind", "question", "said"),
    [
        ("certified", (["soon"],), rf"^{CHAOTIC}: t\[1\] = so"),
        ("certified", ([1], 300), "a whole number, 1 to 250"),
        ("two-precisions", ([1],), "= two-precisions: expected certified, which fits"),
        ("euler", ([1],), "certified, which fits"),
    ],
)
def test_what_no_reference_answers_is_refused(kind, question, said):
    with pytest.raises(polhode.BadInput, match=said):
        polhode.reference(replace(polhode.load(CHAOTIC), reference=kind)).at(*question)


def test_times_are_taken_exactly_whatever_their_kind():
    truth = polhode.reference("euler/largest-axis")
    kinds = [[Fraction(1, 2)], [0.5], ["0.5"], ["1/2"], [mpmath.mpf(0.5)]]
    rows = [truth.at(times, 30)[0] for times in kinds]
    assert all(row == rows[0] for row in rows)
    assert truth.at([0.1], 30) != truth.at(["0.1"], 30)  # the double 0.1 is another number


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
    assert polhode.compare(replace(run, attitude=half)).parts == judgement.parts


# -- a judgement is whole --------------------------------------------------------------------------


@pytest.fixture
def computes_nothing(monkeypatch):
    """A function after which nobody asks a reference, follows a motion or fits a number."""

    def refuse(*args, **options):
        raise AssertionError("something was computed")

    def stop():
        for home, name in (
            (Comparison, "rows"),
            (limits, "conditioning"),
            (explanations, "integrated"),
            (motions, "integrated"),
        ):
            monkeypatch.setattr(home, name, refuse)

    return stop


@pytest.mark.parametrize("factor", [1, 1 + 1e-5, 180 / np.pi])
@pytest.mark.parametrize("details", [False, True])
def test_what_a_judgement_means_is_found_once_and_then_read(factor, details, computes_nothing):
    run = polhode.integrate("lagrange/nutation", at=[0, 1, 2, 3, 4])
    columns = {"t": [0, 1, 2, 3, 4], **dict(zip(run.columns, run.states.T, strict=True))}
    columns |= {name: columns[name] * factor for name in "pqr"}
    judged = polhode.compare(columns, run.scene, details=details)
    _ = judged.diagnosis
    computes_nothing()
    again = pickle.loads(pickle.dumps(judged))
    assert again.to_json() == judged.to_json()
    assert (str(again), again.details()) == (str(judged), judged.details())
    assert again.limit.name == judged.limit.name
    assert bool(judged.residuals) == details


def test_digits_that_are_demanded_are_scored_and_no_more(monkeypatch):
    """A motion that has to be followed for what the digits mean is followed by who asks that."""
    run = polhode.integrate("euler/separatrix", at=[1, 20])
    judged = polhode.compare(run)
    monkeypatch.setattr(limits, "conditioning", None)
    assert 12.5 < judged.worst == min(judged.digits) < 14.5
    with pytest.raises(TypeError):
        _ = judged.limit
    assert 12.5 < polhode.testing.assert_digits(run, run.scene, 12).worst < 14.5


def test_a_limit_is_a_text_with_a_name():
    run = polhode.integrate("euler/largest-axis", at=[10], tol=1e-7)
    limit = pickle.loads(pickle.dumps(polhode.compare(run).limit))
    assert limit == "method (tolerance 1.0e-07)"
    assert (limit.name, limit.detail) == ("method", "tolerance 1.0e-07")


# -- the definition of correct digits: exact differences of numbers of any type, at any size ------

TENTH = Fraction(1, 10)


@pytest.mark.parametrize(
    ("own", "true", "log"),
    [
        (0.1, TENTH, math.log10(float(Fraction(0.1) - TENTH))),
        (np.float64(0.1), TENTH, math.log10(float(Fraction(0.1) - TENTH))),
        (np.longdouble(1) + np.longdouble(2) ** -63, 1.0, -63 * math.log10(2)),
        (1, mpmath.mpf("1.5"), math.log10(0.5)),
        (Fraction(1, 10**1000), mpmath.mpf(0), -1000.0),
        (Fraction(10) ** 400, 0.0, 400.0),
        (mpmath.mpf(3), mpmath.ldexp(1, -(10**12)), math.log10(3)),  # e^-t of a late time
        (0.25, Fraction(1, 4), -math.inf),
        (math.inf, 1.0, math.inf),
        (mpmath.inf, 1.0, math.inf),
        (math.nan, 1.0, math.nan),
        (None, 1.0, math.nan),
        (1.0, None, math.nan),
    ],
)
def test_a_difference_is_exact(own, true, log):
    logs = log10_differences([[own]], [[true]])
    assert logs.shape == (1, 1)
    assert logs[0, 0] == pytest.approx(log, rel=1e-13, nan_ok=True)


@pytest.mark.parametrize(("turns", "off"), [(0, 1e-9), (1, 1e-9), (-3, -1e-9), (10**6, 1e-12)])
def test_whole_turns_are_taken_away(turns, off):
    (row,) = polhode.reference(SCENE).angles([1], 50)
    with mpmath.workprec(200):
        angles = [[row[0] + 2 * mpmath.pi * turns + off, *row[1:]]]
    judged = polhode.compare(angles, SCENE, at=[1], columns=("psi", "theta", "phi"))
    assert judged.worst == pytest.approx(-math.log10(abs(off)), abs=1e-6)


def test_of_w_relative_to_its_largest_modulus_and_of_gamma_as_they_are():
    body = Body.of_moments((3, 2, 1), (0, 0, 1), 1)
    scene = Scene(body, (3, 0, 4), (0, 0, 1))
    true = [[3, 0, 4, 0, 0, 1], [0, 0, 1, 0, 0, 1]]
    states = [[3 + 5e-6, 0, 4, 0, 0, 1], [None, 0, 1, 1e-7, 0, 1]]
    assert polhode.state_errors(states, true, scene) == pytest.approx([1e-6, 1e-7], rel=1e-9)
    assert polhode.state_errors(true, true, scene).tolist() == [0, 0]


@pytest.mark.parametrize(("planted", "digits"), [(0, 250), (20, 20)])
def test_a_table_of_hundreds_of_digits(planted, digits):
    """The reference is asked for few digits first, and for all where it could hide some."""
    case, times = "euler/attitude", [0, 1, 2]
    rows = [[exactly(x) for x in row] for row in polhode.reference(case).at(times, 260)]
    for row in rows[1:]:
        row[3] += Fraction(1, 10**planted) if planted else 0
    judgement = polhode.compare(rows, case, at=times, number="mp", digits=250)
    assert judgement.digits[0] > 249
    assert judgement.digits[1:] == pytest.approx((digits, digits), abs=8)


@pytest.mark.parametrize("size", [Fraction(1), Fraction(2) ** -1200, Fraction(10) ** 320])
def test_units_of_any_size(size):
    """|w| that no double holds."""
    body = Body.of_moments((3, 2, 1), (0, 0, 0), 0)
    scene = Scene(body, (3 * size, 0, 4 * size), None)
    true = [[3 * size, 0 * size, 4 * size]]
    own = [[3 * size * (1 + Fraction(1, 10**8)), 0 * size, 4 * size]]
    assert polhode.state_errors(own, true, scene) == pytest.approx(3 / 5 * 1e-8, rel=1e-6)


# -- assertions of correct digits, as other programs' tests use them -------------------------------


SCENE = "lagrange/nutation"


@pytest.fixture(scope="module")
def run():
    return polhode.integrate(SCENE)


def test_a_function_of_t_is_asked_at_the_times(run):
    judged = polhode.testing.assert_digits(lambda t: run(t), SCENE, at_least=12, at=[1, "0.25"])
    assert [float(t) for t in judged.times] == [1, 0.25]


def test_the_error_tells_the_first_wrong_time_and_the_judgement(run):
    def mine(t):
        return run(t) + (1e-6 if t > 1.5 else 0)

    with pytest.raises(AssertionError) as error:
        polhode.testing.assert_digits(mine, SCENE, at_least=9, at=[1, 2, 3])
    first, *rest = str(error.value).splitlines()
    assert first == "6.00 correct digits at t = 2, where at least 9 are wanted"
    assert "\n".join(rest).startswith("t  correct digits")
    assert "fewer than double precision allows" in str(error.value)


def test_another_convention_is_wrong_unless_it_is_allowed(run):
    columns = of_run(run)
    columns |= {"p": columns["q"], "q": columns["p"]}
    with pytest.raises(AssertionError, match="correct digits at t = "):
        polhode.testing.assert_digits(columns, SCENE, at_least=9)
    judged = polhode.testing.assert_digits(columns, SCENE, at_least=9, as_it_stands=False)
    assert judged.reading == "omega p q r = q p r"


# -- The fixture of pytest, in a session of its own


_TESTS = """
import polhode

RUN = polhode.integrate("lagrange/nutation", at=[1, 2])

def test_right(assert_digits):
    assert assert_digits(RUN, "lagrange/nutation", at_least=13).worst > 13

def test_wrong(assert_digits):
    assert_digits(lambda t: RUN.states[0] + 1e-6, "lagrange/nutation", 9, at=[1])

def test_two(assert_digits):
    for _ in range(2):
        assert_digits(RUN, "lagrange/nutation", 13)

def test_that_asks_for_nothing():
    pass
"""


PLACES = "--junitxml=x.xml", "--polhode-report=r.md"


def session(folder, *options, tests=_TESTS):
    """What pytest prints of the tests."""
    (folder / "test_mine.py").write_text(tests)
    without = ("-p", "no:cacheprovider", "-p", "no:hypothesispytest")
    command = [sys.executable, "-m", "pytest", "-q", *without, *options]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert ran.returncode == 1, ran.stdout
    return ran.stdout


@pytest.mark.slow
def test_digits_stand_at_the_end_in_the_xml_and_on_a_page(tmp_path):
    """Each judgement once, and which failed, of all workers."""
    printed = session(tmp_path, *PLACES, "-W", "error", "-n", "2")
    assert "1 failed, 3 passed" in printed
    assert "6.00 correct digits at t = 1, where at least 9 are wanted" in printed
    end = printed.partition("= correct digits =")[2].splitlines()
    lines = sorted(line for line in end if " correct digits of lagrange/nutation" in line)
    names = ["test_right", "test_two", "test_two", "test_wrong"]
    assert [line.partition(":: ")[0].split("::")[1].partition(":")[0] for line in lines] == names
    assert lines[-1] == "test_mine.py::test_wrong: 6.00 correct digits of lagrange/nutation"
    assert all(13 < float(line.split()[1]) <= 16 for line in lines[:-1])
    written = {
        case.get("name"): [
            p.get("value") for p in case.iter("property") if p.get("name") == "correct_digits"
        ]
        for case in ET.parse(tmp_path / "x.xml").iter("testcase")
    }
    assert written.pop("test_wrong") == ["6.0"]
    counts = {name: len(digits) for name, digits in written.items()}
    assert counts == {"test_right": 1, "test_two": 2, "test_that_asks_for_nothing": 0}
    page = (tmp_path / "r.md").read_text().splitlines()
    rows = sorted(line.split(" | ")[:3] for line in page if line.startswith("| test_mine"))
    assert [row[0].partition("::")[2] for row in rows] == names
    assert [row[1] for row in rows] == ["● passed"] * 3 + ["○ failed"]
    assert rows[-1][2] == "6.00"


def test_a_session_that_does_not_ask_imports_nothing_more():
    code = "import sys, polhode.pytest_plugin; print(sorted({'numpy', 'heyoka'} & {*sys.modules}))"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ran.stdout == "[]\n"


_WRONG = """
from polhode import testing

def test_few(assert_digits):
    assert_digits(lambda t: [1, 2, 3, 0, 0, 1], "lagrange/nutation", 9, at=[1])

def test_bad(assert_digits):
    assert_digits(lambda t: [float("nan")] * 6, "lagrange/nutation", 9, at=[1])

def mine(t):
    return testing.order_of(None, "lagrange/nutation")

def test_own_function(assert_digits):
    assert_digits(mine, "lagrange/nutation", 9, at=[1])
"""


@pytest.mark.slow
def test_what_fails_shows_the_users_line_and_no_source_of_polhode(tmp_path):
    printed = session(tmp_path, *PLACES, "-p", "no:xdist", tests=_WRONG)
    assert "3 failed" in printed
    assert "test_few: 0.20 correct digits of lagrange/nutation" in printed
    assert 'name="correct_digits" value="0.2"' in (tmp_path / "x.xml").read_text()
    assert "○ failed" in (tmp_path / "r.md").read_text()
    few, bad, own = printed.partition("FAILURES")[2].split("________ test_")[1:]
    for output in (few, bad):
        assert "polhode/" not in output
        assert output.count("test_mine.py:") == 1
    assert "return testing.order_of(None" in own  # a fault of the user's function is shown, too


def test_a_page_that_cannot_be_written_is_refused_before_the_tests(tmp_path):
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--polhode-report=r.txt"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert ran.returncode == 4
    assert "--polhode-report: r.txt: -o: expected a name that ends in .html or .md" in ran.stderr
