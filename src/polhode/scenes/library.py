"""The case library, its catalogue, and scenes whose start is a box."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Collection, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from polhode.common.arguments import each
from polhode.common.errors import BadInput, nearest
from polhode.common.files import called
from polhode.common.provenance import digest
from polhode.numbers import exact
from polhode.numbers.conversion import exact_number
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, sign
from polhode.numbers.expression import PLUS_MINUS, in_units, interval_mark
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.scenes.scene import Scene, SceneTables, is_text
from polhode.scenes.vocabulary import REQUESTS

# --- library --------------------------------------------------------------------------------------
#
# The case library: the scene files that ship, by name.


def folder() -> Path:
    """Where the cases lie: inside the installed package, else at the top of a checkout."""
    inside = Path(__file__).parents[1] / "cases"
    return inside if inside.is_dir() else Path(__file__).parents[3] / "cases"


#: Endings of files that are tables.
_TABLES = (".csv", ".npz", ".npy", ".parquet")


def names() -> list[str]:
    """The names of all cases that ship, such as ``euler/separatrix``, sorted."""
    top = folder()
    return sorted(p.relative_to(top).with_suffix("").as_posix() for p in top.rglob("*.toml"))


def ships(name: str) -> bool:
    """Whether a case of exactly this name ships: only the folders on its way are looked into.

    A name is no path: ``./euler/sphere`` is none, nor is ``Euler/sphere`` where a file of that name
    would open it all the same.
    """
    place = folder()
    for part in f"{name}.toml".split("/"):
        try:
            if part not in os.listdir(place):
                return False
        except (FileNotFoundError, NotADirectoryError):  # no cases were installed, or a file
            return False
        place /= part
    return True


def load(scene: Scene | str | Path, *, takes: Collection[str] | None = None) -> Scene:
    """Load a scene by the name of a case that ships, or by a path.

    Parameters
    ----------
    scene : Scene, str or Path
        A name such as "lagrange/nutation", a path of a TOML file, or a Scene, which is returned.
    takes : collection of str, optional
        The words of what the scene may have beyond a heavy body, a start and times: "outputs",
        "events", "form"; all of it by default.  A function that would ignore the rest refuses it.

    Returns
    -------
    Scene
        The scene, its numbers exact.

    Raises
    ------
    BadInput
        An unknown case or file, or one that is no scene, or has what is not taken: file, key, value
        and what was expected.

    Examples
    --------
    >>> import polhode
    >>> polhode.load("lagrange/nutation")
    <Scene lagrange/nutation: moments 1, 1, 1/2, 81 times to t = 40>
    """
    if not isinstance(scene, Scene):
        from polhode.scenes import scene_file

        scene = scene_file.read(*place(scene))
        scene.speak()
    if takes is not None:
        for word, key, value, usual in scene.extras:
            if word not in takes:
                raise BadInput(scene.name, key, value, f"{usual}, or polhode.integrate")
    return scene


def _expected(value: object) -> str:
    """What is loaded; of a result, what of it may have been meant."""
    meant = ""
    if callable(getattr(value, "orbit", None)):  # a family of orbits, or a search for them
        meant = "; its orbit k is .orbit(k)"
    elif hasattr(value, "residue") and hasattr(value, "state"):
        meant = "; the orbit of point k of a family or a search is family.orbit(k)"
    elif isinstance(getattr(value, "scene", None), Scene):
        meant = "; did you mean its .scene?"
    return f"a Scene, a path, or the name of a case{meant}"


def place(scene: str | Path) -> tuple[Path, str | None]:
    """The file of a scene, and its name where it is a case that ships; raises BadInput."""
    if not isinstance(scene, (str, Path)):
        raise BadInput("load", "scene", scene, _expected(scene))
    name = str(scene)
    if ships(name):
        return folder() / f"{name}.toml", name
    if not name or not os.path.exists(scene):  # False for what can be no path, too
        words = nearest(name.removesuffix(".toml"), names())
        if name and os.path.isfile(f"{name}.toml"):
            words = f"did you mean the file {name}.toml?"
        raise BadInput(name or "''", "SCENE", None, f"a path, or the name of a case: {words}")
    if Path(scene).suffix.lower() in _TABLES:
        expected = "a scene file (.toml): this is a table, as for polhode compare FILE SCENE"
        raise BadInput(name, "SCENE", None, expected)
    return Path(scene), None


def path_of(scene: str | Path) -> Path | None:
    """The path that a scene or a trajectory is read from; None for the name of a case."""
    return None if ships(str(scene)) else Path(scene)


def matching(patterns: list[str]) -> list[str]:
    """Names, tops such as ``euler`` and patterns such as ``euler/w*``, expanded; a path stands for
    itself."""
    if not patterns:
        return names()
    matches: list[str] = []
    for pattern in patterns:
        hits = [name for name in names() if fnmatchcase(name, pattern)]
        if not hits and not os.path.isfile(pattern):
            hits = [name for name in names() if fnmatchcase(name, f"{pattern}/*")]
        matches += [name for name in hits or [pattern] if name not in matches]
    return matches


# --- catalogue ------------------------------------------------------------------------------------
#
# What ``polhode list`` shows of the cases that ship, found once and kept beside their files.
#
# Regime and reference of a case follow from its file alone, but finding them takes some
# milliseconds of exact arithmetic each. ``cases/catalogue.json`` holds them by the fingerprint of
# the file, so that an entry is never that of another text; ``tests/measure/catalogue.py`` writes
# it.


FILE = "catalogue.json"


class Entry(NamedTuple):
    """A case as it is listed."""

    title: str
    tags: tuple[str, ...]
    regime: str
    reference: str


def entries() -> Mapping[str, Entry]:
    """The entries of the cases whose files are as they were when the catalogue was made."""
    top, entries = folder(), {}
    try:
        rows = json.loads((top / FILE).read_bytes())
        for name, (fingerprint, title, tags, regime, reference) in rows.items():
            path = top / f"{name}.toml"
            if path.is_file() and digest(path.read_text("utf-8")) == fingerprint:
                entries[name] = Entry(title, tuple(tags), regime, reference)
    except (AttributeError, OSError, TypeError, ValueError):
        return {}  # gone or broken: then every case is read
    return entries


def written(entries: Mapping[str, Entry]) -> str:
    """The text of the catalogue's file."""
    top, rows = folder(), {}
    for name, entry in sorted(entries.items()):
        rows[name] = [digest((top / f"{name}.toml").read_text("utf-8")), *entry]
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in rows.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


