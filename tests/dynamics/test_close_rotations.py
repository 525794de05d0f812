"""Levels of permanent rotations that lie close to each other, and the figure of their regions."""

from fractions import Fraction

import numpy as np
import pytest
from flint import arb

import polhode
from polhode import Body
from polhode.dynamics import exact_levels
from polhode.dynamics.exact_levels import RationalBody
from polhode.numbers.flint_context import ctx
from shared.tools import tiers

START = {"omega": ("0.3", "0.2", "1.1"), "gamma": ("3/5", 0, "4/5")}
NEAR = (2, "2.01", 1)


def found_of(moments, centre=(1, 0, 0), **start):
    body = Body.of_moments(moments, centre, 1)
    return polhode.levels(polhode.Scene(body, **(start or START)))


# -- critical points on the sphere, in plain numpy -------------------------------------------------


def counted(moments, f, torque=(1, 0, 0)):
    """(W, gamma, Morse index) of the critical points of W_f by Newton's method.

    On W'(gamma) - mu gamma = 0, gamma.gamma = 1, from many starts at once.
    """
    a, push = (np.array([float(Fraction(x)) for x in v]) for v in (moments, torque))
    rng = np.random.default_rng(3)
    near = np.array([-1.0, 0, 0]) + 0.05 * rng.normal(size=(200, 3))
    g = np.concatenate([rng.normal(size=(600, 3)), near, np.eye(3), -np.eye(3)])
    g /= np.linalg.norm(g, axis=1)[:, None]

    def gradient(g):
        return push - (f / (a * g * g).sum(axis=1))[:, None] ** 2 * a * g

    def hessian(g):
        i = (a * g * g).sum(axis=1)[:, None, None]
        rotated = (a * g)[:, :, None] * (a * g)[:, None, :]
        return 4 * f * f / i**3 * rotated - f * f / i**2 * np.diag(a)

    mu = (gradient(g) * g).sum(axis=1)
    for _ in range(60):
        matrix = np.zeros((len(g), 4, 4))
        matrix[:, :3, :3] = hessian(g) - mu[:, None, None] * np.eye(3)
        matrix[:, :3, 3], matrix[:, 3, :3] = -g, 2 * g
        right = np.column_stack([gradient(g) - mu[:, None] * g, (g * g).sum(axis=1) - 1])
        regular = np.abs(np.linalg.det(matrix)) > 1e-300
        step = np.zeros((len(g), 4))
        step[regular] = np.linalg.solve(matrix[regular], right[regular, :, None])[..., 0]
        length = np.maximum(np.linalg.norm(step[:, :3], axis=1), 1e-300)
        step *= np.minimum(1, 0.2 / length)[:, None]
        g, mu = g - step[:, :3], mu - step[:, 3]
    small = np.linalg.norm(gradient(g) - mu[:, None] * g, axis=1) < 1e-9
    small &= np.abs(np.linalg.norm(g, axis=1) - 1) < 1e-12
    points = []
    for place, multiplier in zip(g[small], mu[small], strict=True):
        if all(np.linalg.norm(place - place_before) > 1e-4 for _, place_before, _ in points):
            across = np.linalg.svd(place[None])[2][1:]
            second = across @ (hessian(place[None])[0] - multiplier * np.eye(3)) @ across.T
            value = f * f / (2 * (a * place * place).sum()) + push @ place
            points.append((value, place, int((np.linalg.eigvalsh(second) < 0).sum())))
    return sorted(points, key=lambda point: point[0])


@pytest.mark.parametrize(
    ("moments", "f", "torque"),
    tiers(
        [
            *(
                ((2, m, 1), f, (1, 0, 0))
                for m, f in (("2.01", "21"), ("2.001", "21"), ("2.2", "3"))
            ),
            ((2, "3/2", 1), "1", ("3/10", "1/5", "1/2")),
            ((2, "3/2", "6/5"), "3", (0, 1, 0)),
        ],
        [
            *(((2, "2.01", 1), f, (1, 0, 0)) for f in ("20.001", "19.999")),
            *(((2, "2.001", 1), f, (1, 0, 0)) for f in ("200.01", "199.99")),
            *(((2, "2.01", "1/50"), f, (1, 0, 0)) for f in ("1", "21")),
            ((2, "3/2", 1), "19/10", ("3/10", "1/5", "1/2")),
        ],
    ),
)
def test_regions_by_counting_critical_points(moments, f, torque):
    """Their energies, and sum (2 - k) over the parts = minima - saddles + maxima below."""
    points = counted(moments, float(Fraction(f)), torque)
    assert sum((-1) ** index for _, _, index in points) == 2  # none is missed
    result = found_of(moments, torque).regions(f)
    energies = []
    for value, _, _ in points:
        if not energies or value - energies[-1] > 1e-12 * abs(value):
            energies.append(value)
    assert [h for h, _ in result] == pytest.approx(energies, rel=1e-14)
    for low, region in result:
        below = [index for value, _, index in points if value <= low + 1e-13 * abs(low)]
        assert sum(2 - k for k in region) == sum((-1) ** index for index in below)
        if set(below) == {0}:
            assert len(region) == len(below)  # a disc about each minimum


