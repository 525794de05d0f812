"""A run's numbers as arrays, by name, in every number type; and nobody writes into them."""

from __future__ import annotations

import copy
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

import polhode

TYPES = {"double": np.float64, "extended": np.longdouble, "quad": object, "mp": object}


@pytest.fixture(scope="module", params=TYPES)
def run(request):
    scene = replace(
        polhode.load("lagrange/nutation"),
        outputs=("angles", "attitude", "hodographs"),
        events=(polhode.Event("nutation"), polhode.Event("high", "gamma3 - 0.5")),
    )
    digits = 40 if request.param == "mp" else None
    return polhode.integrate(scene, request.param, digits=digits, at=[0, 1, 2, 5])


def test_states_are_an_array(run):
    kind = TYPES[run.number.name]
    assert run.states.shape == (4, 6)
    assert run.states.dtype == kind
    assert run.attitude.shape == (4, 4)
    assert run.omega.shape == run.gamma.shape == (4, 3)
    assert run.states[:, 0].tolist() == [row[0] for row in run.states]


@pytest.mark.parametrize(
    "name", ["p", "r", "gamma2", "psi", "theta", "phi", "q0", "q3", "omega_x", "t"]
)
def test_a_column_by_its_name(run, name):
    column = run[name]
    assert column.shape == (4,)
    assert column.dtype == (np.float64 if name == "t" else TYPES[run.number.name])
    if name in run.columns:
        assert column.tolist() == run.states[:, run.columns.index(name)].tolist()
    if name in ("psi", "theta", "phi"):
        assert getattr(run, name).tolist() == column.tolist()
        place = ("psi", "theta", "phi").index(name)
        assert column.tolist() == [row[place] for row in run.angles]


def test_the_state_at_any_time_is_an_array_too(run):
    assert run("1/3").shape == (6,)
    assert run([0, "1/3"]).shape == (2, 6)
    assert run([]).shape == (0, 6)
    assert run("1/3").dtype == run.states.dtype


def test_columns_compute(run):
    """With the bits that they have."""
    import mpmath

    with mpmath.workprec(run.number.bits):
        length = (run.gamma**2).sum(axis=1)
        assert all(abs(x - 1) < 64 * float(run.number.eps) for x in length)


def test_nothing_is_written_into(run):
    drift = run.drift
    for rows in (run.states, run.attitude, run.omega, run["p"], run["theta"]):
        with pytest.raises(ValueError, match="read-only"):
            rows[0] = 0
    for again in (pickle.loads(pickle.dumps(run)), copy.deepcopy(run)):
        assert again == run
        with pytest.raises(ValueError, match="read-only"):
            again.states[0, 0] = 0
    assert run.drift == drift


def test_events_by_name(run):
    assert run.events["nutation"] == run.events[0]
    assert run.events["high"].t.dtype == np.float64
    assert [event.name for event in run.events] == ["nutation", "high"]
    with pytest.raises(KeyError, match="did you mean 'nutation'"):
        run.events["nutations"]


def test_what_is_no_column_is_told(run):
    with pytest.raises(KeyError, match="did you mean 'gamma1'"):
        run["gama1"]
    with pytest.raises(TypeError):
        iter(run)


def test_angles_that_are_not_defined_are_nan():
    scene = replace(polhode.load("lagrange/lower-pole"), outputs=("angles",))
    for number in TYPES:
        run = polhode.integrate(scene, number, digits=30 if number == "mp" else None, at=[0])
        if run.angles[0][0] is None:
            assert math.isnan(run.psi[0])


def test_a_run_without_gamma():
    run = polhode.integrate("euler/no-gamma", at=[1])
    assert run.states.shape == (1, 3)
    assert run.gamma.shape == (1, 0)


def test_a_run_that_reached_nothing_has_no_rows():
    run = polhode.integrate("lagrange/nutation", "quad", at=[1000], max_steps=3)
    assert run.states.shape == (0, 6)
    assert run["p"].shape == (0,)


def test_what_is_read_again_is_the_same(run, tmp_path):
    for ending in (".npz", ".json"):
        run.save(tmp_path / f"x{ending}")
        again = polhode.load_result(tmp_path / f"x{ending}")
        assert again == run
        assert again.states.dtype == run.states.dtype
        with pytest.raises(ValueError, match="read-only"):
            again.states[0, 0] = 0


@pytest.mark.parametrize("asked", [{"number": "double"}, {"number": "extended"}, {"digits": 40}])
def test_states_of_events_cannot_be_written_into(asked):
    scene = replace(polhode.load("lagrange/nutation"), events=(polhode.Event("nutation"),))
    found = polhode.integrate(scene, at=[3], **asked).events["nutation"]
    again = pickle.loads(pickle.dumps(found))
    for one in (found, again, found.until(found.times[0])):
        assert one.states.shape == (len(one.times), 6)
        with pytest.raises(ValueError, match="read-only"):
            one.states[0, 0] = 7
    nothing = replace(scene, events=(polhode.Event("far", "gamma3 - 2"),))
    assert polhode.integrate(nothing, at=[3], **asked).events["far"].states.shape == (0, 6)


def test_rows_of_angles_cannot_be_written_into(run):
    before = run["psi"].tolist()
    with pytest.raises(TypeError, match="does not support item assignment"):
        run.angles[0][0] = 7
    assert run["psi"].tolist() == before
