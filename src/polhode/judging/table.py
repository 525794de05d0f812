"""Tables: trajectories of any origin, a CSV or rows, with any subset of the columns beside t."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, TextIO

from polhode.common.arguments import each
from polhode.common.errors import BadInput, nearest
from polhode.common.files import read_whole
from polhode.judging.cells import type_of
from polhode.judging.file_cells import most_printed, values
from polhode.judging.synonyms import KNOWN, Column, column
from polhode.numbers import exact, expression
from polhode.numbers.convert import exact_number, exactly
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import NAMES, NumberType
from polhode.numbers.scalars import AnyNumber, AnyVector
from polhode.scenes.words import ANGLES, ATTITUDE, STATE

MAX_BYTES = 1 << 30
MAX_LINE = 1_000_000  # characters
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

    def __repr__(self) -> str:
        return f"<Table {self.name}: {', '.join(self.columns)} at {len(self.times)} times>"

    def some(self, which: Sequence[int]) -> Table:
        """Some of the rows."""
        columns = {name: tuple(x[k] for k in which) for name, x in self.columns.items()}
        return replace(self, times=tuple(self.times[k] for k in which), columns=columns)

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
    times = each("compare", "at", () if at is None else at, _exactly, "a list of times")
    try:
        given = [row if hasattr(row, "dtype") else list(row) for row in states]
        rows = [[_exactly(x) for x in row] for row in given]
    except (TypeError, ValueError) as fault:
        raise BadInput("compare", "states", None, f"rows of finite numbers ({fault})") from None
    if at is None or len(times) != len(rows) or not rows:
        raise BadInput("compare", "at", len(times), f"a time for each of {len(rows)} rows")
    known = (*STATE, *ANGLES, *ATTITUDE)
    for name in each("compare", "columns", columns, str, "a list of names"):
        if name not in known:
            raise BadInput("compare", "columns", name, nearest(name, list(known)))
    if any(len(row) != len(columns) for row in rows):
        expected = f"{len(columns)} numbers in each row: {', '.join(columns)}"
        raise BadInput("compare", "states", None, expected)
    number = number or type_of(given)
    named = dict(zip(columns, zip(*rows, strict=True), strict=True))
    printed = number.printed_digits if number else MOST_PRINTED
    return Table("states", times, named, (), printed, number)


def table_of_columns(given: Any, number: NumberType | None = None) -> Table:
    """Columns by name as a table: a mapping, a pandas DataFrame, an xarray Dataset.

    Names are those of a file's header; the time may be a DataFrame's index.  Columns of floats
    are known as such; nan, NaT and None are empty cells.  Raises BadInput.
    """
    if hasattr(given, "iloc"):  # a DataFrame
        if column(str(given.index.name)).name == "t":
            given = given.reset_index()
        held = {str(name): given[name].to_numpy() for name in given.columns}
    else:
        names = [*getattr(given, "coords", ()), *given.keys()]
        held = {str(name): getattr(given[name], "values", given[name]) for name in names}
    named = {name: column(name) for name in held}
    header = ",".join(held)
    for name in KNOWN:
        if sum(name == found.name for found in named.values()) > 1:
            raise BadInput("compare", "columns", name, "each column once")
    if all(found.name != "t" for found in named.values()):
        raise BadInput("compare", "columns", header, "a column t among them")
    if all(found.name in (None, "t") for found in named.values()):
        expected = f"columns beside t that can be judged, of {', '.join(KNOWN[1:])}"
        raise BadInput("compare", "columns", header, expected)
    if number is None:
        number = type_of(held[name] for name, k in named.items() if k.name not in (None, "t"))
    found: dict[str, tuple[Fraction | None, ...]] = {}
    for name, (known_name, degrees) in named.items():
        if known_name is not None:
            cells = each("compare", name, held[name], _cell, "a column of numbers")
            found[known_name] = tuple(_radians(x) if x and degrees else x for x in cells)
    times = found.pop("t")
    if not times or None in times or any(len(cells) != len(times) for cells in found.values()):
        raise BadInput(
            "compare", "columns", header, "columns as long as t, with a time in each row"
        )
    printed = number.printed_digits if number else MOST_PRINTED
    ignored = tuple(name for name, known in named.items() if known.name is None)
    exact_times = tuple(t for t in times if t is not None)
    return Table("columns", exact_times, found, ignored, printed, number)


def _cell(value: Any) -> Fraction | None:
    """A cell's exact number, None where it is empty."""
    if value is None or value != value:
        return None
    return _exactly(value)


