"""Levels of permanent rotations that lie close to each other, and the figure of their regions."""

from __future__ import annotations

import random
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from flint import arb

import polhode
from polhode.dynamics.levels import descents, effective_potential
from polhode.dynamics.levels.rotation_arcs import RationalBody
from polhode.numbers.flint_context import ctx
from polhode.scenes.body import Body

START = {"omega": ("0.3", "0.2", "1.1"), "gamma": ("3/5", 0, "4/5")}
NEAR = (2, "2.01", 1)


def found_of(moments, **start):
    body = Body.of_moments(moments, (1, 0, 0), 1)
    return polhode.levels(polhode.Scene(body, **(start or START)))


# -- critical points on the sphere, in plain numpy -------------------------------------------------


def counted(moments, f):
    """(W, gamma, Morse index) of the critical points of W_f with T = (1, 0, 0), by Newton's method.

    On W'(gamma) - mu gamma = 0, gamma.gamma = 1, from many starts at once.
    """
    a, push = np.array([float(Fraction(m)) for m in moments]), np.array([1.0, 0, 0])
    rng = np.random.default_rng(3)
    near = np.array([-1.0, 0, 0]) + 0.05 * rng.normal(size=(200, 3))
    g = np.concatenate([rng.normal(size=(600, 3)), near, np.eye(3), -np.eye(3)])
    g /= np.linalg.norm(g, axis=1)[:, None]

    def gradient(g):
        return push - (f / (a * g * g).sum(axis=1))[:, None] ** 2 * a * g

    def hessian(g):
        i = (a * g * g).sum(axis=1)[:, None, None]
        turned = (a * g)[:, :, None] * (a * g)[:, None, :]
        return 4 * f * f / i**3 * turned - f * f / i**2 * np.diag(a)

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
        if all(np.linalg.norm(place - other) > 1e-4 for _, other, _ in points):
            across = np.linalg.svd(place[None])[2][1:]
            second = across @ (hessian(place[None])[0] - multiplier * np.eye(3)) @ across.T
            value = f * f / (2 * (a * place * place).sum()) + push @ place
            points.append((value, place, int((np.linalg.eigvalsh(second) < 0).sum())))
    return sorted(points, key=lambda point: point[0])


@pytest.mark.parametrize(
    ("moments", "f"),
    [
        *((NEAR, f) for f in ("21", "20.001", "19.999")),
        *(((2, "2.001", 1), f) for f in ("21", "200.01", "199.99")),
        *(((2, "2.2", 1), "3"), ((2, "2.01", "1/50"), "1"), ((2, "2.01", "1/50"), "21")),
    ],
)
def test_regions_by_counting_critical_points(moments, f):
    """Their energies, and sum (2 - k) over the parts = minima - saddles + maxima below."""
    points = counted(moments, float(f))
    assert sum((-1) ** index for _, _, index in points) == 2  # none is missed
    regions = found_of(moments).regions(f)
    energies = []
    for value, _, _ in points:
        if not energies or value - energies[-1] > 1e-12 * abs(value):
            energies.append(value)
    assert [h for h, _ in regions] == pytest.approx(energies, rel=1e-14)
    for low, region in regions:
        below = [index for value, _, index in points if value <= low + 1e-13 * abs(low)]
        assert sum(2 - k for k in region) == sum((-1) ** index for index in below)
        if set(below) == {0}:
            assert len(region) == len(below)  # a disc about each minimum


@pytest.mark.parametrize("f", ["21", "20.001"])
def test_two_discs_join_over_the_saddle_between_them(f):
    """Along the circle gamma3 = 0 from one minimum to the other W_f is highest at (-1, 0, 0)."""
    points = counted(NEAR, float(f))
    (one, place, _), (_, other, _), (saddle, middle, index) = points[:3]
    assert index == 1
    assert np.allclose(middle, [-1, 0, 0], atol=1e-12)
    assert abs(place[2]) < 1e-12
    assert np.allclose(place * [1, -1, 1], other)
    angle = np.linspace(-1, 1, 2001) * np.arctan2(abs(place[1]), -place[0])
    along = float(f) ** 2 / (2 * (2 * np.cos(angle) ** 2 + 2.01 * np.sin(angle) ** 2))
    along -= np.cos(angle)
    assert along.max() <= saddle * (1 + 1e-15)
    regions = [region for _, region in found_of(NEAR).regions(f)]
    assert regions == [(1, 1), (1,), (2,), (0,)]
    assert saddle > one


