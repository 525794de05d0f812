"""Tables of columns: what their names and cells mean, wherever they come from."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from polhode.common.arguments import each
from polhode.common.errors import BadInput, nearest
from polhode.judging.tables.attitude_forms import Cells, with_quaternions
from polhode.judging.tables.column_aliases import (
    PLAIN,
    Column,
    Naming,
    by_clock,
    columns,
    known,
    not_judged,
    twice,
)
from polhode.judging.tables.reading import degree
from polhode.judging.tables.table import Table
from polhode.judging.tables.type_inference import of_decimals, of_type, type_of
from polhode.numbers.conversion import exact_number, exactly, to_double
from polhode.numbers.number_types import DOUBLE, NumberType, bits_for, mp
from polhode.numbers.scalars import AnyNumber, AnyVector
from polhode.scenes.vocabulary import ATTITUDE, STATE

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
) -> Table:
    """Rows of numbers as a table; raises BadInput.  ``number``: their type, where it is not plain.

    Floats, of Python or of an array, say so themselves; other numbers without ``number`` are exact.
    """
    at = at if at is None or hasattr(at, "dtype") or not isinstance(at, Iterable) else list(at)
    times = each("compare", "at", () if at is None else at, _exactly, "a list of times")
    try:
        rows = [list(row) for row in states]
    except TypeError as fault:
        expected = f"a run, a file, columns by name or rows of finite numbers ({fault})"
        raise BadInput("compare", "states", None, expected) from None
    if at is None or len(times) != len(rows) or not rows:
        raise BadInput("compare", "at", len(times), f"a time for each of {len(rows)} rows")
    judged = [name for name in known()[1:] if name not in not_judged()]
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
    given: Any,
    number: NumberType | None = None,
    source: str = "compare",
    names: Naming = PLAIN,
) -> Table:
    """Columns by name as a table: a mapping, a pandas DataFrame, an xarray Dataset.

    ``source``: what complaints name.  ``names``: what was said of single names.

    Names are those of a file's header; the time may be a DataFrame's index.  Columns of floats
    are known as such; nan, NaT and None are empty cells.  Raises BadInput.
    """
    if hasattr(given, "iloc"):  # a DataFrame
        if not hasattr(given, "columns"):
            expected = "columns by name, t among them: a DataFrame, not one Series"
            raise BadInput(source, "columns", type(given).__name__, expected)
        if names.columns([str(given.index.name)])[0].name == "t":
            given = given.reset_index()
        held = {str(name): given[name].to_numpy() for name in given.columns}
    else:
        present = [*getattr(given, "coords", ()), *given.keys()]
        held = {str(name): getattr(given[name], "values", given[name]) for name in present}
    if (places := names.stamp([*held])) is not None:
        held = _with_whole_stamps(source, held, *([*held][k] for k in places))
    header = [*held]
    named = names.columns(header)
    clock = next((k for k, one in enumerate(named) if one.name == "t"), None)
    if clock is None:
        expected = f"a column t among them, or {NAMING} that names it"
        raise BadInput(source, "columns", ",".join(header), expected)
    refuse_names(source, "columns", header, named)
    if number is None:
        judged = zip(header, named, strict=True)
        number = type_of(held[name] for name, one in judged if one.name not in (None, "t"))
    cells = [
        None if one.name is None else each(source, name, held[name], _cell, "a column of numbers")
        for name, one in zip(header, named, strict=True)
    ]
    whole = all(isinstance(t, Fraction) and t.denominator == 1 for t in cells[clock] or ())
    named, remarks = by_clock(header, named) if whole else (named, ())
    printed = number.printed_digits if number else MOST_PRINTED
    found = table_of_cells(source, header, named, cells, printed, number)
    errors = _errors(found.times, held[header[clock]], named[clock].factor)
    name = "columns" if source == "compare" else source
    return replace(found, name=name, remarks=(*remarks, *found.remarks), time_errors=errors)


def _with_whole_stamps(
    source: str, held: Mapping[str, Any], seconds: str, rest: str
) -> dict[str, Any]:
    """Columns whose time is in two of them, seconds and nanoseconds, as one of them."""
    parts = [each(source, name, held[name], _whole, "whole numbers") for name in (seconds, rest)]
    if not all(0 <= part < 10**9 for part in parts[1]) or len(parts[0]) != len(parts[1]):
        raise BadInput(source, rest, None, "whole nanoseconds below 1e9, one for each second")
    times = [Fraction(whole * 10**9 + part, 10**9) for whole, part in zip(*parts, strict=True)]
    joined = {"t" if name == seconds else name: x for name, x in held.items() if name != rest}
    return joined | {"t": times}


def _whole(value: Any) -> int:
    exact = _exactly(value)
    if exact.denominator != 1:
        raise ValueError("not whole")
    return exact.numerator


def table_of_cells(
    source: str,
    header: Sequence[str],
    named: Sequence[Column],
    cells: Sequence[Cells | None],
    printed: int,
    number: NumberType | None,
) -> Table:
    """What cells mean by their columns' names: in the scene's units, one column of each name.

    ``cells``: of each column; None of one that is not known.  Raises BadInput for a row without a
    time.
    """
    found: dict[str, Cells] = {}
    for (name, degrees, factor), column in zip(named, cells, strict=True):
        if name is None or column is None:
            continue
        if degrees or factor != 1:
            scale = factor * degree() if degrees else factor
            column = tuple(x and exactly(x) * scale for x in column)
        found[name] = column
    times = [exactly(t) for t in found.pop("t") if t is not None]
    if not times or any(len(column) != len(times) for column in found.values()):
        expected = "columns as long as t, with a time in each row"
        raise BadInput(source, "columns", ",".join(header), expected)
    ignored = tuple(name for name, one in zip(header, named, strict=True) if one.name is None)
    found = with_quaternions(found, bits_for(printed))
    yardstick = number or (DOUBLE if printed <= DOUBLE.printed_digits else mp(printed))
    told = number.most_digits if number else min(printed + 2.0, MOST_DIGITS)
    held = min(told, yardstick.most_digits)
    found, remarks = _with_rates(found, header)
    return Table(
        source, tuple(times), found, yardstick, held, printed, ignored=ignored, remarks=remarks
    )


def _with_rates(
    found: dict[str, Cells], header: Sequence[str]
) -> tuple[dict[str, Cells], tuple[str, ...]]:
    """Columns in which ``gx gy gz`` beside a quaternion are rates, where they are not of length 1;
    and that they are, in words."""
    omega, gamma = STATE[:3], STATE[3:]
    beside = columns([*header, "ax"])  # what they are beside accelerations
    if not {*gamma, *ATTITUDE} <= found.keys() or {*omega} & found.keys():
        return found, ()
    if not {*omega} <= {one.name for one in beside}:
        return found, ()
    rows = zip(*(found[name] for name in gamma), strict=True)
    sizes = [math.hypot(*(to_double(exactly(x)) for x in row)) for row in rows if None not in row]
    if 2 * sum(abs(size - 1) > _OFF for size in sizes) <= len(sizes):
        return found, ()
    rates = {omega[gamma.index(name)] if name in gamma else name: x for name, x in found.items()}
    return rates, ("gx gy gz were read as rates, for they are no unit vector",)


def refuse_names(source: str, key: str, header: Sequence[str], named: Sequence[Column]) -> None:
    """Raise BadInput for a column that is there twice, or a header with no column to judge."""
    if (name := twice(named)) is not None:
        both = [f"{of!r}" for of, meant in zip(header, named, strict=True) if meant.name == name]
        expected = f"each column once ({', '.join(both)}), or {NAMING} that chooses one"
        raise BadInput(source, key, name, expected)
    if all(meant.name in (None, "t") for meant in named):
        expected = f"columns besides t that can be judged: {NAMING} translates names"
        expected += f" to {', '.join(known()[1:])}"
        if "xyz[0]" in header:
            expected += " (PX4's xyz[0] is p in vehicle_angular_velocity alone)"
        raise BadInput(source, key, ",".join(header), expected)


def _errors(times: Sequence[Fraction], given: Any, factor: Fraction) -> tuple[float, ...]:
    """By how much times may be off that were given so: in floats, or in units of a clock."""
    number = type_of([given])
    if number is None:
        return of_decimals(times, abs(factor)) if factor < 1 else ()
    return of_type(times, number)


def _cell(value: Any) -> float | Fraction | None:
    """A cell's exact number, None where it is empty."""
    if value is None or type(value).__name__ in _MISSING or value != value:
        return None
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    return _exactly(value)


def _exactly(value: Any) -> Fraction:
    return exactly(exact_number(value))
