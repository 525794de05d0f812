"""Zeros between knots: of functions whose zeros are known, and of those that only touch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from polhode.taylor.events import hermite_roots

CONTACT = FLAT = 2.0**-26


@pytest.fixture(scope="module")
def newton():
    return hermite_roots.newton()


def cosine(rate, shift, knots):
    """cos(rate t) - shift and its derivatives."""
    turns = [
        rate**k * np.cos(rate * knots + k * math.pi / 2) for k in range(hermite_roots.DERIVATIVES)
    ]
    return np.array(turns) - np.outer(
        [1.0] + [0.0] * (hermite_roots.DERIVATIVES - 1), shift + 0 * knots
    )


def found(values, width, newton):
    crossed = hermite_roots.crossed(values, width, CONTACT, FLAT, newton)
    return crossed, (crossed.cells + crossed.places) * width


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("shift", [0.0, 0.5, -0.9, 0.999, 0.999999])
@pytest.mark.parametrize("width", [0.25, 1.0, 3.0])
def test_zeros_of_a_cosine_are_found_once_or_their_cells_are_unsure(shift, width, way, newton):
    """Unsure are few, where two zeros are nearly one: 9e-2 apart (0.999), and 3e-3 (0.999999)."""
    count = 1500
    knots = way * width * np.arange(count + 1)
    crossed, times = found(cosine(1.0, shift, knots), way * width, newton)
    angle, end = math.acos(shift), count * width
    turns = np.arange(int(end / (2 * math.pi)) + 2)
    true = np.sort(np.concatenate([2 * math.pi * turns + angle, 2 * math.pi * turns - angle]))
    true = true[(true > 0) & (true < end)]
    most = {0.999: 0.05, 0.999999: 0.05 if width < 1 else 1.0}.get(shift, 0.0)
    assert crossed.unsure.sum() <= most * len(true)
    true = true[~crossed.unsure[(true / width).astype(int)]]
    assert len(times) == len(true)
    # what one interval's interpolation is off by at most, roundings of time, and where Newton's
    # method is left; nearly double zeros are left earlier
    off = ((width / 2) ** 10 / math.factorial(10) + 1e-15 * end) / math.sin(angle)
    left = width * (2.0**-20 if abs(shift) < 0.99 else 2.0**-14)
    assert np.all(np.abs(np.abs(times) - true) < 2 * off + left)


def test_a_zero_at_a_knot_is_counted_once(newton):
    """Shifts of a rounding either way: the knot's sign is that of both neighbours."""
    width = math.pi / 4
    for shift in (0.0, 1e-17, -1e-17, 1e-16, -1e-16, 1e-12, -1e-12):
        knots = width * np.arange(41)
        values = cosine(1.0, shift, knots)
        for exact in (False, True):
            if exact:
                values[0, np.abs(values[0]) < 1e-14] = 0.0
            crossed, times = found(values, width, newton)
            assert not crossed.unsure.any()
            assert np.abs(times - math.pi * (np.arange(10) + 0.5)).max() < 1e-5


@pytest.mark.parametrize("off", [0.0, 1e-9, -1e-9, 1e-12])
def test_a_touch_is_unsure_wherever_it_is_and_a_miss_is_not(off, newton):
    at_knots = [2 * math.pi - 3 - k / 8 for k in range(8)]  # and where an interval is halved
    for begin in (*np.linspace(0, 1, 23), *at_knots):
        knots = begin + np.arange(51)
        crossed, times = found(cosine(1.0, 1 + off, knots), 1.0, newton)
        touches = 2 * math.pi * np.arange(1, 9) - begin
        touches = touches[(touches > 0) & (touches < 50)]
        assert len(times) == 0
        for touch in touches:
            assert crossed.unsure[max(0, int(touch - 1e-9)) : int(touch + 1e-9) + 1].any()
        assert crossed.unsure.sum() <= 2 * (len(touches) + 1)
    crossed, times = found(cosine(1.0, 1.001, knots), 1.0, newton)
    assert len(times) == 0
    assert not crossed.unsure.any()


def test_a_triple_zero_is_unsure(newton):
    """(sin t)**3 crosses zero without a slope."""
    knots = 0.3 + 0.5 * np.arange(60)
    first, third = (cosine(n, 0.0, knots - math.pi / 2) for n in (1, 3))
    third *= np.array([(-1.0)] * hermite_roots.DERIVATIVES)[:, None]
    values = (3 * first - third) / 4  # of cos(t - pi/2) = sin t, and -cos(3 (t - pi/2)) = sin 3t
    crossed, times = found(values, 0.5, newton)
    assert len(times) == 0
    zeros = np.arange(math.pi, knots[-1], math.pi)
    assert crossed.unsure[((zeros - 0.3) / 0.5).astype(int)].all()


@pytest.mark.parametrize("rate", [7.3, 12.0, 40.1, 2 * math.pi])
def test_what_is_too_fast_for_the_knots_is_never_taken_for_something_slow(rate, newton):
    """A zero is told only where it is one; where none is told and nothing unsure, there is none."""
    knots = 0.1 + 1.0 * np.arange(500)
    crossed, _ = found(cosine(rate, 0.0, knots), 1.0, newton)
    assert crossed.unsure.mean() > 0.95


def test_blocks_leave_no_trace(newton, monkeypatch):
    knots = 0.7 * np.arange(500)
    values = cosine(1.0, 0.2, knots)
    whole, _ = found(values, 0.7, newton)
    monkeypatch.setattr(hermite_roots, "_BLOCK", 64)
    cut, _ = found(values, 0.7, newton)
    assert np.array_equal(whole.cells, cut.cells)
    assert np.array_equal(whole.places, cut.places)
    assert not (whole.unsure | cut.unsure).any()


def test_what_is_not_finite_is_unsure(newton):
    values = cosine(1.0, 0.0, 0.5 * np.arange(40))
    values[2, 20] = np.nan
    crossed, _ = found(values, 0.5, newton)
    assert crossed.unsure[19:21].all()
    assert not crossed.unsure[:10].any()
    few, times = found(values[:, :2], 0.5, newton)
    assert few.unsure.all()
    assert len(times) == 0


def test_the_error_of_interpolation_is_that_of_two_intervals():
    """Of cos t over two intervals of width w: at most w**10/10! in the middle."""
    for width in (0.5, 1.0, 2.0):
        told = hermite_roots.error(cosine(1.0, 0.0, width * np.arange(200)), width)
        assert 0.5 < told / (width**10 / math.factorial(10)) < 1.05
