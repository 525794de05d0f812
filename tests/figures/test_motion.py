"""Motions that move: what a page holds, how exact it is between its samples, films, refusals."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
from dataclasses import replace
from fractions import Fraction
from html import unescape

import numpy as np
import pytest

import polhode
from polhode.cli import main

pytest.importorskip("matplotlib")
TOP = "lagrange/looping"
BOX = """
schema = 1
title = "A <box> & more"
[body]
g = 0
parts = [{ shape = "box", mass = 1, size = [3, 2, 1] }]
[start]
omega = ["1/10", 1, 0]
gamma = ["3/5", 0, "4/5"]
[run]
end = 30
"""


def told(text):
    """The JSON of a page, its samples as an array."""
    data = json.loads(re.search(r'<script type="application/json"[^>]*>(.*?)</script>', text)[1])
    numbers = np.frombuffer(base64.b64decode(data["samples"]), "<f4").astype(float)
    return data, numbers.reshape(-1, 7)


def rate(row):
    (a, b, c, d), (x, y, z) = row[:4], row[4:]
    return (
        np.array(
            [
                -b * x - c * y - d * z,
                a * x + c * z - d * y,
                a * y + d * x - b * z,
                a * z + b * y - c * x,
            ]
        )
        / 2
    )


def between(data, rows, t):
    """What the page shows at time t: its own formula, written again."""
    step = (data["end"] - data["begin"]) / (len(rows) - 1)
    k = min(len(rows) - 2, int((t - data["begin"]) / step))
    s = (t - data["begin"]) / step - k
    p, q = rows[k], rows[k + 1]
    found = (
        (1 + 2 * s) * (1 - s) ** 2 * p[:4]
        + s * (1 - s) ** 2 * step * rate(p)
        + s * s * (3 - 2 * s) * q[:4]
        + s * s * (s - 1) * step * rate(q)
    )
    return found / np.linalg.norm(found)


@pytest.mark.parametrize("name", [TOP, "euler/largest-axis"])
def test_a_page_shows_the_closed_forms_attitude_between_its_samples(name):
    page = polhode.view(name, end=10)
    data, rows = told(page.text)
    exact = polhode.reference(name)
    times = [0.0, 1 / 3, 5.4321, 9.999]
    true = np.array([[float(x) for x in row] for row in exact.attitude(times, 15)])
    own = np.array([between(data, rows, t) for t in times])
    off = min(np.max(np.abs(own - sign * true)) for sign in (1, -1))
    assert 1e-9 < off < 1e-6  # floats of 24 bits, a thousandth of the width of a line
    assert data["end"] == 10


def test_a_page_needs_nothing_else_and_is_small():
    text = polhode.view(TOP).text
    assert len(text.encode()) < 200_000
    assert not re.search(r"(src|href)=|@import|url\(|fetch\(|https?://", text)


def of_scripts(text, expression):
    """What an expression is in the page's own scripts, run by Node.js; none of them draws."""
    if shutil.which("node") is None:
        pytest.skip("no Node.js here")
    data, _ = told(text)
    scripts = text[text.rindex("<script>") + 8 : text.index("// Two views of a motion")]
    lines = (
        "const document = {createElement: () => ({getContext: () => null})};",
        scripts,
        f"const own = Motion.of({json.dumps(data)});",
        f"console.log(JSON.stringify({expression}));",
    )
    command = ["node", "-e", "\n".join(lines)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=True)
    return json.loads(done.stdout)


PREVIEW = "preview(own, ...new Start(own).at(new Start(own).first{}, new Start(own).second{}))"


@pytest.mark.parametrize(
    "name",
    [
        *(TOP, "euler/dzhanibekov", "kovalevskaya/generic", "lagrange/turned-axes"),
        *("lagrange/backward", "hard/heavy-tiny-units"),
    ],
)
def test_a_preview_of_the_scenes_own_start_is_polhodes_motion_to_a_line_and_not_beyond(name):
    end = {"lagrange/backward": -20, "hard/heavy-tiny-units": "2e-7"}.get(name, 20)
    text = polhode.view(name, end=end).text
    data, rows = told(text)
    assert data["start"]["t"] == 0
    found = of_scripts(text, f"[...{PREVIEW.format('', '')}.numbers]")
    size = np.array([1.0] * 4 + [np.max(np.abs(rows[:, 4:]))] * 3)
    off = np.max(np.abs(np.reshape(found, rows.shape) - rows) / size)
    assert 1e-8 < off < 1e-4


