"""The studies: each is made, its page follows from its rows, and every row can be made again."""

from __future__ import annotations

import copy
import json
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from string import Formatter
from typing import Any

import pytest

import accuracy
import events
import kit
import make
import polhode
import stability
from kit import TYPES, Column, JsonObject, Only, filled, table, tables
from polhode.judging.limits import selected
from shared.reports import COMMITTED, committed
from shared.tools import tiers

CASES = polhode.cases().column("scene")

# -- tables ----------------------------------------------------------------------------------------

ROW = {"name": "a", "digits": 12.34, "seconds": {"run": 0.5}, "found": [1, 2]}
ROW |= {"gap": None, "right": False}


@pytest.mark.parametrize(
    ("value", "form", "cell", "side"),
    [
        ("name", "", "a", "---"),
        ("name", "code", "`a`", "---"),
        ("digits", ".1f", "12.3", "--:"),
        ("seconds.run", ".2g", "0.5", "--:"),
        ("found.1", "d", "2", "--:"),
        ("gap", ".1f", "–", "--:"),
        ("gap.deeper", "", "–", "---"),
        ("name", ".1f", "a", "--:"),  # such as how a run ended, in place of its digits
        ("right", "", "no", "---"),
        ("not there", "", "–", "---"),
    ],
)
def test_a_cell_is_a_value_of_the_row_in_the_form_of_its_column(value, form, cell, side):
    column = Column.of_line(f"header | {value} | {form}")
    assert (column.cell(ROW), column.side) == (cell, side)


def test_a_table_is_rows_of_columns_with_what_they_hold_and_how_to_make_them_again():
    lines = "a | name | code\np | digits | .1f | so\n  *much*, |p|\n"
    page_table = table([ROW, {"name": "b|c"}], lines, "x {0} '{1}'")
    assert page_table.command(page_table.rows[1]) == "x b|c '–'"
    assert page_table.markdown == (
        "| a | p |\n|---|--:|\n| `a` | 12.3 |\n| `b\\|c` | – |\n\n"
        "Columns: *p*: so *much*, |p|.\nTo make rows again, here the first: `x a '12.3'`."
    )
    assert table([], lines).markdown == ""


def test_a_path_that_ends_in_a_star_is_a_column_for_each_key():
    rows = {"at": {"1": 1, "0.5": 2}}, {"at": {"2": None, "1": 3}}, {}
    page_table = table(rows, "t = * | at.* | d | count\n* | none.* | d\n")
    assert page_table.header == ("t = 1", "t = 0.5", "t = 2")
    assert page_table.rows == (("1", "2", "–"), ("3", "–", "–"), ("–", "–", "–"))


def test_a_block_of_a_template_is_a_table_and_one_without_lines_has_the_columns_of_the_last():
    template = "a\n\n```table x: --only {0}\np | p | d\ncase\n```\n\n{n}\n\n```table y\n```\n"
    own = tables(template, {"x": [{"p": 1, "case": "c"}], "y": [{"p": 2}]}, "make x")
    assert own["x"].markdown.splitlines()[2] == "| 1 | c |"
    assert own["x"].markdown.endswith("first: `make x --only 1`.")
    assert "which `polhode show CASE` prints" in own["y"].markdown
    assert "To make" not in own["y"].markdown
    assert filled(template, own, {"n": 3}).startswith("a\n\n| p | case |\n")


def test_a_part_without_rows_is_left_out_under_its_heading():
    template = "# A\n\n{n} of it\n\n## B\n\nwords\n\n{b}\n\n{c}\n\n### C\n\nmore {n}\n\n{c}\n"
    whole = table([{"x": 1}], "x | x")
    none = whole._replace(rows=())
    text = filled(template, {"b": whole, "c": none}, {"n": 2})
    assert text == "# A\n\n2 of it\n\n## B\n\nwords\n\n| x |\n|---|\n| 1 |\n"
    assert filled(template, {"b": none, "c": none}, {"n": 2}) == "# A\n\n2 of it\n"


# -- the committed report --------------------------------------------------------------------------


