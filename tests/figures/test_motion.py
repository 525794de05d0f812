"""Motions that move: what a page holds, how exact it is between its samples, films, refusals."""

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
from polhode.figures.motion_page import EXPLANATIONS, explained
from shared.tools import case_names, even_times, tiers

pytest.importorskip("matplotlib")
TOP = "lagrange/looping"


@pytest.fixture
def short_films(monkeypatch):
    """Of a few pictures."""
    monkeypatch.setattr("polhode.figures.film.FRAMES", 3)


def page_parts(text):
    """The JSON of a page, its samples as an array."""
    data = json.loads(re.search(r'<script type="application/json"[^>]*>(.*?)</script>', text)[1])
    numbers = np.frombuffer(base64.b64decode(data["samples"]), "<f4").astype(float)
    return data, numbers.reshape(-1, 7)


def turned(quaternions, vectors):
    """Rows of vectors, turned by rows of quaternions."""
    scalars, axes = quaternions[:, :1], quaternions[:, 1:]
    return vectors + 2 * np.cross(axes, np.cross(axes, vectors) + scalars * vectors)


def of_scripts(text, expression):
    """What an expression is in the page's own scripts, run by Node.js; none of them draws."""
    if shutil.which("node") is None:
        pytest.skip("no Node.js here")
    data, _ = page_parts(text)
    scripts = text[text.rindex("<script>") + 8 : text.index("// Two views of a motion")]
    lines = (
        "const document = {createElement: () => ({getContext: () => null})};",
        scripts,
        f"const own = Motion.of({json.dumps(data)});",
        f"console.log(JSON.stringify({expression}));",
    )
    command = ["node", "-e", "\n".join(lines)]
    process = subprocess.run(command, capture_output=True, text=True, timeout=100, check=True)
    return json.loads(process.stdout)


# -- pages --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [TOP, "euler/largest-axis"])
def test_a_page_shows_the_closed_forms_attitude_between_its_samples(name):
    page, exact = polhode.view(name, end=10), polhode.reference(name)
    data, rows = page_parts(page.text)
    assert (data["begin"], data["end"]) == (0, 10)
    last = np.array(exact.attitude([10], 15), float)[0]
    assert min(np.max(np.abs(rows[-1, :4] - sign * last)) for sign in (1, -1)) < 1e-6
    times = [0.0, 1 / 3, 5.4321, 9.999]
    true = np.array(exact.attitude(times, 15), float)
    own = np.array(of_scripts(page.text, f"{times}.map(t => own.attitude(t))"))
    off = min(np.max(np.abs(own - sign * true)) for sign in (1, -1))
    assert 1e-9 < off < 1e-6  # floats of 24 bits, a thousandth of the width of a line


def test_a_page_needs_nothing_else_and_is_small():
    text = polhode.view(TOP).text
    assert len(text.encode()) < 200_000
    assert not re.search(r"(src|href)=|@import|url\(|fetch\(|https?://", text)


def test_both_pictures_of_a_page_share_one_painter():
    """Of WebGL's contexts browsers have sixteen for all pages; one more is given back at once."""
    text = polhode.view("euler/largest-axis", end=4).text
    assert text.count('getContext("webgl2"') == 2
    assert text.count("loseContext()") == 1
    assert text.count("new Painter(") == 1


PREVIEW = "preview(own, ...new Start(own).at(new Start(own).first{}, new Start(own).second{}))"


@pytest.mark.parametrize(
    ("name", "end"),
    tiers(
        [(TOP, 20), ("lagrange/turned-axes", 20)],
        [("euler/dzhanibekov", 20), ("lagrange/backward", -20)],
    ),
)
def test_a_preview_of_the_scenes_own_start_is_polhodes_motion_to_a_line_and_not_beyond(name, end):
    text = polhode.view(name, end=end).text
    data, rows = page_parts(text)
    assert data["start"]["t"] == 0
    result = of_scripts(text, f"[...{PREVIEW.format('', '')}.numbers]")
    size = np.array([1.0] * 4 + [np.max(np.abs(rows[:, 4:]))] * 3)
    off = np.max(np.abs(np.reshape(result, rows.shape) - rows) / size)
    assert 1e-8 < off < 1e-4


