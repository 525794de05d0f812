"""Tables in CSV files of other programs.

Separators are comma, semicolon, tab, or blanks, as the first line of the table has them, or as
Excel's ``sep=;`` before it says.  Between semicolons or tabs the numbers may have decimal commas,
if none has a point.  A header may stand in a comment (``# t p q r``, as NumPy writes it), or be
given.  Numbers may be spelt as other languages write them: see :func:`plain_cell`.

A decimal that stands for a double is the double nearest to it, which Python's ``float`` gives; all
others are read exactly and rounded once.
"""

from __future__ import annotations

import codecs
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
from polhode.judging.tables.column_aliases import Column, Naming, by_clock
from polhode.judging.tables.given_columns import refuse_names, table_of_cells
from polhode.judging.tables.table import Table
from polhode.judging.tables.type_inference import of_decimals, of_type, printed_type
from polhode.numbers import expression
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import DIGITS_HELD, DOUBLE, NumberType

MAX_BYTES = 1 << 30
MAX_LINE = 1_000_000  # characters
_EMPTY = ("", "nan", "na", "n/a", "#n/a", "<na>", "nat", "null", "none", "missing", r"\n")
_PLAIN = "0123456789+-.eE"
#: Not a number as C's library of Windows prints it, ``-nan(ind)`` now and ``-1.#IND`` once, and as
#: others do with its bits, ``nan(0x8000)``.
_NAN = re.compile(r"[+-]?(?:nan\(\w*\)|1\.#(?:ind|[qs]?nan)0*)", re.I)
_ODD = re.compile(r"[^0-9eE.,+-]|(?<=[0-9.])[+-]")  # in a row of which a cell is no plain decimal
_DECIMAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
#: Fortran's exponents, ``1.0D+00`` and, of three digits, ``0.123-101``; Mathematica's ``1.5*^-7``.
_FOREIGN = re.compile(
    r"([+-]?(?:\d+\.\d*|\.\d+|\d+(?=\*)))(?:(?:[dDqQ]|\*\^)([+-]?\d+)|([+-]\d{3}))", re.ASCII
)
#: A number as Python's ``repr`` writes one that is no float.
_REPR = re.compile(
    r"(?:(?:np|numpy)\.(?:float|double|longdouble|u?int)\w*|Decimal|(?:mp\.|mpmath\.)?mpf|tensor)"
    r"\((['\"]?)([^()'\"]+|-?nan\(\w*\))\1\)"
)
_LONGEST = 60  # characters of a cell that is read as a double at once
_LEAST, _MOST = 1e-290, 1e290  # within them a double has all its bits
_SEPARATORS = ",;\t"
_BLANK = _SEPARATORS + string.whitespace
_WITH_COMMA = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eEdD]?[+-]?\d+)?")
_COMMENT = re.compile(r"\s*(?:#(?!N/A)|//|!|%(?!time\b))")  # %time heads a column of ROS
_MARKS = "#/!%" + string.whitespace
_CHOSEN = re.compile(r'"?sep=([^"\r\n])"?\s*', re.I)
#: A line that R wrote: the row's name in quotation marks, and numbers, which have none.
_NAMED_ROW = re.compile(r'\s*"(?:[^"]|"")*"[,;\t ]\s*[^"\s]')
#: How files begin that are no text, what they are, and what to do with them.
_OTHER_FILES = {
    b"PK\x03\x04": "a spreadsheet or an archive: save it as CSV, or unpack it",
    b"\xd0\xcf\x11\xe0": "a spreadsheet: save it as CSV",
    b"\x1f\x8b": "compressed: unpack it",
    b"\x89HDF": "HDF5: write its columns as CSV or .npz",
    b"MATLAB 5.0 MAT-file": "MATLAB's: write its columns with writetable",
    b"ULog\x01": "PX4's log: ulog2csv writes its topics as CSV",
    b"#ROSBAG": "a bag of ROS: write its topic as CSV",
    b"\x89MCAP": "a bag of ROS: write its topic as CSV",
    b"SQLite format 3\0": "a database: write its table as CSV",
}
_BOMS = (
    (codecs.BOM_UTF32_LE, "utf-32"),  # it begins as that of UTF-16 does
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_ACCEPTED = (
    "a header with a column t (or time, timestamp) and other columns, separated by commas, "
    "semicolons, tabs or blanks, also after #; or --columns t,p,q,... that names them, or "
    "--columns NAME=t"
)


class _Sheet(NamedTuple):
    """The cells of a file: its header, and its rows with the numbers of their lines.

    ``remarks``: how they were read.  Decimal commas are points now.
    """

    header: Sequence[str]
    rows: list[tuple[int, list[str]]]
    remarks: tuple[str, ...] = ()


def read_csv(path: Path, number: NumberType | None, names: Naming) -> Table:
    """A CSV file as a table, of ``-`` the standard input; raises BadInput.

    ``number``: its decimals stand for numbers of it.  ``names``: columns that were named beside it.
    """
    piped = str(path) == "-"
    path = Path(STDIN) if piped else path
    what = "a readable CSV file"
    content = read_stdin(MAX_BYTES, what) if piped else read_whole(path, MAX_BYTES, what)
    try:
        sheet = _sheet([*io.StringIO(_text(content), newline="")], names)
    except (ValueError, csv.Error) as fault:
        raise BadInput(str(path), "file", None, f"{what} ({fault})") from None
    if not sheet.header:
        raise BadInput(str(path), "file", None, "a header line that names the columns")
    places = names.stamp(sheet.header)
    if places is None and all(meant.name != "t" for meant in names.columns(sheet.header)):
        raise BadInput(str(path), "header", ",".join(sheet.header), _ACCEPTED)
    for line, row in sheet.rows:
        if (count := len(sheet.header)) != len(row):
            expected = f"{count} values"
            if len(row) == count + 1:
                expected += ", one a column of the header (names of rows, as R's, in quotes)"
            raise BadInput(f"{path}:{line}", "line", ",".join(row), expected)
    if places is not None:
        sheet = _with_whole_stamps(path, sheet, places)
    header, named = sheet.header, names.columns(sheet.header)
    refuse_names(str(path), "header", header, named)
    if not sheet.rows:
        raise BadInput(str(path), "file", None, "at least one line of numbers")
    found = _table(path, sheet, named, number)
    return replace(found, remarks=(*found.remarks, *sheet.remarks))


def _text(content: bytes) -> str:
    """A file's text, in UTF-8, or in UTF-16 or UTF-32 with their marks; raises ValueError."""
    for beginning, kind in _OTHER_FILES.items():
        if content.startswith(beginning):
            raise ValueError(f"it is {kind}")
    coding = next((name for mark, name in _BOMS if content.startswith(mark)), "utf-8-sig")
    try:
        text = content.decode(coding)
    except UnicodeDecodeError as fault:
        line = content[: fault.start].count(b"\n") + 1
        odd = f"byte 0x{content[fault.start]:02x} in line {line} is not {coding[:6].upper()}"
        raise ValueError(f"not a CSV text: {odd.removesuffix('-')}") from None
    if "\0" in text:
        raise ValueError("not a CSV text: it has bytes 0, as UTF-16 has without its mark")
    return text


def _sheet(lines: list[str], names: Naming) -> _Sheet:
    """The cells of a file's lines; raises csv.Error for a line without end."""
    if max(map(len, lines), default=0) > MAX_LINE:
        raise csv.Error("not a CSV text: a line without end")
    if chosen := _CHOSEN.fullmatch(lines[0] if lines else ""):
        lines = ["\n", *lines[1:]]
    plain = ["\n" if _COMMENT.match(line) else line for line in lines]
    first = next((k for k, line in enumerate(plain) if line.strip(_BLANK)), None)
    if first is None:
        return _Sheet((), [])
    wide = next((mark for mark in ";\t" if mark in plain[first]), "")
    commas = wide != "" and _have_decimal_commas(plain[first:], wide)
    separator = chosen[1] if chosen else wide if commas else _separator(plain[first])
    top, *rows = _rows(plain[first:], separator, first)
    header: Sequence[str] = names.header
    if _are_numbers(top[1], commas):
        rows = [top, *rows]
        header = header or _commented(lines[:first], len(top[1]), names)
    header = header or top[1]
    remarks = ["read as: decimal commas"] if commas else []
    if {len(row) for _, row in rows} == {len(header) + 1}:
        named = [line for line in plain[first:] if line.strip()][-len(rows) :]
        if all(map(_NAMED_ROW.match, named)):
            rows = [(line, row[1:]) for line, row in rows]
            remarks.append("read as: the first cell of each row is its name, as R writes them")
        elif not any(row[-1] for _, row in rows):  # a separator ends each row
            rows = [(line, row[:-1]) for line, row in rows]
    if commas:
        rows = [(line, [cell.replace(",", ".") for cell in row]) for line, row in rows]
    rows = [
        (line, [*map(plain_cell, row)] if _ODD.search(",".join(row)) else row) for line, row in rows
    ]
    return _Sheet(header, rows, tuple(remarks))


def _with_whole_stamps(path: Path, sheet: _Sheet, places: tuple[int, int]) -> _Sheet:
    """A sheet whose time is in two columns, seconds and nanoseconds, as one that has it in one."""
    k, rest = places
    rows = []
    for line, row in sheet.rows:
        if not (row[k].isdecimal() and row[rest].isdecimal() and len(row[rest]) < 10):
            expected = f"whole seconds, and in {sheet.header[rest]} whole nanoseconds below 1e9"
            raise BadInput(f"{path}:{line}", sheet.header[k], f"{row[k]}, {row[rest]}", expected)
        rows.append((line, _joined(row, places, f"{row[k]}.{row[rest]:0>9}")))
    return sheet._replace(header=_joined(sheet.header, places, "t"), rows=rows)


def _joined(cells: Sequence[str], places: tuple[int, int], time: str) -> list[str]:
    """A row with its time instead of two parts of it."""
    k, rest = places
    return [time if i == k else cell for i, cell in enumerate(cells) if i != rest]


def _rows(lines: Sequence[str], separator: str, before: int) -> list[tuple[int, list[str]]]:
    """Rows of cells with the numbers of their lines; ``before``: lines that stand before them."""
    stripped = (line.strip() for line in lines) if separator == " " else lines
    reader = csv.reader(stripped, delimiter=separator, skipinitialspace=True)
    rows = ((before + reader.line_num, [cell.strip() for cell in row]) for row in reader)
    return [(line, row) for line, row in rows if any(row)]


def _separator(line: str) -> str:
    return next((mark for mark in _SEPARATORS if mark in line), " " if " " in line.strip() else ",")


def _have_decimal_commas(lines: Sequence[str], separator: str) -> bool:
    """Whether cells between separators are numbers with a comma, or have neither comma nor point,
    and one has a comma; the first line may be a header."""
    cells = (cell.strip() for line in lines[1:] or lines for cell in line.split(separator))
    marked = [cell for cell in cells if "," in cell or "." in cell]
    return bool(marked) and all(map(_WITH_COMMA.fullmatch, marked))


def _are_numbers(row: Sequence[str], commas: bool) -> bool:
    """Whether cells are numbers, with decimal commas perhaps, so that they are no header."""
    cells = [plain_cell(cell.replace(",", ".") if commas else cell) for cell in row]
    return any(cells) and all(map(_is_decimal, filter(None, cells)))


def _is_decimal(cell: str) -> bool:
    try:
        expression.decimal(cell)
    except ExpressionError:
        return False
    return True


def _commented(lines: Sequence[str], count: int, names: Naming) -> Sequence[str]:
    """The last comment that names so many columns, t among them; empty where none does."""
    for line in reversed(lines):
        text = line.lstrip(_MARKS)
        for _, cells in _rows([text], _separator(text), 0):
            if len(cells) == count and any(one.name == "t" for one in names.columns(cells)):
                return cells
    return ()


def _table(path: Path, sheet: _Sheet, named: list[Column], number: NumberType | None) -> Table:
    texts = [*zip(*(row for _, row in sheet.rows), strict=True)]
    clock = next(k for k, meant in enumerate(named) if meant.name == "t")
    whole = all(cell.isdecimal() for cell in texts[clock])
    named, remarks = by_clock(sheet.header, named) if whole else (named, ())
    judged = [x for meant, x in zip(named, texts, strict=True) if meant.name not in (None, "t")]
    printed, shown = most_printed(judged), most_printed([texts[clock]])
    kind = of_times = number
    if number is None:
        kind = printed_type(judged, printed)
        of_times = printed_type([texts[clock]], shown)
        if kind is not None:
            told = f"read as: numbers of {kind.name}, printed to {printed} digits"
            remarks = (told, *remarks)
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
        if row[place] and not row[place].strip("*"):
            expected += " (asterisks stand where a format of Fortran was too narrow for it)"
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


def plain_cell(cell: str) -> str:
    """A cell's number as a plain decimal, "" where it has none; any other cell as it is.

    None has an empty cell, and ``nan`` or another word for that, as programs write them.

    >>> [plain_cell(x) for x in ("1.5D+00", "0.25-101", "2.*^-7", "np.float64(0.1)", "-nan(ind)")]
    ['1.5e+00', '0.25e-101', '2.e-7', '0.1', '']
    >>> plain_cell("1/3"), plain_cell("inf"), plain_cell("NaN"), plain_cell("****")
    ('1/3', 'inf', '', '****')
    """
    if _DECIMAL.fullmatch(cell):
        return cell
    cell = cell.replace("\N{MINUS SIGN}", "-")
    if wrapped := _REPR.fullmatch(cell):
        cell = wrapped[2]
    if cell.lstrip("+-").lower() in _EMPTY or _NAN.fullmatch(cell):
        return ""
    foreign = _FOREIGN.fullmatch(cell)
    return f"{foreign[1]}e{foreign[2] or foreign[3]}" if foreign else cell


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
