"""Times of a clock, or rounded ones: what a judgement says of a right program's rows."""

from __future__ import annotations

import time
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import cli
from polhode.scenes.vocabulary import STATE

SCENE = "lagrange/nutation"


def rows_at(times, scene=SCENE):
    """The state at exact times, in doubles, a row each."""
    run = polhode.integrate(scene, at=times)
    return np.array(run.states)


def columns(stamps, states):
    return {"t": np.array([float(t) for t in stamps]), **dict(zip(STATE, states.T, strict=True))}


# -- rounded times --------------------------------------------------------------------------------


def through(door, path, table):
    """The same table, through a door: a mapping, a file of arrays, a frame, a CSV in a format."""
    names, cells = [*table], np.column_stack([*table.values()])
    if door == "npz":
        np.savez(path / "x.npz", **table)
        return path / "x.npz"
    if door.startswith("%"):
        head = ",".join(names)
        np.savetxt(path / "x.csv", cells, fmt=door, delimiter=",", header=head, comments="")
        return path / "x.csv"
    if door == "mapping":
        return table
    frame = pytest.importorskip("pandas").DataFrame(table)
    if door == "frame":
        return frame
    frame.to_csv(path / "x.csv", index=False)
    return path / "x.csv"


@pytest.fixture(scope="module")
def thirds():
    """Times that no clock of doubles holds, and the right rows."""
    times = [Fraction(k, 3) for k in range(20)]
    return times, rows_at(times)


DOORS = ["mapping", "%.18e", "npz", "frame", "pandas"]
DOORS += ["%.17e", "%.20g", "%.25g", "%.16e", "%.17g"]


@pytest.mark.sample(3, first=2)
@pytest.mark.parametrize("door", DOORS)
def test_rounding_of_a_clocks_time_is_the_limit_whatever_the_door(tmp_path, thirds, door):
    times, states = thirds
    table = columns([t + 10**6 for t in times], states)
    found = polhode.compare(through(door, tmp_path, table), SCENE)
    assert found.subject.number.name == "double"
    assert 9 < found.worst < 11
    assert found.limit == "rounding (of the times, by up to 2e-10)"


def test_times_beside_rows_are_rounded_too(thirds):
    times, states = thirds
    rows = polhode.compare(states, SCENE, at=[float(t + 10**6) for t in times])
    assert "limited by rounding (of the times, by up to 2e-10)" in str(rows)


@pytest.mark.parametrize("size", [1e-8, 1e-5])
def test_more_than_the_clock_explains_is_not_blamed_on_it(thirds, size):
    times, states = thirds
    table = columns([t + 10**6 for t in times], states)
    table["q"] = table["q"] + size * np.sin(np.arange(20))
    found = polhode.compare(table, SCENE)
    assert found.limit.startswith("method")
    assert "more than rounding" in str(found)


@pytest.mark.parametrize(("places", "limit"), [(6, "by up to 1e-06"), (9, "by up to 1e-09")])
def test_decimals_that_are_not_evenly_spaced_are_rounded(tmp_path, thirds, places, limit):
    times, states = thirds
    cells = [f"{float(t):.{places}f}" for t in times]
    rows = [",".join([t, *map(repr, row)]) for t, row in zip(cells, states.tolist(), strict=True)]
    path = tmp_path / "x.csv"
    path.write_text("\n".join([",".join(("t", *STATE)), *rows]))
    assert polhode.compare(path, SCENE).limit.startswith("rounding (of the times")
    even = [",".join([f"{k / 10}", row.partition(",")[2]]) for k, row in enumerate(rows)]
    path.write_text("\n".join([",".join(("t", *STATE)), *even]))
    assert not polhode.compare(path, SCENE).limit.startswith("rounding")


# -- decimals of doubles --------------------------------------------------------------------------


def judged(path, cells, header=("t", *STATE)):
    path.write_text("\n".join([",".join(header), *(",".join(row) for row in cells)]))
    return polhode.compare(path, SCENE)


def test_doubles_printed_longer_than_they_are_beside_short_times(tmp_path):
    times = [Fraction(k, 10) for k in range(30)]
    states = rows_at(times)
    cells = [[f"{k / 10}", *(f"{x:.18e}" for x in row)] for k, row in enumerate(states.tolist())]
    found = judged(tmp_path / "x.csv", cells)
    assert (found.subject.number.name, found.limit) == ("double", "rounding")
    assert found.subject.remarks == ("read as: numbers of double, printed to 19 digits",)
    cells[7][2] = cells[7][2][:-7] + "1" + cells[7][2][-6:]  # the decimal of no double
    assert judged(tmp_path / "x.csv", cells).subject.number.name == "mp"
    single = [[t, *(f"{np.float32(x):.18e}" for x in map(float, row))] for t, *row in cells]
    found = judged(tmp_path / "x.csv", single)
    assert (found.subject.number.name, found.limit) == ("single", "rounding")


def test_more_digits_than_a_doubles_stay_more_digits(tmp_path):
    times = [Fraction(k, 4) for k in range(8)]
    exact = polhode.reference(SCENE).at(times, 40)
    for digits in (19, 25, 36):
        cells = [
            [
                str(float(t)),
                *(
                    polhode.numbers.decimals.decimal_string(
                        polhode.numbers.conversion.exactly(x), digits
                    )
                    for x in row
                ),
            ]
            for t, row in zip(times, exact, strict=True)
        ]
        found = judged(tmp_path / "x.csv", cells)
        assert found.subject.number.name == "mp"
        assert digits - 1 < found.worst < digits + 1.5


# -- other origins --------------------------------------------------------------------------------

