"""Many scenes from one: the members of a sweep, every one exact, and checked when it is made."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, TypeAlias

from polhode.common.errors import BadInput, FileName, nearest, say_change
from polhode.common.values import cached_property
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.exact_sequences import LazySequence
from polhode.scenes import keys, scene_file
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.scenes.variation.vary import Grid
from polhode.scenes.vocabulary import CENTRE

_BODIES = 1024  # that are remembered
_LOOKED_AT = 64  # members, for notes
_NEAR_FLAT = Fraction(1, 1 << 40)
_MAY_BE_ROUNDED = {"body.moments", "body.inertia", "start.gamma", "start.quaternion"}

_SECTIONS = ("body", "start")
_KEY = re.compile(r"(body|start)\.[a-z_]+(\[[1-9]\d*\](\.[a-z_]+)?)*")
#: Where a number of the tables stands: in which table or list, and under which key or index.
Place: TypeAlias = tuple[Any, Any]

_WORDS = keys.words("body") | keys.words("body.parts") | keys.words("start")


class Members(LazySequence[Scene]):
    """The scenes of a sweep, without output times; each made, and checked, when it is asked for."""

    def __init__(self, scene: Scene, varied: Grid) -> None:
        self.scene, self.varied = scene, varied
        self._mine = threading.local()  # one reads by writing into tables

    def __len__(self) -> int:
        return len(self.varied.rows)

    def at(self, k: int) -> Scene:
        """The scene of a member."""
        reading: _Reading | None = getattr(self._mine, "reading", None)
        if reading is None:
            reading = self._mine.reading = _Reading(self.scene, self.varied)
        return reading.member(k)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Members):
            return NotImplemented
        return self.scene == other.scene and self.varied == other.varied

    __hash__ = None

    def __getstate__(self) -> tuple[Scene, Grid]:
        return self.scene, self.varied

    def __setstate__(self, state: tuple[Scene, Grid]) -> None:
        self.__init__(*state)  # type: ignore[misc]

    @cached_property
    def axes_stay(self) -> bool:
        """Whether all members have the principal axes of the scene.

        A body of parts, or one whose inertia is given about its centre of mass, turns its axes with
        nearly every number.  Two equal moments leave a choice, which the centre of mass makes.
        """
        varied = {key.partition("[")[0] for key in self.varied.keys if key.startswith("body.")}
        varied -= {"body.weight", "body.g"}
        if not varied:
            return True
        body, axes = self.tables["body"], self.scene.body.axes
        if "parts" in body or body.get("about") == CENTRE:
            return False
        if not varied <= {"body.moments", "body.mass", "body.centre"}:
            return False
        a, b, c = self.scene.body.moments
        return axes.trivial or "body.centre" not in varied or not (a == b or b == c or c == a)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """The notes of the scene, and what was changed of the first members, as of one of them."""
        varied = {key.partition("[")[0] for key in self.varied.keys}
        each = zip(self.varied.keys, self.varied.rows.columns, strict=True)
        as_is = any(k.startswith("start.") for k, x in each if x.floats is not None)
        if as_is:  # members begin at the numbers of the arrays
            varied = {key for key in varied if key.startswith("body.")}
        if not varied & _MAY_BE_ROUNDED:
            return self.scene.notes
        starts = any(key.startswith("start.") for key in varied & _MAY_BE_ROUNDED)
        few = range(min(len(self), _LOOKED_AT))
        members = (self[k] for k in few if starts or self._body_may_be_changed(k))
        of_members = ([*filter(None, [x.body.change])] if as_is else x.changes for x in members)
        changes = next(filter(None, of_members), ())
        return (*self.scene.notes, *(f"members: {text}" for text in changes))

    def _body_may_be_changed(self, index: int) -> bool:
        """Not where three moments vary and are far from those of a flat body."""
        each = zip(self.varied.keys, self.varied.rows[index], strict=True)
        moments = [x for key, x in each if key.startswith("body.moments")]
        return len(moments) < 3 or 2 * max(moments) > sum(moments) * (1 - _NEAR_FLAT)

    def provenance(self) -> dict[str, object]:
        """Where a result comes from, see :meth:`Scene.provenance`; members' notes are said, too."""
        for text in self.notes[len(self.scene.notes) :]:
            say_change(self.scene.name, text)
        found = self.scene.provenance()
        return found | {"notes": list(self.notes)} if self.notes else found

    @cached_property
    def tables(self) -> dict[str, Any]:
        """The tables that are varied, as they were before; not to be written to."""
        data = tables_of(self.scene)
        _places(dict(_leaves(data)), self.varied.keys, self.scene.name)
        return data


