"""Chaos maps: verdicts on integrable tops, against lyapunov, and the same everywhere."""

import json
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from polhode.dynamics import chaos_map
from polhode.dynamics.level_body import LevelBody, tangents_of
from shared.tools import tiers

GENERIC = polhode.load("general/asymmetric-chaotic")
LEVEL = {"h": 3, "f": Fraction(1, 2)}


@pytest.mark.parametrize(
    "case", tiers(["euler/attitude"], ["lagrange/nutation", "kovalevskaya/generic"])
)
def test_no_motion_of_an_integrable_top_is_chaotic(case):
    level = {"h": 3, "f": 0 if case.startswith("g") else Fraction(6, 5)}
    chart = polhode.chaos_map(case, (8, 8), **level)
    assert chart.counts["chaotic"] == 0
    assert chart.counts["regular"] > 0.9 * len(chart.verdict)
    assert 0.5 < chart.growth.max() < 4.5  # a tangent grows like a power of time


def growing_motions_that_are_known_are_unstable_and_others_chaotic():
    """So lyapunov calls them, too: on a separatrix, and a sleeping top that spins too slowly."""
    sleeping = polhode.load("lagrange/sleeping-unstable")
    varied = {"start.omega[3]": ["1/100", "1/10", 1000]}
    chart = polhode.chaos_map(sleeping, vary=varied, end=2000)
    assert chart.shape == (3,)
    assert chart.column("verdict")[:2] == ["unstable", "unstable"]
    assert chart.counts["chaotic"] == 0
    assert polhode.lyapunov(sleeping).verdict == "unstable"
    still = {"omega": [1, 0, 0], "gamma": [1, 0, 0], "moments": ["3/2", 2, 1]}  # Staude's, unstable
    scene = polhode.top(**still, centre=["-1/10", 0, 0], weight=1)
    chart = polhode.chaos_map(scene, vary={"start.omega[1]": [1, "9/8"]}, end=1000)
    assert chart.counts == {"regular": 0, "undecided": 0, "chaotic": 0, "unstable": 2}
    chart = polhode.chaos_map(GENERIC, (4, 4), end=1000, **LEVEL)
    assert chart.counts["chaotic"] > 6
    assert chart.counts["unstable"] == 0


def test_own_starts_are_the_motions_that_a_grid_has(tmp_path):
    """From an array, a file, and as numbers that vary to the bit; gamma is made a unit vector."""
    grid = polhode.chaos_map(GENERIC, (4, 3), end=50, **LEVEL)
    cut = polhode.section(GENERIC, grid=(4, 3), crossings=1, **LEVEL)
    rows, path = cut.start_states, tmp_path / "starts.csv"
    path.write_text("\n".join(",".join(map(repr, row)) for row in rows.tolist()))
    keys = [f"start.{name}[{k}]" for name in ("omega", "gamma") for k in (1, 2, 3)]
    varied = dict(zip(keys, np.split(rows, 6, axis=1), strict=True))
    maps = [
        polhode.chaos_map(GENERIC, end=50, **options)
        for options in ({"starts": rows}, {"starts": path}, {"vary": varied})
    ]
    for own in maps:
        assert own.keys == tuple(keys)
        assert own.shape == (len(rows),)
        assert (own.at == rows).all()
        assert (own.growth == maps[0].growth).all()
    off = np.abs(maps[0].growth - grid.growth)
    assert 0 < off.max() < 1e-9


def test_bodies_vary_beside_own_starts_and_a_wrong_row_is_named():
    rows = [[1.0, 0.5, 2.0, 0.6, 0.0, 0.8]] * 2
    chart = polhode.chaos_map(
        GENERIC, starts=rows, vary={"body.weight": np.array([1.0, 3.0])}, end=50
    )
    assert chart.growth[0] != chart.growth[1]
    for options, words in (
        ({"starts": rows, "grid": (2, 2)}, "no grid"),
        ({"starts": rows, "by": "height"}, "no grid"),
        ({"starts": [[1.0, 0.5, 2.0]]}, r"shape \(N, 6\)"),
        ({"starts": [rows[0], [1.0, 0.5, 2.0, 0.6, 0.1, 0.8]]}, "member 2|row 2"),
        ({"starts": "missing.csv"}, "missing.csv"),
        ({"starts": np.empty((0, 6))}, "at least one start"),
    ):
        with pytest.raises(polhode.BadInput, match=words):
            polhode.chaos_map(GENERIC, end=10, **options)


