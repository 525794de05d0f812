"""The page of published figures: values, printouts of simulations, and figures recomputed here."""

from __future__ import annotations

import copy
from pathlib import Path

import pytest

from polhode.output.json_object import JsonObject
from polhode.scenes import library
from polhode.studies import report
from polhode.studies.page.blocks import Heading, PageTable
from polhode.studies.published import page

COMMITTED = Path(__file__).parents[2] / "reports"


@pytest.fixture
def found() -> JsonObject:
    made = report.results(COMMITTED, "published")
    assert made is not None
    return copy.deepcopy(made)


def tables(found: JsonObject) -> dict[str, PageTable]:
    """The tables under their headings."""
    made, heading = {}, ""
    for block in page.blocks(found):
        if isinstance(block, Heading):
            heading = block.text
        elif isinstance(block, PageTable):
            made[heading] = block
    return made


def test_printed_and_recomputed_figures_stand_in_tables_of_their_own(found):
    made = tables(found)
    for case in found["cases"]:
        own = sum(row["recomputed"] for row in case["figures"])
        for where, count in (
            ("recomputed here", own),
            ("printed elsewhere", len(case["figures"]) - own),
        ):
            heading = f"{case['title']}: {where}"
            assert (len(made[heading].rows) if heading in made else 0) == count, heading


def test_a_printout_of_a_simulation_is_told_by_its_cite():
    cites = {p.cite for name in library.names() for p in library.load(name).published}
    printouts = {cite for cite in cites if page.is_printout({"cite": cite})}
    assert {cite.partition(",")[0].split(" case")[0] for cite in printouts} == {
        "NASA/TM-2015-218675",
        "Kynema",
    }
    assert len(printouts) == 6
    assert not [cite for cite in printouts if "recomputed" in cite]


def test_a_printout_is_not_held_to_the_digits_that_it_shows(found):
    made = tables(found)
    told = page.finding(found)
    assert "Of 9 figures that others give as values, 6 are right" in told
    assert "18 figures are printouts of simulations" in told
    assert all(
        "NASA" in row[0] or "Kynema" in row[0] for row in made["Printouts of simulations"].rows
    )
    assert not [row for row in made["Values that differ from ours"].rows if "NASA" in row[0]]
    brick = made["NASA check case 2, torque-free tumbling brick: printed elsewhere"]
    verdicts = {row[brick.header.index("verdict")] for row in brick.rows}
    assert all(verdict.startswith("agrees to ") for verdict in verdicts)
    for case in found["cases"]:
        for row in case["figures"]:
            row["cite"] = row["cite"].replace("simulation", "table")
    assert "15 figures" not in page.finding(found)
    assert "Of 24 figures that others give as values" in page.finding(found)
