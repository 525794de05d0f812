"""A derived column: a formula and two rows, and it is right in every output and number type."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest

import polhode
from polhode.cli import main
from polhode.equations import columns
from polhode.numbers.row_formulas import RowMap
from polhode.scenes.scene_facts import row_columns
from polhode.scenes.vocabulary import COLUMNS, ColumnWord, column_names
from shared.tables import STATE
from shared.tools import DOUBLE, EXTENDED, QUAD, exactly, mp, tiers

NUMBERS = {"double": DOUBLE, "extended": EXTENDED, "quad": QUAD, "mp": mp(50)}
TOP = "lagrange/nutation"

ROW = ColumnWord(("speed",), ("state",), "derived", "the length of omega")


@pytest.fixture(scope="module", autouse=True)
def speed():
    """The column in the package that is imported."""
    with pytest.MonkeyPatch.context() as patch:
        column = columns.DerivedColumn(columns.of_rows(_speed), "p q r are")
        patch.setitem(columns.FORMULAS, "speed", column)
        patch.setitem(COLUMNS, "speed", ROW)
        yield


def _speed(x, k, fn):
    return [fn.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])]


def true_speed(state):
    """Of exact numbers, by mpmath alone, to 1000 bits."""
    with mpmath.workprec(1000):
        p, q, r = (mpmath.mpf(x.numerator) / x.denominator for x in map(Fraction, state[:3]))
        return mpmath.sqrt(p * p + q * q + r * r)


def assert_rounded(rows, state, number):
    """Half a unit of the type's last bit, and no bit fewer: a rounding of the true value."""
    true = true_speed(state)
    with mpmath.workprec(1000):
        exact = mpmath.mpf(rows.numerator) / rows.denominator
        unit = mpmath.ldexp(1, int(mpmath.floor(mpmath.log(true, 2))) + 1 - number.bits)
        assert abs(exact - true) <= unit * 0.501, (rows, true)
    assert number.rounded(rows) == rows


def read(text, number):
    """The number of the type that a printed decimal stands for."""
    return number.rounded(Fraction(text))


@pytest.fixture
def scene():
    return replace(polhode.load(TOP), outputs=("speed",))


def document(capsys, *arguments):
    """What a command that succeeds says, as JSON or as lines of a table."""
    assert main([*arguments]) == 0
    out = capsys.readouterr().out
    return json.loads(out) if "--json" in arguments else [x.split() for x in out.splitlines()]


@pytest.mark.slow
@pytest.mark.parametrize("number", ["double", "quad"])
def test_a_run_has_the_speed_wherever_it_goes(number, scene, tmp_path, capsys):
    """JSON, CSV and the JSON beside it: the same strings; trajectory, file, frames, notebook."""
    kind, path, at = NUMBERS[number], tmp_path / "x.csv", ["0", "1", "5"]
    command = ["run", TOP, "--number", number, "--at", ",".join(at), "--outputs", "speed"]
    table = document(capsys, *command, "--json")["columns"]
    errors = ["error"] * ("error" in table)  # of a refined run
    assert [*table] == ["t", *STATE, "speed", *errors]
    states = zip(*(table[name] for name in STATE), strict=True)
    for state, text in zip(states, table["speed"], strict=True):
        assert_rounded(read(str(text), kind), [read(str(x), kind) for x in state], kind)
        if number != "double":
            assert len(text.replace(".", "")) == kind.printed_digits
    assert main([*command, "-o", str(path)]) == 0
    header, *lines = csv.reader(path.read_text().splitlines())
    assert header == [*table]
    for k, name in enumerate(header):
        assert [line[k] for line in lines] == [*map(str, table[name])]
    told_beside = json.loads(Path(f"{path}.json").read_text())
    assert ("columns" in told_beside, told_beside["number"]) == (False, number)

    run = polhode.integrate(scene, number, at=at)
    speeds = [value for (value,) in run.outputs["speed"]]
    assert [exactly(x) for x in speeds] == [read(str(text), kind) for text in table["speed"]]
    assert isinstance(run.outputs["speed"], np.ndarray) == kind.flat
    assert not kind.flat or run.outputs["speed"].dtype == run.states.dtype
    assert run.hodographs is None
    run.save(tmp_path / "run.npz")
    again = polhode.load_run(tmp_path / "run.npz")
    assert again == run
    assert [row[0] for row in again.outputs["speed"]] == speeds
    frame, dataset = run.to_pandas(), run.to_xarray()
    assert list(frame.columns) == [*STATE, "speed", *errors] == list(dataset.data_vars)
    assert list(frame["speed"]) == speeds == list(dataset["speed"].values)
    assert "<th>speed</th>" in run._repr_html_()


@pytest.mark.parametrize(("name", "digits"), [(TOP, 12), ("euler/turned-axes", 40)])
def test_a_reference_gives_the_speed_to_the_last_digit(name, digits, capsys):
    command = ["reference", name, "--at", "1,1500", "--outputs", "speed,hodographs"]
    command += ["--digits", str(digits)]
    answer = document(capsys, *command, "--json")
    states = polhode.reference(name).at([1, 1500], digits + 20)
    speeds = answer["columns"]["speed"]
    for state, text in zip(states, speeds, strict=True):
        printed = len(text.replace(".", ""))
        assert printed > digits
        with mpmath.workprec(1000):
            wrong = abs(mpmath.mpf(text) - true_speed([exactly(x) for x in state]))
            assert wrong < mpmath.mpf(10) ** (1 - printed) * 0.51
    header, *lines = document(capsys, *command)
    assert header[-4:] == ["omega_x", "omega_y", "omega_z", "speed"]
    assert [line[-1] for line in lines] == speeds
    column = polhode.reference(name).column("speed", [1, 1500], digits)
    for (x,), text in zip(column, speeds, strict=True):
        assert abs(exactly(x) - Fraction(text)) < 10 * Fraction(10) ** -digits


