"""The report: whole, resumed where it stopped, and the committed one is today's."""

from __future__ import annotations

import json
import re
import shutil
from base64 import b64decode
from collections.abc import Iterator
from typing import Any

import pytest

from polhode.common.provenance import digest
from polhode.judging.limits import selected
from polhode.scenes import library
from polhode.studies import report
from polhode.studies.accuracy import rows as accuracy
from polhode.studies.events import rows as events
from shared.reports import COMMITTED, committed

# -- the committed report ---------------------------------------------------------------------


@pytest.mark.parametrize("name", report.STUDIES)
def test_every_study_is_committed_with_its_page_and_figures(name):
    found = committed(name)
    assert not found["quick"]
    page = report.page(found)
    assert (COMMITTED / f"{name}.md").read_text() == page
    shown = re.findall(r"^!\[.*\]\((.*)\.svg\)$", page, re.M)
    assert shown
    for figure in shown:
        assert (COMMITTED / f"{figure}.svg").read_text().startswith("<?xml")
    for case in found.get("cases", []):
        assert f"\n| {case['case']} | " in page, case["case"]
        assert case["sha256"] == digest(library.load(case["case"]).source), case["case"]
    if name == "accuracy":
        assert [case["case"] for case in found["cases"]] == library.names()


@pytest.mark.parametrize("name", report.STUDIES)
def test_a_page_says_at_its_head_what_made_it_and_where_and_how_long_it_takes(name):
    origin = committed(name)["provenance"]
    head = report.page(committed(name)).split("\n\n")[2]
    assert head == f"Made by polhode {origin['versions']['polhode']} on {origin['cpu']}."
    assert 0.5 < report.STUDIES[name][0] / origin["seconds"] < 2


@pytest.mark.sample(0, slow=2)
@pytest.mark.parametrize("name", ["events", "long-run", "proofs", "stability"])
def test_the_figures_of_a_study_are_those_of_its_page(name):
    found = committed(name)
    shown = re.findall(r"^!\[.*\]\((.*)\.svg\)$", report.page(found), re.M)
    assert sorted(shown) == sorted(report.figures(found))


#: What may move by less than a digit across machines and versions, and what may not at all.
DIGITS = {"correct_digits", "digits_bound", "inputs", "digits", "digits_right"}
SAME = {
    *("outcome", "regime", "reference", "printed", "ours", "lost", "stands", "true", "found"),
    *("grazing", "complete", "sha256", "inside", "kind"),
}
IDS = ("case", "number", "zero", "quantity", "t", "cite", "reference")


