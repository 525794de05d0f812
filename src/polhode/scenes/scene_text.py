"""A scene as the text of a scene file: every number in full, so that reading it gives it back."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence, Set
from fractions import Fraction
from typing import Any

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, plain
from polhode.numbers.conversion import exact_number
from polhode.numbers.decimals import in_full, is_decimal
from polhode.numbers.exact import Exact, Irrational
from polhode.scenes import scene_file, vocabulary
from polhode.scenes.scene import Literal, Scene

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
    text = scene_file.source_text(scene)
    if text is not None and text.tells(scene):
        return str(text)
    data: dict[str, Any] = {key: _plainly(getattr(scene, key)) for key in _TITLES}
    data |= scene_file.tables_of(scene)
    data["run"] = {"form": scene.form, "outputs": list(scene.outputs)} | _times(scene)
    data["section"] = scene.section._asdict()
    data["events"] = [event.table for event in scene.events]
    data["published"] = [figure._asdict() for figure in scene.published]
    data["reference"] = {"kind": scene.reference}
    data["expect"] = {  # doubles that were read from decimals as short as these
        name: [Fraction(repr(x)) for x in band] for name, band in scene.expect.items()
    }
    return written(data, scene.name)


def written(data: Mapping[str, Any], name: str) -> str:
    """The tables of a scene as TOML; what has its default is left out; raises BadInput."""
    lines = ["schema = 1", *_lines("", data, name)]
    for section in ("body", "start", "run", "section", "reference", "expect"):
        table = data.get(section, {})
        body_lines = list(_lines(section, table, name))
        if body_lines or section in ("body", "start"):
            lines += ["", f"[{section}]", *body_lines]
        if section == "body":
            for part in table.get("parts", ()):
                lines += ["", "[[body.parts]]", *_lines("body.parts", part, name)]
    for section in ("events", "published"):
        for table in data.get(section, ()):
            lines += ["", f"[[{section}]]", *_lines(section, table, name)]
    return "\n".join(lines) + "\n"


def owned(value: Any, name: str, key: str = "") -> Any:
    """A value given in Python as a file holds it, which no change of what was given reaches.

    Lists, arrays and tables are copied, what is None in a table is left out; floats stay floats.
    Raises BadInput for what no file can hold.
    """
    if hasattr(value, "tolist"):  # numpy's arrays and numbers
        value = value.tolist()
    if value is None:
        raise BadInput(name, key, "None", "a value")
    if isinstance(value, (bool, int, float)):
        return value
    if isinstance(value, str):
        if len(value) > scene_file.MAX_LINE or _SURROGATE.search(value):
            expected = f"a text of at most {scene_file.MAX_LINE} whole characters"
            raise BadInput(name, key, value, expected)
        return str(value)
    if isinstance(value, Mapping):
        each = ((word, x) for word, x in value.items() if x is not None)
        return {word: owned(x, name, f"{key}.{word}".lstrip(".")) for word, x in each}
    if isinstance(value, Iterable) and not isinstance(value, (bytes, Set)):  # a set has no order
        listed = enumerate(value, 1)
        return [owned(x, name, f"{key}[{k}]" if isinstance(x, Mapping) else key) for k, x in listed]
    if not hasattr(value, "__float__"):
        return value  # refused by who reads it
    try:
        x = exact_number(value)
    except ValueError as fault:
        raise BadInput(name, key, plain(value), f"a number ({fault})") from None
    return _finite(x, name, key)


def _finite(x: Exact, name: str, key: str) -> int | Fraction | str:
    """A number that a file can hold: a decimal, or a fraction as text; raises BadInput."""
    if isinstance(x, Irrational):
        expected = "a number with finitely many digits, or its expression as text"
        raise BadInput(name, key, float(x), expected)
    if x.denominator == 1:
        return x.numerator
    return x if is_decimal(x) else in_full(x)


def _lines(section: str, table: Mapping[str, Any], name: str) -> Iterable[str]:
    for key in vocabulary.KEYS[section]:
        value = table.get(key.name)
        if (
            value is None
            or key.kind in (vocabulary.TABLE, vocabulary.TABLES)
            or key.name == "schema"
        ):
            continue
        text = _text(value, name, f"{section}.{key.name}".lstrip("."))
        if text == key.default:
            continue
        floats = [x for x in _flat(value) if isinstance(x, float) and not _short(x)]
        doubles = ", ".join(map(repr, floats[:3])) + ", ..." * (len(floats) > 3)
        yield f"{key.name} = {text}" + (f"  # the doubles {doubles} in full" if floats else "")


def _text(value: Any, name: str, key: str) -> str:
    """One value as TOML text: numbers in full, texts quoted."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Literal):
        return str(value)
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, (list, tuple)):
        items = [_text(x, name, key) for x in value]
        many = sum(map(len, items)) > 1000
        return "[\n  " + ",\n  ".join(items) + ",\n]" if many else f"[{', '.join(items)}]"
    number = _finite(exact_number(value), name, key)
    return json.dumps(number) if isinstance(number, str) else in_full(Fraction(number))


def _quoted(text: str) -> str:
    """A text as TOML writes it: to it JSON's two halves of one character are none."""
    if text.isascii() or max(text) < "\U00010000":
        return json.dumps(text)
    return f'"{"".join(map(_escaped, text))}"'


def _escaped(x: str) -> str:
    return json.dumps(x)[1:-1] if x < "\U00010000" else f"\\U{ord(x):08x}"


def _flat(value: Any) -> Iterable[Any]:
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from _flat(item)
    else:
        yield value


def _short(x: float) -> bool:
    """Whether a double is just the decimal that Python prints for it."""
    return Fraction(repr(x)) == Fraction(x)


def _plainly(value: str | Sequence[str]) -> Any:
    return value if isinstance(value, str) else list(value)


def _times(scene: Scene) -> dict[str, Any]:
    """The file's own words for the times; end and samples where they are even; else the times."""
    times, count = scene.times, len(scene.times)
    text = scene_file.source_text(scene)
    if text is not None and text.tells(scene, "times"):
        written_there = text.tables.get("run", {})
        return {key: written_there[key] for key in _OF_TIMES if key in written_there}
    if not times:
        return {}
    even = count > 1 and times[0] == 0
    if even and all(t == scene.end * Fraction(k, count - 1) for k, t in enumerate(times)):
        return {"end": scene.end, "samples": count}
    return {"at": list(times)}
