"""Files of results that somebody changed: refused in one line, before much is made of them."""

from __future__ import annotations

import copy
import json
import random
import resource
import zipfile
from functools import partial

import numpy as np
import pytest
from test_results import MAKERS, made

import polhode
from polhode.common.result import Result
from polhode.output.results import document, kinds

#: What may stand anywhere in a document, and should do no harm.
HOSTILE = (
    None,
    True,
    "x",
    -1,
    10**30,
    0.5,
    [],
    {},
    [[]],
    {"r": 0},
    {"r": -1},
    {"r": 10**9},
    {"q": ["0x1", "0x0"]},
    {"q": ["0x1", "0x" + "f" * 100_000]},
    {"i": "0x" + "f" * 1_000_000},
    {"f": "nan"},
    {"f": "inf"},
    {"m": ["0x1", 10**12]},
    {"m": ["0x" + "f" * 1_000_000, 0]},
    {"s": ["<U500000000", [], ["x"]]},
    {"a": ["<f8", [10**9], ""]},
    {"a": ["<f8", [2**31, 2**31, 4], ""]},
    {"a": ["|V2000000000", [1], ["x"]]},
    {"a": ["|O", [1], [None]]},
    {"n": ["Spaced", 0, 1, 10**9]},
    {"n": ["EvenTimes", {"q": ["0x1", "0x1"]}, 10**9]},
    {"n": ["EvenTimes", "x", 2]},
    {"n": ["Scene", "euler/sphere"]},
    {"n": ["NumberType", "mp", 2**30]},
    {"n": ["os:system", "true"]},
    {"n": ["__import__", "os"]},
    {"o": ["polhode.scenes.library:load", "/etc/passwd"]},
    {"g": "polhode.common.files:write_whole"},
    {"x": ["integer_power_of", [{"q": ["0x1", "0x1"]}], None]},
    {"x": ["__builtins__", [], None]},
    {"reference": "euler/sphere"},
    {"reference": "/etc/passwd"},
    {"run": []},
    {"__class__": []},
    {"read": "x"},
    {"kept": 0},
    {"e": "arrived"},
    {"d": [[[], 1]]},
    {"t": 5},
)


def places(value, at=()):
    """The path of each part of a JSON value."""
    yield at
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from places(value[key], (*at, key))


def changed(told, chance):
    """A document with a value changed, left out or moved, and the sum that belongs to it."""
    told = copy.deepcopy(told)
    at, other = chance.choices([*places(told["value"])], k=2)
    parent, last = told, "value"
    for key in at:
        parent, last = parent[last], key
    turn = chance.random()
    if turn < 0.7:
        parent[last] = copy.deepcopy(chance.choice(HOSTILE))
    elif turn < 0.8 and at:
        del parent[last]
    else:
        found = told["value"]
        for key in other:
            found = found[key]
        parent[last] = copy.deepcopy(found)
    told["sum"] = document.checksum(told["kind"], told["value"])
    return told


def check(load, kind):
    """Whether a file was loaded; else it was refused in one line."""
    try:
        found = load()
    except polhode.BadInput as refusal:
        line = str(refusal)
        assert "\n" not in line
        assert len(line) < 1000
        return False
    assert type(found) is kind
    assert repr(found)
    assert found == found
    return True


SMALL = [name for name in MAKERS if not name.startswith(("Trajectory", "Levels"))]


@pytest.mark.parametrize("name", ["Ensemble", "Orbit", "Judgement"])
def test_a_changed_document_is_refused_or_a_result_of_its_kind(name):
    _changed_documents(name, 60)


