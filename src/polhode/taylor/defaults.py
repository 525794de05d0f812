"""What is chosen for the runs of each number type: one table.

What it rests on is measured in ``choices.md`` of the reports, which a test compares with the
table.  Rows depend on the type alone, so that a run is the same on every machine.
"""

from __future__ import annotations

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


def of(number: NumberType) -> Policy:
    """The row of a number type; an mp chunk is the shorter, the more bits there are."""
    row = TABLE[number.name]
    if number.name != "mp":
        return row
    steps = int(row.chunk * float((_CHUNK_BITS / number.bits) ** _CHUNK_POWER))
    return row._replace(chunk=max(1, steps))


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
