"""The solids that a moving body is drawn as, on pages and in films: its parts, or its ellipsoid.

Lengths are in units of the sphere about the fixed point, on which the path is drawn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.scenes.body import Body
from polhode.scenes.shapes import SHAPES, Part

_REACH = 0.8  # of a body of parts
_LARGEST = 0.62  # semi-axis of an ellipsoid of inertia
_ROD, _POINT, _THIN = 0.012, 0.05, 0.02  # what has no width is drawn so wide
_LEAST = 0.008  # of a wall
_PIECE = 0.12  # of a straight edge that is swept

Vector = tuple[float, ...]
Lengths = tuple[float | Vector, ...]


class Solid(NamedTuple):
    """A solid about its own axes, and where these are in the body.

    ``kind``: "box", ``numbers`` its three edges; "ellipsoid", its semi-axes; or "revolved", the
    closed line of points (radius, height) that it sweeps about its third axis.  ``place``: its
    three axes and its origin, in the body.
    """

    kind: str
    numbers: Lengths
    place: tuple[Vector, Vector, Vector, Vector]


class Faces(NamedTuple):
    """Polygons of a solid in the body: corners (n, 4, 3), outward normals (n, 3), tones (n)."""

    corners: Doubles
    normals: Doubles
    tones: Doubles


def solids(body: Body) -> tuple[Solid, ...]:
    """What a body is drawn as."""
    if body.parts:
        size = unit(body)
        return tuple(_part(part, size) for part in body.parts)
    roots = 1 / np.sqrt([to_double(x) for x in body.moments])
    semi = tuple((_LARGEST * roots / np.max(roots)).tolist())
    x, y, z = (tuple(to_double(entry) for entry in row) for row in body.axes.rows)
    return (Solid("ellipsoid", semi, (x, y, z, (0.0, 0.0, 0.0))),)


def unit(body: Body) -> float:
    """The unit of length in which a body is drawn; 1 where it has no parts."""
    return max(_extent(part) for part in body.parts) / _REACH if body.parts else 1.0


def faces(solid: Solid, n: int = 12) -> Faces:
    """A solid as polygons, an ellipsoid's meridian in ``n`` pieces, two tones to see it turn."""
    if solid.kind == "box":
        grids, tones = _box(solid.numbers)
    elif solid.kind == "ellipsoid":
        grids, tones = _ellipsoid(solid.numbers, n)
    else:
        grids, tones = _revolved(solid.numbers, 2 * n)
    *axes, origin = np.array(solid.place)
    corners = grids @ np.array(axes) + origin
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    sizes = np.linalg.norm(across, axis=1)
    nonzero = sizes > 0
    return Faces(corners[nonzero], across[nonzero] / sizes[nonzero, None], tones[nonzero])


def _part(part: Part, size: float) -> Solid:
    lengths = _lengths(part)
    place = _frame(lengths["direction"], [x / size for x in lengths["at"]])
    radius, height = lengths.get("radius", 0.0) / size, lengths["height"] / size
    shape = part.shape
    if shape == "box":
        return Solid("box", tuple(x / size for x in lengths["size"]), place)
    if shape in ("ellipsoid", "sphere", "point"):
        same = (radius if shape == "sphere" else _POINT,) * 3
        semi = tuple(x / size for x in lengths["semi_axes"]) if shape == "ellipsoid" else same
        return Solid("ellipsoid", semi, place)
    if shape == "cone":
        return Solid("revolved", ((0.0, 0.0), (radius, height), (0.0, height)), place)
    inner, outer, half = 0.0, _ROD, height / 2
    if shape != "rod":
        inner, outer = min(lengths["inner"] / size, radius - _LEAST), radius
        half = max(half, _THIN / 2)
    corners = ((inner, -half), (outer, -half), (outer, half), (inner, half), (inner, -half))
    return Solid("revolved", corners, place)


def _lengths(part: Part) -> dict[str, Any]:
    """A part's lengths, place and direction as doubles."""
    lengths: dict[str, Any] = {
        "at": [to_double(x) for x in part.at],
        "direction": [to_double(x) for x in part.direction],
        "height": 0.0,
        "inner": 0.0,
    }
    needed = SHAPES[part.shape]
    for key in (*needed.needs, *needed.takes):
        value = part.lengths[key]
        lengths[key] = (
            [to_double(x) for x in value] if isinstance(value, tuple) else to_double(value)
        )
    return lengths


