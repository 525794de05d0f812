"""Variation of a scene's numbers: keys and ranges."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.common.arguments import each, numbers_given, of_kind, rows_of
from polhode.common.errors import BadInput, plain, say_doubt
from polhode.numbers.conversion import ExactNumbers, LazySequence, in_text, reader, spaced
from polhode.numbers.exact import ZERO, Exact, pi
from polhode.numbers.expression import ExpressionError, in_units
from polhode.numbers.number_types import Flat
from polhode.scenes.body_and_start import THETA, doubtful_theta
from polhode.scenes.vocabulary import unit

# --- array columns --------------------------------------------------------------------------------
#
# Columns of a sweep given as arrays: N members, row by row, never every combination.
#
# ``{"start.omega": (N, 3), "start.gamma": (N, 3), "body.weight": (N, 1)}``. The floats stay the
# array that they are; exact numbers are made where a member is asked for.


#: How many numbers the keys have that are no single number.
_WIDTHS = {
    **{f"body.{key}": 3 for key in ("moments", "centre")},
    **{f"start.{key}": 3 for key in ("omega", "gamma", "momentum", "angles", "rates")},
    "start.quaternion": 4,
}
#: The keys of the numbers of a start, p q r gamma1 gamma2 gamma3.
START = tuple(f"start.{name}[{i}]" for name in ("omega", "gamma") for i in (1, 2, 3))


def row_by_row(
    vary: Mapping[str, Any], name: str, starts: Flat | None = None
) -> tuple[list[str], list[ExactNumbers[Fraction]]]:
    """Keys and columns, where starts are given or an array of rows is among what is varied.

    Else none of them.  Raises BadInput, also for two arrays of one length without rows: they may
    mean either.
    """
    keys: list[str] = []
    columns: list[ExactNumbers[Fraction]] = []
    if starts is not None:
        keys += START[: starts.shape[1]]
        columns += [ExactNumbers(floats=column) for column in starts.T.copy()]
        if not vary:
            return keys, columns
    arrays = {key: values for key, values in vary.items() if _dimensions(values) > 0}
    rows = [key for key, values in arrays.items() if _dimensions(values) > 1]
    if not rows and starts is None:
        _ask(arrays, name)
        return keys, columns
    first = "starts" if starts is not None else rows[0]
    for key, values in vary.items():
        if key not in arrays:
            expected = f"an array with a row for each of {first}: never every combination"
            raise BadInput(name, key, plain(values), expected)
        width = _WIDTHS.get(key, 1)
        table = rows_of(name, key, values if key in rows else _standing(values), width)
        own = [key] if width == 1 else [f"{key}[{i + 1}]" for i in range(width)]
        twice = [number for number in own if number in keys]
        if twice:
            raise BadInput(name, key, f"{twice[0]}, given twice", "each number in one array")
        keys += own
        columns += [ExactNumbers(floats=column) for column in table.T.copy()]
        if len(columns[-1]) != len(columns[0]):
            longest = first if starts is not None else next(iter(vary))
            expected = f"{len(columns[0])} rows, as many as {longest} has"
            raise BadInput(name, key, f"{len(columns[-1])} rows", expected)
    return keys, columns


def _dimensions(values: object) -> int:
    """Of an array of any kind; 0 of anything else."""
    return int(getattr(values, "ndim", 0)) if hasattr(values, "__array__") else 0


def _standing(values: object) -> Flat:
    """An array of numbers as one of rows with a number each."""
    import numpy as np

    return np.asanyarray(values)[:, None]


def _ask(arrays: Mapping[str, Any], name: str) -> None:
    """Two arrays of one length may be meant member by member, or every combination of them."""
    lengths: dict[int, str] = {}
    for key, values in arrays.items():
        first = lengths.setdefault(len(values), key)
        if first != key and len(values) > 1:
            words = f"two arrays of {len(values)} numbers ({first} is the other)"
            expected = (
                "[:, None] on both for member by member, or .tolist() on both for every combination"
            )
            raise BadInput(name, key, words, expected)


# --- vary -----------------------------------------------------------------------------------------
#
# Numbers of a scene file varied: which, and every value, exact, made when asked for.


MAX_MEMBERS = 10_000_000

#: Varied numbers by key: a sequence of values or ``"FROM:TO:N"`` each, of which every combination
#: is a member; or arrays with a row for each member; or the members one by one, each with the same
#: keys; or texts ``KEY=FROM:TO:N``, as on the command line.
Vary = Mapping[str, Any] | Sequence[Mapping[str, Any]] | Sequence[str]


class MemberRows(LazySequence[tuple[Exact, ...]]):
    """A row of values for each member, made when asked.

    ``product``: every combination of the columns' values, the last column's changing fastest; else
    the columns are as long as the rows are many.
    """

    def __init__(self, columns: Sequence[ExactNumbers[Exact]], product: bool) -> None:
        self.columns, self.product = tuple(columns), product
        self.sizes = sizes = [column.size for column in columns]
        self._count = math.prod(sizes) if product else sizes[0]
        #: For each column how many rows have the same value in a row of rows.
        self.repeats = [1] * len(sizes)
        if product:
            self.repeats = [math.prod(sizes[i + 1 :]) for i in range(len(sizes))]

    def __len__(self) -> int:
        return self._count

    def at(self, k: int) -> tuple[Exact, ...]:
        """The values of a member."""
        each = zip(self.columns, self.repeats, strict=True)
        return tuple(column[k // repeat % len(column)] for column, repeat in each)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, MemberRows) and self.product == other.product:
            return self.columns == other.columns
        return super().__eq__(other)

    __hash__ = None

    def __repr__(self) -> str:
        return f"MemberRows({[column.summary for column in self.columns]}, {self.product})"


class Variation(NamedTuple):
    """What is varied: the keys, and a row of values for each member."""

    keys: tuple[str, ...]
    rows: MemberRows


def options(texts: Sequence[str], name: str, units: str = "") -> dict[str, Sequence[Exact]]:
    """What all ``--vary``, ``KEY=FROM:TO:N`` or ``KEY=a,b,c``, say together; raises BadInput.

    Here and below ``units`` are those of the scene.
    """
    varied: dict[str, Sequence[Exact]] = {}
    for text in texts:
        key, equals, listed = text.partition("=")
        if not equals:
            raise BadInput(name, "--vary", text, "KEY=FROM:TO:N or KEY=a,b,c")
        key = key.strip()
        values = numbers(listed, key, name, units, unit(key))
        if key in varied:
            raise BadInput(name, "--vary", text, f"{key} once")
        varied[key] = values
    return varied


def numbers(text: str, key: str, name: str, units: str, dimension: str) -> Sequence[Exact]:
    """The numbers of ``a,b,c``, where each may be ``FROM:TO:N``: N evenly spaced, ends included.

    ``dimension``: as ``unit`` in :func:`polhode.numbers.conversion.in_text`.  Raises BadInput.
    """
    parts = []
    for item in text.split(","):
        try:
            first, *rest = item.split(":")
            ends = [in_text(x, units, dimension) for x in (first, *rest[:1])]
        except ExpressionError as fault:
            raise BadInput(name, key, item, f"numbers ({fault})") from None
        if rest and _is_mixed((first, rest[0]), ends):
            raise BadInput(name, key, item, "a unit at FROM and at TO, or at neither")
        count = int(rest[1]) if rest[1:] and re.fullmatch(r"\s*\d{1,9}\s*", rest[1]) else 0
        if rest and not (len(rest) == 2 and 1 <= count <= MAX_MEMBERS):
            raise BadInput(name, key, item, f"FROM:TO:N with N from 1 to {MAX_MEMBERS}")
        parts.append(spaced(ends[0], ends[1], count) if rest else ends)
    return parts[0] if len(parts) == 1 else [x for part in parts for x in part]


def _is_mixed(texts: Sequence[str], ends: Sequence[Exact]) -> bool:
    """Whether one end of a range has a unit and the other none: ``500:600 rpm`` may mean 500 rpm or
    500 rad/s.  0 is 0 in any unit."""
    return len({in_units(text) for text, end in zip(texts, ends, strict=True) if end != 0}) > 1


def grid(vary: Vary, name: str, units: str = "", starts: Flat | None = None) -> Variation:
    """Keys and rows of what is varied, beside an array of starts if there is one; raises BadInput.

    ``starts``: (N, columns of a state), finite numbers.
    """
    if isinstance(vary, (list, tuple)) and vary and all(isinstance(x, str) for x in vary):
        vary = options(vary, name, units)
    product = isinstance(vary, Mapping)
    arrays: list[ExactNumbers[Fraction]] = []
    if isinstance(vary, Mapping):
        keys, arrays = row_by_row(vary, name, starts)
        if not arrays:
            columns = [_column(key, values, name, units) for key, values in vary.items()]
            keys = [*vary]
    else:
        vary = each(name, "vary", vary, lambda member: member, "keys with their values, or members")
        for k, member in enumerate(vary):
            of_kind(name, f"vary[{k + 1}]", member, Mapping, "a mapping of keys to values")
        keys = [*vary[0]] if vary else []
        for k, member in enumerate(vary):
            if set(member) != set(keys):
                listed = ", ".join(map(plain, member))
                raise BadInput(name, f"member {k + 1}", listed, f"the keys {', '.join(keys)}")
        columns = [
            ExactNumbers(tuple(_exact(m[key], key, name, units) for m in vary)) for key in keys
        ]
    if not keys:
        raise BadInput(name, "vary", None, "at least one number of the scene file to vary")
    rows = MemberRows(arrays or columns, product and not arrays)
    if len(rows) > MAX_MEMBERS:
        expected = f"at most {MAX_MEMBERS}; split the sweep"
        raise BadInput(name, "vary", f"{len(rows)} members", expected)
    if THETA in keys and not arrays:
        thetas = rows.columns[keys.index(THETA)]
        largest = max(thetas.ends or thetas, key=abs, default=ZERO)
        if abs(largest) > 2 * pi():
            say_doubt(name, doubtful_theta(largest))
    return Variation(tuple(keys), rows)


def _column(key: str, values: object, name: str, units: str) -> ExactNumbers[Exact]:
    if isinstance(values, str):
        values = numbers(values, key, name, units, unit(key))
        return values if isinstance(values, ExactNumbers) else ExactNumbers(tuple(values))
    if isinstance(values, ExactNumbers):
        return values
    listed, several = numbers_given(values)
    if not several:
        raise BadInput(name, key, plain(values), "a sequence of numbers, or FROM:TO:N")
    if not listed:
        raise BadInput(name, key, "nothing", "at least one value")
    return ExactNumbers(tuple(_exact(x, key, name, units) for x in listed))


def _exact(value: object, key: str, name: str, units: str) -> Exact:
    try:
        return reader(units, unit(key))(value)
    except ValueError as fault:
        raise BadInput(name, key, plain(value), f"a number ({fault})") from None
