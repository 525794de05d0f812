"""The study speed: peers as processes, what becomes of their answers, curves and verdicts.

No test depends on how long anything takes.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from polhode.equations.forms import principal
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.scalars import Functions
from polhode.peers import field
from polhode.studies import peer_processes
from polhode.studies.page.blocks import markdown
from polhode.studies.peer_processes import Method, Task
from polhode.studies.published import rows as published
from polhode.studies.row_filter import Only
from polhode.studies.speed import benchmark_grid, contenders, figure, page, refined
from polhode.studies.speed import rows as speed
from polhode.studies.speed.published_benchmarks import READ
from polhode.studies.speed.work_precision import WorkPoint, against, frontier, seconds_at, wall

SHORT = contenders.SpeedMotion("short", "general/asymmetric-regular", 2, "regular")
FLOATS = Functions(0.0, math.sin, math.cos, math.sqrt)


# the equations that the peers take


@settings(deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_the_peers_take_the_equations_that_polhode_integrates(state):
    for case in ("general/asymmetric-regular", "lagrange/nutation", "euler/largest-axis"):
        body = contenders.plain_scene(case, (Fraction(1),)).body
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
    ],
)
def test_a_peer_that_fails_stays_in_the_table_with_the_reason(peer, name, status, said, good):
    curve = peer(name)
    assert curve.status == status
    assert said in curve.reason
    assert sum(point.rows is not None for point in curve.points.values()) == good
    assert set(curve.points) == {1e-6, 1e-9}


def test_a_peer_that_cannot_be_built_fails_at_every_tolerance(peer):
    curve = peer("unbuilt", build="raise RuntimeError('no compiler')")
    assert curve.status == "failed"
    assert curve.reason == "at tolerance 1e-06, 1e-09: RuntimeError: no compiler"


@pytest.mark.slow
def test_a_peer_that_takes_too_long_is_stopped_and_keeps_what_it_had(peer):
    curve = peer("sleeping", limit=9.0)
    assert curve.status == "failed"
    assert "stopped after 9 s" in curve.reason
    assert curve.points[1e-6].rows is not None


def test_a_module_that_is_not_there_fails_with_its_last_word():
    job = {"problems": []}
    answers, fault = peer_processes.ask("polhode.peers.nobody", job, 20.0, Path("unused"))
    assert answers == []
    assert "nobody" in fault


def test_stale_rows():
    start, moved = [1, 2], [1, 3]
    assert peer_processes.stale([start, start])
    assert peer_processes.stale([start, moved, moved])
    assert peer_processes.stale([start, moved, start])
    assert not peer_processes.stale([start, moved, [2, 3]])


#: What the process of a peer needs beside numpy.
PACKAGES = {"scipy_python": "scipy", "scipy_numba": "numba", "numbalsoda_cfunc": "numbalsoda"}
PACKAGES |= {"cyrk": "CyRK", "diffrax_dopri8": "diffrax", "splitting": "numba"}


def missing(package: str) -> bool:
    command = [sys.executable, "-c", f"import {package}"]
    return subprocess.run(command, capture_output=True).returncode != 0


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The folder of compiled code, for all methods."""
    return tmp_path_factory.mktemp("compiled")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "digits"),
    [
        (contenders.HEYOKA, (15.0, 15.96)),
        *((m, (14.5, 15.96)) for m in contenders.OURS if m.name == "polhode double"),
        *((m, (18.0, 19.27)) for m in contenders.OURS if m.name == "polhode extended"),
        *((m, (9.0, 15.96)) for m in (*contenders.PEERS, *contenders.SHORT_PEERS)),
    ],
    ids=lambda x: x.name.replace(" ", "-") if isinstance(x, Method) else "",
)
def test_every_method_that_is_here_finds_the_motion(method, digits, compiled):
    scene = contenders.scene_of(SHORT)
    tight = method._replace(tolerances=method.tolerances[-1:])
    curve = peer_processes.run_all([Task(tight, scene, repeats=1)], compiled, rounds=1)[0]
    if curve.status == "missing":
        assert missing(PACKAGES[method.module.rpartition(".")[2]])
        pytest.skip(curve.reason)
    row = speed.motion_row(SHORT, scene, {tight: curve})["methods"][0]
    found = [p["digits"] for p in row["points"] if "digits" in p]
    assert curve.status == "ok", curve.reason
    assert digits[0] <= found[0] <= digits[1]


# curves


def test_frontier_and_seconds_between_its_points():
    marks = [WorkPoint(2, 1), WorkPoint(4, 4), WorkPoint(3, 9), WorkPoint(8, 16)]
    assert frontier(marks) == [WorkPoint(2, 1), WorkPoint(4, 4), WorkPoint(8, 16)]
    assert seconds_at(marks, 1) == 1
    assert seconds_at(marks, 3) == pytest.approx(2, rel=1e-15)
    assert seconds_at(marks, 6) == pytest.approx(8, rel=1e-15)
    assert seconds_at(marks, 8) == pytest.approx(16, rel=1e-15)
    assert seconds_at(marks, 8.1) is None