def test_compare_judges_what_the_speed_is_made_of(tmp_path, capsys):
    """Of a file with both the speed is left aside, and a file of speeds alone is refused."""
    path = tmp_path / "x.csv"
    path.write_text("t,p,q,r,speed\n0,0,0,0,1\n")
    answer = document(capsys, "compare", str(path), TOP, "--json")
    assert answer["judged"] == ["p", "q", "r"]
    assert "column speed was not judged: p q r are" in answer["not_judged"]
    path.write_text("t,speed\n0,1\n")
    assert main(["compare", str(path), TOP]) == 2
    assert "expected columns of p, q, r" in capsys.readouterr().err


@pytest.mark.parametrize("number", tiers(["double"], ["extended"]))
def test_a_sweep_gives_the_speed_of_each_member(number, scene, tmp_path, capsys):
    kind, vary = NUMBERS[number], {"body.weight": [1, 2]}
    many = polhode.integrate_many(scene, vary, number=number, at=[0, 1])
    speeds = many.outputs["speed"]
    assert speeds.shape == (2, 2, 1)
    assert speeds.dtype == many.states.dtype
    for k in range(2):
        for value, state in zip(speeds[k, :, 0], many.states[k], strict=True):
            assert_rounded(exactly(value), [exactly(x) for x in state], kind)
        assert [row[0] for row in many[k].outputs["speed"]] == speeds[k, :, 0].tolist()
    assert list(many.to_pandas().columns) == ["body.weight", *STATE, "speed"]
    assert many.to_xarray()["speed"].values.tolist() == speeds[:, :, 0].tolist()
    file = tmp_path / "top.toml"
    file.write_text(polhode.load(TOP).source.replace('["angles", "attitude"]', '["speed"]'))
    command = ["sweep", str(file), "--vary", "body.weight=1,2", "--at", "0,1", "--number", number]
    told_speeds = document(capsys, *command, "--json")["columns"]["speed"]
    printed = [read(str(x), kind) for x in told_speeds]
    assert printed == [exactly(x) for x in speeds[:, :, 0].ravel()]
    assert main([*command, "-o", str(tmp_path / "x.csv")]) == 0
    assert "left out" not in capsys.readouterr().err
    header, *lines = csv.reader((tmp_path / "x.csv").read_text().splitlines())
    assert header[-1] == "speed"
    assert [line[-1] for line in lines] == [*map(str, told_speeds)]


def test_the_word_is_known_by_name(capsys):
    """The guide's table, and a typo of the word."""
    assert main(["guide", "outputs"]) == 0
    assert "| `speed` | `speed` | the length of omega |" in capsys.readouterr().out
    for verb in ("run", "reference"):
        assert main([verb, TOP, "--outputs", "sped"]) == 2
        assert "run.outputs = sped" in (err := capsys.readouterr().err)
        assert "did you mean 'speed'?" in err
    with pytest.raises(polhode.BadInput, match="did you mean 'speed'"):
        polhode.reference(TOP).column("sped", [1])


def divided(x, k, fn):
    return [k["c"] * x[0] / x[1], fn.sqrt(x[1])]


@pytest.mark.parametrize("number", tiers(["double", "quad"], ["extended", "mp"]))
def test_a_row_without_a_finite_real_value_is_a_gap(number):
    """A division by zero, the root of a negative number, a cell that is not there."""
    kind = NUMBERS[number]
    whole, c = [(1, 4), (3, 1)], {"c": Fraction(1, 3)}
    for bad in ((1, 0), (1, -1), (1, None), (float("nan"), 1), (float("inf"), 1)):
        rows = [list(row) for row in (*whole, bad)]
        column = RowMap(divided, c, kind, 2)(rows)
        assert isinstance(column, list)
        assert column[2] == [None, None]
        assert [exactly(x) for x in column[0]] == [kind.rounded(Fraction(1, 12)), 2]
        assert [exactly(x) for x in column[1]] == [1, 1]
    flat = RowMap(divided, c, kind, 2)([list(row) for row in whole])
    assert isinstance(flat, np.ndarray) == kind.flat


def test_every_column_has_a_meaning_and_a_name_of_its_own():
    """The meaning stands in ``about`` of every file, beside the unit; derived words have files."""
    every = ["t", *STATE, *column_names()]
    assert len({*every}) == len(every)
    assert not {*COLUMNS} & {"scene", "number", "bits", "columns", "times", "states", "events"}
    assert {*columns.FORMULAS} == {*columns.derived_words()}
    names = [name for name in column_names() if name != "speed"]  # which is added here
    rows = row_columns(None, names, [[0.0] * len(names)], DOUBLE)
    assert [column.name for column in rows if not column.meaning] == []
