"""Certificates of the attitude: what is true is proved, and what is false never."""

from __future__ import annotations

import copy
import random
from dataclasses import replace
from fractions import Fraction

import pytest
from flint import arb, ctx
from test_verify import holds, worst

import polhode
from polhode.certificates import verify
from polhode.certificates.state_certificate import Attitude, certificate
from polhode.cli import main
from polhode.equations.kinematics import starting_attitude

_LAST = verify.TURN, "attitude"


def with_attitude(name):
    return replace(polhode.load(name), outputs=("attitude",))


@pytest.fixture(scope="module")
def small():
    """An asymmetric body to t = 3, 20 digits."""
    scene = with_attitude("general/asymmetric-regular")
    found = polhode.certify(scene, at=[1, 3], digits=20)
    turned = Attitude(starting_attitude(scene.gamma, scene.psi), found.attitude.decimals())
    return certificate(scene, found.times, found.decimals(), attitude=turned)


SCENES = {
    "lagrange/nutation": ([1, "7/3"], 20),
    "general/asymmetric-chaotic": ([2, 5], 40),
    "published/hairer-vilmart": ([1], 20),  # from the pole
    "lagrange/turned-axes": ([1], 20),
    "kovalevskaya/generic": ([-1, -4], 30),
    "hard/very-fast-top": (["0.0001"], 16),
    "staude/unstable": ([1, 20], 50),  # whose rates are constant, and its turn is no polynomial
    "steklov/upper": ([0, 1], 16),  # irrational data, and a time 0
}


@pytest.mark.parametrize("name", SCENES)
def test_an_attitude_that_is_certified_is_proved(name, tmp_path):
    at, digits = SCENES[name]
    path = tmp_path / "proof.json"
    polhode.certify(with_attitude(name), at=at, digits=digits).save(path)
    found = polhode.verify(path)
    assert found
    assert "its attitude" in found.text


def test_it_is_the_attitude_of_a_run(small):
    run = polhode.integrate(with_attitude("general/asymmetric-regular"), "quad", at=[1, 3])
    for row, told in zip(run.attitude, small["statement"], strict=True):
        for x, (middle, radius) in zip(row, told["attitude"], strict=True):
            off = abs(Fraction(str(x)) - Fraction(middle))
            assert off <= Fraction(radius) + Fraction(1, 10**30)


@pytest.mark.parametrize("column", range(4))
@pytest.mark.parametrize("row", [0, 1])
def test_a_ball_that_is_moved_off_is_not_proved(small, row, column):
    given = copy.deepcopy(small)
    middle, radius = given["statement"][row]["attitude"][column]
    moved = Fraction(middle) + 3 * Fraction(radius)
    given["statement"][row]["attitude"][column] = [str(moved), radius]
    assert holds(small)
    assert not holds(given)


def test_the_other_quaternion_of_the_start_is_not_proved(small):
    """The same rotation, but the statement tells of the other one."""
    given = copy.deepcopy(small)
    given["scene"]["attitude"] = [_minus(x) for x in given["scene"]["attitude"]]
    assert not holds(given)


def _minus(x):
    middle, *radius = x if isinstance(x, list) else [x]
    return [str(-Fraction(middle)), *radius] if radius else str(-Fraction(middle))


def test_a_start_that_turns_the_vertical_elsewhere_is_told(small):
    given = copy.deepcopy(small)
    given["scene"]["attitude"] = ["0.6", "0", "0.8", "0"]
    with pytest.raises(verify.NotProved, match="another gamma"):
        verify.state(given)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda x: x["scene"].pop("attitude"), "expected attitude"),
        (lambda x: x["scene"]["attitude"].pop(), "a list of 4"),
        (lambda x: x["statement"][0]["attitude"].pop(), "a list of 4"),
        (lambda x: x["statement"][0].update(turn=[]), "nothing else"),
    ],
)
def test_what_is_damaged_is_told(small, change, said):
    given = copy.deepcopy(small)
    change(given)
    with pytest.raises(verify.Damaged, match=said):
        verify.state(given)


def test_guesses_prove_nothing_false(small):
    """Centres and grids that are anything: proved, and true, or not proved."""
    generator = random.Random(5)
    wrong = copy.deepcopy(small)
    middle, radius = wrong["statement"][1]["attitude"][2]
    wrong["statement"][1]["attitude"][2] = [str(Fraction(middle) + 2 * Fraction(radius)), radius]
    for _ in range(6):
        given = copy.deepcopy(wrong)
        for row in given["centres"]:
            k = generator.randrange(6)
            row[k] += generator.randrange(-(2 ** generator.randrange(1, 60)), 2**40)
        assert not holds(given)


#: Each term of the bound that has to hold a fault: where it is made, and with what it is left out.
DROPPED = {
    "turning": lambda patch: patch.setattr(verify, "defect_of_turn", lambda *_: arb(0)),
    "rough centres": lambda patch: _without_the_rest(patch),
}


def _without_the_rest(patch):
    rates = verify.Stage.rates
    patch.setattr(verify.Stage, "rates", lambda self: (rates(self)[0], arb(0)))


def faulty(fault, given, monkeypatch):
    """Guesses that are far from the truth."""
    if fault == "turning":
        turning = verify.turning

        def altered(y, h, bits):
            rows = turning(y, h, bits)
            rows[2][3] += arb("1e-12").mid()
            return rows

        monkeypatch.setattr(verify, "turning", altered)
    else:
        cut = given["state_bits"] - 18
        given["centres"] = [[x >> cut for x in row] for row in given["centres"]]
        given["state_bits"] = 18


@pytest.mark.parametrize("fault", DROPPED)
def test_faulty_guesses_are_contained(fault, small, monkeypatch):
    given = copy.deepcopy(small)
    given["statement"] = given["statement"][:1]
    faulty(fault, given, monkeypatch)
    assert 1e-7 < worst(given, monkeypatch, *_LAST) < 1


@pytest.mark.parametrize("fault", DROPPED)
def test_a_term_that_is_dropped_is_noticed(fault, small, monkeypatch):
    given = copy.deepcopy(small)
    faulty(fault, given, monkeypatch)
    DROPPED[fault](monkeypatch)
    assert worst(given, monkeypatch, *_LAST) > 1


def test_errors_of_the_start_are_carried_on(small, monkeypatch):
    given = copy.deepcopy(small)
    first = [Fraction(x[0] if isinstance(x, list) else x) for x in given["scene"]["attitude"]]
    angle = Fraction(1, 10**9)  # the same gamma within the balls, turned about the vertical
    turned = [first[0] - angle * first[3], first[1] - angle * first[2]]
    turned += [first[2] + angle * first[1], first[3] + angle * first[0]]
    given["scene"]["attitude"] = [[str(x), "2e-9"] for x in turned]
    ctx.prec = 64
    assert 1e-3 < worst(given, monkeypatch, *_LAST) < 1


def test_the_command_line(tmp_path, capsys):
    path = tmp_path / "proof.json"
    scene = "general/asymmetric-regular"
    command = ["reference", scene, "--certified", "--at", "2", "--digits", "20"]
    assert main([*command, "--outputs", "attitude", "-o", str(path)]) == 0
    assert main(["verify", str(path)]) == 0
    assert "at 1 its attitude" in capsys.readouterr().out
