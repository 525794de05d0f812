"""Scene files: every key of the contract, every fault one line, every text a Scene or BadInput."""

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from test_bad_scenes import BASE, base

import polhode
from polhode.cli import main
from shared.motions import scene_of
from shared.tools import case_names, number

FULL = """
schema = 1
title  = "Heavy top, generic motion"
tags   = ["heavy", "hard"]
cite   = ["Kowalevski 1889"]
[body]
moments = [2, 2, 1]
centre  = [1, 0, 0]
weight  = 1
[start]
omega = ["0.3", 0.2, 1.1]
gamma = ["3/5", 0, "4/5"]
psi   = "pi/7"
[run]
end = 200
samples = 401
form = "principal"
outputs = ["angles", "attitude"]
[[events]]
name = "nutation"
zero = "p*gamma2 - q*gamma1"
direction = "rising"
stop = true
[[events]]
zero = "t - 3"
[[published]]
t = 30
quantity = "180/pi*p"
value = "12.6183907758"
cite = "NASA/TM-2015-218675"
[reference]
kind = "certified"
[expect]
double = [11.0, 14.5]
"""


def test_every_key_of_the_contract_is_read():
    scene = scene_of(FULL, "full")
    expected = polhode.top(
        moments=[2, 2, 1],
        centre=[1, 0, 0],
        weight=1,
        omega=["3/10", "1/5", "11/10"],
        gamma=["3/5", 0, "4/5"],
        psi="pi/7",
        at=[Fraction(k, 2) for k in range(401)],
        outputs=["angles", "attitude"],
        events=[
            polhode.Event("nutation", "p*gamma2 - q*gamma1", "rising", True),
            polhode.Event("event 2", "t - 3"),
        ],
        reference="certified",
        title="Heavy top, generic motion",
        name="full",
    )
    more = {"tags": ("heavy", "hard"), "cite": ("Kowalevski 1889",), "source": FULL}
    more |= {"expect": {"double": (11.0, 14.5)}, "published": scene.published}
    assert scene == replace(expected, **more)
    assert (scene.published[0].value, scene.published[0].t) == ("12.6183907758", 30)
    assert scene.source == FULL


GAMMAS = ["[1, 1, 0]", "['pi', 'sqrt(2)', -3e-200]", "[1e900, 0, 1]"]
GAMMAS += ["['sqrt(1/3)', 'sqrt(1/3)', '-sqrt(1/3)']"]  # which is one, by the rule


@pytest.mark.parametrize("gamma", GAMMAS)
def test_normalise_makes_gamma_a_unit_vector(gamma: str):
    normalise = "" if "1/3" in gamma else "\nnormalise = true"
    scene = scene_of(base(gamma=f"gamma = {gamma}{normalise}"))
    assert sum(x * x for x in scene.gamma) == 1
    moved = scene_of(base(omega="momentum = [2, 9, 'pi']", gamma=""))
    assert all(x == y for x, y in zip(moved.omega, (1, 3, number("pi") / 4), strict=True))
    assert moved.columns == ("p", "q", "r")  # without a torque gamma may be left out


def in_angles(angles: str, rates: str = "[0.4, -0.3, 0.7]"):
    return scene_of(base(omega=f"angles = {angles}", gamma=f"rates = {rates}"))


def test_angles_and_rates_give_the_kinematic_equations():
    scene = in_angles("['1/3', 'pi/3', 0.2]")
    assert scene.gamma is not None
    sine, cosine = number("sqrt(3)/2"), Fraction(1, 2)
    s, c = number("sin(1/5)"), number("cos(1/5)")
    assert all(x == y for x, y in zip(scene.gamma, (sine * s, sine * c, cosine), strict=True))
    psi_rate, theta_rate, phi_rate = Fraction(2, 5), Fraction(-3, 10), Fraction(7, 10)
    assert scene.omega[0] == psi_rate * sine * s + theta_rate * c
    assert scene.omega[1] == psi_rate * sine * c - theta_rate * s
    assert scene.omega[2] == psi_rate * cosine + phi_rate
    assert scene.psi == Fraction(1, 3)


