"""Speed over run length and outputs: starts, judging, spreads, and claims made of rows alone."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest

from polhode.common.errors import BadInput
from polhode.numbers.convert import exactly
from polhode.numbers.number_types import DOUBLE
from polhode.scenes.scene import even_times
from polhode.studies import ensembles, report
from polhode.studies.only import Only
from polhode.studies.page.blocks import Text, markdown
from polhode.studies.processes import plain_scene, run_all
from polhode.studies.speed import cells, figure
from polhode.studies.speed.page import lengths
from polhode.studies.speed.work_precision import WorkPoint

CELL = cells.Cell("kovalevskaya", 10, 11)


# -- ensembles --------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ensembles.KINDS)
def test_a_random_scene_is_found_by_its_name(kind):
    for scene in (ensembles.random_scene(kind, 4), ensembles.random_scene(kind, 4, body_of=0)):
        assert ensembles.named(scene.name) == scene
        assert plain_scene(scene.name, (Fraction(3),)).start == scene.start
    assert ensembles.named("lagrange/nutation") is None
    assert ensembles.named(f"{kind} start 0") is None


def test_starts_of_one_body_have_one_body_and_eight_starts():
    scenes = [CELL.scene(k) for k in range(cells.STARTS)]
    assert len({scene.body for scene in scenes}) == 1
    assert len({scene.start for scene in scenes}) == cells.STARTS >= 8


def test_every_length_and_number_of_outputs_is_asked_for():
    assert {end for end, _ in cells.LENGTHS} == {10, 100, 1000, 10_000}
    assert {outputs for _, outputs in cells.LENGTHS} == {2, 11, 1001}
    assert len(cells.LENGTHS) == 12  # each with each


def test_the_page_says_how_long_a_run_is_that_is_made_once():
    told = " ".join(
        block.text for block in lengths.blocks([row(10, 2.0)]) if isinstance(block, Text)
    )
    assert f"of more than {cells.PATIENCE:g} seconds is made once" in told


# -- judging ----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["lagrange", "asymmetric"])
def test_digits_are_those_of_the_error_that_is_put_in(kind):
    cell = cells.Cell(kind, 4, 11)
    true = cells.truth(cell, 1)
    states = true.high.copy()
    assert cells.digits(states, true) > 15.5
    states[7, 4] += 1e-9
    assert cells.digits(states, true) == pytest.approx(9, abs=1e-6)
    assert cells.digits(states[[0, -1]], true) > 15.5  # with two outputs the end alone
    states[-1, 1] += 1e-5 * true.scale
    assert cells.digits(states[[0, -1]], true) == pytest.approx(5, abs=1e-6)


@pytest.mark.parametrize(("outputs", "every"), [(2, 1), (11, 1), (1001, 100)])
def test_the_judged_times_are_among_the_outputs(outputs, every):
    cell = cells.Cell("euler", 1000, outputs)
    assert cell.every == every
    judged = cell.scene(0).times[::every]
    wanted = [exactly(DOUBLE.rounded(t)) for t in even_times(Fraction(1000), 11)]
    assert [exactly(t) for t in judged] == (wanted if outputs > 2 else [wanted[0], wanted[-1]])


def test_a_row_tells_median_least_and_most_of_each_starts_own_ratio():
    ours = [[WorkPoint(6, s), WorkPoint(12, 2 * s)] for s in (1.0, 2.0, 4.0)]
    other = [[WorkPoint(6, 3.0)], [WorkPoint(6, 3.0)], []]
    row = cells.cell_row(CELL, {"polhode": ours, "CyRK VERN8": other}, {})
    six, nine, _ = row["levels"]
    mine, theirs = six["methods"]
    assert (mine["reached"], mine["seconds"], mine["factor"]) == (3, [2.0, 1.0, 4.0], None)
    assert (theirs["reached"], theirs["factor"]) == (2, [2.25, 1.5, 3.0])
    assert nine["methods"][1]["seconds"] is None


# -- claims -----------------------------------------------------------------------------------


def row(end: int, factor: float | None, name: str = "CyRK VERN8") -> dict:
    """A cell in which a peer takes so much of our time at every level; None: it never arrives."""
    ours = [[WorkPoint(5, 1.0), WorkPoint(13, 1.0)]] * 2
    theirs = [[WorkPoint(13, factor)] if factor else [WorkPoint(2, 0.1)]] * 2
    marks = {"polhode": ours, "heyoka alone": [[WorkPoint(13, 0.1)]] * 2, name: theirs}
    return cells.cell_row(cells.Cell("euler", end, 11), marks, {})


def test_claims_count_what_the_rows_say():
    rows = [row(10, 0.5), row(10, 0.8, "CyRK DOP853"), row(100, 2.0), row(1000, None)]
    assert lengths.claim(rows, 9.0) == (
        "At 9 digits polhode's median is ahead of every other program run in 0 of 2 cells of body "
        "and outputs at t = 10, 1 of 1 at t = 100, 1 of 1 at t = 1000; in the others the fastest "
        "(CyRK DOP853, CyRK VERN8) takes 0.50 to 0.80 of its time; in 1 of these cells no other "
        "program reaches so many digits."
    )
    assert "ahead of" not in lengths.claim([row(10, 1.0, "heyoka alone")], 9.0)
    assert lengths.finding([row(10, 1.0, "heyoka alone")]).startswith("No other program was")
    assert lengths.closest(rows[0], 6.0) == lengths.Closest(0.5, 0.5, 0.5, "CyRK VERN8")
    assert lengths.closest(rows[3], 6.0) is None


def test_the_finding_tells_every_level_and_the_engine_by_hand():
    """Not the level alone at which all is won, nor the length at which heyoka alone is caught."""
    rows = [row(10, 0.5), row(10, 0.8, "CyRK DOP853"), row(100, 2.0), row(1000, None)]
    rows[2]["levels"][0]["methods"][-1]["factor"] = [0.9, 0.9, 0.9]
    assert lengths.finding(rows) == (
        "Polhode's median is ahead of every other program run in so many cells of body, length and "
        "number of outputs: 1 of 4 at 6 digits (in 1 no other reaches them), 2 of 4 at 9 digits "
        "(in 1 no other reaches them), 2 of 4 at 12 digits (in 1 no other reaches them). Beside "
        "heyoka written by hand polhode takes, to the same digits, 10 to 10 times as long at "
        "t = 10, 10 to 10 at t = 100, 10 to 10 at t = 1000: a short run pays most for what "
        "surrounds the steps."
    )


def test_the_programs_compared_with_are_named_with_what_they_ran():
    rows = [row(10, 0.5, "splitting 8"), row(10, 0.5), row(100, 2.0)]
    rows[2]["outputs"] = 1001
    assert lengths.others(rows) == (
        "The other programs here: splitting 8 to t = 10 with 11 outputs; CyRK VERN8 to t = 100. "
        "heyoka written by hand, polhode's own engine, is none of them; its factors are in the "
        "table."
    )


def test_where_polhode_does_not_arrive_nothing_is_claimed():
    marks = {"polhode": [[WorkPoint(7, 1.0)]], "CyRK VERN8": [[WorkPoint(13, 1.0)]]}
    short = cells.cell_row(CELL, marks, {})
    assert "no other program" in lengths.claim([short], 12.0)
    assert "1 of 1" not in lengths.claim([short], 12.0)


def test_page_and_figure_of_cells():
    rows = json.loads(json.dumps([row(10, 0.5), row(100, 2.0)]))
    text = markdown("x", lengths.blocks(rows))
    assert "| euler t=10 outputs=11 | 6 | 1e+03 (1e+03–1e+03) |" in text
    assert "ahead on 0 of 1 bodies; CyRK VERN8 ×0.50" in text
    assert figure.lengths(rows).startswith("<?xml")
    assert list(lengths.blocks([])) == []


@pytest.mark.slow
def test_one_cell_alone_from_end_to_end(tmp_path):
    only = Only(("kovalevskaya t=10 outputs=2", "heyoka"))
    assert not cells.wanted_cells(True, only)  # a quick study has eleven outputs alone
    asked = cells.wanted_cells(True, Only(("kovalevskaya t=10 ", "heyoka")))
    curves = run_all(cells.tasks(asked, True), tmp_path)
    (found,) = cells.rows(asked, curves, True)
    assert {m["method"] for m in found["levels"][0]["methods"]} == {"polhode", "heyoka alone"}
    for level in found["levels"]:
        for method in level["methods"]:
            assert method["reached"] == found["starts"] == 2
            assert method["seconds"][1] <= method["seconds"][0] <= method["seconds"][2]


# -- part of a study --------------------------------------------------------------------------


def test_a_row_is_wanted_where_every_text_stands_in_one_of_its_labels():
    only = Only(("Euler", "dop853"))
    assert only("euler/rest", "CyRK DOP853")
    assert not only("euler/rest", "CyRK VERN8")
    assert only.taken == ["euler/rest", "CyRK DOP853"]
    assert Only()("anything")
    assert not Only()
    assert only


def test_part_of_a_study_is_printed_and_is_the_committed_row():
    found, text = report.part("published", ["curtis"])
    (case,) = found["cases"]
    committed = report.results(report_folder(), "published")
    assert case in committed["cases"]
    assert "| " in text
    with pytest.raises(BadInput, match="part of the name of a row"):
        report.part("published", ["no such row"])


@pytest.mark.parametrize("name", report.STUDIES)
def test_every_study_can_make_a_row_alone(name):
    """A study that is asked for a row that it has not runs nothing and says so."""
    with pytest.raises(BadInput, match="part of the name of a row"):
        report.part(name, ["no such row"])


def report_folder():
    from pathlib import Path

    return Path(__file__).parents[2] / "reports"
