"""Tables: trajectories of any origin, with any subset of the columns beside t."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence, Set
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import Any

from polhode.common.arguments import each
from polhode.common.errors import BadInput, nearest
from polhode.common.text_tables import counted, one_line
from polhode.judging.tables.attitude_forms import with_quaternions
from polhode.judging.tables.column_aliases import Column, known, not_judged, twice
from polhode.judging.tables.column_aliases import columns as columns_of
from polhode.judging.tables.time_errors import of_decimals, of_type
from polhode.judging.tables.type_inference import type_of
from polhode.numbers import exact
from polhode.numbers.conversion import exact_number, exactly
from polhode.numbers.number_types import NumberType, bits_for
from polhode.numbers.scalars import AnyNumber, AnyVector

NAMING = "--columns 'NAME=COLUMN, ...' (in Python columns=[...])"
MOST_PRINTED = 60  # digits that rows of exact numbers are counted as


@dataclass(frozen=True, repr=False)
class Table:
    """A trajectory from outside: exact times, and columns by name (None where a cell is empty)."""

    name: str
    times: tuple[Fraction, ...]
    columns: dict[str, tuple[Fraction | None, ...]]
    ignored: tuple[str, ...]
    printed: int  # the most significant digits that any number beside t has
    number: NumberType | None = None  # whose values the numbers are; None: exact decimals
    projected: bool = False  # whether the integrals were, as the file beside it says
    remarks: tuple[str, ...] = ()  # what its JSON file says, and what of that was ignored
    time_errors: tuple[float, ...] = ()  # by which the times may be off, rounded; empty: exact
    signless: bool = False  # whether its attitude had a form that tells no quaternion's sign

    def __post_init__(self) -> None:
        if (name := one_line(self.name)) != self.name:
            object.__setattr__(self, "name", name)

    def __repr__(self) -> str:
        return (
            f"<Table {self.name}: {', '.join(self.columns)} at {counted(len(self.times), 'time')}>"
        )

    def some(self, which: Sequence[int]) -> Table:
        """Some of the rows."""
        columns = {name: tuple(x[k] for k in which) for name, x in self.columns.items()}
        times = tuple(self.times[k] for k in which)
        errors = tuple(self.time_errors[k] for k in which) if self.time_errors else ()
        return replace(self, times=times, columns=columns, time_errors=errors)

    def rows(self, names: Sequence[str]) -> list[list[Fraction | None]] | None:
        """Rows of these columns, None where a cell or a column is not there; None without any."""
        there = [self.columns.get(name) for name in names]
        if all(column is None for column in there):
            return None
        none = (None,) * len(self.times)
        return [list(row) for row in zip(*(column or none for column in there), strict=True)]


def table_of_rows(
    states: Iterable[AnyVector],
    at: Iterable[AnyNumber] | None,
    columns: Sequence[str],
    number: NumberType | None = None,
) -> Table:
    """Rows of numbers as a table; raises BadInput.  ``number``: their type, where it is not plain.

    Floats, of Python or of an array, say so themselves; other numbers without ``number`` are exact.
    """
    at = at if at is None or hasattr(at, "dtype") or not isinstance(at, Iterable) else list(at)
    times = each("compare", "at", () if at is None else at, _exactly, "a list of times")
    try:
        given = [row if hasattr(row, "dtype") else list(row) for row in states]
        rows = [[_cell(x) for x in row] for row in given]
    except (TypeError, ValueError) as fault:
        expected = f"a run, a file, columns by name or rows of finite numbers ({fault})"
        raise BadInput("compare", "states", None, expected) from None
    if at is None or len(times) != len(rows) or not rows:
        raise BadInput("compare", "at", len(times), f"a time for each of {len(rows)} rows")
    judged = [name for name in known()[1:] if name not in not_judged()]
    for name in each("compare", "columns", columns, str, "a list of names"):
        if name not in judged:
            raise BadInput("compare", "columns", name, nearest(name, judged))
    if any(len(row) != len(columns) for row in rows):
        expected = f"{len(columns)} numbers in each row: {', '.join(columns)}"
        raise BadInput("compare", "states", None, expected)
    number = number or type_of(given)
    named = dict(zip(columns, zip(*rows, strict=True), strict=True))
    printed = number.printed_digits if number else MOST_PRINTED
    errors = _errors(times, [at], {Fraction(1)})
    return Table("states", times, named, (), printed, number, time_errors=errors)


def table_of_columns(
    given: Any,
    number: NumberType | None = None,
    source: str = "compare",
    meaning: Callable[[Sequence[str]], list[Column]] = columns_of,
) -> Table:
    """Columns by name as a table: a mapping, a pandas DataFrame, an xarray Dataset.

    ``source``: what complaints name.  ``meaning``: what the names stand for.

    Names are those of a file's header; the time may be a DataFrame's index.  Columns of floats
    are known as such; nan, NaT and None are empty cells.  Raises BadInput.
    """
    if hasattr(given, "iloc"):  # a DataFrame
        if not hasattr(given, "columns"):
            expected = "columns by name, t among them: a DataFrame, not one Series"
            raise BadInput(source, "columns", type(given).__name__, expected)
        if meaning([str(given.index.name)])[0].name == "t":
            given = given.reset_index()
        held = {str(name): given[name].to_numpy() for name in given.columns}
    else:
        names = [*getattr(given, "coords", ()), *given.keys()]
        held = {str(name): getattr(given[name], "values", given[name]) for name in names}
    named = dict(zip(held, meaning([*held]), strict=True))
    header = ",".join(held)
    if all(found.name != "t" for found in named.values()):
        raise BadInput(
            source, "columns", header, f"a column t among them, or {NAMING} that names it"
        )
    refuse_names(source, "columns", [*held], [*named.values()])
    if number is None:
        number = type_of(held[name] for name, k in named.items() if k.name not in (None, "t"))
    found: dict[str, tuple[Fraction | None, ...]] = {}
    for name, (known_name, degrees, factor, part) in named.items():
        if known_name is not None:
            cells = each(source, name, held[name], _cell, "a column of numbers")
            cells = cells if factor == 1 else tuple(x and x * factor for x in cells)
            cells = tuple(radians(x) if x and degrees else x for x in cells)
            found[known_name] = added(found.get(known_name), cells) if part else cells
    times = found.pop("t")
    if not times or None in times or any(len(cells) != len(times) for cells in found.values()):
        raise BadInput(source, "columns", header, "columns as long as t, with a time in each row")
    printed = number.printed_digits if number else MOST_PRINTED
    ignored = tuple(name for name, meant in named.items() if meant.name is None)
    called = "columns" if source == "compare" else source
    exact_times = tuple(t for t in times if t is not None)
    clocks = {name: meant for name, meant in named.items() if meant.name == "t"}
    factors = {meant.factor for meant in clocks.values()}
    errors = _errors(exact_times, [held[name] for name in clocks], factors)
    found, signless = with_quaternions(found, bits_for(printed))
    return Table(
        called, exact_times, found, ignored, printed, number, time_errors=errors, signless=signless
    )


def refuse_names(source: str, key: str, header: Sequence[str], named: Sequence[Column]) -> None:
    """Raise BadInput for a column that is there twice, or a header with no column to judge."""
    if (name := twice(named)) is not None:
        both = [f"{of!r}" for of, meant in zip(header, named, strict=True) if meant.name == name]
        expected = f"each column once ({', '.join(both)}), or {NAMING} that chooses one"
        raise BadInput(source, key, name, expected)
    if all(meant.name in (None, "t") for meant in named):
        expected = f"columns besides t that can be judged, of {', '.join(known()[1:])}"
        raise BadInput(
            source, key, ",".join(header), f"{expected}; or {NAMING} that translates names"
        )


def _errors(
    times: Sequence[Fraction], given: Sequence[Any], factors: Set[Fraction]
) -> tuple[float, ...]:
    """By how much times may be off that were given so: in floats, or in units of a clock."""
    number = type_of(given)
    if len(factors) > 1 or number is None:  # of whole seconds and nanoseconds: exact
        return of_decimals(times, min(map(abs, factors))) if min(factors) < 1 else ()
    return of_type(times, number)


def added(
    one: Sequence[Fraction | None] | None, other: Sequence[Fraction | None]
) -> tuple[Fraction | None, ...]:
    """Columns that are parts of one, cell by cell; the other alone where there is one."""
    if one is None:
        return tuple(other)
    pairs = zip(one, other, strict=True)
    return tuple(None if x is None or y is None else x + y for x, y in pairs)


def _cell(value: Any) -> Fraction | None:
    """A cell's exact number, None where it is empty."""
    if value is None or value != value:
        return None
    return _exactly(value)


def _exactly(value: Any) -> Fraction:
    return exactly(exact_number(value))


def radians(degrees: Fraction) -> Fraction:
    """An angle in radians, to far more digits than any table prints."""
    return degrees * _degree()


@cache
def _degree() -> Fraction:
    """pi/180 to 1100 digits."""
    return exact.binary(*exact.rounded(exact.pi() / 180, 3700))