def read_table(path: Path, number: NumberType | None) -> Table:
    """A CSV file as a table; raises BadInput.

    ``number``: its decimals stand for numbers of it; that which the JSON that polhode wrote beside
    it names, unless given.
    """
    found = read_whole(path, MAX_BYTES, "a readable CSV file")
    try:
        text = io.StringIO(found.decode("utf-8-sig"), newline="")
        rows = [
            (k, [cell.strip() for cell in row])
            for k, row in enumerate(csv.reader(_uncommented(text)), 1)
            if any(cell.strip() for cell in row)
        ]
    except (UnicodeDecodeError, csv.Error):
        raise BadInput(str(path), "file", None, "a readable CSV file (not a CSV text)") from None
    if not rows:
        raise BadInput(str(path), "file", None, "a header line that names the columns")
    header = rows[0][1]
    named = [column(name) for name in header]
    for name in KNOWN:
        if sum(name == found.name for found in named) > 1:
            raise BadInput(str(path), "header", name, "each column once")
    if all(found.name != "t" for found in named):
        raise BadInput(str(path), "header", ",".join(header), "a column t among its names")
    if all(found.name in (None, "t") for found in named):
        expected = f"columns beside t that can be judged, of {', '.join(KNOWN[1:])}"
        raise BadInput(str(path), "header", ",".join(header), expected)
    if len(rows) == 1:
        raise BadInput(str(path), "file", None, "at least one line of numbers")
    return _table(path, header, named, rows[1:], number)


def _uncommented(text: TextIO) -> Iterator[str]:
    """The lines with comments blank: a quotation mark in a comment opens nothing."""
    for line in iter(lambda: text.readline(MAX_LINE + 1), ""):
        if len(line) > MAX_LINE:
            raise csv.Error("a line without end")
        yield "\n" if line.lstrip().startswith("#") else line


def _table(
    path: Path,
    header: list[str],
    named: list[Column],
    rows: list[tuple[int, list[str]]],
    number: NumberType | None,
) -> Table:
    for line, cells in rows:
        if len(cells) != len(header):
            raise BadInput(f"{path}:{line}", "line", ",".join(cells), f"{len(header)} values")
    columns = dict(zip(named, zip(*(cells for _, cells in rows), strict=True), strict=True))
    printed = 1
    for (name, _), texts in columns.items():
        if name not in (None, "t"):
            printed = most_printed(texts, printed)
    beside = _beside(path)
    bits = beside.get("t_bits")
    held = NumberType("mp", bits) if isinstance(bits, int) and bits > 1 else None
    own = _type(beside) if held and number is None else None
    own = own if own and printed <= own.printed_digits else None
    found: dict[str, tuple[Fraction | None, ...]] = {}
    for (name, degrees), texts in columns.items():
        if name is None:
            continue
        try:
            if name == "t":
                exact = values(texts, held or number)
                exact = [x and number.rounded(x) for x in exact] if held and number else exact
            elif degrees:
                exact = [x and _radians(x) for x in values(texts, number)]
                exact = [x and own.rounded(x) for x in exact] if own else exact
            else:
                exact = values(texts, number or own)
        except ExpressionError:
            raise _first_bad(path, named, rows) from None
        found[name] = tuple(exact)
    times = tuple(t for t in found.pop("t") if t is not None)
    if len(times) < len(rows):
        raise _first_bad(path, named, rows)
    ignored = tuple(text for text, known in zip(header, named, strict=True) if known.name is None)
    return Table(str(path), times, found, ignored, printed, number or own, _projected(beside))


def _first_bad(path: Path, named: list[Column], rows: list[tuple[int, list[str]]]) -> BadInput:
    """The complaint about the first cell that is no number."""
    for line, cells in rows:
        for (name, _), cell in zip(named, cells, strict=True):
            if name is None or (cell == "" and name != "t"):
                continue
            try:
                expression.decimal(cell)
            except ExpressionError:
                return BadInput(f"{path}:{line}", name, cell, "a finite decimal number")
    raise AssertionError("each cell is a number")


def _exactly(value: Any) -> Fraction:
    return exactly(exact_number(value))


def _radians(degrees: Fraction) -> Fraction:
    """An angle in radians, to far more digits than any table prints."""
    return degrees * _degree()


@cache
def _degree() -> Fraction:
    """pi/180 to 1100 digits."""
    return exact.binary(*exact.rounded(exact.pi() / 180, 3700))


def _beside(path: Path) -> dict[str, Any]:
    """What the JSON that polhode wrote beside a file says; empty where there is none."""
    try:
        found = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _type(beside: dict[str, Any]) -> NumberType | None:
    """The type of the run's numbers."""
    name, bits = beside.get("number"), beside.get("bits")
    if name not in NAMES or not isinstance(bits, int) or bits < 2:
        return None
    return NumberType(name, bits)


def _projected(beside: dict[str, Any]) -> bool:
    """Whether the integrals were projected."""
    projection = beside.get("projection")
    if not isinstance(projection, dict):
        return False
    return bool(projection.get("count")) and "h" in projection.get("onto", ())
