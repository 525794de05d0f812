"""Typed access to the tables of a scene: every value checked, every fault named by its key."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, TypeGuard

from polhode.common.errors import BadInput, nearest, plain
from polhode.numbers import exact, expression
from polhode.numbers.conversion import derived_number
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError
from polhode.numbers.vectors import Vector
from polhode.scenes import keys
from polhode.scenes.given_numbers import number_in_text

_LONG = 24  # characters: no double is printed with more

#: Between the middle and the radius of an interval, which proofs alone take.
PLUS_MINUS = ("\u00b1", "+-", "+/-")


#: Output times, or crossings of an orbit.
MAX_SAMPLES = 1_000_000


class Literal(str):
    """A decimal of the file, digit for digit."""


class Reading:
    """One scene being read: typed access to its keys, faults named by key."""

    def __init__(self, name: str, data: dict[str, Any]) -> None:
        self.name, self.data = name, data
        self.change = ""  # of the start, which rounding alone kept from being possible
        self.doubt = ""  # what of it is hardly meant
        self.in_si = False  # a number was written with a unit, and is more than an angle

    def bad(self, key: str, value: object, expected: str) -> BadInput:
        """The fault of a key's value, to be raised."""
        return BadInput(self.name, key, as_written(value), expected)

    def known(self, section: str, table: Mapping[str, Any], where: str = "") -> None:
        """Refuse a key that the section has not."""
        allowed = keys.names(section)
        for key, value in table.items():
            if key not in allowed:
                full = ".".join(filter(None, (where or section, key)))
                if ours := keys.ours(section, key):
                    raise self.bad(full, value, ours)
                home = keys.homes(key)
                if home:
                    raise self.bad(full, value, f"no such key here: it belongs in {home}")
                raise self.bad(full, value, f"one of the keys {nearest(key, allowed)}")

    def table(self, section: str, required: bool = True) -> Mapping[str, Any]:
        """A section that is one table."""
        table = self.data.get(section)
        if table is None and not required:
            return {}
        if not isinstance(table, dict):
            raise self.bad(section, table, f"a table [{section}]")
        self.known(section, table)
        return table

    def tables(self, section: str) -> list[dict[str, Any]]:
        """A section of several tables."""
        tables = self.data.get(section, [])
        if not isinstance(tables, list) or not all(isinstance(t, dict) for t in tables):
            raise self.bad(section, tables, f"tables [[{section}]]")
        for index, table in enumerate(tables):
            self.known(section, table, f"{section}[{index + 1}]")
        return tables

    def alone(
        self, section: str, table: Mapping[str, Any], others: Iterable[str], expected: str
    ) -> None:
        """Refuse the first of some keys that the section has all the same."""
        for key in others:
            if key in table:
                raise self.bad(f"{section}.{key}", table[key], expected)

    def read(self, section: str, table: Mapping[str, Any], name: str, where: str = "") -> Any:
        """What a section holds under a key, or the key's default, read as its kind says.

        ``where``: the table of several, as ``events[1]``.
        """
        key = keys.key(section, name)
        readers: dict[str, Callable[[str, Any], Any]] = {
            keys.NUMBER: self.number,
            keys.VECTOR: self.vector,
            keys.WORD: self.word,
            keys.WORDS: self.words,
            keys.TRUTH: self.truth,
        }
        full = ".".join(filter(None, (where or section, name)))
        value = table[name] if name in table else keys.default(section, name)
        return readers[key.kind](full, value)

    def truth(self, key: str, value: object) -> bool:
        """True or false."""
        if not isinstance(value, bool):
            raise self.bad(key, value, "true or false")
        return value

    def whole(self, section: str, table: Mapping[str, Any], name: str, least: int) -> int:
        """What a section holds under a key, or its default: a whole number up to a million."""
        value = table.get(name, keys.default(section, name))
        if not is_int(value) or not least <= value <= MAX_SAMPLES:
            expected = f"a whole number from {least} to {MAX_SAMPLES}"
            raise self.bad(f"{section}.{name}", value, expected)
        return value

    def word(self, key: str, value: object) -> str:
        """A text."""
        if not is_expression(value):
            raise self.bad(key, value, "a text")
        return value

    def words(self, key: str, value: object) -> tuple[str, ...]:
        """A list of texts."""
        return tuple(self.word(key, item) for item in self.array(key, value))

    def array(self, key: str, value: Any, length: int | None = None) -> list[Any]:
        """An array, of so many numbers."""
        expected = "an array" if length is None else f"an array of {length} numbers"
        if not isinstance(value, list) or (length is not None and len(value) != length):
            raise self.bad(key, value, expected)
        return value

    def vector(self, key: str, value: Any) -> Vector:
        """Three numbers."""
        a, b, c = (self.number(key, item) for item in self.array(key, value, 3))
        return a, b, c

    def number(self, key: str, value: Any) -> Exact:
        """The exact number that a value stands for."""
        try:
            if isinstance(value, Literal):
                return expression.decimal(value)
            if is_int(value):
                if abs(value).bit_length() > expression.MAX_BITS:
                    raise ExpressionError("too large")
                return Fraction(value)
            if isinstance(value, str):
                found, in_units = number_in_text(value, keys.unit(key))
                self.in_si |= in_units
                return found
            if hasattr(value, "__float__") and not isinstance(value, bool):  # given in Python
                return derived_number(value)
        except ValueError as fault:
            if isinstance(value, str) and any(mark in value for mark in PLUS_MINUS):
                expected = "a number; intervals are allowed in start.omega, for proofs only: "
                raise self.bad(key, value, expected + "polhode certify") from None
            raise self.bad(key, value, f"a number ({fault})") from None
        raise self.bad(key, value, "a number")

    def readable(self, key: str, text: str, names: tuple[str, ...]) -> None:
        """Check an expression in named columns by computing it once with arbitrary values."""
        from polhode.scenes.column_expressions import check

        try:
            check(text, names)
        except ExpressionError as fault:
            raise self.bad(key, text, f"an expression in {' '.join(names)} ({fault})") from None


def is_expression(value: object) -> TypeGuard[str]:
    """Whether a value is a text, which holds an exact expression; a decimal of the file is none."""
    return isinstance(value, str) and not isinstance(value, Literal)


def is_int(value: object) -> TypeGuard[int]:
    """Whether a value is a whole number of the file."""
    return isinstance(value, int) and not isinstance(value, bool)


def as_written(value: object, depth: int = 4) -> Any:
    """A TOML value for an error message: as TOML, without quotes around decimals."""
    if isinstance(value, (list, dict)) and depth == 0:
        return "..."
    if isinstance(value, list):
        return "[" + ", ".join(_shown(item, depth) for item in value[:20]) + "]"
    if isinstance(value, dict):
        items = list(value.items())[:20]
        return "{" + ", ".join(f"{key} = {_shown(item, depth)}" for key, item in items) + "}"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, exact.Irrational):
        return shown(value)
    if isinstance(value, Fraction) or (isinstance(value, Literal) and len(value) > _LONG):
        return _as_double(value)
    return value


def _as_double(value: Literal | Fraction) -> str:
    """A number that is a double as Python prints that one; any other as it is."""
    try:
        given = expression.decimal(value) if isinstance(value, str) else value
        if given == Fraction(near := float(given)):
            return repr(near).removesuffix(".0")
    except (ExpressionError, OverflowError):
        pass
    return value if isinstance(value, str) else shown(value)


def _shown(item: object, depth: int) -> str:
    return plain(as_written(item, depth - 1))
