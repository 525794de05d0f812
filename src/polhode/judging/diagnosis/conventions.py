"""What a table that is wrong everywhere may mean: the usual other conventions, tried together.

Each part is tried in all its conventions at the times as they stand; where that does not explain
every wrong part, at times that are a step off, run backward, begin elsewhere or have another unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from polhode.common.text_tables import few
from polhode.judging.diagnosis.motion_in_double import integrated
from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.diagnosis.time_unit import UNITS
from polhode.judging.diagnosis.ways import LEAST_ROWS, Right, Way, as_it_stands, ways
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import Reference, Remembered, rows
from polhode.judging.tables.candidate import Subject
from polhode.judging.tables.reading import GAIN, WRONG, Reading, TimeChange
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene

AnyReference: TypeAlias = Reference | Certified | Remembered

MOST_ROWS = 40  # looked at
_AS_GOOD = 1.0  # digits by which a plainer convention may be behind the best
_FARTHEST = 3e3  # radians or so, to which times of another unit are tried


def readings(
    subject: Subject,
    reference: AnyReference,
    wrong: Collection[str],
) -> list[Reading]:
    """For each part that is wrong, the convention that makes most of it right, if one does.

    ``wrong``: which of omega, gamma, attitude and angles are, or may be.
    """
    parts, times = whole_parts(subject)
    whole = {k: part for k, part in parts.items() if k in wrong}
    right = right_at(reference, times) if whole else None
    if right is None:
        return []
    plain = {part: as_it_stands(part, values, right) for part, values in whole.items()}
    found = _read(whole, plain, right)
    if found and _explains(found, plain):
        return found
    if len(times) >= LEAST_ROWS:
        for words, change in other_times(subject, reference.scene):
            moved = integrated(reference.scene, [change.of(t) for t in times])
            there = [] if moved is None else _read(whole, plain, moved, words, change)
            if there and _explains(there, plain):
                return there
    return found or _other_weight(whole, plain, reference.scene, times)


def _explains(found: Sequence[Reading], plain: dict[str, float | None]) -> bool:
    """Whether readings make all the parts right that are wrong as they stand."""
    wrong = {part for part, digits in plain.items() if digits is not None and digits < WRONG}
    return wrong <= {reading.part for reading in found}


def _read(
    whole: dict[str, Doubles],
    plain: dict[str, float | None],
    right: Right,
    words: str = "",
    times: TimeChange | None = None,
) -> list[Reading]:
    """Readings of the parts, at other times where these are given."""
    found = []
    for part, values in whole.items():
        before = plain[part]
        if before is None or before >= WRONG:
            continue
        best = _plainest(part, values, right, times is not None)
        if best is not None and best.digits >= before + GAIN:
            told = ", ".join(filter(None, (words, best.words)))
            found.append(Reading(part, before, told, best.digits, best.change, times))
    return found


def _plainest(part: str, values: Doubles, right: Right, stands: bool) -> Way | None:
    """The first way that is nearly as good as the best; ``stands``: the plain one is one, too."""
    found = [*ways(part, values, right)][0 if stands else 1 :]
    best = max((way.digits for way in found), default=0.0)
    return next((way for way in found if way.digits >= best - _AS_GOOD), None)


def other_times(
    subject: Subject, scene: Scene, far: bool = False
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


def _other_weight(
    whole: dict[str, Doubles],
    plain: dict[str, float | None],
    scene: Scene,
    times: Sequence[Fraction],
) -> list[Reading]:
    """Readings as the same body's motion under a weight of the other sign, told alone."""
    if not scene.body.weight:
        return []
    body = replace(scene.body, weight=-scene.body.weight)
    right = integrated(replace(scene, body=body), times)
    change = TimeChange()  # the plain convention is one, too
    words = "a weight of the other sign"
    found = [] if right is None else _read(whole, plain, right, words, change)
    told = [reading._replace(change=None, times=None) for reading in found]
    return told if told and _explains(told, plain) else []


def right_at(
    reference: AnyReference, times: Sequence[Fraction], moved: TimeChange | None = None
) -> Right | None:
    """The reference's states and attitudes at these times; None where it gives no states.

    ``moved``: where the times are not those of the table, a run in double tells them.
    """
    if moved is not None or isinstance(reference, Certified):  # whose proof may have far to go
        return integrated(reference.scene, times)

    def asked(question: Callable[..., Any]) -> Any:
        try:
            return np.array([[float(x) for x in row] for row in rows(question, times, 18)])
        except (TypeError, ValueError):  # no closed form for it, a pole
            return None

    states, attitude = asked(reference.at), asked(reference.attitude)
    if states is None:
        return None
    return Right(states, attitude, None if attitude is None else matrices(attitude))


def whole_parts(subject: Subject) -> tuple[dict[str, Doubles], list[Fraction]]:
    """The parts of which every number is there, as doubles, at some of the times; and these."""
    kept = few(len(subject.times), MOST_ROWS)

    def doubles(part: Any) -> Any:
        if part is None:
            return None
        values = [[math.nan if x is None else to_double(exactly(x)) for x in part[k]] for k in kept]
        found = np.array(values, dtype=float)
        return None if np.isnan(found).any() else found

    found: dict[str, Any] = {}
    if subject.columns:
        for name, columns in (("omega", slice(0, 3)), ("gamma", slice(3, 6))):
            values = doubles([row[columns] for row in subject.states])
            if values is not None and values.shape[1] == 3:
                found[name] = values
    for name in ("attitude", "angles"):
        values = doubles(getattr(subject, name))
        if values is not None:
            found[name] = values
    return found, [subject.times[k] for k in kept]
