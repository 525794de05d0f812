"""Stability for all time: what is proved, its numbers beside independent ones, what is refused."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import pytest

import polhode
from polhode import BadInput
from polhode.certificates import verify
from polhode.proofs import proved_stability as module
from shared import proofs
from shared.proofs import NAME, PERIOD, START, orbit, stability, stable_start
from shared.tools import tiers

#: Rotation in turns, and the twist: by true returns in canonical coordinates, of an independent
#: program with momenta in place of angular velocities, differences in place of jets.
KNOWN = {
    "elliptic": ("0.26280535970418", "-0.746179275763117"),
    "regular": ("0.35849176211669", "-0.368006549532585"),
    "grioli": ("0.0157568772234", "-23.6474899417368"),
    "hairer": ("0.32745791395213", "-0.772166817461206"),
    "goryachev": ("0.25", "1.49118327505051"),
}


def agrees(ball: Any, text: str, digits: int) -> bool:
    """Whether a ball holds a decimal but for its last place, and is known to some digits."""
    truth = Fraction(text)
    last = Fraction(1, 10 ** len(text.partition(".")[2]))
    is_near = abs(ball.centre - truth) <= last + Fraction(ball.radius)
    return is_near and 0 < ball.radius < abs(float(truth)) * 10.0**-digits


def of(name: str) -> polhode.ProvedStability:
    if name == "regular":
        return stability()
    if name == "elliptic":
        return polhode.prove_stability(proofs.proved(proofs.ELLIPTIC))
    if name == "goryachev":
        case = "goryachev-chaplygin/two-frequencies"
        search = polhode.orbit_search(case, (16, 16), crossings=3)
        return polhode.prove_stability(case, search.orbit(0))
    case = {"grioli": "grioli/turned-axes", "hairer": "published/hairer-vilmart"}[name]
    return polhode.prove_stability(case)


@pytest.mark.parametrize("name", tiers(["regular"], ["elliptic", "grioli"]))
def test_rotation_and_twist_are_those_of_true_returns(name):
    """Grioli's in axes that are not principal ones."""
    proved, (rotation, twist) = of(name), KNOWN[name]
    assert ('"inertia"' in proved.certificate) == (name == "grioli")
    assert agrees(proved.rotation, rotation, 12)
    assert agrees(proved.twist, twist, 8)
    assert proved.orbit.kind == "elliptic"


def test_the_rotation_is_that_of_the_multipliers():
    proved = stability()
    real, imaginary = proved.orbit.multipliers[0]
    turns = math.atan2(abs(float(imaginary)), float(real)) / (2 * math.pi)
    assert float(proved.rotation) == pytest.approx(turns, rel=1e-12)


def test_what_is_told_is_the_theorem_and_its_numbers():
    lines = str(stability()).splitlines()
    assert [line.split()[0] for line in lines[:5]] == [
        *("period", "level", "residue", "rotation", "twist")
    ]
    assert lines[3].endswith("of a turn in a period")
    assert "-0.36800654953" in lines[4]
    said = ("stable for all time, forward and back", "on its level or another", "J. Moser")
    assert all(words in lines[5] for words in said)
    assert stability().fact("theorem") == lines[5]


SPEED = Fraction(3, 2)


def turning(moments, axis):
    """A free body that turns about a principal axis, which is not vertical: a periodic orbit."""
    omega, gamma = ["0"] * 3, ["0.48"] * 3
    omega[axis], gamma[axis - 1], gamma[axis] = str(SPEED), "0.36", "0.8"
    body = {"moments": moments, "centre": ["0"] * 3, "weight": 0, "end": 3, "name": "euler"}
    return polhode.top(**body, omega=omega, gamma=gamma)


def proved_of(moments, axis):
    return polhode.prove_stability(turning(moments, axis), period=2 * math.pi / float(SPEED))


def of_euler(moments, axis):
    """Rotation and twist of these neighbours.

    With a = 1/A - 1/C and b = 1/B - 1/C, C about the axis, L = |G| and J the action of l, Andoyer's
    h = L^2/(2 C) +- (a b)^(1/2) L J - (a + b) J^2/4 + O(J^3); the rotation is dh/dJ over dh/dL.
    """
    a, b, c = (Fraction(moments[axis - k]) for k in (1, 2, 0))
    a, b = 1 / a - 1 / c, 1 / b - 1 / c
    with mpmath.workdps(40):
        turns = mpmath.sqrt((a * b * c**2).numerator) / mpmath.sqrt((a * b * c**2).denominator)
        turns *= 1 if a > 0 else -1
        size = ((a + b) / 2 + c * a * b) / SPEED
        twist = -2 * mpmath.pi * size.numerator / size.denominator
        turns -= mpmath.floor(turns)
        if turns > 0.5:
            turns, twist = 1 - turns, -twist
        return mpmath.nstr(turns, 30), mpmath.nstr(twist, 30)


@pytest.mark.parametrize(
    ("moments", "axis"), tiers([(("6", "8", "9"), 2)], [(("2", "2.5", "4"), 0)])
)
def test_euler_s_top_has_its_rotation_and_twist_in_closed_form(moments, axis):
    """The last one has the multiplier i, and no term of that resonance: it is proved."""
    proved, (rotation, twist) = proved_of(moments, axis), of_euler(moments, axis)
    assert agrees(proved.rotation, rotation, 18)
    assert agrees(proved.twist, twist, 15)


