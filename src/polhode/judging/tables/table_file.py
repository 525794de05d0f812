"""Tables in files: our own results, CSV, NumPy's .npz and .npy, Parquet if pandas reads it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import called, read_npz, read_whole
from polhode.judging.tables.column_aliases import PLAIN, Naming, columns
from polhode.judging.tables.csv_file import MAX_BYTES, read_csv, refuse_names, table_of_columns
from polhode.judging.tables.table import Table, of_run
from polhode.numbers.number_types import NumberType
from polhode.results import reader, writer
from polhode.runs.saved import load_result
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library

if TYPE_CHECKING:
    import pandas as pd

ENDINGS = (".csv", ".tsv", ".npy", *(x for x in writer.ENDINGS if x != ".csv"))
_ARRAYS = (".npy", ".npz", ".parquet")
_FAULTS = (*UNREADABLE, OSError, EOFError, MemoryError, OverflowError, KeyError)
_AXES = {3: "xyz", 4: "wxyz"}

#: Columns by the names in the file.
Arrays: TypeAlias = "Mapping[str, object] | pd.DataFrame"


def is_table(name: str | Path) -> bool:
    """Whether a table is meant: by its ending, or an existing file that is no scene."""
    path = Path(name)
    suffix = path.suffix.lower()
    return suffix in ENDINGS or (
        suffix != ".toml" and not library.ships(str(name)) and path.is_file()
    )


def read_table(path: Path, number: NumberType | None = None, names: Naming = PLAIN) -> Table:
    """A file as a table, of any kind that its ending tells; raises BadInput.

    A result that polhode saved and nobody changed is read as what it is; a CSV file that was
    changed since as any other one, and that is told.  ``number``: the type of its numbers, where
    that is known.  ``names``: columns that were named beside it.
    """
    suffix = path.suffix.lower()
    remarks: tuple[str, ...] = ()
    if suffix == ".json":
        return _of_result(path, number, names)
    if suffix in writer.ENDINGS:
        try:
            reader.kind_at(path)
        except ValueError as why:
            remarks = _unread(path, str(why))
        else:
            return _of_result(path, number, names)
    if suffix in _ARRAYS:
        return table_of_columns(_arrays(path, names), number, str(path), names)
    table = read_csv(path, number, names)
    return replace(table, remarks=(*remarks, *table.remarks))


def _of_result(path: Path, number: NumberType | None, names: Naming) -> Table:
    """A result's table; of a run the run itself, but for what its file says of its digits."""
    result = load_result(path)
    if isinstance(result, Trajectory):
        if names is PLAIN and number in (None, result.number):
            its = f"{result.number.name} ({result.number.bits} bits)"
            remark = f"polhode's own run of {result.scene.name} in {its}"
            table = of_run(replace(result))
            return replace(table, name=called(path), remarks=(remark, *table.remarks))
        number = number or result.number
    columns = {x.name: x.values for x in result.table().columns}
    return replace(table_of_columns(columns, number, str(path), names), name=called(path))


def _unread(path: Path, why: str) -> tuple[str, ...]:
    """That the facts beside a CSV file were not read, where it was changed."""
    if path.suffix.lower() == ".csv" and why == reader.CHANGED:
        return (f"{called(writer.beside(path))} was not read: the table was changed since then",)
    return ()


def _arrays(path: Path, names: Naming) -> Arrays:
    """The columns of a file; raises BadInput."""
    data = read_whole(path, MAX_BYTES, "a readable file of arrays")
    if path.suffix.lower() == ".parquet":
        return _parquet(path, data)
    import numpy as np

    try:
        if zipfile.is_zipfile(io.BytesIO(data)):
            content: Any = read_npz(data, most=MAX_BYTES)
        else:
            content = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
    except _FAULTS as fault:
        expected = f"arrays of numbers that NumPy wrote ({fault})"
        raise BadInput(str(path), "file", None, expected) from None
    if not isinstance(content, dict):
        return _of_one(path, content, names)
    flat: dict[str, object] = {}
    for name, array in content.items():
        parts = _flat(path, name, array)
        if again := [part for part in parts if part in flat]:
            expected = f"each column once ({name!r} has it again)"
            raise BadInput(str(path), "columns", again[0], expected)
        flat |= parts
    return flat


def _parquet(path: Path, data: bytes) -> pd.DataFrame:
    try:
        import pandas as pd

        frame: pd.DataFrame = pd.read_parquet(io.BytesIO(data))
    except ImportError:
        raise BadInput(str(path), "file", None, "pandas and pyarrow installed, for it") from None
    except Exception as fault:  # pyarrow has classes of its own for what is no such file
        reason = str(fault).partition("\n")[0]
        raise BadInput(str(path), "file", None, f"a Parquet file ({reason})") from None
    return frame


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
    if all(column.name is None for column in columns(["t", *parts])[1:]):
        expected = (
            "columns, or arrays of shape (n, 3), (n, 4) or (n, 3, 3) such as omega, gamma, "
            "quaternion, R"
        )
        raise BadInput(str(path), name, array.shape, expected)
    return parts
