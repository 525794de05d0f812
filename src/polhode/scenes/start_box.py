"""Starts that are boxes: ``start.omega = ["3/10 ± 1e-9", 0, 1]``, every motion from it at once.

What proves something of all motions from a box reads its scene here; everything else refuses such a
scene, since it would take one motion of many.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from polhode.common.arguments import each
from polhode.common.errors import BadInput
from polhode.common.files import called
from polhode.numbers import exact
from polhode.numbers.conversion import exact_number
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.scenes import library, scene_file
from polhode.scenes.scene import PLUS_MINUS, Literal, Scene, SceneTables
from polhode.scenes.vocabulary import REQUESTS

KEY = "start.omega"
_EXPECTED = "a middle and a radius of 0 or more"


class StartBox(NamedTuple):
    """All starts whose omega differs from the scene's by at most ``radii``, in its body axes.

    ``radii``: fractions; None for the scene's own start alone.
    """

    scene: Scene
    radii: tuple[Fraction, Fraction, Fraction] | None = None

    @property
    def text(self) -> str:
        """The radii for a complaint."""
        return f"{PLUS_MINUS[0]} ({', '.join(map(shown, self.radii or ()))})"


def read(scene: Scene | str | Path) -> StartBox:
    """A scene, and the radii of its start where its file gives intervals; raises BadInput."""
    if isinstance(scene, Scene):
        return StartBox(library.load(scene, takes=REQUESTS))
    path, name = library.place(scene)
    source = name or str(path)
    text = scene_file.text_of(path, source)
    tables = scene_file.tables(text, source)
    omega = _omega(tables)
    if not any(_mark(x) for x in omega):
        return StartBox(library.load(scene, takes=REQUESTS))
    reading, radii = SceneTables(source, tables), []
    for k, item in enumerate(omega):
        mark = _mark(item)
        if not isinstance(item, str) or not mark:
            radii.append(Fraction(0))
            continue
        middle, _, radius = (part.strip() for part in item.partition(mark))
        exactly = reading.number(KEY, radius)
        if sign(exactly) < 0:
            raise reading.bad(KEY, item, _EXPECTED)
        radii.append(_fraction(exactly))
        omega[k], text = middle, text.replace(item, middle)
    own = scene_file.of_tables(tables, source, lambda: text)
    own.speak()
    a, b, c = radii
    return StartBox(own if name else replace(own, name=called(path)), (a, b, c))


def chosen(scene: Scene | str | Path, radius: AnyNumber | AnyVector | None) -> StartBox:
    """What a scene's file gives, or the box with one radius, or with one for each component."""
    box = read(scene)
    if radius is None:
        return box
    scene = box.scene
    if box.radii is not None:
        expected = "no value together with intervals in the scene"
        raise BadInput(scene.name, "omega_radius", None, expected)
    listed = (radius,) * 3 if isinstance(radius, (str, int, float, Fraction)) else radius
    radii = each(scene.name, "omega_radius", listed, _radius, "a number, or three")
    if len(radii) != 3:
        raise BadInput(scene.name, "omega_radius", len(radii), "a number, or three")
    a, b, c = radii
    return StartBox(scene, (a, b, c))


def _radius(radius: AnyNumber) -> Fraction:
    exactly = exact_number(radius)
    if sign(exactly) < 0:
        raise ValueError("0 or more")
    return _fraction(exactly)


def _fraction(radius: Exact) -> Fraction:
    """The radius; where it is no fraction, as of degrees, a decimal of four digits above it."""
    if isinstance(radius, Fraction):
        return radius
    near = exact.binary(*exact.rounded(radius, 53)) * (1 + Fraction(1, 1 << 50))
    unit = Fraction(10) ** math.floor(math.log10(near) - 3)
    return math.ceil(near / unit) * unit


def _omega(tables: Mapping[str, object]) -> list[object]:
    """The components as they are written; empty where omega is not three of them."""
    start = tables.get("start")
    omega = start.get("omega") if isinstance(start, dict) else None
    return omega if isinstance(omega, list) and len(omega) == 3 else []


def _mark(item: object) -> str:
    """What stands before a component's radius; empty where there is none."""
    if not isinstance(item, str) or isinstance(item, Literal):
        return ""
    return next((mark for mark in PLUS_MINUS if mark in item), "")
