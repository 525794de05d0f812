"""Phases between two roots, and integrals over inverse roots, in balls: against mpmath, at many
precisions, and by force."""

from __future__ import annotations

import cmath
import math
import random
from fractions import Fraction

import mpmath
import pytest
from flint import acb, arb

from polhode.closed_forms.balls import clocks
from polhode.closed_forms.balls.clocks import Factors, Linear, Oscillating, circle, unit
from polhode.closed_forms.balls.core import TooFewBits, ball
from polhode.numbers.flint_context import ctx
from shared.tools import tiers

F = Fraction
RULES = {"circle": circle, "unit": unit}
#: Of x and of time.
PLACES = {
    "clock": [F(0), F(1, 3), F(-29, 10), F(355, 113), F(17)],
    "far clock": [F(-(10**6)), F(10**16)],
}


def drawn_roots(seed, gap=0.0):
    """A root below 0, two above 1, a pair of complex ones; ``gap``: of the first."""
    source = random.Random(seed)

    def value():
        return source.uniform(0.2, 3)

    return -(gap or value()), 1 + value(), 1 + value(), (value() - 1, value())


def clock_of(seed, bits, gap=0.0):
    low, high, higher, pair = drawn_roots(seed, gap)
    with ctx.workprec(bits):
        real = (1, arb(low)), (-1, arb(high)), (-1, arb(higher))
        factors = Factors(real, [(arb(pair[0]), arb(pair[1]))], arb("0.7"))
        return Oscillating(arb(0), arb(1), factors)


def ends_of(seed, gap, real):
    """Values of three linear functions at both ends; of the first, a small one or 1."""
    source = random.Random(seed)

    def value():
        return complex(source.uniform(0.2, 3), 0 if real else source.uniform(-1, 1))

    return [(complex(gap) if k == 0 and gap else value(), value()) for k in range(3)]


def integral(name, ends, bits):
    with ctx.workprec(bits):
        return RULES[name]([Linear(acb(a), acb(b), acb(b) - acb(a)) for a, b in ends])


def balls(kind, seed, bits, gap=0.0, real=True):
    """Both integrals of a rule; of a clock times and moments at the places, and x at such times."""
    if kind in RULES:
        return integral(kind, ends_of(seed, gap, real), bits)
    clock = clock_of(seed, bits, gap)
    with ctx.workprec(bits):
        places = [ball(x) for x in PLACES[kind]]
        series = [y for x in places for y in clock.at(x)[:2]]
        return [*series, *(clock.phase(t) for t in places), clock.S[-1]]


def overlap(first, second):
    return all(x.is_finite() and x.overlaps(y) for x, y in zip(first, second, strict=True))


def by_mpmath(name, ends):
    """Both integrals at mpmath's precision in force."""

    def product(y):
        value = mpmath.mpf(1)
        for a, b in ends:
            value /= mpmath.sqrt(mpmath.mpc(a) + (mpmath.mpc(b) - mpmath.mpc(a)) * y)
        return value

    if name == "circle":
        interval, place, weight = [0, mpmath.pi], lambda x: (1 - mpmath.cos(x)) / 2, mpmath.cos
    else:
        interval, place, weight = [0, 1], lambda x: x * x, lambda x: x * x
    return [
        mpmath.quad(lambda x: product(place(x)), interval),
        mpmath.quad(lambda x: weight(x) * product(place(x)), interval),
    ]


#: A factor that stays below the negative axis: the root on the way is one branch, though a disc
#: reaches over the cut.
BELOW = [(complex(-1, -0.3), complex(2, -0.3)), (complex(2, 0), complex(1, 0))]


@pytest.mark.parametrize(
    ("ends", "digits"),
    [(ends_of(3, 0, True), 33), (BELOW, 25)],
    ids=["real", "below the cut"],
)
@pytest.mark.parametrize("name", RULES)
def test_integrals_against_mpmath(name, ends, digits):
    ours = integral(name, ends, 130)
    assert overlap(integral(name, ends, 100), ours)
    with mpmath.workdps(digits + 5), ctx.workprec(130):
        for x, y in zip(ours, by_mpmath(name, ends), strict=True):
            assert abs(x - acb(str(y.real), str(y.imag))) < arb(10) ** -digits


def test_times_and_moments_against_mpmath():
    low, high, higher, (middle, height) = drawn_roots(3)
    clock = clock_of(3, 140)
    with mpmath.workdps(40), ctx.workprec(140):

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
        place = clock.at(ball(F(22, 7)))
        for ours, right in (
            (place.S, time),
            (place.U, moment),
            (clock.S[-1], half),
            (clock.phase(arb(str(time)) + 6 * clock.S[-1]), 6 * mpmath.pi + x),
        ):
            assert abs(ours - arb(str(right))) < arb(10) ** -36
            assert ours.rad() > arb(10) ** -50


#: Bits that a number has beyond those of its radius, at most; and from how many on.
SPARE = {"circle": (40, 0), "unit": (40, 0), "clock": (110, 120), "far clock": (160, 170)}


@pytest.mark.parametrize(
    ("kind", "gap", "real"),
    tiers(
        [
            *((kind, gap, True) for kind in RULES for gap in (0, 1e-8)),
            *((kind, 1e-3, False) for kind in RULES),
            *((kind, gap, True) for kind in PLACES for gap in (0, 1e-4)),
        ],
        [
            *(("circle", 1e-26, True), ("unit", 1e-8, False)),
            *((kind, 1e-20, True) for kind in PLACES),
        ],
    ),
)
def test_balls_of_all_precisions_overlap(kind, gap, real):
    """Whatever the radius: what is finite at few bits holds what more bits tell."""
    fine, count = balls(kind, 1, 400, gap, real), 0
    (slack, least), is_clock = SPARE[kind], kind in PLACES
    for bits in (24, 30, 40, 53, 107, 192, 200, 330):
        try:
            rough = balls(kind, 1, bits, gap, real)
        except TooFewBits:
            assert is_clock or gap < 1e-20
            continue
        assert all(x.overlaps(y) for x, y in zip(rough, fine, strict=True))
        if bits > least:
            for x in rough:
                assert acb(x).real.rad() < (is_clock + abs(x)) * arb(2) ** (slack - bits)
            count += 1
    assert count >= 2


