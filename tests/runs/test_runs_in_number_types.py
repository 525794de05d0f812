"""Number types and what is asked of a run in each: digits, arrays, any time, files."""

import copy
import math
import pickle
import time
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from shared.motions import heavy
from shared.tools import DOUBLE, change_policy, exactly, tiers

NAME, TIMES = "lagrange/nutation", [0, 1, 2, 5]


TYPES = {"double": np.float64, "extended": np.longdouble, "quad": object, "mp": object}


@pytest.fixture(scope="module", params=TYPES)
def run(request) -> polhode.Trajectory:
    events = polhode.Event("nutation"), polhode.Event("high", "gamma3 - 1/2")
    scene = replace(polhode.load(NAME), outputs=("angles", "attitude", "hodographs"), events=events)
    return polhode.integrate(scene, at=TIMES, number=request.param)


@pytest.fixture
def kind(run) -> type:
    """What numpy takes its numbers for."""
    return TYPES[run.number.name]


def worst(rows, others) -> float:
    """The largest difference of two tables."""
    pairs = (pair for a, b in zip(rows, others, strict=True) for pair in zip(a, b, strict=True))
    return max(abs(float(exactly(x) - exactly(y))) for x, y in pairs)


# -- digits ---------------------------------------------------------------------------------------


def test_every_number_of_a_run_has_the_digits_of_its_type(run):
    """States, angles, attitude, hodographs by the closed form; states of events at their times."""
    judged, most, eps = polhode.compare(run), run.number.most_digits, float(run.number.eps)
    for digits in (*judged.digits[1:], *judged.parts.values()):
        assert most - 2.4 < digits <= most + 0.1
    truth = polhode.reference(run.scene)
    space = truth.hodographs(run.times, 60).space
    assert eps / 20 < worst(run.hodographs.space, space) < 250 * eps
    for event in run.events:
        assert len(event.times) > 2
        assert worst(event.states, truth.at(event.times, 60)) < 150 * eps
    start = zip(run.states[0], run.scene.start, strict=True)
    assert all(exactly(x) == run.number.rounded(exact) for x, exact in start)


@pytest.mark.parametrize(
    ("number", "name", "at"),
    tiers(
        [
            ("double", "euler/turned-axes", [1, 20]),
            ("extended", "euler/backward", [-1, -20]),
            ("quad", "kovalevskaya/irrational-centre", [1, 10]),
        ],
        [
            ("double", "euler/tiny-units", [1, 20]),
            ("quad", "euler/angles-start", [1, 10]),
            ("quad", "lagrange/planar-rotating", [1, 10]),
            ("quad", "pendulum/about-third-axis", [1, 10]),
        ],
    ),
)
def test_bodies_of_any_axes_and_units_have_them_too(name, at, number):
    """Irrational axes and coefficients: none of them is a double in a wider type."""
    scene = replace(polhode.load(name), outputs=("attitude", "angles"), events=())
    run = polhode.integrate(scene, number, at=at)
    judged, most = polhode.compare(run), run.number.most_digits
    for digits in (*judged.digits, *judged.parts.values()):
        assert most - 2.4 < digits <= most + 0.6


@pytest.mark.parametrize("number", tiers(["double", "quad"], ["extended", "mp"]))
def test_output_times_never_change_the_steps(number):
    scene = polhode.load("general/asymmetric-chaotic")
    few = polhode.integrate(scene, at=[10], number=number)
    many = polhode.integrate(scene, at=[*range(1, 10), Fraction(19, 2), 10], number=number)
    assert few.steps == many.steps
    assert [exactly(x) for x in few.states[-1]] == [exactly(x) for x in many.states[-1]]


# -- arrays ---------------------------------------------------------------------------------------


