"""The families with one orbit a body, in balls: exceptional members, and by force."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import mpmath
import pytest
from flint import acb, arb

import polhode
from polhode.closed_forms._one_orbit import orbits
from polhode.closed_forms._one_orbit.orbits import zeros
from polhode.closed_forms.balls import periodic_attitude
from polhode.closed_forms.balls.core import Refused, TooFewBits, ball
from polhode.closed_forms.balls.periodic_attitude import BallEquations, PeriodicAttitude
from polhode.closed_forms.families import mpmath as own_mpmath
from polhode.closed_forms.families import orbit_family
from polhode.numbers import exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf
from shared import steady_precession
from shared.closed_forms import form, gap, motion_of_family, number, row_at, scene_of
from shared.members import start
from shared.orbit_members import steklov_start
from shared.tools import exact_number

F = Fraction


def of(family, seed=1):
    return motion_of_family(family, start(family, seed)[0])


def test_next_to_where_the_modulus_is_1():
    """Steklov's A next to 2B and 2C next to A: b0 and c0 large, and the period long."""
    for off in (F(1, 10**6), F(1, 10**12)):
        plain = steklov_start(F(2) - off, F(1), F(1) - off, F(13, 10), F(1, 3))
        motion = motion_of_family("steklov", plain)
        (few,), (many,) = motion.at([F(7)], 20), motion.at([F(7)], 50)
        assert gap(few, many) < max(abs(x) for x in many[:3]) * 1e-20


@pytest.mark.slow
def test_by_force_a_strip_too_wide_misses(monkeypatch):
    """At 200 bits: fewer samples, and the bound of the proper strip."""
    fine = row_at(of("steklov"), F(-7), 330)
    proper = PeriodicAttitude._proven_sums

    def fewer(self):
        self.strip = self.strip._replace(eta=6 * self.strip.eta)
        return proper(self)

    monkeypatch.setattr(PeriodicAttitude, "_proven_sums", fewer)
    wrong = row_at(of("steklov"), F(-7), 200)
    assert all(x.overlaps(y) for x, y in zip(wrong[:6], fine, strict=False))
    assert not all(x.overlaps(y) for x, y in zip(wrong, fine, strict=True))


def test_how_far_a_state_moves_is_bounded_and_not_by_much():
    """Beside the motion itself at a complex time; half of the bound is passed."""
    motion = of("goryachev", 2)
    with ctx.workprec(100):
        orbit = motion._motion().orbit
        equations = motion._motion().equations()
        now, reach = acb(arb("0.3"), arb("0.1")), arb("1e-4")
        moves = equations.moves(orbit.state(now), reach)
        halved = 0
        for direction in (1, acb(0, 1), -1):
            there = orbit.state(now + direction * reach)
            for x, y, most in zip(there, orbit.state(now), moves, strict=True):
                assert abs(x - y) <= most
                halved += abs(x - y) > most / 2
        assert halved > 10
        assert equations.moves(orbit.state(now), arb(100)) is None
    with ctx.workprec(64):  # w' = 0 where w is along an axis, and the vertical turns
        still = [acb(x) for x in (1, 0, 0, 0, 0, 1)]
        moves = BallEquations([arb(3), arb(2), arb(1)], [arb(0)] * 3).moves(still, arb("0.01"))
        assert [bool(x == 0) for x in moves] == [True] * 4 + [False] * 2
        assert 0.0099 < moves[4] < 0.0103


def test_zeros_of_a_polynomial_are_real_or_not():
    with ctx.workprec(120):
        roots = zeros([exact.exact(x) for x in (-6, 11, -6, 1)])
        assert sorted(round(float(z.real)) for z in roots) == [1, 2, 3]
        assert all(z.imag.is_zero() and z.real.rad() < arb(2) ** -118 for z in roots)
        pair = zeros([exact.exact(x) for x in (2, 0, 3, 0, 1)])  # (z^2 + 1)(z^2 + 2)
        assert not any(z.imag.contains(0) for z in pair)
    near = [F(-1, 10**40), F(0), F(1)]
    with ctx.workprec(64):  # +-1e-20, which 192 bits tell apart
        assert sorted(float(z.real) for z in zeros(near)) == pytest.approx([-1e-20, 1e-20])
    with ctx.workprec(64), pytest.raises(TooFewBits):
        zeros([F(1), F(2), F(1)])  # double
    wide, beside = (acb(arb(x, 1e-10), arb(0, 1e-10)) for x in (0, 1e-10))
    with pytest.raises(TooFewBits):
        orbits._real_or_not(wide, [wide, beside])


def test_roots_of_a_factor_are_smooth_up_to_its_zero():
    """On an ellipse about the way that ends before 0.8 + 0.3i: the principal root would jump."""
    with ctx.workprec(60):
        pair = [acb("0.8", "0.3"), acb("0.8", "-0.3")]
        factor = orbits._Factor(pair, arb(2), arb(0), arb(1))
        places = [acb(0.5, h / 100) for h in range(33)]
        roots = [factor.root(y) for y in places]
        for y, root in zip(places, roots, strict=True):
            assert abs(root * root - 2 * (y - pair[0]) * (y - pair[1])) < 1e-14
        assert max(abs(b - a) for a, b in pairwise(roots)) < 0.05


