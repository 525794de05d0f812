"""The study of proofs: its rows, and page and figure that are made of them alone."""

from __future__ import annotations

import copy
from pathlib import Path

import pytest

from polhode.studies import report
from polhode.studies.proofs import figure, page, rows

COMMITTED = Path(__file__).parents[2] / "reports"


@pytest.fixture
def found():
    made = report.results(COMMITTED, "proofs")
    assert made is not None
    return copy.deepcopy(made)


def test_what_is_committed_is_what_was_asked(found):
    assert [one["what"] for one in found["orbits"]] == [*rows.ORBITS]
    assert [one["what"] for one in found["chaos"]] == [*rows.CHAOS]
    orbits = [row for one in found["orbits"] for row in one["orbits"]]
    proved = [row for row in orbits if row["proved"]]
    assert len(proved) >= 60
    assert {row["kind"] for row in proved} == {"elliptic", "hyperbolic", "inverse hyperbolic"}
    for row in orbits:
        if not row["proved"]:
            assert len(row["cause"]) > 10
            continue
        assert row["digits"] >= rows.DIGITS
        assert float(row["least_period"]) == pytest.approx(row["period"], rel=1e-6)
        inside = {"elliptic": 0 < row["residue"] < 1, "hyperbolic": row["residue"] < 0}
        assert inside.get(row["kind"], row["residue"] > 1)


def test_what_the_page_counts_follows_from_the_rows(found):
    orbits = [row for one in found["orbits"] for row in one["orbits"]]
    told = page.facts(found)
    assert told["proved"] == f"{sum(row['proved'] for row in orbits)} of {len(orbits)}"
    orbits[0]["proved"] = False
    orbits[0]["cause"] = "a reason"
    assert page.facts(found)["proved"] == f"{sum(row['proved'] for row in orbits)} of {len(orbits)}"
    assert page.facts({**found, "orbits": [], "chaos": []})["seconds"] == "–"


@pytest.mark.slow
def test_page_and_figure_are_made_of_the_rows_alone(found):
    text = report.page(found)
    for what in (*rows.ORBITS, *rows.CHAOS):
        assert what in text
    for row in found["chaos"]:
        row.pop("drawn", None)
    assert "manifolds.svg" not in report.page(found)
    assert [*figure.svgs(found)] == ["proofs"]
    found = report.results(COMMITTED, "proofs")
    drawn = figure.svgs(found)
    assert [*drawn] == ["proofs", "manifolds"]
    assert all(text.startswith("<?xml") for text in drawn.values())


@pytest.mark.slow
def test_a_small_study_from_end_to_end():
    found = rows.rows(quick=True)
    (one,) = found["orbits"]
    assert one["orbits"]
    for row in one["orbits"]:
        assert row["proved"] == (row["cause"] == "" if "cause" in row else True)
        if row["proved"]:
            assert row["verified"]
            assert row["seconds"] < 60
