"""What is chosen for the runs of each number type: one table.

What it rests on is measured in ``choices.md`` of the reports, which a test compares with the
table.  Rows depend on the type alone, so that a run is the same on every machine.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

from polhode.numbers.number_types import NumberType

_CHUNK_BITS, _CHUNK_POWER = 237, 2.7  # mp: where its row holds, and how the cost of a step grows


class Policy(NamedTuple):
    """The choices for one number type, counted in Taylor steps.

    ``max_steps``: the step limit unless the user sets another.  ``chunk``: steps between two looks
    at the clock and for Ctrl-C, a fifth of a second of them at 0.6 µs (double), 7 µs (extended),
    0.3 ms (quad), 2 ms (mp at 237 bits).  ``set_back``: steps after which cyclic variables are set
    back to zero; ``divisor``: what they are divided by, a power of two: in that many steps they
    grow to about one, so that they neither loosen the steps nor shorten them.  ``projected``:
    whether a run is put back on its first integrals unless the user says otherwise, and
    ``project_every`` so many steps: that costs a tenth of the steps' time or less.
    ``unit_norm_every``: steps between two corrections of a quaternion's length, likewise.
    ``compact``: heyoka's compact mode, loops over functions instead of unrolled code.
    """

    max_steps: int
    chunk: int
    set_back: int
    divisor: int
    projected: bool
    project_every: int
    unit_norm_every: int
    compact: bool


TABLE = {
    "double": Policy(10**8, 200_000, 160, 256, True, 320, 1000, False),
    "extended": Policy(10**7, 30_000, 32, 64, True, 32, 100, False),
    "quad": Policy(10**6, 600, 8, 16, False, 1, 10, True),
    "mp": Policy(10**6, 100, 4, 8, False, 1, 1, True),
}


class ArrayPolicy(NamedTuple):
    """How arrays of starts are stepped in double where the tolerance is above the type's eps.

    ``starts``: from so many on, to so many ``radians`` of a motion's bound of rates and with at
    least the tolerance ``finest``, below which its rounding shows, by one compiled step of order
    ``lowest`` and ``rise`` more for each digit of the tolerance.  A step is
    (``reach`` + 0.09 order) tolerance**(1/order) radians: of few motions it is too long, and these
    are made again.  Of steps a ninth longer that were six in ten slow starts under a large weight.
    ``share``: of the tolerance, that its last two terms may be; heyoka's own steps allow half a
    tolerance to the last but one.  All others go in batches, of an order ``factor`` times heyoka's
    own, but at most ``highest``, by ``part`` of the tolerance, for what steps of such orders leave
    out is larger than of heyoka's own.
    """

    starts: int
    radians: float
    finest: float
    lowest: int
    rise: float
    reach: float
    share: float
    factor: float
    highest: int
    part: Fraction

    def order(self, tolerance: float) -> int:
        """Of the compiled step."""
        return self.lowest + math.ceil(-self.rise * math.log10(tolerance))

    def step(self, tolerance: float) -> float:
        """The radians of the compiled step."""
        order = self.order(tolerance)
        return float((self.reach + 0.09 * order) * tolerance ** (1 / order))


ARRAYS = ArrayPolicy(1024, 100.0, 1e-12, 6, 0.8, 1.26, 0.5, 1.5, 16, Fraction(1, 4))


def of(number: NumberType) -> Policy:
    """The row of a number type; an mp chunk is the shorter, the more bits there are."""
    row = TABLE[number.name]
    if number.name != "mp":
        return row
    steps = int(row.chunk * float((_CHUNK_BITS / number.bits) ** _CHUNK_POWER))
    return row._replace(chunk=max(1, steps))


# How a propagator of doubles makes rows where the tolerance is above eps: processor time of the
# ordinary way over that of the chosen one, heyoka 7.13, on two busy cores; so many outputs of one
# body each of four or five kinds, the median (least-most).
#
#   long steps, tol    101, t = 0.3      101, t = 1        10 001, t = 1    10 001, t = 10
#   1e-5                                 1.64 (from 0.80)  3.7 (3.1-6.3)    2.9 (2.2-5.8)
#   1e-7               1.32 (1.26-1.47)  1.52 (from 0.75)  6.7 (3.1-8.2)    2.7 (1.7-5.1)
#   1e-9                                 1.54 (from 0.94)  5.9 (4.8-7.4)    3.3 (1.4-4.1)
#
#   higher order, tol  the end, of 40 radians   of 400            101 outputs, 40   400
#   1e-5               1.22 (0.83-1.37)         1.19 (0.96-1.57)  1.04 (0.77-1.30)  1.22 (1.04-1.43)
#   1e-6               1.05 (0.80-1.30)         1.03 (0.85-1.26)  0.92 (0.77-1.16)  1.08 (0.95-1.28)
#
# (of 12 motions each; their errors were 0.66 to 1.15 of the ordinary way's in the median at 1e-5.)
#
# With 101 outputs three or four long steps instead of heyoka's grid (25 outputs a step, t = 1, 15
# motions, tolerances 1e-5 to 1e-11) gained 0.96 to 1.14 in the median where the times are known and
# lost as much where they are asked for once, so a step has 50.  Of such times one or two long steps
# take 1.7 to 1.9 times what the grid does: their powers are made first.  With 1001 outputs some 20
# steps pay (1.0).
#
# Without a part of the tolerance a higher order is faster, and its errors are three times as large,
# up to 3 tolerances of 317 motions; at tolerances below 3e-6 it gains too little.


class LongStepChoice(NamedTuple):
    """Of long steps (polhode.taylor.long_steps): their order, and outputs a step, at least."""

    order: int
    outputs: int


#: Orders of long steps for few outputs and for many, for tolerances above these; none for others.
_LONG_ORDERS = ((3e-4, 14, 12), (3e-6, 16, 14), (3e-8, 18, 14), (3e-10, 22, 14), (1e-12, 26, 16))
LONG_MANY = 1000
#: Of a first attempt: radians of the bound of the rate in a step, over tolerance**(1 / order).
#: Of 48 starts of six kinds heyoka granted as much to all, and 4.3 to 5.2 in the median; so the
#: second is tried where it takes LONG_FEW steps at most, for which a refusal costs little.
LONG_REACH, LONG_TRIED, LONG_FEW = 2.6, 4.8, 4
#: Above this tolerance the order is heyoka's own and so much, by a part of the tolerance, where a
#: propagator's way is longer than so many radians of the bound, and than those of its outputs.
ABOVE, MORE, PART, FAR, FAR_OUTPUTS = 3e-6, 2, Fraction(1, 2), 20.0, 5.0


def long_steps(tolerance: float) -> tuple[LongStepChoice, ...]:
    """The long steps for a tolerance, with few outputs and with many; none where there are none."""
    for least, few, many in _LONG_ORDERS:
        if tolerance > least:
            return LongStepChoice(few, 50), LongStepChoice(many, 100)
    return ()


def first_step_offset(number: NumberType) -> Fraction:
    """What is added to all that heyoka watches in a motion's first step.

    heyoka loses the next zero of a polynomial without constant term.  Added in later steps it would
    hide zeros at a seam of two of them.
    """
    return Fraction(1, 2 ** (647 + number.bits))


def seconds(number: NumberType, steps: float) -> float:
    """About how long so many steps take: a chunk of the table takes a fifth of a second."""
    row = TABLE[number.name]
    wide = (number.bits / _CHUNK_BITS) ** _CHUNK_POWER if number.name == "mp" else 1.0
    return 0.2 * steps / row.chunk * wide
