"""The certificates that ship, and those of what the reports call proven, are proved."""

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import accuracy
import polhode
from polhode import BadInput
from shared.tools import tiers

SHIPPED = sorted((Path(__file__).parents[2] / "cases" / "certificates").glob("*.json"))
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
    verdict = polhode.verify(path)
    assert verdict.proved, verdict.text
    scene = json.loads(path.read_text())["scene"]
    body = polhode.load(SCENES[path.stem]).body
    for key in scene.keys() & {"moments", "inertia", "centre", "weight"}:
        if path.stem != "irrational":  # whose numbers are balls
            assert exact(scene[key]) == exact(getattr(body, key)), key


def exact(value):
    """A number, or numbers in tuples of any depth, as fractions."""
    return tuple(map(exact, value)) if isinstance(value, (list, tuple)) else Fraction(value)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["bobylev-steklov/asymptotic", "hard/sleeping-below-critical-spin"]
)
def test_every_closed_form_that_is_certified_has_a_certificate(name, tmp_path):
    scene = replace(polhode.load(name), outputs=())
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
