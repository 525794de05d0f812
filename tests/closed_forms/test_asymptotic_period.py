"""Turns of a motion that tends to a periodic one, from a count that knows neither."""

import pytest

from polhode.closed_forms._winding.asymptotic_period import Repeating, Settled
from polhode.numbers.mpmath_context import mpf, mpmath

PERIOD, ADVANCE = mpf(3), mpf("0.7")


def counted(since, t):
    """From one time to another."""
    return tuple(b - a for a, b in zip(grown(since), grown(t), strict=True))


def grown(t):
    """Arguments that grow by the advance and by whole turns a period, once settled."""
    side, n = (1 if t > 0 else -1), mpmath.floor(abs(t) / PERIOD)
    early = 2 * mpmath.pi * side * min(n, 5)
    return side * n * ADVANCE + early, side * n * (ADVANCE - 4 * mpmath.pi) + 3 * early


@pytest.mark.parametrize("t", ["19", "-19", "100.5", "-1e12"])
def test_beyond_the_edge_every_period_counts_like_the_first(t):
    found = Repeating(counted, Settled(mpf("15.5"), PERIOD, ADVANCE))
    for one, other in zip(found.growth(mpf(t)), grown(mpf(t)), strict=True):
        assert abs(one - other) < mpf("1e-15") * abs(other)


@pytest.mark.parametrize("fault", ["period", "edge"])
def test_a_fault_is_noticed(fault):
    wrong = {"period": (mpf("15.5"), PERIOD * 2), "edge": (mpf(1), PERIOD)}[fault]
    found = Repeating(counted, Settled(*wrong, ADVANCE))
    one, other = found.growth(mpf(1001)), grown(mpf(1001))
    assert max(abs(a - b) for a, b in zip(one, other, strict=True)) > 1


def test_reached_a_period_beyond_the_edge():
    settled = Settled(mpf(15), PERIOD, ADVANCE)
    assert [settled.reached(mpf(t)) for t in (17, 18, 19, -17, -19)] == [0, 0, 1, 0, 1]


@pytest.mark.parametrize("side", [1, -1])
def test_what_was_counted_once_is_not_counted_again(side):
    edge, asked = mpf("15.5"), []

    def counting(since, t):
        asked.append((abs(since), abs(t)))
        return counted(since, t)

    found = Repeating(counting, Settled(edge, PERIOD, ADVANCE))
    found.growth(side * mpf(1000))
    assert [end for since, end in asked if since == 0] == [edge], "from 0 once, up to the edge"
    assert len(asked) == 18, "16 knots in a period and the way from one of them"
    for t in range(2000, 2100):
        asked.clear()
        both = found.growth(side * mpf(t) / 7)
        ((since, end),) = asked
        assert edge <= since <= end < since + PERIOD / 15
        true = grown(side * mpf(t) / 7)
        assert all(abs(a - b) < 1e-9 for a, b in zip(both, true, strict=True))
