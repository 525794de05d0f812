"""Files in other conventions: synonyms are taken, a wrong file is told how it would be right."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import cli
from polhode.judging.diagnosis import rotation_matrices
from polhode.judging.tables.column_aliases import Column, column
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, STATE

TIMES = tuple(Fraction(k, 4) for k in range(21))
SCENE = polhode.load("lagrange/nutation").at(TIMES)
EXACT = polhode.reference(SCENE)
COLUMNS = {
    "t": [float(t) for t in TIMES],
    **{
        name: [float(x) for x in column]
        for names, rows in (
            (STATE, EXACT.at(TIMES, 20)),
            (ANGLES, EXACT.angles(TIMES, 20)),
            (ATTITUDE, EXACT.attitude(TIMES, 20)),
        )
        for name, column in zip(names, zip(*rows, strict=True), strict=True)
    },
}
MATRICES = rotation_matrices.matrices(np.array([COLUMNS[name] for name in ATTITUDE]).T)


def written(path, **columns):
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(columns)
        out.writerows([repr(float(x)) for x in row] for row in zip(*columns.values(), strict=True))
    return path


def judged(path, **columns):
    return polhode.compare(written(path / "x.csv", t=COLUMNS["t"], **columns), SCENE)


def of(names):
    return {name: COLUMNS[name] for name in names}


@pytest.mark.parametrize(
    ("header", "meant"),
    [
        ("time", Column("t")),
        ("Time [s]", Column("t")),
        ("qx", Column("q1")),
        ("qw", Column("q0")),
        ("wz", Column("r")),
        ("w_x [rad/s]", Column("p")),
        ("p [deg/s]", Column("p", True)),
        ("psi_deg", Column("psi", True)),
        ("theta (degrees)", Column("theta", True)),
        ("gamma_y", Column("gamma2")),
        ("gx", Column("gamma1")),
        ("g3", Column("gamma3")),
        ("q0", Column("q0")),
        ("psi_old", Column(None)),
        ("deg", Column(None)),
        ("", Column(None)),
    ],
)
def test_names_of_other_programs(header, meant):
    assert column(header) == meant


def test_synonyms_and_degrees_are_judged_as_what_they_are(tmp_path):
    quaternion = dict(zip(("qw", "qx", "qy", "qz"), of(ATTITUDE).values(), strict=True))
    omega = dict(zip(("wx", "wy", "wz"), of(STATE[:3]).values(), strict=True))
    degrees = {f"{name}_deg": [math.degrees(x) for x in COLUMNS[name]] for name in ANGLES}
    plain = judged(tmp_path, **of([*STATE[:3], *ATTITUDE, *ANGLES]))
    found = judged(tmp_path, **omega, **quaternion, **degrees)
    assert found.digits == plain.digits
    assert found.parts["attitude"] == plain.parts["attitude"] > 15
    assert 14 < found.parts["angles"] < 16.5
    assert not found.readings


def right_once(found, part, convention, least=14.0):
    (reading,) = [reading for reading in found.readings if reading.part == part]
    assert reading.convention == convention
    assert reading.as_it_stands < 1
    assert least < reading.digits <= 15
    assert f"read as {convention}" in str(found)


def test_a_scalar_last_quaternion_is_named(tmp_path):
    rolled = dict(zip(ATTITUDE, [COLUMNS[n] for n in ("q1", "q2", "q3", "q0")], strict=True))
    right_once(judged(tmp_path, **rolled), "attitude", "scalar-last")


def test_a_quaternion_numbered_from_one_ends_with_its_scalar(tmp_path):
    """q1 q2 q3 q4 with q4 the scalar is right as it stands, with q1 the scalar it is named."""
    numbered = ("q1", "q2", "q3", "q4")
    last = dict(zip(numbered, [COLUMNS[n] for n in ("q1", "q2", "q3", "q0")], strict=True))
    found = judged(tmp_path, **last)
    assert found.parts["attitude"] > 15
    assert found.readings == ()
    assert "column gamma2 is not in the file" in found.notes
    told = [line for line in str(found).splitlines() if "not in the file" in line]
    assert told == ["not judged: columns p q r gamma1 gamma2 gamma3 are not in the file"]
    first = dict(zip(numbered, [COLUMNS[n] for n in ATTITUDE], strict=True))
    right_once(judged(tmp_path, **first), "attitude", "q1 the scalar")


def test_an_inverse_quaternion_is_named(tmp_path):
    inverse = of(ATTITUDE) | {name: [-x for x in COLUMNS[name]] for name in ATTITUDE[1:]}
    right_once(judged(tmp_path, **inverse), "attitude", "body from space")
    rolled = dict(zip(ATTITUDE, [inverse[n] for n in ("q1", "q2", "q3", "q0")], strict=True))
    right_once(judged(tmp_path, **rolled), "attitude", "scalar-last, body from space")


def test_signs_that_change_along_the_way_are_named(tmp_path):
    signs = [1 - 2 * (k % 3 == 1) for k in range(len(TIMES))]
    turned = {name: [s * x for s, x in zip(signs, COLUMNS[name], strict=True)] for name in ATTITUDE}
    right_once(judged(tmp_path, **turned), "attitude", "of either sign at each time")


def test_a_downward_vertical_is_named(tmp_path):
    down = {name: [-x for x in COLUMNS[name]] for name in STATE[3:]}
    right_once(judged(tmp_path, **of(STATE[:3]), **down), "gamma", "the downward vertical")


def test_omega_along_the_axes_of_space_or_in_degrees_is_named(tmp_path):
    omega = np.array([COLUMNS[name] for name in STATE[:3]]).T
    space = np.einsum("nij,nj->ni", MATRICES, omega)
    columns = dict(zip(STATE[:3], space.T, strict=True))
    right_once(judged(tmp_path, **columns), "omega", "along the axes of space")
    columns = dict(zip(STATE[:3], np.degrees(space.T), strict=True))
    right_once(judged(tmp_path, **columns), "omega", "along the axes of space degrees")
    columns = dict(zip(STATE[:3], np.degrees(omega.T), strict=True))
    right_once(judged(tmp_path, **columns), "omega", "degrees")


def test_another_sequence_of_angles_is_named(tmp_path):
    """Yaw, pitch, roll: R = Rz(yaw) Ry(pitch) Rx(roll), written out from its matrix."""
    r = MATRICES
    yaw, roll = np.arctan2(r[:, 1, 0], r[:, 0, 0]), np.arctan2(r[:, 2, 1], r[:, 2, 2])
    pitch = np.arcsin(-r[:, 2, 0])
    found = judged(tmp_path, yaw=yaw, pitch=pitch, roll=roll)
    right_once(found, "angles", "turns about z-y-x", 13.0)
    degrees = dict(zip(ANGLES, np.degrees([yaw, pitch, roll]), strict=True))
    right_once(judged(tmp_path, **degrees), "angles", "turns about z-y-x in degrees", 13.0)


@pytest.mark.parametrize("turned", [0, 360])
def test_angles_in_degrees_are_read_as_omega_in_degrees_is(tmp_path, turned):
    """psi, theta, phi of the scene's own sequence; also where a program cuts turns off."""
    degrees = {name: np.degrees(COLUMNS[name]) for name in ANGLES}
    degrees["psi"] = degrees["psi"] + turned
    found = judged(tmp_path, **degrees)
    assert found.worst > 13
    turns = "; psi and phi up to whole turns" if turned else ""
    assert found.reading == f"angles in degrees{turns}"
    assert f"read as angles in degrees{turns}" in str(found)
    assert judged(tmp_path, **of(ANGLES)).reading is None
    plain = polhode.compare(tmp_path / "x.csv", SCENE, as_it_stands=True)
    assert plain.reading is None


