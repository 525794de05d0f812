"""What misses a family by 1e-30: refused by name in one line, and told to be near to it."""

from __future__ import annotations

import itertools
import re
from fractions import Fraction

import numpy as np
import pytest

import polhode
from shared.closed_forms import all_motions, near_families, number, scene_of
from shared.members import rotation, start
from shared.tools import tiers

F = Fraction
TINY = F(1, 10**30)
MOTIONS = {str(motion): motion for motion in all_motions()}
EVERY = tuple(itertools.product(range(3), range(3)))
#: A motion of each family, and the data, as (row, column), of which none may be other: of moments,
#: Mg r0 and omega; (3, n) turns gamma about axis n.
FIXED = {
    "euler/largest-axis": ((1, 0), (1, 1), (1, 2)),
    "lagrange/nutation": ((0, 0), (0, 1), (1, 0), (1, 1)),
    "kovalevskaya: ee-e+": ((0, 0), (0, 1), (0, 2), (1, 2)),
    "pendulum: libration": ((1, 0), (2, 1), (2, 2), (3, 1), (3, 2)),
    "goryachev-chaplygin/two-frequencies": ((0, 0), (0, 1), (0, 2), (1, 2), (2, 0), (3, 2)),
    "hess/general": ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (2, 2)),
    "staude/stable": (*EVERY, (3, 0)),
    "bobylev-steklov/cn": tuple(place for place in (*EVERY, (3, 0)) if place != (0, 1)),
    "grioli/precession": (*EVERY, (3, 0), (3, 1)),
    "steklov/lower": (*EVERY, (3, 0), (3, 1)),
    "goryachev/motion": (*EVERY, (3, 0)),
    "n-kowalewski/motion": (*EVERY, (3, 0)),
    "chaplygin/motion": (*EVERY, (3, 0)),
}


#: Of some data the first is fast; every third one behind it is slow, the others by hand.
PARTS = tiers([slice(0, 1)], [slice(2, None, 3)])


def off(text):
    return float(re.search(r"off by ([\d.e-]+\d)", text)[1])


@pytest.mark.parametrize("part", PARTS, ids=["first", "third on"])
@pytest.mark.parametrize("name", FIXED)
def test_any_datum_moved_by_1e_30_is_refused(name, part):
    motion = MOTIONS[name]
    for row, column in FIXED[name][part]:
        start = [list(part) for part in motion.principal]
        if row < 3:
            start[row][column] = start[row][column] + TINY
        else:
            turn = rotation(1, *(TINY if n == column else 0 for n in range(3)))
            start[3] = [sum(x * y for x, y in zip(line, start[3], strict=True)) for line in turn]
        scene = scene_of(start, motion.family)
        with pytest.raises(polhode.BadInput) as refused:
            polhode.reference(scene)
        message = str(refused.value)
        assert f"{motion.family} needs " in message, (row, column)
        assert "\n" not in message
        assert 1e-34 < off(message) < 1e-26, message
    if part.start == 0 and all(isinstance(x, (int, F)) for line in start for x in line):
        assert 1e-34 < off(near_families(scene)[motion.family]) < 1e-26  # which reads a file


#: Mg r0 and omega of permanent rotations about axis 3, what is moved by how much, and what is said:
#: 1e-30 of |w|, of the rate sqrt(|Mg r0|/A) = 1000 that the weight gives, and of |Mg r0|.
ALONG = "w along gamma, off by 1.00e-30"
SIZES = {
    "a fast rotation": ((10**6, 1000), (2, 0, F(1, 10**27)), ALONG),
    "a slow one": ((2 * 10**6, 1), (2, 0, F(1, 10**27)), ALONG),
    "a weight": ((10**6, 1), (1, 0, F(1, 10**24)), "gamma x Mg r0 = w x Iw, off by 1.00e-30"),
}


@pytest.mark.parametrize("name", SIZES)
def test_a_rotation_is_off_in_parts_of_what_is_compared(name):
    (weight, rate), (row, column, moved), said = SIZES[name]
    start = [[2, F(3, 2), 1], [0, 0, weight], [0, 0, rate], [0, 0, 1]]
    assert polhode.reference(scene_of(start, "staude")).is_closed_form
    start[row][column] += moved
    with pytest.raises(polhode.BadInput, match=re.escape(said)):
        polhode.reference(scene_of(start, "staude"))


#: Mg r0, omega and gamma of no family.
FAR = (F(3, 10), F(1, 5), F(1, 2)), (F(3, 10), F(1, 5), F(11, 10)), (F(3, 5), F(0), F(4, 5))
#: Moments at which conditions and formulas of some family divide by nothing.
BODIES = (
    (3, 2, F(3, 2)),
    (2, 2, 1),
    (1, 1, 1),
    (4, 4, 1),
    (2, 1, 1),
    (5, 5, 3),
    (3, 3, 2),
    (3, 2, 1),
)


@pytest.mark.parametrize("part", PARTS, ids=["first", "third on"])
@pytest.mark.parametrize("family", [MOTIONS[name].family for name in FIXED])
def test_bodies_far_from_a_family_are_told_what_it_needs(family, part):
    for moments in BODIES[part]:
        if family == "lagrange" and moments == (1, 1, 1):
            continue  # a sphere is one
        with pytest.raises(polhode.BadInput, match=f"{family} needs ") as refused:
            polhode.reference(scene_of((moments, *FAR), family))
        assert "\n" not in str(refused.value)


def test_a_body_far_from_all_families_is_near_none():
    assert near_families(scene_of((BODIES[0], *FAR))) == {}


@pytest.mark.parametrize(
    ("question", "name", "reason"),
    [
        ("attitude", "euler/no-gamma", "without gamma: only its omega is known"),
        ("angles", "euler/no-gamma", "without gamma: only its omega is known"),
    ],
)
def test_a_question_without_an_answer(question, name, reason):
    with pytest.raises(polhode.BadInput, match=reason):
        getattr(MOTIONS[name].reference, question)([10**6], 20)


def slopes(start):
    """The matrix of the equations, linear about a start, by differences in doubles."""
    moments, torque, omega, gamma = (np.array([float(number(x)) for x in row]) for row in start)

    def rates(state):
        w, g = state[:3], state[3:]
        moment = np.cross(g, torque) - np.cross(w, moments * w)
        return np.concatenate([moment / moments, np.cross(g, w)])

    state, steps = np.concatenate([omega, gamma]), 1e-3 * np.eye(6)  # quadratic: no truncation
    return np.array([(rates(state + h) - rates(state - h)) / 2e-3 for h in steps]).T


def test_stability_of_permanent_rotations_against_eigenvalues():
    """Random ones; what is undecided is none of them."""
    regimes = set()
    for seed in range(80):
        body = start("staude", seed)[0]
        if min(body[0]) < F(1, 10) or max(map(abs, body[2])) < F(1, 10):
            continue
        regime = polhode.reference(scene_of(body, "staude")).regime
        growth = max(np.linalg.eigvals(slopes(body)).real)
        if "undecided" not in regime:
            regimes.add(regime)
            assert (growth > 1e-5) == ("unstable" in regime), (seed, regime, growth)
    assert len(regimes) == 2
