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
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple, TypeVar

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.certified import Certified
from polhode.judging.reference import AnyReference
from polhode.judging.tables.double_motion import Right, integrated, matrices
from polhode.judging.tables.table import PARTS, WRONG, Reading, Table, TimeChange
from polhode.judging.tables.ways import (
    ALIKE_AT_START,
    FREEDOM,
    SCALAR_FIRST,
    Way,
    other_times,
    ways,
)
from polhode.numbers.conversion import doubles, to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Doubles
from polhode.numbers.vectors import Matrix
from polhode.scenes.body import exact_vector
from polhode.scenes.scene import Scene

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
    digits_held = np.clip(digits, 0.0, MOST)
    if fitted:
        digits_held = np.concatenate([digits_held[1:2], digits_held[1:]])
    return np.minimum.accumulate(digits_held)


def is_better(mine: Doubles, rival: Doubles, gain: float) -> bool:
    """Whether a course has so many more digits somewhere, and fewer nowhere before."""
    more = mine - rival
    rows = np.flatnonzero(more >= gain)
    return bool(len(rows)) and not np.any(more[: rows[0]] < -_slack(rival[: rows[0]]))


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


# --- worlds ---------------------------------------------------------------------------------------
#
# Worlds: the motions that a table may be of, beside the scene's at the times as they stand.
#
# Each is the scene's motion at other times (:mod:`other_times`), or that of another scene, with a
# sign or an order of numbers that is often another; all in double.


_FARTHEST = (1e4, 1e5)  # radians or so, to which motions at other times are followed
_FEWEST = 2  # rows that tell other times
_POLE = 1e-9  # the sine of theta where psi and phi are one angle


class World(NamedTuple):
    """What a table may be a motion of, in words: the scene's motion at times that are changed, or
    another scene's.

    ``right``: the motion at the first of the rows, as far as it is followed.  ``change``: of the
    times; None of another scene, which no table is read as.
    """

    words: str
    right: Right
    change: TimeChange | None = None


def other_worlds(
    times: Sequence[Fraction], all_times: Sequence[Fraction], scene: Scene
) -> Iterator[World]:
    """The motion at other times, and those of other scenes that may be meant."""
    yield from at_times(other_times(all_times), times, scene)
    for words, candidate in other_scenes(scene):
        right = integrated(candidate, times)
        if right is not None:
            yield World(words, right)


def at_times(
    changes: Mapping[str, TimeChange], times: Sequence[Fraction], scene: Scene
) -> Iterator[World]:
    """The motion at changed times, as far as it is followed, near times before far ones."""
    rate = 10.0**scene.log10_rate
    moved = {words: [change.of(t) for t in times] for words, change in changes.items()}
    for words in sorted(moved, key=lambda words: max(map(abs, moved[words]))):
        some = moved[words]
        for farthest in _FARTHEST:
            far = [k for k, t in enumerate(some) if abs(t) * rate > farthest]
            there = some[: far[0]] if far else some
            if len(there) >= _FEWEST:
                break
        right = integrated(scene, there) if len(there) >= _FEWEST else None
        if right is not None:
            yield World(words, right, changes[words])


