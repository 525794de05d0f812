"""Tables in CSV files of other programs.

Separators are comma, semicolon, tab, or blanks, as the first line of the table has them.  Between
semicolons the numbers may have decimal commas, if none has a point.  A header may stand in a
comment (``# t p q r``, as NumPy writes it), or be given.

A decimal that stands for a double is the double nearest to it, which Python's ``float`` gives; all
others are read exactly and rounded once.
"""

from __future__ import annotations

import csv
import io
import re
import string
from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import NamedTuple

from polhode.common.errors import BadInput
from polhode.common.files import STDIN, called, read_stdin, read_whole
from polhode.judging.tables.attitude_forms import Cells
from polhode.judging.tables.column_aliases import Column, Naming
from polhode.judging.tables.given_columns import refuse_names, table_of_cells
from polhode.judging.tables.table import Table
from polhode.judging.tables.type_inference import of_decimals, of_type, printed_type
from polhode.numbers import expression
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import DIGITS_HELD, DOUBLE, NumberType

MAX_BYTES = 1 << 30
MAX_LINE = 1_000_000  # characters
_EMPTY = ("", "nan", "na", "n/a", "nat", "null", "none")
_PLAIN = "0123456789+-.eE"
_LONGEST = 60  # characters of a cell that is read as a double at once
_LEAST, _MOST = 1e-290, 1e290  # within them a double has all its bits
_SEPARATORS = ",;\t"
_BLANK = _SEPARATORS + string.whitespace
_WITH_COMMA = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?")
_ACCEPTED = (
    "a header with a column t (or time, timestamp) and other columns, separated by commas, "
    "semicolons, tabs or blanks, also after #; or --columns t,p,q,... that names them, or "
    "--columns NAME=t"
)


class _Sheet(NamedTuple):
    """The cells of a file: its header, and its rows with the numbers of their lines.

    ``commas``: whether its numbers had decimal commas, which are points now.
    """

    header: Sequence[str]
    rows: list[tuple[int, list[str]]]
    commas: bool


def read_csv(path: Path, number: NumberType | None, names: Naming) -> Table:
    """A CSV file as a table, of ``-`` the standard input; raises BadInput.

    ``number``: its decimals stand for numbers of it.  ``names``: columns that were named beside it.
    """
    piped = str(path) == "-"
    path = Path(STDIN) if piped else path
    what = "a readable CSV file"
    content = read_stdin(MAX_BYTES, what) if piped else read_whole(path, MAX_BYTES, what)
    try:
        sheet = _sheet([*io.StringIO(content.decode("utf-8-sig"), newline="")], names)
    except (UnicodeDecodeError, csv.Error):
        raise BadInput(str(path), "file", None, f"{what} (not a CSV text)") from None
    header = sheet.header
    if not header:
        raise BadInput(str(path), "file", None, "a header line that names the columns")
    named = names.columns(header)
    if all(meant.name != "t" for meant in named):
        raise BadInput(str(path), "header", ",".join(header), _ACCEPTED)
    refuse_names(str(path), "header", header, named)
    if not sheet.rows:
        raise BadInput(str(path), "file", None, "at least one line of numbers")
    for line, row in sheet.rows:
        if len(row) != len(header):
            raise BadInput(f"{path}:{line}", "line", ",".join(row), f"{len(header)} values")
    found = _table(path, sheet, named, number)
    remarks = ("read as: decimal commas",) if sheet.commas else ()
    return replace(found, remarks=(*found.remarks, *remarks))


def _sheet(lines: Sequence[str], names: Naming) -> _Sheet:
    """The cells of a file's lines; raises csv.Error for a line without end."""
    if max(map(len, lines), default=0) > MAX_LINE:
        raise csv.Error("a line without end")
    plain = ["\n" if line.lstrip().startswith("#") else line for line in lines]
    first = next((k for k, line in enumerate(plain) if line.strip(_BLANK)), None)
    if first is None:
        return _Sheet((), [], False)
    commas = ";" in plain[first] and _have_decimal_commas(plain[first:])
    separator = ";" if commas else _separator(plain[first])
    top, *rows = _rows(plain[first:], separator, first)
    header: Sequence[str] = names.header
    if _are_numbers(top[1], commas):
        rows = [top, *rows]
        header = header or _commented(lines[:first], len(top[1]), names)
    header = header or top[1]
    if commas:
        rows = [(line, [cell.replace(",", ".") for cell in row]) for line, row in rows]
    return _Sheet(header, rows, commas)


def _rows(lines: Sequence[str], separator: str, before: int) -> list[tuple[int, list[str]]]:
    """Rows of cells with the numbers of their lines; ``before``: lines that stand before them."""
    stripped = (line.strip() for line in lines) if separator == " " else lines
    reader = csv.reader(stripped, delimiter=separator, skipinitialspace=True)
    rows = ((before + reader.line_num, [cell.strip() for cell in row]) for row in reader)
    return [(line, row) for line, row in rows if any(row)]


def _separator(line: str) -> str:
    return next((mark for mark in _SEPARATORS if mark in line), " " if " " in line.strip() else ",")