def test_a_curve_against_others():
    ours = [WorkPoint(6, 1), WorkPoint(12, 2)]
    slower = against(ours, [WorkPoint(6, 10), WorkPoint(11, 10.1)], 6, 12)
    assert slower.ahead
    assert (slower.at, slower.reach, slower.short) == (11, 11, 0)
    assert slower.factor == pytest.approx(10.1 / 2 ** (5 / 6), rel=1e-12)
    faster = against(ours, [WorkPoint(6, 0.5), WorkPoint(11, 20)], 6, 12)
    assert not faster.ahead
    assert (faster.factor, faster.at) == (0.5, 6)
    further = against(ours, [WorkPoint(6, 10), WorkPoint(13, 20)], 6, 12.5)
    assert not further.ahead
    assert further.short == 0.5
    hopeless = against(ours, [WorkPoint(5, 0.1)], 6, 12)
    assert hopeless.ahead
    assert hopeless.factor is None


CLIMBING = [(1e-6, 6.0), (1e-9, 9.0), (1e-12, 12.0)]
FLAT_AT_9 = [(1e-6, 6.0), (1e-9, 9.0), (1e-12, 9.1)]


def test_a_wall_is_blamed_on_the_reference():
    assert wall([("double", FLAT_AT_9), ("quad", FLAT_AT_9)]) == 9.1
    assert wall([("double", CLIMBING), ("quad", FLAT_AT_9)]) is None
    assert wall([("double", FLAT_AT_9), ("double", FLAT_AT_9)]) is None  # rounding does that
    higher = [(1e-12, 12.0), (1e-20, 20.0), (1e-25, 20.1)]
    assert wall([("double", FLAT_AT_9), ("quad", higher)]) is None
    assert wall([("extended", higher), ("quad", higher), ("double", FLAT_AT_9)]) == 20.1
    assert wall([("extended", higher), ("quad", higher), ("double", CLIMBING)]) == 20.1
    still = [(1e-12, 12.0), (1e-20, 20.0), (1e-25, 20.6)]
    assert wall([("extended", higher), ("quad", still), ("double", CLIMBING)]) is None
    assert wall([("double", CLIMBING), ("quad", [])]) is None


@pytest.mark.slow
def test_a_reference_that_is_wrong_is_found_by_the_wall(monkeypatch, tmp_path):
    """The closed form of another motion, off by 1e-9: every type flattens there."""
    scene = contenders.scene_of(SHORT)
    asked = [
        m._replace(tolerances=(1e-8, 1e-12, 1e-14))
        for m in contenders.OURS
        if m.name in ("polhode double", "polhode extended")
    ]
    tasks = [Task(method, scene, repeats=1) for method in asked]
    curves = peer_processes.run_all(tasks, tmp_path, rounds=1)
    curves = dict(zip(asked, curves, strict=True))
    assert speed.motion_row(SHORT, scene, curves)["wall"] is None
    true = speed.reference_of(scene)

    class Wrong:
        def at(self, times, digits):
            return [[x * (1 + 1e-9) for x in row] for row in true.at(times, digits)]

    monkeypatch.setattr(speed, "reference_of", lambda scene: Wrong())
    assert speed.motion_row(SHORT, scene, curves)["wall"] == pytest.approx(9, abs=0.5)


# the study


EPS_DIGITS = -math.log10(2**-52)  # a point whose tolerance is eps


def synthetic() -> dict:
    """Rows as the study gives them, with a peer that is faster at 6 digits and one missing."""

    def method(name, number, points, **more):
        shown = [
            {
                "tol": 10.0**-d if d != EPS_DIGITS else 2.0**-52,
                "digits": d,
                "seconds_min": s,
                "seconds_median": s,
                "cpu": s,
            }
            | {"runs": 6, "steps": round(1e6 * s) if name != contenders.PROJECTED else None}
            for d, s in points
        ]
        plain = {"status": "ok", "reason": "", "version": "1", "import": 0.1}
        return plain | {
            "method": name,
            "number": number,
            "compile_cold": 0.1,
            "compile_cached": None,
            "points": shown,
            **more,
        }

    methods = [
        method(contenders.PLAIN, "double", [(6.0, 0.002), (12.0, 0.003)]),
        method(contenders.PROJECTED, "double", [(6.0, 0.001), (EPS_DIGITS, 0.004)]),
        method("polhode quad", "quad", [(20.0, 1.0), (30.0, 2.0)]),
        method(contenders.ENGINE, "double", [(6.0, 0.001), (12.0, 0.002)]),
        method("CyRK DOP853", "double", [(5.0, 0.0005), (6.0, 0.001), (11.0, 0.02)]),
        method("diffrax Dopri8", "double", [(6.0, 0.1), (11.0, 1.0)]),
        method("numbalsoda lsoda", "double", [], status="missing", reason="No module"),
    ]
    motion = {
        "motion": "Euler top",
        "case": "euler/largest-axis",
        "end": 1000,
        "kind": "regular",
        "methods": methods,
        "wall": None,
        "kappa": 1e3,
        "digits_bound": 12.9,
        "verdict": speed.verdict(methods, 12.4),
    }
    return {
        "study": "speed",
        "question": speed.QUESTION,
        "quick": False,
        "target": speed.target([motion]),
        "motions": [motion],
    }