@pytest.mark.parametrize(
    ("kind", "ratio", "seeds", "least"),
    [
        *((kind, 8, 12, 3) for kind in RULES),
        *((kind, 16, 12, 8) for kind in RULES),
        *(("clock", ratio, 3, 3) for ratio in (12, 16)),
    ],
)
def test_a_rule_for_a_larger_ellipse_than_f_is_bounded_on_misses(
    monkeypatch, kind, ratio, seeds, least
):
    """By force, at 200 bits: points and error of Gauss's rule as if discs were larger."""
    gap = 0.05 if kind in RULES else 0.0
    exact = [balls(kind, seed, 330, gap) for seed in range(seeds)]
    monkeypatch.setattr(clocks, "RATIO", ratio)
    rough = [balls(kind, seed, 200, gap) for seed in range(seeds)]
    assert sum(not overlap(x, y) for x, y in zip(rough, exact, strict=True)) >= least


@pytest.mark.parametrize(
    ("kind", "spare", "least", "most"),
    [("clock", -100, 8e-40, 1.0), ("unit", -60, 1e-40, 1e-20)],
)
def test_what_few_points_leave_out_is_in_the_radius(monkeypatch, kind, spare, least, most):
    seed, gap = (2, 0.0) if kind == "clock" else (5, 1e-8)
    fine = balls(kind, seed, 330, gap)
    monkeypatch.setattr(clocks, "_SPARE", spare)
    rough = balls(kind, seed, 200, gap)
    assert overlap(rough, fine)
    assert least < acb(rough[2 * (kind == "clock")]).real.rad() < most
    if kind == "unit":
        proper = clocks._Squares._within
        narrow = staticmethod(lambda radius: proper(radius / 2**60))
        monkeypatch.setattr(clocks._Squares, "_within", narrow)
        assert not overlap(balls(kind, seed, 200, gap), fine)


def test_a_phase_that_iteration_misses_is_enclosed_nevertheless(monkeypatch):
    """Newton's iteration proves nothing: a bad end of it widens the ball."""
    clock = clock_of(5, 120)
    with ctx.workprec(120):
        right = clock.phase(arb(17))
        monkeypatch.setattr(clocks, "_ROUGH", 1e-2)
        monkeypatch.setattr(clocks, "_CLOSE", 40)  # steps below 1/8 are the last
        wrong = clock.phase(arb(17))
        assert wrong.contains(right)
        assert 2**30 * right.rad() < wrong.rad() < arb(2) ** -60
        monkeypatch.setattr(clock, "_fastest", clock._fastest / 2**10)
        assert not clock.phase(arb(17)).overlaps(right)


UNKNOWN = {
    "circle": lambda: circle([Linear(acb(arb(0, 1)), acb(1), acb(1))]),
    "unit": lambda: unit([Linear(acb(arb(0, 1)), acb(1), acb(1))]),
    "clock": lambda: Oscillating(arb(0), arb(1), Factors(((1, arb(0, 1)),))),
}


def test_what_is_not_known_asks_for_more_bits(monkeypatch):
    """Of a disc that holds a zero, too: what middles of balls have chosen is proven."""
    for question in UNKNOWN.values():
        with ctx.workprec(60), pytest.raises(TooFewBits):
            question()
    monkeypatch.setattr(clocks.Panels, "_clear", lambda *_: True)
    for name in RULES:
        with pytest.raises(TooFewBits):
            balls(name, 1, 200, 1e-8)


@pytest.mark.parametrize(
    ("kind", "function"),
    [
        (clocks.Oscillating, lambda x: cmath.sin(x / 2) ** 2),
        (clocks.Tending, lambda x: 1 / cmath.cosh(x) ** 2),
    ],
)
def test_a_variable_stays_within_its_reach_and_nearly_reaches_it(kind, function):
    pick, shares = random.Random(1), []
    variable = kind.__new__(kind)
    variable.width = arb(1)
    for _ in range(2000):
        x, radius = 3 * pick.random(), 1.4 * pick.random()
        moved = function(x + cmath.rect(radius, 2 * math.pi * pick.random())) - function(x)
        shares.append(abs(moved) / float(variable.reach(arb(x), arb(radius))))
    assert 0.95 < max(shares) < 1


def test_far_from_0_the_integrals_hold_what_f_is_all_over_the_ball_of_a_turn():
    """Panels of 120 bits asked in 53: a turn is then known no better than f is narrow."""

    def variable(bits):
        near = clocks.Factors(((1, -(arb(10) ** -12)), (-1, arb(2))))
        with ctx.workprec(bits):
            return clocks.Oscillating(arb(0), arb(1), near)

    pick, few, many, finite, wrong = random.Random(1), variable(120), variable(300), 0, 0
    for _ in range(80):
        turns, off = pick.randrange(10**9, 10**11), 10.0 ** -pick.uniform(3, 9)
        with ctx.workprec(53):
            x = (2 * turns * arb.pi() + off).mid()
            place = few.at(x)
        with ctx.workprec(300):
            right = many.at(x)
        for x, y in zip(place[:2], right[:2], strict=True):
            finite += bool(x.is_finite())
            wrong += x.is_finite() and not x.overlaps(y)
    assert finite > 10
    assert wrong == 0
