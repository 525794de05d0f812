"""Marks of the studies' figures say what the rows behind them hold."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import pytest

from polhode.output.json_object import JsonObject
from polhode.studies import report

COMMITTED = Path(__file__).parents[2] / "reports"
SVG = "{http://www.w3.org/2000/svg}"


def said(study: str, figure: str) -> tuple[JsonObject, Counter[str]]:
    """The committed results of a study, and what the marks of its figure say."""
    found = report.results(COMMITTED, study)
    assert found is not None
    marks = ElementTree.fromstring(report.figures(found)[figure].encode()).iter(f"{SVG}use")
    return found, Counter(t.text or "" for mark in marks for t in mark.iter(f"{SVG}title"))


def beginnings(texts: Counter[str], end: str) -> Counter[str]:
    """The texts up to the first place where one has ``end``."""
    found: Counter[str] = Counter()
    for text, count in texts.items():
        found[text[: text.index(end) + len(end)]] += count
    return found


def digits_of(case: str, run: JsonObject) -> str:
    return f"{case}, {run['number']}: {run['correct_digits']:.1f} digits"


def test_every_run_of_every_case_has_its_dot():
    found, texts = said("accuracy", "accuracy")
    runs = [(case["case"], run) for case in found["cases"] for run in case["runs"]]
    wanted = Counter(digits_of(case, run) for case, run in runs if "correct_digits" in run)
    assert beginnings(texts, " digits") == wanted
    assert wanted.total() > 600


def test_every_run_of_every_hard_case_has_its_dot():
    found, texts = said("stability", "stability")
    runs = {case["case"]: case["runs"] for case in found["cases"]}
    wanted = Counter(
        digits_of(name, run)
        for kind in found["kinds"]
        for name in kind["cases"]
        for run in runs.get(name, ())
        if "correct_digits" in run
    )
    assert beginnings(texts, " digits") == wanted


def test_every_orbit_says_its_period_and_whether_it_is_proved():
    found, texts = said("proofs", "proofs")
    orbits = [(top["what"], row) for top in found["orbits"] for row in top["orbits"]]
    wanted = Counter(f"{what}: period {row['period']:.6g}" for what, row in orbits)
    assert Counter(text.partition(", residue")[0] for text in texts.elements()) == wanted
    refused = [text for text in texts.elements() if "not proved: " in text]
    assert len(refused) == sum(not row["proved"] for _, row in orbits)
    proved = Counter(int(row["digits"]) for _, row in orbits if row["proved"])  # no digit more
    told = [
        int(text.rpartition("proved to ")[2].split()[0])
        for text in texts.elements()
        if "proved to" in text
    ]
    assert Counter(told) == proved


@pytest.mark.parametrize(
    ("study", "figure"),
    [("long-run", "long-run"), ("speed", "speed"), ("speed", "lengths"), ("events", "events")],
)
def test_other_figures_say_numbers_at_every_mark(study, figure):
    found, texts = said(study, figure)
    svg = report.figures(found)[figure]
    assert texts.total() > 30
    assert all(any(character.isdigit() for character in text) for text in texts)
    for group in svg.split('<g class="marks">')[1:]:  # no mark of a group is silent
        marks = group.split("</g>")[0]
        assert marks.count("<use ") == marks.count("<title>") > 0


@pytest.mark.filterwarnings("error")
def test_a_study_of_which_a_part_has_no_rows_has_its_figures():
    empty: list[JsonObject] = [
        {"study": "events", "motions": [], "cost": []},
        {"study": "accuracy", "cases": []},
        {"study": "proofs", "orbits": [{"what": "a top", "orbits": []}], "chaos": []},
    ]
    for found in empty:
        (drawn,) = report.figures(found).values()
        assert "<title>" not in drawn
