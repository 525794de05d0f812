"""Figures of the studies have a mark for every row behind them."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest

from polhode.output.json_object import JsonObject
from polhode.studies import report

COMMITTED = Path(__file__).parents[2] / "reports"
SVG = "{http://www.w3.org/2000/svg}"


def marks(found: JsonObject, figure: str) -> int:
    """How many marks and ticks a figure has."""
    tree = ElementTree.fromstring(report.figures(found)[figure].encode())
    return sum(1 for _ in tree.iter(f"{SVG}use"))


def run_of(case: str) -> Callable[[JsonObject], list[JsonObject]]:
    """The runs of a case."""
    return lambda found: next(row["runs"] for row in found["cases"] if row["case"] == case)


@pytest.mark.parametrize(
    ("study", "rows_of"),
    [
        ("accuracy", run_of("kovalevskaya/generic")),
        ("stability", run_of("hard/near-cusp")),
        ("proofs", lambda found: found["orbits"][0]["orbits"]),
    ],
)
def test_a_row_less_is_a_mark_less(study, rows_of):
    found = report.results(COMMITTED, study)
    less = copy.deepcopy(found)
    del rows_of(less)[0]
    assert marks(found, study) - marks(less, study) == 1


@pytest.mark.parametrize(
    ("study", "figure"),
    [("long-run", "long-run"), ("speed", "speed"), ("speed", "lengths"), ("events", "events")],
)
def test_other_figures_have_marks(study, figure):
    found = report.results(COMMITTED, study)
    assert found is not None
    assert marks(found, figure) > 60
    if figure == "lengths":  # of a program less, one in every panel and length
        fewer = copy.deepcopy(found)
        for cell in fewer["cells"]:
            for level in cell["levels"]:
                level["programs"] = [p for p in level["programs"] if "CyRK" not in p["program"]]
        assert marks(found, figure) - marks(fewer, figure) > 10


@pytest.mark.filterwarnings("error")
def test_a_study_of_which_a_part_has_no_rows_has_its_figures():
    empty: list[JsonObject] = [
        {"study": "events", "motions": [], "cost": []},
        {"study": "accuracy", "cases": []},
        {"study": "proofs", "orbits": [{"what": "a top", "orbits": []}], "chaos": []},
    ]
    for found in empty:
        (drawn,) = report.figures(found).values()
        assert drawn.startswith("<?xml")
