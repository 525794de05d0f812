"""No closed form refuses a start of its family: random ones, the hard ones among them.

What is answered is held against power series that share nothing with it, and against the same in
more bits.  Other axes and units are asked by test_table.py.
"""

from __future__ import annotations

from fractions import Fraction

import pytest

from polhode.numbers.mpmath_context import mpf
from shared import orbit_members
from shared.ball_checks import (
    FEW_BITS,
    TIMES,
    agrees_with_taylor,
    every_ball_holds_its_value,
    made,
)
from shared.closed_form_motions import gap, relabel, table_gap
from shared.members import start

F = Fraction
FAR = F(30)
#: Fast seeds, slow ones and all of them; bits and times of rough balls, bits of sure ones, and how
#: sure these are.
ROUGH = {
    "euler": (4, 8, 100, FEW_BITS, TIMES, 900, "1e-60"),
    "lagrange": (4, 8, 100, FEW_BITS, TIMES, 900, "1e-60"),
    "pendulum": (4, 8, 100, FEW_BITS, TIMES, 900, "1e-60"),
    "hess": (3, 20, 240, FEW_BITS[::2], TIMES, 280, "1e-60"),
    "kovalevskaya": (0, 6, 60, FEW_BITS[1:-1], TIMES[:2], 420, "1e-12"),
    "goryachev-chaplygin": (2, 24, 240, FEW_BITS, (F(7), F(-(10**6))), 420, "1e-12"),
    **dict.fromkeys(
        ("staude", *orbit_members.MEMBERS), (1, 2, 20, FEW_BITS[1:-1], TIMES[:2], 330, "1e-60")
    ),
}
#: Of which a row with attitude costs seconds.
DEAR = "goryachev", "n-kowalewski", "chaplygin"
#: Whose attitude is enclosed, or proven in part.
PARTLY = "kovalevskaya", "goryachev-chaplygin"


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
    motion, (few, times, many, sure_to) = made(family, plain), ROUGH[family][3:]
    assert every_ball_holds_its_value(motion, times, few, many, sure_to) >= 20
    fastest = max(map(abs, plain[2]))
    if fastest < 20 and max(map(abs, plain[1])) < 1000 * min(plain[0]):
        agrees_with_taylor(motion, plain)
    rows, more = (motion.at([FAR, -FAR], digits) for digits in (20, 35))
    assert table_gap(rows, more, max(fastest, 1)) < mpf("1e-19")
    if motion.has_attitude:
        turns = (motion.attitude([FAR], digits)[0] for digits in (20, 35))
        assert gap(*turns) < mpf("1e-19")
    assert motion.proven is True or family in PARTLY
