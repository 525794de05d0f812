"""Tables for people: numbers rounded as their columns say, balls to the digits that are proven."""

from __future__ import annotations

from polhode.common.errors import aligned
from polhode.numbers.balls import Ball, guaranteed
from polhode.numbers.decimals import in_full, is_decimal, strings
from polhode.numbers.number_types import DOUBLE as DOUBLES
from polhode.results.cells import DOUBLE, EXACT, INTEGER, TEXT, TRUTH, doubles, texts, wide, word_of
from polhode.results.table import Column, Table, Value


def lines(table: Table) -> list[str]:
    """The lines of a table as a terminal shows it, in aligned columns."""
    return aligned(*cells(table))


def cells(table: Table) -> tuple[list[str], list[list[str]]]:
    """Header and rows of what is shown of a table; empty where there is no number."""
    columns = [x for x in table.columns if x.digits]
    return [x.name for x in columns], [*map(list, zip(*map(_cells, columns), strict=True))]


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
    if digits < DOUBLES.printed_digits:
        return ["" if x != x else f"{x:.{digits}g}" for x in numbers]
    (row,) = strings([numbers], DOUBLES)
    return ["" if x is None or x == "nan" else x for x in row]


def _wide(x: Value, word: str, digits: int) -> str:
    text = wide(x, digits)
    if word != EXACT:
        return text
    if not is_decimal(x) and len(whole := in_full(x)) <= digits:
        return whole
    head, power, exponent = text.partition("e")
    return head.rstrip("0").rstrip(".") + power + exponent if "." in head else text
