"""What the writer wrote, read within bounds; nothing in a file names code.

JSON and Parquet files have no sum: a digit that somebody changed in one is read.  A CSV file that
was changed is told by the digest in the file beside it, a changed NPZ file by its own sums.
"""

from __future__ import annotations

import csv
import io
import json
import re
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from polhode.common.errors import UNREADABLE, BadInput, nearest
from polhode.common.files import MOST_UNPACKED, check_writable, is_stream, read_npz, read_whole
from polhode.results.cells import DOUBLE, DTYPES, OBJECT, of_json, plain, values_of
from polhode.results.table import RESERVED, Column, Content, Fact, Table, Value
from polhode.results.writer import ABOUT, ENDINGS, FORMAT, METADATA, beside, digest, needed

MOST_BYTES = 1 << 31
MOST_COLUMNS = 10_000  # and facts
MOST_CELLS = 200_000_000
MOST_DIGITS = 70_000  # of a column on a terminal
_USUAL_DIGITS = Column._field_defaults["digits"]
_HEAD = 4096  # bytes of a JSON file that tell its kind

#: The kinds of results, by the names of their classes.
KINDS = (
    *("About", "Cases", "CertifiedEvents", "ChaosMap", "CheckReport", "Conditioning"),
    *("Description", "Enclosure", "Ensemble", "EventTimes", "FieldComparison"),
    *("Frequencies", "Judgement", "Levels", "Lyapunov", "ObservedOrder", "Orbit", "OrbitFamily"),
    *("OrbitSearch", "ProvedChaos", "ProvedOrbit", "ProvedOrbits", "ProvedStability"),
    *("Reductions", "ReferenceTable", "Report", "Section", "Trajectory", "Verdict"),
)
#: What a file that is none makes reading it raise.
DAMAGED = (
    *(LookupError, TypeError, AttributeError, ArithmeticError, MemoryError, csv.Error),
    *UNREADABLE,
)
CERTIFICATE = "polhode certificate"
FOREIGN = "polhode did not write it"
CHANGED = "it was changed since polhode wrote it"


def content_of(path: Path) -> Content:
    """The content of a result's file; raises BadInput for any other file."""
    suffix = path.suffix.lower()
    if suffix not in ENDINGS:
        expected = f"a name that ends in {nearest(suffix, [*ENDINGS])}"
        raise BadInput(str(path), "file", None, expected)
    expected = "a result that polhode saved"
    data = read_whole(path, MOST_BYTES, expected)
    try:
        return _content(*_READERS[suffix](path, data))
    except BadInput:
        raise
    except DAMAGED as fault:
        reason = "it is damaged" if isinstance(fault, (KeyError, RecursionError)) else str(fault)
        raise BadInput(str(path), "file", None, f"{expected} ({reason})") from None


#: The facts of a file and what describes them, and its columns.
_Parts: TypeAlias = tuple[dict[str, Value], Mapping[str, Any]]


def _of_csv(path: Path, data: bytes) -> _Parts:
    place = beside(path)
    about = _object(read_whole(place, MOST_BYTES, f"the facts of {path.name}"))
    if about["sha256"] != digest(data):
        raise ValueError(CHANGED)
    text = io.StringIO(data.decode(), newline="")
    names = next(csv.reader(text), [])
    words = {x["type"] for x in about["about"]["columns"].values()}
    if words == {DOUBLE} and text.tell() < len(data) and not any(gap in data for gap in _GAPS):
        # numpy's own reader is several times as fast
        matrix = np.loadtxt(text, delimiter=",", ndmin=2, comments=None)
        return about, dict(zip(names, matrix.T, strict=True))
    rows = [*csv.reader(text)]
    cells = zip(*rows, strict=True) if rows else (() for _ in names)
    return about, dict(zip(names, cells, strict=True))


_GAPS = (b",,", b",\n", b"\n,", b'"')


def _of_json(path: Path, data: bytes) -> _Parts:
    about = _object(data)
    if "sha256" in about:
        raise ValueError(f"these are the facts of {path.stem}, which is to be read")
    return about, about["columns"]


def _of_npz(path: Path, data: bytes) -> _Parts:
    arrays = dict(read_npz(data))
    about = _object(arrays.pop(ABOUT).tobytes())
    for name, description in about["about"]["facts"].items():
        if "columns" in description:
            about[name] = {key: arrays.pop(f"{name}.{key}") for key in description["columns"]}
    return about, arrays


