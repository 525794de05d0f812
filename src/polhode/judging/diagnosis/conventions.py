"""What a table that is wrong may mean: the usual other conventions, tried together.

Each part is tried in all its conventions, at the times as they stand and at times that are a step
off, run backward, begin elsewhere or have another unit, and against scenes with a sign or an order
of numbers that is often another.  The first rows tell which one it is (:mod:`evidence`): what a
program loses later is its drift, and is reported in the reading that fits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.diagnosis.evidence import (
    BEGINS,
    FAR_GAIN,
    LEAST_GAIN,
    course,
    follows,
    is_alike,
    is_better,
    is_sure,
    least_gain,
    probed_rows,
)
from polhode.judging.diagnosis.motion_in_double import integrated
from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.diagnosis.time_unit import UNITS
from polhode.judging.diagnosis.ways import (
    ALIKE_AT_START,
    FREEDOM,
    LEAST_ROWS,
    SCALAR_FIRST,
    Right,
    Way,
    ways,
)
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import AnyReference
from polhode.judging.tables.reading import WRONG, Reading, TimeChange
from polhode.judging.tables.table import PARTS, Table
from polhode.numbers.conversion import doubles, to_double
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Doubles
from polhode.numbers.vectors import Matrix
from polhode.scenes.body import Body, exact_vector
from polhode.scenes.scene import Scene

_FARTHEST = 3e3  # radians or so, to which times of another unit are tried
_POLE = 1e-9  # the sine of theta where psi and phi are one angle


class _World(NamedTuple):
    """What a table may be a motion of: the scene at its times, at other times, or another scene.

    ``words``: what it is called, empty for the plain one.  ``times``: what makes the times its own.
    ``is_applied``: whether a table can be read so.
    """

    words: str
    right: Right
    times: TimeChange | None = None
    is_applied: bool = True


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


def readings(
    subject: Table,
    reference: AnyReference,
    wrong: Collection[str],
) -> list[Reading]:
    """For each part that is wrong, the convention that makes it right in its first rows, if any.

    ``wrong``: which of omega, gamma, attitude and angles are, or may be.
    """
    parts, times, right = probe(subject, reference)
    if right is None or not parts.keys() & {*wrong}:
        return []
    first = _World("", right)

    def seen(world: _World) -> dict[str, _Part]:
        found = {k: _part(k, values, world, k in wrong) for k, values in parts.items()}
        return _with_same_axes({k: one for k, one in found.items() if one is not None})

    plain = seen(first)
    world, best = first, plain
    if not _explains(plain):
        for other in _other_worlds(subject, reference.scene, times):
            found = seen(other)
            if found.keys() == plain.keys() and _is_better_world(found, best):
                world, best = other, found
    return [
        _reading(k, plain[k].plain, best[k].way, world, times)
        for k in best
        if k in wrong and (best[k].is_told or not is_alike(plain[k].course, best[k].course))
    ]


def _part(part: str, values: Doubles, world: _World, is_wrong: bool) -> _Part | None:
    """The best way of a part; the plain one, where no other tells more or the part is right."""
    tried = ways(part, values, world.right)
    plain = next(tried, None)
    if plain is None:
        return None
    moved = world.right.moved(part)
    if not is_wrong or plain.digits >= WRONG:
        goes = not world.words or follows(course(plain.rows), moved, False, True, False)
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
        goes = follows(mine, moved, best.fitted, bool(world.words), sure)
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


def _explains(parts: Mapping[str, _Part]) -> bool:
    """Whether all parts are right in all rows."""
    return all(one.way.digits >= WRONG for one in parts.values())


def _is_better_world(found: Mapping[str, _Part], other: Mapping[str, _Part]) -> bool:
    """Whether all parts begin right, all together have more digits, and some have far more."""
    mine = {k: one.course for k, one in found.items()}
    more = {k: float(np.sum(one - other[k].course)) for k, one in mine.items()}
    far = [k for k, one in mine.items() if is_better(one, other[k].course, FAR_GAIN)]
    return (
        bool(far)
        and sum(more.values()) > 0
        and all(float(one[0]) >= BEGINS for one in mine.values())
        and all(found[k].goes for k in far)
    )


def _reading(part: str, plain: Way, way: Way, world: _World, times: Sequence[Fraction]) -> Reading:
    """A part as it is read in a world."""
    words = ", ".join(filter(None, (world.words, way.words)))
    change = way.change if world.is_applied else None
    told = shown_rows(way, times)
    how = "read as" if world.is_applied else "right with"
    return Reading(part, plain.digits, words, way.digits, change, world.times, told, how)


def shown_rows(way: Way, times: Sequence[Fraction]) -> tuple[tuple[Fraction, float], ...]:
    """Times with the digits of a way there: the first row, one on the way, the last one."""
    first, last = int(way.fitted), len(times) - 1  # a row that is fitted is right for nothing
    middle = min(range(first, last + 1), key=lambda k: abs(abs(times[k]) - abs(times[last]) / 4))
    return tuple((times[k], float(way.rows[k])) for k in sorted({first, middle, last}))


def _other_worlds(subject: Table, scene: Scene, times: Sequence[Fraction]) -> Iterator[_World]:
    """The motion at other times, and those of other scenes that may be meant."""
    if len(times) >= LEAST_ROWS:
        for words, change in other_times(subject, scene):
            right = integrated(scene, [change.of(t) for t in times])
            if right is not None:
                yield _World(words, right, change)
    for words, other in _other_scenes(scene):
        right = integrated(other, times)
        if right is not None:
            yield _World(words, right, is_applied=False)


def _other_scenes(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Scenes with a sign or an order of numbers that is often another."""
    body = scene.body
    if body.weight:
        yield "a weight of the other sign", _with_body(scene, body.inertia, -body.weight)
    products = [(i, j) for i in range(3) for j in range(i) if body.inertia[i][j] != 0]
    some = [products, *([one] for one in products)] if len(products) > 1 else [products]
    for signs in filter(None, some):
        x, y, z = (
            exact_vector([-m if {(i, j), (j, i)} & {*signs} else m for j, m in enumerate(row)])
            for i, row in enumerate(body.inertia)
        )
        names = ", ".join("I" + "xyz"[j] + "xyz"[i] for i, j in signs)
        words = f"products of inertia of the other sign ({names})"
        with suppress(BadInput, ValueError):  # moments of no body
            yield words, _with_body(scene, (x, y, z), body.weight)
    if scene.columns[3:] and "quaternion" in scene.source:
        start = integrated(scene, [Fraction(0)])
        if start is not None and start.attitude is not None:
            a, b, c, d = start.attitude[0]
            turned = _with_attitude(scene, (d, a, b, c))
            yield "the scene's quaternion taken as scalar-last", turned


