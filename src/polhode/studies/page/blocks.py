"""The blocks that a page is made of.  Text is Markdown of one line: `code`, *emphasis*, links."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple


class Heading(NamedTuple):
    """A section's title."""

    text: str


class Text(NamedTuple):
    """A paragraph."""

    text: str


class Items(NamedTuple):
    """A list of points."""

    items: tuple[str, ...]


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

    @property
    def explained(self) -> tuple[tuple[str, str], ...]:
        """Headers and what they mean; those that mean the same, such as number types, together."""
        headers: dict[str, list[str]] = {}
        for header, meaning in zip(self.header, self.meanings, strict=False):
            headers.setdefault(meaning, []).append(header)
        return tuple((", ".join(names), meaning) for meaning, names in headers.items() if meaning)

    def command(self, row: tuple[str, ...]) -> str:
        """The command that makes one of the rows again."""
        return self.again.format(*(cell.strip("`").replace("'", r"'\''") for cell in row))

    @property
    def told(self) -> str:
        """How to make a row again, below the table; empty where there is nothing to make."""
        if not self.again or not self.rows:
            return ""
        one = "a row" if "{" in self.again else "these rows"
        first = ", here the first" if "{" in self.again and len(self.rows) > 1 else ""
        return f"To make {one} again{first}: `{self.command(self.rows[0])}`"


class Figure(NamedTuple):
    """A figure of this study by name (``name``.svg), and what it shows."""

    name: str
    alt: str


Block = Heading | Text | Items | PageTable | Figure


def markdown(title: str, blocks: Iterable[Block]) -> str:
    """The page as Markdown."""
    return "\n".join(_lines(title, blocks)).rstrip() + "\n"


def _lines(title: str, blocks: Iterable[Block]) -> Iterator[str]:
    yield f"# {title}"
    yield ""
    said = set()
    for block in blocks:
        match block:
            case Heading(text):
                yield f"## {text}"
            case Text(text):
                yield text
            case Items(items):
                yield from (f"- {item}" for item in items)
            case PageTable(header, rows, align):
                sides = align or "l" * len(header)
                yield _row(header)
                yield "|" + "|".join("--:" if side == "r" else "---" for side in sides) + "|"
                yield from (_row(row) for row in rows)
                if block.explained and block.explained not in said:  # of many, once
                    said.add(block.explained)
                    told = "; ".join(f"*{names}*: {meaning}" for names, meaning in block.explained)
                    yield ""
                    yield f"Columns: {told}."
                if block.told:
                    yield ""
                    yield block.told
            case Figure(name, alt):
                yield f"![{alt}]({name}.svg)"
        yield ""


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
