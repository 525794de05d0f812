"""Proved periodic orbits: the truth is inside, what is false is refused, with its inequality."""

from __future__ import annotations

import json
import random
from fractions import Fraction

import pytest
from mpmath import MPContext

import polhode
from polhode import NotProved
from polhode.certificates import verify
from polhode.cli import main
from polhode.proofs.proved_orbit import down, up
from shared import orbit_newton, proofs
from shared.tools import tiers

BODY = proofs.MOMENTS, proofs.TORQUE
UNIT = 2  # of the scene's time are one of the checker's


def closed(orbit):
    """A proved orbit by Newton's method in plain mpmath, where it meets the plane of its proof."""
    level = [proofs.H, proofs.F, Fraction(1)]
    certificate = json.loads(orbit.certificate)
    x = [n * Fraction(2) ** -certificate["state_bits"] for n in certificate["centres"][0]]
    rates = orbit_newton.rates(*BODY, x)
    plane = [a / UNIT**2 for a in rates[:3]] + rates[3:], x
    start = [ball.centre for ball in (*orbit.omega, *orbit.gamma)]
    return orbit_newton.corrected(*BODY, level, start, orbit.period.centre, plane)


@pytest.mark.slow
def test_the_orbit_lies_in_its_balls():
    orbit = proofs.proved(proofs.ELLIPTIC, 12)
    truth = closed(orbit)
    assert orbit.kind == "elliptic"
    # about 1e-20 as printed, the residue to seven figures
    assert abs(Fraction("3.22190206296088781308") - truth.period) < Fraction(1, 10**20)
    assert abs(Fraction("0.5401858") - truth.residue) < Fraction(1, 10**6)
    balls = [*orbit.omega, *orbit.gamma, orbit.period, orbit.residue]
    values = [*truth.start, truth.period, truth.residue]
    pairs = zip(balls, values, strict=True)
    worst = max(float(abs(x - ball.centre) / Fraction(ball.radius)) for ball, x in pairs)
    assert 1e-8 < worst <= 1  # and the balls are not slack


def test_griolis_period_is_two_pi():
    period = polhode.prove_orbit("grioli/precession", digits=50).period
    mp = MPContext()
    mp.dps = 220
    off = abs(mp.mpf(period.centre.numerator) / period.centre.denominator - 2 * mp.pi)
    assert off <= period.radius < mp.mpf("1e-49")


def test_the_front_door_names_level_kind_and_what_is_alone():
    orbit = polhode.orbit("general/asymmetric-regular")
    proof = polhode.prove_orbit("general/asymmetric-regular", orbit)
    assert (proof.h, proof.f) == (Fraction(26, 5), Fraction(69, 25))
    assert proof.kind == orbit.kind == "elliptic"
    assert abs(proof.period.centre - orbit.period) < 1e-14
    (real, side), (same, below) = proof.multipliers
    assert real == same
    assert side.centre == -below.centre
    assert abs(float(real) ** 2 + float(side) ** 2 - 1) < 1e-8
    assert 1e-26 < proof.unique_within.gamma < 1e-19
    assert 1e-26 < proof.unique_within.period < 1e-18
    assert "exactly one periodic orbit" in str(proof)


def test_another_unit_of_time_scales_the_orbit_and_how_far_it_is_alone():
    level = {"h": proofs.H, "f": proofs.F}
    slow = proofs.proved(proofs.ELLIPTIC)
    scene = proofs.near(proofs.ELLIPTIC, rate=2)
    fast = polhode.prove_orbit(scene, scene, h=4 * level["h"], f=2 * level["f"])
    assert fast.kind == slow.kind
    assert fast.period.centre == pytest.approx(slow.period.centre / 2)
    omega, gamma, period = slow.unique_within
    expected = [2 * omega, gamma, period / 2]
    # the centres are decimals, and how far a zero is from its centre tells in the last figures
    assert [*fast.unique_within] == pytest.approx(expected, rel=1e-4, abs=0.0)


def test_an_orbit_of_another_body_is_a_guess_and_no_more():
    near = proofs.near(proofs.ELLIPTIC)
    orbit = polhode.orbit(near, h=proofs.H, f=proofs.F, period=near.end)
    changed = polhode.top(
        moments=["2.00001", *proofs.MOMENTS[1:]],
        centre=proofs.TORQUE,
        weight=1,
        omega=[0, 0, 20],  # whose unit of time is another one
        gamma=[0, 0, 1],
    )
    proof = polhode.prove_orbit(changed, orbit, digits=12, h=proofs.H, f=proofs.F)
    assert proof.scene == changed
    assert 1e-7 < abs(proof.period.centre - orbit.period) < 1e-3


def test_half_the_period_is_refused():
    point = (*proofs.ELLIPTIC[:6], proofs.ELLIPTIC[6] / 2)
    with pytest.raises(NotProved, match=r"no periodic orbit is near the start \(.*\); try another"):
        proofs.proved(point)