OFFSETS = [
    (SCENE, "1700000000", 1, "-"),
    (SCENE, "1700000000.5", 17, "-"),
    ("kovalevskaya/generic", "12.5", "3.3", "-"),
    ("euler/largest-axis", "-45.678", "45.678", "+"),
    ("general/asymmetric-regular", "1234567", 9, "-"),
    ("general/asymmetric-chaotic", "-7.25", "8.5", "+"),
]


@pytest.mark.sample(3, first=2)
@pytest.mark.parametrize(("scene", "offset", "begin", "sign"), OFFSETS)
def test_rows_of_another_clock_are_read_at_their_own_times(scene, offset, begin, sign):
    times = [Fraction(begin) + Fraction(k, 7) for k in range(9)]
    states, told = rows_at(times, scene), []
    stamps = np.array([float(t + Fraction(offset)) for t in times])
    found = polhode.compare(
        columns(stamps, states), scene, forecast=lambda seconds, _: told.append(seconds)
    )
    words = f"t of another clock: rows belong to t {sign} {offset.lstrip('-')}"
    assert found.reading == words
    assert abs(found.times[-1] - times[-1]) < 1e-6
    assert found.worst > 6
    assert found.limit.startswith("rounding")
    assert max(told, default=0) < 5
    assert polhode.compare(columns(stamps, states), scene, read=words).worst == found.worst


OFFSETS_BELOW = [
    ("general/asymmetric-regular", "-3", "0.7"),
    ("lagrange/nutation", "-100000", "5"),
    ("kovalevskaya/generic", "-7.25", "6.5"),
]


@pytest.mark.parametrize(("scene", "offset", "begin"), OFFSETS_BELOW)
def test_stamps_below_zero_are_read_from_their_first_row(scene, offset, begin):
    """Stamps on both sides of 0, or all below it, of which the last one is the nearest to 0."""
    times = [Fraction(begin) + Fraction(k, 4) for k in range(14)]
    stamps = [t + Fraction(offset) for t in times]
    found = polhode.compare(columns(stamps, rows_at(times, scene)), scene)
    assert found.reading == f"t of another clock: rows belong to t + {offset.lstrip('-')}"
    assert found.worst > 9
    assert found.causes == ()


def test_rows_that_belong_a_fraction_of_a_step_earlier_are_explained_so():
    times = [Fraction(k, 4) for k in range(1, 30)]
    table = columns([t + Fraction(1, 64) for t in times], rows_at(times, "kovalevskaya/generic"))
    (cause,) = polhode.compare(table, "kovalevskaya/generic").causes
    assert cause.words == "rows that belong to t - 0.015625"


def test_a_gate_says_that_no_origin_of_t_was_sought():
    times = [Fraction(k, 7) for k in range(9)]
    table = columns([t + 10**9 for t in times], rows_at(times, "general/asymmetric-chaotic"))
    with pytest.raises(polhode.BadInput) as refused:
        polhode.compare(table, "general/asymmetric-chaotic", as_it_stands=True)
    assert "t looks like a clock's (1000000000 to 1.14 later)" in str(refused.value)
    assert "no other origin of t is tried here" in str(refused.value)
    assert "no offset was found" not in str(refused.value)


def test_a_clock_is_found_by_one_part_and_the_others_are_read_in_their_convention():
    times = [Fraction(5) + Fraction(k, 8) for k in range(9)]
    table = columns([t + 10**5 for t in times], rows_at(times))
    table |= {name: np.degrees(table[name]) for name in "pqr"}
    found = polhode.compare(table, SCENE)
    assert found.reading == ("t of another clock: rows belong to t - 100000; omega degrees")
    assert found.worst > 9


@pytest.mark.slow
@pytest.mark.parametrize("scene", [SCENE, "kovalevskaya/generic"])
def test_rows_of_no_time_are_refused_a_clock_soon(scene):
    rows = np.random.default_rng(3).normal(size=(3, 6))
    begun = time.process_time()
    found = polhode.compare(rows, scene, at=[1.7e9, 1.7e9 + 1, 1.7e9 + 2])
    text = str(found)
    assert time.process_time() - begun < 8  # it was 31 s
    assert found.reading is None
    assert "t looks like a clock's (1700000000 to 2 later), and no offset was found" in text


def test_a_proof_that_is_too_long_says_that_times_look_like_a_clocks():
    rows = np.random.default_rng(3).normal(size=(3, 6))
    with pytest.raises(polhode.BadInput, match="t looks like a clock's"):
        polhode.compare(rows, "general/asymmetric-regular", at=[1.7e9, 1.7e9 + 1, 1.7e9 + 2])


def test_the_command_reads_a_clock_and_says_so(tmp_path, capsys):
    times = [Fraction(3) + Fraction(k, 5) for k in range(6)]
    table = columns([t + 1700000000 for t in times], rows_at(times))
    np.savetxt(
        tmp_path / "x.csv",
        np.column_stack([*table.values()]),
        delimiter=",",
        header=",".join(table),
    )
    assert cli.main(["compare", str(tmp_path / "x.csv"), SCENE]) == 0
    out = capsys.readouterr().out
    assert "read as t of another clock: rows belong to t - 1700000000" in out
    assert "limited by rounding (of the times, by up to 2e-07)" in out


def test_what_takes_long_to_follow_is_foretold(tmp_path, capsys, monkeypatch):
    from polhode.verbs import compare

    (tmp_path / "x.csv").write_text("t,p,q,r\n0,0.16,0.3,4.1\n1,0,0,0\n")
    assert cli.main(["compare", str(tmp_path / "x.csv"), SCENE]) == 0
    assert "is followed through" not in capsys.readouterr().err
    monkeypatch.setattr(compare, "_SECONDS", 5.0)
    assert cli.main(["compare", str(tmp_path / "x.csv"), SCENE]) == 0
    assert "the motion is followed through 4.1 radians" in capsys.readouterr().err
