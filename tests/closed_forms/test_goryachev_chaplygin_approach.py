"""chi where v tends to a double root: the double series against its equation and Taylor runs.

Errors lie in bands: what is compared has the digits asked for, and is not the same computation.
"""

import random
from fractions import Fraction

import pytest
from test_goryachev_chaplygin import named, off, on_cubics, place, top

from polhode.closed_forms.functions.fourier import TooManyTerms
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.goryachev_chaplygin import regimes
from polhode.closed_forms.goryachev_chaplygin import top as goryachev_chaplygin
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import InverseS
from polhode.closed_forms.goryachev_chaplygin.attitude import (
    asymptotic_series,
    momentum_azimuth,
    taylor_pieces,
)
from polhode.numbers.mpmath_context import mpf, mpmath
from shared.surface_checks import largest

F = Fraction
NAMES = ["from above", "from below"]
FAR = [F(10**4), F(-(10**4)), F(10**9), F(-(10**9))]


@pytest.fixture(autouse=True)
def only_the_momentum(monkeypatch):
    """Near t = 0 the attitude would come from other series."""
    monkeypatch.setattr(goryachev_chaplygin, "_REACH", 0)


@pytest.mark.parametrize("name", NAMES)
def test_powers_of_q_are_v_and_its_halves(name):
    with mpmath.workprec(200):
        path = top(*named(name))._motion(200).path
        v = path.torus.v
        for Y in (mpf(2), mpf(5)):
            powers = asymptotic_series._powers(v, mpmath.exp(-2 * Y), 100)
            sine, cosine = asymptotic_series._halves(v, powers, path.a)
            here = v.at(v.phase(4 * Y / v.gw), MP)
            root = mpmath.sqrt(here.z)
            wanted = here.z - v.w, root * here.sine, root * here.cosine
            for row, value in zip((powers[0], sine, cosine), wanted, strict=True):
                assert abs(sum(row) - value) < mpf("1e-57")  # some are equal


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", NAMES)
def test_the_series_has_the_rate_of_chi(name):
    """By the five-point rule in sigma, a step of 1e-12: about 1e-47."""
    with mpmath.workprec(224):
        path = top(*named(name))._motion(224).path
        u, v, inverse = path.torus.u, path.torus.v, InverseS(path.torus.u)
        series = asymptotic_series.approach(path.torus, v, path.a, inverse.at)
        step = mpf(10) ** -12
        for al, more in ((mpf("0.7"), mpf("0.01")), (mpf("-5.1"), mpf(1)), (mpf(40), mpf(30))):
            Y = series.edge + more

            def along(k, al=al, Y=Y):
                return series.at(al + k * step / u.S.mean, Y + k * step * v.gw / 4)

            slope = (along(-2) - 8 * along(-1) + 8 * along(1) - along(2)) / (12 * step)
            one, other = u.at(inverse.at(al), MP), v.at(v.phase(4 * Y / v.gw), MP)
            rate = momentum_azimuth._flow(path, one, other) / (2 * path.a)
            assert mpf("1e-60") < abs(slope - rate) < mpf("1e-44")


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_series_and_pieces_agree_where_both_hold(name, monkeypatch):
    """With another share of the radius the seam lies elsewhere: between the two, one is the other.

    Pieces are Taylor series of the six equations, and know nothing of the series' constants.
    """
    times = [F(k, 2) for k in range(-24, 25, 8)]
    plain = top(*named(name)).attitude(times, 30)
    edges = []
    made = asymptotic_series.approach
    monkeypatch.setattr(asymptotic_series, "_SHARE", 0.005)
    monkeypatch.setattr(
        momentum_azimuth, "approach", lambda *a: edges.append(made(*a)) or edges[-1]
    )
    moved = top(*named(name)).attitude(times, 30)
    assert edges
    for one, other in zip(plain, moved, strict=True):
        assert largest(one, other) < mpf("1e-32")


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_far_attitudes_at_two_precisions(name):
    one, other = (top(*named(name)).attitude(FAR, digits) for digits in (25, 40))
    for row, more in zip(one, other, strict=True):
        assert mpf("1e-33") < largest(row, more) < mpf("1e-25")


@pytest.mark.slow
def test_attitude_before_and_after_the_seam():
    assert LOW < off(named("from below"), (F(-18),), digits=25, attitudes=True) < HIGH


LOW, HIGH = mpf("1e-40"), mpf("1e-25")


def asymptotic(seed):
    """A start with D- = 0, H - 2a = 3w^2, G = w^3/2, at random."""
    pick = random.Random(seed)
    while True:
        w, a, u, v = (F(pick.randint(8, 100), 40) for _ in range(4))
        H, G = 3 * w * w + 2 * a, w**3 / 2
        cosines = (
            (u * u - 3 * w * w - 4 * G / u) / (4 * a),
            (v * v - 3 * w * w + 4 * G / v) / (4 * a),
        )
        if v != w and all(0 <= x <= 1 for x in cosines):
            return place(on_cubics(u, v, a, H, G, (pick.choice((1, -1)), pick.choice((1, -1)))))


def check_members(seeds):
    for seed in seeds:
        start, time = asymptotic(seed), F(random.Random(seed).choice((-9, -5, 4, 11)))
        assert top(*start).regime in regimes.ASYMPTOTIC
        error = off(start, (time,), 25, attitudes=True)
        assert LOW < error < HIGH, (seed, mpmath.nstr(error, 3))


@pytest.mark.slow
def test_random_members_agree_with_a_taylor_run():
    check_members(range(2))


@pytest.mark.slow
def test_more_random_members():
    check_members(range(2, 6))


@pytest.mark.campaign
def test_200_random_members():
    check_members(range(100, 300))


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["first", "rule", "pieces"])
def test_a_corrupted_formula_fails(fault, monkeypatch):
    if fault == "first":
        right = asymptotic_series._first
        monkeypatch.setattr(asymptotic_series, "_first", lambda v: right(v) * (1 + mpf(10) ** -20))
    elif fault == "rule":
        rule = asymptotic_series._quartic
        monkeypatch.setattr(
            asymptotic_series,
            "_quartic",
            lambda v: [*rule(v)[:-1], rule(v)[-1] * (1 + mpf(10) ** -15)],
        )
    else:
        rows = taylor_pieces._expanded
        monkeypatch.setattr(
            taylor_pieces, "_expanded", lambda s, a: rows(s, a * (1 + mpf(10) ** -20))
        )
    assert off(named("from below"), (F(-18),), digits=25, attitudes=True) > HIGH


@pytest.mark.slow
def test_where_the_series_is_too_long_the_bodys_own_takes_over(monkeypatch):
    def refused(*parts):
        raise TooManyTerms("too long")

    plain = top(*named("from below")).attitude([F(2)], 20)
    monkeypatch.setattr(momentum_azimuth, "approach", refused)
    assert largest(plain[0], top(*named("from below")).attitude([F(2)], 20)[0]) < mpf("1e-20")
