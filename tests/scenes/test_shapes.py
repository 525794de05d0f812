"""Bodies by shape: moments against integrals over the solid, Steiner, parts put together."""

from fractions import Fraction

import numpy as np
import pytest

import polhode

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
ROUND = np.arange(8) * np.pi / 4  # trapezoidal: exact for the trigonometric polynomials met here
EPS = np.finfo(float).eps


def on(a, b):
    """Gauss–Legendre points and weights from a to b."""
    return (a + b) / 2 + (b - a) / 2 * NODES, (b - a) / 2 * WEIGHTS


def box(size):
    x, y, z = (on(-s / 2, s / 2) for s in size)
    return [
        ((a, b, c), u * v * w)
        for a, u in zip(*x, strict=True)
        for b, v in zip(*y, strict=True)
        for c, w in zip(*z, strict=True)
    ]


def solid_of_revolution(inner, outer, low, high):
    """A solid of revolution about z: radii and heights, the radii functions of z."""
    return [
        ((r * np.cos(p), r * np.sin(p), z), u * v * r)
        for z, u in zip(*on(low, high), strict=True)
        for r, v in zip(*on(inner(z), outer(z)), strict=True)
        for p in ROUND
    ]


def ball(semi_axes, inner=0.0):
    """An ellipsoid, or a hollow sphere of outer radius 1 scaled: spherical shells."""
    a, b, c = semi_axes
    return [
        ((a * r * s * np.cos(p), b * r * s * np.sin(p), c * r * z), u * v * r * r)
        for r, u in zip(*on(inner, 1.0), strict=True)
        for z, v in zip(*on(-1.0, 1.0), strict=True)
        for s in [np.sqrt(1 - z * z)]
        for p in ROUND
    ]


SOLIDS = [
    ({"shape": "box", "size": (3, 2, 1.25)}, box((3, 2, 1.25))),
    (
        {"shape": "cylinder", "radius": 1.5, "height": 2},
        solid_of_revolution(lambda _: 0, lambda _: 1.5, -1, 1),
    ),
    (
        {"shape": "cylinder", "radius": 1.5, "height": 2, "inner": 0.5},
        solid_of_revolution(lambda _: 0.5, lambda _: 1.5, -1, 1),
    ),
    (
        {"shape": "cone", "radius": 1.5, "height": 2},
        solid_of_revolution(lambda _: 0, lambda z: 0.75 * z, 0, 2),
    ),
    ({"shape": "ellipsoid", "semi_axes": (3, 2, 1.25)}, ball((3, 2, 1.25))),
    ({"shape": "sphere", "radius": 2}, ball((2, 2, 2))),
    ({"shape": "sphere", "radius": 2, "inner": 1.5}, ball((2, 2, 2), 0.75)),
    ({"shape": "rod", "height": 3}, [((0, 0, z), w) for z, w in zip(*on(-1.5, 1.5), strict=True)]),
    (
        {"shape": "disc", "radius": 2, "inner": 1},
        [
            ((r * np.cos(p), r * np.sin(p), 0.0), w * r)
            for r, w in zip(*on(1, 2), strict=True)
            for p in ROUND
        ],
    ),
]
TURNS = {  # columns: the images of x, y, z
    "z": np.eye(3),
    "x": np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    "y": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]),
    "-z": np.diag([1, -1, -1]),
    "-x": np.array([[0, 0, -1], [1, 0, 0], [0, -1, 0]]),
}


def integrated(points, mass, at, axis):
    """Centre and inertia about the fixed point of a cloud of points with weights."""
    places = np.array([x for x, _ in points]) @ TURNS[axis].T + at
    weights = np.array([w for _, w in points])
    weights *= mass / weights.sum()
    square = np.einsum("n,ni,ni->", weights, places, places)
    inertia = square * np.eye(3) - np.einsum("n,ni,nj->ij", weights, places, places)
    return weights @ places / mass, inertia


@pytest.mark.parametrize(("keys", "points"), SOLIDS, ids=lambda x: str(x)[:40])
@pytest.mark.parametrize("axis", [*TURNS])
def test_moments_are_the_integrals_over_the_solid(keys, points, axis):
    if axis != "z" and keys["shape"] in ("box", "ellipsoid", "sphere"):
        pytest.skip("has no axis")
    part = polhode.Part(mass=2.5, at=(0.5, -1, 3), axis=axis, **keys)
    centre, inertia = integrated(points, 2.5, (0.5, -1, 3), axis)
    own = np.array([[float(x) for x in row] for row in part.inertia])
    assert np.max(np.abs(own - inertia)) < 200 * EPS * np.max(np.abs(inertia))
    assert np.max(np.abs([float(x) for x in part.centre] - centre)) < 100 * EPS * 3


def test_every_shape_is_integrated():
    with pytest.raises(polhode.BadInput, match="shape = none: expected ") as fault:
        polhode.Part("none", mass=1)
    names = str(fault.value).partition("expected ")[2].partition(" (")[0].split(", ")
    assert {keys["shape"] for keys, _ in SOLIDS} == {*names} - {"point"}


def test_a_shell_is_the_limit_of_hollow_spheres():
    shell = polhode.Part("sphere", 1, radius=3, inner=3)
    assert shell.inertia[0][0] == Fraction(2, 3) * 9


def test_parts_turn_as_one():
    """A dumbbell and its rod, by the parallel-axis theorem by hand; the axes are not principal."""
    body = polhode.Body.of_parts(
        [
            polhode.Part("point", 2, at=(1, 1, 0)),
            polhode.Part("point", 1, at=(-1, 0, 2)),
            polhode.Part("box", 12, size=(1, 2, 3)),
        ],
        g=3,
    )
    x, y, z = (2 + 1 * 4 + 13, 2 + 5 + 10, 2 * 2 + 1 + 5)
    assert body.inertia == ((x, -2, 2), (-2, y, 0), (2, 0, z))
    assert body.centre == (Fraction(1, 15), Fraction(2, 15), Fraction(2, 15))
    assert body.torque == (3, 6, 6)


def test_steiner_carries_to_the_fixed_point():
    body = polhode.Body.about_centre([[2, 0, 0], [0, 3, 0], [0, 0, 4]], (1, 2, 3), 5, 7)
    assert body.inertia == ((67, -10, -15), (-10, 53, -30), (-15, -30, 29))
    assert body.torque == (7, 14, 21)
