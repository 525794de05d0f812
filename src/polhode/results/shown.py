"""Tables for people: numbers rounded as their columns say, balls to the digits that are proven."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

from polhode.common.errors import aligned, printable
from polhode.numbers.decimals import Ball, guaranteed, in_full, is_decimal, strings
from polhode.numbers.number_types import DOUBLE as DOUBLES
from polhode.results.cells import (
    DOUBLE,
    EXACT,
    INTEGER,
    TEXT,
    TRUTH,
    doubles,
    texts,
    wide,
    word_of,
)
from polhode.results.table import Column, Table, Value

MOST_ROWS, MOST_LINES = 8, 40  # that a notebook shows


def lines(table: Table) -> list[str]:
    """The lines of a table as a terminal shows it, in aligned columns."""
    return aligned(*cells(table))


def cells(table: Table) -> tuple[list[str], list[list[str]]]:
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
    header, rows = cells(whole._replace(columns=few_rows))
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
