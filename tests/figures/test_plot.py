"""Figures of motions: what the SVG shows, and what is refused."""

from __future__ import annotations

import json
import math
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from polhode.figures.canvas import curve_sampling, over_time
from polhode.figures.canvas.globe import Globe, facing_most
from polhode.scenes.vocabulary import STATE

pytest.importorskip("matplotlib")
SVG = "{http://www.w3.org/2000/svg}"
TOP = "lagrange/looping"
LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


@pytest.mark.parametrize("ending", ["npz", "npy", "parquet"])
def test_a_file_of_arrays_is_drawn_as_its_csv_is(tmp_path, ending):
    """By the reader of ``compare``."""
    run = polhode.integrate(polhode.load(TOP).at([Fraction(k, 10) for k in range(31)]))
    columns = {"t": np.array(run.t, dtype=float), **dict(zip(STATE, run.states.T, strict=True))}
    table = tmp_path / f"x.{ending}"
    if ending == "npz":
        np.savez(table, **columns)
    elif ending == "npy":
        np.save(table, np.rec.fromarrays([*columns.values()], names=[*columns]))
    else:
        pytest.importorskip("pyarrow")
        pytest.importorskip("pandas").DataFrame(columns).to_parquet(table)
    lines = zip(*(x.tolist() for x in columns.values()), strict=True)
    text = "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in lines)])
    (tmp_path / "x.csv").write_text(text + "\n")
    one, other = (
        Figure(plotted(tmp_path, str(tmp_path / name), "--what", "omega", name=f"{name}.svg"))
        for name in (f"x.{ending}", "x.csv")
    )
    assert np.array_equal(one.curve("p"), other.curve("p"), equal_nan=True)
    assert len(one.curve("p")) > 10


def test_a_file_with_a_quaternion_and_no_angles_says_what_draws_it(tmp_path, capsys):
    (tmp_path / "x.csv").write_text("t,q0,q1,q2,q3\n" + "0,1,0,0,0\n1,1,0,0,0\n2,1,0,0,0\n")
    arguments = ["plot", str(tmp_path / "x.csv"), "-o", str(tmp_path / "x.svg"), "--what"]
    assert main([*arguments, "angles"]) == 2
    error = capsys.readouterr().err
    assert "one of psi, theta, phi for angles; --what attitude draws its q0, q1, q2, q3" in error
    assert main([*arguments, "attitude"]) == 0
    (tmp_path / "x.csv").write_text("t,p\n0,1\n1,1\n2,1\n")
    assert main([*arguments, "angles"]) == 2
    assert "attitude" not in capsys.readouterr().err


def plotted(folder, *arguments, name="x.svg"):
    path = folder / name
    assert main(["plot", *arguments, "-o", str(path)]) == 0
    return path


class Figure:
    """An SVG file read back: texts, curves by their names, ticks."""

    def __init__(self, path) -> None:
        assert path.stat().st_size < 500_000
        self.root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
        self.texts = ["".join(x.itertext()).strip() for x in self.root.iter(f"{SVG}text")]

    def group(self, name):
        return next(g for g in self.root.iter(f"{SVG}g") if g.get("id") == name)

    def curve(self, name):
        """Points of a curve on the page, y upwards; a row of nan between its pieces."""
        points = []
        for path in self.group(name).iter(f"{SVG}path"):
            for letter, x, y in re.findall(r"([ML]) (\S+) (\S+)", path.get("d")):
                if letter == "M" and points:
                    points.append((math.nan, math.nan))
                points.append((float(x), -float(y)))
        return np.array(points)

    def middle_of(self, name, panel):
        within = next(g for g in self.group(f"axes_{panel}").iter(f"{SVG}g") if g.get("id") == name)
        numbers = re.findall(r"[ML] (\S+) (\S+)", next(within.iter(f"{SVG}path")).get("d"))
        points = np.array(numbers, dtype=float) * (1, -1)
        return (points.max(axis=0) + points.min(axis=0)) / 2

    def scale(self, panel, axis):
        """Page to data along an axis: slope and offset from two numbered ticks of a panel."""
        ticks = []
        for group in self.group(f"axes_{panel}").iter(f"{SVG}g"):
            if re.fullmatch(rf"{axis}tick_\d+", group.get("id") or ""):
                texts = ["".join(t.itertext()).strip() for t in group.iter(f"{SVG}text")]
                use = next(group.iter(f"{SVG}use"))
                place = float(use.get(axis)) * (1 if axis == "x" else -1)
                if texts:
                    ticks.append((place, float(texts[0].replace("−", "-"))))
        (a, x), (b, y) = ticks[0], ticks[-1]
        return (y - x) / (b - a), x - a * (y - x) / (b - a)

    def data(self, name, panel, axes="xy"):
        points = self.curve(name)
        for k, axis in enumerate(axes):
            slope, offset = self.scale(panel, axis)
            points[:, k] = slope * points[:, k] + offset
        return points

    @property
    def panels(self):
        return sum(bool(re.fullmatch(r"axes_\d+", g.get("id") or "")) for g in self.root.iter())


