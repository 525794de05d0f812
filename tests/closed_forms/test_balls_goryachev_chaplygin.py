"""Goryachev and Chaplygin's case in balls: bounds by force, and the enclosed attitude."""

import cmath
import math
from fractions import Fraction
from random import Random

import pytest
from flint import arb

import polhode
from polhode.closed_forms.balls import clocks
from polhode.closed_forms.balls import clocks as panels
from polhode.closed_forms.balls.core import TooFewBits
from polhode.closed_forms.families import closed_form
from polhode.common.errors import BadInput
from polhode.judging import reference, score
from polhode.numbers import exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf
from shared import members
from shared.closed_forms import motion_of_family, row_at
from shared.tools import tiers

F = Fraction
NAME = "goryachev-chaplygin"
FROM_ABOVE = members.NEAR["D- from above"](F(1, 10**8))


def motion_of(plain):
    return motion_of_family(NAME, plain)


def test_a_place_that_is_not_near_the_solution_proves_nothing():
    begin = motion_of(members.on_cubics(F(2), F(1), F(1), F(3, 2), F(1, 4)))
    with ctx.workprec(200):
        path = begin._motion().state.path
        x, y = path._phases(arb(1))
        clocks = path._u.clock, path._v.clock
        points = [clock.at(z.mid()) for clock, z in zip(clocks, (x, y), strict=True)]
        steps = arb("1e-20"), arb("1e-20")
        with pytest.raises(TooFewBits):
            path._proven((x.mid(), y.mid()), points, steps, (arb("1e-9"), arb(0)))


@pytest.mark.parametrize("kind", ["D- from above", "G, rotating"])
def test_the_motion_next_to_a_degenerate_one_is_nearly_it(kind):
    """Another way of computing: v constant or asymptotic, G = 0."""
    near, exact_motion = (motion_of(members.NEAR[kind](gap)) for gap in (F(1, 10**40), F(0)))
    assert near.regime != exact_motion.regime
    rows = [motion.at([F(3)], 30)[0] for motion in (near, exact_motion)]
    assert max(abs(x - y) for x, y in zip(*rows, strict=True)) < mpf("1e-29")


def test_a_rule_for_a_larger_ellipse_than_f_is_bounded_on_misses(monkeypatch):
    """Gauss's rule with the points that are enough for 12 half panels in place of 3."""
    plain = FROM_ABOVE
    sure, wrong = row_at(motion_of(plain), F(7), 400), []
    for ratio in (panels.RATIO, 12):
        monkeypatch.setattr(panels, "RATIO", ratio)
        monkeypatch.setattr(clocks, "_PART", 2 * ratio - 1)
        row = row_at(motion_of(plain), F(7), 200)
        wrong.append(sum(not x.overlaps(y) for x, y in zip(row, sure, strict=True)))
    assert wrong == [0, 6]


@pytest.mark.parametrize(
    ("constant", "plain"),
    [
        ((panels, "_SPARE"), FROM_ABOVE),
        ((clocks, "_WAY"), members.MOTIONS[NAME]["asymptotic, from below"]),
    ],
)
def test_what_few_points_and_a_short_way_leave_out_is_in_the_radius(constant, plain, monkeypatch):
    """60 less than rounding leaves, on panels and on the way to a double root."""
    motion = motion_of(plain)
    sure = row_at(motion, F(100), 400)
    monkeypatch.setattr(*constant, -60)
    row = row_at(motion, F(100), 200)
    assert all(x.overlaps(y) for x, y in zip(row, sure, strict=True))
    assert arb("1e-36") < max(x.rad() for x in row) < arb("1e-3")


@pytest.mark.parametrize(
    ("kind", "function"),
    [
        (clocks.Oscillating, lambda x: cmath.sin(x / 2) ** 2),
        (clocks.Tending, lambda x: 1 / cmath.cosh(x) ** 2),
    ],
)
def test_a_variable_stays_within_its_reach_and_nearly_reaches_it(kind, function):
    pick, shares = Random(1), []
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

    pick, few, many, finite, wrong = Random(1), variable(120), variable(300), 0, 0
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


