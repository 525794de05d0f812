"""The studies: each is made, its page follows from its rows, and every row can be made again."""

from __future__ import annotations

import copy
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from string import Formatter
from types import SimpleNamespace
from typing import Any

import pytest

import accuracy
import events
import kit
import make
import polhode
import stability
from kit import TYPES, JsonObject, Only, table
from polhode.judging.limits import selected
from shared.reports import COMMITTED, committed, quick_results, quick_study
from shared.tools import tiers

CASES = polhode.cases().column("scene")

# -- tables: what no committed page shows ----------------------------------------------------------


def test_a_cell_is_escaped_and_what_is_not_there_is_a_dash_also_deep_down():
    rows = {"name": "b|c", "at": {"1": 1}, "gap": []}, {"gap": None, "at": {"2": None, "1": 3}}, {}
    page_table = table(rows, "a | name\nb | gap.0 | .1f\nt = * | at.* | d", "x {0} {1}")
    assert page_table.markdown.splitlines()[2:5] == [
        "| b\\|c | – | 1 | – |",
        "| – | – | 3 | – |",
        "| – | – | – | – |",
    ]
    assert page_table.command(page_table.rows[0]) == "x b|c –"


# -- the committed report --------------------------------------------------------------------------


@pytest.mark.parametrize("name", make.STUDIES)
def test_every_study_is_committed_with_its_page_and_figures(name):
    results = committed(name)
    assert not results["quick"]
    page = make.page(results)
    assert (COMMITTED / f"{name}.md").read_text() == page
    _, question, origin, *_ = page.split("\n\n")
    assert question == results["question"]
    assert origin.startswith("Made by polhode ")
    shown = re.findall(r"^!\[.*\]\((.*)\.svg\)$", page, re.M)
    assert shown
    for figure in shown:
        assert (COMMITTED / f"{figure}.svg").read_text().startswith("<?xml")
    for case in results.get("cases", []):
        assert f"\n| {case['case']} | " in page, case["case"]
        assert case["sha256"] == polhode.load(case["case"]).provenance()["case"], case["case"]
    if name == "accuracy":  # a case younger than the study has no row until it is made again
        rows = [case["case"] for case in results["cases"]]
        assert rows == [case for case in CASES if case in rows]
        assert len(rows) > 0.9 * len(CASES)


def test_the_table_in_readme_is_of_the_committed_rows():
    text = make.README.read_text(encoding="utf-8")
    assert make.with_summary(text, committed("speed")) == text
    spoiled = text.replace("| t = 100, 2 outputs | 0", "| t = 100, 2 outputs | 9")
    assert make.with_summary(spoiled, committed("speed")) == text != spoiled


@pytest.mark.slow
def test_what_is_stale_is_made_again_and_named_and_rows_of_another_version_too(
    tmp_path, monkeypatch, capsys
):
    for name in ("stability.json", "stability.md"):
        (tmp_path / name).write_bytes((COMMITTED / name).read_bytes())
    page = (tmp_path / "stability.md").read_text()
    (tmp_path / "stability.md").write_text(page.replace("# ", "## ", 1) + "more\n")
    version = committed("stability")["provenance"]["versions"]["polhode"]

    def stale(now):
        monkeypatch.setattr(polhode, "__version__", now)
        code = make.main(["stability", "--stale", "-o", str(tmp_path)])
        return code, sorted(capsys.readouterr().out.splitlines())

    assert stale(version) == (1, [str(tmp_path / x) for x in ("stability.md", "stability.svg")])
    assert (tmp_path / "stability.md").read_text() == page
    assert stale(version) == (0, [])
    command = f"rows of polhode {version}, this is 9: python reports/make.py stability"
    assert stale("9") == (1, [f"{tmp_path / 'stability.json'}: {command}"])


@pytest.mark.parametrize("name", make.STUDIES)
def test_every_table_and_every_fact_stands_on_the_page_once_and_is_explained(name):
    results, study = committed(name), make.module(name)
    own, facts = make.tables(name, results), study.facts(results)
    assert {*own} == {*study.tables(results)}
    text = kit.TABLE.sub("", make.template(name))
    if name == "speed":
        text += make.template("summary").replace("{summary}", "")  # README's
    named = [field for _, field, _, _ in Formatter().parse(text) if field is not None]
    assert not {*own} & {*facts}
    assert {field.partition("[")[0] for field in named} == {*facts, "origin"}
    assert any(column.meaning for x in own.values() for column in x.columns)
    for x in own.values():  # two columns of one name tell a reader nothing
        assert len({*x.header}) == len(x.header)