def test_the_verdict_says_where_polhode_is_behind():
    found = synthetic()
    verdict = found["motions"][0]["verdict"]
    rows = {row["method"]: row for row in verdict["peers"]}
    assert set(rows) == {"CyRK DOP853", "diffrax Dopri8"}  # heyoka is no peer
    assert not verdict["ahead_of_all"]
    assert verdict["reaches_floor"]
    assert rows["CyRK DOP853"]["least_factor"] == 0.5
    assert rows["CyRK DOP853"]["at_digits"] == 6
    assert rows["diffrax Dopri8"]["ahead"]
    assert found["target"]["behind"] == [{"motion": "Euler top", **rows["CyRK DOP853"]}]
    engine = verdict["engine"]
    assert engine[contenders.PLAIN]["overhead_most"] == 2
    assert engine[contenders.PLAIN]["steps_tightest"] == 1.5
    assert engine[contenders.PROJECTED]["steps_tightest"] is None
    assert engine[contenders.PROJECTED]["digits_gained"] == round(EPS_DIGITS - 12, 2)


def test_no_claim_is_made_of_nothing():
    found = synthetic()
    assert page.finding(found).startswith("No run here is long and accurate enough")
    (motion,) = found["motions"]
    alone = [m for m in motion["methods"] if not m["method"].startswith(("CyRK", "diffrax"))]
    motion |= {"methods": alone, "verdict": speed.verdict(alone, 12.4)}
    found["target"] = speed.target([motion])
    assert found["target"]["ahead"] is None
    assert "ahead of" not in markdown(page.TITLE, page.blocks(found))


def test_the_page_says_what_its_rows_do_not_show():
    """A program that was not there is named, one that was is not."""
    found = synthetic()
    text = markdown(page.TITLE, page.blocks(found))
    assert "does not stand and is withdrawn until speed is measured again" in text
    assert "; numbalsoda was missing; only reruns of one start" in text
    found["motions"][0]["methods"].pop()
    text = markdown(page.TITLE, page.blocks(found))
    assert "is withdrawn" in text
    assert "was missing" not in text


def test_a_program_left_out_of_the_cells_is_told_with_what_it_reaches():
    found = synthetic()
    (motion,) = found["motions"]
    assert "left out of the cells" not in markdown(page.TITLE, page.blocks(found))
    points = [{"tol": 1e-9, "digits": 12.0, "seconds_min": 0.03, "seconds_median": 0.03}]
    motion["methods"].append(
        motion["methods"][4] | {"method": "splitting 8 compensated", "points": points}
    )
    text = markdown(page.TITLE, page.blocks(found))
    assert (
        "12 digits on 1 of 1 regular motions to t = 1000; where polhode does too, in 10 to 10 "
        in text
    )


def test_polhode_as_it_comes_is_projected_at_eps_alone():
    marks = speed.as_it_comes(synthetic()["motions"][0]["methods"])
    assert marks == [WorkPoint(6, 0.002), WorkPoint(12, 0.003), WorkPoint(EPS_DIGITS, 0.004)]


def test_page_and_figure_are_made_from_the_json_alone():
    found = json.loads(json.dumps(synthetic()))
    text = markdown(page.TITLE, page.blocks(found))
    assert "Euler top, CyRK DOP853: it takes 0.5 of our time at 6.0 digits" in text
    assert "numbalsoda lsoda: missing (No module)" in text
    assert "| diffrax Dopri8 | 50 (6.0) |" in text
    drawn = figure.svgs(found)
    assert drawn == figure.svgs(found)
    assert list(drawn) == ["speed"]
    assert "Not drawn: missing: numbalsoda lsoda" in text


