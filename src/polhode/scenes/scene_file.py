"""Scene files: TOML text to a Scene, every number exact, every fault one line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from polhode.common.errors import UNREADABLE, BadInput, nearest
from polhode.common.files import called, read_whole
from polhode.common.values import waiting
from polhode.numbers import expression
from polhode.numbers.exact import Exact, sign
from polhode.numbers.exact_sequences import ExactNumbers
from polhode.numbers.expression import ExpressionError
from polhode.numbers.vectors import Vector
from polhode.scenes import vocabulary
from polhode.scenes.body import Body
from polhode.scenes.body_and_start import body_of, start_of
from polhode.scenes.scene import (
    Event,
    Literal,
    Published,
    Scene,
    SceneTables,
    SectionPlan,
    even_times,
    is_int,
)
from polhode.scenes.vocabulary import (
    EXTREMA,
    FORMER_REFERENCES,
    READY_MADE,
    REFERENCES,
    SECTION,
    SECTIONS,
    STATE,
    column_names,
)

MAX_FILE = 100_000  # bytes
MAX_LINE = 10_000  # characters: a TOML key of thousands of parts costs quadratic time
#: Which verbs read JSON.
_JSON = "a result, as for polhode plot FILE, or a proof, as for polhode verify FILE"
#: What stands where TOML wants a value and is an expression, or a number with a unit.
_NUMBER = r"\d[\d.]*(?:e[+-]?\d+)?"
_BEGINNING = rf"{_NUMBER}\s*(?:[*/+^-]|[^\W\d_])|\.\d|\d+\.(?!\d)|\(|(?:pi|sqrt|sin|cos)\b"
_BARE = re.compile(rf"(?:^|[=\[,])\s*([+-]?(?:{_BEGINNING})[^=,\]}}#\"']*)(?=[=,\]}}#]|$)")


class SceneText(str):
    """The text of a scene file, and what the reader had of it.

    ``tables``: those of TOML, not to be written to.  ``values``: what became of them, by the
    scene's fields.  A scene that was changed since has the text still, and other values.
    """

    tables: dict[str, Any]
    values: dict[str, Any]

    @classmethod
    def of(cls, text: str, tables: dict[str, Any], values: dict[str, Any]) -> SceneText:
        """A text that was read."""
        read_text = cls(text)
        read_text.tables, read_text.values = tables, values
        return read_text

    def tells(self, scene: Scene, *fields: str) -> bool:
        """Whether these fields of a scene, by default all, are still what the text says."""
        names = fields or tuple(self.values)
        return all(
            (getattr(scene, name),) == (self.values[name],)  # of the same object without a look
            for name in names
        )


def read(path: Path, name: str | None = None) -> Scene:
    """The scene in a file, by that name or by the file's; raises BadInput, which tells the path."""
    if name is None:
        scene = read(path, str(path))
        return scene if scene.name == called(path) else replace(scene, name=called(path))
    return parse(text_of(path, name), name)


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
    if text and not isinstance(text, SceneText):
        text = parse(text, scene.name).source
        vars(scene)["_source"] = text  # threads that ask at once may each read it
    return text if isinstance(text, SceneText) else None


def tables_of(scene: Scene) -> dict[str, Any]:
    """The tables of body and start: those of the scene's file, if they still say what it is."""
    text = source_text(scene)
    if text is not None and text.tells(scene, "body", "omega", "gamma", "psi"):
        return {name: dict(text.tables[name]) for name in ("body", "start")}
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


def of_tables(data: dict[str, object], name: str, text: Callable[[], str]) -> Scene:
    """The scene in tables that were never a text; ``text`` writes them where it is wanted."""
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
    if any(len(line) > MAX_LINE for line in text.splitlines()):
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
        judged = self.table("reference", required=False)
        kind = self.read("reference", judged, "kind")
        if kind not in REFERENCES and kind not in (more := vocabulary.added_names()):
            expected = FORMER_REFERENCES.get(kind) or nearest(kind, [*REFERENCES, *more])
            raise self.bad("reference.kind", kind, expected)
        times = self.times(run)
        published = tuple(self.published(i, p) for i, p in enumerate(self.tables("published")))
        units = self.read("", data, "units")
        values: dict[str, Any] = {
            "body": body,
            "omega": omega,
            "gamma": gamma,
            "psi": psi,
            "times": times,
            "title": self.read("", data, "title"),
            "tags": self.read("", data, "tags"),
            "cite": self.read("", data, "cite"),
            "form": self.read("run", run, "form"),
            "outputs": self.read("run", run, "outputs"),
            "events": tuple(self.event(i, e) for i, e in enumerate(self.tables("events"))),
            "published": published,
            "reference": kind,
            "expect": self.expect(self.table("expect", required=False)),
            "section": self.section(self.table("section", required=False)),
            "units": units or ("SI" if self.in_si else ""),
        }
        source = SceneText.of(text, data, values) if isinstance(text, str) else waiting(text)
        return Scene(**values, name=self.name, source=source, change=self.change, doubt=self.doubt)

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
        return even_times(end, self.whole("run", run, "samples", 2))

    def event(self, index: int, table: Mapping[str, Any]) -> Event:
        """One of the tables [[events]]."""
        key = f"events[{index + 1}]"
        name = self.word(f"{key}.name", table.get("name", f"event {index + 1}"))
        if "zero" not in table and Event(name).needs_zero:
            words = nearest(name, [*READY_MADE, f"{SECTION}<expression>"])
            raise self.bad(f"{key}.zero", None, f"an expression, or one of the names {words}")
        zero = self.word(f"{key}.zero", table.get("zero", ""))
        direction, stop = (self.read("events", table, x, key) for x in ("direction", "stop"))
        return Event(name, zero, direction, stop)  # the scene checks what they say

    def published(self, index: int, table: Mapping[str, Any]) -> Published:
        """One of the tables [[published]]."""
        key = f"published[{index + 1}]"
        t, quantity, value, cite = (
            self.read("published", table, x, key) for x in ("t", "quantity", "value", "cite")
        )
        self.readable(f"{key}.quantity", quantity, (*STATE, *column_names()))
        try:
            expression.decimal(value)
        except ExpressionError as fault:
            raise self.bad(f"{key}.value", value, f"a decimal as printed ({fault})") from None
        right = table.get("right")
        if right is not None and (not is_int(right) or not 0 <= right <= 100):
            raise self.bad(f"{key}.right", right, "how many of its digits are right")
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

    def expect(self, table: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
        """Bands of digits by number type."""
        bands = {}
        for number, band in table.items():
            key = f"expect.{number}"
            least, most = (self.number(key, x) for x in self.array(key, band, 2))
            if not 0 <= least < most <= 10_000:
                raise self.bad(key, band, "the least and the most correct digits")
            bands[number] = (float(least), float(most))
        return bands
