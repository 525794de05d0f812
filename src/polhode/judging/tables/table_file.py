"""Tables in files: our own results, CSV, NumPy's .npz and .npy, Parquet if pandas reads it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import called, npy_header, read_npz, read_whole
from polhode.judging.tables.column_aliases import PLAIN, Naming, columns
from polhode.judging.tables.csv_file import (
    MAX_BYTES,
    read_csv,
    refuse_names,
    sheet_of,
    table_of_columns,
)
from polhode.judging.tables.table import TrajectoryTable, of_run
from polhode.numbers.number_types import NumberType
from polhode.results import reader, writer
from polhode.results.cells import texts, word_of
from polhode.runs.saved import load_result
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.scene import Scene

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


def read_table(
    path: Path, number: NumberType | None = None, names: Naming = PLAIN
) -> TrajectoryTable:
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
            if suffix == ".csv" and str(why) == reader.CHANGED:
                beside = called(writer.beside(path))
                remarks = (f"{beside} was not read: the table was changed since then",)
        else:
            return _of_result(path, number, names)
    if suffix in _ARRAYS:
        return table_of_columns(_arrays(path, names), number, str(path), names)
    table = read_csv(path, number, names)
    return replace(table, remarks=(*remarks, *table.remarks))


def _of_result(path: Path, number: NumberType | None, names: Naming) -> TrajectoryTable:
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


def _arrays(path: Path, names: Naming) -> Arrays:
    """The columns of a file; raises BadInput."""
    data = read_whole(path, MAX_BYTES, "a readable file of arrays")
    if path.suffix.lower() == ".parquet":
        return _parquet(path, data)
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


# --- starts ---------------------------------------------------------------------------------------
#
# The starts of ``polhode sweep --starts FILE``: a row each, in CSV, NPY, or a saved result.


_MOST = 1 << 32  # bytes


def read_starts(path: Path, scene: Scene, extended: bool = False) -> npt.NDArray[Any]:
    """The rows of a file; raises BadInput.

    A CSV, written in any way in which a table may be, has the columns of the scene's states, in any
    order under a header, in theirs without one; its decimals are rounded to doubles, or to
    longdoubles where ``extended``.  Of a result that
    polhode saved its columns of those names are taken: the states of a run, the crossings of a
    section, a family of orbits.
    """
    ending = path.suffix.lower()
    if reader.is_result(path) or (ending == ".json" and path.is_file()):
        return _starts_of_result(path, scene, extended)
    if ending not in (".csv", ".npy") and path.exists():
        expected = "a file .csv or .npy, or a result that polhode saved"
        raise BadInput(str(path), "--starts", path.suffix or None, expected)
    data = read_whole(path, _MOST, "a readable file of starts")
    return _array(path, data) if ending == ".npy" else _starts(path, data, scene, extended)


def _starts_of_result(path: Path, scene: Scene, extended: bool) -> npt.NDArray[Any]:
    columns = {x.name: x for x in load_result(path).table().columns}
    if any(name not in columns for name in scene.columns):
        expected = f"columns {','.join(scene.columns)}"
        raise BadInput(str(path), "columns", ",".join(columns), expected)
    kind = np.longdouble if extended else np.float64
    numbers = [columns[name] for name in scene.columns]
    try:
        return np.array([[*map(kind, texts(x.values, word_of(x)))] for x in numbers], kind).T
    except ValueError as fault:
        expected = f"a number in every cell of {','.join(scene.columns)} ({fault})"
        raise BadInput(str(path), "columns", None, expected) from None


def _array(path: Path, data: bytes) -> npt.NDArray[Any]:
    try:
        dtype, count, begin = npy_header(io.BytesIO(data))
        if begin + count * dtype.itemsize != len(data):
            raise ValueError("it is not as long as it says")
        array: npt.NDArray[Any] = np.load(io.BytesIO(data), allow_pickle=False)
    except _FAULTS as fault:
        raise BadInput(str(path), "file", None, f"an array that NumPy wrote ({fault})") from None
    return array


def _starts(path: Path, data: bytes, scene: Scene, extended: bool) -> npt.NDArray[Any]:
    columns, sheet = [*scene.columns], sheet_of(path, data, PLAIN)
    expected = f"{len(columns)} numbers {','.join(columns)}"
    rows, order = sheet.rows, [*range(len(columns))]
    if sorted(sheet.header) == sorted(columns):
        order = [sheet.header.index(column) for column in columns]
    elif sheet.header and sheet.is_named:  # of other columns
        raise BadInput(str(path), "line 1", ",".join(sheet.header), expected)
    kind = np.longdouble if extended else np.float64
    starts = np.empty((len(rows), len(columns)), kind)
    for k, (line, cells) in enumerate(rows):
        try:
            if len(cells) != len(columns) or any("_" in x or not x.isascii() for x in cells):
                raise ValueError
            starts[k] = [kind(cells[i]) for i in order]
            if any(_lost(cells[i], x) for i, x in zip(order, starts[k], strict=True)):
                raise ValueError
        except ValueError:
            raise BadInput(str(path), f"line {line}", ",".join(cells), expected) from None
    return starts


def _lost(cell: str, rounded: Any) -> bool:
    """Whether a decimal that is not 0 is one too small for the type to have its digits."""
    if abs(rounded) >= np.finfo(type(rounded)).smallest_normal:
        return False
    return any(digit in "123456789" for digit in cell.lower().partition("e")[0])
