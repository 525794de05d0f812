"""Checkers in other languages: one algorithm, the same digits in each of them."""

from __future__ import annotations

import csv
import random
import re
import shutil
import subprocess
import sys
from fractions import Fraction

import pytest
from test_benchmark import FOLDER

import polhode
from polhode.cli import main

TOP = "lagrange-nutation"
CASE = "lagrange/nutation"


@pytest.fixture(scope="module")
def checkers(tmp_path_factory):
    """Commands, by language, of those that this machine has."""
    commands = {"Python": [sys.executable, "-I", str(FOLDER / "check.py")]}
    if cc := shutil.which("cc") or shutil.which("gcc"):
        built = tmp_path_factory.mktemp("c") / "check"
        flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O1"]
        subprocess.run([cc, *flags, str(FOLDER / "check.c"), "-o", str(built), "-lm"], check=True)
        commands["C"] = [str(built)]
    if node := shutil.which("node"):
        commands["JavaScript"] = [node, str(FOLDER / "check.js")]
    return commands


def run(command, *arguments):
    return subprocess.run([*command, *map(str, arguments)], capture_output=True, text=True)


def judged(checkers, path, *more, top=TOP):
    """What all of them print, and their exit code, which are the same."""
    ran = {k: run(command, FOLDER / f"{top}.csv", path, *more) for k, command in checkers.items()}
    plain = ran["Python"]
    for name, result in ran.items():
        assert result.returncode == plain.returncode, (name, result.stderr)
        assert numbers(result.stdout) == pytest.approx(numbers(plain.stdout), abs=0.011), name
        assert (result.stderr == "") == (plain.stderr == ""), name
    return plain


def numbers(text):
    return [float(x) for x in re.findall(r"[-+.\d]+(?:e[-+]?\d+)?", text.replace("missing", "-9"))]


def table(path, rows, header=None):
    with open(path, "w", newline="") as file:
        csv.writer(file).writerows([header or HEADER, *rows])
    return path


with open(FOLDER / f"{TOP}.csv", newline="") as file:
    HEADER, *ROWS = csv.reader(file)


@pytest.mark.usefixtures("compiled_as_for_users")
def test_a_run_in_double_has_the_digits_that_compare_tells(checkers, tmp_path):
    path = tmp_path / "x.csv"
    at = ",".join(row[0] for row in ROWS)
    command = ["run", CASE, "--at", at, "--outputs", "attitude", "-o", str(path)]
    assert main(command) == 0
    printed = judged(checkers, path, 13)
    assert printed.returncode == 0
    judgement = polhode.compare(path, CASE)
    own = [numbers(line)[1:] for line in printed.stdout.splitlines()[2:-1]]
    assert [x for x, _ in own] == pytest.approx([*judgement.digits][1:], abs=0.02)
    assert [x for _, x in own] == pytest.approx([*judgement.part_digits["attitude"]][1:], abs=0.02)


@pytest.mark.parametrize("power", [3, 15, 16, 49])
def test_errors_of_any_size_are_told(checkers, tmp_path, power):
    """In one number of the state and one of the attitude, or of both together."""
    generator = random.Random(power)
    rows = [[*row] for row in ROWS]
    for row in rows[1:]:
        for k in (generator.randrange(4, 7), generator.randrange(7, 11)):
            moved = Fraction(row[k]) + generator.choice([1, -1]) * Fraction(1, 10**power)
            row[k] = f"{float(moved):.17g}" if power < 12 else decimal(moved)
    printed = judged(checkers, table(tmp_path / "x.csv", rows), power - 1)
    assert printed.returncode == 0
    for line in printed.stdout.splitlines()[2:-1]:
        assert numbers(line)[1:] == pytest.approx([power, power], abs=0.06)


def decimal(x):
    return f"{'-' * (x < 0)}{abs(x) // 1}.{round((abs(x) % 1) * 10**60):060d}"


def test_what_is_right_has_fifty_digits_however_it_is_written(checkers, tmp_path):
    rows = [[row[0], *(f" {scientific(x)}" for x in row[1:])] for row in reversed(ROWS)]
    order = [2, 0, 1, 3, 4, 5, 6, 10, 9, 8, 7]
    rows = [[row[k] for k in order] + ["7"] for row in rows]
    header = [*(HEADER[k] for k in order), "time of the processor"]
    path = tmp_path / "x.csv"
    table(path, rows, header)
    path.write_text(path.read_text().replace("\n", "\r\n"))
    printed = judged(checkers, path, 50)
    assert printed.returncode == 0
    assert "worst 50.00 correct digits" in printed.stdout


def scientific(x):
    """Of a decimal: another way to write it."""
    sign, body = ("-", x[1:]) if x.startswith("-") else ("+", x)
    whole, _, rest = body.partition(".")
    return f"{sign}{whole}{rest[:7]}.{rest[7:]}E-7"


@pytest.mark.parametrize("change", ["the other quaternion", "no attitude"])
def test_another_quaternion_or_none_changes_nothing(checkers, tmp_path, change):
    rows, header = [row[:7] for row in ROWS], HEADER[:7]
    if change == "the other quaternion":
        rows, header = [[*row[:7], *map(minus, row[7:])] for row in ROWS], HEADER
    printed = judged(checkers, table(tmp_path / "x.csv", rows, header))
    assert "worst 50.00" in printed.stdout
    assert printed.stdout.splitlines()[3].split() == ["2", "50.00", "50.00"][: 1 + len(header) // 5]


def minus(x):
    return x[1:] if x.startswith("-") else f"-{x}"


def test_a_time_that_is_missing_is_told_and_fails(checkers, tmp_path):
    printed = judged(checkers, table(tmp_path / "x.csv", [*ROWS[1:5], *ROWS[6:]]), 5)
    assert printed.returncode == 1
    assert [line for line in printed.stdout.splitlines() if "missing" in line] == ["15  missing"]


def test_too_few_digits_fail(checkers, tmp_path):
    rows = [[*row] for row in ROWS]
    rows[3][1] = "0.1"
    path = table(tmp_path / "x.csv", rows)
    assert [judged(checkers, path, *least).returncode for least in ((9,), ())] == [1, 0]


@pytest.mark.parametrize(
    "spoil",
    [
        lambda text: text.replace("gamma1", "g1"),
        lambda text: text.replace("\n1,", "\n1,nan,", 1),
        lambda text: text.replace("0.", "o.", 1),
        lambda text: text.replace("\n2,", "\n2,,", 1),
        lambda text: text.rpartition(",")[0] + "\n",
        lambda text: "",
        None,  # no file
    ],
)
def test_bad_input_is_exit_code_2(checkers, tmp_path, spoil):
    path = tmp_path / "x.csv"
    if spoil is not None:
        path.write_text(spoil((FOLDER / f"{TOP}.csv").read_text()))
    printed = judged(checkers, path)
    assert printed.returncode == 2
    assert "Traceback" not in printed.stderr
