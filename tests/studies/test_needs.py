"""The table that the report begins with: commands run as they are typed, judged by others."""

from __future__ import annotations

import math

import pytest

from polhode.studies import report
from polhode.studies.needs import page, rows
from polhode.studies.page import html
from polhode.studies.page.blocks import Text
from polhode.studies.row_filter import Only


@pytest.mark.slow
def test_a_command_is_run_and_its_answer_judged():
    found = rows.rows(quick=True, only=Only(("my own program",)))
    (row,) = found["needs"]
    assert row["command"].startswith("polhode compare")
    assert 13 < row["digits"] < 15.96
    assert row["t"] == 30
    assert row["proven"]
    assert 0.01 < row["seconds"] < 60


def test_states_are_judged_against_the_reference_of_the_scene():
    import polhode

    scene = polhode.load("euler/largest-axis")
    (true,) = polhode.reference(scene).at([5], 30)
    exact = [str(x) for x in true]
    answer = {"scene": "euler/largest-axis", "times": ["5"], "states": [exact]}
    digits, _ = rows._of_states(answer)
    assert digits > 27
    off = {**answer, "states": [[*exact[:3], str(float(exact[3]) + 1e-7), *exact[4:]]]}
    assert rows._of_states(off)[0] == pytest.approx(7, abs=0.01)


def test_a_proof_and_a_comparison_tell_their_own_digits():
    assert rows._of_proof({"digits_proven": [20.0, 16.9]}) == (16.9, True)
    judged = {"correct_digits": [15.0, None, 12.5], "proven": False}
    assert rows._of_comparison(judged) == (12.5, False)
    assert math.isnan(rows._of_comparison({"correct_digits": [None], "proven": True})[0])


def test_the_table_stands_before_the_contents():
    row = {"need": "x", "command": "polhode run y", "digits": 12.34, "t": 1e9, "seconds": 0.5}
    found = {"needs": [{**row, "proven": True}]}
    parts = tuple(page.blocks(found))
    assert parts[0].rows == (("x", "`polhode run y`", "12.3", "0.5"),)
    other = html.Section("b", "B", "finding", (Text("text"),), {})
    lead = html.Section("needs", page.TITLE, page.finding(found), parts, {})
    text = html.page("t", [other, lead], report.LEAD)
    assert text.index("polhode run y") < text.index("<nav") < text.index("<h2>B")
    assert "needs" not in text[text.index("<nav") : text.index("</nav>")]


def test_every_command_names_a_case_that_ships():
    from polhode.scenes import library

    for need in rows.NEEDS:
        assert sum(word in library.names() for word in need.command.split()) == 1
