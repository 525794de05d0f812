"""The case library and its catalogue."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

from polhode.common.errors import BadInput, nearest
from polhode.common.provenance import digest
from polhode.scenes import library
from polhode.scenes.scene import Scene

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
    for word, key, value, usual in scene.extras:
        if takes is not None and word not in takes:
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
    top, entries = library.folder(), {}
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
    top, rows = library.folder(), {}
    for name, entry in sorted(entries.items()):
        rows[name] = [digest((top / f"{name}.toml").read_text("utf-8")), *entry]
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in rows.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"
