"""What the JSON that polhode wrote beside a CSV says of its numbers; anything else is no such file.

Somebody's file of that name may hold anything: a regular file is read up to a limit, each field is
checked against the others and against the cells, and a file that does not fit is ignored, and told.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from polhode.common.errors import UNREADABLE, short
from polhode.common.files import called
from polhode.common.text_tables import few
from polhode.numbers import expression
from polhode.numbers.decimals import shortest
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import LEAST_MP_BITS, MAX_DIGITS, NAMES, NumberType, mp, named

MOST_BYTES = 1 << 27
_MOST_BITS = 4 * mp(MAX_DIGITS).bits  # of a run: the digits asked for, and those that it loses
_ROUNDED_OFF = 3  # zeros that all numbers of a table may end with
_CHECKED = 32  # times
_KEYS = ("number", "bits", "t_bits", "projection")


@dataclass(frozen=True)
class Sidecar:
    """Of which type a table's numbers and times are, and whether its integrals were projected.

    ``remarks``: what was ignored, and why.
    """

    name: str = ""
    number: NumberType | None = None
    projected: bool = False
    remarks: tuple[str, ...] = field(default=())

    def of(self, printed: int, times: Sequence[str]) -> Sidecar:
        """What it tells if that fits the most digits that a cell has and the decimals of t."""
        number, told = self.number, ""
        if number is None:
            return self
        if not 0 <= number.printed_digits - printed <= _ROUNDED_OFF:
            told = f"has {number.printed_digits} digits, and {printed} are printed"
        elif (odd := _not_of(times, number)) is not None:
            told = f"does not print t as {odd}"
        if told:
            return _ignored(self.name, f"{number.name} {told}")
        told = f"{self.name}: numbers and t are of {number.name} ({number.bits} bits)"
        return replace(self, remarks=(told,))


def beside(path: Path) -> Sidecar:
    """What stands beside a table's file; nothing where there is no such file."""
    try:
        place = path.with_suffix(".json")
        if place == path:
            return Sidecar()
        with open(os.open(place, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            regular = stat.S_ISREG(os.fstat(file.fileno()).st_mode)
            text = file.read(MOST_BYTES).decode("utf-8", "replace") if regular else ""
    except FileNotFoundError:
        return Sidecar()
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or "no such name"
        return Sidecar(remarks=(f"the JSON file next to it was not read: {reason}",))
    name = str(called(place))
    if not regular:
        return Sidecar(remarks=(f"{name} was not read: it is not a regular file",))
    found = _fields(text)
    if not found.keys() & {*_KEYS}:
        return _ignored(name, "it does not describe the file's numbers")
    word, bits, held, projection = (found.get(key) for key in _KEYS)
    number = saved_type(word, bits)
    if number is None or type(held) is not int or held != number.bits:
        told = f"number = {short(word, 40)}, bits = {short(bits, 40)}, t_bits = {short(held, 40)}"
        return _ignored(name, f"{told}, no number type of a run")
    if projection is None:
        return Sidecar(name, number)
    try:
        projected = projection["count"] > 0 and "h" in projection["onto"]
    except (TypeError, KeyError):
        return _ignored(name, f"projection = {short(projection, 40)}, no count with integrals")
    return Sidecar(name, number, projected)


def _ignored(name: str, why: str) -> Sidecar:
    return Sidecar(name, remarks=(f"{name} was ignored: {why}",))


def saved_type(word: object, bits: object) -> NumberType | None:
    """The number type that a run's file says; None where no run has such a one."""
    if not isinstance(word, str) or word not in NAMES or type(bits) is not int:
        return None
    if word == "mp":
        return NumberType(word, bits) if LEAST_MP_BITS <= bits <= _MOST_BITS else None
    return named(word) if bits == named(word).bits else None


def _not_of(times: Sequence[str], kind: NumberType) -> str | None:
    """A time that is printed otherwise than a run of this type prints it; None where none is."""
    for k in few(len(times), _CHECKED):
        try:
            value = expression.decimal(times[k])
        except ExpressionError:  # refused elsewhere
            continue
        held = kind.rounded(value)
        if value not in (held, Fraction(shortest(held, kind))):
            return times[k][:40]
    return None


def _fields(text: str) -> dict[str, Any]:
    """Keys and values of a JSON object; none of what is no whole one."""
    try:
        found = json.loads(text)
    except UNREADABLE:
        return {}
    return found if isinstance(found, dict) else {}
