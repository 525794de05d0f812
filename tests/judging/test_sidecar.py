"""The JSON beside a CSV is somebody's file: it is checked, and never changes a verdict silently."""

from __future__ import annotations

import json
import os

import pytest

import polhode
from polhode import cli

SCENE = "lagrange/nutation"


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """A run's file alone, and what it is judged to be."""
    path = tmp_path_factory.mktemp("plain") / "x.csv"
    assert cli.main(["run", SCENE, "--at", "0.1,0.7,2.3,3.3", "-o", str(path)]) == 0
    beside = path.with_suffix(".json")
    known = json.loads(beside.read_text())
    with_it = polhode.compare(path, SCENE)
    beside.unlink()
    return path.read_text(), known, with_it, polhode.compare(path, SCENE)


def judged(tmp_path, plain):
    path = tmp_path / "x.csv"
    path.write_text(plain[0])
    return polhode.compare(path, SCENE)


def nested(depth: int) -> str:
    return '{"t_bits": ' + "[" * depth + "]" * depth + "}"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (nested(50_000), "it does not describe the file's numbers"),
        ("[" * 50_000, "it does not describe the file's numbers"),
        ('{"t_bits": 53, "number": "mp", "bits": ' + "9" * 18 + "}", "bits = 999999999999999999"),
        ('{"t_bits": ' + "9" * 9 + "}", "t_bits = 999999999, no number type"),
        ('{"t_bits": 2, "number": "double", "bits": 53}', "t_bits = 2, no number type"),
        ('{"t_bits": 64, "number": "mp", "bits": 64}', "was ignored: mp has 21 digits"),
        ('{"t_bits": 24, "number": "double", "bits": 24}', "x.json was ignored: number"),
        ('{"t_bits": true, "number": "double", "bits": true}', "bits = True, t_bits = True"),
        ('{"number": ["double"], "bits": {}}', "x.json was ignored: number = ['double']"),
        ('{"projection": {"count": 1, "onto": null}}', "x.json was ignored: number = None"),
        ("no JSON", "it does not describe the file's numbers"),
        ("3", "it does not describe the file's numbers"),
        ('{"t_bits": 53' + "0" * 5000 + "}", "it does not describe the file's numbers"),
    ],
)
def test_what_does_not_fit_is_not_believed_and_told(tmp_path, plain, text, told):
    (tmp_path / "x.json").write_text(text)
    found = judged(tmp_path, plain)
    assert found.digits == plain[3].digits
    assert found.limit == plain[3].limit
    assert [one for one in found.subject.remarks if told in one]
    assert told in str(found)


def test_what_fits_is_told_too(tmp_path, plain):
    (tmp_path / "x.json").write_text(json.dumps(plain[1]))
    found = judged(tmp_path, plain)
    assert found.digits == plain[2].digits
    assert found.subject.remarks == ("x.json: numbers and t are of double (53 bits)",)
    assert "x.json: numbers and t are of double (53 bits)" in str(found)
    assert plain[3].subject.remarks == ()


BITS = '{"t_bits": 53, "number": "double", "bits": 53, "projection": %s}'


@pytest.mark.parametrize("projection", ['{"count": 1, "onto": null}', '"h"', '{"count": "1"}'])
def test_a_projection_that_is_none_is_not_believed(tmp_path, plain, projection):
    (tmp_path / "x.json").write_text(BITS % projection)
    found = judged(tmp_path, plain)
    assert found.digits == plain[3].digits
    assert found.drift is not None
    (remark,) = found.subject.remarks
    assert remark.startswith("x.json was ignored: projection = ")


def test_bits_that_the_times_do_not_have_are_not_believed(tmp_path, plain):
    """A time of more digits than a double tells is none."""
    text = plain[0].replace("\n0.1,", "\n0.1000000000000000000001,")
    (tmp_path / "x.csv").write_text(text)
    (tmp_path / "x.json").write_text(json.dumps(plain[1]))
    found = polhode.compare(tmp_path / "x.csv", SCENE)
    assert "x.json was ignored: double does not print t as 0.1000000000000000000001" in str(found)
    assert float(found.times[0]) == 0.1
    assert found.times[0].denominator > 2**60


@pytest.mark.parametrize(
    "make", [os.mkfifo, lambda place: place.symlink_to("/dev/zero"), lambda place: place.mkdir()]
)
def test_what_is_no_file_is_not_waited_for(tmp_path, plain, make):
    make(tmp_path / "x.json")
    found = judged(tmp_path, plain)
    assert found.digits == plain[3].digits
    assert [one for one in found.subject.remarks if "not read" in one]


def test_a_long_file_is_read_too_and_half_a_file_is_not(tmp_path, plain):
    """As of a run of very many times."""
    long = plain[1] | {"digits_left": [15.0] * (1 << 20)}
    (tmp_path / "x.json").write_text(json.dumps(long))
    found = judged(tmp_path, plain)
    assert found.subject.number.name == "double"
    assert found.digits == plain[2].digits
    (tmp_path / "x.json").write_text(json.dumps(plain[1])[:-1])
    assert "it does not describe the file's numbers" in str(judged(tmp_path, plain))
