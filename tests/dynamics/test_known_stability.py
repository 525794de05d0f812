"""No unstable motion is called regular, however short it is followed: a row each."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import polhode
from shared.motions import asymmetric
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
    if rate is None:
        rate = polhode.lyapunov(scene, 2000).exponent
    exponent = float(polhode.lyapunov(scene, 1).reason.split("exp(")[1].split(" t")[0])
    assert exponent == pytest.approx(rate, rel=0.01)


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
    with pytest.raises(polhode.BadInput, match="other than 0"):
        polhode.lyapunov(case, 0)


@pytest.mark.slow
def test_a_regular_motion_is_called_so_in_the_default_time():
    assert polhode.lyapunov("general/asymmetric-regular").verdict == "regular"


# -- Chaotic, unstable and regular ones, that are followed


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.slow
def test_a_chaotic_motion_is_told_from_a_regular_one():
    """Spin 1.1: 3e9 at t = 200 and 1e50 at 1000 are exponents of 0.109 and 0.115."""
    chaotic = polhode.lyapunov(asymmetric("1.1", [1]), 2000)
    assert chaotic.verdict == "chaotic"
    assert 0.09 < chaotic.exponent < 0.12
    assert chaotic.uncertainty < 0.02
    regular = polhode.lyapunov(asymmetric("3", [1]), 6000)
    assert regular.verdict == "regular"
    assert abs(regular.exponent) < regular.uncertainty < 1e-3
    assert regular.growth == pytest.approx(math.log(2), abs=0.1)


def the_exponents_of_neighbours_scatter_as_the_uncertainty_says():
    spins = [Fraction(11, 10) + Fraction(k, 1000) for k in range(16)]
    motion = [polhode.lyapunov(asymmetric(str(spin), [1]), 2000) for spin in spins]
    scatter = np.std([x.exponent for x in motion], ddof=1)
    claimed = np.median([x.uncertainty for x in motion])  # some stay near an island for long
    assert 0.5 < claimed / scatter < 2


def test_time_rises_unless_the_scene_s_falls():
    """A scene without times is followed as one that ends soon, not as one that ends before 0."""
    some = [polhode.lyapunov(asymmetric("1.1", times), 300) for times in ([], [1])]
    assert some[0].exponent == some[1].exponent
    before = polhode.lyapunov(asymmetric("1.1", [-1]), max_steps=1000)
    assert before.exponent != polhode.lyapunov(asymmetric("1.1"), max_steps=1000).exponent


@pytest.mark.slow
@pytest.mark.parametrize(("end", "spectrum"), [(1000, False), (500, True)])
def test_exponents_are_per_unit_of_the_scenes_time(end, spectrum):
    slow = polhode.lyapunov(asymmetric("1.1", [1]), end, spectrum=spectrum)
    quick = polhode.lyapunov(asymmetric("1.1", rate=2**40), Fraction(end, 2**40), spectrum=spectrum)
    assert slow.verdict == quick.verdict == "chaotic"
    assert quick.exponent / 2**40 == pytest.approx(slow.exponent, rel=4 * 2.0**-53)
    if spectrum:
        exponents = np.array(quick.spectrum) / 2**40
        assert np.allclose(exponents, slow.spectrum, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    "name", ["pendulum/separatrix", "euler/separatrix", "lagrange/sleeping-unstable"]
)
def test_unstable_periodic_and_asymptotic_motions_are_called_so(name):
    motion = polhode.lyapunov(name)
    assert motion.verdict == "unstable"
    assert motion.exponent > 10 * motion.uncertainty > 0
    assert str(motion).startswith("unstable (periodic or asymptotic): exponent ")
    assert "(one standard deviation) up to t" in str(motion)
    if name.endswith("sleeping-unstable"):
        rate = linear_rates(polhode.load(name))[0]
        assert abs(motion.exponent - rate) < motion.uncertainty
        assert math.isclose(motion.exponent, rate, rel_tol=1e-3)


# -- All six Lyapunov exponents, against those of fixed points and against what symmetry demands


def linear_rates(scene):
    """Of I w' = Iw x w + gamma x T, gamma' = gamma x w, linear about the start, falling."""
    inertia = np.array(scene.body.inertia, dtype=float)
    torque, omega, gamma = (
        np.array([float(x) for x in v]) for v in (scene.body.torque, scene.omega, scene.gamma)
    )
    one = np.eye(3)
    spun = np.cross(inertia, omega) + np.cross(inertia @ omega, one)
    pulled = np.cross(one, torque)
    flow = np.block(
        [
            [np.linalg.solve(inertia, spun.T), np.linalg.solve(inertia, pulled.T)],
            [np.cross(gamma, one).T, np.cross(one, omega).T],
        ]
    )
    return sorted(np.linalg.eigvals(flow).real, reverse=True)


@pytest.mark.parametrize(
    ("case", "end", "off"),
    [("pendulum/upright", None, 2e-3), ("lagrange/sleeping-unstable", 400, 2 / 400)],
)
def test_at_a_fixed_point_they_are_the_rates_of_both_planes(case, end, off):
    """An upright pendulum may fall two ways, faster or slower; a top that sleeps spirals out."""
    scene = polhode.load(case)
    rates = linear_rates(scene)
    assert (rates[1] < rates[0] - 0.1) == (case == "pendulum/upright")
    spectrum = polhode.lyapunov(scene, end, spectrum=True).spectrum
    assert spectrum == pytest.approx(rates, abs=off)


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.parametrize(
    ("end", "pair", "zero"), tiers([(1000, 0.01, 0.02)], [(-1000, 0.01, 0.02)])
)
def test_of_a_chaotic_motion_they_add_up_to_nothing_in_pairs(end, pair, zero):
    """Four zeros: along the motion, and across h, f and |gamma|^2; the flow keeps volume."""
    motion = polhode.lyapunov("general/asymmetric-chaotic", end, spectrum=True)
    first, *zeros, last = motion.spectrum
    assert 0.06 < first < 0.16
    if end > 0:  # the fit is compared forwards only
        assert abs(first - motion.exponent) < 2 * motion.uncertainty
    assert sum(motion.spectrum) == pytest.approx(0, abs=1e-10)
    assert abs(first + last) < pair
    for exponent, opposite in zip(zeros[:2], zeros[:1:-1], strict=True):
        assert exponent == pytest.approx(-opposite, abs=0.01)
    assert max(map(abs, zeros)) < zero
    assert motion.fact("spectrum") == [*motion.spectrum] == sorted(motion.spectrum)[::-1]


@pytest.mark.parametrize(
    ("case", "end", "count", "most"),
    [("euler/largest-axis", 2000, 6, 0.005), ("euler/no-gamma", 400, 3, 6 / 400)],
)
def test_of_a_regular_motion_none_grows_and_without_asking_there_are_none(case, end, count, most):
    motion = polhode.lyapunov(case, end, spectrum=True)
    assert len(motion.spectrum) == count
    assert np.abs(motion.spectrum).max() < most
    assert polhode.lyapunov(case, end).spectrum is None
