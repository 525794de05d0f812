"""Tables in CSV files of other programs.

Separators are comma, semicolon, tab, or blanks, as the first line of the table has them, or as
Excel's ``sep=;`` before it says. Between semicolons or tabs the numbers may have decimal
commas, if none has a point. A header may stand in a comment (``# t p q r``, as NumPy writes
it), or be given. Numbers may be spelt as other languages write them: see :func:`plain_cell`.

A decimal that stands for a double is the double nearest to it, which Python's ``float`` gives;
all others are read exactly and rounded once.
"""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
import string
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from functools import partial
from itertools import chain, pairwise, zip_longest
from pathlib import Path
from typing import Any, NamedTuple

from polhode.common.arguments import each, numbers_given
from polhode.common.errors import BadInput, few, nearest
from polhode.common.files import STDIN, called, read_stdin, read_whole
from polhode.judging.tables import column_aliases
from polhode.judging.tables.column_aliases import PLAIN, Cells, NamedColumn, Naming
from polhode.judging.tables.table import TrajectoryTable
from polhode.numbers import expression, number_types
from polhode.numbers.conversion import exact_number, exactly, to_double
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import DOUBLE, AnyNumber, AnyVector, NumberType
from polhode.scenes.vocabulary import ATTITUDE, STATE

# --- type inference -------------------------------------------------------------------------------
#
# Of which number type the cells of a table are, and by how much its times may be off.
#
# Arrays and lists of floats say their type themselves; decimals may be numbers of a type, printed
# with more digits than the type has.  A row of a right program holds at a time that the table has
# only in a number type, or in decimals of so many places: late in a clock's time that costs digits
# that the program did not lose.


_WIDER = (number_types.SINGLE, DOUBLE, number_types.EXTENDED)
_KINDS = {"float32": 0, "float": 1, "float64": 1, "longdouble": 2}
_NEUTRAL = ("bool", "int", "NoneType")  # exact in every type, or empty, or refused elsewhere

_LOOKED_AT = 1000  # cells of a column
_TIMES = 2000  # that are looked at
_MANY = 8  # times that are not evenly spaced, of which the last digits tell
_ROUND = 3  # one in so many may end in 0
_FARTHEST = 400  # places of a cell that is looked at
_SURE = 4.0  # log10 of how seldom other decimals are of a type by chance


def type_of(parts: Iterable[Any]) -> NumberType | None:
    """The widest floating-point type of the cells; None where a cell is of no such type.

    ``parts``: arrays, lists or tuples of cells.  Integers and empty cells go with any type.
    """
    names: set[str] = set()
    for part in parts:
        dtype = getattr(part, "dtype", None)
        if dtype is not None and dtype.kind != "O":
            names.add(dtype.type.__name__)
        elif dtype is not None or isinstance(part, (list, tuple)):
            names |= {kind.__name__ for kind in {*map(type, part)}}
        else:
            return None
    floats = {x for x in names if x not in _NEUTRAL and not x.startswith(("int", "uint"))}
    if not floats or not floats <= _KINDS.keys():
        return None
    return _WIDER[max(_KINDS[name] for name in floats)]


def printed_type(columns: Iterable[Sequence[str]], printed: int) -> NumberType | None:
    """The narrowest type whose numbers decimals are, printed longer than it has digits, as NumPy's
    ``savetxt`` writes doubles; None where they are of no such type.  Of extended and quad numbers
    as many digits as they have tell; shorter decimals are read as doubles anyway.

    ``printed``: the most significant digits of any cell.  A decimal of fewer digits than the type's
    goes with any; each other must be the decimal of a number of the type.

    >>> printed_type([["1.599999999999999922e-01", "2.999999999999999889e-01", "4.5"]], 19)
    """
    some = [[column[k] for k in few(len(column), _LOOKED_AT)] for column in columns]
    for kind in (number_types.SINGLE, DOUBLE, number_types.EXTENDED, number_types.QUAD):
        if printed < _telling(kind):
            return None
        evidence = 0.0
        for cell in (cell for column in some for cell in column if cell):
            type_of_cell = _type_of(cell, kind)
            if type_of_cell is None:
                break
            evidence += type_of_cell
        else:
            if evidence >= _SURE:
                return kind
    return None


