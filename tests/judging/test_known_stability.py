"""No unstable motion is called regular, however short it is followed: a row each."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

import polhode
from polhode.dynamics.lyapunov import known_stability
from polhode.taylor.system import system

ENDS = [1, 3, 10, 20, 30, 100]


def free(moments, omega, **more):
    return polhode.top(moments=moments, omega=omega, **more)


def sleeping(spin):
    """Of moments 2, 2, 1 and Mg z0 = 1: it sleeps stably from (C r)^2 = 4 A Mg z0 on."""
    body = {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": 1}
    return polhode.top(**body, omega=[0, 0, spin], gamma=[0, 0, 1])


def verdicts(scene, ends=ENDS):
    return {polhode.lyapunov(scene, end).verdict for end in ends}


#: Unstable ones at rest, and the rates by the linear equations.
AT_REST = {
    "about the middle axis": (free([1, 2, 3], [0, 1, 0]), math.sqrt(1 / 3)),
    "the same with gamma": (free([1, 2, 3], [0, 1, 0], gamma=[0, "3/5", "4/5"]), math.sqrt(1 / 3)),
    "of nearly equal moments": (
        free([1, "1.001", "1.002"], [0, 1, 0]),
        math.sqrt(1e-6 / 1.002),
    ),
    "a sleeping top": (sleeping(2), 0.5),
    "one barely too slow": (sleeping("2.8284"), math.sqrt(0.5 - (2.8284 / 4) ** 2)),
    "upright": (polhode.load("pendulum/upright"), None),
    "Staude's": (polhode.load("staude/unstable"), None),
    "Staude's, oscillating": (polhode.load("staude/unstable-oscillating"), None),
}
STABLE = {
    "about the largest axis": free([1, 2, 3], [0, 0, 1]),
    "about the smallest axis": free([1, 2, 3], [1, 0, 0]),
    "a sleeping top at its threshold": sleeping("sqrt(8)"),
    "one that is fast enough": sleeping("2.829"),
    "hanging": polhode.load("pendulum/hanging"),
    "Staude's": polhode.load("staude/stable"),
    "on a torus": polhode.load("lagrange/nutation"),
    "near a separatrix": polhode.load("euler/near-separatrix"),
    "of a period": polhode.load("bobylev-steklov/cn"),
    "a pendulum": polhode.load("pendulum/rotating"),
}


@pytest.mark.parametrize("name", AT_REST)
def test_what_stands_still_is_unstable_by_its_eigenvalues(name):
    scene, rate = AT_REST[name]
    assert verdicts(scene, [1, 10, 100]) == {"unstable"}
    if rate is not None:
        found = known_stability(scene, system(replace(scene, form="principal"), ()), 1)
        assert found.rate / 2.0**scene.time_unit == pytest.approx(rate, rel=1e-9)
    else:
        followed = polhode.lyapunov(scene, 2000)
        short = polhode.lyapunov(scene, 1)
        told = float(short.reason.split("exp(")[1].split(" t")[0])
        assert told == pytest.approx(followed.exponent, rel=0.01)


@pytest.mark.parametrize("name", STABLE)
def test_regular_motions_that_are_known_are_called_so_at_once(name):
    assert verdicts(STABLE[name], [1, 30]) == {"regular"}


SEPARATRICES = [
    *("euler/separatrix", "lagrange/homoclinic", "pendulum/separatrix", "hess/loxodrome"),
    *("bobylev-steklov/asymptotic", "kovalevskaya/asymptotic", "goryachev-chaplygin/v-asymptotic"),
]


@pytest.mark.parametrize("name", SEPARATRICES)
def test_what_tends_to_an_unstable_motion_is_undecided_until_the_growth_tells(name):
    scene = polhode.load(name)
    assert polhode.lyapunov(scene, 3).verdict == "undecided"
    assert verdicts(scene) <= {"undecided", "unstable"}


def test_the_time_that_may_decide_is_told_and_does():
    scene = free([1, 2, 3], ["sqrt(3)", 0, 1])
    short = polhode.lyapunov(scene, 8)
    assert short.verdict == "undecided"
    end = float(short.reason.split("an end of ")[1].split()[0])
    assert 8 < end < 50
    assert polhode.lyapunov(scene, end).verdict == "unstable"
    slow = free([1, "1.001", "1.002"], ["sqrt(1.002)", 0, 1])  # e-folds in 1000
    assert verdicts(slow, [30, 2000]) == {"undecided"}


@pytest.mark.parametrize("case", ["general/asymmetric-regular", "general/asymmetric-chaotic"])
def test_without_a_closed_form_no_short_time_decides_for_regular(case):
    for end in (1, 30, 100):
        found = polhode.lyapunov(case, end)
        assert found.verdict == "undecided"
        assert "an end of 1.8e+03 may decide" in found.reason


@pytest.mark.slow
def test_a_regular_motion_is_called_so_in_the_default_time():
    assert polhode.lyapunov("general/asymmetric-regular").verdict == "regular"
