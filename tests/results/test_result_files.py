"""Results written and read again: every ending, the same bytes by every door."""

import json
import math
import random
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from invented import ENDINGS, TEXTS, Bare, Odd, content_at, facts_beside, read, written

import polhode
from polhode import Result
from polhode.cli import main
from polhode.numbers.decimals import Ball
from polhode.numbers.exact import sqrt
from polhode.results import writer
from polhode.results.cells import header_and_rows, lines
from polhode.results.table import Column, Content, Fact, Table

RESULTS = {"all types": Odd(4), "three rows": Odd(3), "one": Odd(1), "none": Odd(0), "bare": Bare()}


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("name", RESULTS)
def test_what_is_read_is_written_to_the_same_bytes(name: str, ending: str, tmp_path: Path) -> None:
    content = RESULTS[name].content()
    path = tmp_path / f"x{ending}"
    files = written(content, path)
    again = read(content, path)
    assert written(again, path) == files
    assert [x.name for x in again.table.columns] == [x.name for x in content.table.columns]
    assert [x[2:4] for x in again.table.columns] == [x[2:4] for x in content.table.columns]
    assert [x.digits for x in again.table.columns] == [x.digits for x in content.table.columns]
    assert again.kind == content.kind
    assert again.title == content.title
    assert again.table.labels == content.table.labels


@pytest.mark.parametrize("ending", ENDINGS)
def test_values_come_back(ending: str, tmp_path: Path) -> None:
    content = Odd().content()
    again = read(content, tmp_path / f"x{ending}")
    before = {x.name: x.values for x in content.table.columns}
    after = {x.name: x.values for x in again.table.columns}
    for name in ("k", "x", "ok", "extended"):
        np.testing.assert_array_equal(after[name], before[name])
        assert after[name].dtype == before[name].dtype
    assert math.copysign(1.0, after["x"][2]) == -1.0
    np.testing.assert_array_equal(after["y"], [1.0, np.nan, -np.inf, 1e-310])
    assert after["a name, quoted"] == TEXTS
    assert after["e"] == before["e"]
    assert after["large"] == before["large"]
    assert all(a is b is None or a == b for a, b in zip(after["wide"], before["wide"], strict=True))
    (root, none, *_) = after["root"]
    assert none is None
    assert 0 < abs(root * root - 2) < Fraction(1, 10**39)
    facts = {x.name: x.value for x in again.facts}
    for fact in content.facts:
        if fact.name not in ("root", "told root", "not a number", "gaps", "empty", "marks"):
            expected = fact.value
            if fact.name == "text":
                expected = 'two\nlines, "quoted" é?'  # half a character is none
            if fact.name == "large":
                expected = Fraction(2**70)  # which no reader of JSON numbers would keep
            if fact.name == "provenance":
                expected = {"versions": {"a": "1"}, "notes": ["x", 5, "inf", None]}
            assert facts[fact.name] == expected, fact.name
            assert type(facts[fact.name]) is type(expected)
    assert facts["not a number"] is None
    assert math.isnan(facts["gaps"][0])
    assert facts["gaps"][1] == 2.5
    assert abs(facts["told root"] ** 2 - 2) < Fraction(1, 10**18)
    assert facts["marks"].columns[1].values == [Fraction(1, 3), None]
    assert facts["marks"].columns[1].unit == "J"
    assert facts["empty"].columns[1].type == "text"


def test_json_is_json_and_a_line_each(tmp_path: Path) -> None:
    def refused(text: str) -> float:
        raise AssertionError(text)

    text = Odd().to_json()
    facts = json.loads(text, parse_constant=refused)
    assert text.isascii()
    assert facts["format"] == "polhode result 2"
    assert facts["result"] == "Odd"
    assert facts["columns"]["x"] == ["inf", None, -0.0, 5.0]
    assert facts["columns"]["e"] == ["1/3", None, "2.5", str(10**40 + 1)]
    assert facts["columns"]["large"] == ["1", str(2**53), str(-(2**60)), "0"]
    assert '"x": ["inf", null, -0.0, 5.0]' in text
    assert facts["exact"] == "3"
    assert facts["whole double"] == 2.0
    assert '"whole double": 2.0,' in text
    about = {"type": "double", "unit": "m", "meaning": "a number", "digits": 3}
    assert facts["about"]["columns"]["x"] == about
    for name in facts["columns"]:
        assert sum(line.startswith(f"  {json.dumps(name)}: [") for line in text.splitlines()) == 1
    path = tmp_path / "x.json"
    assert written(Odd().content(), path)[path].decode() == text


