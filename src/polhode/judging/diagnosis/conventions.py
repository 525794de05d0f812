"""What a table that is wrong may mean: the usual other conventions, tried together.

A table is held against the scene's motion at the times as they stand and, where it is not right
there, against other worlds (:mod:`worlds`).  In each of them each part is tried in all its
conventions (:mod:`ways`), by one measure: the digits of its first rows (:mod:`evidence`).  What a
program loses later is its drift, and is reported in the reading that fits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.judging.diagnosis.evidence import (
    BEGINS,
    FAR_GAIN,
    LEAST_GAIN,
    SURE,
    course,
    first_rows,
    follows,
    is_alike,
    is_better,
    is_sure,
    least_gain,
    probed_rows,
)
from polhode.judging.diagnosis.motion_in_double import integrated
from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.diagnosis.ways import (
    ALIKE_AT_START,
    FREEDOM,
    SCALAR_FIRST,
    Right,
    Way,
    ways,
)
from polhode.judging.diagnosis.worlds import World, other_worlds
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import AnyReference
from polhode.judging.tables.reading import WRONG, Reading
from polhode.judging.tables.table import PARTS, Table
from polhode.numbers.conversion import doubles
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene


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
        return all(one.plain.digits >= WRONG for one in self.parts.values())

    @property
    def readings(self) -> list[Reading]:
        """Of each part that is wrong the convention that makes its first rows right, if any."""
        return [
            _reading(k, one.plain, one.way, self.times)
            for k, one in self.parts.items()
            if one.is_told
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


def other_world(seen: View, subject: Table, scene: Scene) -> World | None:
    """The world in which a table that is wrong is right in its first rows; None where none is.

    The one that explains most, the first of those that are alike.
    """
    found, best = None, seen.parts
    if all(one.way.digits >= WRONG for one in best.values()):
        return None
    for world in other_worlds(seen.times, subject.times, scene):
        parts = _parts(seen.values, world.right, world.words)
        if _is_better_world(parts, best):
            found, best = world, parts
            if all(one.goes and one.way.digits >= SURE for one in parts.values()):
                break  # in all its rows: the others are farther away
    return found


def is_explained(parts: Mapping[str, _Part]) -> bool:
    """Whether the first rows of all parts are right, as they stand or in another convention."""
    return all(
        one.is_told or float(np.min(first_rows(one.plain.rows))) >= WRONG for one in parts.values()
    )


def _parts(values: Mapping[str, Doubles], right: Right | None, words: str = "") -> dict[str, _Part]:
    """Parts in a world, each in its best convention; of a motion that is not known as they stand.

    ``words``: of the world, empty for the scene's motion at the times as they stand.
    """
    if right is None:
        nothing = {k: Way("", np.zeros(len(rows))) for k, rows in values.items()}
        return {k: _Part(way, way, False, False) for k, way in nothing.items()}
    count = len(right.states)
    found = {k: _part(k, rows[:count], right, bool(words)) for k, rows in values.items()}
    return _with_same_axes({k: one for k, one in found.items() if one is not None})


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
    seen: list[_Part] = []
    for fitted in (False, True):
        found = [(way, course(way.rows, fitted)) for way in all_ways if way.fitted == fitted]
        if not found:
            continue
        most = max((one for _, one in found), key=lambda one: float(np.sum(one)))
        best, mine = next(pair for pair in found if is_alike(pair[1], most))
        alike = sum(is_sure(one) for _, one in found)
        told = best.is_unit_alone or alike <= ALIKE_AT_START[part]
        sure = told and not (fitted or best.words.startswith(SCALAR_FIRST))
        goes = follows(mine, moved, best.fitted, must_move, sure)
        told = goes and is_better(mine, own, least_gain(best.tries, FREEDOM[part]))
        seen.append(_Part(best, plain, told, goes))
    named = seen[0]
    if seen[-1].is_told and is_better(seen[-1].course, named.way_course, LEAST_GAIN):
        named = seen[-1]
    return named


def _with_same_axes(parts: dict[str, _Part]) -> dict[str, _Part]:
    """Parts of which gamma or omega, in axes that the other one tells, needs to tell less."""
    for name, other in (("gamma", "omega"), ("omega", "gamma")):
        mine, its = parts.get(name), parts.get(other)
        if mine is None or its is None or mine.is_told or not its.is_told or not mine.goes:
            continue
        own, known = mine.best.change, its.best.change
        if own is None or known is None or own.order != known.order:
            continue
        same = own.signs in (known.signs, tuple(-s for s in known.signs))  # omega: a pseudovector
        if same and is_better(mine.course, course(mine.plain.rows), LEAST_GAIN):
            parts[name] = mine._replace(is_told=True)
    return parts


def _is_better_world(found: Mapping[str, _Part], other: Mapping[str, _Part]) -> bool:
    """Whether all parts begin right, all together have more digits, and some have far more."""
    if found.keys() != other.keys():
        return False
    both = {}
    for k, one in found.items():
        count = min(len(one.course), len(other[k].course))
        both[k] = one.course[:count], other[k].course[:count]
    far = [k for k, pair in both.items() if is_better(*pair, FAR_GAIN)]
    return (
        bool(far)
        and sum(float(np.sum(mine - its)) for mine, its in both.values()) > 0
        and all(float(mine[0]) >= BEGINS for mine, _ in both.values())
        and all(found[k].goes for k in far)
    )


def _reading(
    part: str, plain: Way, way: Way, times: Sequence[Fraction], world: str = ""
) -> Reading:
    """A part as it is read; ``plain``: as it stands.  ``world``: the words of another scene, if
    ``way`` is one of that scene's motion."""
    words = ", ".join(filter(None, (world, way.words)))
    change, how = (None, "right with") if world else (way.change, "read as")
    rows = shown_rows(way, times)
    return Reading(part, plain.digits, words, way.digits, change, rows, how)


def shown_rows(way: Way, times: Sequence[Fraction]) -> tuple[tuple[Fraction, float], ...]:
    """Times with the digits of a way there: the first row, one on the way, the last one."""
    first, last = int(way.fitted), len(times) - 1  # a row that is fitted is right for nothing
    middle = min(range(first, last + 1), key=lambda k: abs(abs(times[k]) - abs(times[last]) / 4))
    return tuple((times[k], float(way.rows[k])) for k in sorted({first, middle, last}))


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
