"""Phases between two roots in balls: against mpmath, at many precisions, and by force."""

import random
from fractions import Fraction

import mpmath
import pytest
from flint import arb

from polhode.closed_forms.balls import clocks
from polhode.closed_forms.balls.clocks import Factors, Oscillating
from polhode.closed_forms.balls.core import TooFewBits, ball
from polhode.numbers.flint_context import ctx

F = Fraction
#: Of x and of time.
NEAR, FAR = [F(0), F(1, 3), F(-29, 10), F(355, 113), F(17)], [F(-(10**6)), F(10**16)]


def roots(seed, gap=0.0):
    """A root below 0, two above 1, a pair of complex ones; ``gap``: of the first."""
    source = random.Random(seed)

    def value():
        return source.uniform(0.2, 3)

    return -(gap or value()), 1 + value(), 1 + value(), (value() - 1, value())


def motion(seed, bits, gap=0.0):
    low, high, higher, pair = roots(seed, gap)
    with ctx.workprec(bits):
        real = (1, arb(low)), (-1, arb(high)), (-1, arb(higher))
        factors = Factors(real, [(arb(pair[0]), arb(pair[1]))], arb("0.7"))
        return Oscillating(arb(0), arb(1), factors)


def numbers(seed, bits, places=NEAR, gap=0.0):
    """Times and moments at the places, and x at times that are the places."""
    clock = motion(seed, bits, gap)
    with ctx.workprec(bits):
        places_in_balls = [ball(x) for x in places]
        series = [y for x in places_in_balls for y in clock.at(x)[:2]]
        return [*series, *(clock.phase(t) for t in places_in_balls), clock.S[-1]]


def overlap(first, second):
    return all(x.is_finite() and x.overlaps(y) for x, y in zip(first, second, strict=True))


def test_against_mpmath():
    low, high, higher, (middle, height) = roots(3)
    clock = motion(3, 140)
    with mpmath.workdps(40):

        def z(x):
            return (1 - mpmath.cos(x)) / 2

        def pace(x):
            y = z(x)
            square = (y - low) * (high - y) * (higher - y) * ((y - middle) ** 2 + height)
            return mpmath.mpf("0.7") / mpmath.sqrt(square)

        x = mpmath.mpf(22) / 7
        time = mpmath.quad(pace, [0, 1, 2, x])
        moment = mpmath.quad(lambda x: pace(x) * z(x), [0, 1, 2, x])
        half = mpmath.quad(pace, [0, 1, 2, mpmath.pi])
        with ctx.workprec(140):
            place = clock.at(ball(F(22, 7)))
            for ours, right in (
                (place.S, time),
                (place.U, moment),
                (clock.S[-1], half),
                (clock.phase(arb(str(time)) + 6 * clock.S[-1]), 6 * mpmath.pi + x),
            ):
                assert abs(ours - arb(str(right))) < arb(10) ** -36
                assert ours.rad() > arb(10) ** -50


@pytest.mark.parametrize("gap", [0, 1e-4, pytest.param(1e-20, marks=pytest.mark.slow)])
def test_balls_of_all_precisions_overlap(gap):
    """Whatever the radius: what is finite at few bits holds what more bits tell."""
    for places, slack in ((NEAR, 40), (FAR, 90)):
        fine, count = numbers(1, 400, places, gap), 0
        for bits in (30, 40, 53, 107, 192, 330):
            try:
                rough = numbers(1, bits, places, gap)
            except TooFewBits:
                continue
            assert all(x.overlaps(y) for x, y in zip(rough, fine, strict=True))
            if bits > slack + 80:
                assert all(x.rad() < (1 + abs(x)) * arb(2) ** (slack + 70 - bits) for x in rough)
                count += 1
        assert count >= 2


@pytest.mark.parametrize("ratio", [12, 16])
def test_a_rule_for_a_larger_ellipse_than_f_is_bounded_on_misses(monkeypatch, ratio):
    """By force, at 200 bits: points and error of Gauss's rule as if discs were larger."""
    exact = [numbers(seed, 330) for seed in range(3)]
    monkeypatch.setattr(clocks, "RATIO", ratio)
    for seed, fine in enumerate(exact):
        assert not overlap(numbers(seed, 200), fine)


def test_what_few_points_miss_is_in_the_radius(monkeypatch):
    fine = numbers(2, 330)
    monkeypatch.setattr(clocks, "_SPARE", -100)
    rough = numbers(2, 200)
    assert overlap(rough, fine)
    assert rough[2].rad() > arb(-90).exp()


def test_a_phase_that_iteration_misses_is_enclosed_nevertheless(monkeypatch):
    """Newton's iteration proves nothing: a bad end of it widens the ball."""
    clock = motion(5, 120)
    with ctx.workprec(120):
        right = clock.phase(arb(17))
        monkeypatch.setattr(clocks, "_ROUGH", 1e-2)
        monkeypatch.setattr(clocks, "_CLOSE", 40)  # steps below 1/8 are the last
        wrong = clock.phase(arb(17))
        assert wrong.contains(right)
        assert 2**30 * right.rad() < wrong.rad() < arb(2) ** -60
        monkeypatch.setattr(clock, "_fastest", clock._fastest / 2**10)
        assert not clock.phase(arb(17)).overlaps(right)


def test_what_is_not_known_asks_for_more_bits():
    with ctx.workprec(60), pytest.raises(TooFewBits):
        Oscillating(arb(0), arb(1), Factors(((1, arb(0, 1)),)))
