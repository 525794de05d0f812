"""Goryachev and Chaplygin's case in balls: bounds by force, and the enclosed attitude."""

import dataclasses
import math
from fractions import Fraction

import pytest
from flint import arb

import polhode
from polhode import BadInput
from polhode.closed_forms.balls import clocks
from polhode.closed_forms.balls.core import TooFewBits
from polhode.judging import reference, score
from polhode.numbers.flint_context import ctx
from shared import members
from shared.closed_forms import gap, motion_of_family, row_at, scene_of
from shared.tools import exact_number, tiers

F = Fraction
NAME = "goryachev-chaplygin"


def motion_of(plain):
    return motion_of_family(NAME, plain)


def test_a_place_that_is_not_near_the_solution_proves_nothing():
    begin = motion_of(members.on_cubics(F(2), F(1), F(1), F(3, 2), F(1, 4)))
    with ctx.workprec(200):
        path = begin._motion().path
        x, y = path._phases(arb(1))
        clocks = path._u.clock, path._v.clock
        points = [clock.at(z.mid()) for clock, z in zip(clocks, (x, y), strict=True)]
        steps = arb("1e-20"), arb("1e-20")
        with pytest.raises(TooFewBits):
            path._proven((x.mid(), y.mid()), points, steps, (arb("1e-9"), arb(0)))


def test_what_a_short_way_leaves_out_is_in_the_radius(monkeypatch):
    """60 less than rounding leaves, on the way to a double root."""
    motion = motion_of(members.MOTIONS[NAME]["asymptotic, from below"])
    sure = row_at(motion, F(100), 400)
    monkeypatch.setattr(clocks, "_WAY", -60)
    row = row_at(motion, F(100), 200)
    assert all(x.overlaps(y) for x, y in zip(row, sure, strict=True))
    assert arb("1e-36") < max(x.rad() for x in row) < arb("1e-3")


@pytest.mark.parametrize("unit", tiers([F(1)], [F(1, 10**30)]))
def test_released(unit):
    """gamma3 = 6/7; a centre at sqrt 2 from the fixed point, in any direction of the plane."""
    size = unit * unit * exact_number("sqrt(2)")
    gamma = F(2, 7), F(3, 7), F(6, 7)
    start = members.BODY, (size * F(3, 5), size * F(4, 5), 0), (0, 0, 0), gamma
    top = polhode.reference(scene_of(start, NAME))
    times = [F(10) / unit, F(-(10**12)) / unit]
    rows, more = top.at(times, 20), top.at(times, 40)
    for row, right in zip(rows, more, strict=True):
        assert gap(row[:3], right[:3]) < 3e-20 * float(unit)
        assert gap(row[3:], right[3:]) < 1e-20
    assert top.period is not None


def test_the_attitude_is_enclosed_where_the_state_has_a_formula():
    truth = polhode.reference("goryachev-chaplygin/two-frequencies")
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
    ("t", "why"), [(10**9, "300000 steps"), (3 * 10**4, r"at most 60 s .* about \d{2,3} s")]
)
def test_an_attitude_too_far_away_is_refused_before_it_is_begun(t, why):
    truth = polhode.reference("goryachev-chaplygin/two-frequencies")
    assert len(truth.at([t], 20)[0]) == 6
    with pytest.raises(BadInput, match=f"{why}.*has the state alone, attitude is enclosed"):
        truth.attitude([t], 20)


def test_one_enclosure_goes_through_all_rows_of_a_table(monkeypatch):
    """Its forecast and its limit on the time are then those of the whole table."""
    proofs, certified = [], reference.EnclosureReference

    def counted(*arguments, **options):
        proofs.append(arguments)
        return certified(*arguments, **options)

    monkeypatch.setattr(reference, "EnclosureReference", counted)
    monkeypatch.setattr(score, "_PIECE", 2)
    scene = dataclasses.replace(polhode.load("goryachev-chaplygin/released"), outputs=("attitude",))
    run = polhode.integrate(scene, at=[F(k, 9) for k in range(7)])
    assert None not in polhode.compare(run).part_digits["attitude"]
    assert len(proofs) == 1
