"""``polhode new``: a commented scene that reads back."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest

import polhode
from polhode.cli import main
from polhode.output import new_scene
from polhode.scenes import vocabulary
from shared.motions import scene_of


@pytest.mark.parametrize(
    "case",
    [
        *("bobylev-steklov/asymptotic", "euler/named-times"),
        *("euler/turned-symmetric", "hard/dzhanibekov-1e-3"),
        *("hard/near-quasi-periodic", "kovalevskaya/delaunay", "lagrange/lower-pole"),
        "pendulum/hanging",
    ],
)
def test_a_commented_case_is_the_case(case):
    scene = polhode.load(case)
    text = new_scene.commented(scene.source)
    assert replace(scene_of(text, scene.name), source="") == replace(scene, source="")
    lines = [line for line in text.splitlines() if line not in scene.source.splitlines()]
    assert lines
    assert all(line.startswith("# ") for line in lines)


@pytest.mark.parametrize(
    ("options", "moment"),
    [
        ([], None),
        (["--cone", "3 cm,5 cm,50 g"], 3 * 0.05 * 0.03**2 / 10),
        (["--disc", "0.03,0.05,0.1"], 0.1 * 0.03**2 / 2),
        (["--sphere", "30 mm,5 cm,100 g", "--tilt", "pi/4", "--spin", "10 rev/s"], 3.6e-5),
    ],
)
def test_a_solid_is_a_scene_in_si(options, moment, tmp_path, capsys):
    path = tmp_path / "top.toml"
    assert main(["new", str(path), *options]) == 0
    assert f"polhode run {path}" in capsys.readouterr().out
    scene = polhode.load(path)
    assert scene.units == "SI"
    if moment is not None:
        assert float(scene.body.moments[2]) == pytest.approx(moment, rel=1e-14)
    text = path.read_text()
    for name in ("g", "shape", "mass", "angles", "rates", "end", "samples"):
        assert re.search(rf"\b{name} += ", text)
        assert f"# {name}: " in text


def test_a_case_is_written_with_comments(tmp_path, capsys):
    path = tmp_path / "mine.toml"
    assert main(["new", str(path), "--like", "lagrange/nutation", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "Lagrange top, generic nutation"
    (omega,) = [key for key in vocabulary.KEYS["start"] if key.name == "omega"]
    assert f"# omega: {omega.meaning}\nomega = [0.16, 0.3, 4.1]\n" in path.read_text()
