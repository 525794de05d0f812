"""The certificates that ship, and those of what the reports call proven, are proved."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import pytest

import accuracy
import polhode
from polhode.certificates import certificate_file, verify
from polhode.common.errors import BadInput
from polhode.scenes import library
from shared.tools import tiers

SHIPPED = sorted((library.folder() / "certificates").glob("*.json"))
#: The scene of each.
SCENES = {
    "asymmetric-30-digits": "general/asymmetric-regular",
    "chaos": "general/asymmetric-chaotic",
    "chaotic": "general/asymmetric-chaotic",
    "dzhanibekov": "euler/dzhanibekov",
    "elliptic": "general/asymmetric-chaotic",
    "grioli": "grioli/precession",
    "grioli-stability": "grioli/precession",
    "grioli-turned-axes": "grioli/turned-axes",
    "hyperbolic": "general/asymmetric-chaotic",
    "irrational": "euler/irrational",
    "kovalevskaya-backward": "kovalevskaya/generic",
    "turned-axes": "lagrange/turned-axes",
}


def test_these_ship():
    assert {path.stem for path in SHIPPED} == {*SCENES}


@pytest.mark.parametrize(
    "path",
    tiers(
        [SHIPPED[3], SHIPPED[8]],
        [
            *(SHIPPED[0], SHIPPED[2], SHIPPED[4], SHIPPED[5], SHIPPED[6], SHIPPED[7]),
            *(SHIPPED[9], SHIPPED[10], SHIPPED[11]),
        ],
    ),
    ids=lambda path: path.stem,
)
def test_what_ships_is_proved_and_of_the_scene_that_ships(path):
    alone = subprocess.run(
        [sys.executable, "-I", verify.__file__, str(path)], capture_output=True, text=True
    )
    assert alone.returncode == 0, alone.stdout + alone.stderr
    certificate = json.loads(path.read_text())
    body = library.load(SCENES[path.stem]).body
    for key, value in certificate_file.body_numbers(
        body, certificate["bits"] + verify.COARSE
    ).items():
        if isinstance(value, str) or not any(isinstance(x, list) for x in value):
            assert certificate["scene"][key] == value


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["bobylev-steklov/asymptotic", "hard/sleeping-below-critical-spin"]
)
def test_every_closed_form_that_is_certified_has_a_certificate(name, tmp_path):
    scene = replace(library.load(name), outputs=())
    if not scene.times:
        pytest.skip("no times")
    enclosure = polhode.certify(scene, accuracy.proven_times(scene), digits=accuracy.PROVEN_DIGITS)
    path = tmp_path / "row.json"
    if scene.gamma is None or not all(isinstance(t, Fraction) for t in enclosure.times):
        with pytest.raises(BadInput, match="for a certificate"):  # the only ones that have none
            enclosure.save(path)
        return
    enclosure.save(path)
    assert polhode.verify(path)


def a_motion_that_is_certified_far_has_a_certificate(name, tmp_path):
    path = tmp_path / "row.json"
    polhode.certify(name, [1, 10, 100, 500], digits=accuracy.PROVEN_DIGITS).save(path)
    assert polhode.verify(path)
