"""A table read in other conventions: the changes of readings applied to its rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from polhode.judging.tables.candidate import Subject
from polhode.judging.tables.reading import Reading
from polhode.numbers.conversion import exactly


def as_read(subject: Subject, readings: Sequence[Reading]) -> Subject:
    """A subject whose parts are read so, as far as readings can be applied."""
    for reading in readings:
        part, change = reading.part, reading.change
        if change is None:
            continue
        if part == "attitude" and subject.attitude is not None:
            subject = replace(subject, attitude=[change.row([*row]) for row in subject.attitude])
        elif part == "angles" and subject.angles is not None and change.order:
            subject = replace(subject, angles=[change.row([*row]) for row in subject.angles])
        elif part in ("omega", "gamma") and subject.states is not None and change.order:
            place = slice(0, 3) if part == "omega" else slice(3, 6)
            states = [[None if x is None else exactly(x) for x in row] for row in subject.states]
            for row in states:
                row[place] = change.row(row[place])
            subject = replace(subject, states=states)
    moved = next((one.times for one in readings if one.times is not None), None)
    if moved is not None:
        subject = subject.at_other_times(moved)
    return replace(subject, readings=(*subject.readings, *readings))
