"""Integrals over inverse roots in balls: against mpmath, at many precisions, and by force."""

import random

import mpmath
import pytest
from flint import acb, arb

from polhode.closed_forms.balls import quadrature
from polhode.closed_forms.balls.core import TooFewBits
from polhode.closed_forms.balls.quadrature import Linear, circle, unit
from polhode.numbers.flint_context import ctx

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


def overlap(one, other):
    return all(x.is_finite() and x.overlaps(y) for x, y in zip(one, other, strict=True))


@pytest.mark.parametrize("real", [True, False])
@pytest.mark.parametrize("name", RULES)
def test_against_mpmath(name, real):
    ends = factors(3, 0, real)
    ours = integral(RULES[name], ends, 130)
    with mpmath.workdps(40):

        def product(y):
            value = mpmath.mpf(1)
            for a, b in ends:
                value /= mpmath.sqrt(mpmath.mpc(a) + (mpmath.mpc(b) - mpmath.mpc(a)) * y)
            return value

        if name == "circle":
            way, place, weight = [0, mpmath.pi], lambda x: (1 - mpmath.cos(x)) / 2, mpmath.cos
        else:
            way, place, weight = [0, 1], lambda x: x * x, lambda x: x * x
        right = [
            mpmath.quad(lambda x: product(place(x)), way),
            mpmath.quad(lambda x: weight(x) * product(place(x)), way),
        ]
        with ctx.workprec(130):
            for x, y in zip(ours, right, strict=True):
                size = abs(x - acb(str(y.real), str(y.imag)))
                assert size < arb(10) ** -33


@pytest.mark.parametrize("gap", [0, 1e-3, 1e-8, 1e-26])
@pytest.mark.parametrize("real", [True, False])
@pytest.mark.parametrize("name", RULES)
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


@pytest.mark.parametrize("factor", [1.5, 2, 4])
@pytest.mark.parametrize("name", RULES)
def test_a_strip_too_wide_is_missed(monkeypatch, name, factor):
    """By force, at 200 bits: fewer points, and a bound for a strip that holds a zero."""
    proper = quadrature.strip

    def room(self, eta):
        return abs(self.slope) * quadrature.square(abs((self.rho - eta) / 2).sinh())

    missed = 0
    seeds = range(12)
    exact = [integral(RULES[name], factors(seed, 0.05, True), 330) for seed in seeds]
    monkeypatch.setattr(quadrature, "strip", lambda factors: factor * proper(factors))
    monkeypatch.setattr(Linear, "least", room)
    for seed, fine in zip(seeds, exact, strict=True):
        missed += not overlap(integral(RULES[name], factors(seed, 0.05, True), 200), fine)
    assert missed >= (3 if factor == 1.5 else 8)


def test_the_sign_of_the_room_is_proven():
    """A zero within the strip is not hidden by a square."""
    with ctx.workprec(100):
        near = Linear(acb(0.01), acb(1), acb(0.99))
        assert near.rho < 0.3
        with pytest.raises(TooFewBits):
            near.least(arb(0.3))
        assert near.least(arb(0.1)) > 0


def test_panels_too_long_raise(monkeypatch):
    """Panels by false doubles: rho below eta is told, not squared away."""
    monkeypatch.setattr(quadrature, "_ways", lambda zeros: [(0.0, 0.5), (0.5, 1.0)])
    with pytest.raises(TooFewBits):
        integral(unit, factors(1, 1e-8, True), 200)


def test_an_error_of_panels_left_out_is_missed(monkeypatch):
    """By force: longer panels with the bound of the shorter ones."""
    ends = factors(5, 1e-8, True)
    fine = integral(unit, ends, 330)
    proper, proper_least = quadrature._ways, quadrature._least_on_panel

    def longer(zeros):
        ways = proper(zeros)
        return [(ways[i][0], ways[min(i + 1, len(ways) - 1)][1]) for i in range(0, len(ways), 2)]

    def least(factor, root, middle, half, eta):
        if root is None:
            return proper_least(factor, root, middle, half, eta)
        size = abs(factor.slope)
        for zero in (root, -root):
            room = abs(quadrature.ellipse((zero - middle) / half) - eta)
            size *= 2 * half * quadrature.square((room / 2).sinh())
        return size

    monkeypatch.setattr(quadrature, "_ways", longer)
    monkeypatch.setattr(quadrature, "_least_on_panel", least)
    assert not overlap(integral(unit, ends, 200), fine)


def test_what_is_not_known_asks_for_more_bits():
    with ctx.workprec(60):
        wide = Linear(acb(arb(0, 1)), acb(1), acb(1))
        for rule in (circle, unit):
            with pytest.raises(TooFewBits):
                rule([wide])