@pytest.mark.parametrize("name", make.STUDIES)
def test_every_study_is_committed_with_its_page_and_figures(name):
    results = committed(name)
    assert not results["quick"]
    page = make.page(results)
    assert (COMMITTED / f"{name}.md").read_text() == page
    assert page.split("\n\n")[2].startswith("Made by polhode ")
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
def test_stale_files_are_made_again_and_named(tmp_path):
    for name in ("events.json", "events.md"):
        (tmp_path / name).write_bytes((COMMITTED / name).read_bytes())
    page = (tmp_path / "events.md").read_text()
    (tmp_path / "events.md").write_text(page.replace("Events", "events", 1) + "more\n")
    changed = make.write_stale(tmp_path, ["events"])
    assert sorted(path.name for path in changed) == ["events.md", "events.svg"]
    assert (tmp_path / "events.md").read_text() == page
    assert make.write_stale(tmp_path, ["events"]) == []


@pytest.mark.parametrize("name", make.STUDIES)
def test_every_table_and_every_fact_stands_on_the_page_once_and_is_explained(name):
    results, study = committed(name), make.module(name)
    own, facts = make.tables(name, results), study.facts(results)
    assert {*own} == {*study.tables(results)}
    text = kit.TABLE.sub("", make.template(name))
    named = [field for _, field, _, _ in Formatter().parse(text) if field is not None]
    assert not {*own} & {*facts}
    assert {field.partition("[")[0] for field in named} == {*facts, "question", "origin"}
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
    assert all(x.again or place in ("summary", "standing", "faults") for place, x in own.items())
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
            *(("accuracy", 0), ("proofs", 0), ("stability", 0), ("events", 0)),
            *(("speed", 1), ("accuracy", 1), ("stability", 1), ("long-run", 1)),
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
        assert make.page(results).startswith(make.page(whole).partition("\n")[0])


def one_run_less(case: str) -> Any:
    def change(results: JsonObject) -> None:
        del next(row["runs"] for row in results["cases"] if row["case"] == case)[0]

    return change


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("accuracy", one_run_less("kovalevskaya/generic")),
        ("stability", one_run_less("hard/near-cusp")),
        ("proofs", lambda results: results["orbits"][0]["orbits"].pop(0)),
    ],
)
def test_a_row_less_is_a_mark_less(name, change):
    results, study = committed(name), make.module(name)
    before = study.svgs(results)[name].count("<use ")
    change(results)
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


def rows_of(name: str, *texts: str) -> JsonObject:
    """Rows of a study, made again."""
    rows: JsonObject = make.module(name).rows(False, print, Only(texts))
    return json.loads(json.dumps(rows))


@pytest.mark.slow
def test_rows_made_today_agree_with_the_committed_ones():
    (today,) = rows_of("accuracy", "euler/smallest-axis")["cases"]
    (before,) = (x for x in committed("accuracy")["cases"] if x["case"] == "euler/smallest-axis")
    assert [run["outcome"] for run in today["runs"]] == ["reached end"] * 4
    for run, then in zip(today["runs"], before["runs"], strict=True):
        assert abs(run["correct_digits"] - then["correct_digits"]) < 1
        assert (run["number"], run["outcome"]) == (then["number"], then["outcome"])
    (motion,) = rows_of("events", "euler/largest-axis")["motions"]
    for run in (*motion["near"], *motion["far"]):
        assert run["found"] == run["true"] > 0
        assert run["ulps"] < 1e4


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in make.STUDIES if name != "speed"])
def test_a_quick_study_is_made(name, tmp_path):
    """From outside, as CONTRIBUTING tells; each wrote its page, which is of its rows."""
    command = [sys.executable, make.__file__, name, "--quick", "-o", str(tmp_path)]
    ended = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    results = make.results_of(tmp_path, name)
    assert results["quick"]
    assert (tmp_path / f"{name}.md").read_text() == make.page(results)
    assert (tmp_path / f"{name}.svg").exists()


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


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["acuracy"], "expected speed, accuracy"),
        (["--only", "x"], "NAME of one study"),
        (["accuracy", "--only", "no such case"], "part of the name of a row, such as"),
        (["benchmark", "--only", "lagrange", "-o", "x"], "expected euler-largest-axis"),
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
    zeros = events.Zeros(scene, "q")
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
