"""A scene as the text of a scene file: every number in full, so that reading it gives it back."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence, Set
from fractions import Fraction
from typing import Any, TypeGuard

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, nearest, plain
from polhode.numbers.conversion import exact_number
from polhode.numbers.decimals import in_full, is_decimal
from polhode.numbers.exact import Irrational
from polhode.scenes import keys, scene_file
from polhode.scenes.body import MATRIX
from polhode.scenes.event import Event
from polhode.scenes.scene import Published, Scene
from polhode.scenes.shapes import Part
from polhode.scenes.validation import Literal
from polhode.scenes.variation.sweep_scenes import tables_of

_TITLES = ("title", "tags", "cite", "units")
_OF_TIMES = ("end", "samples", "at")

#: A half of a character that stands alone, which no text in a file can hold.
_SURROGATE = re.compile("[\ud800-\udfff]")


def as_toml(scene: Scene) -> str:
    """Write a scene as the text of a file that holds it exactly.

    It is the file's own text if the scene was not changed since; body and start are written as they
    were given.

    Parameters
    ----------
    scene : Scene
        The scene; its numbers rational, or the expressions that they were read from.

    Returns
    -------
    str
        A scene file in TOML: ``polhode.load`` of it gives an equal scene.

    Raises
    ------
    BadInput
        A scene that no file can hold.

    Examples
    --------
    >>> import polhode
    >>> text = polhode.as_toml(polhode.top(moments=[2, 2, 1], omega=[0.5, 0, 3], end=10))
    >>> print(text)
    schema = 1
    <BLANKLINE>
    [body]
    moments = [2, 2, 1]
    <BLANKLINE>
    [start]
    omega = [0.5, 0, 3]
    <BLANKLINE>
    [run]
    end = 10
    <BLANKLINE>
    """
    of_kind("as_toml", "scene", scene, Scene, "a Scene")
    if scene.source and scene_file.parse(scene.source, scene.name) == scene:
        return scene.source
    data: dict[str, Any] = {key: _plainly(getattr(scene, key)) for key in _TITLES}
    data |= tables_of(scene)
    data["run"] = {"form": scene.form, "outputs": list(scene.outputs)} | _times(scene)
    data["section"] = scene.section._asdict()
    data["events"] = [_event(event) for event in scene.events]
    data["published"] = [_published(figure) for figure in scene.published]
    data["reference"] = {"kind": scene.reference}
    data["expect"] = {name: list(band) for name, band in scene.expect.items()}
    return written(data, scene.name)


def written(data: Mapping[str, Any], name: str) -> str:
    """The tables of a scene as TOML; what has its default is left out; raises BadInput."""
    lines = ["schema = 1", *_lines("", data, name)]
    for section in ("body", "start", "run", "section", "reference", "expect"):
        table = data.get(section, {})
        told = list(_lines(section, table, name))
        if told or section in ("body", "start"):
            lines += ["", f"[{section}]", *told]
        if section == "body":
            for k, part in enumerate(table.get("parts", ())):
                given = _fields(part, name, k)
                lines += ["", "[[body.parts]]", *_lines("body.parts", given, name)]
    for section in ("events", "published"):
        for table in data.get(section, ()):
            lines += ["", f"[[{section}]]", *_lines(section, table, name)]
    return "\n".join(lines) + "\n"


def owned(value: Any) -> Any:
    """A value for later: lists, arrays and tables copied, which whoever gave them may change."""
    if isinstance(value, (str, bytes, int, float)):
        return value
    if isinstance(value, Mapping):
        return {key: owned(x) for key, x in value.items()}
    if hasattr(value, "getA1"):  # numpy's matrix, whose rows are matrices again
        return value.tolist()
    if _several(value):
        return [owned(x) for x in value]
    return value[()] if getattr(value, "ndim", None) == 0 else value


def as_read(data: Mapping[str, Any], name: str) -> dict[str, object]:
    """The tables that a reader of :func:`written` gets, without the way over a text.

    What has its default is not left out.  Raises BadInput.
    """
    found = {"schema": 1} | _held("", data, name)
    for section in ("body", "start", "run", "reference"):
        table = _held(section, data.get(section, {}), name)
        if section == "body" and data["body"].get("parts"):
            parts = [_fields(part, name, k) for k, part in enumerate(data["body"]["parts"])]
            table["parts"] = [_held("body.parts", part, name) for part in parts]
        found[section] = table
    found["events"] = [_held("events", event, name) for event in data.get("events", ())]
    return found


def _held(section: str, table: Mapping[str, object], name: str) -> dict[str, object]:
    found: dict[str, object] = {}
    for key in keys.KEYS[section]:
        value = table.get(key.name)
        if value is None or key.kind in (keys.TABLE, keys.TABLES) or key.name == "schema":
            continue
        full = f"{section}.{key.name}".lstrip(".")
        found[key.name] = _Value(name, full, key.kind in (keys.WORD, keys.WORDS)).held(value)
    return found


def _lines(section: str, table: Mapping[str, Any], name: str) -> Iterable[str]:
    for key in keys.KEYS[section]:
        value = table.get(key.name)
        if value is None or key.kind in (keys.TABLE, keys.TABLES) or key.name == "schema":
            continue
        full = f"{section}.{key.name}".lstrip(".")
        held = _Value(name, full, key.kind in (keys.WORD, keys.WORDS)).text(value)
        if held == key.default:
            continue
        floats = [x for x in _flat(value) if isinstance(x, float) and not _short(x)]
        told = ", ".join(repr(float(x)) for x in floats[:3]) + ", ..." * (len(floats) > 3)
        yield f"{key.name} = {held}" + (f"  # the doubles {told} in full" if floats else "")


class _Value:
    """One value as TOML text: numbers in full, texts quoted."""

    def __init__(self, name: str, key: str, words: bool) -> None:
        self.name, self.key, self.words = name, key, words

    def text(self, value: object) -> str:
        if type(value).__name__ in ("bool", "bool_"):
            return "true" if value else "false"
        if isinstance(value, Literal):
            return str(value)
        if isinstance(value, str):
            return _quoted(value)
        if _several(value):
            items = [self.text(x) for x in value]
            many = sum(map(len, items)) > 1000
            return "[\n  " + ",\n  ".join(items) + ",\n]" if many else f"[{', '.join(items)}]"
        if self.words:
            raise BadInput(self.name, self.key, plain(value), "a text")
        if isinstance(value, Mapping) and self.key == "body.inertia":
            raise BadInput(self.name, self.key, plain(value), MATRIX)
        return self.number(value)

    def held(self, value: object) -> object:
        """What a reader of the text gets."""
        if isinstance(value, (Literal, bool)):
            return value
        if isinstance(value, str):
            return str(value) if _plain(value) else self._read(value)
        if type(value) is int and not self.words:
            return value
        if isinstance(value, float) and not self.words:
            return exact_number(value)
        if _several(value):
            return [self.held(x) for x in value]
        whole = hasattr(value, "__index__") or type(value).__name__ == "bool_"
        if self.words or whole or isinstance(value, Mapping):
            return self._read(value)
        found = self.exactly(value)
        return found if is_decimal(found) else self._read(value)

    def _read(self, value: object) -> object:
        return scene_file.tables(f"x = {self.text(value)}", self.name)["x"]

    def exactly(self, value: object) -> Fraction:
        try:
            x = exact_number(value)
        except ValueError as fault:
            raise BadInput(self.name, self.key, plain(value), f"a number ({fault})") from None
        if isinstance(x, Irrational):
            expected = "a number with finitely many digits, or its expression as text"
            raise BadInput(self.name, self.key, float(x), expected)
        return x

    def number(self, value: object) -> str:
        x = self.exactly(value)
        return in_full(x) if is_decimal(x) else json.dumps(in_full(x))


def _plain(text: str) -> bool:
    """Whether a text is surely read as it was written."""
    return len(text) < 1000 and (text.isascii() or not _SURROGATE.search(text))


def _quoted(text: str) -> str:
    """A text as TOML writes it: to it JSON's two halves of one character are none."""
    if text.isascii() or max(text) < "\U00010000":
        return json.dumps(text)
    return f'"{"".join(map(_escaped, text))}"'


