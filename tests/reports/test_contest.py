"""The contest of the study speed: who reaches what, ratios, and what is claimed of them.

No test depends on how long anything takes.
"""

from __future__ import annotations

import json
import pickle
import warnings
from collections.abc import Iterable
from importlib.util import find_spec
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

import contest
import kit
import make
import polhode
import programs
import speed
import tops
from kit import Only
from peers import process, scipy_ode
from peers.process import ask
from programs import ENGINE, OURS, RUN
from tops import DRAWS, Cell

PEER = "CyRK VERN8"


# the motions


def test_every_kind_has_as_many_bodies_as_draws_and_patterns_hold_them_all():
    for kind in tops.KINDS:
        rows = [tops.draw(kind, k, 1, 2).top.coefficients for k in range(DRAWS)]
        assert len({row.tobytes() for row in rows}) == DRAWS
        present = np.array(tops.present(kind))
        assert all(np.all(present | (row == 0)) for row in rows)
    assert tops.present("euler") == (True,) * 3 + (False,) * 6
    assert all(tops.present("chaotic"))


@pytest.mark.slow
def test_the_chaotic_draws_are_chaotic():
    for k in (0, DRAWS - 1):
        assert polhode.lyapunov(tops.scene_of("chaotic", k, 100, 2), 3000).verdict == "chaotic"


def judged_draw(kind, index, end=10, outputs=tops.JUDGED):
    """A draw, its times, and a function of states that tells their digits."""
    draw, true = tops.draw(kind, index, end, outputs), tops.truth(kind, index, end)
    times = np.array([float(t) for t in draw.scene.times])
    return draw, times, lambda rows: tops.digits(tops.judged(rows, outputs), true, draw.scene)


def test_the_digits_of_a_run_are_those_of_its_worst_judged_time():
    *_, digits = judged_draw("lagrange", 0)
    rows = np.array(tops.truth("lagrange", 0, 10), dtype=float)
    assert digits(rows) > 15.5
    rows[3, 5] += 1e-7
    assert abs(digits(rows) - 7) < 0.01
    assert judged_draw("lagrange", 0, outputs=2)[2](rows) > 15.5  # the end alone
    rows[7, 0] = np.nan
    assert digits(rows) == 0
    assert len(tops.judged(np.zeros((101, 6)), 101)) == tops.JUDGED
    assert len(tops.judged(np.zeros((2, 6)), 2)) == 1


def costs(program):
    """Compilers are slow."""
    marks = [pytest.mark.slow] if program.needs else []
    return pytest.param(program, id=program.name.replace(" ", "-"), marks=marks)


@pytest.mark.parametrize("program", [*map(costs, programs.PROGRAMS)])
def test_every_program_that_is_here_finds_the_motion(program):
    if any(find_spec(need) is None for need in program.needs):
        pytest.skip(f"without {program.needs}")
    kind = "kovalevskaya" if program.needs else "lagrange"
    run = program.prepared(tops.present(kind))
    for outputs in (2, 101):
        draw, times, digits = judged_draw(kind, 3, outputs=outputs)
        for tol in program.tolerances[-2:]:
            rows = run(draw.top, draw.start, times, tol)
            assert len(rows) in ((1, 2) if outputs == 2 else (101,))
            most = 19.27 if program.name == programs.WIDER else 15.96
            assert 8 < digits(rows) <= most