def test_states_are_arrays_and_columns_go_by_their_names(run, kind):
    assert run.states.shape == (4, 6)
    assert run.attitude.shape == (4, 4)
    assert run.omega.shape == run.gamma.shape == (4, 3)
    assert run.states.dtype == run.attitude.dtype == kind
    for name in ("p", "r", "gamma2", "psi", "theta", "phi", "q0", "q3", "omega_x", "t"):
        column = run[name]
        assert column.shape == (4,)
        assert column.dtype == (np.float64 if name == "t" else kind)
        if name in run.columns:
            assert column.tolist() == run.states[:, run.columns.index(name)].tolist()
    for place, name in enumerate(("psi", "theta", "phi")):
        assert getattr(run, name).tolist() == run[name].tolist()
        assert run[name].tolist() == [row[place] for row in run.angles]
    with mpmath.workprec(run.number.bits):  # they compute with the bits that they have
        assert all(abs(x - 1) < 64 * float(run.number.eps) for x in (run.gamma**2).sum(axis=1))
    with pytest.raises(KeyError, match="did you mean 'gamma1'"):
        run["gama1"]
    with pytest.raises(TypeError):
        iter(run)


def test_events_go_by_their_names(run):
    assert run.events["nutation"] == run.events[0]
    assert run.events["high"].t.dtype == np.float64
    assert [event.name for event in run.events] == ["nutation", "high"]
    with pytest.raises(KeyError, match="did you mean 'nutation'"):
        run.events["nutations"]


def test_nothing_is_written_into(run, tmp_path):
    """Nor into what is read again, from a pickle, a copy or a file, which is the same."""
    drift, psi = run.drift, run["psi"].tolist()
    event = run.events["nutation"]
    events = (event, pickle.loads(pickle.dumps(event)), event.until(event.times[0]))
    arrays = (run.states, run.attitude, run.omega, run["p"], run["theta"], run["omega_x"])
    for rows in (*arrays, *(e.states for e in events)):
        with pytest.raises(ValueError, match="read-only"):
            rows[0] = 0
    with pytest.raises(TypeError, match="does not support item assignment"):
        run.angles[0][0] = 7
    copies = [pickle.loads(pickle.dumps(run)), copy.deepcopy(run)]
    for ending in (".npz", ".json"):
        run.save(tmp_path / f"x{ending}")
        copies.append(polhode.load_result(tmp_path / f"x{ending}"))
    for again in copies:
        assert again == run
        assert again.states.dtype == run.states.dtype
        with pytest.raises(ValueError, match="read-only"):
            again.states[0, 0] = 0
    assert (run.drift, run["psi"].tolist()) == (drift, psi)
    assert list(copies[0]("1/3")) == list(run("1/3"))


@pytest.mark.parametrize(("number", "end"), [("double", 10**7), ("quad", 10**5)])
def test_a_loaded_run_that_ended_early_is_not_made_to_its_end(number, end, tmp_path):
    """That would take half a minute or more."""
    run = polhode.integrate(NAME, number, at=[1, end], max_steps=30, method="taylor")
    run.save(tmp_path / "x.npz")
    again = polhode.load_result(tmp_path / "x.npz")
    began = time.process_time()
    for t in (2, run.reached):
        assert list(again(t)) == list(run(t))
    assert time.process_time() - began < 10


def test_more_steps_than_are_usual_are_allowed_again(monkeypatch, tmp_path):
    """What was asked of a run afterwards ended at the type's own limit."""
    change_policy(monkeypatch, max_steps=100)
    run = polhode.integrate(replace(polhode.load(NAME), outputs=()), at=[100], max_steps=10**4)
    run.save(tmp_path / "x.npz")
    assert run.steps > 100
    assert polhode.load_run(tmp_path / "x.npz")(99).tolist() == run(99).tolist()
    top = replace(run.scene, outputs=("angles", "attitude"))
    beside = polhode.integrate(top, at=[99], max_steps=10**4)
    assert worst([run.attitude_at(99)], beside.attitude) < 1e-12
    assert worst([run.angles_at(99)], beside.angles) < 1e-11


