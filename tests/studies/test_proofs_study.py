"""The study of proofs: its rows, and page and figure that are made of them alone."""

from __future__ import annotations

import pytest

from polhode.studies import report
from polhode.studies.proofs import figure, page, rows
from shared.reports import committed


def test_what_is_committed_is_what_was_asked():
    found = committed("proofs")
    assert [one["what"] for one in found["orbits"]] == [*rows.ORBITS]
    assert [one["what"] for one in found["chaos"]] == [*rows.CHAOS]
    orbits = [row for one in found["orbits"] for row in one["orbits"]]
    proved = [row for row in orbits if row["proved"]]
    assert len(proved) >= 60
    assert {row["kind"] for row in proved} == {"elliptic", "hyperbolic", "inverse hyperbolic"}
    for row in proved:
        assert row["digits"] >= rows.DIGITS
        assert float(row["least_period"]) == pytest.approx(row["period"], rel=1e-6)
        inside = {"elliptic": 0 < row["residue"] < 1, "hyperbolic": row["residue"] < 0}
        assert inside.get(row["kind"], row["residue"] > 1)
    assert all(len(row["cause"]) > 10 for row in orbits if not row["proved"])


@pytest.mark.slow
def test_page_and_figures_follow_from_the_rows():
    found = committed("proofs")
    orbits = [row for one in found["orbits"] for row in one["orbits"]]
    orbits[0] |= {"proved": False, "cause": "a reason"}
    facts = page.facts(found)
    assert facts["proved"] == f"{sum(row['proved'] for row in orbits)} of {len(orbits)}"
    assert page.facts({**found, "orbits": [], "chaos": []})["seconds"] == "–"
    assert [*figure.svgs(found)] == ["proofs", "manifolds"]
    for row in found["chaos"]:
        row.pop("drawn", None)
    assert "manifolds.svg" not in report.page(found)
    assert [*figure.svgs(found)] == ["proofs"]


def test_the_column_of_stable_orbits_counts_the_elliptic_ones():
    found = committed("proofs")
    assert "stable" not in page.tables(found)["orbits"].header
    for one in found["orbits"]:
        elliptic = [row for row in one["orbits"] if row.get("kind") == "elliptic"]
        for n, row in enumerate(elliptic):
            row["stable"] = n > 0
    table = page.tables(found)["orbits"]
    place = table.header.index("stable")
    for one, cells in zip(found["orbits"], table.rows, strict=True):
        count = sum("stable" in row for row in one["orbits"])
        assert cells[place] == (f"{count - 1} of {count}" if count else "–")


@pytest.mark.slow
def test_elliptic_orbits_of_a_search_are_proved_to_be_stable():
    found = rows.rows(True, lambda text: None, lambda name: True)
    orbits = [row for one in found["orbits"] for row in one["orbits"] if row["proved"]]
    stable = [row for row in orbits if row.get("stable")]
    assert stable
    assert all(row["kind"] == "elliptic" and row["twist"] for row in stable)
    assert {row["kind"] for row in orbits if "stable" not in row} <= {
        *("hyperbolic", "inverse hyperbolic")
    }
