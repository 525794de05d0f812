"""Text for people: tables in columns, and which rows of a long one to show."""

from __future__ import annotations

from collections.abc import Sequence


def printable(text: str) -> str:
    """Text in which no character commands a terminal or turns a line around; line ends stay."""
    return "".join(c if c.isprintable() or c == "\n" else "?" for c in text)


def one_line(text: str) -> str:
    """Such text on one line: a name, a title, whatever somebody else wrote."""
    return printable(" ".join(text.split("\n")))


def aligned(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a table whose columns are aligned to the left."""
    rows = [[one_line(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    return [
        "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip()
        for row in (header, *rows)
    ]


def counted(count: int, noun: str) -> str:
    """``1 orbit``, ``2 orbits``: how many, with the noun's plural in s where it is due."""
    return f"{count} {noun}" + "s" * (count != 1)


def few(count: int, most: int) -> list[int]:
    """At most ``most`` of the indices below ``count``, evenly spread, first and last among them."""
    if count <= most:
        return list(range(count))
    return sorted({round(k * (count - 1) / (most - 1)) for k in range(most)})