@pytest.mark.parametrize("f", ["21", "20.001"])
def test_two_discs_join_over_the_saddle_between_them(f):
    """Along the circle gamma3 = 0 from one minimum to the other W_f is highest at (-1, 0, 0)."""
    points = counted(NEAR, float(f))
    (first, place, _), (_, second, _), (saddle, between, index) = points[:3]
    assert index == 1
    assert np.allclose(between, [-1, 0, 0], atol=1e-12)
    assert abs(place[2]) < 1e-12
    assert np.allclose(place * [1, -1, 1], second)
    angle = np.linspace(-1, 1, 2001) * np.arctan2(abs(place[1]), -place[0])
    along = float(f) ** 2 / (2 * (2 * np.cos(angle) ** 2 + 2.01 * np.sin(angle) ** 2))
    along -= np.cos(angle)
    assert along.max() <= saddle * (1 + 1e-15)
    assert [region for _, region in found_of(NEAR).regions(f)] == [(1, 1), (1,), (2,), (0,)]
    assert saddle > first


@pytest.mark.parametrize("beside", [Fraction(1, 10**3), Fraction(1, 10**9), Fraction(1, 10**30)])
def test_regions_just_beside_and_at_a_branch(beside):
    """At f = 20 a second family leaves rest: below it one disc, above it two until they join."""
    result = found_of(NEAR)
    after = [(1,), (2,), (0,)]
    assert [region for _, region in result.regions(20 - beside)] == after
    assert [region for _, region in result.regions(20)] == after
    assert [region for _, region in result.regions(20 + beside)] == [(1, 1), *after]
    assert [h for h, _ in result.regions(20)] == pytest.approx([99, 101, 200.00125000781264])


def test_a_level_at_the_f_of_a_branch_is_decided():
    start = {"omega": (10, 0, 0), "gamma": (1, 0, 0)}  # f = 20, h = 101: a saddle
    assert found_of(NEAR, **start).here.region is None
    start = {"omega": (10, 0, 0.001), "gamma": (1, 0, 0)}
    here = found_of(NEAR, **start).here
    assert (here.f, here.region, here.remark) == (20, (2,), "")


def test_a_rational_level_is_called_so(tmp_path, capsys):
    """omega of a start on a level is irrational, h and f are not."""
    scene = tmp_path / "near.toml"
    scene.write_text(
        "schema = 1\ntitle = 'near'\n[body]\nmoments = [2, 2.01, 1]\ncentre = [1, 0, 0]\n"
        "weight = 1\n[start]\nh = 117\nf = 21\ngamma = [0, 1, 0]\n[run]\nend = 1\nsamples = 2\n"
    )
    diagram = polhode.levels(scene)
    assert diagram.exact
    assert (diagram.here.h, diagram.here.f, diagram.here.region) == (117, 21, (2,))
    scene.write_text(scene.read_text().replace("h = 117", "h = 'sqrt(13690)'"))
    diagram = polhode.levels(scene)
    assert not diagram.exact
    assert diagram.here.region == (2,)


# -- which minima are joined -----------------------------------------------------------------------


