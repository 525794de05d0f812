"""Files of results that somebody changed: refused in one line, before much is made of them.

Changes of any kind are made by hypothesis (tests/fuzz/changed_files.py); here are those by name.
"""

from __future__ import annotations

import json
import resource
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import polhode
from polhode.output.results import document, kinds
from polhode.results.result import Result
from shared.results import MAKERS, result_of_kind, watched

Arrays = dict[str, Any]


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Arrays:
    """The arrays of a run with events, angles and attitude."""
    path = tmp_path_factory.mktemp("run") / "run.npz"
    polhode.integrate(watched().at([0, 0.5, 1, 2])).save(path)
    with np.load(path) as file:
        return {name: file[name] for name in file.files}


def about(**changed: Any) -> Callable[[Arrays], Arrays]:
    """The JSON part with some values changed."""

    def change(arrays: Arrays) -> Arrays:
        told = json.loads(str(arrays["about"])) | changed
        return arrays | {"about": np.array(json.dumps(told))}

    return change


def put(name: str, array: Any) -> Callable[[Arrays], Arrays]:
    return lambda arrays: arrays | {name: np.array(array)}


def cut(name: str) -> Callable[[Arrays], Arrays]:
    return lambda arrays: arrays | {name: arrays[name][:-1]}


CHANGES = {
    "brackets": put("about", "[" * 100_000),
    "no object": put("about", "[1]"),
    "another format": about(format="polhode run 99"),
    "states empty": put("states", np.array([], dtype=np.str_)),
    "states short": cut("states"),
    "states flat": lambda arrays: arrays | {"states": arrays["states"].ravel()},
    "states undefined": put("states", np.full((4, 6), "")),
    "states as doubles": put("states", np.ones((4, 6))),
    "states not finite": put("states", np.full((4, 6), "inf")),
    "times empty": put("times", np.array([], dtype=np.str_)),
    "times short": cut("times"),
    "other times": put("times", ["0", "0.5", "1", "3"]),
    "times as numbers": put("times", [0.0, 0.5, 1.0, 2.0]),
    "angles short": cut("angles"),
    "attitude of three": lambda arrays: arrays | {"attitude": arrays["attitude"][:, 1:]},
    "errors of one": put("errors", [1e-16]),
    "event's states": cut("event0_states"),
    "event's grazing": put("event0_grazing", ["x"]),
    "event's signs": put("event0_signs", [7] * 6),
    "no events": about(events=[]),
    "steps": about(steps="many"),
    "negative steps": about(steps=-1),
    "truth for steps": about(steps=True),
    "bits": about(bits=10**9),
    "bits of a double": about(bits=54),
    "bits of no mp": about(number="mp"),
    "bits of mp": about(number="mp", bits=2**20),
    "digits of mp": about(number="mp", digits=10**9),
    "correct digits": about(number="mp", correct_digits=float("nan")),
    "number": about(number="half"),
    "tolerance": about(tolerance="nan"),
    "tolerance of mp": about(number="mp", tolerance="0x1p+999999999"),
    "method": about(method="guess"),
    "projection": about(projection={"onto": 3}),
    "provenance": about(provenance=[]),
    "reached": about(reached="1e999999999"),
    "reached of many digits": about(reached="9" * 100_000),
    "outcome": about(outcome="arrived"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_archive_is_refused_in_one_line(name: str, saved: Arrays, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    np.savez(path, **saved)
    polhode.load_run(path)
    np.savez(path, **CHANGES[name](saved))
    with pytest.raises(polhode.BadInput, match="a run that polhode saved") as refusal:
        polhode.load_run(path)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("content", [b"", b"PK nonsense", None])
def test_what_is_no_archive_is_refused(content: bytes | None, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(polhode.BadInput, match="a run that polhode saved"):
        polhode.load_run(path)


@pytest.mark.parametrize("text", ["", "[]", "{}", "5", '{"r": 0}', '"x"', '{"q": ["0x1", "0x0"]}'])
@pytest.mark.parametrize("inner", [False, True])
def test_a_document_that_is_none_is_refused(text: str, inner: bool, tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    path.write_text(json.dumps({"result": text}) if inner else text)
    with pytest.raises(polhode.BadInput, match="a result that polhode saved"):
        polhode.load_result(path)
    if path.read_text():
        with pytest.raises(polhode.BadInput, match="there is another"):
            result_of_kind("Orbit").save(path)


@pytest.mark.parametrize(
    ("name", "old", "new", "summed"),
    [
        ("Orbit", '"Closed"', '"Closer"', False),
        ("Orbit", document.FORMAT, "polhode document 1", False),
        ("Ensemble", '"start.omega[3]"', '"start.omega[9]"', True),
        ("Ensemble", '"start.omega[3]"', '"body.colour"', True),
        ("Ensemble", '["Rows", {"t": [', '["Rows", {"t": [[], ', True),
    ],
)
def test_a_changed_document_is_refused(name: str, old: str, new: str, summed: bool) -> None:
    """Its sum shows it, or where that is right again, what it says."""
    text = json.dumps(document.document(result_of_kind(name)))
    assert document.result_of(json.loads(text), "x") == result_of_kind(name)
    assert old in text
    told = json.loads(text.replace(old, new))
    if summed:
        told["sum"] = document.checksum(name, told["value"])
    with pytest.raises(polhode.BadInput, match="a result that polhode saved"):
        document.result_of(told, "x")


@pytest.mark.parametrize(
    ("word", "count", "size"),
    [
        ("<f8", 2**28, 0),  # less than it says
        ("<f8", 2**40, 0),
        ("<U500000000", 1, 0),
        ("<U1", 2**23, 2**25),  # millions of texts in thousands of bytes
        pytest.param("<f8", 2**27, 2**30, marks=pytest.mark.campaign),  # a gigabyte of zeros
    ],
)
def test_a_small_file_takes_little(word: str, count: int, size: int, tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    text = f"{{'descr': '{word}', 'fortran_order': False, 'shape': ({count},), }}".ljust(117) + "\n"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed,
        packed.open("times.npy", "w", force_zip64=True) as out,
    ):
        out.write(b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode())
        for _ in range(size >> 20):
            out.write(bytes(1 << 20))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for load in (polhode.load_run, polhode.load_result):
        with pytest.raises(polhode.BadInput):
            load(path)
    with pytest.raises(polhode.BadInput, match="arrays of numbers"):
        polhode.compare(path, "euler/sphere")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # kilobytes


def test_every_kind_of_result_is_among_those_of_a_document() -> None:
    def all_of(kind: type) -> list[type]:
        return [one for below in kind.__subclasses__() for one in (below, *all_of(below))]

    for name in MAKERS:  # all rooms are imported
        result_of_kind(name)
    special = {"Trajectory", "Reference", "Textbook", "Ended"}
    names = {one.__name__ for one in all_of(Result) if one.__module__.startswith("polhode")}
    assert names - special <= {*kinds.HOMES}
    for word in kinds.HOMES:
        assert kinds.fields_of(word)