@pytest.mark.slow
def test_own_starts_are_drawn_as_dots(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    starts, figure = tmp_path / "s.csv", tmp_path / "m.svg"
    starts.write_text("1,0.5,2,0.6,0,0.8\n0.1,0,3,0,0.6,0.8\n")
    command = ["map", "general/asymmetric-chaotic", "--starts", str(starts), "--end", "50"]
    for quantity in ("exponent", "verdict"):
        assert main([*command, "--what", quantity, "-o", str(figure)]) == 0
        assert "start.omega[2]" in figure.read_text()
    capsys.readouterr()
    assert main([*command, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["grid"] == [2]
    assert len(printed["columns"]["exponent"]) == 2


def test_megno_of_made_up_growth():
    """ln|u| = c t has MEGNO c T/2 + ...: Y = c t exactly, its mean c T/2; ln(1 + t) tends to 2."""
    looks, length = 4096, 1e4
    t = np.linspace(0, length, looks + 1)
    sizes = np.array([0.01 * t, np.log1p(t)])
    judged = chaos_map._judged(sizes, np.array([looks, looks]), length)
    assert judged["megno"][0] == pytest.approx(0.01 * length / 2, rel=1e-12)
    assert 1.9 < judged["megno"][1] < 2.0
    assert judged["growth"][0] == pytest.approx(50, rel=1e-12)
    assert judged["growth"][1] == pytest.approx(np.log(2), rel=1e-3)
    assert judged["exponent"][0] == pytest.approx(0.01, rel=1e-12)
    assert judged["verdict"].tolist() == [2, 0]


def test_tangents_begin_across_what_never_grows_apart():
    from polhode.dynamics import starts as geometry

    on = LevelBody(GENERIC, Fraction(3), Fraction(1, 2))
    states = geometry.momentum_states(on, *geometry.cell_centres(5, 5), True).states
    many = (len(states), 1)
    u = tangents_of(states, np.tile(on.moments, many), np.tile(on.torque, many))
    step = 1e-6
    ahead, behind = states + step * u, states - step * u

    def integrals(x):
        w, g = x[:, :3], x[:, 3:]
        G = w * on.moments
        return np.array([(w * G).sum(1) / 2 + g @ on.torque, (g * G).sum(1), (g * g).sum(1)])

    assert np.abs(integrals(ahead) - integrals(behind)).max() / (2 * step) < 1e-8
    assert np.abs((u * u).sum(axis=1) - 1).max() < 1e-14


def test_nothing_is_called_regular_early_and_a_chaotic_motion_is_left_early():
    chart = polhode.chaos_map(GENERIC, (6, 6), end=500, **LEVEL)
    assert chart.counts["regular"] == 0
    assert chart.counts["chaotic"] > 5
    chart = polhode.chaos_map(GENERIC, (6, 6), end=2000, **LEVEL)
    early = chart.until < 2000
    assert early.sum() > 5
    assert (chart.verdict[early] == 2).all()
    assert set(chart.until) <= {250.0, 500.0, 1000.0, 2000.0}


@pytest.mark.slow
@pytest.mark.usefixtures("parts_at_once")
def test_the_same_in_any_company_and_after_a_stop(tmp_path):
    """Bit for bit, whatever the neighbours: bodies of two weights in turn, one of them another."""
    options = {"end": 200, "vary": {"start.omega[3]": "0.5:3:21", "body.weight": [1, "5/4"]}}
    plain = polhode.chaos_map(GENERIC, **options)
    assert plain.shape == (21, 2)
    options["vary"]["body.weight"] = [1, 2]
    joint = polhode.chaos_map(GENERIC, **options)
    for alone, again in ((plain.growth, joint.growth), (plain.fli, joint.fli)):
        assert (alone[::2] == again[::2]).all()
        assert (alone[1::2] != again[1::2]).all()
    options["vary"] = {"start.omega[3]": "0.5:3:40", "start.omega[1]": "0.1:1:8"}
    plain, folder = polhode.chaos_map(GENERIC, **options), tmp_path / "m.part"
    polhode.chaos_map(GENERIC, parts=folder, **options)
    jobs = sorted(folder.glob("job-*.npz"))
    assert len(jobs) == 2
    jobs[1].unlink()
    again = polhode.chaos_map(GENERIC, parts=folder, workers=1, **options)
    assert (again.growth == plain.growth).all()
    assert (again.fli == plain.fli).all()


#: Starts, grid, until when their verdicts are known; motions, undecided or calm ones at most.
KNOWN = [
    pytest.param("height", "max", (8, 6), 4000, 40, 6, marks=pytest.mark.slow),
    # at T = 1000 some chaotic ones still stick to islands
]


@pytest.mark.parametrize(("by", "extremum", "grid", "until", "motions", "most"), KNOWN)
def test_verdicts_of_known_motions(by, extremum, grid, until, motions, most):
    """At T = 1000, beside those far later."""
    options = {"grid": grid, "by": by, "extremum": extremum, **LEVEL}
    precise = polhode.chaos_map(GENERIC, end=until, tol=1e-8, **options).verdict
    chart = polhode.chaos_map(GENERIC, end=1000, **options).verdict
    assert len(chart) > motions
    assert not ((chart == 2) & (precise == 0)).any()
    assert ((chart == 0) & (precise == 2)).sum() + ((chart == 1) & (precise != 1)).sum() <= most


def test_an_end_that_is_too_short_to_decide_is_named(capsys):
    """In the scene's own time: a body in other units has another least end."""
    scene = "general/asymmetric-regular"
    assert main(["map", scene, "--grid", "2x2", "--end", "20", "--json"]) == 0
    output = capsys.readouterr()
    printed = json.loads(output.out)
    least = 1000 * 2.0 ** polhode.load(scene).time_unit
    assert printed["least_end"] == least
    assert printed["counts"]["undecided"] == 4
    assert printed["meaning"] in output.err
    assert f"t = 20 is too short, none is called regular before t = {least:g}" in output.err


def test_the_least_end_decides_and_needs_no_note():
    slow = polhode.top(
        moments=[100, 100, 100],
        centre=[0, 0, 1],
        weight="1/100",
        omega=["1/100", 0, "1/50"],
        gamma=["3/5", 0, "4/5"],
        end=1,
    )
    least = polhode.chaos_map(slow, (2, 1), end=1).enough
    assert least > 4000
    chart = polhode.chaos_map(slow, (2, 1), end=least)
    assert not chart.too_short
    assert chart.counts["regular"] == len(chart.verdict)
    assert "too short" not in chart.meaning
    assert polhode.chaos_map(slow, (2, 1), end=least * 0.999).counts["regular"] == 0
