"""Scene files: TOML text to a Scene, every number exact, every fault one line; and back."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import fields, replace
from fractions import Fraction
from functools import cache
from itertools import starmap
from pathlib import Path
from typing import Any

from polhode.common.arguments import of_kind
from polhode.common.errors import UNREADABLE, BadInput, nearest, plain
from polhode.common.files import called, read_whole
from polhode.common.values import waiting
from polhode.numbers import expression
from polhode.numbers.conversion import ExactNumbers, exact_number, spaced
from polhode.numbers.decimals import in_full, is_decimal
from polhode.numbers.exact import ZERO, Exact, Irrational, sign
from polhode.numbers.expression import ExpressionError
from polhode.numbers.vectors import Vector
from polhode.scenes import vocabulary
from polhode.scenes.body import Body
from polhode.scenes.body_and_start import body_of, start_of
from polhode.scenes.scene import (
    MOTION_FIELDS,
    Event,
    Literal,
    Published,
    Scene,
    SceneTables,
    SceneText,
    SectionPlan,
)
from polhode.scenes.shapes import Part
from polhode.scenes.vocabulary import EXTREMA, READY_MADE, REFERENCES, SECTION, SECTIONS, STATE

MAX_FILE = 100_000  # bytes
MAX_LINE = 10_000  # characters: a TOML key of thousands of parts costs quadratic time
#: Which verbs read JSON.
_JSON = "a result, as for polhode plot FILE, or a proof, as for polhode verify FILE"
#: What stands where TOML wants a value and is an expression, or a number with a unit.
_NUMBER = r"\d[\d.]*(?:e[+-]?\d+)?"
_BEGINNING = rf"{_NUMBER}\s*(?:[*/+^-]|[^\W\d_])|\.\d|\d+\.(?!\d)|\(|(?:pi|sqrt|sin|cos)\b"
_BARE = re.compile(rf"(?:^|[=\[,])\s*([+-]?(?:{_BEGINNING})[^=,\]}}#\"']*)(?=[=,\]}}#]|$)")


def read(path: Path, name: str | None = None) -> Scene:
    """The scene in a file, by that name or by the file's; raises BadInput, which tells the path."""
    source = name or str(path)
    scene, own = parse(text_of(path, source), source), name or called(path)
    return scene if scene.name == own else replace(scene, name=own)


def text_of(path: Path, name: str) -> str:
    """A scene file's text; raises BadInput with that name."""
    content = read_whole(path, MAX_FILE, "a readable scene file", name)
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise BadInput(name, "file", None, "a readable scene file (not UTF-8 text)") from None


def parse(text: str, name: str = "scene") -> Scene:
    """The scene in a TOML text; raises BadInput."""
    return _File(name, tables(text, name)).scene(text)


def source_text(scene: Scene) -> SceneText | None:
    """A scene's text with what was read from it; None of a scene without; raises BadInput.

    A text that was given to the scene, or written from numbers, is read when this is first asked.
    """
    text = scene.source
    if text and not hasattr(text, "tables"):
        text = parse(text, scene.name).source
        vars(scene)["_source"] = text  # threads that ask at once may each read it
    return text if isinstance(text, SceneText) else None


def tables_of(scene: Scene) -> dict[str, Any]:
    """The tables of body and start: those of the scene's file, if they still say what it is."""
    text = source_text(scene)
    if text is not None and text.tells(scene, *MOTION_FIELDS):
        return {"body": dict(text.tables["body"]), "start": dict(text.tables["start"])}
    body, start = _values(scene.body, "body"), _values(scene, "start")
    if scene.gamma is None:
        del start["psi"]
    if scene.body.parts:  # of which inertia and centre are made
        del body["inertia"], body["centre"]
        body["parts"] = [_values(part, "body.parts") for part in scene.body.parts]
        if sign(scene.body.weight) == 0:
            body["g"] = body.pop("weight")
    elif not any(x != 0 for i, row in enumerate(body["inertia"]) for x in row[:i]):
        body["moments"] = [row[i] for i, row in enumerate(body.pop("inertia"))]
    return {"body": body, "start": start}


@cache
def held_keys(section: str, owner: type) -> tuple[str, ...]:
    """The keys of a section whose values an object has by the same names, tables left out.

    The reader and the writer go by this list.
    """
    names = {field.name for field in fields(owner) if field.init}
    tables = (vocabulary.TABLE, vocabulary.TABLES)
    keys = vocabulary.KEYS[section]
    return tuple(key.name for key in keys if key.name in names and key.kind not in tables)


def _values(owner: Scene | Body | Part, section: str) -> dict[str, Any]:
    """What an object has of a section's keys, in lists, as a table has it."""
    kind: type = type(owner)
    values: dict[str, Any] = {}
    for key in held_keys(section, kind):
        if (value := getattr(owner, key)) is not None:
            values[key] = _in_lists(value)
    return values


def _in_lists(value: Any) -> Any:
    return [*map(_in_lists, value)] if isinstance(value, tuple) else value


