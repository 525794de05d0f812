"""A trajectory as a file: a CSV with any subset of the columns beside t."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TextIO

from polhode.common.errors import BadInput
from polhode.numbers import expression
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import NumberType
from polhode.scenes.words import ANGLES, ATTITUDE, SPACE, STATE

MAX_BYTES = 1 << 30


MAX_LINE = 1_000_000  # characters


@dataclass(frozen=True)
class Table:
    """A trajectory as a file holds it: exact times, and columns by name (None where empty)."""

    name: str
    times: tuple[Fraction, ...]
    columns: dict[str, tuple[Fraction | None, ...]]
    ignored: tuple[str, ...]
    printed: int  # the most significant digits that any number beside t has


def read_table(path: Path, number: NumberType | None) -> Table:
    """A CSV file as a table; raises BadInput.  ``number``: its decimals stand for numbers of it."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise BadInput(str(path), "file", None, f"at most {MAX_BYTES} bytes")
        with path.open(encoding="utf-8-sig", newline="") as text:
            rows = [
                (k, [cell.strip() for cell in row])
                for k, row in enumerate(csv.reader(_uncommented(text)), 1)
                if any(cell.strip() for cell in row)
            ]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or "not a CSV text"
        raise BadInput(str(path), "file", None, f"a readable CSV file ({reason})") from None
    if not rows:
        raise BadInput(str(path), "file", None, "a header line that names the columns")
    header = rows[0][1]
    known = ("t", *STATE, *ANGLES, *ATTITUDE, *SPACE)
    for name in known:
        if header.count(name) > 1:
            raise BadInput(str(path), "header", name, "each column once")
    if "t" not in header:
        raise BadInput(str(path), "header", ",".join(header), "a column t among its names")
    if len(rows) == 1:
        raise BadInput(str(path), "file", None, "at least one line of numbers")
    return _table(path, header, rows[1:], known, number)


def _uncommented(text: TextIO) -> Iterator[str]:
    """The lines with comments blank: a quotation mark in a comment opens nothing."""
    for line in iter(lambda: text.readline(MAX_LINE + 1), ""):
        if len(line) > MAX_LINE:
            raise csv.Error("a line without end")
        yield "\n" if line.lstrip().startswith("#") else line


def _table(
    path: Path,
    header: list[str],
    rows: list[tuple[int, list[str]]],
    known: tuple[str, ...],
    number: NumberType | None,
) -> Table:
    wanted = [name for name in header if name in known]
    found: dict[str, list[Fraction | None]] = {name: [] for name in wanted}
    printed = 1
    for line, cells in rows:
        if len(cells) != len(header):
            raise BadInput(f"{path}:{line}", "line", ",".join(cells), f"{len(header)} values")
        for name, cell in zip(header, cells, strict=True):
            if name not in found:
                continue
            if cell == "" and name != "t":
                found[name].append(None)
                continue
            try:
                value = expression.decimal(cell)
            except ExpressionError:
                raise BadInput(f"{path}:{line}", name, cell, "a finite decimal number") from None
            if name != "t":
                printed = max(printed, _significant(cell))
            found[name].append(number.rounded(value) if number else value)
    times = [t for t in found.pop("t") if t is not None]
    ignored = tuple(name for name in header if name not in known)
    columns = {name: tuple(values) for name, values in found.items()}
    return Table(str(path), tuple(times), columns, ignored, printed)


def _significant(cell: str) -> int:
    mantissa = cell.lower().split("e")[0].lstrip("+-").replace(".", "").lstrip("0")
    return max(1, len(mantissa))
