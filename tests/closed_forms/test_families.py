"""The table of closed forms: complete, walked in order; what a scene near to one is told."""

from __future__ import annotations

import json
import re
import tomllib
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import polhode
from polhode import BadInput
from polhode.cli import main
from shared.closed_forms import near_families
from shared.motions import scene_of

TOP = Path(__file__).parents[2]


def scene(moments="[2, 2, 1]", centre="[0, 0, 1]", omega="[1, 0, 3]", more=""):
    return scene_of(
        f"schema = 1\n[body]\nmoments = {moments}\ncentre = {centre}\nweight = 1\n"
        f"[start]\nomega = {omega}\ngamma = ['3/5', 0, '4/5']\n[run]\nend = 1\n{more}"
    )


def refused(scene, kind):
    """What is said of a family that is asked by its name."""
    with pytest.raises(BadInput) as fault:
        polhode.reference(replace(scene, reference=kind))
    return str(fault.value)


def off(text):
    return float(re.search(r"off by ([\d.e-]+\d)", text)[1])


def test_words_and_contract_name_the_same_families_and_each_of_them_can_be_asked():
    with pytest.raises(BadInput) as fault:
        scene(more="[reference]\nkind = 'none'\n")
    words = str(fault.value).partition(": expected ")[2].split(", ")
    assert (words[0], words[-1]) == ("auto", "certified")
    with (TOP / "pyproject.toml").open("rb") as file:
        contracts = tomllib.load(file)["tool"]["importlinter"]["contracts"]
    (independent,) = (c["modules"] for c in contracts if c["type"] == "independence")
    homes = {home.rpartition(".")[2].replace("_", "-") for home in independent}
    assert homes == {*words[1:-1]}
    for name in homes - {"lagrange"}:
        assert f"; {name} needs " in refused(scene(), name)


def test_the_first_that_fits_is_the_reference_and_the_others_can_be_asked():
    """A spherical pendulum that swings in a plane is a Lagrange top and a pendulum."""
    plane = scene("[1, 1, 1]", "[0, 0, 1]", "[0, 2, 0]")
    top, pendulum = (
        polhode.reference(plane),
        polhode.reference(replace(plane, reference="pendulum")),
    )
    assert (top.kind, pendulum.kind) == ("lagrange", "pendulum")
    (row,), (pendulum_row,) = (form.at([Fraction(7, 2)], 40) for form in (top, pendulum))
    assert max(abs(x - y) for x, y in zip(row, pendulum_row, strict=True)) < 3e-40
    assert "expected lagrange, which fits body and start; euler needs" in refused(plane, "euler")


def test_a_family_refused_by_name_says_what_fits():
    assert refused(scene(), "kovalevskaya").endswith(
        "reference.kind = kovalevskaya: expected lagrange, which fits body and start; "
        "kovalevskaya needs A = B (its axes 1, 2, 3 are here 2, 3, 1), off by 0.333"
    )


@pytest.mark.parametrize(
    "case",
    [
        *("lagrange/cusped", "lagrange/homoclinic", "euler/separatrix", "kovalevskaya/appelrot"),
        *("pendulum/separatrix", "bobylev-steklov/asymptotic", "hess/released"),
        "goryachev-chaplygin/released",
    ],
)
def test_a_motion_is_not_told_near_to_the_family_that_it_belongs_to(case):
    assert near_families(polhode.load(case)) == {}


#: Bodies a little off, motions far off: moments, centre, omega and the family.
HALF = {
    "hess": ("[1, 0.999999999999, 0.5]", "[0, 0, 1]", "[0.16, 0.3, 4.1]"),
    "goryachev-chaplygin": ("['4 + 1e-12', 4, 1]", "[1, 0, 0]", "[0.6, 0.3, 4.1]"),
}


@pytest.mark.parametrize("name", HALF)
def test_a_body_near_a_family_is_not_near_with_another_motion(name):
    moved = scene(*HALF[name])
    assert name not in near_families(moved)
    assert "Iw" in refused(moved, name)
    assert off(refused(moved, name)) > 0.1


def test_all_conditions_must_nearly_hold_not_only_the_first_that_fails():
    """A = 2C to 0.0009; but z0 is half of x0, and q and p are of order 1."""
    moved = scene("['2.0036', 2, 1]", "[1, 0, 0.5]", "[0.3, 0.2, 0.7]")
    assert "bobylev-steklov needs A = 2C, off by" in refused(moved, "bobylev-steklov")
    assert near_families(moved) == {}


@pytest.mark.parametrize("case", ["goryachev-chaplygin/released", "hess/released"])
def test_a_release_nearly_from_rest_is_near_to_one_from_rest(case):
    """What is small beside the w that the weight will make is small, whatever w is at first."""
    rest = polhode.load(case)
    assert rest.omega == (0, 0, 0)
    moved = replace(rest, omega=tuple(Fraction(k, 10**30) for k in (1, 2, 3)))
    assert 1e-31 < off(near_families(moved)[case.partition("/")[0]]) < 1e-28


def test_a_misfit_says_which_axes_it_means():
    """Axis 1 of the family is the second principal axis, and so on."""
    start = scene("[1.3, 1, 2]", "[0, 0, 2]", "[3, 0.4, '1e-12']")
    assert refused(start, "bobylev-steklov").count("(its axes 1, 2, 3 are here ") == 1
    plain = scene("[3, 2, 1.5]", "['1e-12', 0, 0]", "[1, 2, 3]")
    assert "axes" not in refused(plain, "euler")


def test_a_scene_with_a_closed_form_is_told_what_others_it_is_near_to(capsys):
    assert main(["show", "hard/near-bobylev-steklov", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["reference"].startswith("kovalevskaya")
    (fact,) = facts["near"]
    assert fact.startswith("bobylev-steklov: q = 0, off by 7.8")
    assert "()" not in (facts.get("not_told") or "")
