"""The accuracy report: deterministic, whole, and the committed one is today's."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from polhode import library, report
from polhode.errors import BadInput
from polhode.figures import accuracy as figure
from polhode.provenance import digest
from polhode.studies import accuracy

COMMITTED = Path(__file__).parents[1] / "reports"


def committed() -> dict:
    return json.loads((COMMITTED / "accuracy.json").read_text())


def test_the_committed_report_covers_every_case_as_it_is():
    found = committed()
    assert not found["quick"]
    assert [case["case"] for case in found["cases"]] == library.names()
    for case in found["cases"]:
        assert case["sha256"] == digest(library.load(case["case"]).source), case["case"]


def test_every_case_stands_in_a_table_of_the_page():
    found = committed()
    page = report.page(found)
    for case in found["cases"]:
        assert f"| {case['case']} |" in page, case["case"]


def test_page_and_figure_are_made_from_the_json_alone():
    found = committed()
    assert (COMMITTED / "accuracy.md").read_text() == report.page(found)
    assert figure.svg(found) == figure.svg(found)


def test_a_quick_report_agrees_with_the_committed_one(tmp_path):
    """Digits within one across machines and versions; regimes and published figures the same."""
    paths = report.write_report(tmp_path, quick=True)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(p.name for p in paths)
    today = json.loads((tmp_path / "accuracy.json").read_text())
    before = {case["case"]: case for case in committed()["cases"]}
    for case in today["cases"]:
        old = before[case["case"]]
        assert case["regime"] == old["regime"]
        assert case["published"] == old["published"]
        for mine, theirs in zip(case["runs"], old["runs"], strict=True):
            assert mine["outcome"] == theirs["outcome"]
            assert abs(mine["correct_digits"] - theirs["correct_digits"]) < 1


def test_a_report_is_deterministic():
    one, two = (accuracy._case(library.load("euler/separatrix")) for _ in range(2))
    assert one == two


def test_a_folder_that_is_missing_is_refused_before_the_work(tmp_path):
    with pytest.raises(BadInput, match="an existing folder"):
        report.write_report(tmp_path / "nowhere")
