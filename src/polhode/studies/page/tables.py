"""Tables of a study's rows: what stands in each column, and columns that several studies share."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeAlias

from polhode.common.texts import JsonObject
from polhode.studies.page.words import formatted

#: A key of a row, a path of keys and places with dots between them, or a function of the row.
Value: TypeAlias = str | Callable[[JsonObject], object]


class PageTable(NamedTuple):
    """Rows of cells under a header; ``align``: one character a column, l or r.

    ``again``: the command that makes a row again; {0}, {1} stand for its cells.  ``meanings``: what
    each column holds, "" where its header tells it.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    align: str = ""
    again: str = ""
    meanings: tuple[str, ...] = ()

    def command(self, row: tuple[str, ...]) -> str:
        """The command that makes one of the rows again."""
        return self.again.format(*(cell.strip("`").replace("'", r"'\''") for cell in row))

    @property
    def markdown(self) -> str:
        """The table, what its columns hold, and how to make a row again; empty without rows."""
        if not self.rows:
            return ""
        sides = ("--:" if side == "r" else "---" for side in self.align)
        lines = [_line(self.header), f"|{'|'.join(sides)}|", *map(_line, self.rows)]
        headers: dict[str, list[str]] = {}  # of one meaning, such as number types, together
        for header, meaning in zip(self.header, self.meanings, strict=False):
            headers.setdefault(meaning, []).append(header)
        told = [f"*{', '.join(names)}*: {meaning}" for meaning, names in headers.items() if meaning]
        lines += ["", f"Columns: {'; '.join(told)}."] if told else [""]
        if self.again:
            lines.append(f"To make rows again, here the first: `{self.command(self.rows[0])}`.")
        return "\n".join(lines).rstrip()


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


class Column(NamedTuple):
    """A column of a table of rows.

    ``form``: "" for text, "code", or a format of numbers, which stand to the right (">" for text
    that reads as a number).  A value that is missing is a dash; a text that stands where a number
    would, such as how a run ended, is written as it is.  ``meaning``: what the column holds, for a
    stranger, in words that follow the header and a colon; "" where the header tells it.
    """

    header: str
    value: Value
    form: str = ""
    meaning: str = ""

    @property
    def side(self) -> str:
        """``l`` for text, ``r`` for numbers."""
        return "l" if self.form in ("", "code") else "r"

    def cell(self, row: JsonObject) -> str:
        """What stands in this column of a row."""
        value = at(row, self.value) if isinstance(self.value, str) else self.value(row)
        return formatted(value, self.form)


def at(row: JsonObject, path: str) -> Any:
    """The value at a path of keys and places; None where there is none."""
    value: Any = row
    for part in path.split("."):
        if isinstance(value, list):
            value = value[int(part)] if value else None
        else:
            value = value.get(part) if isinstance(value, dict) else None
    return value


def table(rows: Iterable[JsonObject], columns: Sequence[Column], again: str = "") -> PageTable:
    """A table of rows; ``again``: see :class:`PageTable`."""
    return PageTable(
        tuple(column.header for column in columns),
        tuple(tuple(column.cell(row) for column in columns) for row in rows),
        "".join(column.side for column in columns),
        again,
        tuple(column.meaning for column in columns),
    )


def at_times(
    times: Iterable[object], write: Callable[[JsonObject, int], object], meaning: str = ""
) -> list[Column]:
    """A column for each of the times, in which something is written of its place in the row."""

    def column(place: int, t: object) -> Column:
        return Column(f"t = {t}", lambda row: write(row, place), ">", meaning)

    return [column(place, t) for place, t in enumerate(times)]


def yes(key: str, no: str = "no") -> Value:
    """Whether a key of the row is true, in words; None where it has no such key."""

    def value(row: JsonObject) -> str | None:
        return None if key not in row else "yes" if row[key] else no

    return value


CASE = Column("case", "case", "", "a scene of the library, which `polhode show CASE` prints")
NUMBER = Column("number", "number", "", "the number type of the run")
REGIME = Column("regime", "regime", "", "the kind of motion")
T = Column("t", "t", "g")
END = Column("to t", "end", "g", "the last time of the run")
STEPS = Column("steps", "steps", "d")
DIGITS = Column("digits", "digits", ".1f", "-log10 of the largest relative error")