# -- contents -----------------------------------------------------------------------------------


def test_angles_show_the_closed_forms_precession_and_nutation(tmp_path):
    figure = Figure(plotted(tmp_path, TOP, "--what", "angles", "--end", "10"))
    assert figure.panels == 3
    assert {"ψ (rad)", "θ (rad)", "φ (rad)", "t (units of the scene)"} <= set(figure.texts)
    exact = polhode.reference(TOP)
    for panel, name in ((1, "psi"), (2, "theta"), (3, "phi")):
        x_slope, x_offset = figure.scale(3, "x")  # the panels share it
        points = figure.curve(name)
        y_slope, y_offset = figure.scale(panel, "y")
        times = x_slope * points[:, 0] + x_offset
        assert times[0] == pytest.approx(0, abs=1e-5)
        assert times[-1] == pytest.approx(10, abs=1e-5)
        some = range(0, len(points), 7)
        rows = exact.angles([Fraction(times[k]) for k in some if times[k] >= 0], 12)
        true = [float(row[panel - 1]) for row in rows]
        drawn = [y_slope * points[k, 1] + y_offset for k in some if times[k] >= 0]
        assert np.max(np.abs(np.array(drawn) - true)) < 0.01 * np.ptp(true)


def test_angles_break_where_a_motion_goes_through_a_pole(tmp_path):
    figure = Figure(plotted(tmp_path, "pendulum/librating", "--what", "angles"))
    psi = figure.curve("psi")
    assert np.isnan(psi).any()
    pieces = np.split(psi[:, 1], np.flatnonzero(np.isnan(psi[:, 1])))
    assert all(np.nanmax(piece) - np.nanmin(piece) < 1e-3 for piece in pieces if len(piece) > 1)
    assert not np.isnan(figure.curve("theta")).any()


@pytest.mark.slow
def test_plan_and_elevation_have_one_scale_and_hold_the_motion(tmp_path):
    figure = Figure(plotted(tmp_path, "kovalevskaya/generic", "--what", "hodographs"))
    assert figure.panels == 4
    labels = {f"{x} (rad / unit of time)" for x in ("p", "q", "r", "ω·X", "ω·Y", "ω·Z")}
    assert labels <= set(figure.texts)
    for panel in range(1, 5):
        assert figure.scale(panel, "x")[0] == pytest.approx(figure.scale(panel, "y")[0], rel=1e-4)
    times = [Fraction(k, 100) for k in range(2001)]
    run = polhode.integrate("kovalevskaya/generic", at=times)
    p, q, r = run.states[:, :3].T
    for name, panel, y in (("body-elevation", 1, r), ("body-plan", 3, q)):
        drawn = figure.data(name, panel)
        for column, true in ((0, p), (1, y)):
            assert drawn[:, column].min() == pytest.approx(true.min(), abs=2e-3)
            assert drawn[:, column].max() == pytest.approx(true.max(), abs=2e-3)


