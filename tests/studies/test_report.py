"""The report: whole, resumed where it stopped, and the committed one is today's."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from polhode.cli import main
from polhode.common.errors import BadInput
from polhode.common.provenance import digest
from polhode.judging.diagnosis.error_budget import selected
from polhode.scenes import library
from polhode.studies import report
from polhode.studies.accuracy import rows as accuracy
from polhode.studies.events import rows as events

COMMITTED = Path(__file__).parents[2] / "reports"
#: Studies whose quick form takes longer than a test may.
SLOW = ("stability", "events")
#: Studies that a test can hold against the committed ones; those of timings are not among them.
COMPARED = ("accuracy", *SLOW)


def committed(name: str) -> dict[str, Any]:
    found = report.results(COMMITTED, name)
    assert found is not None, name
    return found


# -- the committed report ---------------------------------------------------------------------


@pytest.mark.parametrize("name", report.STUDIES)
def test_every_study_is_committed_with_its_page_and_figures(name):
    found = committed(name)
    assert not found["quick"]
    page = report.page(found)
    assert (COMMITTED / f"{name}.md").read_text() == page
    shown = re.findall(r"^!\[.*\]\((.*)\.svg\)$", page, re.M)
    assert sorted(shown) == sorted(report.figures(found))
    for figure in shown:
        assert (COMMITTED / f"{figure}.svg").read_text().startswith("<?xml")
    assert f'<section id="{name}">' in (COMMITTED / report.PAGE).read_text()


def test_the_committed_report_covers_every_case_as_it_is():
    found = committed("accuracy")
    assert [case["case"] for case in found["cases"]] == library.names()
    for case in [*found["cases"], *committed("stability")["cases"]]:
        assert case["sha256"] == digest(library.load(case["case"]).source), case["case"]


@pytest.mark.parametrize("name", ["accuracy", "stability"])
def test_every_case_stands_in_a_table_of_the_page(name):
    found = committed(name)
    page = report.page(found)
    for case in found["cases"]:
        assert f"\n| {case['case']} | " in page, case["case"]


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPARED)
def test_a_quick_study_agrees_with_the_committed_one(name, tmp_path):
    """Digits within one across machines and versions; outcomes, counts and verdicts the same."""
    report.write_study(name, tmp_path, quick=True)
    today = report.results(tmp_path, name)
    assert today is not None
    assert today["quick"]
    assert differences(today, committed(name)) == []


DIGITS = {"correct_digits", "digits_bound", "inputs", "digits", "digits_right", "reference_digits"}
SAME = {
    *("outcome", "regime", "reference", "verdict", "printed", "ours", "lost", "stands", "changed"),
    *("true", "found", "grazing", "complete", "touches", "cusps", "as_expected", "exit_code"),
    *("rests", "sha256", "target", "within", "inside", "kind"),
}
IDS = ("case", "number", "zero", "quantity", "t", "cite", "shift", "limit", "end", "reference")
UNCOMPARED = {"provenance", "kinds", "cost", "samples", "lines"}


def _name(row: dict[str, Any]) -> tuple[str, ...]:
    """What tells a row from its neighbours."""
    return tuple(str(row[key]) for key in IDS if row.get(key) is not None)


def differences(today: Any, before: Any, where: str = "") -> list[str]:
    """Where two results of one study differ by a digit or in words; rows are matched by name."""
    found: list[str] = []
    for key, value in today.items():
        here, old = f"{where}/{key}", before.get(key)
        if key in UNCOMPARED:
            continue
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = {_name(row): row for row in old}
            for row in value:
                label = f"{here}[{', '.join(_name(row))}]"
                if _name(row) in rows:
                    found += differences(row, rows[_name(row)], label)
                else:
                    found.append(f"{label} is new")
        elif isinstance(value, dict):
            found += differences(value, old, here)
        elif key in DIGITS:
            if (value is None) != (old is None) or (old is not None and abs(value - old) >= 1):
                found.append(f"{here}: {old} was, {value} is")
        elif key in SAME and value != old:
            found.append(f"{here}: {old!r} was, {value!r} is")
    return found


def test_differences_are_seen():
    def row(case: str, digits: float, outcome: str = "reached end") -> dict[str, Any]:
        return {"case": case, "correct_digits": digits, "outcome": outcome}

    before = {"cases": [row("a", 14.2), row("b", 3.0)]}
    assert differences({"cases": [row("b", 3.9)]}, before) == []
    assert differences({"cases": [row("b", 4.0)]}, before)
    assert differences({"cases": [row("b", 3.0, "step limit")]}, before)
    assert differences({"cases": [row("c", 3.0)]}, before)


@pytest.mark.slow
def test_a_study_is_deterministic():
    one, two = (accuracy._case(library.load("euler/separatrix")) for _ in range(2))
    assert one == two


# -- writing and resuming ---------------------------------------------------------------------


class Studies:
    """The committed rows in place of two studies' own; counts how often each is run."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.runs: list[str] = []
        self.interrupted = False
        monkeypatch.setattr(report, "STUDIES", ("events", "accuracy"))
        for module in (events, accuracy):
            monkeypatch.setattr(module, "rows", self._rows(module.NAME))

    def _rows(self, name: str) -> Any:
        kept = committed(name)
        del kept["provenance"]

        def rows(quick: bool, tick: Any) -> dict[str, Any]:
            if self.interrupted and name == "accuracy":
                raise KeyboardInterrupt
            self.runs.append(name)
            if tick is not None:
                tick(f"{name}: half")
            return kept | {"quick": quick}

        return rows