def _with_body(scene: Scene, inertia: Matrix, weight: Exact) -> Scene:
    body = Body(inertia, scene.body.centre, weight)
    return replace(scene, body=body)


def _with_attitude(scene: Scene, given: Sequence[float]) -> Scene:
    """The scene from another attitude, a quaternion, scalar first."""
    (turned,) = matrices(np.array([given]))
    x, y = turned[0, 2], -turned[1, 2]  # the sine of theta times those of psi
    if math.hypot(x, y) < _POLE:
        x, y = turned[1, 0], turned[0, 0]
    gamma = exact_vector([float(z) for z in turned[2]])
    return replace(scene, gamma=gamma, psi=Fraction(math.atan2(x, y)), normalise=True)


def other_times(
    subject: Table, scene: Scene, far: bool = False
) -> Iterator[tuple[str, TimeChange]]:
    """Times at which the rows may hold instead: a step off, backward, from another beginning.

    ``far``: in other units, too, that make the last time one that is far.
    """
    first = subject.times[0]
    for sign, word in ((1, "late"), (-1, "early")):
        for second in subject.times[1:2]:
            yield f"one step of t {word}", TimeChange(shift=sign * (second - first))
    if first != 0:
        yield f"t from {float(first):.6g} on", TimeChange(shift=first)
    yield "t of the other sense", TimeChange(sign=-1)
    if first != 0:
        yield "t of the other sense, from its first row on", TimeChange(-1, shift=-first)
    speed = max([1e-300, *(abs(to_double(x)) for x in scene.start[:3])])
    farthest = max(abs(to_double(t)) for t in subject.times)
    for unit in UNITS:
        if far or farthest * float(unit.length) * speed < _FARTHEST:
            yield f"t {unit.name}", TimeChange(unit=unit.length)


class Probe(NamedTuple):
    """The parts of a table of which every number is there, as doubles, in the rows that tell.

    ``right``: what the reference has at their times, or at those that are told of; None where it
    gives no states.
    """

    parts: dict[str, Doubles]
    times: list[Fraction]
    right: Right | None

    @property
    def digits(self) -> dict[str, float]:
        """The fewest digits of each part as it stands, where the motion is known."""
        if self.right is None:
            return {}
        plain = {k: next(ways(k, values, self.right), None) for k, values in self.parts.items()}
        return {k: way.digits for k, way in plain.items() if way is not None}


def probe(subject: Table, reference: AnyReference, moved: TimeChange | None = None) -> Probe:
    """The rows of a table that tell, beside the motion.

    ``moved``: where the times are not those of the table, a run in double tells them.
    """
    parts, times = whole_parts(subject)
    if not parts:
        return Probe(parts, times, None)
    if moved is not None or isinstance(reference, Certified):  # whose proof may have far to go
        at = times if moved is None else [moved.of(t) for t in times]
        return Probe(parts, times, integrated(reference.scene, at))

    def asked(question: Callable[..., Any]) -> Any:
        try:
            return np.array([[float(x) for x in row] for row in question(times, 18)])
        except (TypeError, ValueError):  # no closed form for it, a pole
            return None

    states, attitude = asked(reference.at), asked(reference.attitude)
    turned = None if attitude is None else matrices(attitude)
    return Probe(parts, times, None if states is None else Right(states, attitude, turned))


def whole_parts(subject: Table) -> tuple[dict[str, Doubles], list[Fraction]]:
    """The parts of which every number is there, as doubles, in the rows that tell; their times."""
    some = subject.some(probed_rows(subject.times))
    found = {part: doubles(rows) for part, names in PARTS.items() if (rows := some.rows(names))}
    whole = {part: values for part, values in found.items() if not np.isnan(values).any()}
    return whole, [*some.times]
