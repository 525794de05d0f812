"""Figures of results: axes and ticks that can be read, marks of all that they hold, looks."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

import long_run
import polhode
import speed
from kit import COLOURS, LOOKS, plain
from programs import PROGRAMS, RUN
from shared.tools import tiers
from speed import lines, work_precision


@pytest.mark.parametrize(
    ("low", "high", "least"),
    [(1e-120, 1e5, 4), (1e-9, 1e-3, 4), (0.5, 2e4, 4), (0.9, 25, 4), (2e-4, 4e-3, 3)],
)
def test_a_logarithmic_axis_has_labels_each_of_its_value(low, high, least):
    with polhode.paper() as plt:
        figure, axes = plt.subplots()
        axes.set(xscale="log", xlim=(low, high))
        plain(axes)
        figure.canvas.draw()
        labels = [*axes.get_xticklabels(), *axes.get_xticklabels(minor=True)]
        shown = {t.get_text(): t.get_position()[0] for t in labels if t.get_text()}
        plt.close(figure)
    within = {text: at for text, at in shown.items() if low <= at <= high}
    assert least <= len(within) <= 9
    for text, at in within.items():
        digits = text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
        value = f"1e{digits[2:]}" if digits != text else text
        assert float(value) == pytest.approx(at, rel=1e-12)


def test_methods_of_a_figure_look_different_and_no_other_program_like_a_number_type():
    types = {curve.name.removeprefix("polhode ") for curve in speed.WAYS}
    runs = [long_run.PLAIN, long_run.PROJECTED]
    drawn = [*dict.fromkeys(program.line for program in PROGRAMS if program.line)]
    assert {*types, *runs, *drawn} == LOOKS.keys()
    for those in (types, runs, drawn):
        assert len({tuple(LOOKS[name].values()) for name in those}) == len(those)
    others = [LOOKS[name]["color"] for name in drawn if not name.startswith("polhode")]
    assert len({*others}) == len(others)  # one colour a program
    assert {*others}.isdisjoint(COLOURS.values())


def test_no_program_of_the_diagram_is_left_out_without_a_word():
    """One that the list of lines lacked was not drawn; one that is unknown is, by its own name."""
    left_out = {p.name for p in PROGRAMS if not p.line}
    assert left_out == {RUN, "SciPy DOP853, Python", "CyRK DOP853, Python"}
    points = [[6.0, 1e-3], [9.0, 2e-3]]
    curves = lines({**{p.name: points for p in PROGRAMS}, "program of 2030": points})
    assert {*curves} == {p.line for p in PROGRAMS if p.line} | {"program of 2030"}
    assert "program of 2030" in work_precision({"Euler, t = 1": curves}, "seconds")


@pytest.mark.parametrize("by", ["momentum", "height"])
def test_axes_of_a_map_and_of_a_section_are_the_same_and_say_what_they_are(by):
    level = {"h": 3, "f": "1/2", "by": by}
    chaos = polhode.chaos_map("kovalevskaya/generic", (1, 2), end=5, **level)
    cut = polhode.section("kovalevskaya/generic", grid=(1, 2), crossings=2, **level)
    words = [(axes.get_xlabel(), axes.get_ylabel()) for axes in (chaos.plot(), cut.plot())]
    assert words[0] == words[1]
    vector = {"momentum": "G", "height": "γ"}[by]
    assert f"azimuth of {vector} about r₀" in words[0][0]
    assert words[0][1].endswith(f"cos({vector}, r₀)")


def test_a_free_body_has_its_third_axis_where_a_heavy_one_has_its_centre():
    section = polhode.section("euler/largest-axis", grid=(1, 2), crossings=2)
    assert "third axis" in section.plot().get_ylabel()


@pytest.mark.parametrize(
    "residues", tiers([(0.93, 0.93 + 1e-13), (-4e4, 300.0)], [((),), ((0.5, 1e30),)])
)
def test_the_axis_of_residues_holds_0_and_1_and_all_of_them(residues):
    """Its labels are plain, and rounding errors are not apart."""
    search = polhode.orbit_search("general/asymmetric-regular", (1, 2), crossings=1)
    orbit = search.orbits[0]
    orbits = [orbit._replace(residue=x, period=2.5 + 1e-13 * k) for k, x in enumerate(residues)]
    axes = replace(search, orbits=tuple(orbits)).plot()
    axes.figure.canvas.draw()
    low, high = axes.get_ylim()
    assert low < min(0, *residues, 0)
    assert high > max(1, *residues, 1)
    labels = {t.get_text(): t.get_position()[1] for t in axes.get_yticklabels()}
    assert labels.keys() >= {"0"}
    assert {0.0, 1.0} <= {line.get_ydata()[0] for line in axes.lines if len(line.get_ydata()) == 2}
    assert sum(low <= at <= high for at in labels.values()) <= 16
    for text, at in labels.items():
        assert float(text.replace("\N{MINUS SIGN}", "-")) == pytest.approx(at, rel=1e-12)
    assert not residues or np.ptp(axes.get_xlim()) >= 0.09


def test_without_matplotlib_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(polhode.BadInput, match=r"matplotlib: .*pip install 'polhode\[figures\]'"):
        polhode.plot("lagrange/nutation")
