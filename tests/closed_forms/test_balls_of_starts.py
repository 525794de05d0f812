"""No closed form refuses a start of its family: random ones, and those next to degenerate motions.

What is answered is held against power series that share nothing with it, and against the same in
more bits.  Other axes and units are asked by test_table.py.
"""

from __future__ import annotations

from collections import Counter
from fractions import Fraction

import pytest
from mpmath import mpf

from shared import members, orbit_members
from shared.closed_forms import (
    FEW_BITS,
    TIMES,
    agrees_with_taylor,
    every_ball_holds_its_value,
    gap,
    motion_of_family,
    relabel,
    table_gap,
)

F = Fraction
FAR = F(30)
#: Fast seeds, slow ones and all of them; bits and times of rough balls, bits of sure ones, how sure
#: these are, and how many numbers of rough ones are finite at least.
ROUGH = {
    "euler": (2, 4, 100, FEW_BITS, TIMES, 900, "1e-60", 21),
    "lagrange": (2, 4, 100, FEW_BITS, TIMES, 900, "1e-60", 21),
    "pendulum": (2, 4, 100, FEW_BITS, TIMES, 900, "1e-60", 21),
    "hess": (0, 1, 240, FEW_BITS[::2], TIMES, 280, "1e-60", 21),
    "kovalevskaya": (0, 1, 60, FEW_BITS[1:-1], TIMES[:2], 420, "1e-12", 20),
    "goryachev-chaplygin": (1, 2, 240, FEW_BITS, (F(7), F(-(10**6))), 420, "1e-12", 36),
    **dict.fromkeys(
        ("staude", *orbit_members.MEMBERS), (1, 1, 20, FEW_BITS[1:-1], TIMES[:2], 330, "1e-60", 21)
    ),
}
#: Of which a row with attitude costs seconds: its fast seeds and slow ones.
LATEST = {"steklov": (0, 1), **dict.fromkeys(("goryachev", "n-kowalewski", "chaplygin"), (0, 0))}
#: Whose attitude is enclosed, or proven in part.
PARTLY = "kovalevskaya", "goryachev-chaplygin"


def seeds():
    """Families and seeds, few of them fast."""
    for family, (fast, slow, count, *_) in ROUGH.items():
        for seed in range(count):
            fast, slow = LATEST.get(family, (fast, slow))
            if seed < max(fast, slow):
                yield pytest.param(family, seed, marks=[pytest.mark.slow] * (seed >= fast))


@pytest.mark.parametrize(("family", "seed"), [*seeds()])
def test_every_ball_holds_its_value(family, seed):
    """However few its bits; and the motion is that of power series."""
    plain, pick = members.start(family, seed)
    plain = relabel(plain, pick.sample(range(3), 3), [pick.choice((1, -1)) for _ in range(3)])
    motion, (few, times, many, sure_to, finite) = motion_of_family(family, plain), ROUGH[family][3:]
    assert every_ball_holds_its_value(motion, times, few, many, sure_to) >= finite
    fastest = max(map(abs, plain[2]))
    if fastest < 20 and max(map(abs, plain[1])) < 1000 * min(plain[0]):
        agrees_with_taylor(motion, plain)
    rows, more = (motion.at([FAR, -FAR], digits) for digits in (20, 35))
    assert table_gap(rows, more, max(fastest, 1)) < mpf("1e-19")
    if motion.place.has_attitude:
        turns = (motion.attitude([FAR], digits)[0] for digits in (20, 35))
        assert gap(*turns) < mpf("1e-19")
    assert motion.place.proven is True or family in PARTLY


#: Kinds of motion of which every row of the table of motions is asked.
KINDS = "-e", "e-", "ee", "steady cone"
#: So near a degenerate one that few bits tell nothing: asked by test_table.py.
UNTOLD = "nearly at rest", "1e-60 from Bobylev-Steklov"
OFF = "1e-8", "-1e-8", "1e-40", "-1e-40"
#: Few bits, beside half of many; many next to a degenerate motion by 1e-8, and by less; and how
#: many numbers of rough balls are finite at least, more than half of many bits tell alone where the
#: few tell so much.
SURE = {
    "kovalevskaya": (FEW_BITS[1:-2], (260, 900), 20),
    "goryachev-chaplygin": (FEW_BITS[::2], (424, 550), 12),
    "hess": ((30, 107), (320, 900), 16),
    **dict.fromkeys(("n-kowalewski", "chaplygin"), (FEW_BITS, (900, 900), 81)),
}
#: Next to which the proof of Hess's case takes seconds, and up to ten of them at 1e-40; all but
#: the first are asked by hand.
LATER = "plane", "separatrix", "rest", "upright"


def named_starts():
    """Families, names, distances from a degenerate motion, and starts."""
    table = members.motion_table()
    for family in ROUGH:
        for name, texts in table.get(family, {}).items():
            if texts[4].startswith(KINDS) and name not in UNTOLD:
                yield family, name, "", members.read_start(texts)
        for name, texts in table["near"].get(family, {}).items():
            for off in OFF if "off" in "".join(texts) else ("",):
                written = [text.replace("off", f"({off})") for text in texts]
                yield family, name, off, members.read_start(written)
    for name, make in members.NEARER.items():
        for off in OFF[::2]:
            yield "goryachev-chaplygin", name, off, make(F(off))
    for name, plain in members.EXCEPTIONAL.items():
        yield "goryachev-chaplygin", name, "", plain
    for family in ("n-kowalewski", "chaplygin"):
        for name, plain in members.MOTIONS[family].items():
            yield family, name, "", plain


def cost(family, name, off, turn):
    """Which run asks it, "" for the fast one; of the dear families most are left out."""
    if family == "hess":
        near = off in ("", "1e-8") and name not in LATER[1:]
        return "left out" if not near else "slow" if name in LATER else ""
    if family == "goryachev-chaplygin":
        return ("left out", "slow", "left out", "")[turn % 4]
    if family == "kovalevskaya":
        return "" if turn == 1 else "left out" if turn % 6 else "slow"
    if family in LATEST:
        return "left out"
    return "left out" if off in OFF[1:3] else ""


def params():
    """Starts with their bits and marks."""
    counts = Counter()
    for family, name, off, plain in named_starts():
        counts[family] += 1
        which = cost(family, name, off, counts[family])
        if which == "left out":
            continue
        marks = [getattr(pytest.mark, which)] if which else []
        few, bits, finite = SURE.get(family, (FEW_BITS, (900, 900), 51))
        many = bits["1e-" in name or off not in ("", "1e-8", "-1e-8")]
        arguments = family, plain, [*few, many // 2], many, finite
        yield pytest.param(*arguments, id=f"{family}: {name} {off}".strip(), marks=marks)


@pytest.mark.parametrize(("family", "plain", "few", "many", "finite"), [*params()])
def test_starts_next_to_degenerate_motions(family, plain, few, many, finite):
    """And in exceptional places; what is rational assumes nothing."""
    motion, times = motion_of_family(family, plain), ROUGH[family][4][:2]
    sure_to = "1e-12" if family in PARTLY else "1e-60"
    assert every_ball_holds_its_value(motion, times, few, many, sure_to) >= finite
    agrees_with_taylor(motion, plain, 32)
    rational = all(isinstance(x, Fraction) for row in plain for x in row)
    assert motion.assumed == () or not rational