class Listed(Only):
    """Wants nothing, and keeps the labels of every row that it was asked for."""

    def __call__(self, *labels: str) -> bool:
        self.passed.append(labels)
        return False


def finds(command: str, name: str, rows: list[tuple[str, ...]]) -> bool:
    """Whether a command names this study and a row of it, or the study as a whole."""
    program, path, study, *rest = shlex.split(command)
    assert (program, path, study) == ("python", "reports/make.py", name)
    assert rest
    only = Only(tuple(rest[1::2]))
    return rest == ["-o", "DIR"] or (
        set(rest[::2]) == {"--only"} and any(only(*row) for row in rows)
    )


@pytest.mark.parametrize(
    "name", tiers(["speed", "stability"], ["accuracy", "proofs", "long-run", "events"])
)
def test_every_row_has_a_command_that_finds_it(name):
    listed, results = Listed(("nothing",)), committed(name)
    make.module(name).rows(False, print, listed)  # nothing is run
    own = make.tables(name, results)
    assert all(x.again or place in ("summary", "faults") for place, x in own.items())
    commands = [x.command(row) for x in own.values() if x.again for row in x.rows]
    text = make.page(results).partition("## Provenance")[0]
    commands += re.findall(r"`(python reports/make.py [^`]+)`", text)
    assert commands
    assert [command for command in commands if not finds(command, name, listed.passed)] == []
    assert not finds(f"python reports/make.py {name} --only 'no row'", name, listed.passed)


def rows_in(results: JsonObject) -> Iterator[tuple[JsonObject, str]]:
    """Where there are lists of rows in a study's results: the object that has one, and its key."""
    for key, value in results.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            yield results, key
        elif isinstance(value, dict) and key != "provenance":
            yield from rows_in(value)


@pytest.mark.parametrize(
    ("name", "count"),
    tiers(
        [("speed", 0), ("long-run", 0), ("proofs", 1)],
        [
            ("accuracy", 0),
            ("proofs", 0),
            ("stability", 0),
            ("events", 0),
            ("speed", 1),
            ("accuracy", 1),
            ("stability", 1),
            ("long-run", 1),
            ("events", 1),
        ],
    ),
)
def test_a_page_of_no_rows_and_of_one_row_of_each_kind_can_be_made(name, count):
    whole = committed(name)
    for k in range(len([*rows_in(whole)])):
        results = copy.deepcopy(whole)
        for j, (place, key) in enumerate(rows_in(results)):
            if not (name == "stability" and key == "cases"):  # which its kinds name
                place[key] = place[key][: count * (j == k)]
        page = make.page(results)
        assert page.startswith(make.page(whole).partition("\n")[0])
        assert "\n\n\n" not in page  # where a table is left out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "part", "rows"),
    [
        ("accuracy", "cases", "runs"),
        ("stability", "cases", "runs"),
        ("proofs", "orbits", "orbits"),
    ],
)
def test_a_row_less_is_a_mark_less(name, part, rows):
    results, study = committed(name), make.module(name)
    results["chaos"], results[part] = [], results[part][:2]
    before = study.svgs(results)[name].count("<use ")
    results[part][0][rows].pop(0)
    assert before - study.svgs(results)[name].count("<use ") == 1


def test_all_that_the_reports_link_to_is_there_and_nothing_else_is():
    linked = {"looping.gif"}  # README's
    for page in COMMITTED.glob("*.md"):
        linked.add(page.name)
        for target in re.findall(r"\]\(([^)#]+)[)#]", page.read_text()):
            if not target.startswith("http"):
                assert (COMMITTED / target).is_file(), (page.name, target)
                linked.add(target)
    linked |= {f"{name}.json" for name in make.STUDIES}
    files = {path.relative_to(COMMITTED).as_posix() for path in COMMITTED.rglob("*.*")}
    own = ("benchmark/", "templates/", "peers/")
    rest = {x for x in files - linked if not x.startswith(own) and "__pycache__" not in x}
    assert {x for x in rest if not x.endswith(".py")} == set()
    text = (COMMITTED / "gallery.md").read_text()
    rows = re.findall(r"^([\w-]+/[\w-]+) (\d+)$", text, re.M)
    assert len(rows) > 20
    for case, end in rows:  # a picture of each motion of the gallery's loop
        assert f"[{case}](../cases/{case}.toml) to t = {end}" in " ".join(text.split())
        assert f"(gallery/{case.replace('/', '-')}.svg)" in text


