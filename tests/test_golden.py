"""The golden comparison notices what it is for: one bit, an entry that is gone, another refusal."""

import copy
import gzip
import json
import math

import numpy as np
import pytest

from measure import golden

RECORD = golden.text_of(
    {
        "double": {
            "a top": {"bits": 53, "states": np.array([[0.1, -2.5], [3.0, 1e-300]])},
            "no top": {"refused": ["BadInput", "x: expected y"]},
        },
        "keys": {"a file": {"bits": "int", "times": ["float"]}},
        "quad": {"a top": {"12": {"bits": 113, "states": [0.5], "outcome": "reached end"}}},
    }
)


def compared(tmp_path, capsys, change):
    """What ``diff`` returns and prints where the second file is changed so."""
    changed = copy.deepcopy(RECORD)
    change(changed)
    files = []
    for name, record in (("a", RECORD), ("b", changed)):
        files.append(tmp_path / f"{name}.json.gz")
        files[-1].write_bytes(gzip.compress(json.dumps(record).encode()))
    code = golden.main(["diff", *map(str, files)])
    return code, capsys.readouterr().out


def test_equal_records_are_equal(tmp_path, capsys):
    code, out = compared(tmp_path, capsys, lambda record: None)
    assert (code, out) == (0, "equal: 4 entries\n")


@pytest.mark.parametrize("value", [0.1, -2.5, 3.0, 1e-300])
def test_one_bit_is_one_ulp(tmp_path, capsys, value):
    def change(record):
        for row in record["double"]["a top"]["states"]:
            for k, text in enumerate(row):
                if text == golden.text_of(value):
                    row[k] = golden.text_of(math.nextafter(value, 10.0))

    code, out = compared(tmp_path, capsys, change)
    assert code == 1
    assert out.startswith("double: a top: 1 difference, up to 1 ulp: states[")
    assert out.endswith("not equal: 1 of 4 entries\n")


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (lambda r: r["double"].pop("a top"), "double: a top: 1 difference: missing in the second"),
        (lambda r: r.pop("quad"), "quad: a top: 1 difference: missing in the second"),
        (lambda r: r["quad"].update(new={}), "quad: new: 1 difference: missing in the first"),
        (lambda r: r["quad"]["a top"]["12"].pop("outcome"), "outcome: reached end and nothing"),
        (lambda r: r["double"]["a top"]["states"].pop(), "1 difference: states[1]: "),
        (
            lambda r: r["double"]["no top"]["refused"].__setitem__(1, "x: expected z"),
            "double: no top: 1 difference: refused[1]: x: expected y and x: expected z",
        ),
        (lambda r: r["double"].update({"no top": {"bits": "53"}}), "double: no top: 2 differences"),
        (lambda r: r["keys"]["a file"]["times"].pop(), "keys: a file: 1 difference: times[0]: "),
    ],
)
def test_what_is_missing_or_refused_otherwise(tmp_path, capsys, change, line):
    code, out = compared(tmp_path, capsys, change)
    assert code == 1
    assert line in out


def test_the_rows_hold_every_part_and_every_case():
    rows = golden.read(golden.ROWS)
    assert {*rows} == {*golden.PARTS, "made by"}
    for name, part in golden.PARTS.items():
        assert {key for key, _ in part()} == {*rows[name]}, name
    assert len(rows["closed forms"]) >= len(golden.CASES) + 12