def _telling(kind: NumberType) -> int:
    """The digits from which on decimals tell of a type."""
    return kind.printed_digits + (kind.bits <= DOUBLE.bits)


def _type_of(cell: str, kind: NumberType) -> float | None:
    """How much a decimal tells for a type, as a power of ten; None where it is not of the type."""
    cells, place = _digits(cell)
    digits = "".join(map(str, cells))
    if len(digits.strip("0")) < _telling(kind) or abs(place) > _FARTHEST:
        return 0.0
    x, unit = Fraction(int(digits)), Fraction(10) ** place
    size = kind.rounded(x * unit)
    if abs(size - x * unit) >= unit:
        return None
    spacing = math.log10(x) - (kind.bits - 1) * math.log10(2)
    return max(0.0, spacing - math.log10(2))


def _digits(cell: str) -> tuple[tuple[int, ...], int]:
    """A decimal's digits from the first that is not 0 on, and the power of ten of its last place;
    those of 0 for what is no decimal, which is refused where the cells are read."""
    try:
        _, digits, place = Decimal(cell).as_tuple()
    except InvalidOperation:
        return (0,), 0
    return (digits, place) if isinstance(place, int) else ((0,), 0)


def most_printed(columns: Iterable[Sequence[str]]) -> int:
    """The most significant digits of any cell, 1 or more."""
    most = 1
    for cell in chain.from_iterable(columns):
        if len(cell) > most and len(cell.lstrip("+-0.")) > most:  # else it has no more digits
            most = max(most, len(_digits(cell)[0]))
    return most


def last_place(cells: Sequence[str]) -> Fraction:
    """The least unit of a cell's last place."""
    return Fraction(10) ** min(map(_place, cells))


def _place(cell: str) -> int:
    """The power of ten of a decimal's last place, at a third of the time that a Decimal takes."""
    mantissa, _, power = cell.lower().partition("e")
    return int(power or 0) - len(mantissa.partition(".")[2])


def of_type(times: Sequence[Fraction], number: NumberType) -> tuple[float, ...]:
    """Half a unit in the last place, at most, of times of a number type."""
    return tuple(abs(to_double(t)) * 2.0**-number.bits for t in times)


def of_decimals(times: Sequence[Fraction], unit: Fraction) -> tuple[float, ...]:
    """Half a unit of the last decimal place, if the times are rounded to it; empty if not.

    They are if they are evenly spaced but for a unit; or if they are not evenly spaced, and their
    last digits are of any kind.

    >>> thirds = [Fraction(k, 3) for k in range(4)]
    >>> of_decimals([Fraction(round(1000 * t), 1000) for t in thirds], Fraction(1, 1000))
    (0.0005, 0.0005, 0.0005, 0.0005)
    >>> of_decimals([Fraction(k, 10) for k in range(4)], Fraction(1, 10))
    ()
    """
    counts = [t / unit for t in times[:_TIMES]]
    steps = [after - before for before, after in pairwise(counts)]
    uneven = max(steps, default=Fraction(0)) - min(steps, default=Fraction(0))
    ending = sum(count % 10 == 0 for count in counts)
    arbitrary = len(counts) >= _MANY and ending * _ROUND <= len(counts)
    if uneven == 0 or (uneven > 2 and not arbitrary) or any(step == 0 for step in steps):
        return ()
    return (to_double(unit) / 2,) * len(times)


# --- given columns --------------------------------------------------------------------------------
#
# Tables of columns: what their names and cells mean, wherever they come from.


NAMING = "--columns 'NAME=COLUMN, ...' (in Python columns=[...])"
_OFF = 0.05  # of 1: a length in most rows that no noise of a unit vector has
MOST_PRINTED = 60  # digits that rows of exact numbers are counted as
_MISSING = ("MaskedConstant", "NAType")  # of NumPy's masked arrays, of pandas
MOST_DIGITS = 1000.0  # that are told of a table


