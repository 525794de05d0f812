"""The golden comparison notices what it is for: one bit, an entry that is gone, another refusal."""

from __future__ import annotations

import copy
import json
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from measure import golden  # puts its folder on the path, where its other files lie

import golden_parts  # isort: skip
import golden_record  # isort: skip

RECORD = golden_record.told(
    {
        "double": {
            "a top": {"bits": 53, "states": np.array([[0.1, -2.5], [3.0, 1e-300]])},
            "no top": {"refused": ["BadInput", "x: expected y"]},
        },
        "quad": {"a top": {"bits": 113, "states": [mpmath.mpf(1) / 3], "outcome": "reached end"}},
    }
)


def compared(tmp_path, capsys, change):
    """What ``diff`` returns and prints where the second file is changed so."""
    other = copy.deepcopy(RECORD)
    change(other)
    for name, record in (("a.json", RECORD), ("b.json", other)):
        (tmp_path / name).write_text(json.dumps(record, sort_keys=True))
    code = golden.main(["diff", str(tmp_path / "a.json"), str(tmp_path / "b.json")])
    return code, capsys.readouterr().out


def test_equal_records_are_equal(tmp_path, capsys):
    code, out = compared(tmp_path, capsys, lambda record: None)
    assert (code, out) == (0, "equal: 3 entries in 2 parts\n")


@pytest.mark.parametrize("value", [0.1, -2.5, 3.0, 1e-300])
def test_one_bit_is_one_ulp(tmp_path, capsys, value):
    def change(record):
        states = record["double"]["a top"]["states"]
        for row in states:
            for k, text in enumerate(row):
                if text == golden_record.number(value):
                    row[k] = golden_record.number(math.nextafter(value, 10.0))

    code, out = compared(tmp_path, capsys, change)
    assert code == 1
    assert out.startswith("double: a top: 1 difference, up to 1 ulp: states[")
    assert out.endswith("not equal: 1 of 3 entries\n")


def test_ulps_are_those_of_the_entry_s_number_type(tmp_path, capsys):
    def change(record):
        with mpmath.workprec(200):
            third = golden_record.read(RECORD["quad"]["a top"]["states"][0])
            other = mpmath.mpf(third.numerator) / third.denominator + mpmath.mpf(2) ** -113
        record["quad"]["a top"]["states"][0] = golden_record.number(other)

    code, out = compared(tmp_path, capsys, change)
    assert code == 1
    assert "quad: a top: 1 difference, up to 2 ulp: states[0]: " in out


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda r: r["double"].pop("a top"), "double: a top: 1 difference: missing in the second"),
        (lambda r: r.pop("quad"), "quad: all: 1 difference: missing in the second"),
        (lambda r: r["quad"].update(new={}), "quad: new: 1 difference: missing in the first"),
        (lambda r: r["quad"]["a top"].pop("outcome"), "outcome: reached end and nothing"),
        (lambda r: r["double"]["a top"]["states"].pop(), "1 difference: states[1]: "),
        (
            lambda r: r["double"]["no top"]["refused"].__setitem__(1, "x: expected z"),
            "double: no top: 1 difference: refused[1]: x: expected y and x: expected z",
        ),
        (
            lambda r: r["double"]["no top"]["refused"].__setitem__(0, "ValueError"),
            "refused[0]: BadInput and ValueError",
        ),
        (lambda r: r["double"].update({"no top": {"bits": "53"}}), "double: no top: 2 differences"),
    ],
)
def test_what_is_missing_or_refused_otherwise(tmp_path, capsys, change, told):
    code, out = compared(tmp_path, capsys, change)
    assert code == 1
    assert told in out


def test_numbers_are_written_with_all_their_bits():
    long = np.nextafter(np.longdouble(1), np.longdouble(2))
    assert golden_record.told(np.array([long])) == [f"0x{2**63 + 1:x}p-63"]
    with mpmath.workprec(300):
        assert golden_record.read(golden_record.number(1 + mpmath.mpf(2) ** -250)) == 1 + Fraction(
            1, 2**250
        )
    for value in (0.1, -1.0, 5e-324, np.float64(1e308)):
        assert golden_record.read(golden_record.number(value)) == Fraction(float(value))
    assert golden_record.told([0.0, -0.0, math.inf, math.nan, Fraction(2, 3), True, 7]) == (
        ["0x0p+0", "-0x0p+0", "inf", "nan", "2/3", True, "7"]
    )
    root = polhode.load("euler/irrational").omega
    assert len({golden_record.number(x) for x in root}) > 1


def test_a_refusal_is_recorded_by_class_and_message():
    found = golden_parts.recorded(lambda: polhode.integrate("euler/sphere", "long"))
    message = "euler/sphere: number = long: expected double, extended, quad, mp"
    assert found == {"refused": ["BadInput", message]}


def test_a_make_that_was_cut_short_goes_on(tmp_path, monkeypatch):
    """Entries that are there are not made again; one whose line a kill cut short is."""
    made = []
    entries = [(f"entry {k}", lambda k=k: made.append(k) or k) for k in range(5)]
    monkeypatch.setitem(golden_parts.PARTS, "levels", lambda: iter(entries))
    (tmp_path / "levels.jsonl").write_text('["entry 0", "0"]\n["entry 2", "')
    monkeypatch.setattr(golden.signal, "signal", lambda *_: None)
    golden.make_part(tmp_path, "levels", 1)
    assert made == [1, 2, 3, 4]
    assert (tmp_path / "levels.jsonl").read_text().splitlines() == [
        f'["entry {k}", "{k}"]' for k in range(5)
    ]


@pytest.mark.parametrize("every", [1, 4, 12, 1000])
def test_a_sample_is_spread_over_every_word_of_the_names(every):
    """Also where as many as are left out divide the number of combinations."""
    entries = [(f"top {k} {w}{p}", k) for k in range(60) for w in "abcde" for p in ("", " project")]
    found = golden.sampled(entries, every)
    assert len(found) == -(-len(entries) // every)
    assert found == [pair for pair in entries if pair in found]
    if every < 100:
        assert {name.partition(" ")[2].partition(" ")[2] for name, _ in found} == {
            f"{w}{p}" for w in "abcde" for p in ("", " project")
        }


def test_made_twice_it_is_the_same_to_the_byte(tmp_path):
    """One entry of a part that is quick, each time in a process of its own."""
    files = [tmp_path / "one.json", tmp_path / "two.json"]
    for file in files:
        golden.main(["make", str(file), "--part", "levels", "--sample", "100"])
    assert files[0].read_bytes() == files[1].read_bytes()
    assert len(json.loads(files[0].read_text())["levels"]) == 1
    assert sorted(tmp_path.iterdir()) == files