def of_tables(data: dict[str, Any], name: str, text: str | Callable[[], str]) -> Scene:
    """The scene in the tables of a text, or of one that a function writes where it is wanted."""
    return _File(name, data).scene(text)


def body_and_start(
    data: dict[str, Any], name: str, body: Body | None = None
) -> tuple[Body, Vector, Vector | None, Exact, str]:
    """Body, omega, gamma and psi in the tables of a scene file, and what was changed of the start.

    Raises BadInput.

    ``body``: the body that the tables are known to hold, to spare reading it again.
    """
    reading = SceneTables(name, data)
    if body is None:
        body = body_of(reading, reading.table("body"))
    omega, gamma, psi = start_of(reading, reading.table("start"), body)
    return body, omega, gamma, psi, reading.change


def exact_value(value: object, key: str, name: str) -> Exact:
    """The exact number that a value in a scene file's tables stands for; raises BadInput."""
    return SceneTables(name, {}).number(key, value)


def tables(text: str, name: str = "scene") -> dict[str, Any]:
    """The tables of a TOML text, decimals kept digit for digit; raises BadInput."""
    if max(map(len, text.splitlines()), default=0) > MAX_LINE:
        raise BadInput(name, "file", None, f"lines of at most {MAX_LINE} characters")
    if text.lstrip().startswith("{"):
        raise BadInput(name, "file", None, f"a scene file (TOML): this is JSON: {_JSON}")
    try:
        data: dict[str, Any] = tomllib.loads(text, parse_float=Literal)
    except UNREADABLE as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        reason = reason.partition(";")[0]  # Python's advice on too many digits is not for here
        _refuse_bare_expression(text, name, reason)
        raise BadInput(name, "file", None, f"TOML ({reason})") from None
    return data


def _refuse_bare_expression(text: str, name: str, reason: str) -> None:
    """Raise BadInput where TOML stopped at an expression without quotes, such as 1/3 or 5 cm."""
    place = re.search(r"\(at line (\d+), column (\d+)\)", reason)
    line = text.split("\n")[int(place[1]) - 1] if place else ""
    for bare in _BARE.finditer(line):
        if place and bare.start(1) < int(place[2]) <= bare.end(1) + 1:  # not in a string, a comment
            key, value = re.match(r"\s*([\w.]+)\s*=", line), bare[1].strip()
            expected = f'it in quotes, as every expression and number with a unit: "{value}"'
            raise BadInput(name, key[1] if key else f"line {place[1]}", value, expected)