@pytest.mark.parametrize("program", [costs(programs.BY_NAME[name]) for name in programs.MANY])
def test_every_program_finds_the_motions_of_many_starts(program):
    """The same starts, however many; as right as a start alone, and in their order."""
    if any(find_spec(need) is None for need in program.needs):
        pytest.skip(f"without {program.needs}")
    few, many = (tops.draw("asymmetric", 2, 1, 2, n) for n in (20, 100))
    assert np.array_equal(few.start, many.start[:20])
    true, times = tops.truth("asymmetric", 2, 1, many=True), np.array([0.0, 1.0])

    def digits(ends):
        return tops.median_digits(ends[: tops.MANY_JUDGED], true, few.scene)

    run = program.prepared(tops.present("asymmetric"), many=True)
    ends = np.array(run(few.top, few.start.copy(), times, 1e-13))  # JAX's cannot be written to
    assert ends.shape == (20, 6)
    assert 11 < digits(ends) <= 15.96
    back = run(few.top, few.start[::-1].copy(), times, 1e-13)
    assert np.abs(back[::-1] - ends).max() < 1e-11
    ends[: tops.MANY_JUDGED // 2, 0] += 1e-3  # fewer than half: the median is another one's
    assert digits(ends) > 11
    ends[: tops.MANY_JUDGED // 2 + 1, 0] += 1e-3
    assert digits(ends) < 4


def test_a_start_that_is_none_is_refused():
    draw = tops.draw("lagrange", 1, 10, 11)
    with pytest.raises(polhode.BadInput):
        programs.BY_NAME[OURS].prepared(())(draw.top, draw.start * 2, np.array([0.0, 1.0]), 1e-9)


def test_the_least_of_several_calls_next_to_a_level_is_told(monkeypatch):
    near = {(0, 10.0**-k): (float(k), 1.0) for k in range(1, 16)}
    assert [tol for _, tol in contest.timed_again(near, False)] == [
        10.0**-k for k in range(13, 4, -1)
    ]
    true, seconds = tops.truth("lagrange", 0, 10), iter((0.0, 3.0, 5.0, 6.0, 8.0, 10.0))
    monkeypatch.setattr(kit, "time", SimpleNamespace(process_time=lambda: next(seconds)))
    cell = Cell("lagrange", 10, tops.JUDGED)
    cell_contest = contest._Contest(
        cell, [true], {OURS: lambda top, start, times, tol: np.array(true, float)}
    )
    cell_contest._once(OURS, 0, 1e-9)
    for _ in range(2):
        cell_contest._block(OURS, 0, 1e-9)
    (((_, tol), (digits, least)),) = cell_contest.timed_points()[OURS].items()
    assert (tol, least) == (1e-9, 1.0)
    assert digits > 15
    entered = {}
    for seconds in (2.0, 1.0, 3.0):  # of three processes, by the fastest
        contest._enter(entered, {OURS: {(0, tol): (digits, seconds)}})
    assert entered == {OURS: {(0, tol): (digits, 1.0)}}


@pytest.mark.slow
def test_a_program_that_cannot_be_prepared_is_told_and_the_others_run(monkeypatch, tmp_path):
    truths = contest._truths({"lagrange": [(cell := Cell("lagrange", 10, 2))]}, print)
    cells = [(cell, truths[cell])]
    job = {"kind": "lagrange", "cells": cells, "programs": ["broken", OURS], "patience": 0}
    job["tolerances"] = {cell: {OURS: [1e-9]}}
    answers, fault = ask(job, 60.0, tmp_path, contest._MODULE)
    failed, answer = answers
    assert fault == ""
    assert failed == {"failed": "broken", "fault": "KeyError: 'broken'"}
    assert len(answer["points"][OURS]) == DRAWS
    assert answer["faults"] == {}
    monkeypatch.setattr(contest, "ask", lambda *_: (answers, ""))
    (row,) = contest._kind(job, 1, tmp_path, print)
    assert row["faults"] == {"broken": failed["fault"]}


@pytest.mark.parametrize("lost", [0, 1, 40])
def test_what_a_stopped_process_had_answered_is_kept(lost, tmp_path):
    """Of its last answer only what is whole."""
    answers = {"state": [0.1] * 6}, {"state": [0.2] * 6}
    data = b"".join(map(pickle.dumps, answers))
    (tmp_path / "answers").write_bytes(data[: len(data) - lost])
    assert [*process._answers(tmp_path / "answers")] == [*answers][: 1 if lost else 2]


# rows


def test_a_cell_that_an_ended_process_did_not_come_to_is_held_whole_by_the_next(monkeypatch):
    """It was never held again, and its programs were called so slow that they did not reach it."""
    first, second = tops.cells("chaotic")[:2]
    answer = {"cell": first, "points": {OURS: {(0, 1e-9): (9.0, 1e-3)}}, "faults": {}}
    jobs = []

    def asked(job, *rest):
        jobs.append({**job})
        answers = [answer, answer | {"cell": second}]
        return (answers[:1], "stopped") if len(jobs) == 1 else (answers, "")

    monkeypatch.setattr(contest, "ask", asked)
    monkeypatch.setattr(contest, "row", lambda cell, points, faults: (points, faults))
    job = {"kind": "chaotic", "cells": [(first, []), (second, [])], "tolerances": {}}
    rows = contest._kind(job, contest.PROCESSES, None, lambda text: None)
    assert [{*job["tolerances"]} for job in jobs] == [
        set(),
        {first},  # without a word of the other, which is held at all of its tolerances
        {first, second},
    ]
    assert [faults for _, faults in rows] == [{}, {"process 1": "stopped"}]
    assert all(points[OURS] for points, _ in rows)


def points(digits: dict[float, float], seconds: dict[float, float], numbers=range(DRAWS)):
    return {
        (k, tol): (digits[tol], seconds[tol] * (1 + k / 100)) for k in numbers for tol in digits
    }


def stands(row):
    return [level["verdict"]["stands"] for level in row["levels"]]


REACH = {1e-5: 5.0, 1e-8: 8.0, 1e-11: 11.0, 1e-14: 14.0}


def test_a_level_is_reached_between_its_tolerances_by_nearly_all_draws_or_not_at_all():
    ours = points(REACH, {1e-5: 1.0, 1e-8: 2.0, 1e-11: 3.0, 1e-14: 4.0})
    few = points(REACH, dict.fromkeys(REACH, 0.1), range(6))
    slow = points(REACH, dict.fromkeys(REACH, 8.0))
    assert contest.seconds_of(ours, 8.0)[0] == pytest.approx(2)
    row = contest.row(Cell("euler", 10, 2), {OURS: ours, "few": few, PEER: slow}, {})
    for level in row["levels"]:
        by_name = {row["program"]: row for row in level["programs"]}
        assert by_name["few"]["reached"] == 6
        assert by_name["few"]["ratio"] is None  # six draws decide nothing
        assert level["verdict"]["stands"] == "ahead"
        assert level["verdict"]["best"] == PEER
        assert level["verdict"]["ratio"][1] > 1
    short = points({1e-5: 5.0, 1e-8: 8.0}, {1e-5: 0.1, 1e-8: 0.2})
    row = contest.row(Cell("euler", 10, 2), {OURS: short, PEER: slow}, {})
    assert stands(row) == ["ahead", "not reached", "not reached"]
    row = contest.row(Cell("euler", 10, 2), {OURS: ours, PEER: short, ENGINE: few, RUN: slow}, {})
    assert stands(row) == ["behind", "alone", "alone"]


def test_what_is_far_behind_at_every_level_is_not_held_again():
    ours = points(REACH, dict.fromkeys(REACH, 1.0))
    far = points(REACH, dict.fromkeys(REACH, 10.2))
    close = points(REACH, dict.fromkeys(REACH, 30.0) | {1e-5: 9.8, 1e-8: 9.8})  # at 6 digits
    lost = points({1e-5: 2.0}, {1e-5: 50.0})  # reaches no level: nothing is known of it
    every = {OURS: ours, "far": far, PEER: close, "lost": lost}
    again = contest.held_again(every, every=False)
    assert again["far"] == []
    assert again["lost"] == [1e-5]
    assert again[OURS] == again[PEER] == [1e-14, 1e-11, 1e-8, 1e-5][::-1]
    ours[0, 1e-3] = 3.0, 1.0
    again = contest.held_again(every, every=True)
    assert again["far"] == []
    assert again[OURS] == [1e-3, *sorted(REACH, reverse=True)]


def test_a_panel_of_the_diagram_has_the_medians_of_each_tolerance_and_what_no_other_beats():
    """Seconds of the draws are 1, 1.01, ... 1.07 times as many."""
    (drawn,) = [cell for cell in tops.cells("euler") if cell.drawn]
    assert drawn.name == "euler t=100 outputs=101"
    assert [cell.name for cell in tops.cells("asymmetric") if cell.drawn][1:] == [
        "asymmetric t=10 starts=10000"
    ]
    assert not [cell for cell in tops.cells("fast") if cell.drawn]
    ours = points(REACH, dict(zip(REACH, (2.0, 4.0, 6.0, 8.0), strict=True)))
    few = points(REACH, dict.fromkeys(REACH, 0.1), range(6))
    vern = points({1e-5: 5.0, 1e-8: 8.0}, {1e-5: 0.2, 1e-8: 8.0})
    dop = points({1e-5: 4.0, 1e-8: 9.0}, {1e-5: 0.6, 1e-8: 6.0})
    row = contest.row(drawn, {OURS: ours, RUN: few, PEER: vern, "CyRK DOP853": dop}, {})
    curves = row["curves"]
    assert curves[OURS] == [[5.0, 2.07], [8.0, 4.14], [11.0, 6.21], [14.0, 8.28]]
    assert RUN not in curves  # six draws of eight
    lines = speed.lines(curves)
    assert [*lines] == ["polhode, double", "CyRK"]
    assert lines["CyRK"] == [(0.207, 1e-5), (6.21, 1e-9)]  # of both methods
    assert "curves" not in contest.row(Cell("euler", 10, 2), {OURS: ours}, {})
    assert speed.svgs({"cells": [row], "motions": []}).keys() == {"speed"}


def test_what_is_judged_has_the_start_of_the_draw_itself_and_what_is_timed_another():
    starts = []

    def run(top, start, times, tol):
        starts.append(start.tolist())
        return rows

    true, cell = tops.truth("lagrange", 0, 10), Cell("lagrange", 10, tops.JUDGED)
    rows = np.array(true, float)
    cell_contest = contest._Contest(cell, [true], {OURS: run})
    cell_contest._once(OURS, 0, 1e-9)
    for _ in range(3):
        cell_contest._block(OURS, 0, 1e-9)
    own = cell_contest.draws[0].start.tolist()
    assert starts[0] == starts[1] == own  # the first call is not timed
    assert own not in starts[2:]
    assert 20 < len(starts) <= 2 + 3 * 30  # short calls are timed in blocks
    assert all(a != b for a, b in pairwise(starts[2:]))
    assert np.allclose(starts[2:], own, rtol=0, atol=16 * 2.0**-50)


def test_an_extended_run_starts_from_the_draws_decimals():
    """Of a motion that multiplies no error it has more digits than the start in doubles would."""
    run = programs.BY_NAME[programs.WIDER].prepared(())
    draw, times, digits = judged_draw("euler", 0, outputs=101)
    rows = run(draw.top, draw.start, times, 2.0**-63)
    assert 17 < digits(rows) < 19.3
    assert digits(rows.astype(float)) <= 15.96
    start = draw.start.copy()
    start[0] += 2.0**-50
    assert 13 < digits(run(draw.top, start, times, 2.0**-63)) < 16


def test_a_tie_is_no_win():
    """The interval of the median holds 1 where draws disagree."""
    own = dict.fromkeys(range(DRAWS), 1.0)
    apart = {k: 0.5 if k % 2 else 2.0 for k in range(DRAWS)}
    middle, least, most = contest.ratio(apart, own, "seed")
    assert least < 1 < most
    standing = [
        {"program": OURS, "reached": 8, "ratio": None},
        {"program": PEER, "reached": 8, "ratio": [middle, least, most]},
    ]
    assert contest.verdict(standing)["stands"] == "even"
    assert contest.ratio(dict.fromkeys(range(6), 2.0), own, "seed") is None
    assert contest.ratio(own, own, "seed") == [1, 1, 1]
    assert contest.ratio(apart, own, "seed") == contest.ratio(apart, own, "seed")


# claims


def synthetic(factor: float, cells: Iterable[Cell]) -> dict:
    """Rows as the study gives them, the peer's times being ours times a factor."""
    ours = points(REACH, dict.fromkeys(REACH, 1e-3))
    theirs = points(REACH, dict.fromkeys(REACH, 1e-3 * factor))
    rows = [
        contest.row(cell, {OURS: ours, RUN: theirs, ENGINE: ours, PEER: theirs}, {"x": "failed so"})
        for cell in cells
    ]
    clock = {"wall": 0.5, "processor": 0.4}
    first = [{"program": OURS, "cold": clock, "warm": clock, "fault": ""}]
    rest = {"once_above": 0.1, "programs": [OURS], "motions": [], "refined": []}
    return json.loads(json.dumps({"first": first, "cells": rows, **rest}))


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_what_the_page_counts_follows_from_the_rows(factor):
    """Of one kind of motion; each length and level has a row, and the summary a cell."""
    results = synthetic(factor, tops.cells("chaotic")[1::3])
    tables, word = make.tables("speed", results), {2.0: "ahead", 0.5: "behind"}[factor]
    for name, many in (("single", False), ("many", True)):
        shown = [row[:2] + row[3:7] for row in tables[name].rows]
        cells = sorted(
            (x["starts"], x["outputs"], x["end"], Cell(*[*x.values()][:4]).name.partition(" ")[2])
            for x in results["cells"]
            if (x["starts"] > 0) == many
        )
        said = f"1 {word}", PEER, f"{factor:.2f}", "1.00"
        assert shown == [(x[-1], f"{level:g}", *said) for x in cells for level in contest.LEVELS]
    cell = f"**{factor:.2f}** {PEER}" if factor > 1 else f"{factor:.2f} {PEER}"
    held = {(x["starts"], x["outputs"], x["end"]) for x in results["cells"]}
    assert [row[0] for row in tables["summary"].rows] == [
        f"t = {end}, " + (f"{starts} starts" if starts else f"{outputs} outputs")
        for starts, outputs, end in sorted(held)
    ]
    assert {x for row in tables["summary"].rows for x in row[1:]} == {cell}


# the study


def test_a_program_that_is_not_installed_is_left_out_and_named(monkeypatch):
    monkeypatch.setattr(programs, "find_spec", lambda need: None if need == "CyRK" else True)
    results = speed.rows(False, print, Only(("no such row",)))
    assert OURS in results["programs"]
    missing = [p.name for p in programs.PROGRAMS if p.name.startswith("CyRK")]
    assert speed.facts(results)["without"] == ", ".join(missing)


def test_polhode_is_not_alone_where_no_other_was_run():
    """It was called so where others were not installed, and with --quick."""
    ours = points(REACH, dict.fromkeys(REACH, 1e-3))
    rows = [contest.row(cell, {OURS: ours, ENGINE: ours}, {}) for cell in tops.cells("chaotic")]
    tables = make.tables("speed", {**synthetic(1.0, []), "cells": rows})
    assert {word for row in rows for word in stands(row)} == {"not run"}
    assert {x for row in tables["summary"].rows for x in row[1:]} == {"others not run"}
    assert {row[3] for row in tables["single"].rows} == {"1 not run"}
    lost = {OURS: ours, PEER: {}}  # it was run, and reached nothing
    assert stands(contest.row(Cell("euler", 10, 2), lost, {})) == ["alone"] * 3


@pytest.mark.slow
@pytest.mark.parametrize("method", ["LSODA", "DOP853"])
def test_scipy_takes_its_steps_in_compiled_code(method, monkeypatch):
    """solve_ivp takes the same steps in Python, many times as long for the same error."""
    integrate = pytest.importorskip("scipy.integrate")
    pytest.importorskip("numba")
    run = programs.BY_NAME[f"SciPy {method}"].prepared(tops.present("lagrange"))
    monkeypatch.setattr(integrate, "solve_ivp", None)
    draw, times, digits = judged_draw("lagrange", 3, outputs=101)
    runs = [run(draw.top, draw.start.copy(), times, 1e-11) for _ in range(2)]
    assert np.array_equal(*runs)  # no call goes on where the one before ended
    assert 8 < digits(runs[0]) < 15
    monkeypatch.setattr(scipy_ode, "_MOST_STEPS", 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # SciPy's own word
        with pytest.raises(ArithmeticError):
            run(draw.top, draw.start.copy(), times[[0, -1]], 1e-12)


def a_small_contest_of_many_starts_from_end_to_end():
    results = speed.rows(True, print, Only(("asymmetric t=1 starts=100",)))
    (cell,) = results["cells"]
    assert (cell["starts"], cell["faults"]) == (100, {})
    for level in cell["levels"]:
        reached = {row["program"]: row["reached"] for row in level["programs"]}
        assert reached == dict.fromkeys((OURS, RUN, ENGINE), 8)
        seconds = {row["program"]: row["seconds"] for row in level["programs"]}
        assert seconds[ENGINE] < 10 * seconds[OURS]  # a hundred times as many would be a loop
    assert "t=1 starts=100" in make.tables("speed", results)["many"].markdown


@pytest.mark.slow
def test_a_small_contest_from_end_to_end():
    """A cell in a process of its own, without compilers; the page is of the rows."""
    results = speed.rows(True, print, Only(("kovalevskaya t=10 outputs=2",)))
    (cell,) = results["cells"]
    assert (cell["outputs"], cell["faults"]) == (2, {})
    for level in cell["levels"]:
        reached = {row["program"]: row["reached"] for row in level["programs"]}
        assert reached == dict.fromkeys((OURS, RUN, ENGINE), 8)
        assert level["verdict"]["stands"] == "not run"
    assert "t=10 outputs=2" in make.tables("speed", results)["single"].markdown
