"""Theta functions in balls, of genus two and one: against FLINT's own, and their tail."""

import pytest
from flint import acb, acb_mat, arb

from polhode.closed_forms.balls import jacobi, theta2
from polhode.closed_forms.balls.core import TooFewBits
from polhode.closed_forms.balls.jacobi import ThetaSeries
from polhode.closed_forms.balls.theta2 import CHARACTERISTICS, Theta2
from polhode.numbers.flint_context import ctx

TAUS = {
    "plain": ((0.1, 1.1), (0.3, 0.4), (-0.2, 1.3)),
    "long": ((0.5, 0.87), (-0.25, 0.3), (0.4, 9.5)),
    "strongly coupled": ((0.0, 1.0), (0.5, 0.5), (0.0, 1.01)),
    "high": ((0.0, 20.0), (0.0, 0.0), (0.0, 20.0)),
}
PLACES = {
    "near 0": ((0.3, 0.2), (-0.1, 0.4)),
    "far": ((31.25, -7.75), (-12.5, 22.0)),
    "98i": ((0.0, 98.0), (0.0, 0.0)),
}


def complexes(pairs):
    return tuple(acb(x, y) for x, y in pairs)


def flint_jets(tau, z):
    a, b, c = tau
    jets = acb_mat([[a, b], [b, c]]).theta_jets(acb_mat([[x] for x in z]), 1)
    return [[jets[8 * a1 + 4 * a2 + 2 * b1 + b2, i] for i in range(3)]
            for a1, a2, b1, b2 in CHARACTERISTICS]  # fmt: skip


def misses(bits, tau, z):
    """How many of the 48 numbers do not overlap FLINT's, at 60 bits more."""
    with ctx.workprec(bits):
        jets = Theta2(complexes(tau), CHARACTERISTICS).at(complexes(z))
        factor = jets.log.exp()
        ours = [[factor * x for x in row] for row in jets.values]
    with ctx.workprec(bits + 60):
        right = flint_jets(complexes(tau), complexes(z))
    rows = zip(ours, right, strict=True)
    assert all(x.is_finite() for row in ours for x in row)
    return sum(not x.overlaps(y) for row, right in rows for x, y in zip(row, right, strict=True))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("tau", TAUS)
def test_all_functions_and_derivatives_hold_those_of_flint(tau, place):
    """And balls are as small as the precision."""
    for bits in (40, 53, 107, 200):
        assert misses(bits, TAUS[tau], PLACES[place]) == 0
    if tau == "plain":
        with ctx.workprec(130):
            jets = Theta2(complexes(TAUS[tau]), CHARACTERISTICS).at(complexes(PLACES[place]))
            size = max(abs(row[0]).mid() for row in jets.values)
            assert all(row[0].rad() < size * arb(2) ** -110 for row in jets.values)


def test_the_bound_of_what_is_left_out_is_needed_and_so_is_every_term(monkeypatch):
    """With far too few terms balls are wide and right; with a part of the bound they miss.

    So do sums that are short by three terms, with the bound as if they were not.
    """
    bound, halves = Theta2._left_out, theta2._halves
    tau, z = ((0.0, 1.0), (0.0, 0.0), (0.0, 1.2)), ((0.0, 0.5), (0.0, 0.6))
    monkeypatch.setattr(theta2, "_SPARE", -120)
    assert misses(200, tau, z) == 0
    monkeypatch.setattr(Theta2, "_left_out", lambda self: tuple(x / 10 for x in bound(self)))
    assert misses(200, tau, z) > 10
    monkeypatch.undo()
    monkeypatch.setattr(theta2, "_halves", lambda size, a: halves(size - 3, a))
    assert misses(200, TAUS["plain"], PLACES["near 0"]) > 20


def test_what_is_too_wide_or_does_not_fall_asks_for_more_bits(monkeypatch):
    with ctx.workprec(60):
        with pytest.raises(TooFewBits):
            Theta2((acb(0, arb(1, 2)), acb(0), acb(0, 1)), CHARACTERISTICS)
        functions = Theta2(complexes(TAUS["plain"]), CHARACTERISTICS)
        with pytest.raises(TooFewBits):
            functions.at((acb(0, arb(1, 1)), acb(0)))
        with pytest.raises(TooFewBits):
            ThetaSeries(arb(1)).above(arb("nan"), third=True)
        monkeypatch.setattr(jacobi.math, "ceil", lambda x: 1)
        with pytest.raises(TooFewBits):
            ThetaSeries(arb("0.01"))


# -- of genus one, as polynomials at any precision, and no wider than they must be ----------------

ARGUMENTS = ("0.49", "0.1", "-0.3", "0")
WIDTHS = ("0.07", "0.3", "1.1", "7", "60")


def values(series, z, y):
    """th1, ..., th4 at z, and th3, th4 at z + i y."""
    sine, cosine = z.sin_cos_pi()
    double = (2 * z).cos_pi()
    real = [
        sine * series.th1(double),
        cosine * series.th2(double),
        series.th3(double),
        series.th4(double),
    ]
    for third in (True, False):
        level, upright = series.above(y, third=third)
        real += [level(double), upright(double) * (2 * z).sin_pi()]
    return real


def flints(s, z, y):
    here = [x.real for x in acb.modular_theta(acb(z), acb(0, s))]
    above = acb.modular_theta(acb(z, y), acb(0, s))[2:]
    return here + [part for x in above for part in (x.real, x.imag)]


@pytest.mark.parametrize("width", WIDTHS)
def test_every_ball_holds_the_value(width):
    for place in ARGUMENTS:
        for share in ("0.5", "0.2", "-0.4"):
            with ctx.workprec(900):
                s, z = arb(width), arb(place)
                right = flints(s, z, arb(share) * s)
            for bits in (24, 53, 113, 330):
                with ctx.workprec(bits):
                    mine = values(ThetaSeries(s), z, arb(share) * s)
                    assert all(x.overlaps(y) for x, y in zip(mine, right, strict=True))


@pytest.mark.parametrize("width", WIDTHS[:3])
def test_what_is_left_out_is_in_the_ball_and_not_much_more(width, monkeypatch):
    """With few terms each ball holds its value, and with no bound of the rest hardly any would."""
    monkeypatch.setattr(jacobi.math, "ceil", lambda x: 3 if width == "0.07" else 1)
    with ctx.workprec(300):
        s, y = arb(width), arb(width) / 3
        series, missed = ThetaSeries(s), 0
        for place in ARGUMENTS[:3]:
            z = arb(place)
            for mine, right in zip(values(series, z, y), flints(s, z, y), strict=True):
                assert mine.overlaps(right)
                missed += not mine.mid().overlaps(right)
        assert missed > 20