def test_what_was_read_elsewhere_is_marked_and_is_no_method_of_ours():
    found = json.loads(json.dumps(synthetic() | {"elsewhere": [r._asdict() for r in READ]}))
    text = markdown(page.TITLE, page.blocks(found))
    assert "## Read elsewhere, not measured here" in text
    assert "figure (read)" in text
    assert "Read elsewhere" not in markdown(page.TITLE, page.blocks(synthetic()))
    ours = {m.name for motion in contenders.MOTIONS for m in contenders.methods(motion, False)}
    for row in READ:
        assert row.program not in ours
        assert all(row)
        assert f"| {row.program} |" in text


def test_the_figure_that_was_read_of_kynema_is_off_by_what_is_said():
    """Its benchmark is a published figure of the library too; ours is the closed form's."""
    found = published.rows(only=Only(("bruels",)))
    rows = [row for case in found["cases"] for row in case["figures"]]
    off = [abs(float(row["difference"])) for row in rows if "Kynema" in row["cite"]]
    assert len(off) == 3
    told = f"off by {max(off):.1e} from".replace("e-0", "e-")
    assert any(told in row.figure for row in READ)


@pytest.mark.slow
def test_a_small_study_from_end_to_end(monkeypatch):
    """The quick study on its shortest motion alone; the same digits twice."""
    monkeypatch.setattr(speed, "MOTIONS", tuple(m for m in speed.MOTIONS if m.kind == "short"))
    told = []
    monkeypatch.setattr(benchmark_grid, "QUICK_LENGTHS", ((10, 11),))
    found = speed.rows(quick=True, tick=told.append)
    assert told
    assert all(line.startswith("speed: ") for line in told)
    assert json.loads(json.dumps(found)) == found
    motion = found["motions"][0]
    assert motion["wall"] is None
    rows = {row["method"]: row for row in motion["methods"]}
    assert "polhode double" in rows
    assert "mpmath odefun" in rows
    assert max(p["digits"] for p in rows["polhode extended"]["points"]) > 18
    for row in rows.values():
        for point in row["points"]:
            assert 0 <= point.get("digits", 0) <= 19.27
    assert markdown(page.TITLE, page.blocks(found))
    assert figure.svgs(found)["speed"].startswith("<?xml")
    assert {cell["kind"] for cell in found["cells"]} == {*benchmark_grid.KINDS}


def test_the_full_study_asks_for_every_peer_and_type():
    asked = {m.name for motion in contenders.MOTIONS for m in contenders.methods(motion, False)}
    assert {m.number for m in contenders.OURS} == {"double", "extended", "quad", "mp"}
    assert asked == {
        m.name
        for m in (
            *contenders.OURS,
            contenders.HEYOKA,
            *contenders.PEERS,
            *contenders.SHORT_PEERS,
        )
    }
    quick = {m.name for motion in contenders.MOTIONS for m in contenders.methods(motion, True)}
    assert quick < asked


def test_of_the_right_hand_sides_of_scipy_one_is_compiled_on_the_short_motion_alone():
    """Its steps are taken in Python: both stand side by side where a run is short."""
    by_kind = {m.kind: {x.name for x in contenders.methods(m, False)} for m in contenders.MOTIONS}
    both = {"SciPy DOP853, Python", "SciPy DOP853, numba"}
    assert both < by_kind["short"]
    assert both & by_kind["regular"] == {"SciPy DOP853, Python"}


def test_a_peers_process_imports_nothing_else_of_polhode():
    """But for what ``import polhode`` itself brings: a table of what to load when asked."""
    code = (
        "import sys, polhode; package = {*sys.modules}; "
        "import polhode.peers.bare_heyoka, polhode.peers.cyrk, polhode.peers.scipy_python; "
        "import polhode.peers.splitting; "
        "own = [m for m in sys.modules if m.partition('.')[0] in ('polhode', 'numpy', 'heyoka')]; "
        "print(*(m for m in own if m in package)); print(*(m for m in own if m not in package))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    package, more = (line.split() for line in done.stdout.splitlines())
    assert {m.rpartition(".")[2] for m in package if m.count(".") > 1} == {"presentation"}
    assert "numpy" not in package
    assert all(m.startswith("polhode.peers") for m in more)


def test_refined_runs_stand_beside_heyokas_own_steps():
    (row,) = [refined._row(replace(refined.CONTESTS[0], end=4))]
    assert row["refined"]["method"] == "refined"
    assert row["taylor"]["method"] == "taylor"
    assert 33.5 < row["refined"]["digits"] < 37
    assert 32 < row["taylor"]["digits"] < 34.5
    assert abs(row["agreement"] - row["taylor"]["digits"]) < 1
    assert row["estimate"] > 10 ** -row["refined"]["digits"]
    rows = [row, {**row, "gain": 20.0}]
    text = markdown("Speed", page._refined(rows))
    assert f"0.050 to {1 / row['gain']:.3f} of the time" in text
    assert list(page._refined([])) == []