def _of_parquet(path: Path, data: bytes) -> _Parts:
    parquet = needed("pyarrow.parquet")
    try:
        file = parquet.ParquetFile(io.BytesIO(data))
        metadata, names = file.metadata, file.schema_arrow.names
        _check_size(len(names), metadata.num_rows)
        groups = (metadata.row_group(k) for k in range(metadata.num_row_groups))
        if sum(group.total_byte_size for group in groups) > MOST_UNPACKED:
            raise ValueError(f"more than {MOST_UNPACKED} bytes")
        types = {x.name: str(x.type) for x in file.schema_arrow}
        if not {*types.values()} <= {"double", "int64", "bool", "string"}:
            raise ValueError("columns of other types")
        texts = [name for name, kind in types.items() if kind == "string"]
        about = _object(file.schema_arrow.metadata[METADATA.encode()])
        table = parquet.read_table(io.BytesIO(data), read_dictionary=texts)
        arrays = {name: _arrow_values(table[name], name in texts) for name in names}
    except Exception as fault:  # pyarrow has classes of its own for what is no such file
        raise ValueError(f"no Parquet file: {str(fault)[:80]}") from None
    return about, arrays


def _arrow_values(column: Any, is_text: bool) -> Any:
    """A column of Parquet; of texts, which may be long and one for many rows, not too many."""
    if column.null_count:
        raise ValueError("no value in some rows")
    if not is_text:
        return column.to_numpy()
    words = (x for part in column.chunks for x in part.dictionary.to_pylist())
    longest = max(map(len, words), default=0)
    if 4 * longest * len(column) > MOST_UNPACKED:
        raise ValueError("texts of too many characters")
    return np.array(column.to_pylist(), dtype=np.str_)


_READERS = {".csv": _of_csv, ".json": _of_json, ".npz": _of_npz, ".parquet": _of_parquet}


def is_result(path: Path) -> bool:
    """Whether a file is one that :func:`content_of` may read."""
    try:
        return bool(kind_at(path))
    except ValueError:
        return False


def kind_at(path: Path) -> str:
    """The kind of the result in a file, of which little is read; ValueError where there is none.

    A table that was changed is none; of a table that is gone or empty the facts tell.
    """
    suffix = path.suffix.lower()
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise ValueError
        if suffix == ".csv":
            head = _head_of(beside(path))
            data = read_whole(path, MOST_BYTES, "a table") if path.exists() else b""
            if data and f'"sha256": "{digest(data)}"' not in head:
                raise ValueError(CHANGED if FORMAT in head else FOREIGN)
        elif suffix == ".npz":
            with zipfile.ZipFile(path) as packed, packed.open(f"{ABOUT}.npy") as file:
                np.lib.format.read_magic(file)
                np.lib.format.read_array_header_1_0(file)
                head = file.read(_HEAD).decode(errors="replace")
        elif suffix == ".parquet":
            schema = needed("pyarrow.parquet").read_schema(path)
            head = schema.metadata[METADATA.encode()].decode(errors="replace")
        else:
            head = _head_of(path)
    except ValueError as fault:
        raise ValueError(CHANGED if str(fault) == CHANGED else FOREIGN) from None
    except Exception:  # the libraries below raise almost anything
        raise ValueError(FOREIGN) from None
    beginning = re.match(r'\{\n "format": "([^"]*)",\n "result": "(\w*)",\n', head)
    if beginning is None or beginning[1] != FORMAT:
        raise ValueError(FOREIGN)
    return beginning[2]


def _head_of(path: Path) -> str:
    if not path.is_file():
        return ""
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read(_HEAD)


def _object(data: bytes) -> dict[str, Value]:
    content = json.loads(data, parse_constant=_no_constant)
    if isinstance(content, dict) and str(content.get("format")).startswith(CERTIFICATE):
        raise ValueError("this is a certificate, which polhode.verify checks")
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ValueError("another format than this version's")
    return content


def _no_constant(text: str) -> float:
    raise ValueError(f"{text}: no number")


