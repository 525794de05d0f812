"""How a table is read that is wrong as it stands, before it is judged.

Its times may have another unit or another beginning, each part another convention.  All of that is
found from a few rows (:func:`polhode.judging.tables.conventions.probed_rows`); the rows of very
many that a file has are then judged once, as they are read.  Or somebody tells the readings, which
are applied whatever they give: ``omega degrees; attitude scalar-last``.  The words are those that a
judgement prints, and no others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches

from polhode.common.errors import BadInput, listed
from polhode.judging.reference import AnyReference
from polhode.judging.tables.column_aliases import lengths, of_length_one
from polhode.judging.tables.conventions import (
    View,
    is_explained,
    other_world,
    shown_rows,
    view,
)
from polhode.judging.tables.table import LENGTH, Reading, Table, TimeChange, as_judged
from polhode.judging.tables.ways import Way, clock_remark, other_times, ways
from polhode.scenes.vocabulary import ATTITUDE

_APPLIED = "a reading that can be applied; this one is reported, and not applied"


def read_as_told(subject: Table, reference: AnyReference, told: str) -> Table:
    """A table as it is read in readings separated by semicolons, in the words that tell them.

    Raises BadInput for one that is none of the table's.
    """
    if LENGTH in told:
        subject = with_unit_quaternions(subject, view(subject, reference))
    phrases = [" ".join(text.split()) for text in told.split(";") if text.strip()] or [told]
    of_parts: list[str] = []
    for phrase in phrases:
        words = phrase.removeprefix("t ")
        change = None if words == phrase else other_times(subject.times).get(words)
        if change is not None:
            subject, _ = at_times_told(subject, view(subject, reference), reference, words, change)
        elif phrase != f"attitude {LENGTH}":  # applied before
            of_parts.append(phrase)
    return subject.read_as(_readings(subject, reference, of_parts)) if of_parts else subject


def at_times_told(
    subject: Table,
    current: View,
    reference: AnyReference,
    words: str,
    change: TimeChange,
) -> tuple[Table, View]:
    """A table at changed times, with the reading that says so, and how it is seen there.

    ``current``: the table before.
    """
    moved = subject.at_other_times(change)
    there = view(moved, reference)
    before = min((part.plain.digits for part in current.parts.values()), default=None)
    best = min((part.way for part in there.parts.values()), key=lambda x: x.digits, default=None)
    digits, rows = (best.digits, shown_rows(best, there.times)) if best else (None, ())
    reading = Reading("t", before, words, digits, rows=rows)
    return replace(moved, readings=(*moved.readings, reading)), there


def table_as_told(table: Table, reference: AnyReference, words: str) -> Table:
    """A table whose state, angles and attitude are read so; raises BadInput likewise."""
    reread = read_as_told(as_judged(table, reference.scene), reference, words)
    return replace(table, times=reread.times, columns={**table.columns, **reread.columns})


def _readings(subject: Table, reference: AnyReference, phrases: Sequence[str]) -> list[Reading]:
    """Readings of parts, in the words that tell them."""
    sample = view(subject, reference)
    if sample.right is None and sample.parts:
        raise BadInput(subject.name, "read", phrases[0], "numbers that can be followed in double")
    by_phrase: dict[str, tuple[str, Way]] = {}
    digits: dict[str, float] = dict.fromkeys(sample.parts, 0.0)
    for part, values in sample.values.items():
        for convention in ways(part, values, sample.right) if sample.right else ():
            if convention.words:
                by_phrase.setdefault(f"{part} {convention.words}", (part, convention))
            else:
                digits[part] = convention.digits
    readings: dict[str, Reading] = {}
    for phrase in phrases:
        if phrase not in by_phrase:
            raise BadInput(subject.name, "read", phrase, _possible(phrase, by_phrase, subject))
        part, convention = by_phrase[phrase]
        if convention.change is None or part in readings:
            expected = f"no second reading of {part}" if convention.change else _APPLIED
            raise BadInput(subject.name, "read", phrase, expected)
        words = phrase.removeprefix(f"{part} ")
        rows = shown_rows(convention, sample.times)
        readings[part] = Reading(
            part, digits[part], words, convention.digits, convention.change, rows=rows
        )
    return [*readings.values()]


def _possible(phrase: str, by_phrase: Mapping[str, tuple[str, Way]], subject: Table) -> str:
    """Readings that a table may have, of those that rename axes only the nearest ones."""
    applied = [
        words for words, (_, convention) in by_phrase.items() if convention.change is not None
    ]
    near = get_close_matches(phrase, applied)
    plain = [words for words in applied if "=" not in words and words not in near]
    times = [f"t {words}" for words in other_times(subject.times)]
    return f"readings that this table can have: {listed(phrase, [*near, *plain, *times])}"


def as_meant(subject: Table, against: AnyReference) -> tuple[Table, tuple[Reading, ...]]:
    """A table in the conventions in which its wrong parts begin right, where some do; and the
    readings that are told and not applied."""
    current = view(subject, against)
    if current.is_right:
        return with_unit_quaternions(subject, current), ()
    world = other_world(current, subject, against.scene)
    if world is not None and world.change is None:
        return with_unit_quaternions(subject, current), tuple(current.readings_in(world))
    if world is not None and world.change is not None:
        subject, current = at_times_told(subject, current, against, world.words, world.change)
    elif not is_explained(current.parts):
        remarks = (*subject.remarks, *clock_remark(subject, against.scene))
        subject = replace(subject, remarks=remarks)
    subject = with_unit_quaternions(subject, current)
    applied = [reading for reading in current.readings if reading.change is not None]
    return subject.read_as(applied), tuple(
        reading for reading in current.readings if reading.change is None
    )


def with_unit_quaternions(subject: Table, current: View) -> Table:
    """A table whose quaternions are of length 1, if they have another one."""
    attitude = subject.rows(ATTITUDE)
    sizes = None if attitude is None else lengths(attitude)
    if attitude is None or sizes is None:
        return subject
    unit = [of_length_one(row, subject.number.bits) for row in attitude]
    before = max(0.0, -math.log10(max(abs(x - 1) for x in sizes)))
    now = current.parts["attitude"].plain.digits if "attitude" in current.parts else 0.0
    reading = Reading("attitude", before, LENGTH, now)
    subject = subject.with_rows(ATTITUDE, unit)
    return replace(subject, readings=(*subject.readings, reading))
