"""Figures of results: the same of a result and of its file; words, options, colours, axes."""

import sys
from dataclasses import replace
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import long_run
import polhode
import speed
from kit import COLOURS, LOOKS, plain
from polhode.cli import main
from polhode.figures import catalogue
from polhode.scenes.vocabulary import Several, Single
from programs import PROGRAMS, RUN
from shared.results import MAKERS, result_of_kind
from shared.tools import of_table, tiers
from speed import lines, work_precision

plt = pytest.importorskip("matplotlib.pyplot")
TOP = "lagrange/nutation"
WITHOUT = {
    *("About", "Cases", "CheckReport", "Conditioning", "Description", "Lyapunov"),
    *("FieldComparison", "ObservedOrder", "ProvedOrbits", "Report", "Verdict"),
}  # kinds that have no figure


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def chaos():
    return polhode.chaos_map("general/asymmetric-chaotic", (4, 4), end=60)


#: But of the proof of minutes, which is made up here, and whose guess is none.
DRAWN = [name for name in MAKERS if name != "ProvedChaos"]


@pytest.mark.parametrize("name", of_table(DRAWN, "About", "Conditioning", "EventTimes"))
def test_every_kind_has_figures_or_is_known_to_have_none(name):
    result = result_of_kind(name)
    if name.partition(" ")[0] not in WITHOUT:
        assert np.ravel(result.plot())[0].figure
        return
    with pytest.raises(polhode.BadInput, match=r"result = .*: expected one that has a figure"):
        result.plot()


def test_every_figure_of_a_motion_is_named_wherever_figures_are(capsys):
    words, guide = [*catalogue.MOTION], Path(polhode.__file__).parent / "guide"
    assert {*words} == {*get_args(Several), *get_args(Single)}
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    commands = (guide / "commands.md").read_text().split("| `polhode plot SCENE")[1]
    texts = (
        capsys.readouterr().out.rpartition("--what WORD")[2],
        polhode.plot.__doc__,
        commands.partition("\n")[0],
        (guide / "motion.md").read_text(),
    )
    assert [[word for word in words if word not in text] for text in texts] == [[]] * 4


def figures_of_a_motion():
    """Their words, as a wrong one is told them; the last is the page that moves."""
    with pytest.raises(polhode.BadInput) as fault:
        polhode.plot("euler/sphere", "nothing")
    *words, _ = str(fault.value).partition(": expected ")[2].split(", ")
    return words


@pytest.mark.parametrize("word", figures_of_a_motion())
def test_a_figure_of_a_file_that_lacks_its_columns_is_refused(tmp_path, word):
    file = tmp_path / "x.csv"
    file.write_text("t,p\n0,1\n1,1\n2,1\n3,1\n")
    if word == "omega":
        assert polhode.plot(str(file), word)
    else:
        with pytest.raises(polhode.BadInput, match="expected"):
            polhode.plot(str(file), word)


FILED = ["Certified", "Enclosure", "Judgement", "Reductions", "ChaosMap", "ProvedOrbit"]


def svg_of(result, word):
    with plt.rc_context({"svg.hashsalt": "x"}):
        figure = np.ravel(polhode.plot(result, word))[0].figure
        figure.savefig(out := BytesIO(), format="svg", metadata={"Date": None})
    plt.close(figure)
    return out.getvalue()


@pytest.mark.parametrize("name", tiers(["Reference"], FILED))
def test_a_file_is_drawn_as_the_result_was(tmp_path, name):
    result = result_of_kind(name)
    result.save(tmp_path / "x.csv")
    again = polhode.load_result(tmp_path / "x.csv")
    for word in ("fli", "megno", "exponent", "verdict") if name == "ChaosMap" else (None,):
        svg, again_svg = (svg_of(x, word) for x in (result, again))
        assert svg == again_svg
        assert len(svg) > 5000