def _have_decimal_commas(lines: Sequence[str]) -> bool:
    """Whether cells between semicolons are numbers with a comma, or have neither comma nor point,
    and one has a comma; the first line may be a header."""
    cells = (cell.strip() for line in lines[1:] or lines for cell in line.split(";"))
    marked = [cell for cell in cells if "," in cell or "." in cell]
    return bool(marked) and all(map(_WITH_COMMA.fullmatch, marked))


def _are_numbers(row: Sequence[str], commas: bool) -> bool:
    """Whether cells are numbers, with decimal commas perhaps, so that they are no header."""
    cells = [cell for cell in row if not is_empty(cell)]
    return bool(cells) and all(
        _is_decimal(cell.replace(",", ".") if commas else cell) for cell in cells
    )


def _is_decimal(cell: str) -> bool:
    try:
        expression.decimal(cell)
    except ExpressionError:
        return False
    return True


def _commented(lines: Sequence[str], count: int, names: Naming) -> Sequence[str]:
    """The last comment that names so many columns, t among them; empty where none does."""
    for line in reversed(lines):
        text = line.lstrip().lstrip("#")
        for _, cells in _rows([text], _separator(text), 0):
            if len(cells) == count and any(one.name == "t" for one in names.columns(cells)):
                return cells
    return ()


def _table(path: Path, sheet: _Sheet, named: list[Column], number: NumberType | None) -> Table:
    columns = zip(*(row for _, row in sheet.rows), strict=True)
    texts = [["" if is_empty(cell) else cell for cell in column] for column in columns]
    clock = next(k for k, meant in enumerate(named) if meant.name == "t")
    judged = [x for meant, x in zip(named, texts, strict=True) if meant.name not in (None, "t")]
    printed, shown = most_printed(judged), most_printed([texts[clock]])
    remarks: tuple[str, ...] = ()
    kind = of_times = number
    if number is None:
        kind = printed_type(judged, printed)
        of_times = printed_type([texts[clock]], shown)
        if kind is not None:
            remarks = (f"read as: numbers of {kind.name}, printed to {printed} digits",)
            printed = kind.printed_digits
    cells = [
        None
        if meant.name is None
        else _numbers(path, sheet, k, texts[k], meant.name, of_times if k == clock else kind)
        for k, meant in enumerate(named)
    ]
    found = table_of_cells(str(path), sheet.header, named, cells, printed, kind)
    return replace(
        found,
        name=called(path),
        remarks=(*remarks, *found.remarks),
        time_errors=_time_errors(found.times, named[clock], texts[clock], of_times, shown),
    )


def _numbers(
    path: Path,
    sheet: _Sheet,
    place: int,
    texts: Sequence[str],
    name: str,
    number: NumberType | None,
) -> Cells:
    """A column's exact numbers; ``number``: whose values its cells stand for."""
    found: list[float | Decimal | Fraction | None] = []
    read = expression.as_it_stands if number is None else partial(value, number=number)
    try:
        for text in texts:
            found.append(read(text) if text or name == "t" else None)
    except ExpressionError:
        line, row = sheet.rows[len(found)]
        expected = "a finite decimal number"
        raise BadInput(f"{path}:{line}", name, row[place], expected) from None
    return tuple(found)


def _time_errors(
    times: Sequence[Fraction],
    clock: Column,
    texts: Sequence[str],
    number: NumberType | None,
    digits: int,
) -> tuple[float, ...]:
    """By how much times may be off, as they are printed with so many digits.

    ``number``: whose values they are.
    """
    if number is not None:
        return of_type(times, number)
    rounded = of_decimals(times, abs(clock.factor) * last_place(texts))
    if not DIGITS_HELD["double"] <= digits <= DOUBLE.printed_digits:
        return rounded
    doubles = of_type(times, DOUBLE)
    return tuple(map(max, doubles, rounded)) if rounded else doubles


def is_empty(cell: str) -> bool:
    """Whether a cell has no number, as programs write it: nothing, or ``nan`` and its like.

    >>> is_empty("NaN"), is_empty("-nan"), is_empty("inf")
    (True, True, False)
    """
    return len(cell) < 5 and cell.lstrip("+-").lower() in _EMPTY


def value(cell: str, number: NumberType) -> float | Fraction:
    """A decimal's exact value, rounded to a number of a type.

    Raises ExpressionError for what is no finite decimal number.
    """
    if number.bits == DOUBLE.bits and len(cell) < _LONGEST and not cell.strip(_PLAIN):
        try:
            x = float(cell)
        except ValueError:
            x = 0.0
        if _LEAST < abs(x) < _MOST:
            return x
    return number.rounded(expression.decimal(cell))


def most_printed(columns: Sequence[Sequence[str]]) -> int:
    """The most significant digits of any cell, 1 or more."""
    found = 1
    for cells in columns:
        for cell in cells:
            if len(cell) > found and len(cell.lstrip("+-0.")) > found:  # else it has no more digits
                found = max(found, _significant(cell))
    return found


def last_place(cells: Sequence[str]) -> Fraction:
    """The least unit of a cell's last place."""
    return Fraction(10) ** min(map(_place, cells))


def _place(cell: str) -> int:
    """The power of ten of a decimal's last place."""
    mantissa, _, power = cell.lower().partition("e")
    return int(power or 0) - len(mantissa.partition(".")[2])


def _significant(cell: str) -> int:
    mantissa = cell.lower().partition("e")[0].lstrip("+-0.")
    return len(mantissa) - ("." in mantissa)
