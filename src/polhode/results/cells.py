"""Values as texts and back; one word tells of which type the values of a column or a fact are.

========== ========================================= ================================
word       values                                    text
========== ========================================= ================================
double     float; none is nan                        the shortest that round-trips
integer    int below 2**53; no gaps                  its digits
truth      bool; no gaps                             true, false
text       str                                       itself
exact      Fraction                                  every decimal digit, else ``7/3``
N digits   Fraction, rounded to N decimal digits     those
N bits     binary numbers that are no doubles        1 + ceil(N log10 2) digits
========== ========================================= ================================

Where there is no number the text is empty.  And tables for people: numbers rounded as their columns
say, balls to the digits that are proven.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from html import escape
from types import NoneType
from typing import Any

from polhode.common.errors import aligned, printable
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, number_value
from polhode.numbers.decimals import Ball, decimal_string, guaranteed, in_full, is_decimal, strings
from polhode.numbers.exact import Irrational
from polhode.numbers.number_types import DOUBLE as DOUBLE_TYPE
from polhode.numbers.number_types import EXTENDED, Doubles, NumberType
from polhode.results.table import Column, Fact, Table, Value, Values

DOUBLE, INTEGER, TRUTH = "double", "integer", "truth"
TEXT, EXACT, OBJECT = "text", "exact", "object"
#: NumPy's types, in files too, of the words that have one; values of the others are texts there.
DTYPES = {DOUBLE: "<f8", INTEGER: "<i8", TRUTH: "|b1"}
MOST_BITS = 1 << 16
#: Of a decimal: a number of that many bits in full.
MOST_CHARACTERS, MOST_EXPONENT = 70_000, 20_000
MOST_ENTRIES = 100  # of an object
_IRRATIONAL_DIGITS = 40
_SAFE = 1 << 53  # integers that every reader of JSON keeps
_DECIMAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE]([+-]?\d{1,5}))?", re.ASCII)
_INFINITE = ("inf", "-inf")


def bits_word(number_type: NumberType) -> str:
    """The word for numbers of a type."""
    return DOUBLE if number_type == DOUBLE_TYPE else f"{number_type.bits} bits"


def digits_word(digits: int) -> str:
    """The word for exact numbers that are told to so many digits."""
    return f"{digits} digits"


def word_of(x: Column | Fact) -> str:
    """The word for a column's type, or a fact's that is no table: of a list that of its values."""
    if isinstance(x, Column):
        return type_of(x.values, x.type)
    if isinstance(x.value, Mapping):
        return OBJECT
    return type_of(x.value if isinstance(x.value, (list, tuple)) else [x.value], x.type)


def type_of(values: Values, word: str = "") -> str:
    """The word for some values, unless it is told; TypeError where they do not say it."""
    if word:
        return word
    import numpy as np

    if isinstance(values, np.ndarray) and values.dtype.kind != "O":
        kinds: set[type] = {values.dtype.type}
    else:
        kinds = set(map(type, values))
    gaps = type(None) in kinds
    kinds.discard(type(None))
    if not kinds:
        return DOUBLE
    if _all(kinds, bool, np.bool_) and not gaps:
        return TRUTH
    if _all(kinds, str):
        return TEXT
    if Irrational in kinds:
        return digits_word(_IRRATIONAL_DIGITS)
    if Fraction in kinds and _all(kinds, Fraction, int):
        return EXACT
    if _all(kinds, int, np.integer):
        there = [x for x in values if x is not None] if gaps else values
        if max(int(np.max(there, initial=0)), -int(np.min(there, initial=0))) >= _SAFE:
            return EXACT
        return DOUBLE if gaps else INTEGER
    if _all(kinds, int, np.integer, float, np.float32, np.float16):
        return DOUBLE
    if _all(kinds, np.longdouble):
        return bits_word(EXTENDED)
    raise TypeError(f"values of {', '.join(sorted(x.__name__ for x in kinds))} need their type")


def _all(kinds: set[type], *of: type) -> bool:
    return all(issubclass(kind, of) and (kind is not bool or bool in of) for kind in kinds)


def texts(values: Values, kind: str) -> list[str]:
    """The cells of a column: numbers round-trip, and are empty where there is none."""
    if kind == DOUBLE:
        cells = list(map(repr, doubles(values).tolist()))
        return ["" if x == "nan" else x for x in cells] if "nan" in cells else cells
    if kind == TRUTH:
        return ["true" if x else "false" for x in values]
    if kind == INTEGER:
        return [str(int(x)) for x in values]
    if kind == TEXT:
        return ["" if x is None else _whole_characters(str(x)) for x in values]
    digits = 0 if kind == EXACT else _digits(kind) or _number(kind).printed_digits
    return ["" if x is None else wide(x, digits) for x in values]


def doubles(values: Values) -> Doubles:
    """Values of the type double as an array, nan where there is none."""
    import numpy as np

    if isinstance(values, np.ndarray) and values.dtype.kind != "O":
        return values.astype(np.float64, copy=False)
    return np.array([np.nan if x is None else x for x in values], dtype=np.float64)


def _whole_characters(text: str) -> str:
    """A text that every file can hold: no half of a character, no NUL, which numpy cuts off."""
    if text.isascii() and "\0" not in text:
        return text
    return text.encode(errors="replace").decode().replace("\0", "?")


def wide(x: Value, digits: int) -> str:
    """An exact or wide number to so many digits, of 0 in full; empty for nan."""
    if isinstance(x, Irrational):
        x = exact.nearest(x, 4 * digits)
    if x != x:
        return ""
    try:
        number = exactly(x)
    except ValueError:
        return "inf" if x > 0 else "-inf"
    return decimal_string(number, digits) if digits else in_full(number)


def values_of(cells: Sequence[str], kind: str) -> Any:
    """What cells stand for: an array of numbers where numpy has the type; ValueError for others."""
    import numpy as np

    if kind == DOUBLE:
        return np.array([x or "nan" for x in cells], dtype=np.str_).astype(np.float64)
    if kind == INTEGER:
        return np.array([int(x) for x in cells], dtype=np.int64)
    if kind == TRUTH:
        return np.array([_TRUTHS[x] for x in cells], dtype=np.bool_)
    if kind == TEXT:
        return list(cells)
    if kind == EXACT or _digits(kind):
        return [None if x == "" else _fraction(x) for x in cells]
    number = _number(kind)
    numbers = [None if x == "" else _binary(x, number) for x in cells]
    if number.flat:
        return np.array([np.nan if x is None else x for x in numbers], dtype=np.longdouble)
    objects = np.empty(len(numbers), dtype=np.object_)
    objects[:] = numbers
    return objects


_TRUTHS = {"true": True, "false": False}


def json_values(values: Values, kind: str) -> list[Value]:
    """The same as JSON has them: its own numbers where it loses no digit, else texts."""
    if kind in (INTEGER, TRUTH):
        word = int if kind == INTEGER else bool
        return [word(x) for x in values]
    if kind == DOUBLE:
        import numpy as np

        numbers = doubles(values)
        listed: list[Value] = numbers.tolist()
        return listed if np.isfinite(numbers).all() else [_finite(x) for x in listed]
    gap = "" if kind == TEXT else None
    return [x or gap for x in texts(values, kind)]


def plain(value: Value, depth: int = 3) -> Value:
    """A small object as JSON has it, without nan; infinities as texts; ValueError for a deep one.

    ``depth``: how many levels of objects and lists it may have.
    """
    if isinstance(value, (Mapping, list, tuple)):
        if depth == 0 or len(value) > MOST_ENTRIES:
            raise ValueError("an object that is too deep or too large")
        if isinstance(value, Mapping):
            return {str(key): plain(x, depth - 1) for key, x in value.items()}
        return [plain(x, depth - 1) for x in value]
    return _finite(value) if isinstance(value, float) else value


def _finite(x: float) -> Value:
    if x != x:
        return None
    return x if abs(x) != math.inf else repr(x)


def of_json(values: Sequence[Value], kind: str) -> Any:
    """The values of a list in JSON; ValueError where one is of another type."""
    import numpy as np

    types = set(map(type, values))
    if not types <= {*_JSON_TYPES.get(kind, (str, NoneType))}:
        raise ValueError(f"a value that is not of type {kind[:40]}")
    if kind == DOUBLE:
        if str in types and not {x for x in values if type(x) is str} <= {*_INFINITE}:
            raise ValueError("a text that is no number")
        return np.array([np.nan if x is None else float(x) for x in values], dtype=np.float64)
    if kind in (INTEGER, TRUTH):
        return np.array(values, dtype=DTYPES[kind])
    return values_of(["" if x is None else x for x in values], kind)


_JSON_TYPES: dict[str, tuple[type, ...]] = {
    DOUBLE: (float, int, str, NoneType),
    INTEGER: (int,),
    TRUTH: (bool,),
    TEXT: (str,),
}


def _digits(kind: str) -> int:
    match = re.fullmatch(r"([1-9]\d{0,4}) digits", kind)
    return int(match[1]) if match else 0


@lru_cache
def _number(kind: str) -> NumberType:
    match = re.fullmatch(r"([1-9]\d{0,5}) bits", kind)
    if match is None or int(match[1]) > MOST_BITS:
        raise ValueError(f"type {kind[:40]!r}")
    bits = int(match[1])
    return EXTENDED if bits == EXTENDED.bits else NumberType("mp", bits)


def _binary(text: str, number_type: NumberType) -> Value:
    if text in _INFINITE:
        from polhode.numbers.mpmath_context import mpmath, ordinary

        infinite = float(text)
        return infinite if number_type.flat else ordinary(mpmath.mpf(infinite))
    return number_value(number_type.rounded(decimal(text)), number_type)


def _fraction(text: str) -> Fraction:
    top, _, bottom = text.partition("/")
    return decimal(top) / (decimal(bottom) if bottom else 1)


def decimal(text: str) -> Fraction:
    """A decimal in full: Python's limit on the digits of an int does not hold for Decimal."""
    match = _DECIMAL.fullmatch(text) if len(text) <= MOST_CHARACTERS else None
    if match is None or abs(int(match[1] or 0)) > MOST_EXPONENT:
        raise ValueError(f"no decimal: {text[:40]!r}")
    return Fraction(Decimal(text))