# -- verdicts of the committed rows ----------------------------------------------------------------

STEP = 0.01  # digits are kept to two places


def judged() -> list[dict[str, Any]]:
    """The runs of the library and of the hard cases that were judged against what is expected."""
    cases = [*committed("accuracy")["cases"], *committed("stability")["cases"]]
    runs = [{"case": case["case"], **run} for case in cases for run in case["runs"]]
    return [run for run in runs if run.get("correct_digits") is not None and run["expected"]]


def test_no_verdict_of_the_library_contradicts_its_band():
    """*conditioning* and *inputs* are of runs that lose no more than the band and the choice of the
    worst time allow, *method* of those that lose more.
    """
    runs, wrong = judged(), []
    assert len(runs) > 800
    for run in runs:
        least = run["expected"][0] - selected(run.get("times", 1))
        below, inside = (
            run["correct_digits"] < least - STEP,
            run["correct_digits"] > least + STEP,
        )
        word = run["limit"].split()[0]
        if (word in ("conditioning", "inputs") and below) or (word == "method" and inside):
            wrong.append((run["case"], run["number"], run["limit"]))
    assert wrong == []
    words = {run["limit"].split()[0] for run in runs}
    assert {"conditioning", "inputs", "method", "rounding"} <= words


def test_nine_in_ten_runs_of_the_library_end_in_the_band():
    """Of runs that have digits left; 85 to 95 % of them, the worst over the output times."""
    runs = [run for run in judged() if run["expected"][2] > 0]
    inside = sum(e[0] <= run["correct_digits"] <= e[2] for run in runs for e in [run["expected"]])
    assert 0.85 <= inside / len(runs) <= 0.95


# -- made today ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_rows_made_today_agree_with_the_committed_ones():
    every = {case["case"]: case for case in committed("accuracy")["cases"]}
    for today in quick_results("accuracy")["cases"]:
        before = every[today["case"]]
        assert [run["outcome"] for run in today["runs"]] == ["reached end"] * 4
        for run, then in zip(today["runs"], before["runs"], strict=True):
            assert abs(run["correct_digits"] - then["correct_digits"]) < 1
            assert (run["number"], run["outcome"]) == (then["number"], then["outcome"])
    (motion,) = quick_results("events")["motions"]
    for run in (*motion["near"], *motion["far"]):
        assert run["found"] == run["true"] > 0
        assert run["ulps"] < 1e4


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in make.STUDIES if name != "speed"])
def test_a_quick_study_is_made(name):
    """Each wrote its page, which is of its rows."""
    files, results = quick_study(name), quick_results(name)
    assert {*files} == {f"{name}.{ending}" for ending in ("json", "md", "svg")}
    assert results["quick"]
    assert files[f"{name}.md"] == make.page(results)


