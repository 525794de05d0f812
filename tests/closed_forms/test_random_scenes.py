"""No closed form refuses a scene of its family: random ones, the hard ones among them.

Axes renamed, reversed and turned, in units of 1e20 and 1e-20.  What is answered is held against
power series that share nothing with it, and against the same at more digits.
"""

from __future__ import annotations

from fractions import Fraction

import pytest

import polhode
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import orbit_members
from shared.ball_checks import (
    FEW_BITS,
    TIMES,
    agrees_with_taylor,
    every_ball_holds_its_value,
    made,
)
from shared.closed_form_motions import (
    IDENTITY,
    Motion,
    by_series,
    gap,
    in_scene,
    number,
    quaternion_of,
    relabel,
    scene_of,
    start_quaternion,
    table_gap,
    turn_between,
)
from shared.members import MEMBERS, rotation, start

F = Fraction
#: Fast seeds, slow ones and all of them; bits and times of rough balls, and bits of sure ones.
ROUGH = {
    "euler": (4, 8, 100, FEW_BITS, TIMES, 900),
    "lagrange": (4, 8, 100, FEW_BITS, TIMES, 900),
    "pendulum": (4, 8, 100, FEW_BITS, TIMES, 900),
    "hess": (3, 20, 240, FEW_BITS[::2], TIMES, 280),
    **dict.fromkeys(("staude", *orbit_members.MEMBERS), (1, 2, 20, FEW_BITS[1:-1], TIMES[:2], 330)),
}
#: Of which a row with attitude costs seconds.
DEAR = "goryachev", "n-kowalewski", "chaplygin"


def seeds():
    """Families and seeds, few of them fast."""
    for family, (fast, slow, count, *_) in ROUGH.items():
        for seed in range(count):
            quick = seed < fast and family not in DEAR
            marks = [] if quick else pytest.mark.slow if seed < slow else pytest.mark.campaign
            yield pytest.param(family, seed, marks=marks)


@pytest.mark.parametrize(("family", "seed"), [*seeds()])
def test_every_ball_holds_its_value(family, seed):
    """However few its bits; and the motion is that of power series."""
    plain, pick = start(family, seed)
    plain = relabel(plain, pick.sample(range(3), 3), [pick.choice((1, -1)) for _ in range(3)])
    motion, (few, times, many) = made(family, plain), ROUGH[family][3:]
    assert every_ball_holds_its_value(motion, times, few, many) > 20
    if max(map(abs, plain[2])) < 20 and max(map(abs, plain[1])) < 1000 * min(plain[0]):
        agrees_with_taylor(motion, plain)
    assert motion.proven is True


QUICK = "euler", "lagrange", "pendulum", "staude", "grioli", "hess"
#: In units of the time in which the numbers of a start are of order 1.
NEAR, FAR = F(3, 4), F(30)
#: Whose axis 1 is exactly vertical where p = 0.
THROUGH_POLES = "steklov", "goryachev"
UNITS = 1, 1, F(10**20), F(1, 10**20)


@pytest.mark.parametrize(
    ("family", "seed"),
    [
        *((family, 0) for family in QUICK),
        *(
            pytest.param(family, 0, marks=pytest.mark.slow)
            for family in MEMBERS
            if family not in QUICK
        ),
        *(
            pytest.param(family, seed, marks=pytest.mark.campaign)
            for family in MEMBERS
            for seed in range(1, 25)
        ),
    ],
)
def test_no_scene_of_a_family_is_refused(family, seed):
    """State, attitude and angles of one scene, near and farther on."""
    plain, pick = start(family, seed)
    order, signs = pick.sample(range(3), 3), [pick.choice((1, -1)) for _ in range(3)]
    plain = relabel(plain, order, signs)
    unit, mass, axes = pick.choice(UNITS), pick.choice(UNITS), IDENTITY
    if pick.random() < 0.5:
        axes = rotation(1, 2, 4, 2)
    motion = Motion(family, f"{seed}", start=plain)
    moved = Motion(family, f"{seed}, moved", "", None)
    moved.__dict__["scene"] = scene_of(plain, family, axes, F(unit), F(mass))
    top, times = moved.reference, [NEAR / unit, -NEAR / unit, FAR / unit]
    rows, more = top.at(times, 20), top.at(times, 35)
    turns, others = top.attitude([F(0), *times], 20), top.attitude([F(0), *times], 35)
    if "degenerate curve" in top.regime:  # of which psi and phi may be refused, next to poles
        return
    if family in THROUGH_POLES and axes is IDENTITY and plain[1][2]:
        with pytest.raises(polhode.BadInput, match="past a pole"):
            top.angles([FAR / unit], 20)
        angles = finer = []
    else:
        angles, finer = top.angles(times, 20), top.angles(times, 35)
    with mpmath.workdps(60):
        assert table_gap(rows, more, unit) < mpf("1e-19")
        assert max(gap(*pair) for pair in zip(turns, others, strict=True)) < mpf("1e-19")
        assert gap(start_quaternion(moved.scene), others[0]) < mpf("1e-34")
        for row, right, q in zip(angles, finer, others[1:], strict=bool(angles)):
            assert [x is None for x in row] == [x is None for x in right]
            if row[0] is None:
                continue
            assert gap(row, right) < mpf("1e-19")
            known = quaternion_of(*right)
            assert min(gap(q, known), gap(q, [-x for x in known])) < mpf("1e-30")
    truth = [*by_series(motion, [NEAR], 30), *by_series(motion, [-NEAR], 30)]
    with mpmath.workdps(60):
        matrix, first = [[number(x) for x in row] for row in axes], start_quaternion(motion.scene)
        seen_there = [
            [*in_scene([x * number(unit) for x in row[:3]], matrix), *in_scene(row[3:6], matrix)]
            for row in truth
        ]
        assert table_gap(seen_there, more[:2], unit) < mpf("1e-25")
        for row, q in zip(truth, others[1:3], strict=True):
            scalar, *turn = turn_between(row[6:10], first)
            assert gap(turn_between(q, others[0]), [scalar, *in_scene(turn, matrix)]) < mpf("1e-25")