def other_scenes(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Scenes with a sign or an order of numbers that is often another."""
    body = scene.body
    if body.weight:
        yield "a weight of the other sign", with_body(scene, body.inertia, -body.weight)
    products = [(i, j) for i in range(3) for j in range(i) if body.inertia[i][j] != 0]
    some = [products, *([product] for product in products)] if len(products) > 1 else [products]
    for signs in filter(None, some):
        x, y, z = (
            exact_vector([-m if {(i, j), (j, i)} & {*signs} else m for j, m in enumerate(row)])
            for i, row in enumerate(body.inertia)
        )
        names = ", ".join("I" + "xyz"[j] + "xyz"[i] for i, j in signs)
        words = f"products of inertia of the other sign ({names})"
        with suppress(BadInput, ValueError):  # moments of no body
            yield words, with_body(scene, (x, y, z), body.weight)
    if scene.columns[3:] and "quaternion" in scene.source:
        start = integrated(scene, [Fraction(0)])
        if start is not None and start.attitude is not None:
            a, b, c, d = start.attitude[0]
            rotated = _with_attitude(scene, (d, a, b, c))
            yield "the scene's quaternion taken as scalar-last", rotated


def with_body(scene: Scene, inertia: Matrix, weight: Exact | None = None) -> Scene:
    """The scene of another inertia, and of another weight unless it is None."""
    weight = scene.body.weight if weight is None else weight
    return replace(scene, body=scene.body.replaced(inertia=inertia, weight=weight))


def _with_attitude(scene: Scene, quaternion: Sequence[float]) -> Scene:
    """The scene from another attitude, a quaternion, scalar first."""
    (matrix,) = matrices(np.array([quaternion]))
    x, y = matrix[0, 2], -matrix[1, 2]  # the sine of theta times those of psi
    if math.hypot(x, y) < _POLE:
        x, y = matrix[1, 0], matrix[0, 0]
    gamma = exact_vector([float(z) for z in matrix[2]])
    return replace(scene, gamma=gamma, psi=Fraction(math.atan2(x, y)), normalise=True)


# --- conventions ----------------------------------------------------------------------------------
#
# What a table that is wrong may mean: the usual other conventions, tried together.
#
# A table is held against the scene's motion at the times as they stand and, where it is not right
# there, against other worlds (:mod:`worlds`). In each of them each part is tried in all its
# conventions (:mod:`ways`), by one measure: the digits of its first rows (:mod:`evidence`). What
# a program loses later is its drift, and is reported in the reading that fits.


class _Part(NamedTuple):
    """A part of a table in a world: its plainest way of the best, whether that tells anything.

    ``plain``: the way as it stands.  ``goes``: whether the best one goes with the motion.
    """

    best: Way
    plain: Way
    is_told: bool
    goes: bool

    @property
    def way(self) -> Way:
        """The way to read it."""
        return self.best if self.is_told else self.plain

    @property
    def way_course(self) -> Doubles:
        """The digits that count in the way to read it."""
        return course(self.way.rows, self.way.fitted)

    @property
    def course(self) -> Doubles:
        """The digits that count at each row, of the best way."""
        return course(self.best.rows, self.best.fitted)


class View(NamedTuple):
    """The parts of a table of which every number is there, in the rows that tell, as doubles.

    ``right``: the scene's motion at the times as they stand; None where it is not known there.
    ``parts``: what each part is beside it.
    """

    values: dict[str, Doubles]
    times: list[Fraction]
    right: Right | None
    parts: dict[str, _Part]

    @property
    def is_right(self) -> bool:
        """Whether all parts are right as they stand, in all rows."""
        return all(part.plain.digits >= WRONG for part in self.parts.values())

    @property
    def readings(self) -> list[Reading]:
        """Of each part that is wrong the convention that makes its first rows right, if any."""
        return [
            _reading(k, part.plain, part.way, self.times)
            for k, part in self.parts.items()
            if part.is_told
        ]

    def readings_in(self, world: World) -> list[Reading]:
        """Of each part that is wrong its convention in another scene's world."""
        return [
            _reading(k, here.plain, there.way, self.times, world.words)
            for k, there in _parts(self.values, world.right, world.words).items()
            if (here := self.parts[k]).plain.digits < WRONG
            and (there.is_told or not is_alike(here.course, there.way_course))
        ]


def view(subject: Table, reference: AnyReference) -> View:
    """A table beside the motion of a reference."""
    values, times = whole_parts(subject)
    right = _motion(reference, times)
    return View(values, times, right, _parts(values, right))


def _motion(reference: AnyReference, times: Sequence[Fraction]) -> Right | None:
    """The reference's motion with its attitude; a run in double tells what is enclosed, whose proof
    may have far to go."""

    def asked(question: Callable[..., Any]) -> Any:
        try:
            return np.array([[float(x) for x in row] for row in question(times, 18)])
        except (TypeError, ValueError):  # no closed form for it, a pole
            return None

    run = integrated(reference.scene, times) if reference.encloses_attitude else None
    if isinstance(reference, Certified):
        return run
    states = asked(reference.at)
    if states is None:
        return None
    attitude = run and run.attitude if reference.encloses_attitude else asked(reference.attitude)
    return Right(states, attitude, None if attitude is None else matrices(attitude))


def other_world(seen_table: View, subject: Table, scene: Scene) -> World | None:
    """The world in which a table that is wrong is right in its first rows; None where none is.

    The one that explains most, the first of those that are alike.
    """
    world_found, best = None, seen_table.parts
    if all(part.way.digits >= WRONG for part in best.values()):
        return None
    for world in other_worlds(seen_table.times, subject.times, scene):
        parts = _parts(seen_table.values, world.right, world.words)
        if _is_better_world(parts, best):
            world_found, best = world, parts
            if all(part.goes and part.way.digits >= SURE for part in parts.values()):
                break  # in all its rows: the others are farther away
    return world_found


def is_explained(parts: Mapping[str, _Part]) -> bool:
    """Whether the first rows of all parts are right, as they stand or in another convention."""
    return all(
        part.is_told or float(np.min(first_rows(part.plain.rows))) >= WRONG
        for part in parts.values()
    )


def _parts(values: Mapping[str, Doubles], right: Right | None, words: str = "") -> dict[str, _Part]:
    """Parts in a world, each in its best convention; of a motion that is not known as they stand.

    ``words``: of the world, empty for the scene's motion at the times as they stand.
    """
    if right is None:
        nothing = {k: Way("", np.zeros(len(rows))) for k, rows in values.items()}
        return {k: _Part(plain_way, plain_way, False, False) for k, plain_way in nothing.items()}
    count = len(right.states)
    parts = {k: _part(k, rows[:count], right, bool(words)) for k, rows in values.items()}
    return _with_same_axes({k: part for k, part in parts.items() if part is not None})


def _part(part: str, values: Doubles, right: Right, must_move: bool) -> _Part | None:
    """The best way of a part; the plain one, where no other tells more or the part is right."""
    tried = ways(part, values, right)
    plain = next(tried, None)
    if plain is None:
        return None
    moved = right.moved(part)
    if plain.digits >= WRONG:
        goes = not must_move or follows(course(plain.rows), moved, False, True, False)
        return _Part(plain, plain, False, goes)
    all_ways = [plain, *tried]
    own = course(plain.rows)
    parts: list[_Part] = []
    for fitted in (False, True):
        courses = [(x, course(x.rows, fitted)) for x in all_ways if x.fitted == fitted]
        if not courses:
            continue
        most = max((digits for _, digits in courses), key=lambda digits: float(np.sum(digits)))
        best, mine = next(pair for pair in courses if is_alike(pair[1], most))
        alike = sum(is_sure(digits) for _, digits in courses)
        is_told = best.is_unit_alone or alike <= ALIKE_AT_START[part]
        sure = is_told and not (fitted or best.words.startswith(SCALAR_FIRST))
        goes = follows(mine, moved, best.fitted, must_move, sure)
        is_told = goes and is_better(mine, own, least_gain(best.tries, FREEDOM[part]))
        parts.append(_Part(best, plain, is_told, goes))
    named = parts[0]
    if parts[-1].is_told and is_better(parts[-1].course, named.way_course, LEAST_GAIN):
        named = parts[-1]
    return named


def _with_same_axes(parts: dict[str, _Part]) -> dict[str, _Part]:
    """Parts of which gamma or omega, in axes that the other one tells, needs to tell less."""
    for name, partner in (("gamma", "omega"), ("omega", "gamma")):
        mine, its = parts.get(name), parts.get(partner)
        if mine is None or its is None or mine.is_told or not its.is_told or not mine.goes:
            continue
        own, theirs = mine.best.change, its.best.change
        if own is None or theirs is None or own.order != theirs.order:
            continue
        same = own.signs in (theirs.signs, tuple(-s for s in theirs.signs))  # omega: a pseudovector
        if same and is_better(mine.course, course(mine.plain.rows), LEAST_GAIN):
            parts[name] = mine._replace(is_told=True)
    return parts


def _is_better_world(parts: Mapping[str, _Part], rival: Mapping[str, _Part]) -> bool:
    """Whether all parts begin right, all together have more digits, and some have far more."""
    if parts.keys() != rival.keys():
        return False
    both = {}
    for k, part in parts.items():
        count = min(len(part.course), len(rival[k].course))
        both[k] = part.course[:count], rival[k].course[:count]
    far = [k for k, pair in both.items() if is_better(*pair, FAR_GAIN)]
    return (
        bool(far)
        and sum(float(np.sum(mine - its)) for mine, its in both.values()) > 0
        and all(float(mine[0]) >= BEGINS for mine, _ in both.values())
        and all(parts[k].goes for k in far)
    )


def _reading(
    part: str, plain: Way, convention: Way, times: Sequence[Fraction], world: str = ""
) -> Reading:
    """A part as it is read; ``plain``: as it stands.  ``world``: the words of another scene, if
    ``convention`` is one of that scene's motion."""
    words = ", ".join(filter(None, (world, convention.words)))
    change, how = (None, "right with") if world else (convention.change, "read as")
    rows = shown_rows(convention, times)
    return Reading(part, plain.digits, words, convention.digits, change, rows, how)


def shown_rows(convention: Way, times: Sequence[Fraction]) -> tuple[tuple[Fraction, float], ...]:
    """Times with the digits of a way there: the first row, one on the way, the last one."""
    # a row that is fitted is right for nothing
    first, last = int(convention.fitted), len(times) - 1
    middle = min(range(first, last + 1), key=lambda k: abs(abs(times[k]) - abs(times[last]) / 4))
    return tuple((times[k], float(convention.rows[k])) for k in sorted({first, middle, last}))


def whole_parts(subject: Table) -> tuple[dict[str, Doubles], list[Fraction]]:
    """The parts that have all their numbers in some rows, as doubles, in those of the rows that
    tell; their times."""
    parts, common = [], {*range(len(subject.times))}
    for part, names in PARTS.items():
        if rows := common.intersection(subject.whole_rows(names)):
            parts.append(part)
            common = rows
    whole = sorted(common)
    some = subject.some([whole[k] for k in probed_rows([subject.times[k] for k in whole])])
    return {part: doubles(some.rows(PARTS[part]) or []) for part in parts}, [*some.times]