class _File(SceneTables):
    """A scene file being read."""

    def scene(self, text: str | Callable[[], str]) -> Scene:
        """The scene of the file with this text, or with one that a function writes."""
        data = self.data
        self.refuse_unknown("", data)
        if data.get("schema") != 1 or isinstance(data.get("schema"), bool):
            raise self.bad("schema", data.get("schema"), "1")
        body = body_of(self, self.table("body"))
        omega, gamma, psi = start_of(self, self.table("start"), body)
        run = self.table("run", required=False)
        plan = self.table("section", required=False)
        kind = self.read("reference", self.table("reference", required=False), "kind")
        if kind not in REFERENCES and kind not in (more := vocabulary.added_names()):
            expected = vocabulary.FORMER_REFERENCES.get(kind) or nearest(kind, [*REFERENCES, *more])
            raise self.bad("reference.kind", kind, expected)
        values: dict[str, Any] = {
            **{"body": body, "omega": omega, "gamma": gamma, "psi": psi, "times": self.times(run)},
            "events": tuple(starmap(self.event, self.tables("events"))),
            "published": tuple(starmap(self.published, self.tables("published"))),
            "reference": kind,
            "expect": self.expect(self.table("expect", required=False)),
            "section": self.section(plan) if plan else SectionPlan(),
        }
        for section, table in (("", data), ("run", run)):
            for key in held_keys(section, Scene):
                values[key] = self.read(section, table, key)
        values["units"] = values["units"] or ("SI" if self.in_si else "")

        def source() -> SceneText:
            scene_text = SceneText(text if isinstance(text, str) else text())
            scene_text.values = values
            if isinstance(text, str):  # the tables of another are read when they are asked for
                scene_text.tables = data
            return scene_text

        return Scene(
            **values,
            name=self.name,
            source=source() if isinstance(text, str) else waiting(source),
            change=self.change,
            doubt=self.doubt,
        )

    # -- sections -----------------------------------------------------------------------------

    def times(self, run: Mapping[str, Any]) -> Sequence[Exact]:
        """The output times of a table [run]."""
        if "at" in run:
            self.alone("run", run, ("end", "samples"), "no value together with at")
            values = self.array("run.at", run["at"])
            if not values:
                raise self.bad("run.at", values, "at least one time")
            return ExactNumbers(
                tuple(self.number(f"run.at[{i + 1}]", t) for i, t in enumerate(values))
            )
        if "end" not in run:
            if "samples" in run:
                raise self.bad("run.end", None, "a time, with samples")
            return ()
        end = self.number("run.end", run["end"])
        if sign(end) == 0:
            raise self.bad("run.end", run["end"], "a time other than 0")
        return spaced(ZERO, end, self.whole("run", run, "samples", 2))

    def event(self, where: str, table: Mapping[str, Any]) -> Event:
        """One of the tables [[events]]."""
        _, _, number = where.strip("]").partition("[")
        whole = {"name": f"event {number}", "zero": "", **table}
        event = Event(**{key: self.read("events", whole, key, where) for key in Event._fields})
        if "zero" not in table and event.needs_zero:
            words = nearest(event.name, [*READY_MADE, f"{SECTION}<expression>"])
            raise self.bad(f"{where}.zero", None, f"an expression, or one of the names {words}")
        return event  # the scene checks what it says

    def published(self, where: str, table: Mapping[str, Any]) -> Published:
        """One of the tables [[published]]."""
        t, quantity, value, cite = (
            self.read("published", table, key, where) for key in ("t", "quantity", "value", "cite")
        )
        self.readable(f"{where}.quantity", quantity, (*STATE, *vocabulary.column_names()))
        try:
            expression.decimal(value)
        except ExpressionError as fault:
            raise self.bad(f"{where}.value", value, f"a decimal as printed ({fault})") from None
        right = table.get("right")
        if right is not None and (type(right) is not int or not 0 <= right <= 100):
            raise self.bad(f"{where}.right", right, "how many of its digits are right")
        return Published(t, quantity, value, cite, right)

    def section(self, table: Mapping[str, Any]) -> SectionPlan:
        """How the level is cut, of a table [section]."""
        by, extremum = (self.read("section", table, x) for x in ("by", "extremum"))
        if by not in SECTIONS:
            self.readable("section.by", by, STATE)
        if extremum not in EXTREMA:
            raise self.bad("section.extremum", extremum, nearest(extremum, [*EXTREMA]))
        crossings = self.whole("section", table, "crossings", 1)
        starts = []
        for k, row in enumerate(self.array("section.starts", table.get("starts", []))):
            key = f"section.starts[{k + 1}]"
            starts.append(tuple(self.number(key, item) for item in self.array(key, row)))
        return SectionPlan(by, extremum, crossings, tuple(starts))

    def readable(self, key: str, text: str, names: tuple[str, ...]) -> None:
        """Check an expression in named columns by computing it once with arbitrary values."""
        try:
            vocabulary.check(text, names)
        except ExpressionError as fault:
            raise self.bad(key, text, f"an expression in {' '.join(names)} ({fault})") from None

    def expect(self, table: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
        """Bands of digits by number type."""
        bands = {}
        for number_type, band in table.items():
            key = f"expect.{number_type}"
            low, high = self.array(key, band, 2)
            least, most = self.number(key, low), self.number(key, high)
            if not 0 <= least < most <= 10_000:
                raise self.bad(key, band, "the least and the most correct digits")
            bands[number_type] = (float(least), float(most))
        return bands


# --- scene text -----------------------------------------------------------------------------------
#
# A scene as the text of a scene file: every number in full, so that reading it gives it back.


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
    text = source_text(scene)
    if text is not None and text.tells(scene):
        return str(text)
    data = _values(scene, "") | tables_of(scene)
    data["run"] = _values(scene, "run") | _times(scene)
    data["section"] = scene.section._asdict()
    data["events"] = [event.table for event in scene.events]
    data["published"] = [figure._asdict() for figure in scene.published]
    data["reference"] = {"kind": scene.reference}
    data["expect"] = {  # doubles that were read from decimals as short as these
        name: [*map(Fraction, map(repr, band))] for name, band in scene.expect.items()
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
        if len(value) > MAX_LINE or _SURROGATE.search(value):
            raise BadInput(name, key, value, f"a text of at most {MAX_LINE} whole characters")
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
        tabled = key.kind in (vocabulary.TABLE, vocabulary.TABLES)
        if value is None or tabled or key.name == "schema":
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
    """A text as TOML writes it: as JSON, which leaves one more control character as it is."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _flat(value: Any) -> Iterable[Any]:
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from _flat(item)
    else:
        yield value


def _short(x: float) -> bool:
    """Whether a double is just the decimal that Python prints for it."""
    return Fraction(repr(x)) == Fraction(x)


def _times(scene: Scene) -> dict[str, Any]:
    """The file's own words for the times; end and samples where they are even; else the times."""
    times, count = scene.times, len(scene.times)
    text = source_text(scene)
    if text is not None and text.tells(scene, "times"):
        written_there = text.tables.get("run", {})
        return {key: written_there[key] for key in _OF_TIMES if key in written_there}
    if not times:
        return {}
    even = count > 1 and times[0] == 0
    if even and all(t == scene.end * Fraction(k, count - 1) for k, t in enumerate(times)):
        return {"end": scene.end, "samples": count}
    return {"at": list(times)}