# --- shown ----------------------------------------------------------------------------------------
#
# Tables for people.


MOST_ROWS, MOST_LINES = 8, 40  # that a notebook shows


def lines(table: Table) -> list[str]:
    """The lines of a table as a terminal shows it, in aligned columns."""
    return aligned(*header_and_rows(table))


def header_and_rows(table: Table) -> tuple[list[str], list[list[str]]]:
    """Header and rows of what is shown of a table; empty where there is no number."""
    columns = [x for x in table.columns if x.digits]
    return [x.name for x in columns], [*map(list, zip(*map(_cells, columns), strict=True))]


def to_html(title: str, report: str, table: Callable[[], Table] | None = None) -> str:
    """What a notebook shows of a result: a short report, else the first rows of its table.

    ``report``: the title again where there is none.  Nothing is computed that it does not show.
    """
    if report != title and report.count("\n") < MOST_LINES:
        return f"<pre>{escape(printable(report))}</pre>"
    heading = f"<p>{escape(printable(title.strip('<>')))}</p>"
    if table is None:
        return heading
    whole = table()
    few_rows = [column._replace(values=column.values[:MOST_ROWS]) for column in whole.columns]
    header, rows = header_and_rows(whole._replace(columns=few_rows))
    head = "".join(f"<th>{escape(name)}</th>" for name in header)
    lines = "".join(
        "<tr>" + "".join(f"<td>{escape(printable(x[:24]))}</td>" for x in row) + "</tr>"
        for row in rows
    )
    more = f"<p>{whole.rows} rows in all</p>" if whole.rows > MOST_ROWS else ""
    return f"{heading}<table><tr>{head}</tr>{lines}</table>{more}"


def _cells(column: Column) -> list[str]:
    values, digits = column.values, column.digits
    if any(isinstance(x, Ball) for x in values):
        return ["" if x is None else guaranteed(x.centre, x.radius) for x in values]
    word = word_of(column)
    if word in (INTEGER, TRUTH, TEXT):
        return texts(values, word)
    if word != DOUBLE:
        return ["" if x is None else _wide(x, word, digits) for x in values]
    numbers = doubles(values).tolist()
    if digits < DOUBLE_TYPE.printed_digits:
        return ["" if x != x else f"{x:.{digits}g}" for x in numbers]
    (row,) = strings([numbers], DOUBLE_TYPE)
    return ["" if x is None or x == "nan" else x for x in row]


def _wide(x: Value, word: str, digits: int) -> str:
    text = wide(x, digits)
    if word != EXACT:
        return text
    if not is_decimal(x) and len(whole := in_full(x)) <= digits:
        return whole
    head, power, exponent = text.partition("e")
    return head.rstrip("0").rstrip(".") + power + exponent if "." in head else text
