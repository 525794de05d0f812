"""A table: the trajectory that is judged, of whatever origin, with any subset of the columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from itertools import chain
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.common.errors import BadInput, counted, one_line
from polhode.common.values import ByValue, cached_property
from polhode.equations.integrals import Drift, drift, drift_of_columns
from polhode.judging.tables.column_aliases import are_attitude, degree, lengths, not_judged, root
from polhode.numbers.conversion import exactly, mpf_row, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.double_double import Pairs, of_cells
from polhode.numbers.number_types import Given, GivenRow, NumberType, Real
from polhode.numbers.vectors import quaternion_product
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, COLUMNS, STATE, column_names

# --- reading --------------------------------------------------------------------------------------
#
# A reading: another convention in which a part of a table would be right.


#: Digits: below the first a part is wrong as it stands, the second is what a reading must add.
WRONG, GAIN = 3.0, 3.0

TURN = "a constant rotation of "  # how a rotation of an attitude begins
_EXACT = 12.0  # digits of a row that is right but for rounding
LENGTH = "of length 1"  # that of quaternions which have another

_BITS = 3700  # of a degree, and of the square root of two: far more than any table prints


class Change(NamedTuple):
    """What makes a part's numbers those of the scene's convention, exactly.

    Column k becomes ``signs[k]`` times column ``order[k]``, in radians where its unit has so many
    ``degrees``; a quaternion is then multiplied by ``space`` from the left and by ``body`` from the
    right, both brought to length 1.
    """

    order: tuple[int, ...] = ()
    signs: tuple[int, ...] = ()
    degrees: int = 0
    space: tuple[int, ...] = (1, 0, 0, 0)
    body: tuple[int, ...] = (1, 0, 0, 0)

    def row(self, row: Sequence[object]) -> list[Fraction | None]:
        """A row's cells changed; empty ones stay so."""
        cells = [None if (x := row[k]) is None else exactly(x) for k in self.order]
        unit = self.degrees * degree() if self.degrees else 1
        numbers = [x and s * unit * x for s, x in zip(self.signs, cells, strict=True)]
        if self.space == self.body == (1, 0, 0, 0):
            return numbers
        if None in cells:
            return [None] * len(cells)
        rotation = quaternion_product(quaternion_product(self.space, numbers), self.body)
        square = sum(x * x for x in self.space) * sum(x * x for x in self.body)
        length = root(Fraction(square), _BITS)  # of small whole numbers
        return [x / length for x in rotation]


class TimeChange(NamedTuple):
    """What makes a table's times those at which its rows hold: ``sign * unit * t - shift``."""

    sign: int = 1
    unit: Fraction = Fraction(1)
    shift: Fraction = Fraction(0)

    def of(self, t: Fraction) -> Fraction:
        """A time changed."""
        return self.sign * self.unit * t - self.shift


class Reading(NamedTuple):
    """A part of a table read another way: its digits as it stands, and as it is read here.

    Of times these are the fewest of any whole vector; None where there is none.  ``rows``: times
    with the digits there as it is read, the first row's first; empty where only the fewest digits
    are known.  ``how``: the words before those of the convention.
    """

    part: str
    as_it_stands: float | None
    convention: str
    digits: float | None
    change: Change | None = None  # None where it is told, and not applied
    rows: tuple[tuple[Fraction, float], ...] = ()
    how: str = "read as"

    def __str__(self) -> str:
        how = "right after" if self.convention.startswith(TURN) else self.how
        if self.digits is None or self.as_it_stands is None:
            return f"{self.part} {how} {self.convention}"
        drifts = self.digits < WRONG and self.rows
        digits = self._drift if drifts else f"{self.digits:.1f} digits"
        words = f"{self.part} as it stands: {self.as_it_stands:.2f} digits"
        return f"{words}; {how} {self.convention}: {digits}"

    @property
    def _drift(self) -> str:
        """The digits at each of the rows."""
        phrases: list[str] = []
        for t, digits in self.rows:
            unit = " digits" if all(text.startswith("exact") for text in phrases) else ""
            value = "exact" if digits >= _EXACT else f"{digits:.1f}{unit}"
            phrases.append(f"{value} at t = {brief(t)}")
        return ", ".join(phrases)


# --- table ----------------------------------------------------------------------------------------


_AGAIN = "was not judged: the quaternion is"  # of the same attitude, in another form

#: The parts that may have a convention, and their columns.
PARTS = {
    "omega": STATE[:3],
    "gamma": STATE[3:],
    **{word: COLUMNS[word].names for word in ("attitude", "angles")},
}
#: A number of a table, None where there is none.
Cell: TypeAlias = Real | float | Decimal | Fraction | None
MOST_AT_ONCE = 20.0  # digits of a table whose drift pairs of doubles tell