def table_of_rows(
    states: Iterable[AnyVector],
    at: Iterable[AnyNumber] | None,
    columns: Sequence[str],
    number: NumberType | None = None,
) -> TrajectoryTable:
    """Rows of numbers as a table; raises BadInput.  ``number``: their type, where it is not plain.

    Floats, of Python or of an array, say so themselves; other numbers without ``number`` are exact.
    """
    if isinstance(at, Iterable) and not (hasattr(at, "dtype") or isinstance(at, (str, bytes))):
        at = list(at)  # an iterator is read once
    times = each("compare", "at", () if at is None else at, _exactly, "a list of times")
    try:
        rows = [list(row) for row in states]
    except TypeError as fault:
        expected = f"a run, a file, columns by name or rows of finite numbers ({fault})"
        raise BadInput("compare", "states", None, expected) from None
    if at is None or len(times) != len(rows) or not rows:
        raise BadInput("compare", "at", len(times), f"a time for each of {len(rows)} rows")
    unjudged = column_aliases.not_judged()
    judged = [name for name in column_aliases.known()[1:] if name not in unjudged]
    for name in each("compare", "columns", columns, str, "a list of names"):
        if name not in judged:
            raise BadInput("compare", "columns", name, nearest(name, judged))
    # Here, since of two columns of one name a mapping keeps the last.
    refuse_names("compare", "columns", columns, PLAIN.columns(columns))
    if any(len(row) != len(columns) for row in rows):
        expected = f"{len(columns)} numbers in each row: {', '.join(columns)}"
        raise BadInput("compare", "states", None, expected)
    named = dict(zip(columns, zip(*rows, strict=True), strict=True))
    return replace(table_of_columns({"t": at, **named}, number), name="states")


def table_of_columns(
    data: Any, number: NumberType | None = None, source: str = "compare", names: Naming = PLAIN
) -> TrajectoryTable:
    """Columns by name as a table: a mapping, a pandas DataFrame, an xarray Dataset.

    ``source``: what complaints name.  ``names``: what was said of single names.

    Names are those of a file's header; the time may be a DataFrame's index.  Columns of floats
    are known as such; nan, NaT and None are empty cells.  Raises BadInput.
    """
    if hasattr(data, "iloc"):  # a DataFrame
        if not hasattr(data, "columns"):
            expected = "columns by name, t among them: a DataFrame, not one Series"
            raise BadInput(source, "columns", type(data).__name__, expected)
        if names.columns([*map(str, data.columns), str(data.index.name)])[-1].name == "t":
            data = data.reset_index()
        arrays = {str(name): data[name].to_numpy() for name in data.columns}
    else:
        present = [*getattr(data, "coords", ()), *data.keys()]
        arrays = {str(name): getattr(data[name], "values", data[name]) for name in present}
    header, columns = _with_one_clock(source, names, [*arrays], [*arrays.values()])
    named = names.columns(header)
    clock = next((k for k, column in enumerate(named) if column.name == "t"), None)
    if clock is None:
        expected = f"a column t among them, or {NAMING} that names it"
        raise BadInput(source, "columns", ",".join(header), expected)
    names.refuse_absent(source, [*arrays])
    refuse_names(source, "columns", header, named)
    if number is None:
        both = zip(named, columns, strict=True)
        number = type_of(x for meant, x in both if meant.name not in (None, "t"))
    cells = [
        None if meant.name is None else each(source, name, x, _cell, "a column of numbers")
        for name, meant, x in zip(header, named, columns, strict=True)
    ]
    whole = all(isinstance(t, Fraction) and t.denominator == 1 for t in cells[clock] or ())
    named, remarks = column_aliases.by_clock(header, named) if whole else (named, ())
    printed = number.printed_digits if number else MOST_PRINTED
    table = table_of_cells(source, header, named, cells, printed, number)
    unit = abs(named[clock].factor)  # in units of a clock, unless they are floats
    errors = _time_errors(table.times, type_of([columns[clock]]), unit if unit < 1 else None)
    name = "columns" if source == "compare" else source
    return replace(table, name=name, remarks=(*remarks, *table.remarks), time_errors=errors)