@pytest.mark.parametrize(("theta", "sense"), [("0", 1), ("'pi'", -1), ("'-2*pi'", 1)])
def test_at_a_pole_phi_counts_as_psi(theta: str, sense: int):
    scene = in_angles(f"['1/3', {theta}, 0.2]")
    assert all(x == y for x, y in zip(scene.gamma, (0, 0, sense), strict=True))
    assert scene.psi == Fraction(1, 3) + sense * Fraction(1, 5)
    assert (scene.omega[0], scene.omega[1]) == (Fraction(-3, 10), 0)


@pytest.mark.parametrize("at", ["[0]", "[0, 1]", "[-1, -2]", "[0, -1, '-pi']", "[1e-4000, 1]"])
def test_times_away_from_zero_are_accepted(at: str):
    assert scene_of(base(end=f"at = {at}")).times[-1:]


@pytest.mark.parametrize("unit", ["1e-3000", "1e-30", "1", "1e30", "1e3000"])
def test_scenes_in_any_units_are_accepted(unit: str):
    scene = scene_of(base(moments=f"moments = [2{unit[1:]}, 3{unit[1:]}, 4{unit[1:]}]"))
    assert scene.body.moments[0] == 2 * number(unit)


def test_files_are_read_in_every_usual_encoding_of_lines(tmp_path: Path):
    path = tmp_path / "top.toml"
    for content in (BASE, "\ufeff" + BASE, BASE.replace("\n", "\r\n")):
        path.write_bytes(content.encode())
        assert polhode.load(path).omega[2] == Fraction(11, 10)


# -- Cases by their names: exactly those that ship, and nothing that is a path ---------------------


NO_NAMES = [
    *("", "/", "euler", "euler/", "/euler/sphere", "euler//sphere", "./euler/sphere", "sphere"),
    *("euler/../euler/sphere", "euler/sphere.toml", "euler/sphere.toml/x", "Euler/sphere"),
    *("euler/*", "euler/\0", "euler\nsphere", "euler/" + 300 * "x", 300 * "x"),
]


@pytest.mark.parametrize("name", NO_NAMES)
def test_what_is_no_name_is_refused(name):
    assert name not in case_names()
    with pytest.raises(polhode.BadInput):
        polhode.load(name)


def test_without_cases_a_path_is_read_all_the_same(tmp_path, monkeypatch):
    path = tmp_path / "own.toml"
    path.write_text(polhode.as_toml(polhode.top(moments=[1, 2, 2.5], omega=[1, 0, 0])))
    monkeypatch.setattr("polhode.scenes.library.folder", lambda: tmp_path / "nowhere")
    assert polhode.load(path).omega == (1, 0, 0)
    with pytest.raises(polhode.BadInput, match="euler/sphere"):
        polhode.load("euler/sphere")


def test_a_top_stands_for_its_cases_unless_a_file_has_its_name(tmp_path, refusal, capsys):
    assert main(["check", "grioli/turned-axes", "grioli", "--number", "double", "--json"]) == 0
    scenes = json.loads(capsys.readouterr().out)["columns"]["scene"]
    names = ["turned-axes", "irrational", "precession"]
    assert [*dict.fromkeys(scenes)] == [f"grioli/{name}" for name in names]
    assert len(scenes) == 3
    assert refusal("check", "griol").startswith("polhode: griol: SCENE: expected a path, or the na")
    (tmp_path / "grioli").write_text("schema = 1\n")
    assert refusal("check", "grioli").startswith("polhode: grioli: body")


def test_a_changed_scene_has_a_fingerprint_of_its_own():
    """Where it is from a file, written from numbers, or read again."""
    written = polhode.top(moments=[2, 2, 1], omega=[0, 0, 3], gamma=[0, 0, 1], end=1)
    for scene in (polhode.load("lagrange/nutation"), written, scene_of(written.source)):
        changed = replace(scene, omega=(1, 2, 9))
        cases = [x.provenance()["case"] for x in (scene, scene.at([1]), changed)]
        assert cases[0] == cases[1] != cases[2]
        assert "omega = [1, 2, 9]" in polhode.view(changed).text
        assert "omega = [1, 2, 9]" not in polhode.view(scene).text
