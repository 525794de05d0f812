"""The content of a result as files, by the ending of a name: one way for ``.save`` and ``-o``.

Nothing in a file depends on the time of day, the machine's name, a path or the command: the
same content gives the same bytes.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from polhode.common.errors import BadInput, nearest
from polhode.common.files import is_stream
from polhode.results.cells import (
    DOUBLE,
    EXACT,
    INTEGER,
    TRUTH,
    doubles,
    json_values,
    plain,
    texts,
    word_of,
)
from polhode.results.frames import needed
from polhode.results.table import Column, Content, Fact, Table, Value

if TYPE_CHECKING:
    import numpy.typing as npt

FORMAT = "polhode result 2"
ENDINGS = (".csv", ".json", ".npz", ".parquet")
ABOUT = "about"  # of an NPZ file: the array that is no column
METADATA = "polhode"  # the key of what a Parquet file's schema says
_USUAL_DIGITS = Column._field_defaults["digits"]
_TO_QUOTE = re.compile('[,"\r\n]')


def files(content: Content, path: Path) -> dict[Path, bytes]:
    """The files of a result at a path; raises BadInput for an ending that is none of ours."""
    if is_stream(path):
        return {path: csv_text(_exactly_timed(content.table)).encode()}
    suffix = path.suffix.lower()
    if suffix == ".csv":
        text = csv_text(content.table).encode()
        about = as_json(document(content, digest=digest(text)))
        return {path: text, beside(path): about.encode()}
    if suffix == ".json":
        return {path: as_json(document(content, columns=True)).encode()}
    if suffix == ".npz":
        return {path: _npz(content)}
    if suffix == ".parquet":
        return {path: _parquet(content)}
    expected = f"a name that ends in {nearest(suffix, [*ENDINGS])}"
    raise BadInput(str(path), "file", None, expected)


def beside(path: Path) -> Path:
    """The file of the facts of a CSV file."""
    return path.with_name(f"{path.name}.json")


def digest(data: bytes) -> str:
    """What tells that a table was changed."""
    return hashlib.sha256(data).hexdigest()


def document(
    content: Content, *, columns: bool = False, tables: bool = True, digest: str = ""
) -> dict[str, Value]:
    """A result as a JSON object: facts by name, words for all types, the columns where asked for.

    ``tables``: with those among the facts.  ``digest``: of the table in a file of its own.
    """
    table, facts = content.table, content.facts
    about = {
        "columns": {x.name: _about_column(x) for x in table.columns},
        "facts": {x.name: _about_fact(x) for x in facts},
    }
    return {
        "format": FORMAT,
        "result": content.kind,
        "version": content.version,
        **({"sha256": digest} if digest else {}),
        "title": content.title,
        "labels": table.labels,
        **{x.name: _fact(x) for x in facts if tables or not isinstance(x.value, Table)},
        "about": about,
        **({"columns": _columns(table)} if columns else {}),
    }


def _about_column(column: Column) -> dict[str, Value]:
    digits = {} if column.digits == _USUAL_DIGITS else {"digits": column.digits}
    return {"type": word_of(column)} | _unit_and_meaning(column) | digits


def _about_fact(fact: Fact) -> dict[str, Value]:
    if not isinstance(fact.value, Table):
        return {"type": word_of(fact)} | _unit_and_meaning(fact)
    columns = {x.name: _about_column(x) for x in fact.value.columns}
    return {"labels": fact.value.labels, "columns": columns} | _unit_and_meaning(fact)


def _unit_and_meaning(x: Column | Fact) -> dict[str, Value]:
    return {key: text for key, text in (("unit", x.unit), ("meaning", x.meaning)) if text}


def _fact(fact: Fact) -> Value:
    value = fact.value
    if isinstance(value, Table):
        return _columns(value)
    if isinstance(value, Mapping):
        return plain(value)
    if isinstance(value, (list, tuple)):
        return json_values(value, word_of(fact))
    return None if value is None else json_values([value], word_of(fact))[0]


def _columns(table: Table) -> dict[str, Value]:
    return {x.name: json_values(x.values, word_of(x)) for x in table.columns}


def as_json(value: Mapping[str, Value]) -> str:
    """JSON text: a line for each key, each column, and each column of a table among the facts."""
    return "{\n" + ",\n".join(_lines(value, " ")) + "\n}\n"


def _lines(value: Mapping[str, Value], indent: str) -> Iterator[str]:
    for key, part in value.items():
        if isinstance(part, Mapping) and part and key != "about":
            inner = ",\n".join(_lines(part, indent + " "))
            yield f"{indent}{json.dumps(key)}: {{\n{inner}\n{indent}}}"
        else:
            yield f"{indent}{json.dumps(key)}: {json.dumps(part, allow_nan=False)}"


def csv_text(table: Table) -> str:
    """A table as CSV: commas, a header, quotes where a text needs them; nothing where no number is.

    A row of one empty cell is quoted: an empty line would be no row.
    """
    columns = [_cells(x) for x in table.columns]
    if len(columns) == 1:
        columns = [[x or '""' for x in columns[0]]]
    header = ",".join(_quoted(x.name) for x in table.columns)
    return "\n".join([header, *map(",".join, zip(*columns, strict=True)), ""])


def _cells(column: Column) -> list[str]:
    word = word_of(column)
    cells = texts(column.values, word)
    return [_quoted(x) for x in cells] if word == "text" else cells


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if _TO_QUOTE.search(text) else text


def _exactly_timed(table: Table) -> Table:
    """A table for a stream, beside which no file tells types: times have every digit."""
    return table._replace(columns=[*map(_exact, table.columns)])


def _exact(column: Column) -> Column:
    if column.name != "t" or word_of(column) != DOUBLE:
        return column
    times = doubles(column.values)
    if not np.isfinite(times).all():
        return column
    return column._replace(values=list(map(Fraction, times.tolist())), type=EXACT)


def _npz(content: Content) -> bytes:
    """One array per column; of the tables among the facts by both names, with a dot between."""
    arrays = {x.name: array(x) for x in content.table.columns}
    for fact in content.facts:
        if isinstance(fact.value, Table):
            arrays |= {f"{fact.name}.{x.name}": array(x) for x in fact.value.columns}
    about = as_json(document(content, tables=False)).encode()
    arrays[ABOUT] = np.frombuffer(about, dtype=np.uint8)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as packed:
        for name, stored in arrays.items():
            part = zipfile.ZipInfo(f"{name}.npy")  # of a fixed date, where numpy tells today's
            part.compress_type = zipfile.ZIP_DEFLATED if stored.dtype.kind == "U" else 0
            with packed.open(part, "w", force_zip64=True) as file:
                np.lib.format.write_array(file, stored, allow_pickle=False)
    return out.getvalue()


def array(column: Column) -> npt.NDArray[np.generic]:
    """A column as an array of doubles, integers or truths, or else of texts."""
    word = word_of(column)
    if word == DOUBLE:
        return np.ascontiguousarray(doubles(column.values))
    if word in (INTEGER, TRUTH):
        return np.ascontiguousarray(column.values, np.int64 if word == INTEGER else np.bool_)
    return np.array(texts(column.values, word), dtype=np.str_)


def _parquet(content: Content) -> bytes:
    pyarrow, parquet = needed("pyarrow"), needed("pyarrow.parquet")
    arrays = {x.name: array(x) for x in content.table.columns}
    columns = {name: x.tolist() if x.dtype.kind == "U" else x for name, x in arrays.items()}
    types = [(name, _ARROW.get(x.dtype.kind, "string")) for name, x in arrays.items()]
    schema = pyarrow.schema(types, metadata={METADATA: as_json(document(content))})
    out = io.BytesIO()
    parquet.write_table(pyarrow.table(columns, schema=schema), out)
    return out.getvalue()


_ARROW = {"f": "float64", "i": "int64", "b": "bool"}