def _with_one_clock(
    source: str, names: Naming, header: Sequence[str], columns: Sequence[Any]
) -> tuple[Sequence[str], Sequence[Any]]:
    """Columns whose time is in two of them, whole seconds and nanoseconds, with one instead."""
    if (places := names.stamp(header)) is None:
        return header, columns
    k, rest = places
    parts = []
    for place in places:
        cells, are_several = numbers_given(columns[place])
        if not are_several:
            raise BadInput(source, header[place], columns[place], "a column of whole numbers")
        parts.append(cells)
    times = []
    for row, stamp in enumerate(zip_longest(*parts), 1):
        try:
            seconds, nanoseconds = map(_count, stamp)
            times.append(f"{seconds}.{nanoseconds:09}")
            if nanoseconds >= 10**9:
                raise ValueError
        except (TypeError, ValueError):
            expected = f"whole seconds from 0 on, and in {header[rest]} whole nanoseconds below 1e9"
            key = f"{header[k]}, row {row}"
            raise BadInput(source, key, ", ".join(map(str, stamp)), expected) from None
    both = zip([*header], columns, strict=True)
    joined = [("t", times) if i == k else column for i, column in enumerate(both) if i != rest]
    return [name for name, _ in joined], [column for _, column in joined]


def _count(value: Any) -> int:
    """A whole number from 0 on; raises TypeError or ValueError for another."""
    number = _exactly(value)
    if number.denominator != 1 or number < 0:
        raise ValueError("not whole")
    return number.numerator


def table_of_cells(
    source: str,
    header: Sequence[str],
    named: Sequence[NamedColumn],
    cells: Sequence[Cells | None],
    printed: int,
    number: NumberType | None,
) -> TrajectoryTable:
    """What cells mean by their columns' names: in the scene's units, one column of each name.

    ``cells``: of each column; None of one that is not known.  Raises BadInput for a row without a
    time.
    """
    cells_by_name: dict[str, Cells] = {}
    for (name, factor), column in zip(named, cells, strict=True):
        if name is None or column is None:
            continue
        if factor != 1:
            column = tuple(x and exactly(x) * factor for x in column)
        cells_by_name[name] = column
    times = [exactly(t) for t in cells_by_name.pop("t") if t is not None]
    if not times or any(len(column) != len(times) for column in cells_by_name.values()):
        expected = "columns as long as t, with a time in each row"
        raise BadInput(source, "columns", ",".join(header), expected)
    ignored = tuple(name for name, meant in zip(header, named, strict=True) if meant.name is None)
    cells_by_name = column_aliases.with_quaternions(cells_by_name, number_types.bits_for(printed))
    yardstick = number or (DOUBLE if printed <= DOUBLE.printed_digits else number_types.mp(printed))
    most = number.most_digits if number else min(printed + 2.0, MOST_DIGITS)
    digits = min(most, yardstick.most_digits)
    cells_by_name, remarks = _with_rates(cells_by_name, header)
    return TrajectoryTable(
        source,
        tuple(times),
        cells_by_name,
        yardstick,
        digits,
        printed,
        ignored=ignored,
        remarks=remarks,
    )


def _with_rates(
    cells_by_name: dict[str, Cells], header: Sequence[str]
) -> tuple[dict[str, Cells], tuple[str, ...]]:
    """Columns in which ``gx gy gz`` beside a quaternion are rates, where they are not of length 1;
    and that they are, in words."""
    omega, gamma = STATE[:3], STATE[3:]
    beside = column_aliases.columns([*header, "ax"])  # what they are beside accelerations
    is_whole = {*gamma, *ATTITUDE} <= cells_by_name.keys() and not {*omega} & cells_by_name.keys()
    if not is_whole or not {*omega} <= {column.name for column in beside}:
        return cells_by_name, ()
    rows = zip(*(cells_by_name[name] for name in gamma), strict=True)
    sizes = [math.hypot(*(to_double(exactly(x)) for x in row)) for row in rows if None not in row]
    if 2 * sum(abs(size - 1) > _OFF for size in sizes) <= len(sizes):
        return cells_by_name, ()
    renamed = dict(zip(gamma, omega, strict=True))
    rates = {renamed.get(name, name): x for name, x in cells_by_name.items()}
    return rates, ("gx gy gz were read as rates, for they are no unit vector",)