def test_rounded_inputs_are_those_of_an_attitude_asked_for_later():
    """It was that of the exact scene, 1e-16 away."""
    top = replace(polhode.load(NAME), outputs=())
    late, early = (
        polhode.integrate(replace(top, outputs=x), "quad", inputs=DOUBLE, at=[1])
        for x in ((), ("attitude",))
    )
    assert late.inputs == DOUBLE
    assert worst([late.attitude_at("1/2")], [early.attitude_at("1/2")]) < 1e-32


def test_runs_with_no_rows_and_rows_with_no_numbers():
    free = polhode.integrate("euler/no-gamma", at=[1])
    assert (free.states.shape, free.gamma.shape) == ((1, 3), (1, 0))
    short = polhode.integrate(NAME, "quad", at=[1000], max_steps=3)
    assert (short.states.shape, short["p"].shape) == ((0, 6), (0,))
    never = replace(polhode.load(NAME), events=(polhode.Event("far", "gamma3 - 2"),))
    pole = replace(polhode.load("lagrange/from-the-pole"), outputs=("angles",))
    for number in ("double", "quad"):
        assert polhode.integrate(never, number, at=[1]).events[0].states.shape == (0, 6)
        assert math.isnan(polhode.integrate(pole, number, at=[0]).psi[0])


# -- the state at any time ------------------------------------------------------------------------


def test_a_run_is_called_at_any_time(run, kind):
    """At output times to the bit, between them as accurate, and of the same kind."""
    assert [[*row] for row in run(TIMES)] == [[*row] for row in run.states]
    between = ["1/3", "2.7", "sqrt(2)*3"]
    true = polhode.reference(run.scene).at(between, 60)
    for t, exact in zip(between, true, strict=True):
        row = run(t)
        assert (row.shape, row.dtype) == ((6,), kind)
        assert worst([row], [exact]) < 100 * float(run.number.eps)
    assert (run(between).shape, run([]).shape) == ((3, 6), (0, 6))
    assert type(run([0.5])[0][0]) is type(run.states[0][0])
    for t in (0.5, Fraction(1, 2), np.float64(0.5), np.longdouble(0.5), mpmath.mpf(0.5)):
        assert [*run(t)] == [*run("1/2")]
    for wrong in (5.000001, -1e-9, "21", math.inf, math.nan, "x", None):
        with pytest.raises(ValueError, match="expected a time from 0 to 5"):
            run(wrong)


@pytest.mark.parametrize("number", tiers(["quad"], ["double", "extended", "mp"]))
def test_a_backward_run_is_called_backward(number):
    run = polhode.integrate(heavy("-20"), number)
    again = run(run.times)
    assert [[*row] for row in again] == [[*row] for row in run.states]
    with pytest.raises(polhode.BadInput, match="from 0 to -20"):
        run(1)


# -- which type -----------------------------------------------------------------------------------


def test_a_narrower_type_than_digits_need_is_refused(monkeypatch):
    scene = polhode.load("euler/largest-axis").at((Fraction(1),))
    with pytest.raises(polhode.BadInput, match="digits = 30: expected fewer in double; quad"):
        polhode.integrate(scene, "double", digits=30)
    monkeypatch.setattr("polhode.numbers.number_types.extended_here", lambda: False)
    with pytest.raises(polhode.BadInput, match="no 64 bits here"):
        polhode.integrate(scene, "extended")
    assert polhode.integrate(scene, digits=16).number.name == "quad"


def test_numbers_outside_the_range_of_a_type_are_refused():
    scene = polhode.load("euler/largest-axis")
    tiny = replace(scene, omega=(Fraction(1, 10**350), Fraction(1), Fraction(1)))
    with pytest.raises(polhode.BadInput, match="range of double"):
        polhode.integrate(tiny, at=[1])
    assert polhode.integrate(tiny, "quad", at=[1]).outcome.done
    close = [1, 1 + Fraction(1, 10**20)]
    with pytest.raises(polhode.BadInput, match="differ when rounded to double"):
        polhode.integrate(scene, at=close)
    run = polhode.integrate(scene, "quad", at=close)
    assert run.times[1] > run.times[0]
