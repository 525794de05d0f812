"""Figures of motions: what is drawn, of scenes, runs and files, and what is refused."""

import json
import math
import re
import warnings
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from polhode.figures.sphere import Globe, facing_most
from shared.tables import of_run, through
from shared.tools import even_times, tiers

plt = pytest.importorskip("matplotlib.pyplot")
TOP = "lagrange/looping"


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def curves(what_of, quantity, **options):
    """The panels of a figure, and the points of its curves by their names."""
    panels = np.ravel(polhode.plot(what_of, quantity, **options))
    lines = [line for panel in panels for line in panel.lines]
    return panels, {line.get_gid(): line.get_xydata() for line in lines if line.get_gid()}


def plotted(folder, *arguments, name="x.svg"):
    path = folder / name
    assert main(["plot", *arguments, "-o", str(path)]) == 0
    return path


# -- contents -----------------------------------------------------------------------------------


@pytest.mark.parametrize("quantity", ["angles", "omega", "momentum", "attitude"])
def test_curves_over_time_are_those_of_the_closed_form(quantity):
    name = "lagrange/turned-axes"
    panels = np.ravel(polhode.plot(name, quantity, end=5))
    assert panels[-1].get_xlabel() == "t (units of the scene)"
    lines = [line for panel in panels for line in panel.lines]
    assert len(lines) == {"angles": 3}.get(quantity, 4)
    t, exact = lines[0].get_xdata(), polhode.reference(name)
    assert (t[0], t[-1]) == pytest.approx((0, 5))
    some = [len(t) // 3, len(t) - 1]
    rows_at = {"angles": exact.angles, "attitude": exact.attitude}.get(quantity, exact.at)
    true = np.array(rows_at([Fraction(t[k]) for k in some], 15), float)
    if quantity in ("omega", "momentum"):
        true = true[:, :3] @ (
            np.array(exact.scene.body.inertia, float) if quantity == "momentum" else np.eye(3)
        )
        true = np.c_[true, np.linalg.norm(true, axis=1)]
    own = np.array([line.get_ydata()[some] for line in lines]).T
    assert own == pytest.approx(true, abs=1e-11)


def test_angles_break_where_a_motion_goes_through_a_pole():
    _, drawn = curves("pendulum/librating", "angles")
    psi = drawn["psi"][:, 1]
    pieces = np.split(psi, np.flatnonzero(np.isnan(psi)))
    assert len(pieces) > 1
    assert all(np.nanmax(piece) - np.nanmin(piece) < 1e-3 for piece in pieces if len(piece) > 1)
    assert not np.isnan(drawn["theta"]).any()


def test_a_backward_scene_is_drawn_backward():
    panels, drawn = curves("lagrange/backward", "angles")
    assert drawn["phi"][:, 0].max() == 0 > drawn["phi"][:, 0].min()
    low, high = panels[-1].get_xlim()
    assert low < high


def test_plan_and_elevation_have_one_scale_and_hold_the_motion():
    panels, drawn = curves("kovalevskaya/generic", "hodographs")
    assert {panel.get_ylabel() for panel in panels} == {
        f"{x} (rad / unit of time)" for x in ("q", "r", "ω·Y", "ω·Z")
    }
    assert [panel.get_aspect() for panel in panels] == [1] * 4
    run = polhode.integrate("kovalevskaya/generic", at=even_times(Fraction(20), 2001))
    p, q, r = run.states[:, :3].T
    for name, y in (("body-elevation", r), ("body-plan", q)):
        for column, true in zip(drawn[name].T, (p, y), strict=True):
            assert (column.min(), column.max()) == pytest.approx((true.min(), true.max()), abs=2e-3)


def test_a_free_body_gets_polhode_and_herpolhode():
    """The herpolhode's distance from the foot of G: w² - (2h/G)²."""
    panels, drawn = curves("euler/largest-axis", "hodographs")
    assert panels[1].get_title() == "herpolhode in the invariable plane"
    assert len(drawn["polhode"]) > 50
    scene = polhode.load("euler/largest-axis")
    run = polhode.integrate(scene, at=even_times(Fraction(50), 1001))
    momentum = np.array(scene.body.inertia, float) @ run.states[0, :3]
    height2 = (2 * float(scene.integrals.energy)) ** 2 / np.dot(momentum, momentum)
    radius = np.sqrt(np.sum(run.states[:, :3] ** 2, axis=1) - height2)
    own = np.linalg.norm(drawn["herpolhode"], axis=1)
    assert (own.min(), own.max()) == pytest.approx((radius.min(), radius.max()), rel=0.02)


@pytest.mark.parametrize("name", tiers(["lagrange/cusped"], [TOP]))
def test_cusps_and_loops_of_the_apex_stand_on_the_sphere(name):
    panels, drawn = curves(name, "sphere")
    assert [panel.get_title() for panel in panels] == ["γ in the body", "centre of mass in space"]
    assert np.hypot(*drawn["outline"].T) == pytest.approx(1)
    for points in (drawn["gamma"], drawn["gamma-hidden"]):
        assert np.nanmax(np.hypot(*points.T)) <= 1 + 1e-9
    shown, hidden = (np.isfinite(drawn[key][:, 0]).sum() for key in ("apex", "apex-hidden"))
    assert shown > hidden > 50
    # seen face on, in the middle of its disc, only a cusp turns back between two samples
    apex = drawn["apex"]
    steps = np.diff(apex, axis=0)
    turns = np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0])))))
    sharpest = np.nanmax(turns[np.hypot(*apex[1:-1].T) < 0.7])
    assert sharpest > 2.5 if name.endswith("cusped") else sharpest < 0.6


