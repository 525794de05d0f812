"""Results in files, by the ending of the name; each loads again and is equal."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, nearest
from polhode.common.files import check_writable, npz, read_npz, read_whole, write_whole
from polhode.output import archive, csv_tables, frames
from polhode.output.json_object import JsonObject
from polhode.output.json_results import as_json
from polhode.output.results import document, summaries
from polhode.output.results.kinds import Value
from polhode.output.results.tables import table
from polhode.results import reader
from polhode.results.result import Result
from polhode.runs import saved
from polhode.runs.sweep.ensemble import Ensemble
from polhode.runs.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

SUFFIXES = (".csv", ".json", ".npz", ".parquet")
_CERTIFICATE = b'"format": "polhode certificate'
KEY = "result"  # of the document, beside what the command prints


def save(found: Result, path: str | Path, more: JsonObject | None = None) -> None:
    """Write a result; raises BadInput.  ``more``: what else the JSON beside a table says."""
    of_kind("save", "path", path, (str, Path), "the path of a file")
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise BadInput(str(path), "file", None, f"a name that ends in {' or '.join(SUFFIXES)}")
    check_writable(path, SUFFIXES)
    files = _FORMATS[suffix](found, path) if more is None else _csv(found, path, more)
    for place in files:
        _refuse_another(place, type(found).__name__)
    write_whole(files)


def load_result(path: str | Path) -> Result:
    """Load what ``.save`` wrote: an equal result.

    Parameters
    ----------
    path : str or Path
        A file that ``.save`` of any result wrote; of a CSV the JSON file beside it is read, too.

    Returns
    -------
    Result
        A run is equal to what was saved, and callable; of other kinds a :class:`Saved`, which has
        the columns and facts that they had.

    Raises
    ------
    BadInput
        A file of another kind, or a damaged one.

    Examples
    --------
    >>> import os, tempfile, polhode
    >>> found = polhode.levels("general/asymmetric-chaotic")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found.save(os.path.join(folder, "levels.npz"))
    ...     again = polhode.load_result(os.path.join(folder, "levels.npz"))
    >>> again, again.fact("f") == found.here.f
    (<Levels of general/asymmetric-chaotic: 8 curves, 2 cusps>, True)
    """
    of_kind("load_result", "path", path, (str, Path), "the path of a file")
    path = Path(path)
    if reader.is_result(path):
        return saved.load_result(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise BadInput(
            str(path), "file", None, f"a name that ends in {nearest(suffix, [*SUFFIXES])}"
        )
    told = _told(path)
    if told is None:
        expected = "a result that polhode saved"
        if suffix == ".json" and _CERTIFICATE in path.read_bytes()[:80]:
            expected += "; this is a certificate, which polhode.verify checks"
        raise BadInput(str(path), "file", None, expected)
    if isinstance(told, Trajectory):
        return told
    return document.result_of(told, str(path))


def _csv(found: Result, path: Path, more: JsonObject | None = None) -> dict[Path, str | bytes]:
    rows, beside = summaries.rows(found), summaries.summary(found, beside=True) | (more or {})
    texts = "".join(",".join(row) + "\n" for row in rows)
    return {path: texts, csv_tables.sidecar(path): _with_document(found, beside)}


def _json(found: Result, path: Path) -> dict[Path, str | bytes]:
    return {path: _with_document(found, summaries.summary(found))}


def _npz(found: Result, path: Path) -> dict[Path, str | bytes]:
    if isinstance(found, Trajectory):
        return {path: npz(archive.arrays(found), packed=True)}
    held = {**summaries.arrays(found), KEY: np.array(json.dumps(document.document(found)))}
    return {path: npz(held, packed=True)}


def _parquet(found: Result, path: Path) -> dict[Path, str | bytes]:
    from io import BytesIO

    frame = to_pandas(found).reset_index()
    frame = frame.map(_parquet_cell)
    frame.attrs = {KEY: json.dumps(document.document(found))}
    out = BytesIO()
    frames.needed("pyarrow")
    frame.to_parquet(out, engine="pyarrow")
    return {path: out.getvalue()}


def _parquet_cell(x: Value) -> Value:
    """A wider number than Parquet has as text."""
    from polhode.output.results.texts import text_of

    wide = hasattr(x, "_mpf_") or (isinstance(x, np.longdouble))
    return text_of([x])[0] if wide else x


_FORMATS = {".csv": _csv, ".json": _json, ".npz": _npz, ".parquet": _parquet}


def _with_document(found: Result, summary: JsonObject) -> str:
    return as_json(summary | {KEY: json.dumps(document.document(found))})


def _told(path: Path) -> Value:
    """The document in a file; a run of its archive; None where there is neither."""
    suffix = path.suffix.lower()
    place = csv_tables.sidecar(path) if suffix == ".csv" else path
    data = read_whole(place, archive.MAX_BYTES, "a result that polhode saved")
    try:
        if suffix == ".npz":
            held = read_npz(data)
            if KEY not in held:
                return archive.run_of(held)
            told = json.loads(str(held[KEY]))
        elif suffix == ".parquet":
            told = json.loads(_parquet_attrs(data)[KEY])
        else:
            told = json.loads(json.loads(data)[KEY])
    except archive.DAMAGED:
        return None
    return told if isinstance(told, dict) else None


def _parquet_attrs(data: bytes) -> dict[str, str]:
    from io import BytesIO

    frames.needed("pyarrow")
    parquet = frames.needed("pyarrow.parquet")
    try:
        found = parquet.read_schema(BytesIO(data)).metadata[b"PANDAS_ATTRS"]
    except Exception as fault:  # pyarrow has classes of its own for what is no such file
        raise ValueError(str(fault)) from None
    told: dict[str, str] = json.loads(found)
    return told


def _refuse_another(place: Path, kind: str) -> None:
    """Refuse to overwrite what is no result of this kind; an empty file is nothing."""
    if not os.path.isfile(place) or not place.stat().st_size:
        return
    try:
        there = _kind_there(place)
    except BadInput:
        there = ""
    if there != kind:
        what = f"the file of a result {there}" if there else "another, perhaps a certificate"
        expected = f"a new file, or that of a result {kind} (there is {what})"
        raise BadInput(str(place), "file", None, expected)


def _kind_there(place: Path) -> str:
    """What kind of result a file holds, empty where it holds none."""
    told = _told(place)
    if isinstance(told, Trajectory):
        return "Trajectory"
    if told is not None:
        return str(told.get("kind", ""))
    return ""


def to_pandas(found: Result) -> pd.DataFrame:
    """Its table as a DataFrame; times are doubles there."""
    if isinstance(found, Trajectory):
        return frames.of_run_pandas(found)
    if isinstance(found, Ensemble):
        return frames.of_ensemble_pandas(found)
    made = table(found)
    return frames.of_columns(made.columns, made.labels)


def to_xarray(found: Result) -> xr.Dataset:
    """Its table as a Dataset along its index."""
    made: xr.Dataset
    if isinstance(found, Trajectory):
        made = frames.of_run_xarray(found)
    elif isinstance(found, Ensemble):
        made = frames.of_ensemble_xarray(found)
    else:
        frames.needed("xarray")
        made = to_pandas(found).to_xarray()
    return made
