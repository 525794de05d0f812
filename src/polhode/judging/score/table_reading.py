"""How a table is read that is wrong as it stands: told by some of its rows, before it is judged.

Its times may have another unit or another beginning; each part another convention.
All of that is found from a few rows (:func:`polhode.judging.diagnosis.evidence.probed_rows`); the
rows of very many that a file has are then judged once, as they are read.
"""

from __future__ import annotations

import math
from dataclasses import replace

from polhode.judging.diagnosis.conventions import View, is_explained, other_world, view
from polhode.judging.diagnosis.other_times import clock_remark
from polhode.judging.diagnosis.told_readings import at_times_told
from polhode.judging.references.reference import AnyReference
from polhode.judging.tables.attitude_forms import lengths, of_length_one
from polhode.judging.tables.reading import LENGTH, Reading
from polhode.judging.tables.table import Table
from polhode.scenes.vocabulary import ATTITUDE


def as_meant(subject: Table, against: AnyReference) -> tuple[Table, tuple[Reading, ...]]:
    """A table in the conventions in which its wrong parts begin right, where some do; and the
    readings that are told and not applied."""
    seen = view(subject, against)
    if seen.is_right:
        return with_unit_quaternions(subject, seen), ()
    world = other_world(seen, subject, against.scene)
    if world is not None and world.change is None:
        return with_unit_quaternions(subject, seen), tuple(seen.readings_in(world))
    if world is not None and world.change is not None:
        subject, seen = at_times_told(subject, seen, against, world.words, world.change)
    elif not is_explained(seen.parts):
        remarks = (*subject.remarks, *clock_remark(subject, against.scene))
        subject = replace(subject, remarks=remarks)
    subject = with_unit_quaternions(subject, seen)
    applied = [one for one in seen.readings if one.change is not None]
    return subject.read_as(applied), tuple(one for one in seen.readings if one.change is None)


def with_unit_quaternions(subject: Table, seen: View) -> Table:
    """A table whose quaternions are of length 1, if they have another one."""
    attitude = subject.rows(ATTITUDE)
    found = None if attitude is None else lengths(attitude)
    if attitude is None or found is None:
        return subject
    unit = [of_length_one(row, subject.number.bits) for row in attitude]
    before = max(0.0, -math.log10(max(abs(x - 1) for x in found)))
    now = seen.parts["attitude"].plain.digits if "attitude" in seen.parts else 0.0
    reading = Reading("attitude", before, LENGTH, now)
    subject = subject.with_rows(ATTITUDE, unit)
    return replace(subject, readings=(*subject.readings, reading))