@pytest.mark.parametrize("options", [{}, {"tol": 1e-6}, {"tol": 1e-9, "project": 3}])
def test_the_error_shown_is_the_error_found(options):
    """Of a run the errors are its own, not those of a run of its scene as it is made by default."""
    scene = replace(polhode.load(TOP), outputs=())  # of the errors no output is integrated
    run = polhode.integrate(scene.at(even_times(Fraction(2), 501)), "double", **options)
    panels, drawn = curves(run, "error")
    worst = -min(polhode.compare(run).digits)
    own = max(np.nanmax(drawn[name][:, 1]) for name in ("omega", "gamma"))
    assert own == pytest.approx(worst, abs=0.3)
    true = np.array(polhode.reference(scene).at(run.times, 50))
    off = np.abs((np.array(run.states, dtype=object) - true).astype(float))
    scale = np.linalg.norm(true[:, :3].astype(float), axis=1).max()
    for name, errors in (("omega", off[:, :3] / scale), ("gamma", off[:, 3:])):
        assert np.nanmax(drawn[name][:, 1]) == pytest.approx(np.log10(errors.max()), abs=1e-6), name
    assert [text.get_text() for text in panels[0].texts] == ["eps"]
    assert panels[0].lines[-1].get_ydata()[0] == pytest.approx(math.log10(run.number.eps))


def test_integrals_shown_reach_the_drift_of_the_run():
    panels, drawn = curves("kovalevskaya/generic", "integrals")
    assert len(panels) == 4
    times = even_times(Fraction(20), 501)
    drift = polhode.integrate("kovalevskaya/generic", at=times, project=False).drift
    for name in ("h", "f", "gamma"):
        assert np.nanmax(drawn[name][:, 1]) == pytest.approx(math.log10(getattr(drift, name)))


def test_what_is_exactly_kept_is_said_to_be():
    panels, _ = curves("euler/rest", "integrals")
    said = [text.get_text() for panel in panels for text in panel.texts]
    assert said.count("exactly 0") == 3
    assert len(curves("euler/no-gamma", "integrals")[0]) == 2  # h and |G|²


def test_axes_of_a_scene_in_si_have_seconds():
    cone = polhode.Part("cone", mass="50 g", radius="3 cm", height="5 cm")
    top = polhode.top(parts=[cone], g=9.80665, angles=[0, "pi/6", 0], rates=[0, 0, 150], end=0.1)
    axes = polhode.plot(top, "omega")
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("t (s)", "ω in the body (rad/s)")


def test_a_figure_is_drawn_into_axes_that_are_given():
    _, grid = plt.subplots(3, 2)
    back = polhode.plot(polhode.load(TOP), "angles", grid[:, 1], end=2)
    assert list(back) == list(grid[:, 1])
    assert all(panel.lines for panel in grid[:, 1])
    assert not any(panel.lines for panel in grid[:, 0])
    assert polhode.integrate("lagrange/nutation", at=[1, 2]).plot(ax=grid[0, 0]) is grid[0, 0]
    assert grid[0, 0].lines
    for axes in (grid[0], 3):
        with pytest.raises(polhode.BadInput, match="3 matplotlib axes"):
            polhode.plot(TOP, "angles", axes, end=2)
    with pytest.raises(polhode.BadInput, match="did you mean 'angles'"):
        polhode.plot(TOP, "angels")


def test_the_outline_of_an_ellipsoid_is_where_the_view_grazes():
    globe = Globe(25, 20, (1.0, 0.5, 2.0))
    points = globe._outline()
    assert np.max(np.abs(globe.facing(points))) < 1e-12
    assert np.max(np.abs(np.sum((points / globe.semi_axes) ** 2, axis=1) - 1)) < 1e-12
    behind = np.array([[-1.0, -0.2, 0.1 * k] for k in range(-3, 4)])
    assert (facing_most(behind).facing(behind) > 0).all()
    assert facing_most(np.array([[1.0, 0.3, 0.2]])) == Globe(25, 20)