def refuse_names(
    source: str, key: str, header: Sequence[str], named: Sequence[NamedColumn]
) -> None:
    """Raise BadInput for a column that is there twice, or a header with no column to judge."""
    names = [meant.name for meant in named]
    if twice := [x for x in column_aliases.readable() if names.count(x) > 1]:
        both = [repr(of) for of, meant in zip(header, names, strict=True) if meant == twice[0]]
        expected = f"each column once ({', '.join(both)}), or {NAMING} that chooses one"
        raise BadInput(source, key, twice[0], expected)
    if {*names} <= {None, "t"}:
        expected = f"columns besides t that can be judged: {NAMING} translates names"
        expected += f" to {', '.join(column_aliases.known()[1:])}"
        if "xyz[0]" in header:
            expected += " (PX4's xyz[0] is p in vehicle_angular_velocity alone)"
        raise BadInput(source, key, ",".join(header), expected)


def _time_errors(
    times: Sequence[Fraction],
    number: NumberType | None,
    unit: Fraction | None,
    are_doubles: bool = False,
) -> tuple[float, ...]:
    """By how much times may be off that are numbers of a type, or of ``unit``; of decimals that may
    be doubles ``are_doubles``."""
    if number is not None:
        return of_type(times, number)
    rounded = of_decimals(times, unit) if unit else ()
    doubles = of_type(times, DOUBLE) if are_doubles else ()
    return tuple(map(max, doubles, rounded)) if doubles and rounded else doubles or rounded


def _cell(value: Any) -> float | Fraction | None:
    """A cell's exact number, None where it is empty."""
    if value is None or type(value).__name__ in _MISSING or value != value:
        return None
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    return _exactly(value)


def _exactly(value: Any) -> Fraction:
    return exactly(exact_number(value))


# --- csv file -------------------------------------------------------------------------------------


MAX_BYTES = 1 << 30
MAX_LINE = 1_000_000  # characters
_EMPTY = ("", "nan", "na", "n/a", "#n/a", "<na>", "nat", "null", "none", "missing", r"\n")
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
_PLAIN = "0123456789+-.eE"
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


class Sheet(NamedTuple):
    """The cells of a file: its header, and its rows with the numbers of their lines.

    ``remarks``: how they were read.  Decimal commas are points now.  ``is_named``: whether the
    header names columns; else it is the first row.
    """

    header: Sequence[str]
    rows: list[tuple[int, list[str]]]
    remarks: tuple[str, ...] = ()
    is_named: bool = True


def read_csv(path: Path, number: NumberType | None, names: Naming) -> TrajectoryTable:
    """A CSV file as a table, of ``-`` the standard input; raises BadInput.

    ``number``: its decimals stand for numbers of it.  ``names``: columns that were named beside it.
    """
    piped = str(path) == "-"
    path = Path(STDIN) if piped else path
    readable = "a readable CSV file"
    content = read_stdin(MAX_BYTES, readable) if piped else read_whole(path, MAX_BYTES, readable)
    sheet = sheet_of(path, content, names)
    header, count = sheet.header, len(sheet.header)
    if not header:
        raise BadInput(str(path), "file", None, "a header line that names the columns")
    if names.stamp(header) is None and all(x.name != "t" for x in names.columns(header)):
        raise BadInput(str(path), "header", ",".join(header), _ACCEPTED)
    names.refuse_absent(str(path), header)
    for line, row in sheet.rows:
        if len(row) != count:
            expected = f"{count} values"
            if len(row) == count + 1:
                expected += ", one a column of the header (names of rows, as R's, in quotes)"
            raise BadInput(f"{path}:{line}", "line", ",".join(row), expected)
    columns = [*zip(*(row for _, row in sheet.rows), strict=True)] or [()] * count
    header, texts = _with_one_clock(str(path), names, header, columns)
    named = names.columns(header)
    refuse_names(str(path), "header", header, named)
    if not sheet.rows:
        raise BadInput(str(path), "file", None, "at least one line of numbers")
    clock = next(k for k, meant in enumerate(named) if meant.name == "t")
    whole = all(cell.isdecimal() for cell in texts[clock])
    named, remarks = column_aliases.by_clock(header, named) if whole else (named, ())
    judged = [x for meant, x in zip(named, texts, strict=True) if meant.name not in (None, "t")]
    printed, shown = most_printed(judged), most_printed([texts[clock]])
    kind = of_times = number
    if number is None:
        kind = printed_type(judged, printed)
        of_times = printed_type([texts[clock]], shown)
        if kind is not None:
            remark = f"read as: numbers of {kind.name}, printed to {printed} digits"
            remarks = (remark, *remarks)
            printed = kind.printed_digits
    lines = [f"{path}:{line}" for line, _ in sheet.rows]
    cells = [
        None
        if meant.name is None
        else _numbers(lines, texts[k], meant.name, of_times if k == clock else kind)
        for k, meant in enumerate(named)
    ]
    table = table_of_cells(str(path), header, named, cells, printed, kind)
    return replace(
        table,
        name=called(path),
        remarks=(*remarks, *table.remarks, *sheet.remarks),
        time_errors=_time_errors(
            table.times,
            of_times,
            None if of_times else abs(named[clock].factor) * last_place(texts[clock]),
            number_types.DIGITS_HELD["double"] <= shown <= DOUBLE.printed_digits,
        ),
    )