@pytest.mark.slow
def test_a_preview_that_is_not_accurate_is_not_shown():
    """Faster than its start says: a thin body whose weight turns it about its thin axis."""
    thin = {"moments": ["1e-6", 1, 1], "centre": [0, 1, "1/10"], "weight": 1}
    top = polhode.top(**thin, omega=["1/10", 0, 0], gamma=[0, 0, 1], end=2)
    text = polhode.view(top).text
    own = PREVIEW.format("", "")
    shown = of_scripts(text, f"(({own}) || {{numbers: [0]}}).numbers.length")
    assert shown == 1
    assert "between them the picture is not the motion" in text


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (TOP, "Its path has loops."),
        ("lagrange/cusped", "Its path has cusps, or nearly."),
        ("lagrange/nutation", "Its path is a wave."),
        ("lagrange/spherical-pendulum", "Its path is a wave."),
        ("lagrange/planar-librating", "It swings in a plane."),
        ("lagrange/steady-slow", "The axis keeps its tilt, or nearly."),
        ("lagrange/upper-pole", "The axis passes through the vertical, or close to it."),
        ("lagrange/lower-pole", "The axis passes through the vertical, or close to it."),
        ("lagrange/sleeping-stable", "The axis stays vertical, or nearly."),
        (
            "lagrange/sleeping-unstable",
            "The axis stands upright, but spins too slowly: the smallest push makes it fall.",
        ),
        ("kovalevskaya/generic", ""),
    ],
)
def test_what_a_preview_looks_like_is_decided_by_its_start(name, words):
    text = polhode.view(name, end="1/10").text
    assert of_scripts(text, "looks(own, own.start.attitude, own.start.omega)") == words


def test_angles_do_not_climb_by_passing_the_pole():
    """A pendulum in a plane: psi and phi jump by half a turn there, and back."""
    text = polhode.view("lagrange/planar-rotating", end=40).text
    rows = of_scripts(text, "own.angles()")
    for row in rows[1:]:
        seen = np.array([x for x in row if x is not None])
        assert len(seen) < len(row)  # the jumps are gaps
        assert np.ptp(seen) < 3.2
    assert '"not shown: at a pole, or rows too far apart"' in text


@pytest.mark.parametrize(("first", "second"), [(0.5, 0.0), (0.0, 0.4), (-1.25, -0.3)])
def test_a_preview_of_another_start_is_the_motion_that_polhode_computes_from_it(first, second):
    """The numbers that the page shows, put into a scene, give the preview's motion."""
    text = polhode.view(TOP, end=8).text
    made = PREVIEW.format(f" + {first}", f" + {second}")
    start = made.replace("preview(own, ...", "(")
    (attitude, omega), found = of_scripts(text, f"[{start}, [...{made}.numbers]]")
    a, b, c, d = attitude
    gamma = [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d]
    old = polhode.load(TOP)
    tilt = np.arccos(gamma[2]) - np.arccos(float(old.gamma[2]))
    assert tilt == pytest.approx(second, abs=1e-9)
    assert omega[2] - float(old.omega[2]) == pytest.approx(first, abs=1e-9)
    body = {"moments": old.body.moments, "centre": old.body.centre, "weight": old.body.weight}
    scene = polhode.top(**body, omega=omega, gamma=gamma, end=8, samples=2001)
    run = polhode.integrate(scene)
    q0, q1, q2, q3, *w = np.reshape(found, (-1, 7)).T
    vertical = [2 * (q1 * q3 - q0 * q2), 2 * (q2 * q3 + q0 * q1), 1 - 2 * (q1 * q1 + q2 * q2)]
    off = np.max(np.abs(np.array([*w, *vertical]).T - run.states))
    assert 1e-8 < off < 2e-4