def test_a_proof_whose_check_would_take_hours_is_refused(monkeypatch):
    """A traceback it was, of the checker's own refusal."""
    monkeypatch.setattr(verify, "MOST_WORK", 10**5)
    with pytest.raises(NotProved, match="bits are too many; try fewer digits, or a shorter orbit"):
        polhode.prove_orbit("grioli/precession", digits=12)


@pytest.mark.slow
def test_twice_the_period_is_refused_with_a_shorter_one(tmp_path, capsys):
    orbit = polhode.orbit("grioli/precession")
    *head, end = polhode.as_toml(orbit.scene).splitlines()[:-1]
    assert end == "end = 6.2831853071795865"
    path = tmp_path / "twice.toml"
    path.write_text("\n".join([*head, "end = 12.566370614359173"]))
    assert main(["prove", "orbit", "grioli/precession", "--orbit", str(path)]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "the period may be 2 times the least one; try the period 6.2831853" in err
    assert list(tmp_path.iterdir()) == [path]


#: On a resonant torus of Kovalevskaya's and of Lagrange's top, as searches found them.
TORI = {
    "kovalevskaya/generic": (
        *(-0.09356027906795326, -0.8088610393017476, -1.7698828995014064),
        *(-0.8942524456933294, -0.3119512609933422, -0.32093453247689424),
        11.923560586069057,
    ),
    "lagrange/nutation": (
        *(0.3057968418058629, 0.792249993748683, -0.07197004546693597),
        *(0.19965454798580418, 0.30923023702957153, -0.929792838203876),
        2.0047658025660637,
    ),
}


@pytest.mark.parametrize("case", tiers(["lagrange/nutation"], ["kovalevskaya/generic"]))
def test_an_orbit_of_a_resonant_torus_is_refused(case):
    scene = polhode.load(case)
    p, q, r, *gamma, period = TORI[case]
    omega = [w / 2.0**scene.time_unit for w in (p, q, r)]
    near = polhode.Scene(scene.body, omega, gamma, times=(period,), normalise=True)
    with pytest.raises(
        NotProved, match=r"not isolated.*: (Krawczyk's test fails|the ten equations are singular)"
    ):
        polhode.prove_orbit(scene, near)


def test_bounds_are_written_on_their_own_side():
    """1.2934e-20 and 0.97 times that both begin with 1.3; so with 1.000002 and a little more."""
    assert (down(1.2934e-20), up(1.000002)) == ("1.2e-20", "1.00001")
    chance = random.Random(3)
    for _ in range(2000):
        x = 10 ** chance.uniform(-40, 3)
        assert 0.89 * Fraction(x) < Fraction(down(x)) <= Fraction(x) <= Fraction(up(x))
        assert Fraction(up(x)) < Fraction(x) * Fraction("1.0000101")


def test_the_primes_by_which_a_period_is_divided_are_all():
    first = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29]
    assert verify._primes(30) == first[::-1]
    assert verify._primes(29) == first[::-1]


def test_the_verbs_tell_the_theorem(capsys):
    assert main(["prove", "orbit", "grioli/precession"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("period      6.2831853071795864769252867665590")
    assert "proved: on the level h = 63/74, f = 836/1369 exactly one" in out
    assert "every digit is proven" in err


def test_a_refused_proof_leaves_nothing(tmp_path, capsys):
    path = tmp_path / "orbit.json"
    assert main(["prove", "orbit", "euler/largest-axis", "-o", str(path)]) == 3
    out, err = capsys.readouterr()
    assert not path.exists()
    assert out == ""
    assert err.count("\n") == 1
    assert "not isolated" in err


def test_a_file_whose_kind_is_no_text_is_not_replaced(tmp_path, refusal):
    """It was a traceback."""
    (tmp_path / "x.json").write_text('{"kind": []}')
    err = refusal("prove", "orbit", "grioli/precession", "-o", "x.json")
    assert "a new file, or a certificate's" in err


@pytest.mark.slow
def test_a_search_is_proved_orbit_by_orbit():
    case = "general/asymmetric-regular"
    orbits = polhode.prove_orbits(case, (8, 8), crossings=1)
    assert orbits.column("proven") == [True] * 3
    assert min(orbits.column("digits_proven")) >= 30
    for orbit, proof in zip(orbits.search.orbits, orbits.proofs, strict=True):
        assert abs(float(proof.period) - orbit.period) < 1e-12
        assert proof.kind == orbit.kind
        assert abs(float(proof.residue.centre) - orbit.residue) < 1e-6
    assert str(orbits).count("proved: ") == 3


@pytest.mark.slow
def test_orbits_that_are_not_proved_say_why(capsys):
    """On an integrable top they lie on resonant tori."""
    words = ["prove", "orbits", "lagrange/looping", "--grid", "5x5", "--crossings", "1"]
    assert main([*words, "--json"]) == 3
    columns = json.loads(capsys.readouterr().out)["columns"]
    assert columns["proven"]
    assert not any(columns["proven"])
    assert set(columns["digits_proven"]) == {None}
    assert all(columns["cause"])
