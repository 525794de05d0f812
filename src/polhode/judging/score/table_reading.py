"""How a table is read that is wrong as it stands: told by some of its rows, before it is judged.

Its times may have another unit, another beginning or another clock; each part another convention.
All of that is found from one probe (:func:`polhode.judging.diagnosis.evidence.probed_rows`); the
rows of very many that a file has are then judged once, as they are read.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from polhode.common.errors import BadInput
from polhode.judging.clock import clock, unknown_clock
from polhode.judging.diagnosis.conventions import probe, readings
from polhode.judging.diagnosis.evidence import probed_rows
from polhode.judging.diagnosis.motion_in_double import integrated
from polhode.judging.diagnosis.time_unit import begins_at_start, time_unit
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import AnyReference
from polhode.judging.score.judgement import Judgement
from polhode.judging.tables.attitude_forms import lengths, of_length_one
from polhode.judging.tables.reading import GAIN, LENGTH, WRONG, Reading, TimeChange
from polhode.judging.tables.table import PARTS, Table
from polhode.numbers.conversion import doubles
from polhode.numbers.decimals import brief
from polhode.scenes.vocabulary import ATTITUDE

_FIRST = 5  # rows that tell whether the times are others


def as_meant(subject: Table, against: AnyReference) -> tuple[Table, tuple[Reading, ...]]:
    """A table in the conventions in which its wrong parts begin right, where some do; and the
    readings that are told and not applied."""
    if _as_they_stand(_probe(subject), against) >= WRONG:
        return with_unit_quaternions(subject, against), ()
    subject = _from_the_start(_in_seconds(subject, against), against)
    subject = with_unit_quaternions(_by_the_clock(subject, against), against)
    found = tuple(readings(subject, against, PARTS))
    applied = [one for one in found if one.change is not None]
    if not applied:
        return subject, found
    other = subject.read_as(applied)
    before, now = (probe(one, against).digits for one in (subject, other))
    read = {one.part for one in applied}
    if any(now.get(k, 0.0) < d - GAIN for k, d in before.items() if k not in read):
        return subject, found
    return other, tuple(one for one in found if one.change is None)


def _probe(subject: Table) -> Table:
    """The rows that tell how a table is meant."""
    return subject.some(probed_rows(subject.times))


def _in_seconds(subject: Table, against: AnyReference) -> Table:
    """A table with the times of its unit, where its first rows are right so alone."""
    unit = time_unit(subject, against.scene)
    if unit is None:
        return subject
    some = [k for k in _earliest(subject, abs) if subject.times[k] != 0]
    return _at_other_times(subject, against, some, TimeChange(unit=unit.length), unit.name)


def _from_the_start(subject: Table, against: AnyReference) -> Table:
    """A table whose earliest row is the scene's start at another time, with times from there on."""
    some = _earliest(subject)
    first = subject.times[some[0]]
    if first == 0 or not begins_at_start(subject, some[0], against.scene):
        return subject
    words = f"from its first row on ({brief(first)})"
    return _at_other_times(subject, against, some, TimeChange(shift=first), words)


def _by_the_clock(subject: Table, against: AnyReference) -> Table:
    """A table with the times of the scene, where its first rows belong to others."""
    some = _earliest(subject)
    rows = subject.some(some)
    plain = _as_they_stand(rows, against)
    if plain >= WRONG or _is_explained(rows, against):
        return subject
    found = clock(rows, against.scene)
    if found is None:
        remark = unknown_clock(subject, against.scene)
        return replace(subject, remarks=(*subject.remarks, *remark))
    moved = subject.at_other_times(found.change, found.off)
    if not found.entire and not _is_explained(moved.some(some), against):
        return subject
    reading = Reading("t", plain, found.words, found.digits)
    return replace(moved, readings=(*subject.readings, reading))


def _earliest(subject: Table, size: Callable[[Fraction], Fraction] | None = None) -> list[int]:
    """The rows with the earliest times, or with those of the least ``size``."""
    times = [*map(size, subject.times)] if size else subject.times
    return sorted(range(len(times)), key=times.__getitem__)[:_FIRST]


def _is_explained(rows: Table, against: AnyReference) -> bool:
    """Whether all parts are right, as they stand or in another convention."""
    seen = probe(rows, against)
    if seen.right is None and seen.parts:
        return False
    wrong = {name for name, d in seen.digits.items() if d < WRONG}
    return wrong <= {one.part for one in readings(rows, against, wrong)}


def with_unit_quaternions(subject: Table, against: AnyReference) -> Table:
    """A table whose quaternions are of length 1, if they have another one."""
    attitude = subject.rows(ATTITUDE)
    found = None if attitude is None else lengths(attitude)
    if attitude is None or found is None:
        return subject
    unit = [of_length_one(row, subject.number.bits) for row in attitude]
    before = max(0.0, -math.log10(max(abs(x - 1) for x in found)))
    digits = probe(subject, against).digits
    reading = Reading("attitude", before, LENGTH, digits.get("attitude", 0.0))
    subject = subject.with_rows(ATTITUDE, unit)
    return replace(subject, readings=(*subject.readings, reading))


def _at_other_times(
    subject: Table, against: AnyReference, some: list[int], change: TimeChange, words: str
) -> Table:
    """A table at changed times, where some of its rows are right so alone."""
    rows = subject.some(some)
    changed = rows.at_other_times(change)
    before = _as_they_stand(rows, against)
    if before >= WRONG:
        return subject
    with suppress(BadInput):
        now = Judgement(changed, against).worst
        if now >= before + GAIN:
            reading = Reading("t", before, words, now)
            moved = subject.at_other_times(change)
            return replace(moved, readings=(*subject.readings, reading))
    return subject


def _as_they_stand(rows: Table, against: AnyReference) -> float:
    """The fewest digits of rows; of a proof, that may have far to go, against a run in double."""
    if isinstance(against, Certified):
        plain = integrated(against.scene, rows.times, attitude=False)
        if plain is None:
            return 0.0
        digits = probe(rows, against).digits
        found = [d for name, d in digits.items() if name in ("attitude", "angles")]
        states = rows.rows(against.scene.columns)
        if states is not None:
            off = np.nanmax(np.abs(doubles(states) - plain.states), initial=1e-16)
            found.append(max(0.0, -math.log10(off)))
        return min(found, default=0.0)
    with suppress(BadInput):
        return Judgement(rows, against).worst
    return 0.0