def sheet_of(path: Path, content: bytes, names: Naming) -> Sheet:
    """The cells of a CSV file; raises BadInput."""
    try:
        return _sheet([*io.StringIO(_text(content), newline="")], names)
    except (ValueError, csv.Error) as fault:
        raise BadInput(str(path), "file", None, f"a readable CSV file ({fault})") from None


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


def _sheet(lines: list[str], names: Naming) -> Sheet:
    """The cells of a file's lines; raises csv.Error for a line without end."""
    if max(map(len, lines), default=0) > MAX_LINE:
        raise csv.Error("not a CSV text: a line without end")
    if chosen := _CHOSEN.fullmatch(lines[0] if lines else ""):
        lines = ["\n", *lines[1:]]
    plain = ["\n" if _COMMENT.match(line) else line for line in lines]
    first = next((k for k, line in enumerate(plain) if line.strip(_BLANK)), None)
    if first is None:
        return Sheet((), [])
    wide = next((mark for mark in ";\t" if mark in plain[first]), "")
    commas = wide != "" and _have_decimal_commas(plain[first:], wide)
    separator = chosen[1] if chosen else wide if commas else _separator(plain[first])
    top, *rows = _rows(plain[first:], separator, first)
    header: Sequence[str] = names.header
    if _are_numbers(top[1], commas):
        rows = [top, *rows]
        header = header or _commented(lines[:first], len(top[1]), names)
    is_named = bool(header) or top not in rows
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
    return Sheet(header, rows, tuple(remarks), is_named)


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
    try:
        return bool([expression.decimal(cell) for cell in cells if cell])
    except ExpressionError:
        return False


def _commented(lines: Sequence[str], count: int, names: Naming) -> Sequence[str]:
    """The last comment that names so many columns, t among them, or all of which are known, as
    those of starts; empty where none does."""
    for line in reversed(lines):
        text = line.lstrip(_MARKS)
        for _, cells in _rows([text], _separator(text), 0):
            meant = [column.name for column in names.columns(cells)]
            if len(cells) == count and ("t" in meant or None not in meant):
                return cells
    return ()


def _numbers(
    lines: Sequence[str], texts: Sequence[str], name: str, number: NumberType | None
) -> Cells:
    """A column's exact numbers; ``number``: whose values its cells stand for.

    ``lines``: what complaints name of each.
    """
    numbers: list[float | Decimal | Fraction | None] = []
    read = expression.as_it_stands if number is None else partial(value, number=number)
    try:
        for text in texts:
            numbers.append(read(text) if text or name == "t" else None)
    except ExpressionError:
        cell, expected = texts[len(numbers)], "a finite decimal number"
        if cell and not cell.strip("*"):
            expected += " (asterisks stand where a format of Fortran was too narrow for it)"
        raise BadInput(lines[len(numbers)], name, cell, expected) from None
    return tuple(numbers)


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
    if number.bits == DOUBLE.bits and not cell.strip(_PLAIN):
        with suppress(ValueError):
            if _LEAST < abs(x := float(cell)) < _MOST:
                return x
    return number.rounded(expression.decimal(cell))