@dataclass(frozen=True, eq=False, repr=False)
class TrajectoryTable(ByValue):
    """A trajectory by columns: of a run, of a file, of arrays.

    ``times``: exact ones.  ``columns``: cells by name, None where one is empty; of what is judged
    those that the scene has.  ``number``: the type whose rounding the digits possible are about; of
    decimals without one double, or one of as many digits as are printed where those are more than
    a double's 17.  ``held``: the most correct digits that can be told.  ``printed``: the most
    significant digits of any number beside t.  ``ignored``: names of columns that
    are not known.  ``projected``: whether the integrals were.  ``notes``: what is not judged.
    ``remarks``: how it was read.  ``readings``: conventions that were applied to it.
    ``time_errors``: by which the times may be off, rounded; empty where they are exact.
    ``run``: where it is one.
    """

    name: str
    times: tuple[Fraction, ...]
    columns: Mapping[str, tuple[Cell, ...]]
    number: NumberType
    held: float
    printed: int
    ignored: tuple[str, ...] = ()
    projected: bool = False
    notes: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    readings: tuple[Reading, ...] = ()
    time_errors: tuple[float, ...] = ()
    run: Trajectory | None = None

    def __post_init__(self) -> None:
        if (name := one_line(self.name)) != self.name:
            object.__setattr__(self, "name", name)

    def __repr__(self) -> str:
        times = counted(len(self.times), "time")
        return f"<Table {self.name}: {', '.join(self.columns)} at {times}>"

    @property
    def state(self) -> tuple[str, ...]:
        """The columns of the state that are there."""
        return tuple(name for name in STATE if name in self.columns)

    @property
    def early(self) -> str:
        """That a run ended before its last time, in words; empty where it did not."""
        run = self.run
        if run is None or run.outcome.done or len(run.times) >= len(run.scene.times):
            return ""
        rows = f"{len(run.times)} of {len(run.scene.times)} rows"
        return f"the run ended early, with {rows}: {run.outcome.cause}"

    @property
    def steps(self) -> str:
        """What is to blame where the method is."""
        if self.run is None:
            return "steps of the program"
        tight = self.run.at_full_tolerance
        return "rounding in the steps" if tight else f"tolerance {self.run.tolerance:.1e}"

    def rows(self, names: Sequence[str]) -> list[list[Cell]] | None:
        """Rows of these columns, None where a cell or a column is not there; None without any."""
        if not {*names} & self.columns.keys():
            return None
        none = (None,) * len(self.times)
        return [list(row) for row in zip(*(self.columns.get(n, none) for n in names), strict=True)]

    def numbers(self, names: Sequence[str], *, in_pairs: bool) -> Given | Pairs:
        """:meth:`rows`, which are there, or the same as pairs where these hold every number."""
        if in_pairs:
            with suppress(OverflowError, ValueError):  # a number beyond doubles, or none
                parts = [self._pairs(name) for name in names]
                hi, lo = (np.stack([getattr(x, y) for x in parts], axis=1) for y in ("hi", "lo"))
                return Pairs(hi, lo)
        return self.rows(names) or []

    def _pairs(self, name: str) -> Pairs:
        """A column as pairs, not a number where no cell is there; ValueError or OverflowError."""
        if name not in self._known_pairs:
            cells = self.columns.get(name, (None,) * len(self.times))
            self._known_pairs[name] = of_cells(cells)
        return self._known_pairs[name]

    @cached_property
    def _known_pairs(self) -> dict[str, Pairs]:
        return {}

    def whole_rows(self, names: Sequence[str]) -> list[int]:
        """The rows that have a number in each of these columns."""
        if not {*names} <= self.columns.keys():
            return []
        gaps = {*self.gaps(names)}
        return [k for k in range(len(self.times)) if k not in gaps]

    def gaps(self, names: Sequence[str]) -> list[int]:
        """The rows in which one of these columns that are there has no number."""
        there = [self.columns[name] for name in names if name in self.columns]
        return sorted({k for cells in there for k, x in enumerate(cells) if x is None})

    def some(self, which: Sequence[int]) -> TrajectoryTable:
        """Some of the rows."""
        return replace(
            self,
            times=tuple(self.times[k] for k in which),
            columns={n: tuple(cells[k] for k in which) for n, cells in self.columns.items()},
            time_errors=tuple(self.time_errors[k] for k in which) if self.time_errors else (),
        )

    def with_rows(self, names: Sequence[str], rows: Iterable[GivenRow]) -> TrajectoryTable:
        """The table with other cells in some columns."""
        columns = dict(zip(names, zip(*rows, strict=True), strict=True))
        return replace(self, columns={**self.columns, **columns})

    def at_other_times(self, change: TimeChange) -> TrajectoryTable:
        """The same rows at changed times; their origin is off by as much as the first time."""
        times, unit = tuple(change.of(t) for t in self.times), abs(to_double(change.unit))
        errors = [unit * x for x in self.time_errors]
        off = errors[0] if errors and change.shift else 0.0
        return replace(self, times=times, time_errors=tuple(x + off for x in errors))

    def read_as(self, readings: Sequence[Reading]) -> TrajectoryTable:
        """The table in other conventions, as far as readings can be applied."""
        table = self
        for reading in readings:
            names, change = PARTS.get(reading.part, ()), reading.change
            rows = table.rows(names)
            if rows is not None and change is not None:
                table = table.with_rows(names, map(change.row, rows))
        return replace(table, readings=(*table.readings, *readings))

    def drift(self, scene: Scene, bits: int) -> Drift | str:
        """Drift of the integrals, or why it says nothing."""
        if self.projected:
            return "they were projected"
        if self.run is not None:
            return self.run.drift
        missing = [name for name in scene.columns if name not in self.columns]
        if missing:
            return f"it takes all of {', '.join(scene.columns)}, and the table has no {missing[0]}"
        columns = [self.columns[name] for name in scene.columns]
        if any(x is None for x in chain(*columns)):  # asked so, for a Fraction's == is slow
            return "it takes all cells of the state, and some are empty"
        if self.held <= MOST_AT_ONCE:
            with suppress(OverflowError, ValueError):  # a number beyond doubles, or none
                pairs = [self._pairs(name) for name in scene.columns]
                if (at_once := drift_of_columns(scene, pairs)) is not None:
                    return at_once
        rows = zip(*columns, strict=True)
        return drift(scene, [mpf_row(row, bits) for row in rows], bits)


