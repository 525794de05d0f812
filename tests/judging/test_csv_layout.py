"""Files as other programs write them: separators, headers in comments or none, other names."""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import cli
from polhode.judging.tables.column_aliases import column
from polhode.scenes.vocabulary import ATTITUDE, STATE

TIMES = [Fraction(k, 4) for k in range(13)]
SCENE = "lagrange/nutation"
NAMES = ("t", *STATE, *ATTITUDE)


@pytest.fixture(scope="module")
def table():
    """The exact motion: t, the state, the quaternion, in rows of doubles."""
    exact = polhode.reference(SCENE)
    rows = zip(TIMES, exact.at(TIMES, 20), exact.attitude(TIMES, 20), strict=True)
    return np.array([[float(x) for x in (t, *a, *b)] for t, a, b in rows])


def text(table, separator=",", header=NAMES):
    head = [separator.join(header)] if header else []
    return "\n".join([*head, *(separator.join(map(repr, row)) for row in table.tolist())]) + "\n"


def judged(tmp_path, capsys, content, *options):
    path = tmp_path / "x.csv"
    path.write_text(content)
    code = cli.main(["compare", str(path), SCENE, "--json", *options])
    out, err = capsys.readouterr()
    return (code, json.loads(out)) if code == 0 else (code, err)


def is_right(found):
    code, answer = found
    assert code == 0, answer
    assert answer["worst"] > 14.5
    assert {*answer["parts"]} == {"omega", "gamma", "attitude"}


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", "   "])
def test_any_separator_is_read(tmp_path, capsys, table, separator):
    is_right(judged(tmp_path, capsys, text(table, separator)))


@pytest.mark.parametrize("headed", [True, False])
def test_decimal_commas_between_semicolons_are_read(tmp_path, capsys, table, headed):
    content = text(table, ";", NAMES if headed else ()).replace(".", ",")
    options = [] if headed else ["--columns", ",".join(NAMES)]
    found = judged(tmp_path, capsys, content, *options)
    is_right(found)
    assert found[1]["remarks"] == ["read as: decimal commas"]
    plain = judged(tmp_path, capsys, text(table, ";"))
    assert plain[1]["remarks"] == []
    assert plain[1]["correct_digits"] == found[1]["correct_digits"]


@pytest.mark.parametrize("cell", ["0.5", "1.000,5", "1,000,5", "x,5"])
def test_commas_that_are_not_all_decimal_are_refused(tmp_path, capsys, table, cell):
    content = text(table, ";").replace(".", ",")
    code, error = judged(tmp_path, capsys, content.rpartition(";")[0] + f";{cell}\n")
    assert code == 2
    assert "expected a finite decimal number" in error


def test_a_column_without_a_name_is_quoted(tmp_path, capsys, table):
    content = "\n".join(f"{k - 1 if k else ''},{x}" for k, x in enumerate(text(table).split()))
    (tmp_path / "x.csv").write_text(content)
    assert cli.main(["compare", str(tmp_path / "x.csv"), SCENE]) == 0
    said = "not judged: column '' is not known and was not judged"
    assert said in capsys.readouterr().out.splitlines()


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("comments", ["", "# made by a program, of t and such\n"])
def test_a_header_in_a_comment_is_read(tmp_path, capsys, table, separator, comments):
    path = tmp_path / "y.csv"
    np.savetxt(path, table, delimiter=separator, header=separator.join(NAMES))
    is_right(judged(tmp_path, capsys, comments + path.read_text()))


def test_columns_are_named_where_there_is_no_header(tmp_path, capsys, table):
    is_right(judged(tmp_path, capsys, text(table, header=()), "--columns", ",".join(NAMES)))
    other = [f"c{k}" for k in range(len(NAMES))]
    is_right(judged(tmp_path, capsys, text(table, header=other), "--columns", ",".join(NAMES)))
    code, told = judged(tmp_path, capsys, text(table, header=()))
    assert code == 2
    assert "expected a header with a column t (or time, timestamp)" in told
    assert "--columns t,p,q,..." in told


def test_lines_are_counted_as_the_file_has_them(tmp_path, capsys, table):
    content = text(table, header=()).replace("\n0.5,", "\n0.5,x", 1)
    code, told = judged(tmp_path, capsys, content, "--columns", ",".join(NAMES))
    assert code == 2
    assert "x.csv:3: p = x" in told


def test_single_columns_are_named_with_a_factor(tmp_path, capsys, table):
    table = table.copy()
    table[:, 0] *= 1000
    table[:, 3] *= -1
    header = ("stamp", "p", "q", "R", *STATE[3:], "Q.W", *ATTITUDE[1:])
    given = ("--columns", "stamp=t*1e-3, R=-r, Q.W=q0")
    is_right(judged(tmp_path, capsys, text(table, header=header), *given))
    for wrong in ("stamp=time", "stamp=t*x", "=t"):
        code, told = judged(tmp_path, capsys, text(table, header=header), "--columns", wrong)
        assert code == 2
        assert "NAME=COLUMN" in told


@pytest.mark.parametrize(
    ("theirs", "ours"),
    [
        ("orientation.w", "q0"),
        ("pose.orientation.x", "q1"),
        ("angular_velocity.z", "r"),
        ("AngularVelocity.x", "p"),
        ("Rotation.w", "q0"),
        ("Rotation_Z", "q3"),
        ("rotation_quaternion[0]", "q0"),
        ("rotation_quaternion[3]", "q3"),
        ("qpos0", "q0"),
        ("qpos[3]", "q3"),
        ("qvel2", "r"),
        ("qvel3", None),
        ("timestamp", "t"),
        ("position.x", None),
        ("rotation", None),
    ],
)
def test_names_of_engines(theirs, ours):
    assert column(theirs).name == ours


def test_units_of_time_and_rate_in_names(tmp_path, capsys, table):
    table = table.copy()
    table[:, 0] *= 1000
    table[:, 1:4] *= 30 / np.pi
    header = ("time_ms", "wx [rpm]", "wy [rpm]", "wz [rpm]", *STATE[3:], *ATTITUDE)
    is_right(judged(tmp_path, capsys, text(table, header=header)))
