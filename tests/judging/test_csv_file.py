"""A file is judged at a few rows before all are read, and what is wrong with it is told first."""

from __future__ import annotations

import json
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.common.errors import BadInput
from polhode.judging.tables import csv_file

COLUMNS = ("p", "q", "r", "gamma1", "gamma2", "gamma3")


def rows_of(count):
    """A scene, and rows of its state: doubles, each off by about 1e-13."""
    scene = polhode.load("euler/attitude").at([Fraction(k, 4) for k in range(count)])
    table = np.array(polhode.reference(scene).at(scene.times, 17), dtype=float).T
    noise = np.random.default_rng(7).uniform(-1e-13, 1e-13, table.shape)
    return scene, (table + noise).T


def written(path, count, spoiled=None, head=()):
    """A file of so many rows; ``spoiled``: a row of which a cell is no number."""
    scene, rows = rows_of(count)
    cells = [
        [str(float(t)), *map(repr, row.tolist())] for t, row in zip(scene.times, rows, strict=True)
    ]
    if spoiled is not None:
        cells[spoiled][2] = "x"
    path.write_text("\n".join([*head, "t," + ",".join(COLUMNS), *map(",".join, cells)]) + "\n")
    return scene


@pytest.mark.parametrize("spoiled", [None, 5, 0, 1199])
def test_the_first_answer_comes_before_the_rows_are_read(tmp_path, monkeypatch, spoiled):
    path, told = tmp_path / "x.csv", []
    scene = written(path, 1200, spoiled, ["# a comment", "", ",,"])
    read = []
    plain = csv_file.values

    def values(cells, number):
        read.append(len(cells))
        return plain(cells, number)

    def first(some, count):
        told.append((len(some.times), count, some.times[0], some.times[-1], some.worst > 12))

    monkeypatch.setattr(csv_file, "values", values)

    def judged():
        return polhode.compare(path, scene, first=lambda *x: (first(*x), read.append("told")))

    if spoiled is None:
        assert judged().worst > 12
    else:
        with pytest.raises(BadInput, match=rf"x\.csv:{spoiled + 5}: q = x"):
            judged()
    before, _, after = "".join(map(str, read)).partition("told")
    if spoiled in (None, 5):  # no row of the first eleven is spoiled
        assert told == [(11, 1200, scene.times[0], scene.times[-1], True)]
        assert before.replace("11", "") == ""
        assert after.replace("1200", "") == ""
    else:
        assert told == []


def test_bytes_that_are_no_text_are_refused(tmp_path):
    path = tmp_path / "x.csv"
    path.write_bytes(b"t,p\n0,\xff\n")
    with pytest.raises(BadInput, match=r"file: expected a readable CSV file \(not a CSV text\)"):
        polhode.compare(path, "euler/attitude")


@pytest.mark.slow
def test_a_first_answer_of_a_few_rows(tmp_path):
    scene, told = written(tmp_path / "x.csv", 1200), []
    found = polhode.compare(
        tmp_path / "x.csv", scene, first=lambda some, count: told.append((some, count))
    )
    ((some, count),) = told
    assert (len(some.times), count) == (11, 1200)
    assert found.worst <= some.worst < found.worst + 2
    assert "drift h" in str(found)


def test_a_first_answer_that_cannot_be_given_hides_no_fault(tmp_path):
    """As of times beyond what a reference can tell: the file is read first."""
    scene = written(tmp_path / "x.csv", 1200, 5)

    def first(some, count):
        raise BadInput("reference", "t", None, "a nearer time")

    with pytest.raises(BadInput, match=r"x\.csv:7: q = x"):
        polhode.compare(tmp_path / "x.csv", scene, first=first)
    written(tmp_path / "x.csv", 1200)
    with pytest.raises(BadInput, match="a nearer time"):
        polhode.compare(tmp_path / "x.csv", scene, first=first)


@pytest.mark.parametrize("count", [1000, 1001])
def test_the_first_answer_where_lines_are_no_rows(tmp_path, count):
    """A cell of an ignored column is in quotation marks, over two lines."""
    path, told = tmp_path / "x.csv", []
    scene = written(path, count)
    lines = path.read_text().splitlines()
    lines = [f'{line},"a\nb"' if k == 333 else f"{line},c" for k, line in enumerate(lines)]
    path.write_text("\n".join(lines) + "\n")
    found = polhode.compare(path, scene, first=lambda some, count: told.append(count))
    assert told == ([count] if count > 1000 else [])
    assert found.worst > 12


@pytest.mark.slow
def test_a_table_from_the_standard_input():
    command = [sys.executable, "-m", "polhode", "compare", "-", "lagrange/nutation", "--json"]
    text = "t,p,q,r\n0,0.16,0.3,4.1\n"
    told = subprocess.run(command, input=text, capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    assert json.loads(told.stdout)["file"] == "standard input"
    for text, fault in (
        ("t,p\n0,x\n", ":2: p = x: expected a finite"),
        ("", ": file: expected a header"),
    ):
        told = subprocess.run(command, input=text, capture_output=True, text=True)
        assert told.returncode == 2
        assert f"polhode: standard input{fault}" in told.stderr
