"""Speed over run length and outputs: starts, judging, spreads, and claims made of rows alone."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest

from polhode.common.errors import BadInput
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import DOUBLE
from polhode.scenes.output_times import even_times
from polhode.studies import ensembles, report
from polhode.studies.page.blocks import Text, markdown
from polhode.studies.peer_processes import plain_scene, run_all
from polhode.studies.row_filter import Only
from polhode.studies.speed import benchmark_grid, figure
from polhode.studies.speed.page import lengths
from polhode.studies.speed.work_precision import WorkPoint

CELL = benchmark_grid.Cell("kovalevskaya", 10, 11)


# -- ensembles --------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ensembles.KINDS)
def test_a_random_scene_is_found_by_its_name(kind):
    for scene in (ensembles.random_scene(kind, 4), ensembles.random_scene(kind, 4, body_of=0)):
        assert ensembles.named(scene.name) == scene
        assert plain_scene(scene.name, (Fraction(3),)).start == scene.start
    assert ensembles.named("lagrange/nutation") is None
    assert ensembles.named(f"{kind} start 0") is None


def test_starts_of_one_body_have_one_body_and_eight_starts():
    scenes = [CELL.scene(k) for k in range(benchmark_grid.STARTS)]
    assert len({scene.body for scene in scenes}) == 1
    assert len({scene.start for scene in scenes}) == benchmark_grid.STARTS >= 8


def test_every_length_and_number_of_outputs_is_asked_for():
    assert {end for end, _ in benchmark_grid.LENGTHS} == {10, 100, 1000, 10_000}
    assert {outputs for _, outputs in benchmark_grid.LENGTHS} == {2, 11, 1001}
    assert len(benchmark_grid.LENGTHS) == 12  # each with each


def test_the_page_says_how_long_a_run_is_that_is_made_once():
    told = " ".join(
        block.text for block in lengths.blocks([row(10, 2.0)]) if isinstance(block, Text)
    )
    assert f"of more than {benchmark_grid.PATIENCE:g} seconds is made once" in told


# -- judging ----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["lagrange", "asymmetric"])
def test_digits_are_those_of_the_error_that_is_put_in(kind):
    cell = benchmark_grid.Cell(kind, 4, 11)
    true = benchmark_grid.truth(cell, 1)
    states = true.high.copy()
    assert benchmark_grid.digits(states, true) > 15.5
    states[7, 4] += 1e-9
    assert benchmark_grid.digits(states, true) == pytest.approx(9, abs=1e-6)
    assert benchmark_grid.digits(states[[0, -1]], true) > 15.5  # with two outputs the end alone
    states[-1, 1] += 1e-5 * true.scale
    assert benchmark_grid.digits(states[[0, -1]], true) == pytest.approx(5, abs=1e-6)


@pytest.mark.parametrize(("outputs", "every"), [(2, 1), (11, 1), (1001, 100)])
def test_the_judged_times_are_among_the_outputs(outputs, every):
    cell = benchmark_grid.Cell("euler", 1000, outputs)
    assert cell.every == every
    judged = cell.scene(0).times[::every]
    wanted = [exactly(DOUBLE.rounded(t)) for t in even_times(Fraction(1000), 11)]
    assert [exactly(t) for t in judged] == (wanted if outputs > 2 else [wanted[0], wanted[-1]])


def test_a_row_tells_median_least_and_most_of_each_starts_own_ratio():
    ours = [[WorkPoint(6, s), WorkPoint(12, 2 * s)] for s in (1.0, 2.0, 4.0)]
    other = [[WorkPoint(6, 3.0)], [WorkPoint(6, 3.0)], []]
    row = benchmark_grid.cell_row(CELL, {"polhode": ours, "CyRK VERN8": other}, {})
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
    return benchmark_grid.cell_row(benchmark_grid.Cell("euler", end, 11), marks, {})


CLOSEST = (
    "polhode is ahead of every program tried but heyoka, its own engine, in every cell where it "
    "arrives"
)


def test_what_stands_is_told_of_long_accurate_runs_alone():
    """Short runs and few digits decide nothing, whoever is ahead there."""
    rows = [row(10, 0.5), row(100, 2.0), row(1000, 3.0), row(10000, None)]
    rows[2]["levels"][0]["methods"][-1]["factor"] = [0.9, 0.9, 0.9]  # to 6 digits
    told = lengths.stands(rows)
    assert told.startswith(
        f"From t = 1000 on and to 9 digits and more {CLOSEST} itself from nearly"
    )
    assert ": CyRK VERN8, the closest, takes 3 times as long." in told
    assert "repeated from one start" in told
    assert lengths.stands(rows[:2]).startswith("No run here is long and accurate enough")
    assert lengths.stands([row(1000, 1.0, "heyoka alone")]).startswith("No run here is")


def test_a_lost_race_is_told():
    rows = [row(1000, 0.5), row(1000, 2.0), row(1000, 1.0)]
    told = lengths.stands(rows)
    assert "its own engine, in 2 of 6 cells where it arrives itself" in told
    assert ": CyRK VERN8, the closest, takes 0.5 times as long." in told


def test_the_engine_by_hand_is_told_of_more_than_two_outputs():
    """With two it was called in a slow way."""
    rows = [row(10, 0.5), row(1000, 2.0)]
    two = row(1000, 2.0) | {"outputs": 2}
    for level in two["levels"]:
        level["methods"][1]["factor"] = [5.0, 5.0, 5.0]
    told = lengths.beside_engine([*rows, two])
    assert "10 to 10 times as long at t = 10, 10 to 10 at t = 1000: a short run" in told
    assert "`propagate_until` is 8 to 42 % faster; those cells are left out." in told
    assert lengths.beside_engine([two]) == ""


def test_the_closest_peer_of_a_cell():
    assert lengths.closest(row(10, 0.5), 6.0) == lengths.Closest(0.5, 0.5, 0.5, "CyRK VERN8")
    assert lengths.closest(row(1000, None), 6.0) is None


def test_the_programs_compared_with_are_named_with_what_they_ran():
    rows = [row(10, 0.5, "splitting 8"), row(10, 0.5), row(100, 2.0)]
    rows[2]["outputs"] = 1001
    assert lengths.others(rows) == (
        "The other programs here: splitting 8 to t = 10 with 11 outputs; CyRK VERN8 to t = 100. "
        "heyoka written by hand, polhode's own engine, is none of them; its factors are in the "
        "table."
    )


def test_where_polhode_does_not_arrive_nothing_is_claimed():
    """From seven starts in eight at least."""

    def short(arrived: int) -> dict:
        ours = [[WorkPoint(13 if k < arrived else 7, 1.0)] for k in range(8)]
        marks = {"polhode": ours, "CyRK VERN8": [[WorkPoint(13, 2.0)]] * 8}
        return benchmark_grid.cell_row(benchmark_grid.Cell("euler", 1000, 11), marks, {})

    assert lengths.stands([short(6)]).startswith("No run here is")
    assert "takes 2 times as long" in lengths.stands([short(7)])


def test_page_and_figure_of_cells():
    rows = json.loads(json.dumps([row(10, 0.5), row(100, 2.0)]))
    text = markdown("x", lengths.blocks(rows))
    assert "| euler t=10 outputs=11 | 6 | 1e+03 (1e+03–1e+03) |" in text
    assert "hold 60 to 110 microseconds of calls" in text
    assert "ahead" not in text
    assert figure.lengths(rows).startswith("<?xml")
    assert list(lengths.blocks([])) == []


@pytest.mark.slow
def test_one_cell_alone_from_end_to_end(tmp_path):
    only = Only(("kovalevskaya t=10 outputs=2", "heyoka"))
    assert not benchmark_grid.wanted_cells(True, only)  # a quick study has eleven outputs alone
    asked = benchmark_grid.wanted_cells(True, Only(("kovalevskaya t=10 ", "heyoka")))
    curves = run_all(benchmark_grid.tasks(asked, True), tmp_path)
    (found,) = benchmark_grid.rows(asked, curves, True)
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


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", report.STUDIES)
def test_every_study_can_make_a_row_alone(name):
    """A study that is asked for a row that it has not runs nothing and says so."""
    with pytest.raises(BadInput, match="part of the name of a row"):
        report.part(name, ["no such row"])


def report_folder():
    from pathlib import Path

    return Path(__file__).parents[2] / "reports"
