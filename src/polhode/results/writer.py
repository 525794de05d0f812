"""The content of a result as files, by the ending of a name: one way for ``.save`` and ``-o``.

And as tables of other packages: pandas DataFrames and xarray Datasets.

Nothing in a file depends on the time of day, the machine's name, a path or the command: the
same content gives the same bytes.
"""

from __future__ import annotations

import hashlib
import io
import math
import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.files import is_stream
from polhode.common.texts import as_json
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import Ball
from polhode.numbers.exact import Irrational
from polhode.results.cells import DOUBLE, DTYPES, EXACT, doubles, json_values, plain, texts, word_of
from polhode.results.table import Column, Content, Fact, Table, Value

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd
    import xarray as xr

FORMAT = "polhode result 2"
ENDINGS = (".csv", ".json", ".npz", ".parquet")
ABOUT = "about"  # of an NPZ file: the array that is no column
METADATA = "polhode"  # the key of what a Parquet file's schema says
_USUAL_DIGITS = Column._field_defaults["digits"]
_TO_QUOTE = re.compile('[,"\r\n]')


def files(content: Content, path: Path) -> dict[Path, bytes]:
    """The files of a result at a path, which has one of ``ENDINGS`` or is a stream."""
    if is_stream(path):
        return {path: csv_text(_exactly_timed(content.table)).encode()}
    suffix = path.suffix.lower()
    if suffix == ".csv":
        text = csv_text(content.table).encode()
        about = as_json(document(content, digest=digest(text)))
        return {path: text, beside(path): about.encode()}
    if suffix == ".json":
        return {path: as_json(document(content, columns=True)).encode()}
    return {path: _npz(content) if suffix == ".npz" else _parquet(content)}


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
        "columns": {x.name: _about(x) for x in table.columns},
        "facts": {x.name: _about(x) for x in facts},
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


def _about(x: Column | Fact) -> dict[str, Value]:
    """What a file says of a column or a fact beside its values."""
    about: dict[str, Value] = {}
    if isinstance(x, Fact) and isinstance(x.value, Table):
        columns = {column.name: _about(column) for column in x.value.columns}
        about |= {"labels": x.value.labels, "columns": columns}
    else:
        about["type"] = word_of(x)
    about |= {key: text for key, text in (("unit", x.unit), ("meaning", x.meaning)) if text}
    if isinstance(x, Column) and x.digits != _USUAL_DIGITS:
        about["digits"] = x.digits
    return about


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
    columns = [*table.columns]
    for k, column in enumerate(columns):
        if column.name == "t" and word_of(column) == DOUBLE:
            times = doubles(column.values)
            if np.isfinite(times).all():
                columns[k] = column._replace(values=[*map(Fraction, times.tolist())], type=EXACT)
    return table._replace(columns=columns)


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
    if word in DTYPES:
        values = doubles(column.values) if word == DOUBLE else column.values
        return np.ascontiguousarray(values, DTYPES[word])
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


# --- packages -------------------------------------------------------------------------------------
#
# Packages that not everybody has.


def needed(package: str, source: str = "tables") -> ModuleType:
    """A package by its name; raises BadInput, for ``source``, where it is missing."""
    try:
        return import_module(package)
    except ImportError:
        name = package.partition(".")[0]
        expected = f"it to be installed: pip install {name}"
        if name in ("pandas", "xarray"):
            expected = "it to be installed: pip install 'polhode[frames]'"
        raise BadInput(source, name, None, expected) from None


# --- frames ---------------------------------------------------------------------------------------


def to_pandas(content: Content) -> pd.DataFrame:
    """A DataFrame whose index are the labels; exact numbers are doubles there.

    ``attrs`` has the facts that are no tables.
    """
    pandas = needed("pandas")
    table = content.table
    frame = pandas.DataFrame({x.name: _frame_values(x) for x in table.columns})
    if table.labels:
        frame = frame.set_index([x.name for x in table.columns[: table.labels]])
    frame.attrs = {x.name: x.value for x in content.facts if not isinstance(x.value, Table)}
    return frame


def to_xarray(content: Content) -> xr.Dataset:
    """A Dataset along the labels."""
    needed("xarray")
    frame = to_pandas(content)
    dataset: xr.Dataset = frame.to_xarray()
    return dataset.assign_attrs(frame.attrs)


def _frame_values(column: Column) -> Any:
    if word_of(column) == DOUBLE:
        return doubles(column.values)
    values = column.values
    if any(isinstance(x, (Fraction, Irrational)) for x in values):
        return np.array([np.nan if x is None else to_double(x) for x in values])
    return values if isinstance(values, np.ndarray) else list(values)


# --- ball columns ---------------------------------------------------------------------------------
#
# Balls as two columns or facts: a decimal, and the radius of a ball around it that holds them.


def written_table(table: Table) -> Table:
    """A table with two columns for each of balls: the radii come after all others."""
    columns, radii = [], []
    for column in table.columns:
        values = column.values
        if not isinstance(values, (list, tuple)) or Ball not in map(type, values):
            columns.append(column)
            continue
        middles, bounds = zip(*map(_decimals, values), strict=True)
        columns.append(column._replace(values=[*middles], type=EXACT))
        name = f"{column.name}_radius"
        radii.append(Column(name, [*bounds], "proven bound", column.unit, DOUBLE, digits=0))
    return Table([*columns, *radii], table.labels)


def written_facts(facts: Sequence[Fact]) -> Iterator[Fact]:
    """Facts with two for each ball, and for each list of balls."""
    for fact in facts:
        value = fact.value
        if isinstance(value, Table):
            yield fact._replace(value=written_table(value))
        elif isinstance(value, Ball):
            centre, radius = _decimals(value)
            yield fact._replace(value=centre, type=EXACT)
            yield Fact(f"{fact.name}_radius", radius, "proven bound", fact.unit, DOUBLE)
        else:
            yield fact


def _decimals(ball: Ball | None) -> tuple[Fraction | None, float | None]:
    """The midpoint that is written, and a radius around that very number."""
    if ball is None:
        return None, None
    if not math.isfinite(ball.radius):
        return Fraction(round(ball.centre)), math.inf
    middle, radius = ball.decimals
    return Fraction(middle), float(radius)
