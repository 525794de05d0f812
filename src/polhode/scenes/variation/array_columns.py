"""Columns of a sweep given as arrays: N members, row by row, never every combination.

``{"start.omega": (N, 3), "start.gamma": (N, 3), "body.weight": (N, 1)}``.  The floats stay the
array that they are; exact numbers are made where a member is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from polhode.common.arguments import rows_of
from polhode.common.errors import BadInput, plain
from polhode.numbers.exact_sequences import ExactNumbers

if TYPE_CHECKING:
    from polhode.numbers.rows import Flat

#: How many numbers the keys have that are no single number.
_WIDTHS = {
    **{f"body.{key}": 3 for key in ("moments", "centre")},
    **{f"start.{key}": 3 for key in ("omega", "gamma", "momentum", "angles", "rates")},
    "start.quaternion": 4,
}


def row_by_row(
    vary: Mapping[str, Any], name: str
) -> tuple[tuple[str, ...], list[ExactNumbers[Fraction]]]:
    """Keys and columns, where an array of rows is among what is varied; else none of them.

    Raises BadInput, also for two arrays of one length without rows: they may mean either.
    """
    arrays = {key: given for key, given in vary.items() if _dimensions(given) > 0}
    rows = [key for key, given in arrays.items() if _dimensions(given) > 1]
    if not rows:
        _ask(arrays, name)
        return (), []
    first, keys = rows[0], []
    columns: list[ExactNumbers[Fraction]] = []
    for key, given in vary.items():
        if key not in arrays:
            expected = f"an array with a row for each of {first}: never every combination"
            raise BadInput(name, key, plain(given), expected)
        width = _WIDTHS.get(key, 1)
        table = rows_of(name, key, given if key in rows else _standing(given), width)
        own = [key] if width == 1 else [f"{key}[{i + 1}]" for i in range(width)]
        twice = [number for number in own if number in keys]
        if twice:
            raise BadInput(name, key, f"{twice[0]}, given twice", "each number in one array")
        keys += own
        columns += [ExactNumbers(floats=column.copy()) for column in table.T]
        if len(columns[-1]) != len(columns[0]):
            expected = f"{len(columns[0])} rows, as many as {next(iter(vary))} has"
            raise BadInput(name, key, f"{len(columns[-1])} rows", expected)
    return tuple(keys), columns


def _dimensions(given: object) -> int:
    """Of an array of any kind; 0 of anything else."""
    return int(getattr(given, "ndim", 0)) if hasattr(given, "__array__") else 0


def _standing(given: object) -> Flat:
    """An array of numbers as one of rows with a number each."""
    import numpy as np

    found: Flat = np.asanyarray(given)[:, None]
    return found


def _ask(arrays: Mapping[str, Any], name: str) -> None:
    """Two arrays of one length may be meant member by member, or every combination of them."""
    lengths: dict[int, str] = {}
    for key, given in arrays.items():
        other = lengths.setdefault(len(given), key)
        if other != key and len(given) > 1:
            what = f"two arrays of {len(given)} numbers ({other} is the other)"
            expected = (
                "[:, None] on both for member by member, or .tolist() on both for every combination"
            )
            raise BadInput(name, key, what, expected)