def test_the_file_of_frequencies_has_the_lines_without_a_spectrum(tmp_path):
    analysis = result_of_kind("Frequencies")
    analysis.save(tmp_path / "x.json")
    panels = [analysis.plot(), polhode.plot(tmp_path / "x.json")]
    own, read = ({x.get_gid(): x.get_xydata() for x in axes.lines} for axes in panels)
    assert {*own} - {*read} == {"spectrum gamma3"}
    assert read["gamma3"].tolist() == own["gamma3"].tolist()
    true = [(x.frequency, abs(x.amplitude)) for x in analysis.lines["gamma3"]]
    assert own["gamma3"].tolist() == pytest.approx(np.array(true))


@pytest.mark.parametrize(
    "words",
    [
        f"section {TOP} --grid 1x2 --crossings 2",
        "orbits general/asymmetric-regular --grid 1x2 --crossings 1",
        f"sweep {TOP} --vary start.omega[2]=1:2:3 --at 1,2 --cmap magma",
    ],
)
def test_every_verb_with_a_figure_takes_a_title(tmp_path, words):
    path = tmp_path / "x.svg"
    assert main([*words.split(), "-o", str(path), "--title", "mine & yours"]) == 0
    assert ">mine &amp; yours</text>" in path.read_text(encoding="utf-8")


def test_a_runs_file_is_drawn_as_the_run(tmp_path):
    run = polhode.integrate(TOP, "extended", at=[1, 2])
    run.save(tmp_path / "x.json")
    curves = [
        axes.lines[0].get_xydata()
        for axes in (polhode.plot(tmp_path / "x.json", "omega", end=3), run.plot("omega", end=3))
    ]
    assert curves[0].tolist() == curves[1].tolist()
    assert len(curves[0]) > 1000
    assert curves[0][-1][0] == 3
    panel = polhode.plot(tmp_path / "x.json", "error", end=1)[0]
    assert panel.lines[-1].get_ydata()[0] == pytest.approx(np.log10(float(run.number.eps)))


@pytest.mark.parametrize("quantity", ["fli", "megno", "exponent", "verdict"])
def test_a_map_shows_the_number_that_is_asked_for(chaos, quantity):
    axes = chaos.plot(quantity, title="mine")
    assert axes.get_title() == "mine"
    (mesh,) = axes.collections
    cells = np.ma.filled(mesh.get_array(), np.nan).T.ravel()
    values = np.asarray(getattr(chaos, quantity), dtype=float)
    early = chaos.until < chaos.end * (1 - 1e-9)
    options = ~early if quantity in ("fli", "megno") else np.full(len(values), True)
    assert options.any()
    assert cells[chaos.cell[options]] == pytest.approx(values[options])
    assert np.isnan(np.delete(cells, chaos.cell)).all()


@pytest.mark.slow
def test_colours_of_maps_and_of_a_style_are_taken(chaos):
    (mesh,) = chaos.plot(cmap="magma").collections
    assert mesh.get_cmap().name == "magma"
    plain = polhode.plot(TOP, "omega", end=1)
    with plt.style.context("ggplot"):
        styled = polhode.plot(TOP, "omega", end=1)
        expected = plt.rcParams["axes.prop_cycle"].by_key()["color"][:3]
    assert [line.get_color() for line in styled.lines[:3]] == expected
    assert [line.get_color() for line in plain.lines[:3]] == ["#0072b2", "#d55e00", "#009e73"]


@pytest.mark.slow
def test_a_dark_style_hides_nothing_and_sections_and_axes_take_its_colours():
    with plt.style.context("dark_background"):
        cycle = plt.rcParams["axes.prop_cycle"].by_key()["color"]
        drawn = polhode.section(TOP, grid=(3, 2), crossings=2).plot()
        globe = polhode.plot(TOP, "sphere", end=1)[0]
    assert {line.get_color() for line in drawn.lines} == {*cycle[:6]}
    assert "white" in {text.get_color() for text in globe.texts}


