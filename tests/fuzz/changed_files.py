"""Files of polhode's own that somebody changed, as strategies: results and runs."""

from __future__ import annotations

import copy
import functools
import io
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

import polhode
from fuzz import values
from fuzz.cases import Case, mangled, of, several
from polhode.results.writer import beside
from polhode.runs.saved import Saved
from shared.results import CERTIFIED, result_of_kind

Arrays = dict[str, np.ndarray]


def archived(arrays: Arrays) -> bytes:
    """The bytes of an NPZ file."""
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def unpacked(text: bytes) -> Arrays:
    """The arrays of an NPZ file."""
    with np.load(io.BytesIO(text), allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


@functools.cache
def saved(name: str, suffix: str) -> bytes:
    """The file in which a result of that kind is saved: of a CSV, the one beside it."""
    with tempfile.TemporaryDirectory() as folder:
        result_of_kind(name).save(path := Path(folder) / f"x{suffix}")
        return (beside(path) if suffix == ".csv" else path).read_bytes()


def places(value: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The path of each part of a JSON value."""
    keys = (
        value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    )
    return [at, *(place for key in keys for place in places(value[key], (*at, key)))]


@st.composite
def altered(draw: st.DrawFn, value: Any) -> Any:
    """A JSON value with one part changed, left out, or another one in its place."""
    document = {"": copy.deepcopy(value)}
    at, second = (("", *draw(of(places(value)))) for _ in range(2))
    parent = functools.reduce(lambda part, key: part[key], at[:-1], document)
    turn = draw(st.integers(0, 9))
    if turn < 7:
        parent[at[-1]] = copy.deepcopy(draw(of(values.JSON)))
    elif turn < 8 and len(at) > 1:
        del parent[at[-1]]
    else:
        part = functools.reduce(lambda part, key: part[key], second, document)
        parent[at[-1]] = copy.deepcopy(part)
    return document[""]


def use_result(name: str) -> None:
    """A result that can be loaded is a run or what it told, and answers."""
    result = polhode.load_result(name)
    assert isinstance(result, (polhode.Trajectory, Saved))
    assert repr(result)
    assert result == result
    if isinstance(result, polhode.Trajectory):
        _ = result.drift, result.expected, result.state_strings(), result.time_strings()
        result("0.25")
    else:
        assert result.to_json()


@st.composite
def arrays_changed(draw: st.DrawFn, text: bytes) -> bytes:
    """An NPZ file with arrays changed, or left out, or the JSON in it, or a cell."""
    arrays = unpacked(text)
    about = json.loads(bytes(arrays["about"])) if "about" in arrays else None
    for _ in draw(several(2)):
        name, turn = draw(of(arrays)), draw(st.integers(0, 9))
        if turn < 4 and about is not None:
            text = json.dumps(draw(altered(about))).encode()
            arrays["about"] = np.frombuffer(text, dtype=np.uint8)
        elif turn < 6:
            arrays[name] = draw(of(values.arrays(arrays[name])))
        elif turn < 7 and len(arrays) > 1:
            del arrays[name]
        elif arrays[name].size:
            cells = arrays[name].ravel().astype(object)
            cells[draw(st.integers(0, cells.size - 1))] = draw(of(values.CELLS))
            arrays[name] = np.array(cells.astype(str)).reshape(arrays[name].shape)
    return archived(arrays)


@st.composite
def result(draw: st.DrawFn, names: Sequence[str]) -> Case:
    """A saved result: a value of its JSON changed, arrays, or some bytes."""
    name, turn = draw(of(names)), draw(st.integers(0, 2))
    suffix = ".npz"
    if turn == 0:
        document = draw(altered(json.loads(result_of_kind(name).to_json())))
        text, suffix = json.dumps(document).encode(), ".json"
    elif turn == 1:
        text = draw(arrays_changed(saved(name, suffix)))
    else:
        suffix = draw(of((".csv", ".npz", ".json")[: 2 + (name not in CERTIFIED)]))
        text = draw(mangled(saved(name, suffix)))
    beside_it = {"x.csv": b"t\n0\n"} if suffix == ".csv" else {}
    files = {f"x{suffix}".replace(".csv", ".csv.json"): text} | beside_it
    return Case(name, files, lambda: use_result(f"x{suffix}"))
