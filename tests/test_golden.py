"""The golden comparison notices what it is for: one bit, an entry that is gone, another refusal."""

import copy
import gzip
import json
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from measure import golden

with mpmath.workprec(113):
    THIRD = mpmath.mpf(1) / 3

RECORD = golden.text_of(
    {
        "double": {
            "a top": {"bits": 53, "states": np.array([[0.1, -2.5], [3.0, 1e-300]])},
            "no top": {"refused": ["BadInput", "x: expected y"]},
        },
        "keys": {"a file": {"bits": "int", "times": ["float"]}},
        "quad": {"a top": {"12": {"bits": 113, "states": [THIRD], "outcome": "reached end"}}},
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


def test_ulps_are_those_of_the_nearest_number_type(tmp_path, capsys):
    def change(record):
        states = record["quad"]["a top"]["12"]["states"]
        states[0] = golden.text_of(golden.number_of(states[0]) + Fraction(2, 2**114))

    code, out = compared(tmp_path, capsys, change)
    assert code == 1
    assert "quad: a top: 1 difference, up to 2 ulp: 12.states[0]: " in out


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


def test_numbers_are_written_with_all_their_bits():
    long = np.nextafter(np.longdouble(1), np.longdouble(2))
    assert golden.text_of(np.array([long])) == [f"0x{2**63 + 1:x}p-63"]
    with mpmath.workprec(300):
        near = golden.text_of(1 + mpmath.mpf(2) ** -250)
    assert golden.number_of(near) == 1 + Fraction(1, 2**250)
    for value in (0.1, -1.0, 5e-324, np.float64(1e308)):
        assert golden.number_of(golden.text_of(value)) == Fraction(float(value))
    assert golden.text_of([0.0, -0.0, math.inf, math.nan, Fraction(2, 3), True, 7]) == (
        ["0x0p+0", "-0x0p+0", "inf", "nan", "2/3", True, "7"]
    )


def test_a_refusal_is_recorded_by_class_and_message():
    message = "euler/sphere: number = long: expected double, extended, quad, mp"
    refusal = golden.answer(lambda: polhode.integrate("euler/sphere", "long"))
    assert refusal == {"refused": ["BadInput", message]}


def test_the_rows_hold_every_part_and_every_case():
    rows = golden.read(golden.ROWS)
    assert {*rows} == {*golden.PARTS, "made by"}
    for name, part in golden.PARTS.items():
        assert {key for key, _ in part()} == {*rows[name]}, name
    assert len(rows["closed forms"]) >= len(golden.CASES) + 12


def test_an_entry_of_the_rows_is_what_it_is_now():
    """Of a kind that every processor rounds alike; the others by hand: golden.py check."""
    rows = golden.read(golden.ROWS)
    entries = dict(golden.PARTS["closed forms"]())
    assert golden.answer(entries["euler/sphere"]) == rows["closed forms"]["euler/sphere"]