def numbers(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """What is compared of a study's results, by its place; rows go by what they are called."""
    if isinstance(value, dict):
        for key, x in value.items():
            yield from numbers(x, (*path, key))
    elif isinstance(value, list):
        for row in [row for row in value if isinstance(row, dict)]:
            yield from numbers(row, (*path, *(row.get(key) for key in IDS)))
    elif path[-1] in DIGITS | SAME:
        yield path, value


@pytest.mark.sample(0, first=1, slow=1)
@pytest.mark.parametrize(
    ("name", "part", "least"),
    [("accuracy", ["euler/smallest-axis"], 10), ("events", ["euler/largest-axis"], 10)],
)
def test_rows_made_today_agree_with_the_committed_ones(name, part, least):
    today, before = dict(numbers(report.part(name, part)[0])), dict(numbers(committed(name)))
    assert len(today) > least
    for path, x in today.items():
        if path[-1] in DIGITS and None not in (x, before[path]):
            assert abs(x - before[path]) < 1, path
        else:
            assert x == before[path], path


# -- writing and resuming ---------------------------------------------------------------------


class Studies:
    """The committed rows in place of two studies' own; counts how often each is run."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.runs: list[str] = []
        self.interrupted = False
        monkeypatch.setattr(report, "STUDIES", {"events": (90, 30), "accuracy": (600, 60)})
        for name, module in (("events", events), ("accuracy", accuracy)):
            monkeypatch.setattr(module, "rows", self._rows(name))

    def _rows(self, name: str) -> Any:
        kept = committed(name)
        del kept["provenance"]
        few = {"cases": 3, "motions": 1, "cost": 1}  # fewer rows are drawn sooner
        kept |= {key: kept[key][:count] for key, count in few.items() if key in kept}

        def rows(quick: bool, say: Any, wanted: Any) -> dict[str, Any]:
            if self.interrupted and name == "accuracy":
                raise KeyboardInterrupt
            self.runs.append(name)
            say("half")
            return kept | {"quick": quick}

        return rows


@pytest.fixture
def studies(monkeypatch):
    return Studies(monkeypatch)


@pytest.mark.slow
def test_a_report_that_was_killed_goes_on_where_it_stopped(studies, tmp_path):
    said: list[str] = []
    foretold: list[str] = []
    studies.interrupted = True
    with pytest.raises(KeyboardInterrupt):
        report.write_report(tmp_path, tick=said.append, foretell=foretold.append)
    assert [p.name for p in tmp_path.iterdir()] == ["events.json"]  # whole, and nothing else
    studies.interrupted = False
    paths = report.write_report(tmp_path, tick=said.append, foretell=foretold.append)
    assert studies.runs == ["events", "accuracy"]
    assert [text for text in said if "half" in text] == [
        "1 of 2: events: half",
        "1 of 1: accuracy: half",
    ]
    assert sorted(tmp_path.iterdir()) == sorted(paths)
    assert {p.suffix for p in paths} == {".json", ".md", ".svg", ".html"}
    texts = {path: path.read_text() for path in paths}
    for path in paths:
        if path.suffix != ".json":
            path.unlink()
    assert report.write_pages(tmp_path) == paths  # from the results alone
    assert {path: path.read_text() for path in paths} == texts
    assert report.write_report(tmp_path, foretell=foretold.append) == paths
    assert studies.runs == ["events", "accuracy"]
    goes_on = "on two processors; stopped, the same command goes on with the study that it was at"
    assert foretold == [
        f"events, accuracy: about 12 minutes {goes_on}",
        f"accuracy: about 10 minutes {goes_on}",
        "every study is of today's code: pages and figures alone are made",
    ]


@pytest.mark.sample(0, first=2, slow=1)
@pytest.mark.parametrize("change", ["fresh", "quick", "text", "cut short", "code"])
def test_results_that_are_not_todays_are_made_again(studies, change, tmp_path, monkeypatch):
    report.write_report(tmp_path)
    path = tmp_path / "events.json"
    if change == "text":
        path.write_text(path.read_text().replace('"key": "', '"key": "0'))
    elif change == "cut short":
        path.write_text(path.read_text()[:1000])
    elif change == "code":
        key = report.key
        monkeypatch.setattr(report, "key", lambda name, quick: "new" + key(name, quick))
    report.write_report(tmp_path, quick=change == "quick", fresh=change == "fresh")
    every = change in ("fresh", "quick", "code")
    assert studies.runs == ["events", "accuracy", "events"] + ["accuracy"] * every


@pytest.mark.slow
def test_one_study_leaves_the_others_as_they_are(studies, tmp_path):
    folder = tmp_path / "new" / "deep"
    report.write_study("accuracy", folder)
    before = (folder / "accuracy.json").read_text()
    report.write_study("events", folder, quick=True)
    assert studies.runs == ["accuracy", "events"]
    assert (folder / "accuracy.json").read_text() == before
    assert json.loads((folder / "events.json").read_text())["quick"]
    assert "--quick" in (folder / "events.md").read_text()


@pytest.mark.slow
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


# -- what the pages link to -----------------------------------------------------------------------


def test_the_report_begins_with_the_figure_that_everybody_looks_for():
    """Error against computing time stood third, behind strips of dots."""
    page = (COMMITTED / "report.html").read_text()
    listed = re.findall(r'<li><a href="#([\w-]+)">', page)
    assert listed == re.findall(r'<section id="([\w-]+)">', page) == [*report.STUDIES]
    assert listed[0] == "speed"
    first = re.search(r'<img src="data:image/svg\+xml;base64,([\w+/=]+)"', page)
    assert first is not None
    assert b64decode(first[1]).decode() == (COMMITTED / "speed.svg").read_text()


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
    text = (COMMITTED / "gallery.md").read_text()
    rows = re.findall(r"^([\w-]+/[\w-]+) (\d+)$", text, re.M)
    assert len(rows) > 20
    for case, end in rows:  # a picture of each motion of the gallery's loop
        assert f"[{case}](../cases/{case}.toml) to t = {end}" in " ".join(text.split())
        assert f"(gallery/{case.replace('/', '-')}.svg)" in text


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
    sure = [r for r in runs if r["correct_digits"] > r["expected"][0] + STEP]
    within = next(r for r in sure if r["limit"] == "conditioning" and r["expected"][0] > 3)
    assert misjudged([within | {"limit": "method (of it)"}])


def test_nine_in_ten_runs_of_the_library_end_in_the_band():
    """Of runs that have digits left; 85 to 95 % of them, the worst over the output times."""
    runs = [run for run in judged() if run["expected"][2] > 0]
    inside = sum(e[0] <= run["correct_digits"] <= e[2] for run in runs for e in [run["expected"]])
    assert 0.85 <= inside / len(runs) <= 0.95