def _extent(part: Part) -> float:
    """How far a part reaches from the fixed point, at most."""
    numbers = _lengths(part)
    lengths = [*numbers.get("size", []), *(2 * x for x in numbers.get("semi_axes", []))]
    lengths += [2 * numbers.get("radius", 0.0), numbers["height"]]
    half = math.sqrt(sum((x / 2) ** 2 for x in lengths))
    lifted = numbers["height"] / 2 if part.shape == "cone" else 0.0
    middle = [x + lifted * e for x, e in zip(numbers["at"], numbers["direction"], strict=True)]
    return math.hypot(*middle) + half or 1.0


def _frame(
    direction: Sequence[float], origin: Sequence[float]
) -> tuple[Vector, Vector, Vector, Vector]:
    """A right-handed frame whose third axis is one of the body's axes, or its reverse."""
    z = np.array(direction)
    x = np.roll(np.abs(z), 1)
    y = np.cross(z, x)
    return tuple(x.tolist()), tuple(y.tolist()), tuple(z.tolist()), tuple(origin)


def _ellipsoid(semi: Lengths, n: int) -> tuple[Doubles, Doubles]:
    """Patches between parallels and meridians, octants in two tones."""
    lat = np.pi * (np.arange(n + 1) / n - 0.5)
    u = _swept(np.cos(lat), np.sin(lat), 2 * n) * np.array(semi)
    i, j = np.meshgrid(np.arange(n), np.arange(2 * n), indexing="ij")
    return _patches(u), ((2 * i // n + 2 * j // n) % 2).ravel().astype(float)


def _revolved(line: Lengths, n: int) -> tuple[Doubles, Doubles]:
    """Patches around the third axis, quarters in two tones."""
    radius, height = _divided(line).T
    _, j = np.meshgrid(np.arange(len(radius) - 1), np.arange(n), indexing="ij")
    return _patches(_swept(radius, height, n)), ((4 * j // n) % 2).ravel().astype(float)


def _swept(radius: Doubles, height: Doubles, n: int) -> Doubles:
    """What points sweep about the third axis, in ``n`` steps of a turn."""
    turn = 2 * np.pi * np.arange(n + 1) / n
    rows = (np.outer(radius, np.cos(turn)), np.outer(radius, np.sin(turn)))
    grid: Doubles = np.stack([*rows, np.outer(height, np.ones(n + 1))], axis=-1)
    return grid


def _divided(line: Lengths) -> Doubles:
    """The points of a line with others between, no two farther apart than _PIECE.

    Among short faces it can be told which one is nearer.
    """
    points = np.array(line)
    pieces = [points[:1]]
    for a, b in pairwise(points):
        count = max(1, math.ceil(float(np.linalg.norm(b - a)) / _PIECE))
        pieces.append(a + (b - a) * np.arange(1, count + 1)[:, None] / count)
    return np.concatenate(pieces)


def _patches(u: Doubles) -> Doubles:
    """The four corners of each mesh of a grid of points, outwards seen against the clock."""
    patches: Doubles = np.stack([u[:-1, :-1], u[:-1, 1:], u[1:, 1:], u[1:, :-1]], axis=2)
    return patches.reshape(-1, 4, 3)


def _box(size: Lengths, n: int = 4) -> tuple[Doubles, Doubles]:
    """Its faces, each in small patches, so that what is nearer can be told among solids."""
    grid = np.linspace(-0.5, 0.5, n + 1)
    a, b = np.meshgrid(grid, grid, indexing="ij")
    corners, tones = [], []
    for axis in range(3):
        for side in (1, -1):
            u = np.zeros((n + 1, n + 1, 3))
            u[..., axis] = side / 2
            u[..., (axis + 1) % 3], u[..., (axis + 2) % 3] = (a, b) if side < 0 else (b, a)
            corners.append(_patches(u * np.array(size)))
            tones.append(np.full(n * n, axis % 2, dtype=float))
    return np.concatenate(corners), np.concatenate(tones)