def _content(about: dict[str, Value], columns: Mapping[str, Any]) -> Content:
    kind, version, title = _text(about["result"]), _text(about["version"]), _text(about["title"])
    if kind not in KINDS:
        raise ValueError(f"result {kind[:40]!r}")
    descriptions = about["about"]["facts"]
    if len(descriptions) > MOST_COLUMNS or not {*descriptions}.isdisjoint(RESERVED):
        raise ValueError("facts that are none")
    table = _table(columns, about["about"]["columns"], about["labels"])
    facts = tuple(_fact(name, about[name], x) for name, x in descriptions.items())
    return Content(kind, version, title, table, facts)


def _table(columns: Mapping[str, Any], descriptions: Value, labels: Value) -> Table:
    if not isinstance(descriptions, dict):
        raise ValueError("no columns")
    if {*columns} != {*descriptions}:
        raise ValueError("other columns than those that it describes")
    sizes = {*map(len, columns.values())}
    if len(sizes) > 1:
        raise ValueError("columns of several lengths")
    _check_size(len(columns), max(sizes, default=0))
    if type(labels) is not int or not 0 <= labels <= len(columns):
        raise ValueError("labels")
    listed = []
    for name, description in descriptions.items():
        word, digits = _text(description["type"]), description.get("digits", _USUAL_DIGITS)
        if type(digits) is not int or not 0 <= digits <= MOST_DIGITS:
            raise ValueError(f"{name}: digits")
        values = _values(columns[name], word)
        listed.append(Column(name, values, *_meaning(description), word, digits))
    return Table(tuple(listed), labels)


def _check_size(columns: int, rows: int) -> None:
    if columns > MOST_COLUMNS or columns * rows > MOST_CELLS:
        raise ValueError(f"{columns} columns of {rows} rows")


def _values(cells: Any, word: str) -> Any:
    """The values of an array, of a list of JSON, or of the cells of a CSV file: a tuple."""
    if isinstance(cells, list):
        return of_json(cells, word)
    if not isinstance(cells, np.ndarray):
        return values_of(cells, word)
    is_right = cells.dtype.str == DTYPES[word] if word in DTYPES else cells.dtype.kind == "U"
    if cells.ndim != 1 or not is_right:
        raise ValueError(f"an array of {cells.dtype} and {cells.ndim} dimensions, not {word[:40]}")
    return cells if word in DTYPES else values_of(cells.tolist(), word)


def _fact(name: str, content: Any, description: Mapping[str, Value]) -> Fact:
    if "columns" in description:
        table = _table(content, description["columns"], description["labels"])
        return Fact(name, table, *_meaning(description))
    word, value = _text(description["type"]), content
    if content is None or word == OBJECT:
        value = plain(content)
    else:
        is_list = isinstance(content, list)
        values = of_json(content if is_list else [content], word)
        listed = values.tolist() if word in DTYPES else [*values]
        value = listed if is_list else listed[0]
    return Fact(name, value, *_meaning(description), word)


def _meaning(description: Mapping[str, Value]) -> tuple[str, str]:
    return _text(description.get("meaning", "")), _text(description.get("unit", ""))


def _text(x: Value) -> str:
    if not isinstance(x, str):
        raise ValueError("no text")
    return x


# --- places ---------------------------------------------------------------------------------------
#
# Whether a result may take the place of a file: one rule for ``.save`` and ``-o``.


def check_place(path: Path, kind: str, inputs: Iterable[Path | None] = ()) -> None:
    """Refuse a path that a result of this kind cannot be written to, or must not; raises BadInput.

    A file is replaced where it is empty, or of the same kind of result as polhode wrote it.
    ``inputs``: files that are read.
    """
    places = [path, beside(path)] if path.suffix.lower() == ".csv" else [path]
    for place in places:
        check_writable(place, ENDINGS, inputs)
    refuse_facts(path)
    if path.suffix.lower() == ".parquet":
        needed("pyarrow", str(path))
    occupied = [str(place) for place in places if place.exists() and place.stat().st_size]
    if is_stream(path) or not occupied:
        return
    try:
        there = kind_at(path)
    except ValueError as fault:
        raise BadInput(occupied[0], "file", None, f"another name: {fault}") from None
    if there != kind:
        raise BadInput(occupied[0], "file", None, f"another name: it holds a result {there}")


def refuse_facts(path: Path) -> None:
    """Raise BadInput for the name of the facts of a CSV file, which are written with its table."""
    table = path.with_suffix("")
    if table.suffix.lower() == ".csv" and path.name == beside(table).name:
        expected = f"another name: this is of the facts of {table.name}"
        raise BadInput(str(path), "file", None, expected)