def test_times_that_are_off_by_a_step_are_named(tmp_path):
    moved = {name: [*COLUMNS[name][1:], 0.0][:-1] for name in STATE[:3]}
    path = written(tmp_path / "x.csv", t=COLUMNS["t"][:-1], **moved)
    right_once(polhode.compare(path, SCENE), "omega", "one step of t early")


@pytest.mark.parametrize("names", [STATE, STATE[3:], ATTITUDE, (*STATE, *ATTITUDE)])
def test_each_part_that_is_off_by_a_step_is_named(tmp_path, names):
    moved = {name: COLUMNS[name][1:] for name in names}
    found = polhode.compare(written(tmp_path / "x.csv", t=COLUMNS["t"][:-1], **moved), SCENE)
    parts = {"omega": "p" in names, "gamma": "gamma1" in names, "attitude": "q0" in names}
    assert {reading.part for reading in found.readings} == {p for p, has in parts.items() if has}
    for reading in found.readings:
        right_once(found, reading.part, "one step of t early")
    assert found.worst > 14
    assert found.limit in ("rounding", "")


def test_a_step_that_does_not_explain_all_parts_is_not_named(tmp_path):
    moved = {name: COLUMNS[name][1:] for name in STATE[:3]}
    noise = {name: [math.sin(7 * k) for k in range(len(TIMES) - 1)] for name in STATE[3:]}
    path = written(tmp_path / "x.csv", t=COLUMNS["t"][:-1], **moved, **noise)
    assert polhode.compare(path, SCENE).readings == ()


