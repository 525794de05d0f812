"""Theta functions of genus two in balls: against FLINT's own, by their laws, and their tail."""

import pytest
from flint import acb, acb_mat, arb

from polhode.closed_forms.balls import theta2
from polhode.closed_forms.balls.core import TooFewBits
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


@pytest.mark.parametrize("bits", [40, 53, 107, 200])
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("tau", TAUS)
def test_all_functions_and_derivatives_hold_those_of_flint(tau, place, bits):
    assert misses(bits, TAUS[tau], PLACES[place]) == 0


@pytest.mark.parametrize("place", PLACES)
def test_balls_are_as_small_as_the_precision(place):
    with ctx.workprec(130):
        jets = Theta2(complexes(TAUS["plain"]), CHARACTERISTICS).at(complexes(PLACES[place]))
        size = max(abs(row[0]).mid() for row in jets.values)
        assert all(row[0].rad() < size * arb(2) ** -110 for row in jets.values)


def test_a_dropped_term_is_missed(monkeypatch):
    """By force: sums too short by three terms, with the bound as if they were not."""

    def short(size, a):
        return halves(size - 3, a)

    halves = theta2._halves
    monkeypatch.setattr(theta2, "_halves", short)
    assert misses(200, TAUS["plain"], PLACES["near 0"]) > 20


@pytest.mark.parametrize("share", [10, 100])
def test_the_bound_of_what_is_left_out_is_needed(monkeypatch, share):
    """With far too few terms balls are wide and right; with a part of the bound they miss."""
    bound = Theta2._left_out
    tau, z = ((0.0, 1.0), (0.0, 0.0), (0.0, 1.2)), ((0.0, 0.5), (0.0, 0.6))
    monkeypatch.setattr(theta2, "_SPARE", -120)
    assert misses(200, tau, z) == 0
    monkeypatch.setattr(Theta2, "_left_out", lambda self: tuple(x / share for x in bound(self)))
    assert misses(200, tau, z) > 10


def test_periods_are_taken_out_whole():
    with ctx.workprec(120):
        tau = complexes(TAUS["plain"])
        functions = Theta2(tau, CHARACTERISTICS)
        z = complexes(PLACES["near 0"])
        moved = functions.lattice.times((3, -2))
        far = z[0] + 5 + moved[0], z[1] - 4 + moved[1]
        jets = functions.at(far)
        factor = jets.log.exp()
        along = functions.lattice.times((3, -2))
        i_pi = acb(0, arb.pi())
        factor = (-i_pi * (3 * along[0] - 2 * along[1] + 2 * (3 * z[0] - 2 * z[1]))).exp()
        for c, row, far_row in zip(
            CHARACTERISTICS, functions.at(z).values, jets.values, strict=True
        ):
            side = -1 if (c[0] * 5 - c[1] * 4 + c[2] * 3 - c[3] * 2) % 2 else 1
            assert (factor * far_row[0]).overlaps(side * factor * row[0])
            slope = row[1] - 2 * i_pi * 3 * row[0]
            assert (factor * far_row[1]).overlaps(side * factor * slope)


def test_what_is_too_wide_asks_for_more_bits():
    with ctx.workprec(60):
        with pytest.raises(TooFewBits):
            Theta2((acb(0, arb(1, 2)), acb(0), acb(0, 1)), CHARACTERISTICS)
        functions = Theta2(complexes(TAUS["plain"]), CHARACTERISTICS)
        with pytest.raises(TooFewBits):
            functions.at((acb(0, arb(1, 1)), acb(0)))