def of_run(run: Trajectory) -> TrajectoryTable:
    """A run as a table; raises BadInput for one that reached no time."""
    if not run.times:
        ended = f"a time that the run reached ({run.outcome.cause}; {run.outcome.advice})"
        raise BadInput(run.scene.name, "rows", None, ended)
    outputs = [(COLUMNS[word].names, rows) for word, rows in run.outputs.items()]
    columns: dict[str, tuple[Cell, ...]] = {}
    for names, rows in [(run.columns, run.states), *outputs]:
        cells = rows.tolist() if isinstance(rows, np.ndarray) else rows
        columns |= dict(zip(names, zip(*cells, strict=True), strict=True))
    columns = {name: cells for name, cells in columns.items() if name not in not_judged()}
    table = TrajectoryTable(
        f"{run.scene.name}: {run.number.name} ({run.number.bits} bits)",
        tuple(run.times),
        columns,
        run.number,
        run.number.most_digits,
        run.number.printed_digits,
        projected=run.projected,
        run=run,
    )
    return replace(table, remarks=(table.early,)) if table.early else table


def as_judged(table: TrajectoryTable, scene: Scene) -> TrajectoryTable:
    """A table with those columns alone that the scene has, and notes of the others."""
    there, unjudged = table.columns, not_judged()
    again = are_attitude(table.ignored) if table.ignored else ()
    remarks = [
        (_quoted(name), _AGAIN if is_again else "is not known and was not judged")
        for name, is_again in zip(table.ignored, again, strict=True)
    ]
    remarks += [(name, f"was not judged: {why}") for name, why in unjudged.items() if name in there]
    others = [name for name in column_names() if name not in unjudged]
    if not scene.columns[3:]:
        without = "was not judged: the scene has no gamma"
        remarks += [(name, without) for name in (*STATE[3:], *others) if name in there]
        others = []
    remarks += [(name, "is not in the file") for name in scene.columns if name not in there]
    notes = _together(remarks)
    columns = {name: there[name] for name in (*scene.columns, *others) if name in there}
    if any(x is None for name in scene.columns for x in columns.get(name, ())):
        notes.append("empty cells were not judged")
    judged = replace(table, columns=columns, notes=tuple(notes))
    return replace(judged, remarks=(*table.remarks, *_length(judged)))


def _together(remarks: Iterable[tuple[str, str]]) -> list[str]:
    """What is said of columns, those of which the same is said in one note."""
    alike: dict[str, list[str]] = {}
    for name, remark in remarks:
        alike.setdefault(remark, []).append(name)
    notes = []
    for remark, names in alike.items():
        many = remark.replace("is not", "are not", 1).replace("was not", "were not", 1)
        single = f"column {names[0]} {remark}"
        notes.append(f"columns {' '.join(names)} {many}" if names[1:] else single)
    return notes


def _length(table: TrajectoryTable) -> list[str]:
    """That quaternions have another length than 1."""
    sizes = lengths(table.rows(ATTITUDE) or [])
    if sizes is None:
        return []
    least, most = (f"{x:.6g}" for x in sizes)
    words = f"is {least}" if least == most else f"is between {least} and {most}"
    return [f"the quaternion's length {words}, not 1"]


def _quoted(name: str) -> str:
    """A column's name, in quotation marks where it is no word."""
    return name if name and not any(map(str.isspace, name)) else repr(name)
