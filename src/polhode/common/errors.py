"""What goes wrong by the user's hand, said in one line."""

from __future__ import annotations

#: What reading JSON or TOML raises for text that is none, or nested too deeply.
UNREADABLE = (ValueError, RecursionError)


class FileName(str):
    """What results call a file, and ``given``: what its user called it, for a line of an error."""

    __slots__ = ("given",)
    given: str

    def __new__(cls, name: str, given: str) -> FileName:
        """A name and what was given."""
        made = super().__new__(cls, name)
        made.given = given
        return made

    def __reduce__(self) -> tuple[type, tuple[str, str]]:
        return type(self), (str(self), self.given)

    def with_more(self, text: str) -> FileName:
        """Both with a text after them."""
        return FileName(self + text, self.given + text)


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
        source = source.given if isinstance(source, FileName) else source
        self.source, self.key, self.value, self.expected = source, key, value, expected
        shown = "" if value is None else f" = {short(value)}"
        where = f"{short(source, 200)}: {short(key, 80)}"
        super().__init__(f"{where}{shown}: expected {short(expected, 600)}")

    def __reduce__(self) -> tuple[type, tuple[str, str, object, str]]:
        return type(self), (self.source, self.key, self.value, self.expected)


class StdoutFault(Exception):
    """Standard output takes no more; ``fault``: what the system said."""

    def __init__(self, fault: OSError) -> None:
        self.fault = fault
        super().__init__(fault.strerror)


def nearest(word: object, known: list[str]) -> str:
    """The words allowed, the nearest one first in mind: for the end of an error message."""
    told = ", ".join(known) if len(known) <= 20 else f"one of {len(known)} names"
    return told + _meant(word, known)


def listed(word: object, known: list[str]) -> str:
    """All of the words allowed, however many, and the nearest one."""
    return ", ".join(known) + _meant(word, known)


def _meant(word: object, known: list[str]) -> str:
    from difflib import get_close_matches

    close = get_close_matches(word, known, n=1) if isinstance(word, str) else []
    if not close and isinstance(word, str) and len(word) > 2:  # the end of a long name
        close = [name for name in known if word.lower() in name.lower()][:1]
    return f" (did you mean {close[0]!r}?)" if close else ""


def short(value: object, limit: int = 60) -> str:
    """A value on one line, printable and cut at so many characters."""
    text = value if isinstance(value, str) else plain(value)
    line = " ".join(text.split())
    line = "".join(c if c.isprintable() else "?" for c in line)
    return line if len(line) <= limit else line[: limit - 3] + "..."


def plain(value: object) -> str:
    """``str(value)``, also of an integer that Python refuses to print."""
    try:
        return str(value)
    except ValueError:  # an integer too long for Python to print
        return "a number of thousands of digits"