def test_a_report_that_was_killed_goes_on_where_it_stopped(tmp_path, monkeypatch):
    studies, said = Studies(monkeypatch), []
    studies.interrupted = True
    with pytest.raises(KeyboardInterrupt):
        report.write_report(tmp_path, tick=said.append)
    assert [p.name for p in tmp_path.iterdir()] == ["events.json"]  # whole, and nothing else
    studies.interrupted = False
    paths = report.write_report(tmp_path, tick=said.append)
    assert studies.runs == ["events", "accuracy"]
    assert "2 of 2: accuracy: half" in said
    assert sorted(tmp_path.iterdir()) == sorted(paths)
    assert {p.suffix for p in paths} == {".json", ".md", ".svg", ".html"}
    report.write_report(tmp_path, tick=said.append)
    assert studies.runs == ["events", "accuracy"]


@pytest.mark.slow
@pytest.mark.parametrize("change", ["fresh", "quick", "text", "cut short", "code"])
def test_results_that_are_not_todays_are_made_again(change, tmp_path, monkeypatch):
    studies = Studies(monkeypatch)
    report.write_report(tmp_path, tick=print)
    path = tmp_path / "events.json"
    if change == "text":
        path.write_text(path.read_text().replace('"key": "', '"key": "0'))
    elif change == "cut short":
        path.write_text(path.read_text()[:1000])
    elif change == "code":
        key = report.key
        monkeypatch.setattr(report, "key", lambda name, quick: "new" + key(name, quick))
    report.write_report(tmp_path, quick=change == "quick", fresh=change == "fresh", tick=print)
    every = change in ("fresh", "quick", "code")
    assert studies.runs == ["events", "accuracy", "events"] + ["accuracy"] * every


def test_pages_are_made_from_the_results_alone(tmp_path, monkeypatch):
    Studies(monkeypatch)
    paths = report.write_report(tmp_path, tick=print)
    texts = {path: path.read_text() for path in paths}
    for path in paths:
        if path.suffix != ".json":
            path.unlink()
    assert report.write_pages(tmp_path) == paths
    assert {path: path.read_text() for path in paths} == texts


def test_one_study_leaves_the_others_as_they_are(tmp_path, monkeypatch):
    studies = Studies(monkeypatch)
    report.write_report(tmp_path, tick=print)
    before = (tmp_path / "accuracy.json").read_text()
    report.write_study("events", tmp_path, quick=True)
    assert studies.runs == ["events", "accuracy", "events"]
    assert (tmp_path / "accuracy.json").read_text() == before
    assert json.loads((tmp_path / "events.json").read_text())["quick"]
    assert "--quick" in (tmp_path / "events.md").read_text()


