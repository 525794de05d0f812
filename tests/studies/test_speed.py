"""The study speed: peers as processes, what becomes of their answers, curves and verdicts.

No test depends on how long anything takes.
"""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from polhode.equations.forms import principal
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.scalars import Functions
from polhode.peers import field
from polhode.studies import peer_processes
from polhode.studies.peer_processes import Method, Task
from polhode.studies.speed import contenders, page, refined
from polhode.studies.speed.work_precision import WorkPoint, frontier, seconds_at

SHORT = contenders.SpeedMotion("short", "general/asymmetric-regular", 2, "regular")
FLOATS = Functions(0.0, math.sin, math.cos, math.sqrt)


# the equations that the peers take


@settings(deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_the_peers_take_the_equations_that_polhode_integrates(state):
    for case in ("general/asymmetric-regular", "lagrange/nutation", "euler/largest-axis"):
        body = peer_processes.plain_scene(case, (Fraction(1),)).body
        k = {name: to_double(x) for name, x in principal.coefficients(body).items()}
        c = tuple(k.get(name, 0.0) for name in field.TERMS)
        wanted = principal.field(state, k, FLOATS)
        found = list(field.returning(c)(*state))
        filled = [0.0] * 6
        field.filling(state, filled, c)
        size = max(1.0, *map(abs, wanted))
        assert all(abs(x - y) <= 8 * 2**-52 * size for x, y in zip(found, wanted, strict=True))
        assert filled == found


# processes


@pytest.fixture
def peer(tmp_path, monkeypatch):
    """Make a driver of a body of Python and run it on the short motion."""
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=":")

    def run(name, load="return 'peer 1'", build="", limit=20.0, tolerances=(1e-6, 1e-9)):
        (tmp_path / f"{name}.py").write_text(
            "import os, sys, time\n"
            "from polhode.peers.protocol import Solution, serve\n"
            f"def load():\n    {load}\n"
            f"def build(problem):\n    {build or 'pass'}\n"
            "    def solve(tol):\n"
            "        rows = [[(k + 1) * x for x in problem.start] for k in range(11)]\n"
            "        return answer(rows, tol, problem)\n"
            "    return solve\n"
            "def answer(rows, tol, problem):\n"
            f"    {_ANSWERS.get(name, 'return Solution(rows, 7)')}\n"
            "serve(load, build)\n"
        )
        method = Method(name, name, "", tolerances, limit=limit)
        return peer_processes.run_all(
            [Task(method, contenders.scene_of(SHORT))], tmp_path / "cache"
        )[0]

    return run


_ANSWERS = {
    "unchanged": "return Solution([problem.start] * 11)",
    "half_stale": "return Solution(rows[:5] + [rows[4]] * 6 if tol < 1e-7 else rows)",
    "raising": "if tol < 1e-7: raise ArithmeticError('step too small')\n    return Solution(rows)",
    "infinite": "return Solution([[float('nan')] * 6] * 11)",
    "short": "return Solution(rows[:7])",
    "dying": "os._exit(3) if tol < 1e-7 else 0\n    return Solution(rows)",
    "sleeping": "time.sleep(60) if tol < 1e-7 else 0\n    return Solution(rows)",
}


def test_a_peer_that_answers(peer):
    curve = peer("fine")
    assert (curve.status, curve.reason, curve.version) == ("ok", "", "peer 1")
    assert [len(point.seconds) for point in curve.points.values()] == [4, 4]  # two rounds of two
    assert len(curve.compiling) == 2
    start = contenders.scene_of(SHORT).start
    first = curve.points[1e-6].rows[0]
    assert first == [DOUBLE.rounded(x) for x in start]


def test_a_missing_peer_stays_in_the_table(peer):
    curve = peer("absent", load="import no_such_package")
    assert curve.status == "missing"
    assert "no_such_package" in curve.reason
    assert not curve.points


@pytest.mark.parametrize(
    ("name", "status", "said", "good"),
    [
        ("unchanged", "stale", "left unchanged", 0),
        ("half_stale", "stale", "at tolerance 1e-09", 1),
        ("raising", "failed", "ArithmeticError: step too small", 1),
        ("infinite", "failed", "not finite", 0),
        ("short", "failed", "7 states at 11 times", 0),
        ("dying", "failed", "process ended with 3", 1),
        ("unbuilt", "failed", "at tolerance 1e-06, 1e-09: RuntimeError: no compiler", 0),
    ],
)
def test_a_peer_that_fails_stays_in_the_table_with_the_reason(peer, name, status, said, good):
    curve = peer(name, build="raise RuntimeError('no compiler')" if name == "unbuilt" else "")
    assert curve.status == status
    assert said in curve.reason
    assert sum(point.rows is not None for point in curve.points.values()) == good
    assert name == "unbuilt" or set(curve.points) == {1e-6, 1e-9}


@pytest.mark.slow
def test_a_peer_that_takes_too_long_is_stopped_and_keeps_what_it_had(peer):
    curve = peer("sleeping", limit=9.0)
    assert curve.status == "failed"
    assert "stopped after 9 s" in curve.reason
    assert curve.points[1e-6].rows is not None


def test_rows_are_stale_that_stand_still_or_come_back_to_the_start():
    start, moved = [1, 2], [1, 3]
    for rows in ([start, start], [start, moved, moved], [start, moved, start]):
        assert peer_processes.stale(rows)
    assert not peer_processes.stale([start, moved, [2, 3]])


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
        "import polhode.peers.bare_heyoka, polhode.peers.cyrk, polhode.peers.scipy_python; "
        "import polhode.peers.splitting, polhode.studies.speed.first_result; "
        "own = [m for m in sys.modules if m.partition('.')[0] in ('polhode', 'numpy', 'heyoka')]; "
        "print(*(m for m in own if m in package)); print(*(m for m in own if m not in package))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    package, more = (line.split() for line in done.stdout.splitlines())
    assert package == ["polhode"]
    assert all(m.startswith(("polhode.peers", "polhode.studies")) for m in more)


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
