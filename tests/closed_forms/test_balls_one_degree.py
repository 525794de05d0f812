"""Motions of one degree of freedom in balls: against mpmath, at many precisions, and by force."""

import random
from fractions import Fraction

import mpmath
import pytest
from flint import acb, arb

from polhode.closed_forms.balls import one_degree
from polhode.closed_forms.balls.core import Refused, TooFewBits, ball
from polhode.closed_forms.balls.one_degree import OneDegree
from polhode.closed_forms.balls.quadrature import Linear, bound
from polhode.numbers.flint_context import ctx

F = Fraction
#: Of x and of time.
NEAR, FAR = [F(0), F(1, 3), F(-29, 10), F(355, 113), F(17)], [F(-(10**6)), F(10**16)]


def ends(seed, gap=0.0):
    """Both ends of two real factors and a conjugate pair; ``gap``: the first end of the first."""
    source = random.Random(seed)

    def value():
        return source.uniform(0.2, 3)

    one, two = (complex(value(), value()) for _ in range(2))
    rows = [(value(), value()), (value(), value()), (one, two), (one.conjugate(), two.conjugate())]
    return [(gap or rows[0][0], rows[0][1]), *rows[1:]]


def motion(rows, bits):
    with ctx.workprec(bits):
        return OneDegree([Linear(acb(a), acb(b), acb(b) - acb(a)) for a, b in rows])


def numbers(rows, bits, places=NEAR):
    """Times and moments at the places, and x at times that are the places."""
    made = motion(rows, bits)
    with ctx.workprec(bits):
        found = [ball(x) for x in places]
        series = [f.at(x) for f in (made.time, made.moment) for x in found]
        return [*series, *(made.phase(t) for t in found), made.period]


def overlap(one, other):
    return all(x.is_finite() and x.overlaps(y) for x, y in zip(one, other, strict=True))


def test_against_mpmath():
    rows = ends(3)
    made = motion(rows, 140)
    with mpmath.workdps(40):

        def pace(x):
            y = (1 - mpmath.cos(x)) / 2
            square = mpmath.fprod(
                mpmath.mpmathify(a) + (mpmath.mpmathify(b) - a) * y for a, b in rows
            )
            return 1 / mpmath.sqrt(square.real)

        x = mpmath.mpf(22) / 7
        time = mpmath.quad(pace, [0, 1, 2, x])
        moment = mpmath.quad(lambda x: pace(x) * (1 - mpmath.cos(x)) / 2, [0, 1, 2, x])
        period = 2 * mpmath.quad(pace, [0, 1, 2, mpmath.pi])
        with ctx.workprec(140):
            x = ball(F(22, 7))
            for ours, right in (
                (made.time.at(x), time),
                (made.moment.at(x), moment),
                (made.period, period),
                (made.phase(arb(str(time)) + 3 * made.period), 6 * mpmath.pi + mpmath.mpf(22) / 7),
            ):
                assert abs(ours - arb(str(right))) < arb(10) ** -36
                assert ours.rad() > arb(10) ** -50


def test_the_rate_is_that_of_x():
    made = motion(ends(4), 100)
    with ctx.workprec(100):
        t, h = arb(5), arb(2) ** -30
        slope = (made.phase(t + h) - made.phase(t - h)) / (2 * h)
        assert abs(made.rate(made.phase(t)) / slope - 1) < arb(10) ** -16


@pytest.mark.parametrize("gap", [0, pytest.param(1e-4, marks=pytest.mark.slow)])
def test_balls_of_all_precisions_overlap(gap):
    """Whatever the radius: what is finite at few bits holds what more bits tell."""
    rows = ends(1, gap)
    for places, slack in ((NEAR, 32), (FAR, 84)):
        fine = numbers(rows, 360, places)
        for bits in (30, 40, 53, 107, 192, 330):
            rough = numbers(rows, bits, places)
            assert all(x.overlaps(y) for x, y in zip(rough, fine, strict=True))
            if bits > slack + 8:
                assert all(x.rad() < (1 + abs(x)) * arb(2) ** (slack - bits) for x in rough)


@pytest.mark.parametrize("factor", [1.5, 2, 4])
def test_a_strip_too_wide_is_missed(monkeypatch, factor):
    """By force, at 200 bits: fewer samples, and the bound that the proper strip has."""
    proper = one_degree.strip
    seeds = range(3)
    exact = [numbers(ends(seed, 0.3), 330) for seed in seeds]
    monkeypatch.setattr(one_degree, "strip", lambda factors: factor * proper(factors))
    monkeypatch.setattr(one_degree, "bound", lambda factors, eta: bound(factors, eta / factor))
    for seed, fine in zip(seeds, exact, strict=True):
        assert not overlap(numbers(ends(seed, 0.3), 200), fine)


def test_what_few_samples_miss_is_in_the_radius(monkeypatch):
    fine = numbers(ends(2), 330)
    monkeypatch.setattr(one_degree, "_SPARE", -100)
    rough = numbers(ends(2), 200)
    assert overlap(rough, fine)
    assert rough[1].rad() > arb(-60).exp()
    proper = one_degree.SineSeries
    monkeypatch.setattr(one_degree, "SineSeries", lambda *x: proper(*x[:2], x[2] / 2**64))
    assert not overlap(numbers(ends(2), 200), fine)


@pytest.mark.parametrize("place", [0, 10, 50])
def test_a_term_left_out_is_missed(monkeypatch, place):
    proper = one_degree.SineSeries
    fine = numbers(ends(2), 330)

    def shorter(mean, terms, error):
        return proper(mean, [*terms[:place], arb(0), *terms[place + 1 :]], error)

    monkeypatch.setattr(one_degree, "SineSeries", shorter)
    assert not overlap(numbers(ends(2), 200), fine)


def test_a_phase_that_iteration_misses_is_enclosed_nevertheless(monkeypatch):
    """Newton's iteration proves nothing: a bad end of it widens the ball."""
    made = motion(ends(5), 120)
    with ctx.workprec(120):
        right = made.phase(arb(17))
        proper = OneDegree._near
        monkeypatch.setattr(OneDegree, "_near", lambda self, t: proper(self, t) + arb(2) ** -20)
        wrong = made.phase(arb(17))
        assert wrong.contains(right)
        assert arb(2) ** -60 < wrong.rad() < arb(2) ** -30
        monkeypatch.setattr(made, "_fastest", made._fastest / 2**10)
        assert not made.phase(arb(17)).overlaps(right)


def test_what_is_not_known_asks_for_more_bits():
    with ctx.workprec(60), pytest.raises(TooFewBits):
        OneDegree([Linear(acb(arb(0, 1)), acb(1), acb(1))])


def test_too_near_a_double_zero_is_refused_at_once():
    with pytest.raises(Refused, match="too near a degenerate motion"):
        motion(ends(1, 1e-8), 100)
