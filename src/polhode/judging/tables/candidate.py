"""What is judged, in the terms of a judgement: a run, or a table of whatever origin."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain
from typing import TYPE_CHECKING, Any

from polhode.common.value_semantics import ByValue
from polhode.equations.column import column, derived_words
from polhode.equations.integrals import Drift, drift, drift_of_columns
from polhode.judging.tables.attitude_forms import lengths
from polhode.judging.tables.column_aliases import not_judged
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import to_double, to_mpf
from polhode.numbers.number_types import DOUBLE, NumberType, mp
from polhode.numbers.rows import Given
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, COLUMNS, STATE, column_names

if TYPE_CHECKING:
    from polhode.judging.tables.reading import Reading, TimeChange

MOST_DIGITS = 1000.0  # that are told of a table
MOST_AT_ONCE = 20.0  # of a table whose drift pairs of doubles tell


@dataclass(frozen=True, eq=False)
class Subject(ByValue):
    """A run or a table as a judgement reads it.

    ``number``: the type whose rounding the digits possible are about; of a table without one
    double, or one of as many digits as are printed where those are more than a double's 17.
    ``held``: the most correct digits that can be told.  ``columns``: those of the state that are
    there.  ``states``: rows of all the scene's columns, None where one is not there; ``angles`` and
    ``attitude`` likewise, None where nothing of them is there; ``derived``: the same of derived
    columns, by output.  ``steps``: what is to blame where the method is.  ``printed``: significant
    digits in a table, None of a run.  ``remarks``: how the table was read.  ``readings``:
    conventions that were applied to it.  ``time_errors``: by which the times may be off, rounded;
    empty where they are exact.  ``signless``: whether the quaternion's sign means nothing at any
    time.
    """

    source: Trajectory | Table
    name: str
    number: NumberType
    held: float
    times: tuple[Fraction, ...]
    columns: tuple[str, ...]
    states: Any
    angles: Given | None
    attitude: Given | None
    derived: Mapping[str, Given]
    steps: str
    printed: int | None
    projected: bool
    notes: tuple[str, ...]
    remarks: tuple[str, ...] = ()
    readings: tuple[Reading, ...] = ()
    time_errors: tuple[float, ...] = ()
    signless: bool = False

    def part(self, word: str) -> Given | None:
        """Rows of an output by its word, None where nothing of it is there."""
        return {"angles": self.angles, "attitude": self.attitude, **self.derived}.get(word)

    def some(self, which: Sequence[int]) -> Subject:
        """Some of the rows."""

        def of(rows: Given | None) -> list[Any] | None:
            return None if rows is None else [rows[k] for k in which]

        return replace(
            self,
            times=tuple(self.times[k] for k in which),
            states=of(self.states),
            angles=of(self.angles),
            attitude=of(self.attitude),
            derived={word: [rows[k] for k in which] for word, rows in self.derived.items()},
            time_errors=tuple(self.time_errors[k] for k in which) if self.time_errors else (),
        )

    def at_other_times(self, change: TimeChange, off: float | None = None) -> Subject:
        """The same rows at changed times; ``off``: by how much their origin may be off, as much as
        the first time unless given."""
        times, unit = tuple(change.of(t) for t in self.times), abs(to_double(change.unit))
        errors = [unit * x for x in self.time_errors or [0.0] * len(times)]
        off = (errors[0] if change.shift else 0.0) if off is None else off
        told = tuple(x + off for x in errors) if any(errors) or off else ()
        return replace(self, times=times, time_errors=told)

    @property
    def run(self) -> Trajectory | None:
        """The run, where it is one."""
        return self.source if isinstance(self.source, Trajectory) else None

    def drift(self, scene: Scene, bits: int) -> Drift | str:
        """Drift of the integrals, or why it says nothing."""
        if self.projected:
            return "they were projected"
        if isinstance(self.source, Trajectory):
            return self.source.drift
        if len(self.columns) < len(scene.columns) or _gaps(chain(*self.states)):
            return "a column of the state is missing"
        if self.held <= MOST_AT_ONCE:
            from polhode.numbers.double_double import of_fractions

            with suppress(OverflowError):  # a number beyond doubles
                columns = [of_fractions(x) for x in zip(*self.states, strict=True)]
                if (at_once := drift_of_columns(scene, columns)) is not None:
                    return at_once
        return drift(scene, [[to_mpf(x, bits) for x in row] for row in self.states], bits)


def of_run(run: Trajectory) -> Subject:
    """A run as what is judged."""
    return Subject(
        source=run,
        name=f"{run.scene.name}: {run.number.name} ({run.number.bits} bits)",
        number=run.number,
        held=run.number.most_digits,
        times=tuple(run.times),
        columns=run.columns,
        states=run.states,
        angles=run.angles,
        attitude=run.attitude,
        derived={word: run.outputs[word] for word in judged_words() if word in run.outputs},
        steps="rounding in the steps"
        if run.at_full_tolerance
        else f"tolerance {run.tolerance:.1e}",
        printed=None,
        projected=run.projected,
        notes=(),
    )


def of_table(table: Table, scene: Scene) -> Subject:
    """A table as what is judged: its columns as far as the scene has them."""
    number, there = table.number, table.columns
    notes = [f"column {_quoted(name)} is not known and was not judged" for name in table.ignored]
    unjudged = not_judged()
    notes += [f"column {n} was not judged: {why}" for n, why in unjudged.items() if n in there]
    if not scene.columns[3:]:
        for name in (*STATE[3:], *column_names()):
            if name in there and name not in unjudged:
                notes.append(f"column {name} was not judged: the scene has no gamma")
    columns = tuple(name for name in scene.columns if name in there)
    notes += [f"column {name} is not in the file" for name in scene.columns if name not in there]
    if any(_gaps(there[name]) for name in columns):
        notes.append("empty cells were not judged")
    attitude = table.rows(ATTITUDE) if scene.columns[3:] else None
    yardstick = number or (DOUBLE if table.printed <= DOUBLE.printed_digits else mp(table.printed))
    held = number.most_digits if number else min(table.printed + 2.0, MOST_DIGITS)
    derived = {word: table.rows(COLUMNS[word].names) for word in judged_words()}
    return Subject(
        source=table,
        name=table.name,
        number=yardstick,
        held=min(held, yardstick.most_digits),
        times=table.times,
        columns=columns,
        states=table.rows(scene.columns),
        angles=table.rows(ANGLES) if scene.columns[3:] else None,
        attitude=attitude,
        derived={word: rows for word, rows in derived.items() if rows and scene.columns[3:]},
        steps="steps of the program",
        printed=table.printed,
        projected=table.projected,
        notes=tuple(notes),
        remarks=(*table.remarks, *_length(attitude)),
        time_errors=table.time_errors,
        signless=table.signless,
    )


def _length(attitude: list[list[Fraction | None]] | None) -> list[str]:
    """That quaternions have another length than 1."""
    found = None if attitude is None else lengths(attitude)
    if found is None:
        return []
    least, most = (f"{x:.6g}" for x in found)
    told = f"is {least}" if least == most else f"is between {least} and {most}"
    return [f"the quaternion's length {told}, not 1"]


def _quoted(name: str) -> str:
    """A column's name, in quotation marks where it is no word."""
    return name if name and not any(map(str.isspace, name)) else repr(name)


def judged_words() -> list[str]:
    """The derived columns that are held against a reference."""
    return [word for word in derived_words() if not column(word).not_judged]


def _gaps(cells: Iterable[Any]) -> bool:
    """Whether any cell is not there (asked so, for a Fraction's == is slow)."""
    return any(x is None for x in cells)
