"""Files that nobody's writer wrote: refused in one line, before much is made of them."""

import hashlib
import io
import json
import resource
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from invented import ENDINGS, Bare, Odd, content_at, facts_beside, written

import polhode

Document = dict[str, Any]


def saved_document() -> Document:
    """The JSON of a result."""
    saved: Document = json.loads(Odd().to_json())
    return saved


def fact(name: str, value: Any) -> Callable[[Document], None]:
    return lambda saved: saved.update({name: value})


def column(name: str, values: Any) -> Callable[[Document], None]:
    return lambda saved: saved["columns"].update({name: values})


def typed(name: str, word: Any) -> Callable[[Document], None]:
    return lambda saved: saved["about"]["columns"][name].update(type=word)


def about(**changes: Any) -> Callable[[Document], None]:
    return lambda saved: saved["about"]["facts"].update(changes)


CHANGES: dict[str, Callable[[Document], Any]] = {
    "another format": fact("format", "polhode result 3"),
    "no format": lambda saved: saved.pop("format"),
    "a kind of code": fact("result", "os.system"),
    "another kind": fact("result", "Section"),
    "a kind that is a list": fact("result", ["Odd"]),
    "title": fact("title", 7),
    "version": fact("version", None),
    "labels": fact("labels", 11),
    "labels below none": fact("labels", -1),
    "labels of a truth": fact("labels", True),
    "a digest": fact("sha256", "0" * 64),
    "no columns": fact("columns", {}),
    "columns in a list": fact("columns", []),
    "a column more": column("more", [1, 2, 3, 4]),
    "a column less": lambda saved: saved["columns"].pop("k"),
    "a short column": column("k", [0, 1, 2]),
    "a column that is none": column("k", 5),
    "a text for an integer": column("k", ["0", 1, 2, 3]),
    "a truth for an integer": column("k", [True, 1, 2, 3]),
    "a double for an integer": column("k", [0.5, 1, 2, 3]),
    "a gap for an integer": column("k", [None, 1, 2, 3]),
    "a long integer": column("k", [2**64, 1, 2, 3]),
    "an integer for a truth": column("ok", [1, True, True, True]),
    "a text for a double": column("x", ["5", 1, 2, 3]),
    "a truth for a double": column("x", [True, 1, 2, 3]),
    "a list for a double": column("x", [[1], 1, 2, 3]),
    "a double for an exact number": column("e", [0.5, None, None, None]),
    "no number": column("e", ["1/x", None, None, None]),
    "divided by zero": column("e", ["1/0", None, None, None]),
    "a large exponent": column("e", ["1e999999999", None, None, None]),
    "an exponent beyond the bound": column("e", ["1e20001", None, None, None]),
    "many digits": column("e", ["1" * 5_000_000, None, None, None]),
    "other digits": column("e", ["\u0663", None, None, None]),
    "an underscore": column("e", ["1_0", None, None, None]),
    "not a number": column("wide", ["nan", None, None, None]),
    "many bits": typed("wide", "1000000000 bits"),
    "no bits": typed("wide", "0 bits"),
    "more bits than may be": typed("wide", f"{(1 << 16) + 1} bits"),
    "no digits": typed("root", "0 digits"),
    "no word": typed("x", "float"),
    "a word that is a list": typed("x", ["double"]),
    "an object in a column": typed("x", "object"),
    "digits of a terminal": lambda saved: saved["about"]["columns"]["x"].update(digits=10**9),
    "a unit that is none": lambda saved: saved["about"]["columns"]["x"].update(unit=3),
    "a meaning that is none": lambda saved: saved["about"]["facts"]["count"].update(meaning=[]),
    "columns not described": lambda saved: saved["about"].update(columns=[]),
    "facts not described": lambda saved: saved["about"].update(facts=[]),
    "nothing described": lambda saved: saved.update(about=5),
    "a text for a fact": fact("count", "1"),
    "a number for a text": fact("texts", [1]),
    "a fact that is gone": lambda saved: saved.pop("count"),
    "a fact of a reserved name": about(columns={"type": "object"}),
    "a long list": about(**{f"fact {k}": {"type": "double"} for k in range(10_001)}),
    "a deep object": fact("provenance", json.loads("[" * 400 + "]" * 400)),
    "an object of four": fact("provenance", {"a": {"b": {"c": {"d": 1}}}}),
    "a large object": fact("provenance", {str(k): k for k in range(101)}),
    "a table that is none": fact("marks", [1]),
    "a table of two lengths": fact("marks", {"mark": [1], "h": [None, None]}),
    "the labels of a table": lambda saved: saved["about"]["facts"]["marks"].update(labels=3),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_json_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    saved = saved_document()
    path.write_text(json.dumps(saved))
    content_at(path)
    CHANGES[name](saved)
    path.write_text(json.dumps(saved))
    start = time.process_time()
    with pytest.raises(polhode.BadInput, match="a result that polhode saved") as refusal:
        content_at(path)
    assert "\n" not in str(refusal.value)
    assert time.process_time() - start < 1


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", "5", "[" * 100_000, '{"format": NaN}', "\ud800", '{"x": 1e', "null"]
)
@pytest.mark.parametrize("ending", ENDINGS)
def test_what_is_no_result_is_refused(text: str, ending: str, tmp_path: Path) -> None:
    if ending == ".parquet":
        pytest.importorskip("pyarrow")
    path = tmp_path / f"x{ending}"
    path.write_bytes(text.encode(errors="surrogatepass"))
    with pytest.raises(polhode.BadInput, match=r"a result that polhode saved|the facts of"):
        content_at(path)
    if ending == ".csv":
        facts_beside(path).write_bytes(text.encode(errors="surrogatepass"))
        with pytest.raises(polhode.BadInput, match="a result that polhode saved"):
            content_at(path)
    with pytest.raises(polhode.BadInput):
        content_at(tmp_path / f"not there{ending}")


def test_the_digest_of_a_table_is_asked(tmp_path: Path) -> None:
    """A digit that a spreadsheet cut is told; facts beside another table are none of it."""
    path = tmp_path / "x.csv"
    files = written(Odd().content(), path)
    path.write_bytes(files[path].replace(b"0.333", b"0.33"))
    with pytest.raises(polhode.BadInput, match="changed since polhode wrote it"):
        content_at(path)
    path.write_bytes(files[path])
    content_at(path)
    with pytest.raises(polhode.BadInput, match=r"these are the facts of x\.csv"):
        content_at(facts_beside(path))
    facts_beside(path).unlink()
    with pytest.raises(polhode.BadInput, match="the facts of x"):
        content_at(path)


@pytest.mark.parametrize("table", ["", "x" * 200_000 + "\n", "x,y\n0.5,0.25\na,b\n", "x,y\n1\n"])
def test_a_table_that_is_none_is_refused_though_its_digest_is_right(table, tmp_path: Path) -> None:
    """Made by hand: no header, or rows that are not those of columns."""
    path = tmp_path / "x.csv"
    facts = json.loads(written(Bare().content(), path)[facts_beside(path)])
    facts["about"]["columns"] = {name: {"type": "double"} for name in ("x", "y")}
    path.write_text(table)
    facts["sha256"] = hashlib.sha256(table.encode()).hexdigest()
    facts_beside(path).write_text(json.dumps(facts))
    with pytest.raises(polhode.BadInput, match="a result that polhode saved"):
        content_at(path)


def packed(saved: Any, **changes: Any) -> bytes:
    """An NPZ file with arrays changed."""
    with np.load(io.BytesIO(saved)) as file:
        arrays = {name: file[name] for name in file.files}
    out = io.BytesIO()
    np.savez(out, **{k: x for k, x in (arrays | changes).items() if x is not None})
    return out.getvalue()


ARRAYS: dict[str, Any] = {
    "bytes": np.array([b"0", b"1", b"2", b"3"]),
    "complex numbers": np.ones(4, dtype=complex),
    "small floats": np.ones(4, dtype=np.float32),
    "small integers": np.ones(4, dtype=np.int32),
    "swapped": np.ones(4, dtype=">f8"),
    "texts": np.array(["0", "1", "2", "3"]),
    "two dimensions": np.ones((4, 1)),
    "none": np.float64(4),
    "times": np.zeros(4, dtype="M8[s]"),
    "short": np.ones(3),
    "gone": None,
}


@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_of_other_types_are_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    data = written(Odd().content(), path)[path]
    path.write_bytes(packed(data))
    content_at(path)
    path.write_bytes(packed(data, x=ARRAYS[name]))
    with pytest.raises(polhode.BadInput, match="a result that polhode saved"):
        content_at(path)


@pytest.mark.parametrize("count", [2**28, 2**40])
def test_a_small_file_takes_little(count: int, tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({count},), }}".ljust(117) + "\n"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file,
        file.open("about.npy", "w", force_zip64=True) as out,
    ):
        out.write(b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode())
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(polhode.BadInput):
        content_at(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # kilobytes


@pytest.mark.parametrize("plain", [True, False])
def test_parquet_of_one_long_text_for_many_rows_is_refused(plain: bool, tmp_path: Path) -> None:
    """A dictionary makes a file of a megabyte stand for gigabytes."""
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "x.parquet"
    Bare().save(path)
    about = parquet.read_schema(path).metadata[b"polhode"].decode()
    which = pyarrow.array(np.zeros(10_000, dtype=np.int32))
    texts = pyarrow.DictionaryArray.from_arrays(which, pyarrow.array(["x" * 1_000_000]))
    table = pyarrow.table({"x": texts})
    with parquet.ParquetWriter(path, table.schema, store_schema=not plain) as out:
        out.write_table(table)
        out.add_key_value_metadata({"polhode": about})
    assert path.stat().st_size < 2_000_000
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    expected = "texts of too many characters" if plain else "columns of other types"
    with pytest.raises(polhode.BadInput, match=expected):
        content_at(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # kilobytes