def test_a_table_is_what_others_read(tmp_path: Path) -> None:
    """numpy, its loadtxt too where there are no gaps, and pandas."""
    pandas = pytest.importorskip("pandas")
    path = tmp_path / "x.csv"
    Odd().save(path)
    frame = pandas.read_csv(path)
    assert len(frame) == 4
    assert frame["a name, quoted"][0] == TEXTS[0]
    np.testing.assert_array_equal(frame["x"], [np.inf, np.nan, -0.0, 5.0])
    Bare().save(tmp_path / "bare.csv")
    frame = pandas.read_csv(tmp_path / "bare.csv")
    np.testing.assert_array_equal(frame["x"], [np.nan, 1.5, np.nan])


def test_doubles_come_back_by_the_fast_way(tmp_path: Path) -> None:
    """Where all cells are full numpy reads them, elsewhere Python."""
    draw = random.Random(7)
    x = np.array([draw.uniform(-1, 1) * 10.0 ** draw.randint(-300, 300) for _ in range(2000)])
    y = x[::-1].copy()
    for gaps in (False, True):
        if gaps:
            y[5] = np.nan
        content = Content("Odd", "1", "", Table([Column("x", x), Column("y", y)]), ())
        again = read(content, tmp_path / "x.csv")
        for column, before in zip(again.table.columns, (x, y), strict=True):
            np.testing.assert_array_equal(column.values, before)


def test_a_stream_has_a_table_alone_with_times_in_full() -> None:
    columns = [Column("t", np.array([0.1, 2.0])), Column("x", np.array([0.1, 2.0]))]
    content = Content("Odd", "1", "", Table(columns), ())
    (text,) = writer.files(content, Path("-")).values()
    lines = text.decode().splitlines()
    assert lines == ["t,x", f"{Decimal.from_float(0.1):f},0.1", "2,2.0"]
    columns[0] = Column("t", np.array([0.1, np.nan]))
    (text,) = writer.files(content._replace(table=Table(columns)), Path("-")).values()
    assert text.decode().splitlines()[1:] == ["0.1,0.1", ",2.0"]


