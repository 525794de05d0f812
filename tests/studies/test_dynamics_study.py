"""The study of dynamics: its rows, and page and figures that are made of them alone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from polhode.output.json_results import as_json
from polhode.studies import report
from polhode.studies.dynamics import cost, figure, page, rows
from polhode.studies.page.blocks import markdown
from polhode.studies.row_filter import Only

COMMITTED = Path(__file__).parents[2] / "reports"


@pytest.mark.slow
def test_a_section_row_has_its_curve_and_its_spread():
    found = rows.rows(True, None, Only(("section Kovalevskaya",)))
    (row,) = found["sections"]
    assert row["crossings"] == rows.LONG
    assert 0.5 < row["spread_in_eps"] < 12
    assert row["spread"] == pytest.approx(row["spread_in_eps"] * row["scale"] * 2**-52, rel=0.01)
    field = np.array([np.nan if x is None else x for x in row["field"]]).reshape(row["cells"])
    # the exact curve passes where the orbit crossed: the nearest cells' values enclose the orbit's
    inside = 0
    for value, l, ratio in zip(row["values"], row["l"], row["ratio"], strict=True):
        for x, y in zip(l, ratio, strict=True):
            i = int(x / (2 * np.pi) * row["cells"][0] - 0.5)
            j = int((y + 1) / 2 * row["cells"][1] - 0.5)
            near = field[max(i - 1, 0) : i + 3, max(j - 1, 0) : j + 3]
            inside += bool(near.min() <= value <= near.max())
    assert inside > 0.9 * row["orbits"] * rows.SHOWN


@pytest.mark.slow
def test_a_levels_row_is_what_levels_says():
    found = rows.rows(False, None, Only(("levels asymmetric",)))
    (row,) = found["levels"]
    assert (row["cusps"], row["hopf"], row["fourth"]) == (2, 2, None)
    assert row["topology"] == "S3"
    assert len(row["columns"]) >= rows.COLUMNS
    assert all(len(c[1]) == len(c[2]) for c in row["columns"])


def test_the_map_holds_the_three_integrable_bodies():
    row = rows._map((7, 3))
    assert [sum(c["counts"]) == c["motions"] == 3 for c in row["columns"]] == [True] * 3
    assert all(c["counts"][2] == 0 for c in row["columns"])
    assert sum(row["counts"].values()) == 21 == len(row["verdict"])
    assert {0.5, 1.0, 2.0} <= set(row["x"])


@pytest.mark.slow
def test_other_programs_make_the_same_crossings():
    pytest.importorskip("scipy")
    told = [r for r in cost.rows(True, Only(), lambda _: None) if r["outcome"] == "done"]
    assert len(told) >= 3
    for row in told:
        assert row["crossings"] in (10, 480)
        assert row["error"] < (1e-13 if row["program"].startswith("polhode") else 1e-10)
        assert row["microseconds"] > 0


def test_a_program_that_is_missing_keeps_its_row(monkeypatch):
    def missing():
        raise ImportError("No module named 'else'", name="else")

    monkeypatch.setattr(cost, "_others", lambda *_: {"else": missing})
    (row,) = cost.rows(True, Only(("cost else",)), lambda _: None)
    assert row["outcome"] == "else is not installed"
    assert "else is not installed" in markdown("x", page._cost([row]))


def test_the_page_is_made_from_the_json_alone():
    found = report.results(COMMITTED, "dynamics")
    assert found is not None
    assert len(found["levels"]) == 6
    assert [row["what"] for row in found["sections"]] == [top.what for top in rows.TOPS]
    text = markdown(page.TITLE, page.blocks(found))
    for row in [*found["levels"], *found["sections"]]:
        assert f"| {row['what']} | {row['case']} |" in text
    told = page.finding(found)
    assert "of 93 motions of integrable bodies 0 are found chaotic" in told
    alone = told.partition("a crossing of one orbit takes")[2].partition("in batches")[0]
    assert "(polhode, one orbit)" in alone  # it is not hidden, and comes before batches


@pytest.mark.slow
def test_figures_are_made_from_the_json_alone():
    found = report.results(COMMITTED, "dynamics")
    assert found is not None
    drawn = figure.svgs(found)
    assert drawn == figure.svgs(json.loads(as_json(found)))
    assert {*drawn} == {"dynamics-levels", "dynamics-sections", "dynamics-map"}


def test_stretches_of_a_column_are_bars():
    assert figure._runs(np.array([True, True, False, True])) == [(0, 2), (3, 4)]
    assert figure._runs(np.array([False, False])) == []
