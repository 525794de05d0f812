"""Many scenes from one: numbers of a scene file varied, every member exact and checked up front."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple, overload

from polhode.common.arguments import each, of_kind
from polhode.common.errors import BadInput, nearest, plain
from polhode.numbers import expression
from polhode.numbers.convert import exact_number
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError
from polhode.scenes import keys, scene_file
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

MAX_MEMBERS = 10_000_000
_BODIES = 1024  # that are remembered

_SECTIONS = ("body", "start")
_KEY = re.compile(r"(body|start)\.[a-z]+(\[[1-9]\d*\](\.[a-z_]+)?)*")
_WORDS = keys.words("body") | keys.words("body.parts") | keys.words("start")

#: Varied numbers by key: a sequence of values or ``"FROM:TO:N"`` each, of which every combination
#: is a member; or the members one by one, each with the same keys.
Vary = Mapping[str, Any] | Sequence[Mapping[str, Any]]


class Spaced(Sequence[Exact]):
    """So many numbers from ``first`` to ``last``, evenly spaced, ends included; made when asked."""

    def __init__(self, first: Exact, last: Exact, count: int) -> None:
        self.first, self.last, self._count = first, last, count

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Exact: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Exact]: ...
    def __getitem__(self, index: int | slice) -> Exact | Sequence[Exact]:
        where = range(self._count)[index]
        if isinstance(where, range):
            return [self[k] for k in where]
        step = Fraction(where, max(1, self._count - 1))
        return self.first + (self.last - self.first) * step

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sequence):
            return NotImplemented
        return len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Spaced({self.first!r}, {self.last!r}, {self._count})"


class Rows(Sequence[tuple[Exact, ...]]):
    """A row of values for each member, made when asked.

    ``product``: every combination of the columns' values, the last column's changing fastest; else
    the columns are as long as the rows are many.
    """

    def __init__(self, columns: Sequence[Sequence[Exact]], product: bool) -> None:
        self.columns, self.product = tuple(columns), product
        sizes = [len(column) for column in self.columns]
        self._count = math.prod(sizes) if product else sizes[0]
        #: For each column how many rows have the same value in a row of rows.
        self.repeats = [math.prod(sizes[i + 1 :]) if product else 1 for i in range(len(sizes))]

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> tuple[Exact, ...]: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[tuple[Exact, ...]]: ...
    def __getitem__(self, index: int | slice) -> tuple[Exact, ...] | Sequence[tuple[Exact, ...]]:
        where = range(self._count)[index]
        if isinstance(where, range):
            return [self[k] for k in where]
        each = zip(self.columns, self.repeats, strict=True)
        return tuple(column[where // repeat % len(column)] for column, repeat in each)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sequence):
            return NotImplemented
        if isinstance(other, Rows) and self.product == other.product:
            return self.columns == other.columns
        return len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Rows({self.columns!r}, {self.product})"


class Grid(NamedTuple):
    """What is varied: the keys, and a row of values for each member."""

    keys: tuple[str, ...]
    rows: Rows


class Members(Sequence[Scene]):
    """The scenes of a sweep, without output times; each made, and checked, when it is asked for."""

    def __init__(self, scene: Scene, varied: Grid) -> None:
        self.scene, self.varied = scene, varied
        self._reading: Any = None

    def __len__(self) -> int:
        return len(self.varied.rows)

    @overload
    def __getitem__(self, index: int) -> Scene: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Scene]: ...
    def __getitem__(self, index: int | slice) -> Scene | Sequence[Scene]:
        where = range(len(self))[index]
        if isinstance(where, range):
            return [self[k] for k in where]
        if self._reading is None:
            self._reading = _Reading(self.scene, self.varied)
        scene: Scene = self._reading.member(where)
        return scene

    def __iter__(self) -> Iterator[Scene]:
        return (self[k] for k in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Members):
            return NotImplemented
        return self.scene == other.scene and self.varied == other.varied

    __hash__ = None  # type: ignore[assignment]

    def __getstate__(self) -> tuple[Scene, Grid]:
        return self.scene, self.varied

    def __setstate__(self, state: tuple[Scene, Grid]) -> None:
        self.__init__(*state)  # type: ignore[misc]

    @property
    def tables(self) -> dict[str, Any]:
        """The tables that are varied, numbers exact, none of them varied yet."""
        data = tables_of(self.scene)
        _places(data, self.varied.keys, self.scene.name)
        return data


class _Reading:
    """A scene's tables in which a member's values are put before it is read."""

    def __init__(self, scene: Scene, varied: Grid) -> None:
        self.scene, self.varied = scene, varied
        self.data = tables_of(scene)
        self.places = _places(self.data, varied.keys, scene.name)
        self.same_body = not any(key.startswith("body.") for key in varied.keys)
        self.bare = replace(scene, times=(), published=(), expect={}, source="", outputs=())
        self.bodies: dict[tuple[Any, ...], Body] = {}

    def member(self, index: int) -> Scene:
        row = self.varied.rows[index]
        name = label(self.scene.name, self.varied, index)
        for spots, value in zip(self.places, row, strict=True):
            for table, at in spots:
                table[at] = value
        body = self.scene.body if self.same_body else self._known(row, name)
        body, omega, gamma, psi = scene_file.body_and_start(self.data, name, body)
        return replace(self.bare, body=body, omega=omega, gamma=gamma, psi=psi, name=name)

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


def option(text: str, name: str) -> tuple[str, Sequence[Exact]]:
    """Key and values of ``KEY=FROM:TO:N`` or ``KEY=a,b,c``; raises BadInput."""
    key, equals, listed = text.partition("=")
    if not equals:
        raise BadInput(name, "--vary", text, "KEY=FROM:TO:N or KEY=a,b,c")
    return key.strip(), values(listed, key.strip(), name)


def options(texts: Sequence[str], name: str) -> dict[str, Sequence[Exact]]:
    """What all ``--vary`` say together; raises BadInput."""
    varied: dict[str, Sequence[Exact]] = {}
    for text in texts:
        key, found = option(text, name)
        if key in varied:
            raise BadInput(name, "--vary", text, f"{key} once")
        varied[key] = found
    return varied


def values(text: str, key: str, name: str) -> Sequence[Exact]:
    """The numbers of ``FROM:TO:N`` (N of them, evenly spaced, ends included) or of ``a,b,c``."""
    try:
        if ":" not in text:
            return [expression.number(item) for item in text.split(",")]
        ends = text.split(":")
        if len(ends) != 3:
            raise BadInput(name, key, text, "FROM:TO:N")
        first, last = expression.number(ends[0]), expression.number(ends[1])
    except ExpressionError as fault:
        raise BadInput(name, key, text, f"numbers ({fault})") from None
    count = int(ends[2]) if re.fullmatch(r"\s*\d{1,9}\s*", ends[2]) else 0
    if not 1 <= count <= MAX_MEMBERS:
        raise BadInput(name, key, text, f"FROM:TO:N with N from 1 to {MAX_MEMBERS}")
    return Spaced(first, last, count)


def grid(vary: Vary, name: str) -> Grid:
    """Keys and rows of what is varied; raises BadInput."""
    product = isinstance(vary, Mapping)
    if isinstance(vary, Mapping):
        columns = [_column(key, given, name) for key, given in vary.items()]
        keys = tuple(vary)
        count = math.prod(len(column) for column in columns)
    else:
        vary = each(name, "vary", vary, lambda member: member, "keys with their values, or members")
        for k, member in enumerate(vary):
            of_kind(name, f"vary[{k + 1}]", member, Mapping, "a mapping of keys to values")
        keys = tuple(vary[0]) if vary else ()
        count = len(vary)
        for k, member in enumerate(vary):
            if set(member) != set(keys):
                listed = ", ".join(map(plain, member))
                raise BadInput(name, f"member {k + 1}", listed, f"the keys {', '.join(keys)}")
        columns = [[_exact(m[key], key, name) for m in vary] for key in keys]
    if not keys:
        raise BadInput(name, "vary", None, "at least one number of the scene file to vary")
    if count > MAX_MEMBERS:
        raise BadInput(name, "vary", f"{count} members", f"at most {MAX_MEMBERS}; split the sweep")
    return Grid(keys, Rows(columns, product))


def label(name: str, varied: Grid, index: int) -> str:
    """How a member is called in messages."""
    row = zip(varied.keys, varied.rows[index], strict=True)
    return f"{name} member {index + 1} ({', '.join(f'{key} = {shown(x)}' for key, x in row)})"


def _column(key: str, given: Any, name: str) -> Sequence[Exact]:
    if isinstance(given, str):
        return values(given, key, name)
    if not isinstance(given, Iterable):
        raise BadInput(name, key, plain(given), "a sequence of numbers, or FROM:TO:N")
    column = given if isinstance(given, Spaced) else [_exact(x, key, name) for x in given]
    if not column:
        raise BadInput(name, key, "nothing", "at least one value")
    return column


def _exact(value: Any, key: str, name: str) -> Exact:
    try:
        return exact_number(value)
    except ValueError as fault:
        raise BadInput(name, key, plain(value), f"a number ({fault})") from None


def tables_of(scene: Scene) -> dict[str, Any]:
    """The tables of body and start: those of the scene's file, if they still say what it is."""
    held = (scene.body, scene.omega, scene.gamma, scene.psi)
    if scene.source:
        data = scene_file.tables(scene.source, scene.name)
        if scene_file.body_and_start(data, scene.name) == held:
            return {name: dict(data[name]) for name in _SECTIONS}
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


def _places(data: dict[str, Any], keys: Sequence[str], name: str) -> list[list[tuple[Any, Any]]]:
    """For each key the containers and indices of its number; an inertia's mirror image with it."""
    body, start = data["body"], data["start"]
    if "centre" in body and "g" not in body:
        body.setdefault("weight", 0)
    if "gamma" in start:
        start.setdefault("psi", 0)
    known = dict(_leaves(data, name))
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


def _leaves(data: dict[str, Any], name: str) -> Iterable[tuple[str, tuple[Any, Any]]]:
    """Every number of the tables: its key, and where it stands; read once for all members."""
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
            table[at] = scene_file.exact_value(value, key, name)
            yield key, (table, at)