def test_a_free_body_gets_polhode_and_herpolhode(tmp_path):
    """The herpolhode's distance from the foot of G: w² - (2h/G)²."""
    figure = Figure(plotted(tmp_path, "euler/largest-axis", "--what", "hodographs"))
    assert "herpolhode in the invariable plane" in figure.texts
    x, y = figure.data("herpolhode", 2).T
    scene = polhode.load("euler/largest-axis")
    run = polhode.integrate(scene, at=[Fraction(k, 20) for k in range(1000)])
    momentum = [float(x) for x in scene.body.momentum(scene.omega)]
    height2 = (2 * float(scene.integrals.energy)) ** 2 / np.dot(momentum, momentum)
    radius = np.sqrt(np.sum(run.states[:, :3] ** 2, axis=1) - height2)
    drawn = np.hypot(x, y)
    assert drawn.min() == pytest.approx(radius.min(), rel=0.02)
    assert drawn.max() == pytest.approx(radius.max(), rel=0.02)
    assert len(figure.curve("polhode")) > 50


@pytest.mark.parametrize("name", ["lagrange/cusped", TOP])
def test_cusps_and_loops_of_the_apex_stand_on_the_sphere(tmp_path, name):
    figure = Figure(plotted(tmp_path, name, "--what", "sphere"))
    assert {"γ in the body", "centre of mass in space", "x", "Z"} <= set(figure.texts)
    outline = figure.curve("outline")  # the first one: gamma's
    centre = (np.nanmax(outline, axis=0) + np.nanmin(outline, axis=0)) / 2
    radius = np.ptp(outline[:, 0]) / 2
    assert np.ptp(outline[:, 1]) / 2 == pytest.approx(radius, rel=1e-4)
    seen, hidden = (figure.curve(f"gamma{end}") for end in ("", "-hidden"))
    for points in (seen, hidden):
        assert np.nanmax(np.hypot(*(points - centre).T)) <= radius * 1.001
    assert len(figure.curve("apex")) > 50 < len(figure.curve("apex-hidden"))
    # seen face on, in the middle of its disc, only a cusp turns back between two samples
    apex = figure.curve("apex") - figure.middle_of("outline-2", 2)
    steps = np.diff(apex, axis=0)
    turns = np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0])))))
    sharpest = np.nanmax(turns[np.hypot(*apex[1:-1].T) < 0.7 * radius])
    assert sharpest > 2.5 if name.endswith("cusped") else sharpest < 0.6


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("number", ["double", "quad"])
def test_the_error_shown_is_the_error_found(tmp_path, number):
    figure = Figure(plotted(tmp_path, TOP, "--what", "error", "--number", number))
    scene = replace(polhode.load(TOP), outputs=())  # of the errors no output is integrated
    times = curve_sampling.shown_times(scene, None, over_time.SAMPLES)
    worst = -min(polhode.compare(polhode.integrate(scene, number, at=times)).digits)
    drawn = max(
        np.nanmax(log10s(figure, name, panel)) for name, panel in (("omega", 1), ("gamma", 2))
    )
    assert worst - 0.3 < drawn < worst + 0.5
    assert "eps" in figure.texts


def log10s(figure, name, panel):
    """The heights of a logarithmic curve, from the ticks 10^k of its panel."""
    ticks = []
    for group in figure.group(f"axes_{panel}").iter(f"{SVG}g"):
        if re.fullmatch(r"ytick_\d+", group.get("id") or ""):
            text = "".join("".join(t.itertext()) for t in group.iter(f"{SVG}text"))
            power = text.strip().removeprefix("10").translate(LOWERED)
            ticks.append((-float(next(group.iter(f"{SVG}use")).get("y")), float(power)))
    (a, x), (b, y) = ticks[0], ticks[-1]
    return x + (figure.curve(name)[:, 1] - a) * (y - x) / (b - a)


def test_integrals_shown_reach_the_drift_of_the_run(tmp_path):
    figure = Figure(plotted(tmp_path, "kovalevskaya/generic", "--what", "integrals"))
    assert figure.panels >= 3
    times = [Fraction(20 * k, 500) for k in range(501)]
    drift = polhode.integrate("kovalevskaya/generic", at=times, project=False).drift
    for panel, name in ((1, "h"), (2, "f"), (3, "gamma")):
        drawn = np.nanmax(log10s(figure, name, panel))
        assert drawn == pytest.approx(math.log10(getattr(drift, name)), abs=0.05)


