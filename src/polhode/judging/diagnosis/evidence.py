"""Whether a table is right in another convention: told by its first rows, whatever comes later.

A program that drifts is right at the start, where the scene is exact, and wrong at the end.  So the
digits of a convention are counted from the first row on and never rise again: one that is wrong in
the first rows is wrong, and one that is right there may drift as it likes.

What a wrong table could have by chance is not told.  A convention of which ``tries`` were tried has
to have so many digits more than the table as it stands that one in some thousand tables of random
numbers has one; and it has to follow the motion: where the motion has left its first row, it is
nearer to it than a table that stays there, or goes elsewhere, would be.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeVar

import numpy as np

from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles

Rows = TypeVar("Rows", Doubles, list[int])

MOST = 12.0  # digits that count: more are no more certain
BEGINS = 1.0  # digits of a first row that is right
LEAST_GAIN = 1.5  # digits that a convention gives at least, at some of the first rows
FAR_GAIN = 2.0  # likewise other times, or another scene
_RARE = 3.5  # log10 of so many tables of which one is right by chance
_ALIKE, _ALIKE_IF_EXACT, _EXACT = 0.3, 1.0, 9.0  # digits by which conventions do not differ
SURE = 6.0  # digits of a first row that is the start
_STAYS = 0.5  # digits that are left where the motion has left it
_LEFT = 0.1  # of its size: by so much the motion has left its first row
_FAR_LEFT = 0.5  # likewise, so that what goes elsewhere is plainly not there
_STILL = 0.01  # and by less it stands still
_FOLLOWS = 0.7  # digits of the way that the motion has come
_FOLLOWS_FITTED = 1.3  # likewise, of what is fitted to the first row
_FIRST_ROWS, _LATER_ROWS = 5, 6  # that are looked at: the first, and later ones ever farther apart


def probed_rows(times: Sequence[Fraction]) -> list[int]:
    """The rows that tell a convention: from the start on, the last one too."""
    order = sorted(range(len(times)), key=lambda k: abs(to_double(times[k])))
    count = len(order)
    if count <= _FIRST_ROWS + _LATER_ROWS:
        return order
    later = np.geomspace(_FIRST_ROWS, count - 1, _LATER_ROWS)
    return [order[k] for k in sorted({*range(_FIRST_ROWS), *(round(float(x)) for x in later)})]


def first_rows(rows: Rows) -> Rows:
    """The first of rows in the order of their times, which tell whether a table begins right."""
    return rows[:_FIRST_ROWS]


def course(digits: Doubles, fitted: bool = False) -> Doubles:
    """Digits that count at each row: the fewest up to there.

    ``fitted``: to the first row, which therefore says nothing.
    """
    held = np.clip(digits, 0.0, MOST)
    if fitted:
        held = np.concatenate([held[1:2], held[1:]])
    return np.minimum.accumulate(held)


def is_better(mine: Doubles, other: Doubles, gain: float) -> bool:
    """Whether a course has so many more digits somewhere, and fewer nowhere before."""
    more = mine - other
    rows = np.flatnonzero(more >= gain)
    return bool(len(rows)) and not np.any(more[: rows[0]] < -_slack(other[: rows[0]]))


def is_alike(mine: Doubles, best: Doubles) -> bool:
    """Whether a course is as good as the best one, where that has any digits."""
    return bool(np.all((mine >= best - _slack(best)) | (best < 1.0)))


def _slack(digits: Doubles) -> Doubles:
    return np.where(digits >= _EXACT, _ALIKE_IF_EXACT, _ALIKE)


def least_gain(tries: int, freedom: int) -> float:
    """The digits that random numbers, so many in a row, hardly have in any of so many tries."""
    return max(LEAST_GAIN, (math.log10(tries) + _RARE) / freedom)


def is_sure(mine: Doubles) -> bool:
    """Whether the first row is right to many digits."""
    return bool(mine[0] >= SURE)


def follows(mine: Doubles, moved: Doubles, fitted: bool, must_move: bool, sure: bool) -> bool:
    """Whether a course goes with the motion; ``moved``: how far that is from its first row.

    ``must_move``: whether a motion that stands still tells nothing.  ``sure``: whether the first
    row alone tells, being the start to many digits in one convention.
    """
    sure = sure and is_sure(mine) and not must_move
    left = np.flatnonzero(moved >= (_FAR_LEFT if sure or fitted else _LEFT))
    row = int(left[0]) if len(left) else int(np.argmax(moved))
    if sure:
        return float(mine[row]) >= _STAYS
    if moved[row] < _STILL and not (fitted or must_move):
        return True
    if moved[row] == 0:
        return False
    digits = float(mine[row]) + math.log10(float(moved[row]))
    return digits >= (_FOLLOWS_FITTED if fitted else _FOLLOWS)