# -- files --------------------------------------------------------------------------------------


def texts(path):
    """The texts of an SVG that are no numbers."""
    result = re.findall(r"<text[^>]*>([^<]*)</text>", path.read_text(encoding="utf-8"))
    return [text for text in result if not re.match(r"[−\d]", text)]


def paths(path):
    return re.findall(r' d="([^"]+)"', path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("ending", tiers(["npz"], ["npy", "parquet"]))
def test_a_file_of_arrays_is_drawn_as_its_csv_is(tmp_path, ending):
    run = polhode.integrate(polhode.load(TOP).at([Fraction(k, 10) for k in range(31)]))
    columns = of_run(run)
    rotated = {name: x[::-1] for name, x in columns.items()}  # in no order
    first, second = (
        paths(plotted(tmp_path, str(table), "--what", "omega", name=f"{table.name}.svg"))
        for table in (through(ending, columns, tmp_path), through("csv", rotated, tmp_path))
    )
    assert first == second
    assert max(map(len, first)) > 300


@pytest.mark.slow
def test_a_trajectory_file_is_drawn_like_its_scene(tmp_path):
    path, times = tmp_path / "run.csv", ",".join(f"{k}/10" for k in range(101))
    command = ["run", TOP, "--at", times, "--outputs", "angles,attitude", "-o", str(path)]
    assert main(command) == 0
    drawn = texts(plotted(tmp_path, str(path), "--what", "hodographs"))
    assert drawn
    theirs = texts(plotted(tmp_path, TOP, "--what", "hodographs", "--end", "10", name="y.svg"))
    assert [text.replace("third axis", "centre of mass") for text in drawn] == theirs


@pytest.mark.slow
def test_a_file_with_the_space_hodograph_needs_no_attitude(tmp_path):
    path = tmp_path / "run.csv"
    command = ["run", TOP, "--at", "1,2,3,4,5", "--outputs", "hodographs", "-o", str(path)]
    assert main(command) == 0
    assert "in space" in texts(plotted(tmp_path, str(path), "--what", "hodographs"))


@pytest.mark.slow
def test_the_same_motion_gives_the_same_bytes(tmp_path):
    arguments = (TOP, "--what", "angles", "--end", "3")
    first = plotted(tmp_path, *arguments, name="a.svg").read_bytes()
    assert first == plotted(tmp_path, *arguments, name="b.svg").read_bytes()
    assert first.startswith(b"<?xml")
    assert len(first) < 500_000


def test_json_says_what_was_drawn(tmp_path, capsys):
    path = plotted(tmp_path, "euler/long", "--what", "sphere", "--json")
    out, err = capsys.readouterr()
    shown = json.loads(out)
    assert (shown["file"], shown["samples"]) == (str(path), 2001)
    assert 0 < shown["to"] < 200
    assert "of 10000" in err
    assert "--end" in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("euler/no-gamma --what angles", "start.gamma"),
        ("euler/no-gamma --what sphere", "start.gamma"),
        (f"{TOP} --what pictures", "--what = pictures: expected angles, "),
        (f"{TOP} --what angles --end soon", "--end"),
        (f"{TOP} --what angles --end 0", "end other than 0"),
        (f"{TOP} --what angles --number octuple", "quad"),
        (f"{TOP} --what error --scene {TOP}", "FILE"),
        (f"{TOP} --what omega --read degrees", "no --read: it is for a FILE"),
        ("lagrange/loping --what angles", "lagrange/looping"),
        ("bare.csv --what angles", "psi, theta, phi"),
        ("bare.csv --what sphere", "gamma1"),
        ("bare.csv --what hodographs", "q0"),
        ("bare.csv --what error", "--scene"),
        ("bare.csv --what integrals", "--scene"),
        (f"bare.csv --what integrals --scene {TOP}", "gamma1"),
        ("bare.csv --what sphere --end 3", "--end"),
        ("bare.csv --what sphere --number quad", "--scene"),
        ("bare.csv --what omega --read degrees", "--scene whose conventions are meant"),
        ("turns.csv --what angles", "for angles; --what attitude draws its q0, q1, q2, q3"),
        (f"empty.csv --what error --scene {TOP}", "column"),
        ("short.csv --what angles", "three rows"),
        ("missing.csv --what angles", "readable CSV"),
        (f"{TOP} --what angles -o x.jpg", ".svg or .png or .pdf"),
        (f"{TOP} --what angles -o x.svg.gz", ".svg"),
        (f"{TOP} --what angles -o nowhere/x.svg", "nowhere"),
        (f"{TOP} --what motion", ".gif"),
        (
            f"{TOP} --what motion -o x.html",
            "polhode view lagrange/looping -o x.html, which makes pages",
        ),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_one_line(tmp_path, refusal, words, said):
    (tmp_path / "bare.csv").write_text("t,p,q,r\n0,1,2,3\n1,1,2,3\n2,1,2,3\n")
    (tmp_path / "turns.csv").write_text("t,q0,q1,q2,q3\n0,1,0,0,0\n1,1,0,0,0\n2,1,0,0,0\n")
    (tmp_path / "empty.csv").write_text("t,u\n0,1\n1,1\n2,1\n")
    (tmp_path / "short.csv").write_text("t,psi\n0,1\n1,1\n")
    arguments = words.split()
    assert said in refusal("plot", *arguments, *([] if "-o" in arguments else ["-o", "x.svg"]))


def test_a_run_that_does_not_reach_its_end_draws_nothing(tmp_path, capsys):
    path = tmp_path / "x.svg"
    assert main(["plot", "lagrange/from-the-pole", "--what", "angles", "-o", str(path)]) == 3
    assert "singular at theta" in capsys.readouterr().err
    assert not path.exists()


# -- fonts that lack letters -----------------------------------------------------------------------

#: Knuth's roman and sans serif, which ship with matplotlib: without Greek, or raised digits.
WITHOUT_GREEK = [
    {"font.family": ["cmr10"]},
    {"font.family": "sans-serif", "font.sans-serif": ["cmss10"]},
]
WITH_GREEK = [{}, {"font.family": ["cmr10", "DejaVu Sans"]}, {"font.family": "DejaVu Serif"}]
LABELS = {
    "ψ (rad)": r"$\psi$ (rad)",
    "10⁻¹²": "10$^{-12}$",
    "|Δh| / (T₀ + Mg|r₀|)": r"|$\Delta$h| / (T$_0$ + Mg|r$_0$|)",
    "S²×S¹": r"S$^{2} \times$S$^{1}$",
    "||γ|² − 1|": r"||$\gamma$|$^{2}$ $-$ 1|",
    "ω·X (rad / unit of time)": r"$\omega \cdot$X (rad / unit of time)",
    "p (rad / unit of time)": "p (rad / unit of time)",
}


@pytest.mark.parametrize(
    "style",
    tiers([WITHOUT_GREEK[0], {}], [WITHOUT_GREEK[1], {"text.usetex": True}, *WITH_GREEK[1:]]),
)
def test_labels_are_mathtext_where_the_font_lacks_a_letter_and_under_tex(style):
    """And plain text where the font has it."""
    with plt.rc_context(style | {"axes.formatter.use_mathtext": True}):
        words = "angles", "integrals", "hodographs", "error"
        panels = [x for word in words for x in np.ravel(polhode.plot(TOP, word, end=1))]
        labels = {x for panel in panels for x in (panel.get_xlabel(), panel.get_ylabel())}
        labels.add(panels[-2].yaxis.get_major_formatter()(-12.0))  # of the error's axis
        *_, legend = polhode.levels("lagrange/nutation").plot().get_legend_handles_labels()
    assert {*(LABELS if style in WITH_GREEK else LABELS.values())} <= labels | {*legend}


@pytest.mark.parametrize("style", WITHOUT_GREEK)
@pytest.mark.parametrize(
    ("scene", "quantity"),
    [
        *(("lagrange/nutation", x) for x in ("angles", "omega", "sphere", "hodographs")),
        *(("lagrange/nutation", x) for x in ("integrals", "error")),
        ("euler/largest-axis", "hodographs"),
    ],
)
def test_no_letter_is_a_box(scene, quantity, style):
    with plt.rc_context(style | {"axes.formatter.use_mathtext": True}), warnings.catch_warnings():
        warnings.simplefilter("error")  # "Glyph 968 missing from font(s)"
        polhode.plot(scene, quantity, end=1)
        plt.gcf().canvas.draw()


@pytest.mark.slow
@pytest.mark.parametrize("style", WITHOUT_GREEK)
def test_no_letter_of_a_section_or_a_level_is_a_box(style):
    cut = polhode.section("kovalevskaya/generic", grid=(1, 2), crossings=2, by="height")
    with plt.rc_context(style | {"axes.formatter.use_mathtext": True}), warnings.catch_warnings():
        warnings.simplefilter("error")
        for result in (cut, polhode.levels("lagrange/nutation")):
            result.plot()
            plt.gcf().canvas.draw()