@pytest.mark.slow
@pytest.mark.parametrize("name", SMALL)
def test_2000_changed_documents(name):
    loaded = _changed_documents(name, 2000 // len(SMALL) + 1)
    assert loaded < 100  # most changes are noticed


def _changed_documents(name, count):
    chance = random.Random(name)
    told = document.document(made(name))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    loaded = 0
    for _ in range(count):
        load = partial(document.result_of, changed(told, chance), "x.json")
        loaded += check(load, type(made(name)))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 400_000  # kilobytes
    return loaded


@pytest.mark.sample(6)
@pytest.mark.parametrize("suffix", [".csv", ".json", ".npz"])
@pytest.mark.parametrize("name", MAKERS)
def test_changed_bytes_are_refused_or_a_result_of_its_kind(name, suffix, tmp_path):
    if (name, suffix) in (("Enclosure", ".json"), ("ProvedOrbit", ".json")):
        pytest.skip("that is its certificate")
    made(name).save(tmp_path / f"x{suffix}")
    path = tmp_path / ("x.json" if suffix == ".csv" else f"x{suffix}")
    whole, chance = path.read_bytes(), random.Random(name)
    for _ in range(12):
        data = bytearray(whole)
        for _ in range(chance.choice((1, 3))):
            data[chance.randrange(len(data))] = chance.randrange(256)
        path.write_bytes(data[: len(data) - chance.choice((0, 0, 0, 5, len(data) // 2))])
        check(lambda: polhode.load_result(tmp_path / f"x{suffix}"), type(made(name)))


@pytest.mark.parametrize("text", ["", "[]", "{}", "5", '{"r": 0}', '"x"', '{"q": ["0x1", "0x0"]}'])
@pytest.mark.parametrize("inner", [False, True])
def test_a_document_that_is_none_is_refused(text, inner, tmp_path):
    path = tmp_path / "x.json"
    path.write_text(json.dumps({"result": text}) if inner else text)
    with pytest.raises(polhode.BadInput, match="a result that polhode saved"):
        polhode.load_result(path)
    if path.read_text():
        with pytest.raises(polhode.BadInput, match="there is another"):
            made("Orbit").save(path)


def test_members_are_rows_of_the_scene():
    told = document.document(made("Ensemble"))
    text = json.dumps(told["value"])
    for old, new in (
        ('"start.omega[3]"', '"start.omega[9]"'),
        ('"start.omega[3]"', '"body.colour"'),
        ('["Rows", {"t": [', '["Rows", {"t": [[], '),
    ):
        assert old in text
        value = json.loads(text.replace(old, new))
        given = told | {"value": value, "sum": document.checksum("Ensemble", value)}
        with pytest.raises(polhode.BadInput, match="a result that polhode saved"):
            document.result_of(given, "x")


@pytest.mark.parametrize(
    ("word", "count", "size"),
    [
        ("<f8", 2**28, 0),  # less than it says
        ("<f8", 2**40, 0),
        ("<U500000000", 1, 0),
        ("<U1", 2**23, 2**25),  # millions of texts in thousands of bytes
        pytest.param("<f8", 2**27, 2**30, marks=pytest.mark.slow),  # zeros, a gigabyte of them
    ],
)
def test_a_small_file_takes_little(word, count, size, tmp_path):
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


@pytest.mark.parametrize("digits", [50, 350])
def test_a_run_of_many_digits_loads(digits, tmp_path):
    """More digits than a number of a scene file may have, and a tolerance below all doubles."""
    run = polhode.integrate("euler/sphere", at=["1e-3000"], digits=digits)
    run.save(tmp_path / "x.npz")
    assert len(run.time_strings()[0]) > 5000
    assert polhode.load_run(tmp_path / "x.npz") == run


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("correct_digits", float("nan")),
        ("correct_digits", float("inf")),
        ("bits", 2**20),
        ("steps", -1),
        ("digits", 10**9),
        ("tolerance", "0x1p+999999999"),
        ("reached", "1e99999999"),
        ("reached", "9" * 100_000),
    ],
)
def test_values_that_no_run_has_are_refused(key, value, tmp_path):
    path = tmp_path / "x.npz"
    made("Trajectory in quad").save(path)
    with np.load(path) as file:
        held = {name: file[name] for name in file.files}
    about = json.loads(str(held["about"])) | {key: value, "number": "mp"}
    np.savez(path, **held | {"about": np.array(json.dumps(about))})
    with pytest.raises(polhode.BadInput, match="a run that polhode saved"):
        polhode.load_run(path)


def test_every_kind_of_result_is_among_those_of_a_document():
    def all_of(kind):
        for one in kind.__subclasses__():
            yield one
            yield from all_of(one)

    for name in MAKERS:  # all rooms are imported
        made(name)
    special = {"Trajectory", "Reference", "Ended"}
    names = {one.__name__ for one in all_of(Result) if one.__module__.startswith("polhode")}
    assert names - special <= {*kinds.HOMES}
    for word in kinds.HOMES:
        assert kinds.fields_of(word)