def test_a_key_changes_with_every_module_and_nothing_beside_them(tmp_path, monkeypatch):
    """As in an installed copy, where Python leaves what it compiled beside its modules."""
    package = tmp_path / "polhode"
    shutil.copytree(report.PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(report, "PACKAGE", package)
    before = report.key("events", False)
    for beside in ("__pycache__/cli.cpython-311.pyc", "studies/new.so", "notes.txt", "._cli.pyc"):
        (package / beside).parent.mkdir(exist_ok=True)
        (package / beside).write_bytes(b"\xf3\r\r\n\x00")
    assert report.key("events", False) == before
    keys = {before, report.key("events", True)}
    for module in ("cli.py", "closed_forms/euler/top.py", "studies/events/page.py", "new.py"):
        with (package / module).open("ab") as file:
            file.write(b"\n# changed \xf3\n")  # and one that is no UTF-8
        keys.add(report.key("events", False))
    assert len(keys) == 2 + 4


@pytest.mark.slow
def test_a_folder_that_is_missing_is_made(tmp_path, monkeypatch):
    Studies(monkeypatch)
    report.write_study("events", tmp_path / "new" / "deep")
    assert (tmp_path / "new" / "deep" / "events.json").is_file()


def test_a_folder_that_cannot_be_made_is_refused_before_the_work(tmp_path):
    (tmp_path / "file").touch()
    for write in (report.write_report, lambda folder: report.write_study("accuracy", folder)):
        with pytest.raises(BadInput, match="a folder to write to"):
            write(tmp_path / "file" / "below")


@pytest.mark.parametrize("name", report.GONE)
def test_a_study_that_went_names_what_there_is_instead(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for more in ([], ["--only", "x"], ["--quick"]):
        assert main(["study", name, *more, "-o", "out"]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.endswith(f"; {name} is a study no more, see {report.GONE[name]}")
    assert not [*tmp_path.iterdir()]


def test_all_that_the_reports_link_to_is_there_and_nothing_else_is():
    linked = {"report.html", "looping.gif"}  # README's
    for page in COMMITTED.glob("*.md"):
        linked.add(page.name)
        for target in re.findall(r"\]\(([^)#]+)[)#]", page.read_text()):
            if not target.startswith("http"):
                assert (COMMITTED / target).is_file(), (page.name, target)
                linked.add(target)
    linked |= {f"{name}.json" for name in report.STUDIES}
    files = {path.relative_to(COMMITTED).as_posix() for path in COMMITTED.rglob("*.*")}
    assert {name for name in files - linked if not name.startswith("benchmark/")} == set()


def test_the_gallery_has_a_picture_of_each_motion_of_its_loop():
    text = (COMMITTED / "gallery.md").read_text()
    rows = re.findall(r"^([\w-]+/[\w-]+) (\d+)$", text, re.M)
    assert len(rows) > 20
    for case, end in rows:
        assert f"[{case}](../cases/{case}.toml) to t = {end}" in " ".join(text.split())
        assert f"(gallery/{case.replace('/', '-')}.svg)" in text


def test_an_unknown_study_is_refused_with_the_nearest_name(tmp_path):
    with pytest.raises(BadInput, match="did you mean 'stability'"):
        report.write_study("stabilty", tmp_path)


# -- the verdicts of the committed report ------------------------------------------------------

STEP = 0.01  # digits are kept to two places


def judged() -> list[dict[str, Any]]:
    """The runs of the library and of the hard cases that were judged against what is expected."""
    cases = [*committed("accuracy")["cases"], *committed("stability")["cases"]]
    runs = [{"case": case["case"], **run} for case in cases for run in case["runs"]]
    return [run for run in runs if run.get("correct_digits") is not None and run["expected"]]


def misjudged(runs: list[dict[str, Any]]) -> list[str]:
    """Runs whose verdict the band contradicts.

    *conditioning* and *inputs* are of runs that lose no more than the band and the choice of the
    worst time allow, *method* of those that lose more.
    """
    found = []
    for run in runs:
        digits = run["correct_digits"]
        least = run["expected"][0] - selected(run.get("times", 1))
        word = run["limit"].split()[0]
        below, inside = digits < least - STEP, digits > least + STEP
        if (word in ("conditioning", "inputs") and below) or (word == "method" and inside):
            found.append(f"{run['case']}, {run['number']}: {word}, {digits} of {run['expected']}")
    return found


def test_no_verdict_of_the_library_contradicts_its_band():
    runs = judged()
    assert len(runs) > 800
    words = {run["limit"].split()[0] for run in runs}
    assert {"conditioning", "inputs", "method", "rounding"} <= words
    assert misjudged(runs) == []


def test_a_verdict_that_contradicts_its_band_is_seen():
    runs = [dict(run) for run in judged()]
    beyond = next(r for r in runs if r["limit"].startswith("method") and r["correct_digits"] > 3)
    sure = [r for r in runs if r["correct_digits"] > r["expected"][0] + STEP]
    within = next(r for r in sure if r["limit"] == "conditioning" and r["expected"][0] > 3)
    swapped = [beyond | {"limit": "conditioning"}, within | {"limit": "method (of it)"}]
    least = beyond["expected"][0] - selected(beyond.get("times", 1))
    close = least - beyond["correct_digits"] <= STEP
    assert len(misjudged(swapped)) == 2 - close


def test_nine_in_ten_runs_of_the_library_end_in_the_band():
    """Of runs that have digits left; 85 to 95 % of them, the worst over the output times."""
    cases = committed("accuracy")["cases"]
    runs = [run for case in cases for run in case["runs"] if run.get("correct_digits") is not None]
    runs = [run for run in runs if run["expected"] and run["expected"][2] > 0]
    inside = sum(e[0] <= run["correct_digits"] <= e[2] for run in runs for e in [run["expected"]])
    assert 0.85 <= inside / len(runs) <= 0.95