def test_what_is_exactly_kept_is_said_to_be(tmp_path):
    figure = Figure(plotted(tmp_path, "euler/rest", "--what", "integrals"))
    assert figure.texts.count("exactly 0") == 3
    without = Figure(plotted(tmp_path, "euler/no-gamma", "--what", "integrals"))
    assert without.panels == 2  # h and |G|²


# -- files --------------------------------------------------------------------------------------


@pytest.fixture
def trajectory(tmp_path):
    times = ",".join(f"{k}/10" for k in range(101))
    path = tmp_path / "run.csv"
    asked = ["run", TOP, "--at", times, "--outputs", "angles,attitude", "-o", str(path)]
    assert main(asked) == 0
    return path


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("what", ["angles", "hodographs", "sphere", "integrals", "error"])
def test_a_trajectory_file_is_drawn_like_its_scene(tmp_path, trajectory, what):
    own = [] if what in ("angles", "hodographs", "sphere") else ["--scene", TOP]
    own += ["--number", "double"] if own else []
    figure = Figure(plotted(tmp_path, str(trajectory), "--what", what, *own))
    theirs = Figure(plotted(tmp_path, TOP, "--what", what, "--end", "10", name="y.svg"))
    third_axis = [text.replace("third axis", "centre of mass") for text in figure.texts]
    labels = [text for text in third_axis if not re.match(r"[−\d]", text)]
    assert labels == [text for text in theirs.texts if not re.match(r"[−\d]", text)]


@pytest.mark.slow
def test_a_file_with_the_space_hodograph_needs_no_attitude(tmp_path):
    path = tmp_path / "run.csv"
    asked = ["run", TOP, "--at", "1,2,3,4,5", "--outputs", "hodographs", "-o", str(path)]
    assert main(asked) == 0
    assert Figure(plotted(tmp_path, str(path), "--what", "hodographs")).panels == 4


@pytest.mark.sample(1)
@pytest.mark.parametrize("suffix", [".svg", ".png", ".pdf"])
def test_the_same_motion_gives_the_same_bytes(tmp_path, suffix):
    arguments = (TOP, "--what", "angles", "--end", "3")
    one = plotted(tmp_path, *arguments, name=f"a{suffix}").read_bytes()
    assert one == plotted(tmp_path, *arguments, name=f"b{suffix}").read_bytes()
    assert one.startswith({".svg": b"<?xml", ".png": b"\x89PNG", ".pdf": b"%PDF"}[suffix])


def test_json_says_what_was_drawn(tmp_path, capsys):
    path = plotted(tmp_path, "euler/long", "--what", "sphere", "--json")
    out, err = capsys.readouterr()
    shown = json.loads(out)
    assert shown["file"] == str(path)
    assert shown["samples"] == curve_sampling.SAMPLES
    assert 0 < shown["to"] < 200
    assert "of 10000" in err
    assert "--end" in err


