"""Quaternions joined and held upright, against rotations of vectors."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from polhode.equations import kinematics, quaternion_products
from polhode.equations.hodographs import turned
from polhode.scenes.body import cross, dot

EPS = 2.0**-52


def test_a_product_turns_by_one_and_then_by_the_other():
    """Exactly, in fractions: R(a ⊗ b) v = R(a) R(b) v, and not the other way round."""
    a, b = [Fraction(x) for x in (1, -2, 3, 5)], [Fraction(x) for x in (7, 1, -4, 2)]
    v = [Fraction(x) for x in (3, 11, -6)]
    whole = turned(quaternion_products.product(a, b), v)
    assert whole == turned(a, turned(b, v))
    assert whole != turned(b, turned(a, v))


def test_the_vertical_is_what_the_attitude_turns_to_the_third_axis():
    q = [Fraction(x, 7) for x in (2, 3, -6, 0)]  # 4 + 9 + 36 = 49
    assert turned(q, quaternion_products.vertical(q)) == [0, 0, 1]
    gamma = (Fraction(2, 3), Fraction(-1, 3), Fraction(2, 3))
    start = [float(x) for x in kinematics.starting_attitude(gamma, Fraction(2))]
    assert np.allclose(
        quaternion_products.vertical(start), [float(x) for x in gamma], rtol=0, atol=4 * EPS
    )


def test_an_upright_quaternion_is_of_length_one_and_the_nearest_one():
    """The turn between the two is the angle between the verticals, about an axis across both."""
    random = np.random.default_rng(5)
    q = random.normal(size=(4, 200))
    q /= np.linalg.norm(q, axis=0)
    gamma = np.array(quaternion_products.vertical(q)) + 1e-3 * random.normal(size=(3, 200))
    gamma /= np.linalg.norm(gamma, axis=0)
    found = np.array(quaternion_products.upright(q, gamma, np.sqrt))
    assert np.abs(np.linalg.norm(found, axis=0) - 1).max() <= 4 * EPS
    assert np.abs(np.array(quaternion_products.vertical(found)) - gamma).max() <= 8 * EPS
    assert np.abs(np.array(quaternion_products.vertical(q)) - gamma).max() > 1e-4
    back = np.array(quaternion_products.product([q[0], *-q[1:]], found))
    angle = 2 * np.arcsin(np.linalg.norm(back[1:], axis=0))
    own = quaternion_products.vertical(q)
    between = np.arcsin(np.linalg.norm(cross(gamma, own), axis=0))
    assert np.abs(angle - between).max() <= 16 * EPS
    assert np.abs(dot(back[1:], gamma)).max() <= 8 * EPS
    assert (dot(q[:3], found[:3]) + q[3] * found[3] > 0).all()


def test_numbers_and_columns_of_them_give_the_same():
    q, gamma = [0.5, -0.5, 0.5, 0.5], [0.0, 0.6, 0.8]
    one = quaternion_products.upright(q, gamma, math.sqrt)
    many = quaternion_products.upright(*(np.array(x)[:, None] for x in (q, gamma)), np.sqrt)
    assert one == [x[0] for x in many]