@pytest.mark.slow
def test_a_preview_that_is_not_accurate_is_not_shown():
    """Faster than its start says: a thin body whose weight turns it about its thin axis."""
    thin = {"moments": ["1e-6", 1, 1], "centre": [0, 1, "1/10"], "weight": 1}
    top = polhode.top(**thin, omega=["1/10", 0, 0], gamma=[0, 0, 1], end=2)
    text = polhode.view(top).text
    assert of_scripts(text, f"{PREVIEW.format('', '')} === null")
    assert "between them the picture is not the motion" in text


@pytest.mark.parametrize(
    ("name", "words"),
    tiers(
        [
            (TOP, "Its path has loops."),
            ("lagrange/steady-slow", "The axis keeps its tilt, or nearly."),
        ],
        [
            ("lagrange/cusped", "Its path has cusps, or nearly."),
            ("lagrange/spherical-pendulum", "Its path is a wave."),
            ("lagrange/upper-pole", "The axis passes through the vertical, or close to it."),
            ("lagrange/sleeping-stable", "The axis stays vertical, or nearly."),
        ],
    ),
)
def test_what_a_preview_looks_like_is_decided_by_its_start(name, words):
    text = polhode.view(name, end="1/10").text
    looks = of_scripts(text, "looks(own, own.start.attitude, own.start.omega)")
    assert looks.endswith(words)
    assert bool(looks) == bool(words)


@pytest.mark.parametrize(("first", "second"), tiers([(0.5, 0.0), (0.0, 0.4)], [(-1.25, -0.3)]))
def test_a_preview_of_another_start_is_the_motion_that_polhode_computes_from_it(first, second):
    """The numbers that the page shows, put into a scene, give the preview's motion."""
    text = polhode.view(TOP, end=8).text
    results = PREVIEW.format(f" + {first}", f" + {second}")
    start = results.replace("preview(own, ...", "(")
    (attitude, omega), result = of_scripts(text, f"[{start}, [...{results}.numbers]]")
    old, (a, b, c, d) = polhode.load(TOP), attitude
    gamma = [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d]
    tilt = np.arccos(gamma[2]) - np.arccos(float(old.gamma[2]))
    assert tilt == pytest.approx(second, abs=1e-9)
    assert omega[2] - float(old.omega[2]) == pytest.approx(first, abs=1e-9)
    body = {"moments": old.body.moments, "centre": old.body.centre, "weight": old.body.weight}
    scene = polhode.top(**body, omega=omega, gamma=gamma, end=8, samples=2001)
    q, w = np.split(np.reshape(result, (-1, 7)), [4], axis=1)
    vertical = turned(q * [1, -1, -1, -1], [[0.0, 0.0, 1.0]])
    off = np.max(np.abs(np.hstack([w, vertical]) - polhode.integrate(scene).states))
    assert 1e-8 < off < 2e-4


def test_the_angles_of_a_page_are_eulers():
    text = polhode.view("lagrange/nutation", end=20).text
    own = np.array(of_scripts(text, "own.angles()"))[:, ::100]
    exact = polhode.reference("lagrange/nutation").angles(even_times(Fraction(20), 21), 15)
    psi, theta, phi = np.array(exact, float).T
    assert own[0] == pytest.approx(theta, abs=1e-6)
    for mine, true in ((own[1], psi), (own[2], phi)):
        assert mine - mine[0] == pytest.approx(true - true[0], abs=2e-6)