# --- start box ------------------------------------------------------------------------------------
#
# Starts that are boxes: ``start.omega = ["3/10 ± 1e-9", 0, 1]``, every motion from it at once.
#
# What proves something of all motions from a box reads its scene here; everything else refuses such
# a scene, since it would take one motion of many.


BOX_KEY = "start.omega"


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


def load_box(scene: Scene | str | Path) -> StartBox:
    """A scene, and the radii of its start where its file gives intervals; raises BadInput."""
    from polhode.scenes import scene_file

    if isinstance(scene, Scene):
        return StartBox(load(scene, takes=REQUESTS))
    path, name = place(scene)
    source = name or str(path)
    text = scene_file.text_of(path, source)
    tables = scene_file.tables(text, source)
    start = tables.get("start")
    omega = start.get("omega") if isinstance(start, dict) else None
    if not isinstance(omega, list) or len(omega) != 3 or not any(map(_mark, omega)):
        return StartBox(load(scene, takes=REQUESTS))
    reading, radii = SceneTables(source, tables), [Fraction(0)] * 3
    for k, item in enumerate(omega):
        if mark := _mark(item):
            middle, _, radius = (part.strip() for part in item.partition(mark))
            exactly = reading.number(BOX_KEY, radius)
            if sign(exactly) < 0:
                raise reading.bad(BOX_KEY, item, "a middle and a radius of 0 or more")
            # 300 ± 1 rpm may mean 300 rpm or 300 rad/s; 0 is 0 in any unit
            parts = [part for part in (middle, radius) if sign(reading.number(BOX_KEY, part))]
            if len({*map(in_units, parts)}) > 1:
                raise reading.bad(BOX_KEY, item, "a unit at the middle and at the radius, or none")
            radii[k], omega[k], text = _fraction(exactly), middle, text.replace(item, middle)
    own = scene_file.of_tables(tables, source, text)
    own.speak()
    a, b, c = radii
    return StartBox(own if name else replace(own, name=called(path)), (a, b, c))


def box_of(scene: Scene | str | Path, radius: AnyNumber | AnyVector | None) -> StartBox:
    """What a scene's file gives, or the box with one radius, or with one for each component."""
    box = load_box(scene)
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
    near = exact.nearest(radius, 53) * (1 + Fraction(1, 1 << 50))
    unit = Fraction(10) ** math.floor(math.log10(near) - 3)
    return math.ceil(near / unit) * unit


def _mark(item: object) -> str:
    """What stands before a component's radius; empty where there is none."""
    return interval_mark(item) if is_text(item) else ""