@pytest.mark.slow
def test_the_twist_is_one_over_the_unit_of_an_action():
    """In half the unit of time and with three times the mass: the same motions."""
    rates, gamma = ([Fraction(x) for x in START[k : k + 3]] for k in (0, 3))
    scene = polhode.top(
        moments=[3 * x for x in stable_start().body.moments],
        centre=stable_start().body.centre,
        weight=12 * stable_start().body.weight,
        omega=[2 * x for x in rates],
        gamma=gamma,
        normalise=True,
        end=Fraction(PERIOD) / 2,
    )
    level = {"h": Fraction(26, 5) * 12, "f": Fraction(69, 25) * 6}
    proved = polhode.prove_stability(scene, scene, **level)
    assert float(proved.twist) == pytest.approx(float(stability().twist) / 6, rel=1e-11)
    assert float(proved.rotation) == pytest.approx(float(stability().rotation), rel=1e-12)


@pytest.mark.slow
def test_an_orbit_that_is_known_too_badly_is_proved_anew():
    """Its start's ball, which the return map multiplies, is made narrower."""
    rough = polhode.prove_orbit(NAME, stable_start(), digits=8)
    proved = polhode.prove_stability(rough)
    assert proved.runs == 2
    assert proved.orbit.digits > rough.digits + 3
    assert agrees(proved.twist, KNOWN["regular"][1], 8)


def test_a_theorem_stays_where_its_orbit_is_not_proved_to_more_digits(monkeypatch):
    def refuse(*_, **__):
        raise polhode.NotProved("to so many digits")

    rough = polhode.prove_orbit(NAME, stable_start(), digits=12)
    monkeypatch.setattr(module, "prove_orbit", refuse)
    proved = polhode.prove_stability(rough)
    assert proved.orbit is rough
    assert agrees(proved.twist, KNOWN["regular"][1], 1)
    assert not agrees(proved.twist, KNOWN["regular"][1], 8)


# -- refusals -------------------------------------------------------------------------------------


def refusal(*arguments, **options):
    with pytest.raises(polhode.NotProved) as why:
        polhode.prove_stability(*arguments, **options)
    assert "\n" not in str(why.value)
    return str(why.value)


def test_a_hyperbolic_orbit_is_not_stable():
    line = refusal(proofs.proved(proofs.HYPERBOLIC))
    assert "the orbit is hyperbolic (multiplier 5.95122203587" in line
    assert line.endswith("): it is not stable")


def with_residue(centre):
    """The orbit, its residue a small ball around another number."""
    return replace(orbit(), residue=orbit().residue._replace(centre=centre, radius=2e-15))


def test_a_third_root_of_unity_decides_nothing():
    line = refusal(with_residue(Fraction(3, 4) + Fraction(1, 10**15)))
    assert "a multiplier may be a third root of unity (residue 0.75" in line
    assert "nothing is decided" in line


#: Of Euler's top, all exactly so: the moments, and what is said of the multipliers.
RESONANT = {
    (30, 21, 35): "a multiplier may be a third root of unity (residue 0.75",
    (16, 10, 20): "a multiplier may be 1 or -1",
    (1, 2, 3): "a further multiplier is about 1",
}


@pytest.mark.parametrize("moments", RESONANT)
def test_an_orbit_at_a_resonance_is_refused(moments):
    assert RESONANT[moments] in refusal(turning(moments, 2), period=2 * math.pi / float(SPEED))


#: What the checker says of the return map, the residue, what is told, and after how many tries.
SAID = {
    "jets, step 3 of 9: the condition of the step": (
        None,
        "the jets grow too fast for 161 bits",
        3,
    ),
    "the residue may be 1/2: a resonance of the fourth order, of which a term is large": (
        Fraction(1, 2),
        "a multiplier may be i (residue 0.5",
        1,
    ),
    # with a twist of some digits
    "": (None, "the twist [+/- 1.01e-3] may be 0", 3),
}


@pytest.mark.parametrize("fault", SAID)
def test_what_the_checker_refuses_is_told_with_what_to_try(fault, monkeypatch):
    runs = []

    def twist_of(zero, guide):
        runs.append(guide)
        if fault:
            raise verify.NotProved(fault)
        return verify.Twist(verify.arb("0.3"), verify.arb(0, "1e-3"))

    monkeypatch.setattr(verify, "twist_of", twist_of)
    monkeypatch.setattr(module, "_TRIES", 3)
    residue, said, tries = SAID[fault]
    assert said in refusal(orbit() if residue is None else with_residue(residue))
    assert len(runs) == tries
    bits = [guide.jet_bits for guide in runs]
    assert bits == sorted(bits)


def test_jets_that_would_take_hours_are_none(monkeypatch):
    """Their certificate was written, and refused when it was read."""
    monkeypatch.setattr(verify, "MOST_WORK", 3 * 10**6)  # of the orbit alone a third of that
    assert refusal(orbit()).endswith("bits are too many; try a shorter orbit")


@pytest.mark.parametrize("option", [{"h": 3}, {"digits": 60}])
def test_an_orbit_that_is_proved_comes_alone(option):
    """Of digits nothing came."""
    with pytest.raises(BadInput, match="nothing else with an orbit that is proved"):
        polhode.prove_stability(orbit(), **option)


def test_a_certificate_is_what_the_checker_reads(tmp_path):
    certificate = json.loads(stability().certificate)
    assert certificate["kind"] == "stability"
    assert (certificate["jet_bits"], certificate["weight_bits"]) == (96, 10)
    assert {"rotation", "twist"} < {*certificate["statement"]}
    with pytest.raises(BadInput, match="save: path = 5: expected the path of a file"):
        stability().save(5)
    stability().save(tmp_path / "x.csv")
    again = polhode.load_result(tmp_path / "x.csv")
    assert again.to_json() == stability().to_json()