def test_a_map_takes_the_colours_of_the_style_and_a_map_of_colours_of_ones_own(chaos):
    with plt.rc_context({"image.cmap": "cividis"}):
        (mesh,) = chaos.plot("megno").collections
    assert mesh.get_cmap().name == "cividis"
    (mesh,) = chaos.plot("megno", cmap=plt.get_cmap("magma")).collections
    assert mesh.get_cmap().name == "magma"


@pytest.mark.slow
def test_levels_show_the_range_that_is_asked_for():
    diagram = polhode.levels("general/asymmetric-chaotic")
    axes = diagram.plot(f_range=(0, "1/2"), h_range="1:2")
    assert (axes.get_xlim(), axes.get_ylim()) == ((0, 0.5), (1, 2))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("plot x.npz -o y.svg --what megna", "did you mean 'megno'?"),
        ("plot x.npz -o y.svg --cmap magna", "did you mean 'magma'?"),
        (
            "plot x.npz -o y.svg --what verdict --cmap magma",
            "plot verdict: cmap = magma: expected title",
        ),
        (
            "plot x.npz -o y.html",
            "y.html: -o: expected polhode view x.npz -o y.html, which makes pages",
        ),
        ("plot x.npz -o y.svg --end 3", "--end = 3: expected no --end: it is for a motion"),
        ("plot x.npz -o y.svg --scene euler/rest --what sphere", "x.npz"),
        ("plot x.npz -o x.npz", "-o"),
        (f"map {TOP} --grid 2x2 --cmap magma", "--cmap = magma: expected it with a figure"),
        (f"map {TOP} --grid 2x2 --what flu -o y.svg", "did you mean 'fli'?"),
        (f"levels {TOP} --f-range 2:1 -o y.svg", "--f-range = 2:1: expected A:B with A below B"),
        ("plot x.npz -o y.svg --f-range 0:1", "plot fli: f_range = 0:1: expected cmap, title"),
        (f"levels {TOP} --h-range 2 -o y.svg", "--h-range = 2: expected A:B, two numbers"),
    ],
)
def test_what_a_verb_cannot_draw_is_one_line(tmp_path, monkeypatch, chaos, refusal, words, said):
    monkeypatch.chdir(tmp_path)
    chaos.save("x.npz")
    assert said in refusal(*words.split())
    assert not (tmp_path / "y.svg").exists()


# -- Figures of results: axes and ticks that can be read, marks of all that they hold, looks -------


@pytest.mark.parametrize(
    ("low", "high", "least"),
    [(1e-120, 1e5, 4), (1e-9, 1e-3, 4), (0.5, 2e4, 4), (0.9, 25, 2), (2e-4, 4e-3, 3)],
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
        assert float(text.replace("\N{MINUS SIGN}", "-")) == pytest.approx(at, rel=1e-12)


def test_labels_of_a_narrow_panel_stand_apart():
    with polhode.paper() as plt:
        figure, axes = plt.subplots(figsize=(2.2, 2))
        axes.set(xscale="log", xlim=(1.4e-3, 0.7))
        plain(axes)
        figure.canvas.draw()
        labels = [*axes.get_xticklabels(), *axes.get_xticklabels(minor=True)]
        boxes = [t.get_window_extent() for t in labels if t.get_text()]
        plt.close(figure)
    shown = sorted((x.x0, x.x1) for x in boxes if axes.bbox.x0 <= x.x0 <= axes.bbox.x1)
    assert len(shown) >= 2
    assert all(first[1] < second[0] for first, second in pairwise(shown))


def test_methods_of_a_figure_look_different_and_no_other_program_like_a_number_type():
    ways = [way for motion in speed.MOTIONS for way in speed.ways(motion, quick=False)]
    types = {way.name.removeprefix("polhode ") for way in ways}
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
    assert "program of 2030" in work_precision({"Euler, t = 1": curves})


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
