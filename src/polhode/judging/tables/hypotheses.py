"""What may be wrong with a table, and the one rule by which it is accepted.

A *hypothesis* says how a part of a table is to be read, at which times its rows hold, or of which
other scene it is the motion.  Its *evidence* is the digits that the rows have then.  The rule is
the same for all of them.

**The first rows tell.**  A program that drifts is right at the start, where the scene is exact,
and wrong at the end.  So digits are counted from the first row on and never rise again: what is
wrong in the first rows is wrong, and what is right there may drift as it likes.  Rows to which a
number of the hypothesis was fitted say nothing one by one: what counts for them are the rows after
them, and where there are none, their own fewest digits.

**Chance.**  A hypothesis of which ``tries`` were tried has to have so many digits more than the
table as it stands that one in some thousand tables of random numbers has one; a number that was
fitted to the table costs as much again.

**Motion.**  It has to follow the motion: where the motion has left its first row, the table is
nearer to it than one that stays there, or goes elsewhere, would be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.judging.tables.table import Change, TimeChange
from polhode.numbers.number_types import Doubles
from polhode.scenes.scene import Scene

MOST = 12.0  # digits that count: more are no more certain
LEAST_GAIN = 1.5  # digits that a hypothesis gives at least, at some row
_RARE = 3.5  # log10 of so many tables of which one is right by chance
_ALIKE, _ALIKE_IF_EXACT, EXACT = 0.3, 1.0, 9.0  # digits by which hypotheses do not differ
SURE = 6.0  # digits of a first row that is the start
_STAYS = 0.5  # digits that are left where the motion has left it
_LEFT = 0.1  # of its size: by so much the motion has left its first row
_FAR_LEFT = 0.5  # likewise, so that what goes elsewhere is plainly not there
_STILL = 0.01  # and by less it stands still
_FOLLOWS = 0.7  # digits of the way that the motion has come

#: The scene whose number is so much larger, and its times; raises ValueError for no body.
Motion: TypeAlias = Callable[[Fraction], tuple[Scene, TimeChange]]


class Hypothesis(NamedTuple):
    """What may be wrong with a part of a table, or with all of it.

    ``words``: how it is told, with {} for the number that is fitted; empty for the table as it
    stands.  ``change``: how the part is read, or at which times the rows hold; None of what is told
    and not applied.  ``motion``: of which the table may be, of a hypothesis of all parts.
    ``tries``: how many are as plain, of which one may be right by chance.  ``fitted``: how many
    numbers are fitted to the table, ``origin + unit * x`` for the x of ``motion``, ``smallest`` or
    more.  ``renamed``: how many frames it renames; the plainer ones come first.
    """

    words: str = ""
    change: Change | TimeChange | None = None
    motion: Motion | None = None
    tries: int = 1
    fitted: int = 0
    renamed: int = 0
    origin: float = 0.0
    unit: float = 1.0
    smallest: float = -math.inf

    @property
    def scene(self) -> Scene:
        """Of which it says that the table is, before a number is fitted."""
        assert self.motion is not None
        scene, _ = self.motion(Fraction(0))
        return scene


class Evidence(NamedTuple):
    """The digits that rows of a table have under a hypothesis, those of the earliest row first.

    ``rows_fitted``: how many of them its numbers were fitted to.  ``freedom``: the numbers of a row
    that are free of each other.
    """

    hypothesis: Hypothesis
    rows: Doubles
    rows_fitted: int = 0
    freedom: int = 1

    @property
    def digits(self) -> float:
        """The fewest digits of a row."""
        return float(np.min(self.rows))

    @property
    def course(self) -> Doubles:
        """The digits that count at each row: the fewest up to there."""
        digits = np.clip(self.rows, 0.0, MOST)
        if self.rows_fitted >= len(digits):
            return np.full(len(digits), np.min(digits))
        digits[: self.rows_fitted] = digits[self.rows_fitted]
        course: Doubles = np.minimum.accumulate(digits)
        return course

    @property
    def gain(self) -> float:
        """The digits more than as it stands that random numbers hardly have in any of the tries."""
        chance = (math.log10(self.hypothesis.tries) + _RARE) / self.freedom
        return max(LEAST_GAIN, chance) * (2 if self.hypothesis.fitted else 1)

    def follows(self, moved: Doubles, must_move: bool = False, is_named: bool = False) -> bool:
        """Whether it goes with the motion; ``moved``: how far that is from its first row.

        ``must_move``: whether a motion that stands still tells nothing.  ``is_named``: whether the
        first row alone tells, being the start to many digits in one convention.
        """
        course, fitted = self.course, bool(self.hypothesis.fitted)
        is_named = is_named and float(course[0]) >= SURE and not must_move
        left = np.flatnonzero(moved >= (_FAR_LEFT if is_named or fitted else _LEFT))
        row = int(left[0]) if len(left) else int(np.argmax(moved))
        if is_named:
            return float(course[row]) >= _STAYS
        if moved[row] < _STILL and not (fitted or must_move):
            return True
        if moved[row] == 0:
            return False
        digits = float(course[row]) + math.log10(float(moved[row]))
        return digits >= _FOLLOWS * (2 if fitted else 1)


class Comparison(NamedTuple):
    """Evidence of a part beside that of a rival, and whether it goes with the motion."""

    evidence: Evidence
    rival: Evidence
    goes: bool


def explains(parts: Sequence[Comparison]) -> bool:
    """The rule: whether evidence of all parts of a table explains it.

    All of them begin right and have more digits together; one or more have far more at some row,
    and no fewer before it, and go with the motion.
    """
    better, more = [], 0.0
    for part in parts:
        mine, rival = part.evidence.course, part.rival.course
        count = min(len(mine), len(rival))  # as far as both go
        gains = mine[:count] - rival[:count]
        more += float(np.sum(gains))
        first = np.flatnonzero(gains >= part.evidence.gain)[:1]
        if len(first) and np.all(gains[: first[0]] >= -_slack(rival[: first[0]])):
            better.append(part)
    begin = all(float(part.evidence.course[0]) >= LEAST_GAIN for part in parts)
    return bool(better) and all(part.goes for part in better) and more > 0 and begin


def is_alike(mine: Doubles, best: Doubles) -> bool:
    """Whether a course is as good as the best one, where that has any digits."""
    return bool(np.all((mine >= best - _slack(best)) | (best < 1.0)))


def _slack(digits: Doubles) -> Doubles:
    return np.where(digits >= EXACT, _ALIKE_IF_EXACT, _ALIKE)
