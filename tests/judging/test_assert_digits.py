"""Assertions of correct digits, as other programs' tests use them."""

from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as ET

import pytest

import polhode
from shared.tables import of_run

SCENE = "lagrange/nutation"


@pytest.fixture(scope="module")
def run():
    return polhode.integrate(SCENE)


def test_a_function_of_t_is_asked_at_the_times(run):
    score = polhode.testing.assert_digits(lambda t: run(t), SCENE, at_least=12, at=[1, "0.25"])
    assert [float(t) for t in score.times] == [1, 0.25]


def test_the_error_tells_the_first_wrong_time_and_the_judgement(run):
    def mine(t):
        return run(t) + (1e-6 if t > 1.5 else 0)

    with pytest.raises(AssertionError) as error:
        polhode.testing.assert_digits(mine, SCENE, at_least=9, at=[1, 2, 3])
    first, *rest = str(error.value).splitlines()
    assert first == "6.00 correct digits at t = 2, where at least 9 are wanted"
    assert "\n".join(rest).startswith("t  correct digits")
    assert "fewer than double precision allows" in str(error.value)


def test_another_convention_is_wrong_unless_it_is_allowed(run):
    columns = of_run(run)
    columns |= {"p": columns["q"], "q": columns["p"]}
    with pytest.raises(AssertionError, match="correct digits at t = "):
        polhode.testing.assert_digits(columns, SCENE, at_least=9)
    score = polhode.testing.assert_digits(columns, SCENE, at_least=9, as_it_stands=False)
    assert score.reading == "omega p q r = q p r"


# -- The fixture of pytest, in a session of its own


_TESTS = """
import polhode

RUN = polhode.integrate("lagrange/nutation", at=[1, 2])

def test_right(assert_digits):
    assert assert_digits(RUN, "lagrange/nutation", at_least=13).worst > 13

def test_wrong(assert_digits):
    assert_digits(lambda t: RUN.states[0] + 1e-6, "lagrange/nutation", 9, at=[1])

def test_two(assert_digits):
    for _ in range(2):
        assert_digits(RUN, "lagrange/nutation", 13)

def test_that_asks_for_nothing():
    pass
"""


def session(folder, *options, tests=_TESTS):
    """What pytest prints of the tests."""
    (folder / "test_mine.py").write_text(tests)
    without = ("-p", "no:cacheprovider", "-p", "no:hypothesispytest")
    command = [sys.executable, "-m", "pytest", "-q", *without, *options]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert ran.returncode == 1, ran.stdout
    return ran.stdout


@pytest.mark.slow
def test_digits_stand_at_the_end_and_in_the_xml(tmp_path):
    printed = session(tmp_path, "--junitxml=x.xml", "-W", "error", "-n", "1")
    assert "1 failed, 3 passed" in printed
    assert "6.00 correct digits at t = 1, where at least 9 are wanted" in printed
    end = printed.partition("= correct digits =")[2].splitlines()
    lines = sorted(line for line in end if " correct digits of lagrange/nutation" in line)
    names = ["test_right", "test_two", "test_two", "test_wrong"]
    assert [line.partition(":: ")[0].split("::")[1].partition(":")[0] for line in lines] == names
    assert lines[-1] == "test_mine.py::test_wrong: 6.00 correct digits of lagrange/nutation"
    assert all(13 < float(line.split()[1]) <= 16 for line in lines[:-1])
    written = {
        case.get("name"): [
            p.get("value") for p in case.iter("property") if p.get("name") == "correct_digits"
        ]
        for case in ET.parse(tmp_path / "x.xml").iter("testcase")
    }
    assert written.pop("test_wrong") == ["6.0"]
    counts = {name: len(digits) for name, digits in written.items()}
    assert counts == {"test_right": 1, "test_two": 2, "test_that_asks_for_nothing": 0}


def test_a_session_that_does_not_ask_imports_nothing_more():
    code = "import sys, polhode.pytest_plugin; print(sorted({'numpy', 'heyoka'} & {*sys.modules}))"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ran.stdout == "[]\n"


_WRONG = """
from polhode import testing

def test_few(assert_digits):
    assert_digits(lambda t: [1, 2, 3, 0, 0, 1], "lagrange/nutation", 9, at=[1])

def test_bad(assert_digits):
    assert_digits(lambda t: [float("nan")] * 6, "lagrange/nutation", 9, at=[1])

def mine(t):
    return testing.order_of(None, "lagrange/nutation")

def test_own_function(assert_digits):
    assert_digits(mine, "lagrange/nutation", 9, at=[1])
"""


@pytest.mark.slow
def test_what_fails_shows_the_users_line_and_no_source_of_polhode(tmp_path):
    printed = session(tmp_path, "-p", "no:xdist", tests=_WRONG)
    assert "3 failed" in printed
    few, bad, own = printed.partition("FAILURES")[2].split("________ test_")[1:]
    for output in (few, bad):
        assert "polhode/" not in output
        assert output.count("test_mine.py:") == 1
    assert "return testing.order_of(None" in own  # a fault of the user's function is shown, too


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["0", "2"])
def test_a_page_has_each_judgement_once_and_says_which_failed(tmp_path, workers):
    session(tmp_path, "--polhode-report=r.md", "-n", workers)
    lines = (tmp_path / "r.md").read_text().splitlines()
    rows = sorted(line.split(" | ")[:3] for line in lines if line.startswith("| test_mine"))
    names = ["test_right", "test_two", "test_two", "test_wrong"]
    assert [row[0].partition("::")[2] for row in rows] == names
    assert [row[1] for row in rows] == ["● passed"] * 3 + ["○ failed"]
    assert rows[-1][2] == "6.00"


def test_a_page_that_cannot_be_written_is_refused_before_the_tests(tmp_path):
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--polhode-report=r.txt"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert ran.returncode == 4
    assert "--polhode-report: r.txt: -o: expected a name that ends in .html or .md" in ran.stderr
