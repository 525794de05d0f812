"""Families of periodic orbits and the search of a level."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import polhode
from polhode.cli import main

#: Where Grioli's family turns in h at his f, by this program: the tests say how it is one.
FOLD = 0.74971327932623


@pytest.fixture(scope="module")
def family():
    """Grioli's orbit towards smaller h, through a branch point and a fold, and back."""
    return polhode.orbit_family("grioli/precession", "h", "0.7", points=60)


@pytest.mark.slow
def test_a_family_passes_its_fold(family):
    assert family.ended == "came back to h = 63/74"
    assert [mark.what for mark in family.bifurcations] == ["branch point", "fold"]
    fold = family.bifurcations[-1].point
    assert fold.h == min(fold.h, *(point.h for point in family.points))
    assert abs(fold.residue) < 1e-11
    assert fold.h == pytest.approx(FOLD, abs=1e-12)
    for point in family.points:
        assert point.f == pytest.approx(836 / 1369, rel=1e-13)
        assert point.h >= fold.h
    first, last = family.points[0], family.points[-1]
    assert first.h == pytest.approx(last.h, rel=1e-14)
    assert abs(first.period - last.period) > 0.1  # another orbit of the same level


@pytest.mark.slow
def test_two_orbits_on_this_side_of_a_fold_and_none_on_the_other(family):
    fold = family.bifurcations[-1]
    above = family.points[fold.after - 1], family.points[fold.after]
    assert above[0].residue * above[1].residue < 0
    assert {point.kind for point in above} == {"elliptic", "hyperbolic"}
    near = family.orbit(fold.after, digits=20)
    assert near.kind == above[1].kind
    assert float(near.residue) == pytest.approx(above[1].residue, rel=1e-9)
    with pytest.raises(polhode.BadInput, match="start nearer to a periodic orbit"):
        polhode.orbit(near.scene, h=FOLD - 0.001, period=near.period)


@pytest.mark.slow
def test_rotations_of_a_free_body_are_a_family_with_one_residue():
    """T = 2 pi/w with h = A w^2/2 at every point; R = sin^2(pi sqrt((A-B)(A-C)/(BC)))."""
    spun = polhode.top(moments=[2, 1.5, 1], omega=[1, 0, 0], gamma=["4/5", "3/5", 0])
    family = polhode.orbit_family(spun, "h", 3)
    exact = math.sin(math.pi * math.sqrt(1 / 3)) ** 2
    assert len(family.points) > 5
    for point in family.points:
        assert point.period == pytest.approx(2 * math.pi / math.sqrt(point.h), rel=1e-12)
        assert point.residue == pytest.approx(exact, abs=1e-12)
    assert family.points[-1].h == pytest.approx(3, rel=1e-15)
    assert not family.bifurcations


def test_a_period_doubles_where_the_residue_passes_one():
    """Beside it there is an orbit of twice the period, of a residue near zero."""
    family = polhode.orbit_family("grioli/precession", "h", "1.19")
    assert [point.what for point in family.bifurcations] == ["period doubling"]
    first = family.bifurcations[0].point
    assert first.residue == pytest.approx(1, abs=1e-11)
    assert family.points[-1].kind == "inverse hyperbolic"
    # at R = 1 + d, the same orbit taken twice has R2 = 4 R (1 - R) = -4 d + ...
    last = family.points[-1]
    twice = 4 * last.residue * (1 - last.residue)
    matrix = family.members[-1].orbit.monodromy
    assert (6 - np.trace(matrix @ matrix)) / 4 == pytest.approx(twice, rel=1e-9)


def test_along_f_too():
    family = polhode.orbit_family("grioli/precession", "f", "0.66", points=20)
    assert family.by == "f"
    assert "fold" in [point.what for point in family.bifurcations]
    assert {round(point.h, 12) for point in family.points} == {round(63 / 74, 12)}


