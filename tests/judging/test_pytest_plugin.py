"""The fixture of pytest, in a session of its own."""

from __future__ import annotations

import subprocess
import sys

_TESTS = """
import polhode

RUN = polhode.integrate("lagrange/nutation", at=[1, 2])

def test_right(assert_digits):
    assert assert_digits(RUN, "lagrange/nutation", at_least=13).worst > 13

def test_wrong(assert_digits):
    assert_digits(lambda t: RUN.states[0] + 1e-6, "lagrange/nutation", 9, at=[1])

def test_that_asks_for_nothing():
    pass
"""


def test_digits_stand_at_the_end_and_in_the_xml(tmp_path):
    (tmp_path / "test_mine.py").write_text(_TESTS)
    ran = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "--junitxml=x.xml",
            "-p",
            "no:cacheprovider",
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert ran.returncode == 1
    assert "1 failed, 2 passed" in ran.stdout
    assert "6.00 correct digits at t = 1, where at least 9 are wanted" in ran.stdout
    told = [
        line for line in ran.stdout.splitlines() if "::" in line and "correct digits of" in line
    ]
    assert len(told) == 1
    assert told[0].startswith("test_mine.py::test_right: 1")
    assert told[0].endswith("correct digits of lagrange/nutation")
    assert (tmp_path / "x.xml").read_text().count('name="correct_digits"') == 1


def test_a_session_that_does_not_ask_imports_nothing_more():
    program = (
        "import sys, polhode.pytest_plugin; print(sorted({'numpy', 'heyoka'} & {*sys.modules}))"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert ran.stdout == "[]\n"