def test_angles_do_not_climb_by_passing_the_pole():
    """A pendulum in a plane: psi and phi jump by half a turn there, and back."""
    text = polhode.view("lagrange/planar-rotating", end=40).text
    for row in of_scripts(text, "own.angles()")[1:]:
        shown = np.array([x for x in row if x is not None])
        assert len(shown) < len(row)  # the jumps are gaps
        assert np.ptp(shown) < 3.2
    assert '"not shown: at a pole, or rows too far apart"' in text


def test_the_ellipsoid_of_energy_touches_its_plane():
    text = polhode.view("euler/largest-axis", end=10).text
    data, rows = page_parts(text)
    result = of_scripts(text, "poinsot(own)")
    assert data["poinsot"]
    along = rows[:, 4:] @ np.array(data["axes"]).T / result["semi"]
    assert np.sum(along**2, axis=1) == pytest.approx(1, abs=1e-6)
    height = turned(rows[:, :4], rows[:, 4:]) @ result["upward"]
    assert height == pytest.approx(result["height"], rel=1e-6)


def test_a_body_of_parts_is_drawn_as_it_is_and_texts_stay_texts(tmp_path, capsys):
    scene, page = tmp_path / "box.toml", tmp_path / "box.html"
    solid = polhode.Part("box", mass=1, size=[3, 2, 1])
    start = {"omega": ["1/10", 1, 0], "gamma": ["3/5", 0, "4/5"], "end": 30}
    box = polhode.as_toml(polhode.top(parts=[solid], g=0, title="A <box> & more", **start))
    scene.write_text(box)
    assert main(["view", str(scene), "-o", str(page), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    text = page.read_text(encoding="utf-8")
    data, rows = page_parts(text)
    assert (printed["bytes"], printed["samples"]) == (len(text.encode()), len(rows))
    (own,) = data["solids"]
    assert (own["kind"], own["place"][3]) == ("box", [0, 0, 0])
    assert np.array(own["numbers"]) / own["numbers"][2] == pytest.approx([3, 2, 1])
    assert np.linalg.norm(own["numbers"]) / 2 == pytest.approx(0.8)  # fits the sphere
    assert "<title>A &lt;box&gt; &amp; more</title>" in text
    assert box.strip() in unescape(text)


@pytest.mark.parametrize(
    ("name", "apex", "axis"),
    tiers(
        [("euler/dzhanibekov", "axis of the middle moment", 1)],
        [("euler/symmetric-first-axis", "axis of symmetry", 0), ("euler/sphere", "third axis", 2)],
    ),
)
def test_what_is_followed_of_a_free_body_is_named(name, apex, axis):
    assert polhode.plot(name, "sphere", end=1)[1].get_title() == f"{apex} in space"
    data, _ = page_parts(polhode.view(name, end=1).text)
    assert data["apex"] == np.eye(3)[axis].tolist()


def test_what_is_drawn_of_a_part_has_its_volume():
    """Solids as pages and films draw them: their faces, seen from outside, enclose it."""
    from polhode.figures.solids import faces, solids, unit

    hollow = {"radius": 1, "height": 2, "inner": "1/2", "axis": "-x"}
    for shape, lengths, volume in (
        ("box", {"size": [1, 2, 3]}, 6),
        ("cylinder", hollow, 1.5 * np.pi),
        ("cone", {"radius": 1, "height": 2, "axis": "y"}, 2 / 3 * np.pi),
        ("ellipsoid", {"semi_axes": [1, 2, 3]}, 8 * np.pi),
        ("sphere", {"radius": 1}, 4 / 3 * np.pi),
    ):
        body = polhode.Body.of_parts([polhode.Part(shape, mass=1, at=[1, 0, 0], **lengths)], g=1)
        (solid,) = solids(body)
        a, b, c, d = np.moveaxis(faces(solid, 60).corners, 1, 0) * unit(body)
        enclosed = np.sum(a * np.cross(b, c) + a * np.cross(c, d)) / 6  # Gauss
        assert enclosed == pytest.approx(volume, rel=5e-3)
        parts = [
            np.sum(a * np.cross(x, y), axis=1)[:, None] * (a + x + y) for x, y in ((b, c), (c, d))
        ]
        middle = np.sum(parts, axis=(0, 1)) / 24 / enclosed
        assert middle == pytest.approx([float(x) for x in body.centre], abs=5e-3)


def test_a_motion_backwards_in_time_is_shown_forwards():
    data, rows = page_parts(polhode.view("euler/largest-axis", end=-5).text)
    assert (data["begin"], data["end"]) == (-5, 0)
    start = [float(x) for x in polhode.load("euler/largest-axis").omega]
    assert rows[-1, 4:] == pytest.approx(start, rel=1e-7)


# -- files --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_trajectory_file_of_another_program_is_shown(tmp_path, capsys, short_films):
    table, page = tmp_path / "x.csv", tmp_path / "x.html"
    times = ",".join(str(k / 20) for k in range(101))
    assert main(["run", TOP, "--at", times, "--outputs", "attitude", "-o", str(table)]) == 0
    table.with_name("x.csv.json").unlink()  # with which it would be known as polhode's own
    view = ["view", str(table), "-o", str(page)]
    plot = ["plot", str(table), "--what", "motion", "-o", str(tmp_path / "x.gif")]

    def notes(command, scene, code=0):
        capsys.readouterr()
        assert main([*command, *(["--scene", scene] if scene else [])]) == code
        return capsys.readouterr().err

    assert notes(view, TOP) == ""
    text = page.read_text(encoding="utf-8")
    assert len(page_parts(text)[1]) == 101
    assert "as the file has them" in text
    assert "makes loops" in text
    for command in (view, plot):
        assert "is of another motion than the scene's" in notes(command, "lagrange/nutation")
        assert "another motion" not in notes(command, TOP)
    assert "the scene that the file belongs to" in notes(view, None, 2)
    lines = table.read_text().splitlines()
    table.write_text("\n".join([lines[0], *lines[1::10]]))
    for command in (view, plot):
        apart = re.search(r"Two samples are up to \S+ radians apart.*", notes(command, TOP))[0]
        assert apart in page.read_text(encoding="utf-8")
    table.write_text("\n".join(lines[:10] + lines[11:]))
    assert "three rows or more at even times" in notes(view, TOP, 2)


def test_a_file_is_shown_in_the_conventions_that_are_told(tmp_path, capsys):
    """omega in degrees, the scalar last, other names: the same page as of the plain file."""
    scene = polhode.load(TOP).at(even_times(Fraction(2), 41))
    run = polhode.integrate(replace(scene, outputs=("attitude",)))
    t, w, q = np.array(run.t, dtype=float), run.states[:, :3], np.array(run.attitude, dtype=float)
    tables = {"t": np.c_[t, w, q], "clock": np.c_[1000 * t, np.degrees(w), np.roll(q, -1, 1)]}
    read = ["--read", "omega degrees; attitude scalar-last", "--columns", "clock=t*1e-3"]
    shown = []
    for name, rows in tables.items():
        table, page = tmp_path / f"{name}.csv", tmp_path / f"{name}.html"
        head = f"{name},p,q,r,q0,q1,q2,q3"
        np.savetxt(table, rows, delimiter=",", fmt="%.17g", header=head, comments="")
        command = ["view", str(table), "--scene", TOP, "-o", str(page)]
        assert main([*command, *(read if name == "clock" else [])]) == 0
        assert capsys.readouterr().err == ""
        shown.append(page_parts(page.read_text(encoding="utf-8"))[1])
    assert shown[1] == pytest.approx(shown[0], abs=1e-6)
    plot = ["plot", str(table), "--what", "omega", "--scene", TOP, *read]
    assert main([*plot, "-o", str(tmp_path / "x.svg")]) == 0


# -- films --------------------------------------------------------------------------------------


def gif_pictures(path):
    from PIL import Image

    with Image.open(path) as results:
        for k in range(results.n_frames):
            results.seek(k)
            yield np.array(results.convert("RGB")).astype(int)


def test_a_film_shows_the_motion_to_its_end(tmp_path, short_films):
    path = tmp_path / "x.gif"
    assert main(["plot", TOP, "--what", "motion", "--end", "4", "-o", str(path)]) == 0
    shown = [*gif_pictures(path)]
    assert [picture.shape for picture in shown] == 3 * [(360, 360, 3)]
    counts = [int(np.sum((p[..., 0] > 180) & (p[..., 2] < 90))) for p in shown]
    assert counts == sorted(counts)  # the path grows
    assert counts[-1] > 5 * counts[0]


@pytest.mark.slow
def test_a_film_ends_where_the_motion_is_back_at_its_start(tmp_path, capsys, short_films):
    """A pendulum's as many whole periods as there are."""
    path = tmp_path / "x.gif"
    name = "pendulum/librating"
    command = ["plot", name, "--what", "motion", "--end", "40", "-o", str(path)]
    assert main([*command, "--json"]) == 0
    out, err = capsys.readouterr()
    back = json.loads(out)["to"]
    assert "the motion is as at t = 0," in err
    period = float(polhode.reference(name).period)
    assert back / period == pytest.approx(4, abs=1e-4)
    first, *_, last = gif_pictures(path)
    assert np.any(first[20:] != last[20:])  # below the title: the one before the first


@pytest.mark.slow
def test_what_is_nearer_is_drawn_later(tmp_path, monkeypatch, short_films):
    """The faces of a sphere that are seen well, whose depths follow from where they are drawn."""
    from matplotlib import collections, pyplot

    assert pyplot  # whose own classes are made of what is replaced
    drawn, results = [], collections.PolyCollection
    monkeypatch.setattr(
        collections, "PolyCollection", lambda x, **how: drawn.append(x) or results(x, **how)
    )
    command = ["plot", "euler/sphere", "--what", "motion", "--end", "1"]
    assert main([*command, "-o", str(tmp_path / "x.gif")]) == 0
    squares = np.sum(np.array([face for face in drawn[0] if len(face) == 4]) ** 2, axis=2)
    radius = np.sqrt(np.max(squares))
    depths = np.sqrt(radius**2 - squares[np.max(squares, axis=1) < 0.8 * radius**2]).mean(axis=1)
    assert len(depths) > 80
    assert np.min(np.diff(depths)) > -1e-9


# -- browsers -----------------------------------------------------------------------------------


SWITCHES = (
    *("--headless", "--no-sandbox", "--no-first-run", "--disable-sync", "--disable-quic"),
    *("--disable-background-networking", "--use-gl=angle", "--use-angle=swiftshader"),
    *("--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"),
)


@pytest.mark.slow
def test_a_browser_draws_it(tmp_path):
    """Body, path and hodographs are there, and nothing is wider than the window."""
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("no browser here")
    from PIL import Image

    page, shot = tmp_path / "x.html", tmp_path / "x.png"
    polhode.view(TOP).save(page)
    options = ["--virtual-time-budget=3000", f"--user-data-dir={tmp_path / 'profile'}"]
    options += ["--window-size=400,1300", f"--screenshot={shot}", "--dump-dom"]
    command = [browser, *SWITCHES, *options, f"{page.as_uri()}#t=9&play=0"]
    text = subprocess.run(command, capture_output=True, timeout=100).stdout.decode()
    r, g, b = np.moveaxis(np.array(Image.open(shot).convert("RGB")).astype(int), -1, 0)
    orange, blue = (r > 190) & (g < 130) & (b < 60), (b > 120) & (r < 60)
    assert orange.sum() > 1000
    assert blue.sum() > 3000
    assert "t = 9.000" in text
    assert '<p id="fault" hidden="">' in text


# -- What a page says of a motion: every regime has its words, and what they claim is so -----------


def said(scene, kind=None):
    scene = polhode.load(scene)
    top = polhode.reference(scene)
    return explained(kind or top.kind, top.regime, scene)


@pytest.mark.slow
def test_every_case_of_the_library_has_words_of_its_own_kind_and_all_words_are_used():
    used = set()
    for name in case_names():
        text = said(name)
        assert not text.startswith("A motion with a closed form"), f"{name}: explanations.toml"
        used.add(text)
    for body, omega in (([1, 1, 2], [1, 0, 0]), ([1, 1, 2], [0, 0, 1])):
        free = polhode.top(moments=body, weight=0, omega=omega, gamma=[0, 0, 1], end=1)
        used.add(said(free, "euler"))
    added = said("lagrange/looping", "mine")  # by a user
    assert added.startswith("A motion with a closed form (mine): looping")
    unused = {(kind, begins) for kind, begins, text in EXPLANATIONS if text not in used}
    assert {x for x in unused if x[1]} == {("lagrange", "spherical pendulum, conical")}


def upward(**changes):
    """A top whose weight pulls upward, or another one."""
    options = {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": -1, "omega": [0, 0, 1]}
    return polhode.top(**options | changes, gamma=[0, 0, 1], end=1)


@pytest.mark.parametrize(
    ("scene", "words", "absent"),
    tiers(
        [("grioli/precession", "same constant rate", "\n"), ("euler/largest-axis", "", "racket")],
        [
            ("euler/dzhanibekov", "tennis racket", "\n"),
            ("hess/general", "stays perpendicular", "\n"),
            (upward(), "opposite to the centre of mass", "\n"),
            (upward(moments=[2, "5/2", 3], weight="1/2"), "", "push"),  # undecided
        ],
    ),
)
def test_words_fit_the_scene(scene, words, absent):
    text = page_parts(polhode.view(scene, end="1/10").text)[0]["words"]
    assert words in text
    assert absent not in text


def angles(name, end):
    """theta, and psi' from the closed form, at even times."""
    times = [end * k / 100 for k in range(101)]
    rows = polhode.reference(name).angles(times, 15)
    psi, theta, _ = np.array([[float(x) for x in row] for row in rows]).T
    return theta, np.gradient(psi, times[1])


@pytest.mark.parametrize(
    ("name", "words", "rates"),
    [
        ("lagrange/looping", "makes loops", (-1, -1)),
        ("lagrange/nutation", "never changes its sense", (1, 1)),
        ("lagrange/spherical-pendulum", "always in the same sense", (1, 1)),
        ("lagrange/cusped", "stands still for a moment", (0, None)),
        ("lagrange/steady-slow", "without nutation", (None, 1)),
        ("lagrange/steady-fast", "without nutation", (None, 1)),
    ],
)
def test_precession_goes_the_way_that_is_said(name, words, rates):
    """The signs of psi' at the highest point by that at the lowest, and of its bounds."""
    assert words in polhode.view(name, end="1/10").text
    theta, rate = angles(name, 10)
    highest, lowest = (int(of(theta[5:-5])) + 5 for of in (np.argmin, np.argmax))
    at_ends, bounds = rates
    if at_ends is None:
        assert np.ptp(theta) < 1e-12
        assert np.ptp(rate) < 1e-9 * abs(rate[0])
        return
    assert theta[lowest] - theta[highest] > 0.1
    if at_ends == 0:
        assert abs(rate[highest]) < 0.05 * np.max(np.abs(rate))
        return
    assert np.sign(rate[highest] * rate[lowest]) == at_ends
    assert np.sign(np.min(rate) * np.max(rate)) == bounds


def test_a_page_says_it_and_does_not_deny_a_closed_form_where_an_enclosure_is_asked_for():
    assert "axis of the middle moment" in polhode.view("euler/dzhanibekov", end=30).text
    text = polhode.view(
        replace(polhode.load("lagrange/looping"), reference="certified"), end=4
    ).text
    assert "makes loops" in text
    assert "No closed form" not in text
