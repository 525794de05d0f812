"""Errors of users, in one line, and texts in columns."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction

# --- text tables ----------------------------------------------------------------------------------
#
# Text for people: tables in columns, and which rows of a long one to show.


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


# --- errors ---------------------------------------------------------------------------------------
#
# What goes wrong by the user's hand, said in one line; and what is said of input that is taken.


_LONG = "a number of thousands of digits"
_MOST_BITS = 14_000  # of an integer that is printed, some 4200 digits

#: What reading JSON or TOML raises for text that is none, or nested too deeply.
UNREADABLE = (ValueError, RecursionError)


class FileName(str):
    """What results call a file; ``original``: what its user called it, for a line of an error."""

    __slots__ = ("original",)
    original: str

    def __new__(cls, name: str, original: str) -> FileName:
        """A name and the one that the user wrote."""
        text = super().__new__(cls, name)
        text.original = original
        return text

    def __reduce__(self) -> tuple[type, tuple[str, str]]:
        return type(self), (str(self), self.original)

    def with_more(self, text: str) -> FileName:
        """Both with a text after them."""
        return FileName(self + text, self.original + text)


class BadInput(ValueError):
    """Input that cannot be used: its source, the key, the value, and what was expected.

    A ValueError of one line, with these as ``source``, ``key``, ``value`` and ``expected``.

    >>> import polhode
    >>> polhode.integrate("euler/sphere", "long")
    Traceback (most recent call last):
    ...
    polhode.common.errors.BadInput: euler/sphere: number = long: expected double, extended, quad, mp
    """

    def __init__(self, source: str, key: str, value: object, expected: str) -> None:
        source = source.original if isinstance(source, FileName) else source
        self.source, self.key, self.value, self.expected = source, key, value, expected
        shown = "" if value is None else f" = {short(value)}"
        where = f"{short(source, 200)}: {short(key, 80)}"
        super().__init__(f"{where}{shown}: expected {short(expected, 600)}")

    def __reduce__(self) -> tuple[type, tuple[str, str, object, str]]:
        return type(self), (self.source, self.key, self.value, self.expected)


class TooManySteps(BadInput):
    """That a proof would take more steps than it may."""


class ConstantZero(BadInput):
    """An event whose expression is zero all along the motion, for all that the type can tell."""


class StdoutFault(Exception):
    """Standard output takes no more; ``fault``: what the system said."""

    def __init__(self, fault: OSError) -> None:
        self.fault = fault
        super().__init__(fault.strerror)


def nearest(word: object, names: list[str]) -> str:
    """The words allowed, the nearest one first in mind: for the end of an error message."""
    choices = ", ".join(names) if len(names) <= 20 else f"one of {len(names)} names"
    return choices + _meant(word, names)


def listed(word: object, names: list[str]) -> str:
    """All of the words allowed, however many, and the nearest one."""
    return ", ".join(names) + _meant(word, names)


def _meant(word: object, names: list[str]) -> str:
    from difflib import get_close_matches

    close = get_close_matches(word, names, n=1) if isinstance(word, str) else []
    if not close and isinstance(word, str) and len(word) > 2:  # the end of a long name
        close = [name for name in names if word.lower() in name.lower()][:1]
    return f" (did you mean {close[0]!r}?)" if close else ""


def short(value: object, limit: int = 60) -> str:
    """A value on one line, printable and cut at so many characters."""
    text = value if isinstance(value, str) else plain(value)
    line = printable(" ".join(text.split()))
    return line if len(line) <= limit else line[: limit - 3] + "..."


def plain(value: object) -> str:
    """``str(value)``, also of an integer that Python refuses to print, or would for minutes."""
    try:
        return _LONG if _too_long(value) else str(value)
    except ValueError:  # an integer too long for Python to print
        return _LONG


def _too_long(value: object) -> bool:
    """Whether an integer of thousands of digits is in a value, whatever Python's limit is."""
    if isinstance(value, (int, Fraction)):
        return max(value.numerator.bit_length(), value.denominator.bit_length()) > _MOST_BITS
    return isinstance(value, (list, tuple)) and any(map(_too_long, value[:100]))


# -- input that is taken --------------------------------------------------------------------------

_changes_said: set[str] = set()
_in_verb = [False]


class DoubtfulInput(UserWarning):
    """Input that is possible, and hardly meant."""


@contextmanager
def in_verb() -> Iterator[None]:
    """While a verb runs: doubts are lines on stderr, and changes are said anew."""
    before = _in_verb[0]
    _in_verb[0] = True
    _changes_said.clear()
    try:
        yield
    finally:
        _in_verb[0] = before


def say_change(source: str, text: str) -> None:
    """Say on stderr that input was changed which rounding alone kept from being possible.

    Once in a process, and never as a warning, which may be an error to its caller.  ``text`` has
    its amount in brackets, which makes it no other change.
    """
    kind = f"{source}: {text.partition(' (')[0]}"
    if kind not in _changes_said:
        _changes_said.add(kind)
        _print(f"{source}: {text}")


def say_doubt(source: str, text: str) -> None:
    """Say of input that it is possible, and hardly meant: a warning; of a verb a line on stderr."""
    if _in_verb[0]:
        _print(f"{source}: {text}")
    else:
        warnings.warn(f"{source}: {text}", DoubtfulInput, stacklevel=4)


def _print(line: str) -> None:
    if sys.stderr is None:
        return
    try:
        print(printable(line), file=sys.stderr)
    except (OSError, ValueError):  # closed: nobody could be told
        return
