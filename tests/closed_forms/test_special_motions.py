"""What ``near`` tells of special motions: named, by how much, and nothing of others."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest
import test_goryachev_chaplygin as chaplygin
import test_hess as hess

from polhode.closed_forms import families
from polhode.numbers import exact
from polhode.scenes import library
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

F = Fraction

#: A case near a special motion, what is told of it first, and between what amounts.
CASES = {
    "hard/near-cusp": ("lagrange, cusped", "f = C r b", 1e-16, 1e-15),
    "hard/near-pole": ("lagrange, through the upper pole", "f = C r", 1e-13, 1e-12),
    "hard/near-homoclinic": ("lagrange, homoclinic to the sleeping top", "b = 1", 1e-12, 1e-10),
    "hard/near-steady": ("lagrange, steady precession", "theta'' = 0", 1e-10, 1e-8),
    "hard/sleeping-below-critical-spin": (
        "lagrange, sleeping, critical spin",
        "C^2 r^2 = 4 A Mg z0",
        0.9e-10,
        1.1e-10,
    ),
    "hard/near-appelrot": ("kovalevskaya, Appelrot, special motion", "ro^2 G1", 1e-12, 1e-11),
    "hard/near-asymptotic": ("kovalevskaya, degenerate curve", "k or -k", 1e-13, 1e-11),
    "hard/near-quasi-periodic": ("kovalevskaya, degenerate curve", "k or -k", 1e-13, 1e-11),
    "kovalevskaya/near-delaunay": ("kovalevskaya, Delaunay", "(p + iq)^2 = G1", 1e-21, 1e-19),
    "euler/near-separatrix": ("euler, separatrix", "G^2 = 2 h B", 1e-11, 1e-9),
    "hard/dzhanibekov-1e-9": ("euler, permanent rotation", "axis 2", 0.9e-9, 1.1e-9),
    "euler/nearly-symmetric": ("euler, symmetric body", "A = B", 4e-13, 6e-13),
}


@pytest.mark.parametrize("case", CASES)
def test_a_case_near_a_special_motion_is_told_so(case):
    name, condition, low, high = CASES[case]
    told, missed = families.near(library.load(case))[0]
    assert told == name
    assert condition in missed.condition
    assert low < float(missed.off) < high


@pytest.mark.sample(10)
@pytest.mark.parametrize(
    "case",
    [
        *("lagrange/cusped", "lagrange/upper-pole", "lagrange/lower-pole", "lagrange/homoclinic"),
        *("lagrange/steady-fast", "lagrange/sleeping-critical", "lagrange/nutation"),
        *("kovalevskaya/delaunay", "kovalevskaya/appelrot", "kovalevskaya/asymptotic"),
        *("kovalevskaya/quasi-periodic", "kovalevskaya/multiply-degenerate"),
        *("kovalevskaya/type-eee-outside", "kovalevskaya/generic", "euler/separatrix"),
        *("pendulum/separatrix", "bobylev-steklov/asymptotic", "hess/cone", "hess/released"),
        *("goryachev-chaplygin/v-constant", "goryachev-chaplygin/v-asymptotic"),
        *("goryachev-chaplygin/released", "goryachev-chaplygin/two-frequencies"),
    ],
)
def test_a_special_motion_itself_and_a_generic_one_are_near_to_none(case):
    assert families.near(library.load(case)) == []


def _on_cubics(u, v, a, H, G):
    return chaplygin.place(chaplygin.on_cubics(F(u), F(v), F(a), H, G))


def _bobylev(gap):
    """gamma1 + C r^2/2 Mg x0 = 1 - gap, Mg x0 gamma3 = C p r."""
    g1, g3 = F(3, 4) - gap, F(3, 10)
    gamma = g1, exact.sqrt(1 - g1 * g1 - g3 * g3), g3
    return (F(2), F(3, 2), F(1)), (F(2), F(0), F(0)), (2 * g3, F(0), F(1)), gamma


def _swing(gap):
    """h = 1 - gap about axis 3, from the lowest point."""
    speed = exact.sqrt((4 - 2 * gap) / 2)
    return (F(3), F(5, 2), F(2)), (F(1), F(0), F(0)), (F(0), F(0), speed), (F(-1), F(0), F(0))


def _off_the_plane(gap):
    body, torque, omega, gamma = hess.named("libration")
    momentum = [m * w for m, w in zip(body, omega, strict=True)]
    assert sum(x * y for x, y in zip(momentum, gamma, strict=True)) == 0
    return body, torque, tuple(w + gap * e for w, e in zip(omega, (2, 1, -3), strict=True)), gamma


def _off_the_cone(gap):
    body, torque, omega, gamma = hess.named("cone")
    return body, torque, tuple(w * (1 + gap) for w in omega), gamma


def _hess_level(gap):
    body, torque, omega, gamma = hess.named("separatrix")
    return body, torque, tuple(w * (1 + gap) for w in omega), gamma


#: A motion that is ``gap`` from a special one, and what is told.
MOVED = {
    "G = 0": ("goryachev-chaplygin, G = 0", lambda x: _on_cubics("5/4", "2/3", 1, F(1), x)),
    "D- from above": (
        "goryachev-chaplygin, v constant or asymptotic, eta = pi",
        lambda x: _on_cubics("9/4", "3/4", 2, 7 + x, F(1, 2)),
    ),
    "D- from below": (
        "goryachev-chaplygin, v constant or asymptotic, eta = pi",
        lambda x: _on_cubics("9/4", "3/4", 2, 7 - x, F(1, 2)),
    ),
    "D+": (
        "goryachev-chaplygin, v constant, eta = 0",
        lambda x: _on_cubics("3/2", "1", 1, 1 + x * x, F(1, 2)),
    ),
    "H = 2a": (
        "goryachev-chaplygin, G = 0, H = 2a",
        lambda x: _on_cubics("3/2", "5/4", 1, 2 + x, F(0)),
    ),
    "bobylev": ("bobylev-steklov, asymptotic to a rotation", _bobylev),
    "pendulum": ("pendulum, separatrix", _swing),
    "hess, f": ("hess, f = 0", _off_the_plane),
    "hess, cone": ("hess, steady cone", _off_the_cone),
    "hess, level": ("hess, separatrix", _hess_level),
}


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", MOVED)
def test_the_amount_grows_as_the_distance_and_no_more_is_told_far_off(name):
    motion, moved = MOVED[name]
    amounts = []
    for gap in (F(1, 10**6), F(1, 10**9)):
        moments, torque, omega, gamma = moved(gap)
        start = Scene(Body.of_moments(moments, torque, 1), omega, gamma)
        found = dict(families.near(start))
        assert motion in found, found
        amounts.append(float(found[motion].off) / float(gap))
    assert 0.05 < amounts[0] < 20
    assert abs(amounts[1] / amounts[0] - 1) < 1e-2
    moments, torque, omega, gamma = moved(F(1, 50))
    far = Scene(Body.of_moments(moments, torque, 1), omega, gamma)
    assert motion not in dict(families.near(far))


BODIES = {
    "euler": ((3, 2, F(3, 2)), (0, 0, 0)),
    "lagrange": ((1, 1, F(7, 10)), (0, 0, 1)),
    "kovalevskaya": ((2, 2, 1), (1, 0, 0)),
}


@pytest.mark.parametrize("name", BODIES)
def test_generic_motions_are_near_to_none(name):
    """Of 400 at random none of Euler's and Lagrange's, four of Kovalevskaya's: nine distances."""
    pick, told = random.Random(5), 0
    for _ in range(12):
        omega = [F(pick.randint(-(10**6), 10**6), 500_000) for _ in range(3)]
        x, y = (F(pick.randint(-2000, 2000), 1000) for _ in range(2))
        norm = 1 + x * x + y * y
        gamma = 2 * x / norm, 2 * y / norm, pick.choice((1, -1)) * (2 / norm - 1)
        moments, torque = BODIES[name]
        told += bool(families.near(Scene(Body.of_moments(moments, torque, 1), omega, gamma)))
    assert told <= 1
