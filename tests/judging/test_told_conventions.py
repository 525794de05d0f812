"""Conventions told by hand are applied, whatever digits they give, and no others."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_readings_together import columns_of, quaternion_times

import polhode
from polhode.cli import main
from polhode.common.errors import BadInput
from polhode.scenes.vocabulary import ATTITUDE, STATE

CASE = "lagrange/nutation"


@pytest.fixture(scope="module")
def columns():
    scene = polhode.load(CASE).at([k / 8 for k in range(17)])
    run = polhode.integrate(scene)
    found = {name: columns_of(run, name) for name in (*STATE, *ATTITUDE)}
    return {"t": np.array([float(t) for t in run.t])} | found


def in_degrees(columns):
    return columns | {name: np.degrees(columns[name]) for name in STATE[:3]}


def scalar_last(columns):
    return columns | {f"q{k}": columns[f"q{(k + 1) % 4}"] for k in range(4)}


def y_up(columns):
    half = math.sqrt(0.5)
    return quaternion_times(columns, left=np.array([half, -half, 0, 0]))


def in_milliseconds(columns):
    return columns | {"t": 1000 * columns["t"]}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ([in_degrees], "degrees"),
        ([scalar_last], "scalar-last"),
        ([scalar_last], "qw last"),
        ([y_up], "y-up"),
        ([y_up], "y up"),
        ([in_milliseconds], "t milliseconds"),
        ([in_degrees, scalar_last], "degrees, scalar-last"),
        ([in_degrees, scalar_last, in_milliseconds], "ms ,qw last,deg"),
    ],
)
def test_what_is_told_is_applied(columns, changes, told):
    changed = columns
    for change in changes:
        changed = change(changed)
    found = polhode.compare(changed, CASE, read=told)
    assert found.worst > 14
    assert polhode.compare(changed, CASE, as_it_stands=True).worst < 2


def test_it_is_the_reading_that_is_found(columns):
    changed = scalar_last(in_degrees(columns))
    found = polhode.compare(changed, CASE)
    told = polhode.compare(changed, CASE, read=", ".join(r.convention for r in found.readings))
    assert told.readings == found.readings
    assert told.digits == found.digits


def angles_of(columns, turned=0):
    found = polhode.reference(CASE).angles([float(t) for t in columns["t"]], 20)
    psi, theta, phi = np.degrees(np.array(found, dtype=float)).T
    return {"t": columns["t"], "psi": psi + turned, "theta": theta, "phi": phi}


@pytest.mark.parametrize("told", ["degrees", "in degrees", "angles in degrees", "deg"])
def test_angles_in_degrees_are_told(columns, told):
    found = polhode.compare(angles_of(columns, 360), CASE, read=told)
    assert found.worst > 13
    assert found.reading == "angles in degrees; psi and phi up to whole turns"
    assert polhode.compare(angles_of(columns), CASE, read=told).reading == "angles in degrees"


@pytest.mark.parametrize(
    "changed",
    [
        lambda columns: scalar_last(in_degrees(columns)),
        lambda columns: y_up(columns),
        lambda columns: in_degrees(columns | {"p": columns["q"], "q": columns["p"]}),
        lambda columns: columns | {"t": columns["t"] + 5},
        lambda columns: in_degrees(columns) | angles_of(columns, 360),
        lambda columns: in_milliseconds(scalar_last(columns)),
    ],
)
def test_what_compare_prints_can_be_told(columns, changed):
    found = polhode.compare(changed(columns), CASE)
    assert found.reading is not None
    told = polhode.compare(changed(columns), CASE, read=found.reading)
    assert told.worst > 13
    assert told.part_digits == found.part_digits


@pytest.mark.slow
def test_a_convention_is_told_of_one_part(columns):
    both = columns | angles_of(columns)
    found = polhode.compare(both, CASE, read="angles in degrees")
    assert found.worst > 13
    assert polhode.compare(both, CASE, read="degrees").reading.startswith("omega degrees; angles")


def test_axes_are_told_as_a_reading_tells_them(columns):
    changed = columns | {"p": columns["q"], "q": columns["p"]}
    assert polhode.compare(changed, CASE, read="p q r = q p r").worst > 14


def test_what_makes_a_right_table_wrong_is_applied_too(columns):
    found = polhode.compare(columns, CASE, read="degrees")
    assert found.worst < 1
    assert found.reading == "omega degrees"


def test_nothing_else_is_tried(columns):
    found = polhode.compare(scalar_last(in_degrees(columns)), CASE, read="degrees")
    assert found.worst_part == "attitude"
    assert found.worst < 1
    assert [reading.part for reading in found.readings] == ["omega"]


@pytest.mark.parametrize("told", ["sideways", "degrees, sideways", "", " , "])
def test_what_is_none_is_refused(columns, told):
    with pytest.raises(BadInput, match=r"read = .*: expected conventions"):
        polhode.compare(columns, CASE, read=told)


def test_a_convention_of_a_part_that_is_not_there_is_refused(columns):
    some = {name: columns[name] for name in ("t", *STATE)}
    with pytest.raises(BadInput, match="read = scalar-last"):
        polhode.compare(some, CASE, read="scalar-last")


@pytest.mark.parametrize(
    ("told", "refused", "why"),
    [
        ("y up, left-handed", "left-handed", "expected conventions: degrees, rpm"),
        ("degrees", "degrees", "expected omega or angles in every row; the table has attitude"),
        ("omega degrees", "degrees", "expected omega in every row; the table has attitude"),
        ("attitude degrees", "degrees", "a convention of attitude; this one is of omega or angles"),
        ("turns about z-x-z in degrees", "turns about", "this one is reported, and not applied"),
        ("along the axes of space", "along the axes", "this one is reported, and not applied"),
        (
            "a constant rotation of 30° about (0, 0, 1) in space axes",
            "a constant rotation of 30° about .0, 0, 1. in space axes",
            "this one is reported, and not applied",
        ),
        ("y up", "y up", "a quaternion that nearly has the first row's attitude in it"),
        ("scalar-last, q1 the scalar", ".* the scalar|scalar-last", "no second convention"),
    ],
)
def test_the_refusal_names_the_word_and_why(columns, told, refused, why):
    some = {name: columns[name] for name in ("t", *ATTITUDE)}
    some = quaternion_times(some, left=np.array([0.8, 0.36, 0.48, 0]))
    with pytest.raises(BadInput, match=f"read = (?:{refused}).*: .*{why}"):
        polhode.compare(some, CASE, read=told)


def test_the_command_line(columns, tmp_path, capsys):
    path = tmp_path / "x.csv"
    rows = np.array([*in_degrees(columns).values()]).T
    np.savetxt(path, rows, delimiter=",", fmt="%.17g", header=",".join(columns), comments="")
    command = ["compare", str(path), CASE, "--read"]
    assert main([*command, "degrees"]) == 0
    assert "read as" in capsys.readouterr().out
    assert main([*command, "sideways"]) == 2
    assert capsys.readouterr().err.startswith("polhode: ")
