"""Integrals, rotation matrices and Rodrigues parameters as outputs, and as starts."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from shared.tools import exactly

TOP = "kovalevskaya/generic"
MATRIX = [f"R{i}{j}" for i in "123" for j in "123"]
RODRIGUES = [f"sigma{k}" for k in "123"]
INTEGRALS = ["h", "f", "drift_h", "drift_f", "drift_gamma", "drift_fourth"]
WORDS = ("integrals", "matrix", "mrp")


def scene(name: str = TOP) -> polhode.Scene:
    return replace(polhode.load(name), outputs=WORDS)


@pytest.fixture(scope="module")
def run() -> polhode.Trajectory:
    return polhode.integrate(scene(), at=[0, 1, 2, "7/3", 20])


def test_the_largest_departure_of_each_column_is_the_drift(run):
    for name, drift in run.drift._asdict().items():
        assert float(np.max(np.abs(run[f"drift_{name}"]))) == drift > 0


@pytest.mark.parametrize("number", ["double", "extended", "quad"])
def test_energy_and_momentum_are_those_of_the_state_in_the_scene_s_units(number):
    run = polhode.integrate(scene("general/asymmetric-regular"), number, at=[1, 2])
    body = run.scene.body
    for k, row in enumerate(run.states):
        w, gamma = ([exactly(x) for x in part] for part in (row[:3], row[3:]))
        momentum = [sum(a * x for a, x in zip(line, w, strict=True)) for line in body.inertia]
        h = sum(a * x for a, x in zip(momentum, w, strict=True)) / 2
        h += sum(a * x for a, x in zip(body.torque, gamma, strict=True))
        f = sum(a * x for a, x in zip(momentum, gamma, strict=True))
        assert abs(exactly(run["h"][k]) / h - 1) <= run.number.eps
        assert abs(exactly(run["f"][k]) / f - 1) <= run.number.eps
    gap = run["drift_fourth"]
    assert all(x is None or x != x for x in gap)  # no integral but three


def test_the_matrix_turns_gamma_up_and_is_of_the_quaternion(run):
    matrices = np.stack([run[name] for name in MATRIX], axis=1).reshape(-1, 3, 3)
    assert np.abs(matrices[:, 2] - run.gamma).max() < 1e-12  # row 3: the vertical in the body
    assert np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max() < 1e-15
    assert np.linalg.det(matrices) == pytest.approx(np.ones(5))
    angles = np.arccos((np.trace(matrices, axis1=1, axis2=2) - 1) / 2)
    sigma = np.stack([run[name] for name in RODRIGUES], axis=1)
    turn = 4 * np.arctan(np.linalg.norm(sigma, axis=1))
    assert np.cos(turn) == pytest.approx(np.cos(angles), abs=1e-13)
    for r, s in zip(matrices, sigma, strict=True):
        assert r @ s == pytest.approx(s, abs=1e-14)  # the axis stays


def test_files_and_commands_have_the_columns(run, tmp_path, capsys):
    names = [*MATRIX, *RODRIGUES, *INTEGRALS]
    run.save(tmp_path / "x.csv")
    again = polhode.load_result(tmp_path / "x.csv")
    assert again == run
    command = ["run", TOP, "--at", "0,1,2,7/3,20", "--outputs", ",".join(WORDS), "--json"]
    assert main(command) == 0
    columns = json.loads(capsys.readouterr().out)["columns"]
    for name in names:
        assert again.column(name).tolist() == run.column(name).tolist() == columns[name]


def test_a_sweep_and_an_enclosure_have_integrals_and_a_reference_all():
    many = polhode.integrate_many(scene(), {"start.omega[1]": [1, 2]}, at=[0, 1])
    assert abs(many.column("drift_h")).max() < 1e-15
    assert abs(many.column("h")[1] / many.column("h")[0] - 1) < 1e-14
    enclosure = polhode.certify(scene("general/asymmetric-regular"), at=[1], digits=20)
    run = polhode.integrate(enclosure.scene, "quad", at=[1])
    for word in ("matrix", "mrp", "integrals"):
        (centres,), (radii,) = enclosure.derived[word].centres, enclosure.derived[word].radii
        for centre, radius, x in zip(centres, radii, run.outputs[word][0], strict=True):
            assert (centre is None) == (x is None)
            if x is not None:
                assert abs(float(centre - exactly(x))) <= radius + 1e-30
    assert polhode.reference(scene()).column("matrix", [1], 20)[0][8] is not None


@pytest.mark.parametrize("turn", [{"mrp": [0.1, "1/2", "-1/3"]}, {"mrp": [0, 0, 0]}])
def test_a_start_s_parameters_are_those_of_the_run(turn):
    keys = {"moments": [2, 3, 4], "omega": [1, 0, 1], "end": 1}
    top = polhode.top(**keys, **turn, outputs=["mrp", "matrix", "attitude"])
    run = polhode.integrate(top, at=[0])
    expected = [float(Fraction(x)) for x in turn["mrp"]]
    assert [float(run[name][0]) for name in RODRIGUES] == pytest.approx(expected, abs=1e-15)
    matrix = [[float(run[f"R{i}{j}"][0]) for j in "123"] for i in "123"]
    again = polhode.top(**keys, matrix=matrix)
    assert np.abs(np.array([*map(float, again.gamma)]) - run.gamma[0]).max() < 1e-15
    assert float(again.psi) == pytest.approx(float(top.psi), abs=1e-14)


def test_a_matrix_is_exact_or_made_so_and_said(capsys):
    quarter = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    keys = {"moments": [2, 3, 4], "omega": [1, 0, 1]}
    exact = polhode.top(**keys, matrix=quarter)
    assert (exact.gamma, exact.notes) == ((0, 1, 0), ())
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    assert "start.matrix made a rotation" in polhode.top(**keys, matrix=rotation).notes[0]
    for wrong in (np.diag([1, 1, -1]), rotation * 1.01, rotation[:2], [[1, 0, 0]] * 3):
        with pytest.raises(polhode.BadInput, match=r"start\.matrix"):
            polhode.top(**keys, matrix=wrong)
    off = rotation + 1e-6 * np.arange(9).reshape(3, 3)
    with pytest.raises(polhode.BadInput, match="normalise"):
        polhode.top(**keys, matrix=off)
    near = polhode.top(**keys, matrix=off, normalise=True)
    assert np.abs(np.array([*map(float, near.gamma)]) - rotation[2]).max() < 1e-5
    assert sum(x * x for x in near.gamma) == 1
