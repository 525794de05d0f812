"""Figures as data: ticks that can be read, marks of all that the axes hold."""

from __future__ import annotations

import re
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

import polhode
from polhode.common.errors import BadInput
from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import require
from polhode.figures.canvas.direct_labels import Look, balanced
from polhode.figures.canvas.log_ticks import names, ticks
from polhode.figures.canvas.panel import Axis, Guide, Panel, Point, Series

LOOK = Look("#0072b2", "o")


@given(st.floats(-300, 300), st.floats(0.05, 200))
def test_a_logarithmic_axis_has_two_labels_or_more_each_of_its_value(low, decades):
    low, high = 10.0**low, 10.0 ** min(low + decades, 307)
    found = ticks(low, high)
    assert 2 <= len(found) <= 10
    assert found == sorted(set(found))
    assert all(low * (1 - 1e-6) <= x <= high * (1 + 1e-6) for x in found)
    for x, name in zip(found, names(found), strict=True):
        plain = name.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
        factor, _, power = plain.rpartition("·") if "·" in plain else ("", "", plain)
        if power.startswith("10") and name != plain:
            value = float(f"{factor or 1}e{power[2:]}")
        else:
            value = float(plain)
        assert value == pytest.approx(x, rel=1e-5)


def test_what_a_logarithmic_axis_does_not_hold_has_no_mark():
    points = [Point(1, 1), Point(10, 0), Point(-1, 1), Point(1000, 2)]
    held = [points[0], points[-1]]
    axes = Axis("x", "log"), Axis("y", "log")
    drawn = [panel.svg([Panel([Series(row, LOOK)], *axes)], 3) for row in (points, held, held[:1])]
    marks = [text.count("<use ") for text in drawn]
    assert marks[0] == marks[1] != marks[2]


def test_rows_stand_from_the_top_down_under_their_headings():
    shown = panel.rows([("", ["a"]), ("second", ["b", "c"])])
    assert dict(shown.names) == {0: "a", 2: "b", 3: "c"}
    assert dict(shown.headings) == {1: "second"}
    assert shown.bands == [(-0.5, 0.5)]
    text = panel.svg(
        [Panel([Series(panel.line([1, 2, 3], shown.names), LOOK.marks)], rows=shown)], 3
    )
    places = {
        word: float(re.search(rf'y="([\d.]+)"[^>]*>{word}<', text)[1])  # type: ignore[index]
        for word in ("a", "second", "b", "c")
    }
    assert [*places] == sorted(places, key=places.__getitem__)


def test_names_stand_beside_curves_and_guides():
    series = Series(panel.line([1, 2], [1, 2]), LOOK, end="a curve")
    text = panel.svg([Panel([series], guides=[Guide("y", 1.5, name="a guide")])], 3)
    assert ">a curve<" in text
    assert ">a guide<" in text


def test_lines_of_a_label_are_as_even_as_they_can_be():
    assert balanced("Chaotic and falling bodies", 23) == "Chaotic and\nfalling bodies"
    assert balanced("Cusps", 23) == "Cusps"


@pytest.mark.parametrize("by", ["momentum", "height"])
def test_axes_of_a_map_and_of_a_section_are_the_same_and_say_what_they_are(by):
    level = {"h": 3, "f": "1/2", "by": by}
    found = polhode.chaos_map("kovalevskaya/generic", (2, 2), end=20, **level)
    cut = polhode.section("kovalevskaya/generic", grid=(2, 2), crossings=2, **level)
    words = [(axes.get_xlabel(), axes.get_ylabel()) for axes in (found.plot(), cut.plot())]
    assert words[0] == words[1]
    vector = {"momentum": "G", "height": "γ"}[by]
    assert f"azimuth of {vector} about r₀" in words[0][0]
    assert words[0][1].endswith(f"cos({vector}, r₀)")


def test_a_free_body_has_its_third_axis_where_a_heavy_one_has_its_centre():
    found = polhode.section("euler/largest-axis", grid=(2, 2), crossings=2)
    assert "third axis" in found.plot().get_ylabel()


def test_without_matplotlib_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(BadInput) as fault:
        require()
    told = "figures: matplotlib: expected it to be installed: pip install 'polhode[figures]'"
    assert str(fault.value) == told