def test_ctrl_c_keeps_what_is_done():
    def stop(text):
        if text.startswith("4 orbits"):
            raise KeyboardInterrupt

    family = polhode.orbit_family("grioli/precession", "h", "0.7", progress=stop)
    assert family.interrupted
    assert not family.complete
    assert len(family.points) == 4
    assert family.orbit(3).kind == "elliptic"


def test_a_search_finds_orbits_that_close(monkeypatch):
    search = polhode.orbit_search("general/asymmetric-regular", (10, 10), crossings=2)
    assert len(search.orbits) >= 5
    scene = search.scene
    for point in search.orbits:
        assert point.h == pytest.approx(float(scene.integrals.energy), rel=1e-13)
        there = polhode.Scene(
            scene.body, point.state[:3], point.state[3:], times=(point.period,), normalise=True
        )
        run = polhode.integrate(there)
        assert np.max(np.abs(run.states[0] - point.state)) < 1e-10
    pairs = {(round(point.period, 8), round(point.residue, 8)) for point in search.orbits}
    assert len(pairs) == len(search.orbits)  # of this body no two are alike
    kinds = {point.kind for point in search.orbits}
    assert kinds == {"elliptic", "hyperbolic"}  # islands have both (Poincare, Birkhoff)


@pytest.mark.slow
def test_the_verb(tmp_path, capsys):
    figure, arrays = tmp_path / "family.svg", tmp_path / "family.npz"
    command = ["family", "grioli/precession", "--by", "h", "--to", "0.84"]
    assert main([*command, "-o", str(arrays)]) == 0
    file = np.load(arrays)
    assert file["p"].shape == file["h"].shape
    assert main(command) == 0
    assert capsys.readouterr().out.split()[:6] == ["orbit", "h", "f", "period", "residue", "kind"]
    assert main([*command, "-o", str(figure)]) == 0
    assert "family residue" in figure.read_text()
    capsys.readouterr()
    assert main([*command, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["ended"] == "reached h = 21/25"
    assert printed["columns"]["h"][-1] == pytest.approx(0.84, rel=1e-15)
    case = "general/asymmetric-regular"
    assert main(["orbits", case, "--grid", "8x8", "--crossings", "1", "--json"]) == 0
    orbits = json.loads(capsys.readouterr().out)["columns"]
    search = ["orbits", case, "--grid", "8x8", "--crossings", "1"]
    assert main([*search, "--pick", "2", "--digits", "20", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert float(first["period"]) == pytest.approx(orbits["period"][1], rel=1e-13)
    assert len(first["period"].replace(".", "")) == 22
    assert main([*search, "--pick", "9"]) == 2
    assert "expected a number to 3" in capsys.readouterr().err


def test_a_family_that_cannot_be_followed_ends_with_code_3(monkeypatch, capsys):
    from polhode.dynamics import newton_shooting

    def lost(*_):
        raise newton_shooting.NotClosed("no step is short enough")

    monkeypatch.setattr(newton_shooting, "stepped", lost)
    assert main(["family", "grioli/precession", "--by", "h", "--to", "0.9"]) == 3
    assert "not followed beyond h = 0.851351" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "meant"),
    [(lambda family: family.points[0], "the orbit of point k of a family or a search is")],
)
def test_a_point_given_as_a_start_is_told_which_call_makes_an_orbit_of_it(options, meant):
    family = polhode.orbit_family("grioli/precession", "h", "0.76")
    for call in (polhode.orbit, lambda x: polhode.orbit_family(x, "h", 1), polhode.integrate):
        with pytest.raises(polhode.BadInput) as refusal:
            call(options(family))
        assert meant in str(refusal.value)
        assert "\n" not in str(refusal.value)
    first = polhode.orbit_family(family.orbit(0), "h", "0.752")
    assert first.points[0].period == pytest.approx(family.points[0].period, rel=1e-12)


def test_a_result_given_as_a_scene_is_told_what_was_meant():
    run = polhode.integrate("euler/sphere", at=[1])
    with pytest.raises(polhode.BadInput, match=r"did you mean its \.scene\?"):
        polhode.integrate(run)