def test_the_angles_of_a_page_are_eulers():
    text = polhode.view("lagrange/nutation", end=20).text
    found = np.array(of_scripts(text, "own.angles()"))
    times = [20 * k / 2000 for k in range(0, 2001, 100)]
    exact = polhode.reference("lagrange/nutation").angles(times, 15)
    psi, theta, phi = np.array([[float(x) for x in row] for row in exact]).T
    own = found[:, ::100]
    assert own[0] == pytest.approx(theta, abs=1e-6)
    for mine, true in ((own[1], psi), (own[2], phi)):
        assert mine - mine[0] == pytest.approx(true - true[0], abs=2e-6)


def test_the_ellipsoid_of_energy_touches_its_plane():
    text = polhode.view("euler/largest-axis", end=10).text
    data, rows = told(text)
    found = of_scripts(text, "poinsot(own)")
    axes, energy = np.array(data["axes"]), np.array(found["semi"])
    assert data["poinsot"]
    for row in rows[::100]:
        a, b, c, d = row[:4]
        matrix = np.array(
            [
                [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
                [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
                [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
            ]
        )
        assert np.sum((axes @ row[4:] / energy) ** 2) == pytest.approx(1, abs=1e-6)
        assert found["upward"] @ matrix @ row[4:] == pytest.approx(found["height"], rel=1e-6)


def test_a_body_of_parts_is_drawn_as_it_is_and_texts_stay_texts(tmp_path, capsys):
    scene, page = tmp_path / "box.toml", tmp_path / "box.html"
    scene.write_text(BOX)
    assert main(["view", str(scene), "-o", str(page), "--json"]) == 0
    made = json.loads(capsys.readouterr().out)
    text = page.read_text(encoding="utf-8")
    assert made["bytes"] == len(text.encode())
    data, rows = told(text)
    assert made["samples"] == len(rows)
    (box,) = data["solids"]
    assert (box["kind"], box["place"][3]) == ("box", [0, 0, 0])
    assert np.array(box["numbers"]) / box["numbers"][2] == pytest.approx([3, 2, 1])
    assert np.linalg.norm(box["numbers"]) / 2 == pytest.approx(0.8)  # fits the sphere
    assert "<title>A &lt;box&gt; &amp; more</title>" in text
    assert BOX.strip() in unescape(text)


def test_a_motion_backwards_in_time_is_shown_forwards():
    data, rows = told(polhode.view("euler/largest-axis", end=-5).text)
    assert (data["begin"], data["end"]) == (-5, 0)
    start = [float(x) for x in polhode.load("euler/largest-axis").omega]
    assert rows[-1, 4:] == pytest.approx(start, rel=1e-7)


@pytest.mark.slow
def test_a_trajectory_file_of_another_program_is_shown(tmp_path, capsys):
    table, page = tmp_path / "x.csv", tmp_path / "x.html"
    times = ",".join(str(k / 20) for k in range(101))
    run = ["run", TOP, "--at", times, "--outputs", "attitude", "-o", str(table)]
    assert main(run) == 0
    capsys.readouterr()
    assert main(["view", str(table), "--scene", TOP, "-o", str(page)]) == 0
    assert capsys.readouterr().err == ""
    text = page.read_text(encoding="utf-8")
    _, rows = told(text)
    assert len(rows) == 101
    assert "as the file has them" in text
    assert "makes loops" in text
    assert main(["view", str(table), "--scene", "lagrange/nutation", "-o", str(page)]) == 0
    assert "of another motion than the scene" in page.read_text(encoding="utf-8")
    said = (
        "the file is of another motion than the scene's: energy or momentum differ; "
        "polhode compare FILE SCENE says which convention or cause"
    )
    assert said in capsys.readouterr().err
    film = ["plot", str(table), "--what", "motion", "--size", "100", "--fps", "2"]
    film += ["-o", str(tmp_path / "x.gif"), "--scene"]
    assert main([*film, "lagrange/nutation"]) == 0
    assert said in capsys.readouterr().err
    assert main([*film, TOP]) == 0
    assert "another motion" not in capsys.readouterr().err
    assert main(["view", str(table), "--scene", TOP, "-o", str(page)]) == 0
    capsys.readouterr()
    assert main(["view", str(table), "-o", str(page)]) == 2
    assert "the scene that the file belongs to" in capsys.readouterr().err
    lines = table.read_text().splitlines()
    table.write_text("\n".join([lines[0], *lines[1::10]]))
    for draws in (["view", str(table), "-o", str(page), "--scene"], film):
        assert main([*draws, TOP]) == 0
        said = re.search(r"Two samples are up to \S+ radians apart.*", capsys.readouterr().err)[0]
        assert said in page.read_text(encoding="utf-8")
    table.write_text("\n".join(lines[:10] + lines[11:]))
    assert main(["view", str(table), "--scene", TOP, "-o", str(page)]) == 2
    assert "three rows or more at even times" in capsys.readouterr().err


def test_a_file_is_shown_in_the_conventions_that_are_told(tmp_path, capsys):
    """omega in degrees, the scalar last, other names: the same page as of the plain file."""
    times = [Fraction(k, 20) for k in range(41)]
    run = polhode.integrate(replace(polhode.load(TOP).at(times), outputs=("attitude",)))
    t, w = np.array(run.t, dtype=float), run.states[:, :3]
    q = np.array(run.attitude, dtype=float)
    tables = {"plain": np.c_[t, w, q], "other": np.c_[1000 * t, np.degrees(w), np.roll(q, -1, 1)]}
    for name, rows in tables.items():
        head = "t,p,q,r,q0,q1,q2,q3" if name == "plain" else "clock,p,q,r,q0,q1,q2,q3"
        path = tmp_path / f"{name}.csv"
        np.savetxt(path, rows, delimiter=",", fmt="%.17g", header=head, comments="")
    read = ["--read", "degrees, scalar-last", "--columns", "clock=t*1e-3"]
    shown = {}
    for name, told_by_hand in (("plain", []), ("other", read)):
        page = tmp_path / f"{name}.html"
        command = ["view", str(tmp_path / f"{name}.csv"), "--scene", TOP, "-o", str(page)]
        assert main([*command, *told_by_hand]) == 0
        assert capsys.readouterr().err == ""
        shown[name] = told(page.read_text(encoding="utf-8"))[1]
    assert shown["other"] == pytest.approx(shown["plain"], abs=1e-6)
    picture = ["-o", str(tmp_path / "x.svg")]
    other = str(tmp_path / "other.csv")
    assert main(["plot", other, "--what", "omega", "--scene", TOP, *read, *picture]) == 0
    assert main(["plot", other, "--what", "omega", *read, *picture]) == 2
    assert "--scene whose conventions are meant" in capsys.readouterr().err
    assert main(["plot", TOP, "--what", "omega", "--read", "degrees", *picture]) == 2
    assert "no --read: it is for a FILE" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["view", TOP, "-o", "x.png"], "a name that ends in .html"),
        (["plot", TOP, "--what", "motion", "-o", "x.svg"], ".html or .gif or .mp4"),
        (["plot", TOP, "--what", "omega", "-o", "x.gif"], ".svg, .png, .pdf"),
        (["view", "nope/nope", "-o", "x.html"], "the name of a case"),
        (["plot", TOP, "--what", "motion", "-o", "x.gif", "--fps", "0"], "--fps"),
        (["plot", TOP, "--what", "motion", "-o", "x.gif", "--fps", "30"], "hundredths of a second"),
        (["plot", TOP, "--what", "motion", "-o", "x.gif", "--size", "5"], "an even number"),
        (["plot", TOP, "--what", "omega", "-o", "x.svg", "--fps", "20"], "a film"),
        (["plot", TOP, "--what", "motion", "-o", "x.html", "--size", "200"], "a film"),
    ],
)
def test_what_cannot_be_shown_is_refused(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_film_in_mp4_needs_ffmpeg_and_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", "")
    assert main(["plot", TOP, "--what", "motion", "-o", "x.mp4"]) == 2
    assert "the program ffmpeg" in capsys.readouterr().err


def test_an_ffmpeg_that_fails_is_one_line(tmp_path, monkeypatch, capsys):
    """One that ends at once, and one that is there and cannot be run."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    fake = tmp_path / "ffmpeg"
    for text in ("#!/bin/sh\necho no such codec >&2; exit 3\n", "#!/nowhere/sh\n"):
        fake.write_text(text)
        fake.chmod(0o755)
        assert main(["plot", TOP, "--what", "motion", "--end", "1", "-o", "x.mp4"]) == 2
        (line,) = [x for x in capsys.readouterr().err.splitlines() if "drawn to" not in x]
        assert "a program ffmpeg that films in MP4" in line
        assert [path.name for path in tmp_path.iterdir()] == ["ffmpeg"]


def gif_pictures(path):
    from PIL import Image

    with Image.open(path) as made:
        for k in range(made.n_frames):
            made.seek(k)
            yield np.array(made.convert("RGB")).astype(int)


def mp4_pictures(path):
    """Read again by ffmpeg; each is 360 x 360."""
    command = ["ffmpeg", "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, timeout=100, check=True)
    yield from np.frombuffer(done.stdout, np.uint8).reshape(-1, 360, 360, 3).astype(int)


@pytest.mark.parametrize(("suffix", "pictures"), [(".gif", gif_pictures), (".mp4", mp4_pictures)])
def test_a_film_shows_the_motion_to_its_end(tmp_path, monkeypatch, suffix, pictures):
    from polhode.figures import film

    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        pytest.skip("no ffmpeg here")
    monkeypatch.setattr(film, "SECONDS", 1)
    path = tmp_path / f"x{suffix}"
    assert main(["plot", TOP, "--what", "motion", "--end", "4", "--fps", "5", "-o", str(path)]) == 0
    counts = [int(np.sum((p[..., 0] > 180) & (p[..., 2] < 90))) for p in pictures(path)]
    assert len(counts) == 5
    assert counts == sorted(counts)  # the path grows
    assert counts[-1] > 5 * counts[0]


@pytest.mark.parametrize(
    ("name", "end", "turns"),
    [
        ("pendulum/librating", 40, 4),
        ("grioli/precession", 20, 3),
        (TOP, 26, 0),
        ("euler/dzhanibekov", 20, 0),  # nearly a rotation until it flips
        ("euler/separatrix-backward", -30, 0),
        ("euler/rest", 5, 0),
    ],
)
def test_a_film_ends_where_the_motion_is_back_at_its_start(
    tmp_path, monkeypatch, capsys, name, end, turns
):
    """A pendulum's as many whole periods as there are; of a top that comes never back, not."""
    from polhode.figures import film

    monkeypatch.setattr(film, "SECONDS", 1)
    path = tmp_path / "x.gif"
    command = ["plot", name, "--what", "motion", "--end", str(end), "--fps", "4", "-o", str(path)]
    assert main([*command, "--json"]) == 0
    out, err = capsys.readouterr()
    said = re.search(r"at t = ([\d.]+) the motion is as at t = 0,", err)
    if turns == 0:
        assert said is None
        assert json.loads(out)["to"] == end
        return
    assert json.loads(out)["to"] == pytest.approx(float(said[1]), rel=1e-5)
    period = float(polhode.reference(name).period)
    back = float(said[1])
    assert back / period == pytest.approx(round(back / period), abs=1e-4)
    assert round(back / period) == int(end / period)
    assert turns is None or int(end / period) == turns
    first, *_, last = gif_pictures(path)
    assert np.any(first != last)  # the last frame is the one before the first


def test_a_film_has_the_size_that_was_asked_for(tmp_path):
    path = tmp_path / "x.gif"
    command = ["plot", TOP, "--what", "motion", "--end", "1", "--fps", "1", "--size", "200"]
    assert main([*command, "-o", str(path)]) == 0
    pictures = [*gif_pictures(path)]
    assert [picture.shape for picture in pictures] == 6 * [(200, 200, 3)]


def test_what_is_drawn_of_a_part_has_its_volume():
    """Solids as pages and films draw them: their faces, seen from outside, enclose it."""
    from polhode.figures.solids import faces, solids, unit

    shapes = {
        "box": {"size": [1, 2, 3]},
        "cylinder": {"radius": 1, "height": 2, "inner": "1/2", "axis": "-x"},
        "cone": {"radius": 1, "height": 2, "axis": "y"},
        "ellipsoid": {"semi_axes": [1, 2, 3]},
        "sphere": {"radius": 1},
    }
    volumes = {
        "box": 6,
        "cylinder": 1.5 * np.pi,
        "cone": 2 / 3 * np.pi,
        "ellipsoid": 8 * np.pi,
        "sphere": 4 / 3 * np.pi,
    }
    for shape, lengths in shapes.items():
        part = polhode.Part(shape, mass=1, at=[1, 0, 0], **lengths)
        body = polhode.Body.of_parts([part], g=1)
        (solid,) = solids(body)
        a, b, c, d = np.moveaxis(faces(solid, 60).corners, 1, 0) * unit(body)
        enclosed = np.sum(a * np.cross(b, c) + a * np.cross(c, d)) / 6  # Gauss
        assert enclosed == pytest.approx(volumes[shape], rel=5e-3)


@pytest.mark.parametrize("what", ["omega", "momentum", "attitude"])
def test_curves_over_time_are_those_of_the_run(what):
    axes = polhode.plot("lagrange/turned-axes", what, end=5)
    lines = {line.get_label(): line for line in axes.lines}
    t = axes.lines[0].get_xdata()
    exact = polhode.reference("lagrange/turned-axes")
    k = len(t) // 3
    if what == "attitude":
        true = [float(x) for x in exact.attitude([t[k]], 15)[0]]
    else:
        true = [float(x) for x in exact.at([t[k]], 15)[0][:3]]
        if what == "momentum":
            body = exact.scene.body
            true = [
                sum(float(a) * w for a, w in zip(row, true, strict=True)) for row in body.inertia
            ]
    own = [line.get_ydata()[k] for line in lines.values()][: len(true)]
    assert own == pytest.approx(true, abs=1e-11)
    if what != "attitude":
        assert axes.lines[3].get_ydata()[k] == pytest.approx(np.linalg.norm(true), abs=1e-11)


def test_a_figure_is_drawn_into_axes_that_are_given():
    from matplotlib import pyplot as plt

    figure, given = plt.subplots(3, 2)
    back = polhode.plot(polhode.load(TOP), "angles", given[:, 1], end=2)
    assert list(back) == list(given[:, 1])
    assert all(panel.lines for panel in given[:, 1])
    assert not any(panel.lines for panel in given[:, 0])
    for axes, said in ((given[0], "3 matplotlib axes"), (3, "3 matplotlib axes")):
        with pytest.raises(polhode.BadInput, match=said):
            polhode.plot(TOP, "angles", axes, end=2)
    with pytest.raises(polhode.BadInput, match="did you mean 'angles'"):
        polhode.plot(TOP, "angels")
    plt.close(figure)


@pytest.mark.slow
@pytest.mark.parametrize("width", [400, 1400])
def test_a_browser_draws_it(tmp_path, width):
    """Body, path and hodographs are there, and nothing is wider than the window."""
    from measure.timings import frames

    browser = frames.browser()
    if browser is None:
        pytest.skip("no browser here")
    from PIL import Image

    page, shot = tmp_path / "x.html", tmp_path / "x.png"
    polhode.view(TOP).save(page)
    given = ["--virtual-time-budget=3000", f"--user-data-dir={tmp_path / 'profile'}"]
    command = [browser, *frames.SWITCHES, *given, f"--window-size={width},1300"]
    address = f"{page.as_uri()}#t=9&play=0"
    subprocess.run([*command, f"--screenshot={shot}", address], capture_output=True, timeout=100)
    picture = np.array(Image.open(shot).convert("RGB")).astype(int)
    r, g, b = picture[..., 0], picture[..., 1], picture[..., 2]
    orange, blue = (r > 190) & (g < 130) & (b < 60), (b > 120) & (r < 60)
    assert orange.sum() > 1000
    assert blue.sum() > 3000
    dom = subprocess.run([*command, "--dump-dom", address], capture_output=True, timeout=100)
    text = dom.stdout.decode()
    assert "t = 9.000" in text
    assert '<p id="fault" hidden="">' in text


@pytest.mark.slow
@pytest.mark.parametrize("name", [TOP, "euler/largest-axis"])
def test_a_frame_is_cheap(name):
    """A few calls of WebGL a thing drawn; the time that they take is measured by that script."""
    from measure.timings import frames

    if frames.browser() is None:
        pytest.skip("no browser here")
    found = frames.cost(polhode.view(name), 1400)
    assert 200 < found["calls"] < 420
    assert 5_000 < found["triangles"] < 50_000
    assert all(width > 600 for width in found["canvas"])