def swapped(*order):
    return {name: COLUMNS[of] for name, of in zip(STATE, order, strict=True)}


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        (swapped("q", "p", "r", *STATE[3:]), "omega p q r = q p r"),
        (
            swapped("r", "p", "q", "gamma3", "gamma1", "gamma2"),
            "omega p q r = q r p; gamma gamma1 gamma2 gamma3 = gamma2 gamma3 gamma1",
        ),
        (
            of(STATE) | {n: [-x for x in COLUMNS[n]] for n in ("r", "gamma3")},
            "omega p q r = p q -r; gamma gamma1 gamma2 gamma3 = gamma1 gamma2 -gamma3",
        ),
        (of(STATE) | {n: [-x for x in COLUMNS[n]] for n in STATE[3:]}, "gamma the downward"),
        (of(STATE) | {n: np.degrees(COLUMNS[n]) for n in STATE[:3]}, "omega degrees"),
    ],
)
def test_a_reading_is_applied(tmp_path, columns, told):
    """Its digits are the table; as it stands the file is wrong."""
    found = judged(tmp_path, **columns, **of(ATTITUDE))
    assert found.worst > 14
    assert found.reading.startswith(told)
    assert f"limited by {found.limit}; read as {found.reading}" in str(found)
    plain = polhode.compare(tmp_path / "x.csv", SCENE, as_it_stands=True)
    assert plain.worst < 1
    assert plain.reading is None
    assert plain.readings == ()


def test_what_limits_the_digits_of_a_table_that_was_read_is_told(tmp_path):
    """The convention was applied: what is left is the error of the table as it is read."""
    columns = of(STATE) | {n: np.degrees(COLUMNS[n]) for n in STATE[:3]}
    found = judged(tmp_path, **columns | {"p": columns["p"] + 1e-6})
    assert found.reading == "omega degrees"
    assert found.limit.startswith("method")
    text = str(found)
    assert "limited by more than rounding" in text
    assert "no limit is named" not in text


def test_a_wrong_sign_in_a_row_or_two_is_no_other_axis(tmp_path):
    columns = of(STATE) | {"p": [-x for x in COLUMNS["p"]]}
    for rows in (1, 2):
        few = {"t": COLUMNS["t"][4 : 4 + rows], **{n: c[4 : 4 + rows] for n, c in columns.items()}}
        found = polhode.compare(written(tmp_path / "x.csv", **few), SCENE)
        assert found.worst < 1.5
        assert found.readings == ()


def test_times_in_milliseconds_are_read_so(tmp_path):
    """Right from the first rows on; of a motion without closed form the proof is a short one."""
    for case in (SCENE, polhode.load("general/asymmetric-regular")):
        run = polhode.integrate(case, at=[Fraction(k, 50) for k in range(1, 60)])
        columns = {n: run.states[:, k] for k, n in enumerate(STATE)}
        path = written(tmp_path / "x.csv", t=[1000 * float(t) for t in run.t], **columns)
        found = polhode.compare(path, case)
        assert found.worst > 14
        assert found.reading == "t milliseconds"


def test_what_is_right_or_hopeless_gets_no_other_reading(tmp_path):
    assert judged(tmp_path, **of([*STATE, *ATTITUDE])).readings == ()
    noise = {name: [math.sin(7 * k) for k in range(len(TIMES))] for name in STATE}
    assert judged(tmp_path, **noise).readings == ()
    assert polhode.compare(polhode.integrate(replace(SCENE, outputs=()))).readings == ()


@pytest.mark.parametrize("header", ["t,note", "t", "t,omega_x,omega_y,omega_z"])
def test_a_file_of_which_nothing_can_be_judged_is_refused(tmp_path, capsys, header):
    path = tmp_path / "x.csv"
    path.write_text(f"{header}\n{','.join('1' for _ in header.split(','))}\n")
    assert cli.main(["compare", str(path), "lagrange/nutation"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "header" in err
