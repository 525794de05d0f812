"""The starts of ``polhode sweep --starts FILE``: a row each, in CSV, NPY, or a saved result."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import npy_header, read_whole
from polhode.results.cells import texts, word_of
from polhode.results.reader import is_result
from polhode.runs.saved import load_result
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    import numpy.typing as npt

_MOST = 1 << 32  # bytes
_FAULTS = (*UNREADABLE, OSError, EOFError, MemoryError, OverflowError)


def read(path: Path, scene: Scene, extended: bool = False) -> npt.NDArray[Any]:
    """The rows of a file; raises BadInput.

    A CSV has the columns of the scene's states, in any order under a header, in theirs without one;
    its decimals are rounded to doubles, or to longdoubles where ``extended``.  Of a result that
    polhode saved its columns of those names are taken: the states of a run, the crossings of a
    section, a family of orbits.
    """
    ending = path.suffix.lower()
    if is_result(path) or (ending == ".json" and path.is_file()):
        return _of_result(path, scene, extended)
    if ending not in (".csv", ".npy") and path.exists():
        expected = "a file .csv or .npy, or a result that polhode saved"
        raise BadInput(str(path), "--starts", path.suffix or None, expected)
    data = read_whole(path, _MOST, "a readable file of starts")
    return _array(path, data) if ending == ".npy" else _table(path, data, scene, extended)


def _of_result(path: Path, scene: Scene, extended: bool) -> npt.NDArray[Any]:
    import numpy as np

    columns = {x.name: x for x in load_result(path).table().columns}
    if any(name not in columns for name in scene.columns):
        expected = f"columns {','.join(scene.columns)}"
        raise BadInput(str(path), "columns", ",".join(columns), expected)
    kind = np.longdouble if extended else np.float64
    held = [columns[name] for name in scene.columns]
    try:
        return np.array([[*map(kind, texts(x.values, word_of(x)))] for x in held], kind).T
    except ValueError as fault:
        expected = f"a number in every cell of {','.join(scene.columns)} ({fault})"
        raise BadInput(str(path), "columns", None, expected) from None


def _array(path: Path, data: bytes) -> npt.NDArray[Any]:
    import numpy as np

    try:
        dtype, count, begin = npy_header(io.BytesIO(data))
        if begin + count * dtype.itemsize != len(data):
            raise ValueError("it is not as long as it says")
        found: npt.NDArray[Any] = np.load(io.BytesIO(data), allow_pickle=False)
    except _FAULTS as fault:
        raise BadInput(str(path), "file", None, f"an array that NumPy wrote ({fault})") from None
    return found


def _table(path: Path, data: bytes, scene: Scene, extended: bool) -> npt.NDArray[Any]:
    import numpy as np

    name, columns = str(path), list(scene.columns)
    expected = f"{len(columns)} numbers {','.join(columns)}"
    try:
        lines = csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""))
        rows = [(lines.line_num, [cell.strip() for cell in row]) for row in lines if any(row)]
    except (UnicodeDecodeError, csv.Error) as fault:
        raise BadInput(name, "file", None, f"a CSV file ({fault})") from None
    if rows and sorted(rows[0][1]) == sorted(columns):
        header = rows.pop(0)[1]
        order = [header.index(column) for column in columns]
    else:
        order = list(range(len(columns)))
    kind = np.longdouble if extended else np.float64
    found = np.empty((len(rows), len(columns)), kind)
    for k, (line, cells) in enumerate(rows):
        try:
            if len(cells) != len(columns) or any("_" in x or not x.isascii() for x in cells):
                raise ValueError
            found[k] = [kind(cells[i]) for i in order]
            if any(_lost(cells[i], x) for i, x in zip(order, found[k], strict=True)):
                raise ValueError
        except ValueError:
            raise BadInput(name, f"line {line}", ",".join(cells), expected) from None
    return found


def _lost(cell: str, rounded: Any) -> bool:
    """Whether a decimal that is not 0 is one too small for the type to have its digits."""
    import numpy as np

    if abs(rounded) >= np.finfo(type(rounded)).smallest_normal:
        return False
    return any(digit in "123456789" for digit in cell.lower().partition("e")[0])