@pytest.mark.parametrize("beside", [Fraction(1, 10**3), Fraction(1, 10**9), Fraction(1, 10**30)])
def test_regions_just_beside_and_at_a_branch(beside):
    """At f = 20 a second family leaves rest: below it one disc, above it two until they join."""
    found = found_of(NEAR)
    after = [(1,), (2,), (0,)]
    assert [region for _, region in found.regions(20 - beside)] == after
    assert [region for _, region in found.regions(20)] == after
    assert [region for _, region in found.regions(20 + beside)] == [(1, 1), *after]
    assert [h for h, _ in found.regions(20)] == pytest.approx([99, 101, 200.00125000781264])


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
    found = polhode.levels(scene)
    assert found.exact
    assert (found.here.h, found.here.f, found.here.region) == (117, 21, (2,))
    scene.write_text(scene.read_text().replace("h = 117", "h = 'sqrt(13690)'"))
    found = polhode.levels(scene)
    assert not found.exact
    assert found.here.region == (2,)


# -- what proves a descent -------------------------------------------------------------------------


def test_derivatives_along_a_great_circle_and_their_bounds():
    """At 50 digits, beside Taylor's coefficients of mpmath; the bounds hold and are not slack."""
    rng = random.Random(5)
    nearest = [0.0, 0.0]
    for k in range(80):  # a nearly spherical free body comes close to the bounds
        apart, heavy = (40, 1) if k % 2 else (4000, 0)
        moments = [1 + Fraction(rng.randint(-20, 30), apart) for _ in range(3)]
        if k % 3 == 0:
            moments[0] /= 100
        torque = tuple(heavy * Fraction(rng.randint(-30, 30), 30) for _ in range(3))
        f = Fraction(rng.randint(1, 60), 20)
        with mpmath.workdps(60), ctx.workprec(220):
            g, u = frame(rng)
            body = RationalBody(tuple(moments), torque, True)
            known = descents.Potential.of(body, f)
            of = [tuple(arb(str(x)) for x in vector) for vector in (g, u)]
            a, t = ([mpmath.mpf(x.numerator) / x.denominator for x in y] for y in (moments, torque))

            half = mpmath.mpf(f.numerator) ** 2 / f.denominator**2 / 2

            def along(angle, a=a, t=t, g=g, u=u, half=half):
                cos, sin = mpmath.cos(angle), mpmath.sin(angle)
                at = [cos * x + sin * y for x, y in zip(g, u, strict=True)]
                inertia = sum(m * x * x for m, x in zip(a, at, strict=True))
                return half / inertia + sum(x * y for x, y in zip(t, at, strict=True))

            right = [mpmath.factorial(k) * c for k, c in enumerate(mpmath.taylor(along, 0, 4))]
            for got, expected in zip(known.derivatives(*of), right[1:4], strict=True):
                assert abs(float(got - arb(str(expected)))) < 1e-45
            least = known.least_inertia(*of, arb(0))  # here
            assert float(least) == pytest.approx(
                float(sum(m * x * x for m, x in zip(a, g, strict=True)))
            )
            for which, bound in enumerate(known.bounds(least)):
                ratio = float(abs(arb(str(right[2 * which + 2]))) / bound)
                assert ratio <= 1
                nearest[which] = max(nearest[which], ratio)
    assert min(nearest) > 0.75


def frame(rng):
    """Two unit vectors at right angles, in mpmath's precision."""
    g, u = (mpmath.matrix([rng.gauss(0, 1) for _ in range(3)]) for _ in range(2))
    g /= mpmath.norm(g)
    u -= (g.T * u)[0] * g
    return list(g), list(u / mpmath.norm(u))


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


def drawn(found):
    plt = pytest.importorskip("matplotlib.pyplot")
    from polhode.figures import levels as figure

    made = figure.draw(plt, figure.Diagram(found, figure.Window(F, H)))
    plt.close(made)
    return made


@pytest.mark.slow
def test_the_figure_shows_the_regions_of_close_rotations():
    found = found_of(NEAR)
    assert all(column.regions for column in found.columns(*F, 41))
    axes = drawn(found).axes[0]
    assert {place: shades_at(axes, place) for place in PLACES} == PLACES


@pytest.mark.slow
def test_an_undecided_column_is_hatched(monkeypatch):
    """It is not filled with a neighbour's colour."""
    decided = effective_potential.regions_between

    def partly(body, arcs, f, known=None):
        if Fraction("20.5") < f < Fraction("21.5"):
            raise descents.Undecided("for a test")
        return decided(body, arcs, f, known)

    monkeypatch.setattr(effective_potential, "regions_between", partly)
    found = found_of(NEAR)
    axes = drawn(found).axes[0]
    assert [shades_at(axes, place) for place in PLACES] == [{"not decided"}] * 4
    assert shades_at(axes, (20.4, 250.0)) == {"RP³"}
    assert shades_at(axes, (21.6, 150.0)) == {"S²×S¹"}
    with pytest.raises(polhode.BadInput, match="the regions are decided"):
        found.regions(21)