#: Exact and awkward: at a turning point of u, with an irrational centre, in units of 1e30.
CASES = {
    "from rest": (F(0), F(0), F(0)),
    "nearly from rest": (F(1, 10**30), F(0), F(-4 * 2, 6 * 10**30)),
}


@pytest.mark.parametrize(
    ("unit", "name"),
    tiers(
        [(Fraction(1, 1), "from rest")],
        [(Fraction(1, 1000000000000000000000000000000), "from rest")],
    ),
)
def test_released(name, unit):
    """gamma3 = 6/7; a centre at sqrt 2 from the fixed point, in any direction of the plane."""
    omega = tuple(unit * x for x in CASES[name])
    torque = unit * unit * exact.sqrt(F(2)) * F(3, 5), unit * unit * exact.sqrt(F(2)) * F(4, 5), 0
    motion = motion_of((members.BODY, torque, omega, (F(2, 7), F(3, 7), F(6, 7))))
    times = [F(10) / unit, F(-(10**12)) / unit]
    rows, more = motion.at(times, 20), motion.at(times, 40)
    for row, right in zip(rows, more, strict=True):
        off = [abs(x - y) for x, y in zip(row, right, strict=True)]
        assert max(off[:3]) < mpf("1e-20") * 3 * float(unit)
        assert max(off[3:]) < mpf("1e-20")
    assert (motion.period(20) is None) == name.startswith("nearly")


def test_the_attitude_is_enclosed_where_the_state_has_a_formula():
    truth = polhode.reference("goryachev-chaplygin/two-frequencies")
    motion = closed_form(truth.scene)[1]
    for refused in (motion.attitude, motion.angles):
        with pytest.raises(ValueError, match=r"reference\.kind = certified"):
            refused([F(1)], 20)
    (q,), (row,) = truth.attitude([3], 20), truth.at([3], 20)
    a, b, c, d = q
    vertical = 2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d
    assert 0 < max(abs(x - y) for x, y in zip(vertical, row[3:], strict=True)) < 1e-20
    assert truth.proven == "states are proven by the closed form, the attitude by an enclosure"


def test_angles_at_the_start_and_past_a_pole():
    """From rest they are the start's; where axis 3 passes the vertical, the attitude judges."""
    truth = polhode.reference("goryachev-chaplygin/released")
    (angles,), (q,) = truth.angles([0], 20), truth.attitude([0], 20)
    assert angles[0] == 0
    assert abs(math.tan(angles[2]) - 2 / 3) < 1e-15
    assert q[0] > 0
    moments, torque, omega, gamma = members.MOTIONS[NAME]["v constant, et = 0"]
    body = polhode.Body.of_moments(moments, torque, 1)
    scene = polhode.Scene(body, omega, gamma, outputs=("angles",))
    with pytest.raises(BadInput, match=r"psi and phi are lost at t = 3"):
        polhode.reference(scene).angles([4], 15)
    judged = polhode.compare(polhode.integrate(scene, at=[1, 4]))
    assert 12 < min(judged.part_digits["angles"]) < 17


@pytest.mark.parametrize(
    ("t", "why"), [(10**9, "300000 steps"), (10**3, "at most 1 s .* about [34]")]
)
def test_an_attitude_too_far_away_is_refused_before_it_is_begun(t, why, monkeypatch):
    monkeypatch.setattr(reference, "_FORETOLD_SECONDS", 1)
    truth = polhode.reference("goryachev-chaplygin/two-frequencies")
    assert len(truth.at([t], 20)[0]) == 6
    with pytest.raises(BadInput, match=f"{why}.*has the state alone, attitude is enclosed"):
        truth.attitude([t], 20)


def test_one_enclosure_goes_through_all_rows_of_a_table(monkeypatch):
    """Its forecast and its limit on the time are then those of the whole table."""
    proofs, certified = [], reference.Certified

    def counted(*arguments, **options):
        proofs.append(arguments)
        return certified(*arguments, **options)

    monkeypatch.setattr(reference, "Certified", counted)
    monkeypatch.setattr(score, "_PIECE", 2)
    truth, times = polhode.reference("goryachev-chaplygin/released"), [F(k, 9) for k in range(7)]
    table = score.Answers(truth, times, True, None)
    assert len(table.rows("attitude", 15)) == len(table.rows("at", 15).hi) == 7
    assert len(proofs) == 1
