"""Tables in files: CSV, arrays in NumPy's .npz and .npy, and Parquet where pandas reads it."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import read_npz, read_whole
from polhode.judging.tables.column_aliases import columns
from polhode.judging.tables.csv_file import MAX_BYTES, read_csv
from polhode.judging.tables.given_columns import refuse_names, table_of_columns
from polhode.judging.tables.naming import PLAIN, Naming
from polhode.judging.tables.sidecar import saved_type
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import exactly
from polhode.numbers.expression import decimal
from polhode.numbers.number_types import NumberType
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, STATE

if TYPE_CHECKING:
    import pandas as pd

ENDINGS = (".npy", ".npz", ".parquet")
_OWN = {"times": ("t",), "states": STATE, "angles": ANGLES, "attitude": ATTITUDE}
_FAULTS = (*UNREADABLE, OSError, EOFError, MemoryError, OverflowError, KeyError)
_AXES = {3: "xyz", 4: "wxyz"}

#: Columns by the names in the file.
Arrays: TypeAlias = "Mapping[str, object] | pd.DataFrame"


def read_table(path: Path, number: NumberType | None = None, names: Naming = PLAIN) -> Table:
    """A file as a table, of any kind that its ending tells; raises BadInput.

    ``number``: the type of its numbers, where that is known.  ``names``: columns that were named
    beside it.
    """
    if path.suffix.lower() not in ENDINGS:
        return read_csv(path, number, names)
    held, own = _arrays(path, names)
    return table_of_columns(held, number or own, str(path), names)


def _arrays(path: Path, names: Naming) -> tuple[Arrays, NumberType | None]:
    """The columns of a file, and the type of their numbers where it says it; raises BadInput."""
    data = read_whole(path, MAX_BYTES, "a readable file of arrays")
    if path.suffix.lower() == ".parquet":
        return _parquet(path, data), None
    import numpy as np

    try:
        if zipfile.is_zipfile(io.BytesIO(data)):
            held: Any = read_npz(data, most=MAX_BYTES)
        else:
            held = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
    except _FAULTS as fault:
        expected = f"arrays of numbers that NumPy wrote ({fault})"
        raise BadInput(str(path), "file", None, expected) from None
    if not isinstance(held, dict):
        return _of_one(path, held, names), None
    if {"about", "times", "states"} <= {*held}:
        return _of_polhode(path, held)
    flat: dict[str, object] = {}
    for name, array in held.items():
        parts = _flat(path, name, array)
        if again := [part for part in parts if part in flat]:
            expected = f"each column once ({name!r} has it again)"
            raise BadInput(str(path), "columns", again[0], expected)
        flat |= parts
    return flat, None


def _parquet(path: Path, data: bytes) -> pd.DataFrame:
    try:
        import pandas as pd

        found: pd.DataFrame = pd.read_parquet(io.BytesIO(data))
    except ImportError:
        raise BadInput(str(path), "file", None, "pandas and pyarrow installed, for it") from None
    except Exception as fault:  # pyarrow has classes of its own for what is no such file
        reason = str(fault).partition("\n")[0]
        raise BadInput(str(path), "file", None, f"a Parquet file ({reason})") from None
    return found


def _of_one(path: Path, array: Any, names: Naming) -> dict[str, object]:
    """Columns of one array: of its fields' names, or of those that were named beside it."""
    if array.dtype.names:
        return {name: array[name] for name in array.dtype.names}
    if array.ndim != 2 or len(names.header) != array.shape[1]:
        expected = "fields with names, or --columns with a name for each of its columns"
        raise BadInput(str(path), "shape", array.shape, expected)
    # Here, since of two columns of one name a mapping keeps the last.
    refuse_names(str(path), "columns", names.header, names.columns(names.header))
    return {name: array[:, k] for k, name in enumerate(names.header)}


def _of_polhode(path: Path, held: Mapping[str, Any]) -> tuple[dict[str, object], NumberType]:
    """A trajectory that polhode saved: its decimals as numbers of its type."""
    try:
        about = json.loads(str(held["about"]))
        number = saved_type(about["number"], about["bits"])
        if number is None:
            raise ValueError
        own: dict[str, object] = {}
        for key, names in _OWN.items():
            if key in held:
                rows = held[key].reshape(len(held["times"]), -1)
                own |= {
                    name: [None if x == "" else _exactly(str(x), number, key) for x in rows[:, k]]
                    for k, name in enumerate(names[: rows.shape[1]])
                }
    except (*_FAULTS, AttributeError, TypeError):
        raise BadInput(str(path), "about", None, "a trajectory that polhode saved") from None
    return own, number


def _exactly(text: str, number: NumberType, key: str) -> Fraction:
    """A number of the type from its decimal; of a time the decimal itself."""
    found = decimal(text)
    return found if key == "times" else exactly(number.rounded(found))


def _flat(path: Path, name: str, array: Any) -> dict[str, object]:
    """A column, or those of an array of three or four: ``gamma`` as ``gamma_x``, ...; of matrices
    ``R`` as ``R_11``, ..."""
    if array.ndim == 1:
        return {name: array}
    if array.ndim == 0:
        return {}
    axes: Sequence[str] = _AXES.get(array.shape[1], "") if array.ndim == 2 else ""
    prefix = "w" if name.lower() == "omega" else name  # omega_x is a column along space axes
    parts = {f"{prefix}_{axis}": array[:, k] for k, axis in enumerate(axes)}
    if array.shape[1:] == (3, 3):
        parts = {f"{prefix}_{i + 1}{j + 1}": array[:, i, j] for i in range(3) for j in range(3)}
    if all(one.name is None for one in columns(["t", *parts])[1:]):
        expected = (
            "columns, or arrays of shape (n, 3), (n, 4) or (n, 3, 3) such as omega, gamma, "
            "quaternion, R"
        )
        raise BadInput(str(path), name, array.shape, expected)
    return parts
