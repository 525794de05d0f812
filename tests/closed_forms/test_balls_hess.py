"""Hess's case in balls: its cones, its way to a limit, and its tail by force."""

import math
from fractions import Fraction

import mpmath
import pytest
from flint import arb, ctx
from mpmath import mpf

import polhode
from polhode.closed_forms import hess
from shared import members
from shared.closed_forms import gap, motion_of_family, number, scene_of
from shared.tools import exactly

F = Fraction
MOMENTS, TORQUE = (F(1), F(25, 34), F(1, 2)), (F(3, 5), F(0), F(4, 5))


def on_surface(momentum, up):
    """A start from Iw along e2 and e3, and gamma along e2, e3 and e1."""
    (M2, M3), (g2, g3, u) = momentum, up
    A, B, C = MOMENTS
    omega = -F(4, 5) * M2 / A, -M3 / B, F(3, 5) * M2 / C
    gamma = F(3, 5) * u - F(4, 5) * g2, -g3, F(4, 5) * u + F(3, 5) * g2
    return MOMENTS, TORQUE, omega, gamma


def reference_of(name):
    """Of the library, or of a row of the table of motions."""
    if "/" in name:
        return polhode.reference(name)
    start = members.read_start(members.motion_table()["hess"][name])
    return polhode.reference(scene_of(start, "hess"))


def test_a_cone_that_turns_returns_after_its_period_and_not_before():
    motion = reference_of("hess/cone")
    period = exactly(motion.period)
    begin, half, end = motion.at([F(0), period / 2, period], 30)
    assert gap(begin, end) < mpf("1e-28")
    assert gap(begin, half) > mpf("1e-2")


@pytest.mark.parametrize(("name", "axis"), [("cone, the other way", 1), ("hess/loxodrome", None)])
def test_what_is_left_of_the_way_falls_at_the_rate_told(name, axis):
    """Of w along the middle axis, or along r0, where it tends to 0."""
    motion = reference_of(name)
    times = [F(k) / exactly(motion.approach) for k in (40, 80, 400)]
    with mpmath.workdps(90):
        along = [0, 1, 0] if axis else [number(x) for x in motion.scene.body.torque]
        rows = motion.at(times, 80)
        first, second, end = (sum(x * y for x, y in zip(along, row, strict=False)) for row in rows)
        end = end if axis else 0
        fall = mpmath.log(abs((first - end) / (second - end)))
    assert abs(fall - 40) < 2


@pytest.mark.parametrize("seed", range(3))
def test_the_bound_of_the_angular_velocity_is_one_and_no_more(seed):
    """By rows over a hundred units of time, 0.7 apart."""
    motion = motion_of_family("hess", members.start("hess", seed)[0])
    with ctx.workprec(64):
        bound = float(motion.row_at(arb(1), attitude=False)[1][0].mid())
    rows = motion.at([F(7 * k, 10) for k in range(150)], 15)
    largest = max(math.hypot(*row[:3]) for row in rows)
    assert 0.95 * bound < largest <= bound * (1 + 1e-12)


def maps_at(starts, bits):
    """N of each motion."""
    with ctx.workprec(bits):
        return [motion_of_family("hess", plain)._motion().spin.map for plain in starts]


def test_fewer_terms_make_wider_balls_that_hold_the_value(monkeypatch):
    """A tail of 2^-100 at 200 bits, of which the true one is more than the rounding."""
    starts = [on_surface((F(1, 7), F(1, 5)), [F(x, 7) for x in (6, 3, 2)])]
    (right,) = maps_at(starts, 260)
    monkeypatch.setattr(hess, "_SPARE", -100)
    (rough,) = maps_at(starts, 200)
    assert rough.overlaps(right)
    assert not rough.mid().overlaps(right)
    assert arb("1e-33") < max(x.real.rad() for x in rough.entries()) < arb("1e-25")


def test_far_away_psi_and_phi_are_refused_and_the_attitude_is_not():
    top = polhode.reference("hess/loxodrome")
    assert len(top.angles([30], 15)) == 1
    with pytest.raises(polhode.BadInput, match="ask for the attitude"):
        top.angles([10**6], 15)
    assert len(top.attitude([10**6], 15)) == 1


@pytest.mark.parametrize("a12", ["0.3", "0.9", "6"])
def test_the_tail_is_that_of_its_majorant_and_little_more(a12):
    """(1 - x)^-a12, of which the first terms are taken away at 300 bits."""
    with ctx.workprec(300):
        a, x, term, rest = arb(a12), arb(1) / 6, arb(1), (1 - arb(1) / 6) ** -arb(a12)
        for k in range(40):
            rest -= term
            term *= x * (a + k) / (k + 1)
        bound = hess.tail(a, x, 40).real.rad()
        assert rest < bound < rest * arb("1.2")
