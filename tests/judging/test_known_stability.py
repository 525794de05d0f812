"""No unstable motion is called regular, however short it is followed: a row each."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import polhode
from polhode.dynamics.lyapunov import known_stability
from polhode.taylor.system import system
from shared.tools import tiers

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
        motion = known_stability(scene, system(replace(scene, form="principal"), ()), 1)
        assert motion.rate / 2.0**scene.time_unit == pytest.approx(rate, rel=1e-9)
    else:
        followed = polhode.lyapunov(scene, 2000)
        short = polhode.lyapunov(scene, 1)
        exponent = float(short.reason.split("exp(")[1].split(" t")[0])
        assert exponent == pytest.approx(followed.exponent, rel=0.01)


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
        motion = polhode.lyapunov(case, end)
        assert motion.verdict == "undecided"
        assert "an end of 1.8e+03 may decide" in motion.reason


@pytest.mark.slow
def test_a_regular_motion_is_called_so_in_the_default_time():
    assert polhode.lyapunov("general/asymmetric-regular").verdict == "regular"


# -- All six Lyapunov exponents, against those of fixed points and against what symmetry demands


GENERIC = "general/asymmetric-chaotic"


def test_at_a_fixed_point_they_are_the_rates_of_both_planes():
    """An upright pendulum may fall two ways: I w' = gamma x Mg r0, gamma' = gamma x w, linear."""
    scene = polhode.load("pendulum/upright")
    inertia = np.array([[float(x) for x in row] for row in scene.body.inertia])
    torque, gamma = (np.array([float(x) for x in v]) for v in (scene.body.torque, scene.gamma))
    flow = np.zeros((6, 6))
    flow[:3, 3:] = np.linalg.solve(inertia, -np.cross(torque, np.eye(3)).T)
    flow[3:, :3] = np.cross(gamma, np.eye(3)).T
    rates = sorted(np.linalg.eigvals(flow).real, reverse=True)
    assert 0.5 < rates[1] < rates[0] - 0.1
    spectrum = polhode.lyapunov(scene, spectrum=True).spectrum
    assert spectrum == pytest.approx(rates, abs=2e-3)


@pytest.mark.parametrize("end", tiers([1000], [-1000]))
def test_of_a_chaotic_motion_they_add_up_to_nothing_in_pairs(end):
    motion = polhode.lyapunov(GENERIC, end, spectrum=True)
    assert 0.06 < motion.spectrum[0] < 0.16
    assert sum(motion.spectrum) == pytest.approx(0, abs=1e-10)  # the flow keeps volumes
    for exponent, opposite in zip(motion.spectrum[:3], motion.spectrum[:2:-1], strict=True):
        assert exponent == pytest.approx(-opposite, abs=0.01)
    assert max(map(abs, motion.spectrum[1:5])) < 0.02
    assert motion.fact("spectrum") == [*motion.spectrum]


def test_of_a_regular_motion_none_grows_and_without_asking_there_are_none():
    motion = polhode.lyapunov("euler/largest-axis", 2000, spectrum=True)
    assert np.abs(motion.spectrum).max() < 0.005
    assert polhode.lyapunov("euler/largest-axis", 2000).spectrum is None