def _escaped(x: str) -> str:
    return json.dumps(x)[1:-1] if x < "\U00010000" else f"\\U{ord(x):08x}"


def _several(value: object) -> TypeGuard[Iterable[object]]:
    """Whether a value is a list of values; an array of no dimension is a number, a set no list."""
    if isinstance(value, (list, tuple)):  # the question after Iterable takes ten times as long
        return True
    listed = isinstance(value, Iterable) and not isinstance(value, (str, bytes, Mapping, Set))
    return listed and getattr(value, "ndim", 1) > 0


def _flat(value: Any) -> Iterable[Any]:
    if _several(value):
        for item in value:
            yield from _flat(item)
    else:
        yield value


def _short(x: float) -> bool:
    """Whether a double is just the decimal that Python prints for it."""
    return Fraction(repr(float(x))) == Fraction(float(x))


def _fields(part: object, name: str, index: int) -> Mapping[str, Any]:
    """A part's keys: of a Part those that were given; of a mapping its own, all known."""
    if isinstance(part, Part):
        return {key.name: getattr(part, key.name) for key in keys.KEYS["body.parts"]}
    if not isinstance(part, Mapping):
        raise BadInput(name, f"body.parts[{index + 1}]", plain(part), "a Part, or a mapping")
    _known("body.parts", part, name, f"body.parts[{index + 1}]")
    return part


def _known(section: str, table: Mapping[str, Any], name: str, where: str) -> None:
    for key in table:
        if key not in keys.names(section):
            expected = f"one of the keys {nearest(key, keys.names(section))}"
            raise BadInput(name, f"{where}.{key}", plain(table[key]), expected)


def _plainly(value: str | Sequence[str]) -> Any:
    return value if isinstance(value, str) else list(value)


def _times(scene: Scene) -> dict[str, Any]:
    """The file's own words for the times; end and samples where they are even; else the times."""
    times, count = scene.times, len(scene.times)
    if scene.source:
        written_there = scene_file.tables(scene.source, scene.name).get("run", {})
        if scene_file.times_of(written_there, scene.name) == times:
            return {key: written_there[key] for key in _OF_TIMES if key in written_there}
    if not times:
        return {}
    even = count > 1 and times[0] == 0
    if even and all(t == scene.end * Fraction(k, count - 1) for k, t in enumerate(times)):
        return {"end": scene.end, "samples": count}
    return {"at": list(times)}


def _event(event: Event) -> dict[str, Any]:
    return event._asdict() | {"zero": event.zero or None}


def _published(figure: Published) -> dict[str, Any]:
    return figure._asdict()
