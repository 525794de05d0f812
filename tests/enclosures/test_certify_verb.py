"""``polhode certify``: only proven digits are printed."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from fractions import Fraction
from importlib.metadata import version
from pathlib import Path

import pytest

import polhode
from polhode import cli
from polhode.enclosures.task import Task
from polhode.scenes.library import StartBox
from shared.tools import exactly

CASE = "kovalevskaya/generic"


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = cli.main(arguments)
    out, err = capsys.readouterr()
    return code, out, err


def test_every_printed_digit_is_that_of_the_closed_form(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "certify", CASE, "--at", "1,30", "--digits", "25")
    assert code == 0
    rows = [line.split() for line in out.splitlines()[1:]]
    exact = polhode.reference(CASE).at([1, 30], digits=60)
    for row, true in zip(rows, exact, strict=True):
        for text, x in zip(row[1:-1], true, strict=True):
            places = len(text.partition(".")[2])
            assert places >= 24  # the 25th may have a tie in its ball
            assert round(exactly(x) * 10**places) == Fraction(text) * 10**places
    assert "every digit is proven" in err


def test_json_has_balls_that_hold_the_truth(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(capsys, "certify", CASE, "--at", "-2,-7", "--digits", "18", "--json")
    answer = json.loads(out)
    columns = answer["columns"]
    assert code == 0
    assert min(columns["digits_proven"]) >= answer["digits_proven"] >= 18
    exact = polhode.reference(CASE).at([-2, -7], digits=60)
    proven = polhode.certify(CASE, at=[-2, -7], digits=18)
    for k, name in enumerate(polhode.load(CASE).columns):
        for n, row in enumerate(exact):
            middle, radius = Fraction(columns[name][n]), columns[f"{name}_radius"][n]
            assert abs(middle - exactly(row[k])) <= Fraction(radius)
            assert Fraction(radius) < Fraction(1, 10**17)
            # both are decimals, the radius rounded up, and hold the whole ball all the same
            off = abs(middle - proven.centres[n][k])
            assert off + Fraction(proven.radii[n][k]) <= Fraction(radius)


TOP = """schema = 1
body = {{ moments = {moments}, centre = [0, 0, 1], weight = {weight} }}
start = {{ {start} }}
run.end = {end}
"""


def written(tmp_path, start: str, moments="[1, 1.2, 0.5]", weight=1, end=2, more="") -> str:
    path = tmp_path / "top.toml"
    path.write_text(TOP.format(moments=moments, weight=weight, start=start, end=end) + more)
    return str(path)


@pytest.mark.parametrize("rate", [75, -75])
def test_proven_numbers_of_any_size_are_printed(rate, tmp_path, capsys) -> None:
    """Rates of 1e75: not one digit before the point that is proven may be left out, nor a cell."""
    start = f'omega = ["1e{rate}", "2e{rate}", "1e{rate}"], gamma = [0, "3/5", "4/5"]'
    top, end = written(tmp_path, start, "[1, 2, 3]", 0, '"1e-80"'), f"3e{-rate}"
    code, out, _ = run(capsys, "certify", top, "--at", end, "--digits", "15")
    assert code == 0
    (row,) = ([float(x) for x in line.split()[1:-1]] for line in out.splitlines()[1:])
    (exact,) = polhode.reference(top).at([end], digits=20)
    assert row == pytest.approx([float(x) for x in exact], rel=1e-13)
    assert max(len(text) for text in out.splitlines()[1].split()[1:]) < 30


def test_a_statement_says_what_is_proven_and_what_it_rests_on(capsys) -> None:
    case = ("certify", "general/asymmetric-regular", "--at", "1,2", "--digits", "12", "--json")
    code, out, err = run(capsys, *case, "--outputs", "angles")
    assert code == 0
    statement = "\n".join(json.loads(out)["statement"])
    for words in (
        *("I_y = (0, 3/2, 0)", "w = (3/10, 1/5, 3), gamma = (3/5, 0, 4/5), psi = 0"),
        *("exists on [0, 2]", "its angles likewise"),
        *(f"python-flint {version('python-flint')}", "proven up to whole turns"),
    ):
        assert words in statement
    assert "by the rule for equal" not in err
    statement = json.loads(run(capsys, *case)[1])["statement"]
    assert "exists on [0, 2]" in statement[1]
    assert not any("whole turns" in line for line in statement)


def test_what_the_rule_for_equal_decides_is_noted(tmp_path, capsys) -> None:
    start = 'gamma = ["sqrt(2)*sqrt(3) - sqrt(6)", 0, 1], omega = [1, 0, 4]'
    top = written(tmp_path, start, more='run.outputs = ["attitude"]\n')
    arguments = ("--at", "2", "--digits", "12")
    code, _, err = run(capsys, "certify", top, *arguments)
    assert code == 0
    assert "by the rule for equal numbers, not proven: whether the start is at a pole" in err
    code, out, _ = run(capsys, "certify", top, *arguments, "--json")
    assert len(json.loads(out)["assumed"]) == 2


def test_a_zero_at_the_start_is_no_event_and_where_a_proof_is_open_is_told(
    tmp_path, capsys
) -> None:
    start = 'angles = [0, "pi/2", 0], rates = [0, 1, 4]'
    top = written(tmp_path, start, more='[[events]]\nname = "equator"\n')
    arguments = ("--at", "2", "--digits", "12", "--events")
    code, _, err = run(capsys, "certify", top, *arguments)
    assert code == 0
    assert "event equator: 1 proven at t = 1.64484294505897" in err
    assert "; undecided from 0 to 1." in err  # gamma3 is 0 there by the rule for "equal"
    assert "e-22\n" in err
    for number in ("double", "quad"):
        (events,) = polhode.integrate(top, number).events
        assert [round(float(t), 12) for t in events.times] == [1.644842945059]


@pytest.mark.slow
def test_a_proven_table_holds_what_is_printed_and_loads_again(tmp_path, capsys) -> None:
    scene = tmp_path / "scene.toml"
    events = '\n[[events]]\nname = "nutation"\n'
    scene.write_text(polhode.as_toml(polhode.load("lagrange/nutation")) + events)
    path = tmp_path / "proven.csv"
    command = ["certify", str(scene), "--at", "1,2", "--digits", "20", "--events"]
    code, out, _ = run(capsys, *command)
    assert code == 0
    header, *printed = (line.split() for line in out.splitlines())
    code, out, _ = run(capsys, *command, "-o", str(path))
    assert (code, out) == (0, "")
    names, *rows = (line.split(",") for line in path.read_text().splitlines())
    width = len(header)
    assert names[:width] == header
    assert names[width:] == [f"{name}_radius" for name in header[1:-1]]
    for row, decimals in zip(rows, printed, strict=True):
        for middle, radius, text in zip(row[1:], row[width:], decimals[1:-1], strict=False):
            places = len(text.partition(".")[2])
            assert round(Fraction(middle) * 10**places) == Fraction(text) * 10**places
            assert 0 < float(radius) < 1e-19
    code, out, _ = run(capsys, *command, "--json")
    assert (
        Path(f"{path}.json").read_text().partition('"title"')[2].partition('"about"')[0]
        == (out.partition('"title"')[2].partition('"about"')[0])
    )
    assert json.loads(out)["events"]["event"]
    code, out, _ = run(capsys, "compare", str(path), str(scene), "--as-it-stands")
    assert code == 0
    assert min(float(x) for x in re.findall(r"^[12] +(\S+)", out, re.MULTILINE)) > 20


def test_a_closed_form_is_written_as_a_table(tmp_path, capsys) -> None:
    path, command = tmp_path / "exact.csv", ("reference", CASE, "--at", "0,1", "--digits", "30")
    code, printed, err = run(capsys, *command)
    assert (code, err) == (0, "")
    assert run(capsys, *command, "-o", str(path)) == (0, "", f"written: {path}, {path}.json\n")
    header, *shown = (line.split() for line in printed.splitlines())
    names, *rows = (line.split(",") for line in path.read_text().splitlines())
    assert names == [*header, *(f"{name}_radius" for name in header[1:])]
    assert [row[: len(header)] for row in rows] == shown
    exact = polhode.reference(CASE).at([0, 1], digits=60)
    for row, true in zip(rows, exact, strict=True):
        for text, radius, x in zip(row[1:], row[len(header) :], true, strict=False):
            assert abs(Fraction(text) - exactly(x)) <= Fraction(radius) < Fraction(1, 10**30)
    assert json.loads(Path(f"{path}.json").read_text())["reference"] == "kovalevskaya"


@pytest.mark.parametrize(
    ("name", "last", "digits"),
    [
        ("lagrange/nutation", 40, 10),
        ("lagrange/nutation", 2, 60),  # ten times too many: looks on the way were taken for steps
        ("kovalevskaya/generic", 50, 15),
        ("general/asymmetric-regular", 20, 10),
        ("euler/rest", 1000, 10),
        pytest.param("general/asymmetric-chaotic", 100, 15, marks=pytest.mark.slow),
    ],
)
def test_a_proof_takes_about_as_many_steps_as_are_foretold(name, last, digits):
    """What a step costs is measured by the clock, how many there are is not."""
    scene = replace(polhode.load(name), outputs=())
    steps = polhode.certify(scene, at=[last], digits=digits).steps
    (forecast,) = Task(StartBox(scene), [Fraction(last)], digits).forecasts
    assert steps / 3 < forecast.steps < 3 * steps