@pytest.mark.slow
def test_ctrl_c_ends_a_study_and_writes_nothing(tmp_path):
    """While its processes work: within seconds, where a row takes longer."""
    command = [sys.executable, make.__file__, "long-run", "-o", str(tmp_path)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        process.stderr.readline()
        process.send_signal(signal.SIGINT)
        _, message = process.communicate(timeout=60)
    assert process.returncode == 130
    assert message.endswith("make.py: stopped; the study that was being made is not written\n")
    assert [*tmp_path.iterdir()] == []


def test_rows_that_are_printed_say_whether_they_are_quick(monkeypatch):
    """A page of quick rows said that programs were missing, which quick studies leave out."""
    results, study = [], SimpleNamespace(rows=lambda quick, say, only: {"x": only("x")})
    monkeypatch.setattr(make, "module", lambda name: study)
    monkeypatch.setattr(make, "tables", lambda name, rows: results.append(rows) or {})
    make.part("speed", ["x"], quick=True)
    assert results == [{"quick": True, "x": True}]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["acuracy"], "expected speed, accuracy"),
        (["--only", "x"], "NAME of one study"),
        (["speed", "--only", "x", "-o", "y"], "expected no --only"),
        (["accuracy", "--only", "no such case"], "part of the name of a row, such as"),
        (["benchmark", "--only", "no such top", "-o", "x"], "such as euler-largest-axis"),
    ],
)
def test_what_is_asked_wrongly_is_refused_in_words(words, message, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    try:
        code = make.main(words)
    except SystemExit as end:
        code = end.code
    assert code == 2
    assert message in capsys.readouterr().err


# -- what would be seen ----------------------------------------------------------------------------


def test_every_case_tagged_hard_is_in_the_study_of_stability_once():
    names = stability.hard_names()
    assert len(names) == len(set(names))
    assert set(names) <= set(CASES)
    tagged = {name for name in CASES if "hard" in polhode.load(name).tags}
    assert tagged <= set(names)
    assert set(stability.QUICK) <= set(names)


def test_a_lost_event_is_seen(monkeypatch):
    """A count that is not the closed form's shows, and no error is then made up."""
    scene = events._watching(polhode.load("euler/largest-axis"), "q")
    zeros = events.Zeros(scene)
    first, second = zeros.first
    assert abs(second - first - zeros.period / 2) < Fraction(1, 10**45)
    honest = events._run(scene, zeros, "double", 20)
    assert honest["true"] == honest["found"] == 4
    assert 0 < honest["ulps"] < 8
    monkeypatch.setattr(zeros, "first", zeros.first[:1])
    corrupted = events._run(scene, zeros, "double", 20)
    assert corrupted["true"] == 2 != corrupted["found"]
    assert "ulps" not in corrupted


def test_a_closed_form_beside_the_motion_is_seen(monkeypatch):
    assert accuracy.provable(polhode.load("general/asymmetric-regular")) is None
    scene = accuracy.provable(polhode.load("lagrange/nutation"))
    row = accuracy.proven_case(scene)
    assert row["inside"]
    assert row["digits"] >= accuracy.PROVEN_DIGITS
    omega = (scene.omega[0] + Fraction(1, 10**15), *scene.omega[1:])
    moved = polhode.reference(replace(scene, omega=omega))
    monkeypatch.setattr(polhode, "reference", lambda _: moved)
    assert not accuracy.proven_case(scene)["inside"]


@pytest.mark.parametrize(("number", "most"), [("double", 1e4), ("extended", 1e4), ("quad", 1e4)])
def test_a_regular_motion_comes_back(number, most):
    scene = polhode.load("euler/largest-axis")
    assert 0 < stability.error(scene, TYPES[number]) < most
    assert stability.error(scene.at((Fraction(1, 8),)), TYPES[number]) < 20


# -- figures that hold at another time than their label says ---------------------------------------


def printed_late(late: Fraction, wrong: str = "") -> list[JsonObject]:
    """Of the state at t = 5 + late, printed to 12 digits as if it were that at 5."""
    scene = polhode.load("lagrange/nutation")
    row = polhode.reference(scene).at([5 + late], 20)[0]
    texts = [f"{float(x):.12g}" for x in row]
    if wrong:
        texts[1] = wrong
    published = [
        polhode.Published(Fraction(5), q, x, "X") for q, x in zip(scene.columns, texts, strict=True)
    ]
    return accuracy.printed_figures(replace(scene, published=tuple(published)))[1]


@pytest.mark.parametrize("late", [Fraction(1, 1000), Fraction(-1, 40), Fraction(1, 10**6)])
def test_a_shift_is_found_to_the_digits_printed(late):
    (label,) = printed_late(late)
    assert label["shift"] == pytest.approx(float(late), rel=1e-4, abs=1e-11)
    assert label["after"] < 1e-11
    assert label["before"] > 100 * label["after"]


def test_figures_that_are_right_or_wrong_in_another_way_have_none():
    assert printed_late(Fraction(0)) == []
    assert printed_late(Fraction(1, 1000), wrong="0.5") == []


def test_the_brick_of_simulation_six_is_half_a_millisecond_late():
    (label,) = accuracy.printed_figures(polhode.load("published/nasa-brick"))[1]
    assert "simulation 6" in label["cite"]
    assert label["shift"] == pytest.approx(5e-4, rel=1e-4)
    assert label["after"] < label["before"] / 10_000
