"""Tables in files: a CSV, and what the JSON that polhode wrote beside it says of its numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import TextIO

from polhode.common.errors import BadInput
from polhode.common.files import STDIN, called, read_stdin, read_whole
from polhode.common.text_tables import few
from polhode.judging.tables.attitude_forms import with_quaternions
from polhode.judging.tables.column_aliases import Column
from polhode.judging.tables.csv_columns import last_place, most_printed, values
from polhode.judging.tables.csv_layout import BLANK, Naming, is_empty, layout
from polhode.judging.tables.sidecar import Sidecar, beside
from polhode.judging.tables.table import Table, added, radians, refuse_names
from polhode.judging.tables.time_errors import of_decimals, of_type
from polhode.judging.tables.type_inference import printed_type
from polhode.numbers import expression
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import DIGITS_HELD, DOUBLE, NumberType, bits_for

MAX_BYTES = 1 << 30
MAX_LINE = 1_000_000  # characters
_ACCEPTED = (
    "a header with a column t (or time, timestamp) and other columns, separated by commas, "
    "semicolons, tabs or blanks, also after #; or --columns t,p,q,... that names them, or "
    "--columns NAME=t"
)


@dataclass(frozen=True, repr=False)
class TableFile:
    """The lines of a CSV file, comments blank, whose cells are still to be read.

    ``number``: its decimals stand for numbers of it; that which the JSON that polhode wrote beside
    it names, unless given.  ``beside``: what that JSON says.  ``separator``, ``before``, ``names``,
    ``commas``: see :mod:`polhode.judging.tables.csv_layout`.
    """

    path: Path
    lines: tuple[str, ...]
    number: NumberType | None
    beside: Sidecar
    separator: str = ","
    before: int = 0
    names: Naming = field(default_factory=Naming)
    commas: bool = False

    @property
    def table(self) -> Table:
        """All the rows; raises BadInput."""
        return self._of(self.lines)

    def some(self, most: int) -> tuple[Table, int] | None:
        """At most so many of the rows, evenly spread, and how many the file has.

        None where lines are not rows, or where these cannot be read: :attr:`table` tells why.
        """
        header, *held = [k for k, line in enumerate(self.lines) if line.strip(BLANK)] or [0]
        if not held or any('"' in line for line in self.lines):  # a cell may have many lines
            return None
        chosen = [header, *(held[k] for k in few(len(held), most))]
        try:
            return self._of([self.lines[k] for k in chosen]), len(held)
        except BadInput:
            return None

    def _of(self, lines: Sequence[str]) -> Table:
        path = self.path
        reader = csv.reader(lines, delimiter=self.separator)
        try:
            rows = [
                (reader.line_num - self.before, [cell.strip() for cell in row])
                for row in reader
                if any(cell.strip() for cell in row)
            ]
        except csv.Error:
            raise _no_text(path) from None
        if not rows:
            raise BadInput(str(path), "file", None, "a header line that names the columns")
        header = rows[0][1]
        named = self.names.columns(header)
        if all(found.name != "t" for found in named):
            raise BadInput(str(path), "header", ",".join(header), _ACCEPTED)
        refuse_names(str(path), "header", header, named)
        if len(rows) == 1:
            raise BadInput(str(path), "file", None, "at least one line of numbers")
        found = _table(path, header, named, rows[1:], self.number, self.beside)
        if self.commas:
            found = replace(found, remarks=(*found.remarks, "read as: decimal commas"))
        return found


def open_table(path: Path, number: NumberType | None, names: Naming | None = None) -> TableFile:
    """A CSV file's lines, of ``-`` those of the standard input; raises BadInput.

    ``number``: see :class:`TableFile`; ``names``: columns that were named beside it.
    """
    piped = str(path) == "-"
    path = Path(STDIN) if piped else path
    what = "a readable CSV file"
    found = read_stdin(MAX_BYTES, what) if piped else read_whole(path, MAX_BYTES, what)
    try:
        lines = tuple(_lines(io.StringIO(found.decode("utf-8-sig"), newline="")))
    except (UnicodeDecodeError, csv.Error):
        raise _no_text(path) from None
    names = names or Naming()
    laid = layout(lines, names)
    about = Sidecar() if piped else beside(path)
    return TableFile(
        path, laid.lines, number, about, laid.separator, laid.before, names, laid.commas
    )


def read_table(path: Path, number: NumberType | None, names: Naming | None = None) -> Table:
    """A CSV file as a table; raises BadInput.  ``number``, ``names``: see :func:`open_table`."""
    return open_table(path, number, names).table


def _no_text(path: Path) -> BadInput:
    return BadInput(str(path), "file", None, "a readable CSV file (not a CSV text)")


def _lines(text: TextIO) -> Iterator[str]:
    """The lines, each within a limit."""
    for line in iter(lambda: text.readline(MAX_LINE + 1), ""):
        if len(line) > MAX_LINE:
            raise csv.Error("a line without end")
        yield line


def _table(
    path: Path,
    header: list[str],
    named: list[Column],
    rows: list[tuple[int, list[str]]],
    number: NumberType | None,
    beside: Sidecar,
) -> Table:
    for line, cells in rows:
        if len(cells) != len(header):
            raise BadInput(f"{path}:{line}", "line", ",".join(cells), f"{len(header)} values")
    columns = {
        meant: texts if meant.name == "t" else [x if not is_empty(x) else "" for x in texts]
        for meant, texts in zip(named, zip(*(cells for _, cells in rows), strict=True), strict=True)
    }
    judged = [texts for meant, texts in columns.items() if meant.name not in (None, "t")]
    clocks = {meant: texts for meant, texts in columns.items() if meant.name == "t"}
    printed = 1
    for texts in judged:
        printed = most_printed(texts, printed)
    beside = beside.of(printed, next(iter(clocks.values())))
    held, own, remarks = beside.number, beside.number if number is None else None, beside.remarks
    clock = held or number
    if clock is None:
        own, clock = (_inferred(texts) for texts in (judged, [*clocks.values()]))
        if own is not None:
            remarks = (*remarks, f"read as: numbers of {own.name}, printed to {printed} digits")
            printed = own.printed_digits
    found: dict[str, tuple[Fraction | None, ...]] = {}
    for (name, degrees, factor, part), texts in columns.items():
        if name is None:
            continue
        by = None if factor == 1 else factor
        try:
            if name == "t":
                exact = values(texts, clock)
                exact = [x and number.rounded(x) for x in exact] if held and number else exact
                exact = [x and x * by for x in exact] if by else exact
            elif degrees or by:
                exact = [x and x * factor for x in values(texts, number)]
                exact = [x and radians(x) for x in exact] if degrees else exact
                exact = [x and own.rounded(x) for x in exact] if held and own else exact
            else:
                exact = values(texts, number or own)
        except ExpressionError:
            raise _first_bad(path, named, rows) from None
        found[name] = added(found.get(name), exact) if part else tuple(exact)
    times = tuple(t for t in found.pop("t") if t is not None)
    if len(times) < len(rows):
        raise _first_bad(path, named, rows)
    ignored = tuple(text for text, known in zip(header, named, strict=True) if known.name is None)
    found, signless = with_quaternions(found, bits_for(printed))
    return Table(
        called(path),
        times,
        found,
        ignored,
        printed,
        number or own,
        beside.projected,
        remarks,
        () if held else _time_errors(times, clocks, clock),
        signless,
    )


def _inferred(columns: Sequence[Sequence[str]]) -> NumberType | None:
    """The type of which columns are, printed longer than it has digits."""
    most = 1
    for texts in columns:
        most = most_printed(texts, most)
    return printed_type(columns, most)


def _time_errors(
    times: Sequence[Fraction], clocks: Mapping[Column, Sequence[str]], number: NumberType | None
) -> tuple[float, ...]:
    """By how much times may be off, as they are printed; ``number``: whose values they are."""
    if number is not None:
        return of_type(times, number)
    units = {abs(meant.factor) * last_place(texts) for meant, texts in clocks.items()}
    rounded = of_decimals(times, min(units))
    digits = max(most_printed(texts, 1) for texts in clocks.values())
    if len(clocks) > 1 or not DIGITS_HELD["double"] <= digits <= DOUBLE.printed_digits:
        return rounded
    doubles = of_type(times, DOUBLE)
    return tuple(map(max, doubles, rounded)) if rounded else doubles


def _first_bad(path: Path, named: list[Column], rows: list[tuple[int, list[str]]]) -> BadInput:
    """The complaint about the first cell that is no number."""
    for line, cells in rows:
        for (name, *_), cell in zip(named, cells, strict=True):
            if name is None or (is_empty(cell) and name != "t"):
                continue
            try:
                expression.decimal(cell)
            except ExpressionError:
                return BadInput(f"{path}:{line}", name, cell, "a finite decimal number")
    raise AssertionError("each cell is a number")
