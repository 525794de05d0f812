"""How a table's text is laid out: its separator, where its header stands, what its columns mean.

Separators are comma, semicolon, tab, or blanks, as the first line of the table has them.  Between
semicolons the numbers may have decimal commas, if none has a point.  A header may stand in a
comment (``# t p q r``, as NumPy writes it), or be given.
"""

from __future__ import annotations

import re
import string
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from polhode.common.errors import BadInput, nearest
from polhode.judging.tables.column_aliases import UNKNOWN, Column, columns, readable
from polhode.numbers import expression
from polhode.numbers.expression import ExpressionError

SEPARATORS = ",;\t"
BLANK = SEPARATORS + string.whitespace
_EMPTY = ("", "nan", "na", "n/a", "nat", "null", "none")
_WITH_COMMA = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?")


@dataclass(frozen=True)
class Naming:
    """Columns that were named beside a file.

    ``header``: all of them in order, empty where the file has its own.  ``meant``: what single
    names of its header mean.
    """

    header: tuple[str, ...] = ()
    meant: Mapping[str, Column] = field(default_factory=dict)

    def columns(self, header: Sequence[str]) -> list[Column]:
        """What the names of a header mean; a column that was told is no other one of the header."""
        told = {one.name for one in self.meant.values()}
        others = [UNKNOWN if one.name in told else one for one in columns(header)]
        return [self.meant.get(name, one) for name, one in zip(header, others, strict=True)]


@dataclass(frozen=True)
class Layout:
    """Lines whose first that is not blank is the header, and what separates their cells.

    ``before``: lines in front of them that the file does not have.  ``commas``: whether the
    file's decimal commas became points.
    """

    lines: tuple[str, ...]
    separator: str
    before: int = 0
    commas: bool = False


def is_empty(cell: str) -> bool:
    """Whether a cell has no number, as programs write it: nothing, or ``nan`` and its like.

    >>> is_empty("NaN"), is_empty("-nan"), is_empty("inf")
    (True, True, False)
    """
    return len(cell) < 5 and cell.lstrip("+-").lower() in _EMPTY


def naming(text: str) -> Naming:
    """The columns of ``--columns``: ``t,qw,qx``, or ``time_ms=t*1e-3, Q.W=q0``; raises BadInput."""
    items = [item.strip() for item in text.split(",")]
    if not any("=" in item for item in items):
        return Naming(tuple(items))
    meant = {}
    for item in items:
        name, _, told = (part.strip() for part in item.partition("="))
        ours, _, by = (part.strip() for part in told.partition("*"))
        sign, ours = (-1, ours[1:].strip()) if ours.startswith("-") else (1, ours)
        if not name or ours not in readable():
            expected = f"NAME=COLUMN, of {nearest(ours, readable())}"
            raise BadInput("compare", "--columns", item, expected)
        try:
            factor = sign * (expression.decimal(by) if by else Fraction(1))
        except ExpressionError as fault:
            raise BadInput("compare", "--columns", item, f"NAME=COLUMN*NUMBER ({fault})") from None
        meant[name] = Column(ours, False, factor)
    return Naming((), meant)


def layout(lines: Sequence[str], names: Naming) -> Layout:
    """The layout of a file's lines; comments become blank, but for one that is the header."""
    plain = ["\n" if line.lstrip().startswith("#") else line for line in lines]
    first = next((k for k, line in enumerate(plain) if line.strip(BLANK)), None)
    if first is None:
        return Layout(tuple(plain), ",")
    rows = first + _is_header(plain[first])
    commas = ";" in plain[first] and _have_decimal_commas(plain[rows:])
    if commas:
        plain[rows:] = [line.replace(",", ".") for line in plain[rows:]]
    separator = _separator(plain[first])
    before = 0
    if _is_row(plain[first], separator):
        count = len(_cells(plain[first], separator))
        if names.header:
            plain.insert(0, _joined(names.header, separator))
            before = 1
        elif (place := _commented(lines, first, count, names)) is not None:
            comment = lines[place].lstrip().lstrip("#")
            plain[place] = _joined(_cells(comment, _separator(comment)), separator)
    elif names.header:
        plain[first] = _joined(names.header, separator)
    if separator == " " and not any('"' in line for line in plain):
        plain = [" ".join(line.split()) + "\n" for line in plain]
    return Layout(tuple(plain), separator, before, commas)


def _have_decimal_commas(rows: Sequence[str]) -> bool:
    """Whether cells between semicolons are numbers with a comma, or have neither comma nor point,
    and one has a comma."""
    marked = [cell for line in rows for cell in _cells(line, ";") if "," in cell or "." in cell]
    return bool(marked) and all(_WITH_COMMA.fullmatch(cell) for cell in marked)


def _is_header(line: str) -> bool:
    """Whether a line between semicolons has a cell that begins like a name."""
    return any(cell[:1].isalpha() for cell in _cells(line, ";"))


def _commented(lines: Sequence[str], first: int, count: int, names: Naming) -> int | None:
    """The last comment before the first row that names so many columns, t among them."""
    for k in range(first - 1, -1, -1):
        text = lines[k].lstrip().lstrip("#")
        cells = _cells(text, _separator(text))
        if len(cells) == count and any(one.name == "t" for one in names.columns(cells)):
            return k
    return None


def _separator(line: str) -> str:
    return next((mark for mark in SEPARATORS if mark in line), " " if " " in line.strip() else ",")


def _cells(line: str, separator: str) -> list[str]:
    parts = line.split() if separator == " " else line.split(separator)
    return [part.strip() for part in parts]


def _joined(cells: Sequence[str], separator: str) -> str:
    return (
        separator.join(cell.replace(" ", "_") if separator == " " else cell for cell in cells)
        + "\n"
    )


def _is_row(line: str, separator: str) -> bool:
    """Whether a line holds numbers alone, so that it is no header."""
    cells = [cell for cell in _cells(line, separator) if not is_empty(cell)]
    try:
        for cell in cells:
            expression.decimal(cell)
    except ExpressionError:
        return False
    return bool(cells)