def test_a_backward_scene_is_drawn_backward(tmp_path):
    figure = Figure(plotted(tmp_path, "lagrange/backward", "--what", "angles"))
    assert figure.scale(3, "x")[0] > 0
    assert figure.data("phi", 3)[:, 0].max() == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["euler/no-gamma", "--what", "angles"], "start.gamma"),
        (["euler/no-gamma", "--what", "hodographs"], "start.gamma"),
        (["euler/no-gamma", "--what", "sphere"], "start.gamma"),
        ([TOP, "--what", "pictures"], "--what = pictures: expected angles, "),
        ([TOP], "--what"),
        ([TOP, "--what", "angles", "--end", "soon"], "--end"),
        ([TOP, "--what", "angles", "--end", "0"], "end other than 0"),
        ([TOP, "--what", "angles", "--number", "octuple"], "quad"),
        ([TOP, "--what", "error", "--scene", TOP], "FILE"),
        (["lagrange/loping", "--what", "angles"], "lagrange/looping"),
        (["bare.csv", "--what", "angles"], "psi, theta, phi"),
        (["bare.csv", "--what", "sphere"], "gamma1"),
        (["bare.csv", "--what", "hodographs"], "q0"),
        (["bare.csv", "--what", "error"], "--scene"),
        (["bare.csv", "--what", "integrals"], "--scene"),
        (["bare.csv", "--what", "integrals", "--scene", TOP], "gamma1"),
        (["bare.csv", "--what", "sphere", "--end", "3"], "--end"),
        (["bare.csv", "--what", "sphere", "--number", "quad"], "--scene"),
        (["empty.csv", "--what", "error", "--scene", TOP], "column"),
        (["short.csv", "--what", "angles"], "three rows"),
        (["missing.csv", "--what", "angles"], "readable CSV"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_one_line(
    tmp_path, monkeypatch, capsys, arguments, said
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bare.csv").write_text("t,p,q,r\n0,1,2,3\n1,1,2,3\n2,1,2,3\n")
    (tmp_path / "empty.csv").write_text("t,u\n0,1\n1,1\n2,1\n")
    (tmp_path / "short.csv").write_text("t,psi\n0,1\n1,1\n")
    before = sorted(tmp_path.iterdir())
    assert main(["plot", *arguments, "-o", "x.svg"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert said in err
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("name", ["x.jpg", "x", "nowhere/x.svg", "x.svg.gz"])
def test_a_place_that_cannot_be_written_is_refused_before_the_run(
    tmp_path, monkeypatch, capsys, name
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(curve_sampling, "run", None)
    assert main(["plot", TOP, "--what", "angles", "-o", name]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_run_that_does_not_reach_its_end_draws_nothing(tmp_path, capsys):
    path = tmp_path / "x.svg"
    assert main(["plot", "lagrange/from-the-pole", "--what", "angles", "-o", str(path)]) == 3
    assert "singular at theta" in capsys.readouterr().err
    assert not path.exists()


# -- the globe ----------------------------------------------------------------------------------


def test_the_outline_of_an_ellipsoid_is_where_the_view_grazes():
    globe = Globe(25, 20, (1.0, 0.5, 2.0))
    points = globe._outline()
    assert np.max(np.abs(globe.facing(points))) < 1e-12
    assert np.max(np.abs(np.sum((points / globe.semi_axes) ** 2, axis=1) - 1)) < 1e-12
    inside = np.random.default_rng(1).normal(size=(500, 3))
    inside = inside / np.linalg.norm(inside, axis=1)[:, None] * globe.semi_axes
    assert np.ptp(globe.onto_page(inside)[:, 0]) <= np.ptp(globe.onto_page(points)[:, 0])


def test_the_view_shows_most_of_a_curve():
    behind = np.array([[-1.0, -0.2, 0.1 * k] for k in range(-3, 4)])
    assert (facing_most(behind).facing(behind) > 0).all()
    assert facing_most(np.array([[1.0, 0.3, 0.2]])) == Globe(25, 20)


def test_axes_of_a_scene_in_si_have_seconds():
    cone = polhode.Part("cone", mass="50 g", radius="3 cm", height="5 cm")
    top = polhode.top(parts=[cone], g=9.80665, angles=[0, "pi/6", 0], rates=[0, 0, 150], end=0.1)
    assert polhode.plot(top, "angles")[-1].get_xlabel() == "t (s)"
    axes = polhode.plot(top, "omega")
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("t (s)", "ω in the body (rad/s)")
    assert (
        polhode.plot("lagrange/nutation", "omega", end=1).get_xlabel() == "t (units of the scene)"
    )


def test_a_run_is_drawn_into_axes_that_come_first():
    from matplotlib import pyplot as plt

    run = polhode.integrate("lagrange/nutation", at=[1, 2])
    figure, axes = plt.subplots()
    assert run.plot(axes) is axes
    assert axes.lines
    plt.close(figure)