def test_npz_is_numpy_s_own(tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    Odd().save(path)
    with np.load(path, allow_pickle=False) as file:
        assert file["k"].tolist() == [0, 1, 2, 3]
        assert file["e"].tolist() == ["1/3", "", "2.5", str(10**40 + 1)]
        assert file["marks.h"].tolist() == ["1/3", ""]
        facts = json.loads(bytes(file["about"]))
    assert "columns" not in facts
    assert "marks" not in facts
    assert facts["truth"] is True


def test_an_unknown_ending_is_refused_before_anything(tmp_path: Path) -> None:
    for name in ("x.txt", "x", "x.jsn"):
        with pytest.raises(polhode.BadInput, match=r"a name that ends in .*\.csv"):
            Odd().save(tmp_path / name)
        with pytest.raises(polhode.BadInput, match=r"a name that ends in .*\.csv"):
            content_at(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_names_that_are_not_there_are_refused() -> None:
    odd: Result = Odd()
    assert odd.column("k").tolist() == [0, 1, 2, 3]  # type: ignore[union-attr]
    assert odd.fact("count") == 1
    with pytest.raises(polhode.BadInput, match=r"column = wid: expected .*wide"):
        odd.column("wid")
    with pytest.raises(polhode.BadInput, match=r"fact = cont: expected .*count"):
        odd.fact("cont")


def test_a_value_of_no_type_is_a_fault_of_its_maker() -> None:
    for values in ([object()], [1, "x"], [True, None], np.array([1j]), [Fraction(1), 0.5]):
        with pytest.raises(TypeError):
            writer.csv_text(Table([Column("x", values)]))
    deep = {"a": {"b": {"c": {"d": 1}}}}
    with pytest.raises(ValueError, match="too deep"):
        writer.document(Content("Odd", "", "", Table(()), [Fact("object", deep)]))


# -- What a result may replace: nothing, or an unchanged file of a result of its kind --------------


def contents(folder: Path) -> dict[str, bytes]:
    return {x.name: x.read_bytes() for x in folder.iterdir()}


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_result_replaces_its_own_kind_alone(ending: str, tmp_path: Path) -> None:
    if ending == ".parquet":
        pytest.importorskip("pyarrow")
    path = tmp_path / f"x{ending}"
    path.write_bytes(b"")  # an empty file is nothing
    Odd(2).save(path)
    Odd(3).save(path)
    before = contents(tmp_path)
    with pytest.raises(polhode.BadInput, match="another name: it holds a result Odd"):
        Bare().save(path)
    assert contents(tmp_path) == before
    path.write_bytes(b"t,x\n1,2\n")
    changed = contents(tmp_path)
    with pytest.raises(polhode.BadInput, match="another name: "):
        Odd(3).save(path)
    assert contents(tmp_path) == changed


def test_facts_that_are_somebody_s_are_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    beside = facts_beside(path)
    beside.write_text('{"a": 1}')
    with pytest.raises(polhode.BadInput, match=r"x\.csv\.json: .* polhode did not write it"):
        Odd().save(path)
    assert not path.exists()
    beside.unlink()
    Odd().save(path)
    path.unlink()  # of a table that is gone the facts are replaced
    Odd(1).save(path)
    path.unlink()
    with pytest.raises(polhode.BadInput, match="it holds a result Odd"):
        Bare().save(path)


def test_the_name_of_a_table_s_facts_is_no_result_s(tmp_path: Path) -> None:
    """A result there would take the facts from a table that is whole."""
    Odd().save(tmp_path / "x.csv")
    before = contents(tmp_path)
    with pytest.raises(polhode.BadInput, match=r"another name: this is of the facts of x\.csv"):
        Odd().save(tmp_path / "x.csv.json")
    assert contents(tmp_path) == before
    names = ["x.csv", "x.csv.json"]
    for verb in ("run", "certify"):
        places = [word for name in names for word in ("-o", str(tmp_path / name))]
        assert main([verb, "lagrange/nutation", "--at", "1", *places]) == 2
    assert contents(tmp_path) == before


def test_json_that_is_cut_is_ours_still(tmp_path: Path) -> None:
    """What was cut, by a full disk, can be written again."""
    path = tmp_path / "x.json"
    Odd().save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[:500])
    Odd().save(path)
    assert path.read_bytes() == whole


# -- Tables as a terminal shows them: rounded as their columns say, never beyond what is known -----

THIRD = Fraction(1, 3)


@pytest.mark.parametrize(
    ("column", "shown"),
    [
        (Column("x", [0.1, float("nan"), -2.5e-9]), ["0.1", "", "-2.5e-09"]),
        (Column("x", np.array([1 / 3, 0.0]), digits=17), ["0.33333333333333331", "0"]),
        (Column("x", [1.0, None], digits=17), ["1.0000000000000000", ""]),
        (Column("x", [THIRD, Fraction(1, 8), Fraction(3)], digits=15), ["1/3", "0.125", "3"]),
        (Column("x", [Fraction(10**8, 10**7 + 1), Fraction(1, 3 * 10**9)]), ["10", "3.33333e-10"]),
        (Column("x", [Fraction(1, 10**7), None], type="exact"), ["1e-07", ""]),
        (Column("x", [sqrt(Fraction(2))], digits=12), ["1.41421356237"]),
        (Column("x", np.array([1], np.longdouble), digits=5), ["1.0000"]),
        (Column("x", [Ball(THIRD, 1e-4), None]), ["0.333", ""]),
        (Column("x", [3, 10**6]), ["3", "1000000"]),
        (Column("x", [True, False]), ["true", "false"]),
        (Column("x", ["a", ""]), ["a", ""]),
    ],
)
def test_cells_are_rounded_and_empty_where_there_is_no_number(column, shown):
    assert header_and_rows(Table([column])) == (["x"], [[x] for x in shown])


def test_a_column_of_no_digits_is_not_shown_and_no_rows_are_a_header():
    table = Table([Column("x", [1.5]), Column("y", [2.5], digits=0), Column("z", ["u\x1b"])])
    assert lines(table) == ["x    z", "1.5  u?"]
    assert lines(Table([Column("x", []), Column("name", [], type="text")])) == ["x  name"]
