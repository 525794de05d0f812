"""The study speed: programs as processes, what becomes of their answers, curves and verdicts.

No test depends on how long anything takes.
"""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import polhode
from polhode.equations.forms import principal
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Functions
from polhode.peers import field, process
from polhode.studies.processes import ask
from polhode.studies.speed import draws, number_types, page, refined
from polhode.studies.speed.work_precision import WorkPoint, frontier, seconds_at

FLOATS = Functions(0.0, math.sin, math.cos, math.sqrt)


# the equations that the peers take


@pytest.mark.slow
@settings(deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_the_peers_take_the_equations_that_polhode_integrates(state):
    for case in ("general/asymmetric-regular", "lagrange/nutation", "euler/largest-axis"):
        k = {n: to_double(x) for n, x in principal.coefficients(polhode.load(case).body).items()}
        c = [k.get(name, 0.0) for name in field.TERMS]
        wanted = principal.field(state, k, FLOATS)
        found = field.of_pattern([x != 0 for x in c])(*state, c)
        size = max(1.0, *map(abs, wanted))
        assert all(abs(x - y) <= 8 * 2**-52 * size for x, y in zip(found, wanted, strict=True))


# processes


@pytest.fixture
def peer(tmp_path, monkeypatch):
    """Make a program of a body of Python and run it twice, the second time at 1e-9."""
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=":")

    def run(name, body, limit=20.0):
        text = f"import os, time\ndef prepared(present, method):\n    return run\n{body}\n"
        (tmp_path / f"{name}.py").write_text(text)
        one = draws.draw("euler", 0, 2, 2)
        job = {"module": name, "method": "", "present": [], "runs": [*map(one.run, (1e-6, 1e-9))]}
        return ask(process.__name__, job, limit, tmp_path / "cache")

    return run


DOUBLED = "def run(top, start, times, tol):\n    {}\n    return 2 * start[None]"


def test_a_program_that_answers(peer):
    answers, fault = peer("fine", DOUBLED.format("pass"))
    start = draws.draw("euler", 0, 2, 2).start
    assert fault == ""
    assert [answer["state"] for answer in answers] == [[*2 * start]] * 2


@pytest.mark.parametrize(
    ("name", "body", "reason", "last"),
    [
        ("absent", "import no_such_package", "No module named 'no_such_package'", None),
        ("dying", DOUBLED.format("os._exit(3) if tol < 1e-7 else 0"), "ended with 3", "state"),
        ("raising", DOUBLED.format("1 / (tol > 1e-7)"), "", "failed"),
    ],
)
def test_a_program_that_fails_leaves_what_it_had_and_says_why(peer, name, body, reason, last):
    answers, fault = peer(name, body)
    assert reason in fault
    assert (fault == "") == (reason == "")
    assert [*answers[-1]] == [last] if answers else last is None
    assert last != "failed" or answers[-1]["failed"] == "ZeroDivisionError: division by zero"


@pytest.mark.slow
def test_a_program_that_takes_too_long_is_stopped_and_keeps_what_it_had(peer):
    answers, fault = peer("sleeping", DOUBLED.format("time.sleep(60 * (tol < 1e-7))"), 9.0)
    assert "stopped after 9 s" in fault
    assert len(answers) == 1


# curves


def test_frontier_and_seconds_between_its_points():
    marks = [WorkPoint(2, 1), WorkPoint(4, 4), WorkPoint(3, 9), WorkPoint(8, 16)]
    assert frontier(marks) == [WorkPoint(2, 1), WorkPoint(4, 4), WorkPoint(8, 16)]
    for digits, seconds in ((1, 1), (3, 2), (6, 8), (8, 16)):
        assert seconds_at(marks, digits) == pytest.approx(seconds, rel=1e-15)
    assert seconds_at(marks, 8.1) is None


# the study


def test_a_peers_process_imports_nothing_else_of_polhode():
    """Nor does ``import polhode`` by itself, which reads a table of what to load when asked."""
    code = (
        "import sys, polhode; package = {*sys.modules}; "
        "import polhode.peers.bare_heyoka, polhode.peers.cyrk, polhode.peers.scipy_ode; "
        "import polhode.peers.splitting, polhode.peers.process; "
        "own = [m for m in sys.modules if m.partition('.')[0] in ('polhode', 'numpy', 'heyoka')]; "
        "print(*(m for m in own if m in package)); print(*(m for m in own if m not in package))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    package, more = (line.split() for line in done.stdout.splitlines())
    assert package == ["polhode"]
    assert all(m.startswith("polhode.peers") for m in more)


def test_a_number_type_has_its_digits_and_steps_at_each_tolerance():
    motion = number_types.SpeedMotion("short", "general/asymmetric-regular", 2, "regular")
    double, wide = number_types.WAYS[0], number_types.WAYS[2]
    row = number_types.row(motion, [double, wide], quick=True)
    assert [way["method"] for way in row["methods"]] == ["polhode double", "polhode extended"]
    for way, (least, most) in zip(row["methods"], ((14.5, 16), (17.5, 19.3)), strict=True):
        points = {point["tol"]: point for point in way["points"]}
        assert least < points[min(points)]["digits"] <= most
        assert points[max(points)]["digits"] < least - 1
        assert points[max(points)]["steps"] > points[min(points)]["steps"]  # of a lower order


def test_refined_runs_stand_beside_heyokas_own_steps():
    (row,) = [refined._row(replace(refined.CONTESTS[0], end=4))]
    assert row["refined"]["method"] == "refined"
    assert row["taylor"]["method"] == "taylor"
    assert 33.5 < row["refined"]["digits"] < 37
    assert 32 < row["taylor"]["digits"] < 34.5
    assert abs(row["agreement"] - row["taylor"]["digits"]) < 1
    assert row["estimate"] > 10 ** -row["refined"]["digits"]
    empty = {"cells": [], "first": [], "motions": [], "without": [], "once_above": 0.1}
    told = page.facts(empty | {"refined": [row, {**row, "gain": 20.0}]})
    assert told["refined_time"] == f"0.050 to {1 / row['gain']:.3f}"
    assert page.facts(empty)["refined_time"] == "–"
