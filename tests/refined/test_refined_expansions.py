"""Numbers as sums of doubles: every operation against integers, bit for bit where it says exact."""

import random
from fractions import Fraction

import numpy as np
import pytest

from polhode.refined.expansions import Limbs, product, rounded

KINDS = [Limbs(4, 24), Limbs(7, 23), Limbs(15, 22)]
kinds = pytest.mark.parametrize("kind", KINDS, ids=str)


def numbers(kind, count, seed=0, size=1):
    draw = random.Random(seed)
    most = size << kind.finest
    return [Fraction(draw.randint(-most, most), 1 << kind.finest) for _ in range(count)]


def well_formed(limbs, kind, slack=0.0):
    """Every limb a multiple of its unit, and at most half of the one before.

    ``slack``: a head that was rounded from a sum may be a hair too far off.
    """
    for i, x in enumerate(limbs, start=1):
        if i < kind.count:
            assert Fraction(float(x)) * 2 ** kind.place(i) % 1 == 0
        if i > 1:
            assert abs(x) <= 2.0 ** -(kind.place(i - 1) + 1) * (1 + slack)


@kinds
def test_a_number_is_split_into_limbs_that_add_up_to_it(kind):
    for x in [*numbers(kind, 50), *numbers(kind.shifted(2), 50, size=4)]:
        limbs = kind.split(x)
        well_formed(limbs, kind)
        rest = abs(kind.value(limbs) - x)
        assert rest <= Fraction(1, 1 << kind.finest + 1)
    for x in numbers(kind, 50):
        whole = int(x * 2**kind.finest)
        assert kind.integer(kind.split_integer(whole)) == whole
    third = kind.split(Fraction(1, 3))
    assert 0 < abs(kind.value(third) - Fraction(1, 3)) <= Fraction(1, 1 << kind.finest + 1)


@kinds
def test_doubles_are_split_without_loss(kind):
    x = np.random.default_rng(1).uniform(-1, 1, (3, 5))
    limbs = kind.split_doubles(x)
    assert limbs.shape == (kind.count, 3, 5)
    for at in np.ndindex(3, 5):
        well_formed(limbs[(slice(None), *at)], kind)
        assert kind.value(limbs[(slice(None), *at)]) == Fraction(x[at])


def test_rounding_to_a_place_is_to_the_nearest():
    for place in (24, 48, 70):
        unit = 2.0**-place
        for v in np.random.default_rng(2).uniform(-1000, 1000, 200) * unit:
            assert rounded(v, place) == np.rint(v / unit) * unit


@kinds
def test_small_doubles_are_added_without_loss(kind):
    draw = np.random.default_rng(3)
    exact = numbers(kind, 40)
    x = np.array([kind.split(v) for v in exact]).T.copy()
    for size in (1e-9, 1e-13, 1e-17, 1e-25):
        small = draw.uniform(-size, size, 40)
        kind.adjust(x, small)
        exact = [a + Fraction(b) for a, b in zip(exact, small, strict=True)]
        for n in range(40):
            # what is lost is below the last bit of the larger of the two: small, the last limb
            error = abs(kind.value(x[:, n]) - exact[n])
            lost = max(2.0 ** -kind.place(kind.count - 1), 2 * size)
            assert error <= Fraction(lost) / 2**53
            exact[n] = kind.value(x[:, n])
    for n, again in enumerate(kind.renormalised(x.T)):
        well_formed(again, kind)
        assert abs(kind.value(again) - exact[n]) < Fraction(1, 1 << kind.finest)


@kinds
def test_the_levels_of_a_product_are_exact(kind):
    for x, y in zip(numbers(kind, 30, 4), numbers(kind, 30, 5, size=4), strict=True):
        a, b = kind.split(x), kind.split(y)
        found = product(a, b)
        for total, level in enumerate(found.exact, start=2):
            pairs = [(i, total - i) for i in range(1, total)]
            exact = sum(Fraction(a[i - 1]) * Fraction(b[j - 1]) for i, j in pairs)
            assert Fraction(level) == exact


@kinds
def test_a_product_is_right_to_the_bits_that_the_kind_claims(kind):
    worst = Fraction(0)
    for x, y in zip(numbers(kind, 100, 6), numbers(kind, 100, 7), strict=True):
        limbs = product(kind.split(x), kind.split(y)).limbs(kind)
        well_formed(limbs, kind, 2.0**-20)
        worst = max(worst, abs(kind.value(limbs) - x * y))
    assert worst < Fraction(1, 1 << kind.bits)
    assert worst > Fraction(1, 1 << kind.bits + 14)  # the claim is no more modest than that


@kinds
def test_sums_of_products_are_added_by_levels_and_renormalised_once(kind):
    a, b, c, d = (kind.split(x) for x in numbers(kind, 4, 8))
    found = (product(a, b) - product(c, d)).limbs(kind)
    exact = kind.value(a) * kind.value(b) - kind.value(c) * kind.value(d)
    assert abs(kind.value(found) - exact) < Fraction(2, 1 << kind.bits)
    added = (product(a, b) + product(c, d)).limbs(kind.shifted(2))
    exact = kind.value(a) * kind.value(b) + kind.value(c) * kind.value(d)
    assert abs(kind.value(added) - exact) < Fraction(2, 1 << kind.bits)


def test_arrays_and_floats_give_the_same_limbs():
    kind = Limbs(4, 24)
    x, y = numbers(kind, 20, 10), numbers(kind, 20, 11)
    columns = [np.array([kind.split(v) for v in values]).T for values in (x, y)]
    together = np.array(product(list(columns[0]), list(columns[1])).limbs(kind))
    for n in range(20):
        assert together[:, n].tolist() == product(kind.split(x[n]), kind.split(y[n])).limbs(kind)