def test_a_strip_that_is_not_proven_is_refused(monkeypatch):
    monkeypatch.setattr(periodic_attitude, "_LEAST_ETA", 0.2)
    with pytest.raises(Refused, match=r"Steklov.*not bounded next to real times"):
        of("steklov").attitude([F(1)], 20)


class Wrong(steady_precession.SteadyPrecession):
    """Of another start."""

    def _orbit(self, bits):
        return replace(super()._orbit(bits), n=mpf(3))


class Endless(steady_precession.SteadyPrecession):
    """Without period."""

    def _orbit(self, bits):
        proper = super()._orbit(bits)

        class Orbit:
            period = None
            at = staticmethod(proper.at)

        return Orbit()


class Rough(steady_precession.SteadyPrecession):
    """Its rate is right to half of the bits only."""

    def _orbit(self, bits):
        proper = super()._orbit(bits)
        return replace(proper, s=proper.s * (1 + own_mpmath.ldexp(1, -bits // 2)))


STEADY = (
    (F(1), F(1), F(2)),
    (F(0), F(0), F(4)),
    (F(6, 5), F(0), F(9, 5)),
    (F(3, 5), F(0), F(4, 5)),
)


@pytest.mark.slow
def test_an_orbit_of_ones_own_is_reproduced_not_proven():
    top = form(steady_precession.FAMILY, *STEADY)
    assert (top.place.proven, top.radii([F(1)], 20)) == (False, None)
    for far in (F(10**12) + F(1, 7), F(10**40, 7)):
        (few,), (many,) = top.at([far], 20), top.at([far], 60)
        assert max(abs(x - y) for x, y in zip(few, many, strict=True)) < mpf("2e-20")
    assert top.error(20, [F(1)]) < mpf("1e-20")
    (turn,), (finer,) = top.attitude([F(10**6)], 20), top.attitude([F(10**6)], 40)
    assert max(abs(x - y) for x, y in zip(turn, finer, strict=True)) < mpf("2e-20")
    rough = form(orbit_family("rough", Rough), *STEADY)
    (rough_row,) = rough.at([F(10**40, 7)], 30)
    assert max(abs(x - y) for x, y in zip(rough_row, many, strict=True)) < mpf("2e-30")


def test_what_an_orbit_of_ones_own_may_lack():
    with pytest.raises(ArithmeticError, match="does not reproduce the start"):
        form(orbit_family("wrong", Wrong), *STEADY).at([F(1)], 20)
    endless = form(orbit_family("endless", Endless), *STEADY)
    assert endless.period(20) is None
    assert len(endless.at([F(1)], 20)[0]) == 6
    with pytest.raises(Refused, match="the attitude none"):
        endless.attitude([F(1)], 20)


def test_irrational_bodies_tell_what_is_called_0(monkeypatch):
    """A = 2C by sqrt 2 sqrt 3 = sqrt 6; what is asked of other axes is not told."""
    C = exact.sqrt(F(6))
    A = 2 * exact.sqrt(F(2)) * exact.sqrt(F(3))
    gamma = F(16, 25), F(12, 25), F(3, 5)
    torque, p, r = (2 * C, F(0), F(0)), F(6, 5), F(1)
    plain = (A, F(13, 10) * C, C), torque, (p, F(0), r), gamma
    motion = motion_of_family("bobylev-steklov", plain)
    assert motion.assumed
    assert all(ball(x).is_zero() for x in motion.assumed)
    proper = orbits.placed_in

    def asks(*arguments):
        assert exact.sign(A - 2 * C) == 0
        return proper(*arguments)

    monkeypatch.setattr(orbits, "placed_in", asks)
    assert motion_of_family("bobylev-steklov", start("bobylev-steklov", 3)[0]).assumed == ()


@pytest.mark.parametrize("unit", [F(10) ** 320, F(1, 10**320)])
@pytest.mark.parametrize("family", ["bobylev-steklov", "chaplygin"])
def test_units_beyond_doubles_are_no_exception(family, unit):
    """They ended in the words of Python's OverflowError, at 20 000 bits or with a nan."""
    plain = start(family, 1)[0]
    there, here = (polhode.reference(scene_of(plain, family, unit=x)) for x in (1 / unit, 1))
    t = F(3, 2)
    (row,), (plain_row,) = there.at([t * unit], 20), here.at([t], 25)
    with mpmath.workdps(30):
        row[:3] = [x * number(unit) for x in row[:3]]
        assert gap(row, plain_row) < 1e-18
        if family == "bobylev-steklov":
            assert gap(there.attitude([t * unit], 20)[0], here.attitude([t], 25)[0]) < 1e-19
            assert abs(there.period / number(unit) / here.period - 1) < 1e-19


def test_irrational_data_tell_what_is_assumed():
    """sqrt 2 sqrt 3 = sqrt 6 is no theorem to 4096 bits: the proof names the number called 0."""
    a = exact_number("sqrt(2)*sqrt(3)")
    gamma = F(9, 25), F(12, 25), F(4, 5)

    def euler_top(moments):
        return form("euler", moments, (F(0),) * 3, (F(1), F(1), F(1)), gamma)

    equal = euler_top((a, exact_number("sqrt(6)"), F(2)))
    assert "prolate" in equal.regime or "oblate" in equal.regime
    assert len(equal.assumed) > 0
    plain = euler_top((a, F(5, 2), F(2)))
    plain.at([F(1)], 20)
    assert plain.assumed == ()
