"""Many scenes from one: numbers of a scene file varied, every member exact and checked up front."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

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

MAX_MEMBERS = 100_000

_SECTIONS = ("body", "start")
_KEY = re.compile(r"(body|start)\.[a-z]+(\[[1-9]\d*\](\.[a-z_]+)?)*")
_WORDS = keys.words("body") | keys.words("body.parts") | keys.words("start")

#: Varied numbers by key: a sequence of values or ``"FROM:TO:N"`` each, of which every combination
#: is a member; or the members one by one, each with the same keys.
Vary = Mapping[str, Any] | Sequence[Mapping[str, Any]]


class Grid(NamedTuple):
    """What is varied: the keys, and a row of values for each member."""

    keys: tuple[str, ...]
    rows: tuple[tuple[Exact, ...], ...]


def option(text: str, name: str) -> tuple[str, list[Exact]]:
    """Key and values of ``KEY=FROM:TO:N`` or ``KEY=a,b,c``; raises BadInput."""
    key, equals, listed = text.partition("=")
    if not equals:
        raise BadInput(name, "--vary", text, "KEY=FROM:TO:N or KEY=a,b,c")
    return key.strip(), values(listed, key.strip(), name)


def values(text: str, key: str, name: str) -> list[Exact]:
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
    return [first + (last - first) * Fraction(k, max(1, count - 1)) for k in range(count)]


def grid(vary: Vary, name: str) -> Grid:
    """Keys and rows of what is varied; raises BadInput."""
    if isinstance(vary, Mapping):
        columns = [_column(key, given, name) for key, given in vary.items()]
        keys = tuple(vary)
        count = 1
        for column in columns:
            count *= len(column)
        rows: Iterable[tuple[Exact, ...]] = itertools.product(*columns)
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
        rows = (tuple(_exact(m[key], key, name) for key in keys) for m in vary)
    if not keys:
        raise BadInput(name, "vary", None, "at least one number of the scene file to vary")
    if count > MAX_MEMBERS:
        raise BadInput(name, "vary", f"{count} members", f"at most {MAX_MEMBERS}; split the sweep")
    return Grid(keys, tuple(rows))


def members(scene: Scene, varied: Grid) -> tuple[Scene, ...]:
    """A scene for each row, without output times; raises BadInput naming the member."""
    data = tables_of(scene)
    places = _places(data, varied.keys, scene.name)
    same_body = not any(key.startswith("body.") for key in varied.keys)
    bodies: dict[tuple[Any, ...], Body] = {}
    bare = replace(scene, times=(), published=(), expect={}, source="", outputs=())
    found = []
    for index, row in enumerate(varied.rows):
        name = label(scene.name, varied, index)
        for spots, value in zip(places, row, strict=True):
            for table, at in spots:
                table[at] = value
        of_body = tuple(
            x if isinstance(x, Fraction) else (id(x),)
            for key, x in zip(varied.keys, row, strict=True)
            if key.startswith("body.")
        )
        known = scene.body if same_body else bodies.get(of_body)
        body, omega, gamma, psi = scene_file.body_and_start(data, name, known)
        bodies[of_body] = body
        found.append(replace(bare, body=body, omega=omega, gamma=gamma, psi=psi, name=name))
    return tuple(found)


def label(name: str, varied: Grid, index: int) -> str:
    """How a member is called in messages."""
    row = zip(varied.keys, varied.rows[index], strict=True)
    return f"{name} member {index + 1} ({', '.join(f'{key} = {shown(x)}' for key, x in row)})"


def _column(key: str, given: Any, name: str) -> list[Exact]:
    if isinstance(given, str):
        return values(given, key, name)
    if not isinstance(given, Iterable):
        raise BadInput(name, key, plain(given), "a sequence of numbers, or FROM:TO:N")
    column = [_exact(x, key, name) for x in given]
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
