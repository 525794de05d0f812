"""Products of vectors and quaternions: exactly, against numpy's and against rotation matrices."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from polhode.numbers import vectors

RANDOM = np.random.default_rng(5)
ROWS = [[Fraction(int(x)) for x in RANDOM.integers(-99, 99, 8)] for _ in range(12)]


def floats(numbers):
    return np.array(numbers, dtype=float)


@pytest.mark.parametrize("row", ROWS)
def test_products_of_vectors_are_numpy_s(row):
    """Whole numbers, of which doubles hold every product."""
    a, b = row[:3], row[3:6]
    assert vectors.dot(a, b) == np.dot(floats(a), floats(b))
    assert [*vectors.cross(a, b)] == np.cross(floats(a), floats(b)).tolist()
    assert [*vectors.minus(a, b)] == (floats(a) - floats(b)).tolist()
    assert [*vectors.scaled(row[6], a)] == (float(row[6]) * floats(a)).tolist()
    assert not vectors.parallel(a, b)
    assert vectors.parallel(a, vectors.scaled(row[7], a))
    assert vectors.is_zero(vectors.cross(a, vectors.scaled(row[7], a)))


def matrix(q):
    """R(q) of a quaternion of any length, times the square of that, by its definition."""
    w, v = q[0], floats(q[1:])
    across = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * across


@pytest.mark.parametrize("row", ROWS)
def test_a_product_of_quaternions_is_that_of_their_matrices(row):
    a, b = floats(row[:4]), floats(row[4:])
    both = vectors.quaternion_product(a, b)
    assert matrix(both) == pytest.approx(matrix(a) @ matrix(b), rel=1e-13, abs=1e-6)
    assert [*vectors.vertical(a)] == matrix(a)[2].tolist()


@pytest.mark.parametrize("row", ROWS)
def test_a_quaternion_held_upright_has_that_vertical(row):
    q, gamma = floats(row[:4]), floats(row[4:7])
    q, gamma = q / np.linalg.norm(q), gamma / np.linalg.norm(gamma)
    found = floats(vectors.upright(q, gamma, np.sqrt))
    assert found @ found == pytest.approx(1, rel=4e-16)
    assert matrix(found)[2] == pytest.approx(gamma, abs=2e-15)


def test_the_inverse_of_a_symmetric_matrix_is_exact():
    half = Fraction(1, 2)
    rows = ((4 * half, half, 0 * half), (half, 6 * half, 2 * half), (0 * half, 2 * half, 5 * half))
    vector = (Fraction(1), Fraction(-2), Fraction(1, 3))
    assert vectors.apply(vectors.inverse(rows), vectors.apply(rows, vector)) == vector
