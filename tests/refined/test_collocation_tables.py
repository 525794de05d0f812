"""Gauss tables against exact integrals, and products by levels against integers, bit for bit."""

from fractions import Fraction

import numpy as np
import pytest

from polhode.refined.collocation_tables import LARGEST_FIELD, tables
from polhode.refined.compiled_field import FIELD_SHIFT
from polhode.refined.expansions import Limbs
from polhode.refined.gauss_legendre import gauss
from polhode.refined.self_test import exact_product, products_are_exact

QUAD = Limbs(4, 24)


@pytest.mark.parametrize("count", [12, 15, 29, 40])
def test_nodes_integrate_polynomials_exactly_up_to_their_degree(count):
    bits = 200
    g = gauss(count, bits)
    unit = Fraction(1, 1 << bits)
    c = [(x * unit + 1) / 2 for x in g.nodes]
    tolerance = count * unit
    for degree in (0, 1, 5, count - 1):
        powers = [x**degree for x in c]
        for j, end in [*enumerate(c), (count, Fraction(1))]:
            found = sum(a * unit * p for a, p in zip(g.integrals[j], powers, strict=True))
            assert abs(found - end ** (degree + 1) / (degree + 1)) < tolerance
    for degree, exact in ((2 * count - 1, True), (2 * count, False)):
        found = sum(b * unit * x**degree for b, x in zip(g.weights, c, strict=True))
        assert (abs(found - Fraction(1, degree + 1)) < tolerance) == exact


def test_the_tables_in_double():
    t = tables(QUAD, 29)
    x = 2 * t.nodes - 1
    coarse = np.polynomial.legendre.leggauss(14)[0]
    eps = np.finfo(float).eps
    assert np.abs(t.integrals @ np.cos(t.nodes) - np.sin(t.nodes)).max() < 4 * eps
    assert abs(t.weights @ np.cos(t.nodes) - np.sin(1)) < 4 * eps
    assert np.abs(t.thinned @ np.cos(3 * x) - np.cos(3 * coarse)).max() < 16 * eps
    ends = np.concatenate([x, [-1.0, 1.0]])
    for points, integral in ((coarse, t.coarse), (ends, t.fine)):
        found = integral @ np.cos(coarse)  # of degree 13: good to its last Legendre coefficient
        assert np.abs(found - np.sin(points) / 2).max() < 64 * eps


@pytest.mark.parametrize(("limbs", "nodes"), [(QUAD, 29), (QUAD, 34), (Limbs(7, 23), 40)])
def test_products_by_levels_are_exact_for_the_largest_fields(limbs, nodes):
    """|F1| at its bound 4 and signs such that all terms of a row add up."""
    t = tables(limbs, nodes)
    kind = limbs.shifted(FIELD_SHIFT)
    largest = kind.split(Fraction(LARGEST_FIELD) - Fraction(1, 1 << kind.place(1) + 2))
    assert products_are_exact(t, limbs)
    for row in (0, nodes // 2, nodes, nodes + 2):
        for limb in range(limbs.count - 1):
            signs = np.sign(t.levels[limb][row, :nodes])  # of limb A_{limb + 1}, which meets F_1
            one = np.array(largest)[:, None] * np.where(signs == 0, 1.0, signs)
            field = np.broadcast_to(one[None, :, :, None], (6, limbs.count, nodes, 1)).copy()
            levels = t.integrated(field)[:-1]
            for i, level in enumerate(levels):
                exact = exact_product(t.levels[i][row], field[0, :, :, 0], limbs)
                assert level[0, row, 0] * 2.0 ** (limbs.width * (i + 2)) == exact


def test_too_many_nodes_for_the_width_are_refused():
    with pytest.raises(ValueError, match="100 nodes are too many for limbs of 24 bits"):
        tables(Limbs(8, 24), 100)


@pytest.mark.parametrize(("limbs", "nodes"), [(QUAD, 29), (Limbs(7, 23), 40)])
def test_the_whole_product_is_right_to_the_last_bits(limbs, nodes):
    t = tables(limbs, nodes)
    kind = limbs.shifted(FIELD_SHIFT)
    draw = np.random.default_rng(2)
    unit = Fraction(1, 1 << kind.finest)
    numbers = [Fraction(int(x), 1) for x in draw.integers(-(2**62), 2**62, nodes)]
    exact = [x * 4 / 2**62 + unit * int(k) for x, k in zip(numbers, range(nodes), strict=True)]
    field = np.array([kind.split(x) for x in exact]).T
    given = np.broadcast_to(field[None, :, :, None], (6, *field.shape, 1)).copy()
    levels = t.integrated(given)
    few = t.integrated(given, 3)  # the first of them, for sweeps that can use no more
    assert len(few) == min(3, limbs.count)
    assert all((a == b).all() for a, b in zip(few, levels, strict=False))
    bits = limbs.finest + 64
    g = gauss(nodes, bits)
    worst = Fraction(0)
    for row in range(nodes + 1):
        found = sum(Fraction(float(x[0, row, 0])) for x in levels)
        true = sum(Fraction(a, 1 << bits) * f for a, f in zip(g.integrals[row], exact, strict=True))
        worst = max(worst, abs(found - true))
    assert worst < Fraction(1, 1 << limbs.bits)
    last = [2 * (nodes - 2) + 1, 2 * (nodes - 1) + 1]
    true = max(
        abs(
            sum(
                Fraction(w * p[nodes - 2 + i], 1 << 2 * bits) * f * last[i]
                for w, p, f in zip(g.weights, g.legendre, exact, strict=True)
            )
        )
        for i in range(2)
    )
    assert t.last_coefficients(levels)[0] == pytest.approx(float(true), rel=2.0**-40)
