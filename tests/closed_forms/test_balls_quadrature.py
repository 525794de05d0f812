"""Integrals over inverse roots in balls: against mpmath, at many precisions, and by force."""

import random

import mpmath
import pytest
from flint import acb, arb

from polhode.closed_forms.balls import clocks
from polhode.closed_forms.balls.clocks import Linear, circle, unit
from polhode.closed_forms.balls.core import TooFewBits
from polhode.numbers.flint_context import ctx
from shared.tools import tiers

BITS = [24, 40, 53, 107, 200]
RULES = {"circle": circle, "unit": unit}


def factors(seed, gap, real):
    """Values of three linear functions at both ends; of the first, a small one or 1."""
    source = random.Random(seed)

    def value():
        return complex(source.uniform(0.2, 3), 0 if real else source.uniform(-1, 1))

    return [(complex(gap) if k == 0 and gap else value(), value()) for k in range(3)]


def integral(rule, ends, bits):
    with ctx.workprec(bits):
        return rule([Linear(acb(a), acb(b), acb(b) - acb(a)) for a, b in ends])


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


@pytest.mark.parametrize(
    ("real", "name"),
    tiers([(True, "circle"), (True, "unit")], [(False, "circle"), (False, "unit")]),
)
def test_against_mpmath(name, real):
    ends = factors(3, 0, real)
    ours = integral(RULES[name], ends, 130)
    with mpmath.workdps(40), ctx.workprec(130):
        for x, y in zip(ours, by_mpmath(name, ends), strict=True):
            size = abs(x - acb(str(y.real), str(y.imag)))
            assert size < arb(10) ** -33


@pytest.mark.parametrize(
    ("gap", "real", "name"),
    tiers(
        [
            *((0, True, "circle"), (1e-08, True, "circle"), (0.001, False, "circle")),
            *((0, True, "unit"), (1e-08, True, "unit"), (0.001, False, "unit")),
        ],
        [
            *((0.001, True, "circle"), (1e-26, True, "circle"), (0, False, "circle")),
            *((1e-08, False, "circle"), (1e-26, False, "circle"), (0.001, True, "unit")),
            *((1e-26, True, "unit"), (0, False, "unit"), (1e-08, False, "unit")),
            (1e-26, False, "unit"),
        ],
    ),
)
def test_balls_of_all_precisions_overlap(name, real, gap):
    """Whatever the radius: what is finite at few bits holds what more bits tell."""
    ends = factors(1, gap, real)
    fine = integral(RULES[name], ends, 260)
    for bits in BITS:
        try:
            rough = integral(RULES[name], ends, bits)
        except TooFewBits:
            assert gap < 1e-20
            continue
        assert overlap(rough, fine)
        with ctx.workprec(bits):
            assert all(x.real.rad() < abs(x) * arb(2) ** (40 - bits) for x in rough)


@pytest.mark.parametrize("ratio", [8, 16])
@pytest.mark.parametrize("name", RULES)
def test_a_rule_for_a_larger_ellipse_than_f_is_bounded_on_misses(monkeypatch, name, ratio):
    """By force, at 200 bits: points and error of Gauss's rule as if discs were larger."""
    seeds, missed = range(12), 0
    exact = [integral(RULES[name], factors(seed, 0.05, True), 330) for seed in seeds]
    monkeypatch.setattr(clocks, "RATIO", ratio)
    for seed, fine in zip(seeds, exact, strict=True):
        missed += not overlap(integral(RULES[name], factors(seed, 0.05, True), 200), fine)
    assert missed >= (3 if ratio == 8 else 8)


def test_what_few_points_leave_out_is_in_the_radius(monkeypatch):
    ends = factors(5, 1e-8, True)
    fine = integral(unit, ends, 330)
    monkeypatch.setattr(clocks, "_SPARE", -60)
    rough = integral(unit, ends, 200)
    assert overlap(rough, fine)
    assert arb("1e-40") < rough[0].real.rad() < arb("1e-20")
    proper = clocks._Squares._within
    monkeypatch.setattr(
        clocks._Squares, "_within", staticmethod(lambda radius: proper(radius / 2**60))
    )
    assert not overlap(integral(unit, ends, 200), fine)


@pytest.mark.parametrize("name", RULES)
def test_panels_too_long_raise(monkeypatch, name):
    """What middles of balls have chosen is proven: a disc that holds a zero is told."""
    monkeypatch.setattr(clocks.Panels, "_clear", lambda *_: True)
    with pytest.raises(TooFewBits):
        integral(RULES[name], factors(1, 1e-8, True), 200)


@pytest.mark.parametrize("name", RULES)
def test_a_disc_may_reach_over_the_cut_of_a_root(name):
    """A factor that stays below the negative axis: the root on the way is one branch."""
    ends = [(complex(-1, -0.3), complex(2, -0.3)), (complex(2, 0), complex(1, 0))]
    fine = integral(RULES[name], ends, 300)
    assert overlap(integral(RULES[name], ends, 100), fine)
    with mpmath.workdps(30), ctx.workprec(130):
        assert abs(fine[0].real - arb(str(by_mpmath(name, ends)[0].real))) < arb(10) ** -25


def test_what_is_not_known_asks_for_more_bits():
    with ctx.workprec(60):
        wide = Linear(acb(arb(0, 1)), acb(1), acb(1))
        for rule in (circle, unit):
            with pytest.raises(TooFewBits):
                rule([wide])
