"""Output times counted from where a chunk begins: rounded once, all of them at once."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest

from polhode.numbers.number_types import DOUBLE, EXTENDED
from polhode.taylor.backend.time_grid import Times, differences


def offsets(seed: int) -> list[Fraction]:
    """Sums of a double and of one or two far below its last bit, as a run's clock is."""
    draw = random.Random(seed)
    found = []
    for _ in range(12):
        high = draw.uniform(0.1, 1000.0)
        low = draw.uniform(-1, 1) * np.spacing(high) / 2
        found += [Fraction(high) + Fraction(low), Fraction(high)]
        found.append(found[-2] + Fraction(draw.uniform(-1, 1) * np.spacing(low) / 2))
    return found


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED], ids=lambda n: n.name)
@pytest.mark.parametrize("sign", [1, -1])
def test_each_time_is_the_exact_difference_rounded_once(number, sign):
    draw = random.Random(3)
    for offset in offsets(1):
        exact = sorted(
            offset + Fraction(draw.uniform(0, 1) * 10.0 ** draw.uniform(-17, 3)) for _ in range(60)
        )
        times = [sign * number.rounded(t) for t in exact]
        found = Times(times, number).since(sign * offset)
        wanted = [number.rounded(t - sign * offset) for t in times]
        assert [Fraction(*x.as_integer_ratio()) for x in found] == wanted


def test_a_tie_is_left_to_exact_arithmetic():
    """4 - offset lies midway between two doubles, but for what the offset has far below."""
    offset = 1 + Fraction(1, 2**52) + Fraction(1, 2**107)
    times = np.array([4.0, 4.0 + 2.0**-50])
    assert differences(times, offset)[1] == [0, 1]
    exact = [DOUBLE.rounded(Fraction(t) - offset) for t in times]
    assert Times([Fraction(t) for t in times], DOUBLE).since(offset).tolist() == [
        float(x) for x in exact
    ]


@pytest.mark.parametrize(("number", "bits"), [(DOUBLE, 53), (EXTENDED, 64)], ids=["53", "64"])
def test_a_tie_below_a_power_of_two_is_one(number, bits):
    """A mantissa of all ones, of which numpy's spacing is nan in extended."""
    below = Fraction(1, 2**bits)
    offset = -60 - below - below / 2 * (1 - Fraction(1, 2**25))  # nearly halfway to the next
    times = Times([Fraction(-61)], number)
    assert differences(times.grid, offset)[1] == [0]
    (found,) = times.since(offset)
    assert Fraction(*found.as_integer_ratio()) == number.rounded(-61 - offset)


def test_regular_times_leave_next_to_nothing_to_exact_arithmetic():
    offset = Fraction(271.3) + Fraction(1.1e-15)
    found, doubtful = differences(np.arange(300.0, 1300.0, 0.01), offset)
    assert len(found) == 100_000
    assert len(doubtful) < 30


def test_a_part_of_times_is_the_same_times():
    times = Times([Fraction(k, 8) for k in range(20)], DOUBLE)
    assert list(times[3:7]) == [Fraction(k, 8) for k in range(3, 7)]
    assert times[3:7].grid.tolist() == [k / 8 for k in range(3, 7)]
    assert (len(times), times[-1]) == (20, Fraction(19, 8))