class _Reading:
    """A scene's tables in which a member's values are put before it is read."""

    def __init__(self, scene: Scene, varied: Grid) -> None:
        self.scene, self.varied = scene, varied
        self.data = tables_of(scene)
        leaves = dict(_leaves(self.data))
        for key, (table, at) in leaves.items():  # read once for all members
            table[at] = scene_file.exact_value(table[at], key, scene.name)
        self.places = _places(leaves, varied.keys, scene.name)
        self.same_body = not any(key.startswith("body.") for key in varied.keys)
        bare = replace(scene, times=(), published=(), expect={}, source="", outputs=())
        self.bare = replace(bare, change="", doubt="")
        self.bodies: dict[tuple[Any, ...], Body] = {}

    def member(self, index: int) -> Scene:
        row = self.varied.rows[index]
        name = label(self.scene.name, self.varied, index)
        for spots, value in zip(self.places, row, strict=True):
            for table, at in spots:
                table[at] = value
        body = self.scene.body if self.same_body else self._known(row, name)
        body, omega, gamma, psi, change = scene_file.body_and_start(self.data, name, body)
        found = replace(self.bare, body=body, omega=omega, gamma=gamma, psi=psi, name=name)
        return replace(found, change=change) if change else found

    def _known(self, row: tuple[Exact, ...], name: str) -> Body:
        """The body that the tables hold now: one for all members that have the same."""
        of_body = tuple(
            x if isinstance(x, Fraction) else (id(x),)
            for key, x in zip(self.varied.keys, row, strict=True)
            if key.startswith("body.")
        )
        if of_body not in self.bodies:
            if len(self.bodies) >= _BODIES:
                self.bodies.clear()
            self.bodies[of_body] = scene_file.body_and_start(self.data, name)[0]
        return self.bodies[of_body]


def label(name: str, varied: Grid, index: int) -> str:
    """How a member is called in messages."""
    row = zip(varied.keys, varied.rows[index], strict=True)
    more = f" member {index + 1} ({', '.join(f'{key} = {shown(x)}' for key, x in row)})"
    return name.with_more(more) if isinstance(name, FileName) else name + more


def tables_of(scene: Scene) -> dict[str, Any]:
    """The tables of body and start: those of the scene's file, if they still say what it is."""
    text = scene_file.source_text(scene)
    if text is not None and text.tells(scene, "body", "omega", "gamma", "psi"):
        return {name: dict(text.tables[name]) for name in _SECTIONS}
    body = scene.body
    start: dict[str, Any] = {"omega": list(scene.omega)}
    if scene.gamma is not None:
        start |= {"gamma": list(scene.gamma), "psi": scene.psi}
    inertia = body.inertia
    if any(inertia[i][j] != 0 for i in range(3) for j in range(3) if i != j):
        form: dict[str, Any] = {"inertia": [list(row) for row in inertia]}
    else:
        form = {"moments": [inertia[i][i] for i in range(3)]}
    return {"body": {**form, "centre": list(body.centre), "weight": body.weight}, "start": start}


def _places(known: Mapping[str, Place], keys: Sequence[str], name: str) -> list[list[Place]]:
    """For each key the places of its number among those known; an inertia's mirror image with it.

    Raises BadInput.
    """
    places, taken = [], set()
    for key in keys:
        if key not in known or not _KEY.fullmatch(key):
            raise BadInput(name, "vary", key, f"a number of the scene: {nearest(key, [*known])}")
        spots = [known[key]]
        if key.startswith("body.inertia"):
            row, column = key[13], key[16]
            mirror = f"body.inertia[{column}][{row}]"
            if mirror != key:
                spots.append(known[mirror])
            if mirror in taken:
                raise BadInput(name, "vary", key, f"not {mirror} too: they are one number")
        taken.add(key)
        places.append(spots)
    return places


def _leaves(data: dict[str, Any]) -> Iterator[tuple[str, Place]]:
    """Every number of the tables: its key, and where it stands, also of those left out."""
    body, start = data["body"], data["start"]
    if "centre" in body and "g" not in body:
        body.setdefault("weight", 0)
    if "gamma" in start:
        start.setdefault("psi", 0)
    pending: list[tuple[str, Any, Any]] = [
        (f"{section}.{key}", data[section], key) for section in _SECTIONS for key in data[section]
    ]
    for key, table, at in pending:
        value = table[at]
        if isinstance(value, list):
            table[at] = value = list(value)  # the caller's tables stay as they are
            pending += [(f"{key}[{i + 1}]", value, i) for i in range(len(value))]
        elif isinstance(value, dict):  # one of [[body.parts]]
            table[at] = value = dict(value)
            pending += [(f"{key}.{name}", value, name) for name in value]
        elif not isinstance(value, bool) and at not in _WORDS:
            yield key, (table, at)