@pytest.mark.slow
def test_an_arc_lies_below_an_energy_above_all_of_its_own_and_below_no_lower_one():
    """W_f along 300 arcs between random points, from 2001 samples; h beside the largest of them."""
    rng = np.random.default_rng(11)
    part = np.linspace(0, 1, 2001)[:, None]
    inner = 0
    for _ in range(300):
        moments, torque = rng.integers(2, 60, 3) / 20, rng.integers(-30, 30, 3) / 10
        f = int(rng.integers(1, 40)) / 10
        body = RationalBody(*(tuple(map(Fraction, x.tolist())) for x in (moments, torque)), True)
        ends = rng.normal(size=(2, 3))
        ends /= np.linalg.norm(ends, axis=1)[:, None]
        angle = np.arccos(ends[0] @ ends[1])
        g = (np.sin((1 - part) * angle) * ends[0] + np.sin(part * angle) * ends[1]) / np.sin(angle)
        along = f * f / (2 * (moments * g * g).sum(axis=1)) + g @ torque
        most = int(np.argmax(along))
        inner += 0 < most < 2000
        with ctx.workprec(128):
            first, second = (
                exact_levels.Critical(tuple(arb(x) for x in end), arb(value), 0)
                for end, value in ((ends[0].tolist(), along[0]), (ends[1].tolist(), along[-1]))
            )
            for off in (1e-5, -1e-5):
                h = Fraction(float(along[most] + off * (1 + along.max() - along.min())))
                assert exact_levels.arc_below(body, h, Fraction(f), first, second) == (off > 0)
    assert inner > 60  # its largest energy is not always at an end


def test_minima_are_joined_only_over_a_saddle_whose_arcs_are_below():
    """Two minima and a saddle below two maxima and a saddle: one disc, or an annulus and a disc."""
    moments, torque = ((Fraction(x) for x in v) for v in ((2, "2.01", 1), (1, 0, 0)))
    body = RationalBody(tuple(moments), tuple(torque), True)
    at = exact_levels.critical_points(body, Fraction(21))
    assert [point.morse for point in at.points] == [0, 0, 1, 1, 2, 2]
    assert exact_levels.parts(body, at, 3) == (1,)
    low, second, saddle, *above = at.points
    elsewhere = saddle._replace(gamma=above[-1].gamma)  # arcs from there come down from above
    false = at._replace(points=[low, second, elsewhere, *above])
    with pytest.raises(exact_levels.Undecided, match="parts is not known"):
        exact_levels.parts(body, false, 3)
    one_maximum = at._replace(points=[low, second, elsewhere, above[-1]])
    # what is left is one disc: no arc is asked
    assert exact_levels.parts(body, one_maximum, 3) == (1,)


@pytest.mark.parametrize("unit", [Fraction(1), Fraction(2) ** 900])
def test_two_discs_join_by_a_chain_where_no_arc_lies_below(unit):
    """Two saddles, nearly mirror images: from the lower one no arc leads down to a minimum."""
    moments, centre = (
        [Fraction(x) * unit for x in v] for v in (("2", "0.7", "1.6"), ("0.8", "0.4", "1e-6"))
    )
    regions = found_of(moments, centre).regions(Fraction("2.8585818648") * unit)
    assert [region for _, region in regions] == [(1,), (1, 1), (1,), (2,), (1,), (0,)]


# -- the figure ------------------------------------------------------------------------------------

F, H = (15.0, 25.0), (80.0, 300.0)
PLACES = {
    (21.0, 250.0): {"RP³"},
    (21.0, 150.0): {"S²×S¹"},
    (21.0, 110.4): {"S³"},
    (21.0, 100.0): set(),
}


def shades_at(axes, place):
    """The names in the legend of what is filled at a point."""
    named = {}
    for patch in axes.patches:
        key = patch.get_hatch() or tuple(patch.get_facecolor())
        named[key] = patch.get_label()
    return {
        named[filled.get_hatch() or tuple(filled.get_facecolor()[0])]
        for filled in axes.collections
        if any(path.contains_point(place) for path in filled.get_paths())
    }


@pytest.mark.slow
def test_the_figure_shows_the_regions_of_close_rotations():
    result = found_of(NEAR)
    assert all(column.regions for column in result.columns(*F, 41))
    pytest.importorskip("matplotlib")
    axes = result.plot(f_range=F, h_range=H)
    assert {place: shades_at(axes, place) for place in PLACES} == PLACES


@pytest.mark.slow
def test_an_undecided_column_is_hatched(monkeypatch):
    """It is not filled with a neighbour's colour."""
    decided = exact_levels.regions_between

    def partly(body, f):
        if Fraction("20.5") < f < Fraction("21.5"):
            raise exact_levels.Undecided("for a test")
        return decided(body, f)

    monkeypatch.setattr(exact_levels, "regions_between", partly)
    result = found_of(NEAR)
    axes = result.plot(f_range=F, h_range=H)
    assert [shades_at(axes, place) for place in PLACES] == [{"not decided"}] * 4
    assert shades_at(axes, (20.4, 250.0)) == {"RP³"}
    assert shades_at(axes, (21.6, 150.0)) == {"S²×S¹"}
    with pytest.raises(polhode.BadInput, match="the regions are decided"):
        result.regions(21)
