"""Figures of results: the same of a result and of its file; words, options, colours, axes."""

from __future__ import annotations

import numpy as np
import pytest

import polhode
from polhode.cli import main
from polhode.dynamics.frequencies import Frequencies
from polhode.figures import catalogue
from polhode.results.reader import KINDS
from shared.results import result_of_kind
from shared.tools import tiers

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


def test_every_kind_has_figures_or_is_known_to_have_none():
    drawn = set(catalogue.FIGURES) - {"Certified", "Reference"}
    assert drawn | WITHOUT == set(KINDS)
    assert not drawn & WITHOUT


@pytest.mark.parametrize(
    "name",
    tiers(
        ["Reference"],
        [
            *("Certified", "Enclosure", "Judgement", "Reductions"),
            *("Reductions of events", "ChaosMap", "ProvedOrbit"),
        ],
    ),
)
def test_a_file_is_drawn_as_the_result_was(tmp_path, name):
    result = result_of_kind(name)
    result.save(tmp_path / "x.csv")
    again = polhode.load_result(tmp_path / "x.csv")
    for word in catalogue.words(again.result):
        svg = catalogue.drawn(result, ".svg", "x", word)
        assert svg == catalogue.drawn(again, ".svg", "x", word)
        assert len(svg) > 5000


def test_the_file_of_frequencies_has_the_lines_without_a_spectrum(tmp_path):
    analysis = result_of_kind("Frequencies")
    analysis.save(tmp_path / "x.json")
    assert isinstance(analysis, Frequencies)
    panels = [analysis.plot(), polhode.plot(tmp_path / "x.json")]
    own, read = ({x.get_gid(): x.get_xydata() for x in axes.lines} for axes in panels)
    assert {*own} - {*read} == {"spectrum gamma3"}
    assert read["gamma3"].tolist() == own["gamma3"].tolist()
    true = [(x.frequency, abs(x.amplitude)) for x in analysis.lines["gamma3"]]
    assert own["gamma3"].tolist() == pytest.approx(np.array(true))


@pytest.mark.slow
def test_the_command_draws_what_python_draws(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    level = ["section", TOP, "--grid", "2x2", "--crossings", "5"]
    assert main([*level, "-o", "x.npz", "-o", "x.svg"]) == 0
    assert main(["plot", "x.npz", "-o", "y.svg"]) == 0
    points = [
        np.concatenate([line.get_xydata() for line in axes.lines])
        for axes in (
            polhode.plot("x.npz"),
            polhode.section(TOP, grid=(2, 2), crossings=5).plot(),
        )
    ]
    assert points[0].tolist() == points[1].tolist()
    x, y = ((tmp_path / name).read_text().splitlines() for name in ("x.svg", "y.svg"))
    differing = [a for a, b in zip(x, y, strict=True) if a != b]
    title = f"title>polhode: crossings of {TOP}</"
    assert differing
    assert all(title in line for line in differing)


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
    ("options", "said"),
    [
        ({"what": "flu"}, "--what = flu: expected fli, megno, exponent, verdict .did you mean"),
        ({"cmap": "magna"}, "cmap = magna: .*did you mean 'magma'"),
        ({"colour": 1}, "colour = 1: expected cmap, title"),
        ({"what": "verdict", "cmap": "magma"}, "plot verdict: cmap = magma: expected title"),
        ({"end": 3}, "--end = 3: expected no --end: it is for a motion"),
        ({"ax": [1, 2]}, "axes = 2 things: expected 1 matplotlib axes"),
    ],
)
def test_what_a_map_does_not_have_is_refused(chaos, options, said):
    with pytest.raises(polhode.BadInput, match=said):
        chaos.plot(**options)


def test_kinds_without_a_figure_say_so():
    with pytest.raises(
        polhode.BadInput, match="result = Conditioning: expected one that has a figure"
    ):
        result_of_kind("Conditioning").plot()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("plot x.npz -o y.svg --what megna", "did you mean 'megno'?"),
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
