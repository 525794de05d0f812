"""Scene files: TOML text to a Scene, every number exact, every fault one line."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from polhode.common.errors import BadInput, nearest, plain
from polhode.common.files import read_whole
from polhode.numbers import exact, expression
from polhode.numbers.exact import ONE, ZERO, Exact, sign
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import NAMES
from polhode.scenes.body import Body, Matrix, UnphysicalBody, Vector, diagonal, dot, scaled
from polhode.scenes.level import SIGNS, omega_on_level
from polhode.scenes.scene import Event, Published, Scene, SectionPlan, even_times
from polhode.scenes.words import (
    ANGLES,
    ATTITUDE,
    DIRECTIONS,
    EXTREMA,
    READY_MADE,
    REFERENCES,
    SECTION,
    SECTIONS,
    STATE,
)

MAX_FILE = 100_000  # bytes
MAX_LINE = 10_000  # characters: a TOML key of thousands of parts costs quadratic time
MAX_SAMPLES = 1_000_000

_SECTIONS: dict[str, tuple[str, ...]] = {
    "": (
        *("schema", "title", "tags", "cite", "body", "start", "run"),
        *("events", "published", "reference", "expect", "section"),
    ),
    "body": ("moments", "inertia", "centre", "weight"),
    "start": (
        *("omega", "momentum", "gamma", "normalise", "psi", "angles", "rates"),
        *("h", "f", "sign"),
    ),
    "run": ("end", "samples", "at", "form", "outputs"),
    "events": ("name", "zero", "direction", "stop"),
    "published": ("t", "quantity", "value", "cite", "right"),
    "reference": ("kind",),
    "section": ("by", "extremum", "crossings", "starts"),
    "expect": NAMES,
}


class _Literal(str):
    """A decimal of the file, digit for digit."""


def read(path: Path, name: str | None = None) -> Scene:
    """The scene in a file; raises BadInput."""
    name = name or str(path)
    found = read_whole(path, MAX_FILE, "a readable scene file", name)
    try:
        text = found.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise BadInput(name, "file", None, "a readable scene file (not UTF-8 text)") from None
    return parse(text, name)


def parse(text: str, name: str = "scene") -> Scene:
    """The scene in a TOML text; raises BadInput."""
    return _Reading(name, tables(text, name)).scene(text)


def body_and_start(
    data: dict[str, Any], name: str, body: Body | None = None
) -> tuple[Body, Vector, Vector | None, Exact]:
    """Body, omega, gamma and psi in the tables of a scene file; raises BadInput.

    ``body``: the body that the tables are known to hold, to spare reading it again.
    """
    reading = _Reading(name, data)
    if body is None:
        body = reading.body(reading.table("body"))
    return body, *reading.start(reading.table("start"), body)


def exact_value(value: Any, key: str, name: str) -> Exact:
    """The exact number that a value in a scene file's tables stands for; raises BadInput."""
    return _Reading(name, {}).number(key, value)


def tables(text: str, name: str = "scene") -> dict[str, Any]:
    """The tables of a TOML text, decimals kept digit for digit; raises BadInput."""
    if any(len(line) > MAX_LINE for line in text.splitlines()):
        raise BadInput(name, "file", None, f"lines of at most {MAX_LINE} characters")
    try:
        data: dict[str, Any] = tomllib.loads(text, parse_float=_Literal)
    except (ValueError, RecursionError) as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        reason = reason.partition(";")[0]  # Python's advice on too many digits is not for here
        raise BadInput(name, "file", None, f"TOML ({reason})") from None
    return data


class _Reading:
    """One file being read: typed access to its keys, faults named by key."""

    def __init__(self, name: str, data: dict[str, Any]) -> None:
        self.name, self.data = name, data

    def scene(self, text: str) -> Scene:
        data = self.data
        self.known("", data)
        if data.get("schema") != 1 or isinstance(data.get("schema"), bool):
            raise self.bad("schema", data.get("schema"), "1")
        body = self.body(self.table("body"))
        start = self.table("start")
        omega, gamma, psi = self.start(start, body)
        run = self.table("run", required=False)
        kind = self.word(
            "reference.kind", self.table("reference", required=False).get("kind", "auto")
        )
        if kind not in REFERENCES:
            raise self.bad("reference.kind", kind, nearest(kind, list(REFERENCES)))
        return Scene(
            body=body,
            omega=omega,
            gamma=gamma,
            psi=psi,
            times=self.times(run),
            name=self.name,
            title=self.word("title", data.get("title", "")),
            tags=self.words("tags", data.get("tags", [])),
            cite=self.words("cite", data.get("cite", [])),
            form=self.word("run.form", run.get("form", "principal")),
            outputs=self.words("run.outputs", run.get("outputs", [])),
            events=tuple(self.event(i, e) for i, e in enumerate(self.tables("events"))),
            published=tuple(self.published(i, p) for i, p in enumerate(self.tables("published"))),
            reference=kind,
            expect=self.expect(self.table("expect", required=False)),
            source=text,
            section=self.section(self.table("section", required=False)),
        )

    # -- sections -----------------------------------------------------------------------------

    def body(self, table: Mapping[str, Any]) -> Body:
        key, other = ("moments", "inertia") if "moments" in table else ("inertia", "moments")
        if key not in table:
            raise self.bad("body.moments", None, "moments = [A, B, C] or inertia = a 3 x 3 matrix")
        if other in table:
            raise self.bad(f"body.{other}", table[other], "only one of moments and inertia")
        if key == "moments":
            inertia = diagonal(self.vector("body.moments", table["moments"]))
        else:
            rows = self.array("body.inertia", table["inertia"], 3)
            a, b, c = (self.vector(f"body.inertia[{i + 1}]", row) for i, row in enumerate(rows))
            inertia = (a, b, c)
        centre = self.vector("body.centre", table["centre"]) if "centre" in table else _NOWHERE
        weight = self.number("body.weight", table.get("weight", 0))
        if "centre" not in table and sign(weight) != 0:
            raise self.bad("body.centre", None, "given, since weight is not 0")
        return self.physical(key, table[key], inertia, centre, weight)

    def physical(
        self, key: str, value: object, inertia: Matrix, centre: Vector, weight: Exact
    ) -> Body:
        try:
            return Body(inertia, centre, weight)
        except UnphysicalBody as fault:
            raise self.bad(f"body.{key}", value, fault.expected) from None

    def start(self, table: Mapping[str, Any], body: Body) -> tuple[Vector, Vector | None, Exact]:
        if "angles" in table or "rates" in table:
            return self.start_in_angles(table)
        if any(key in table for key in ("h", "f", "sign")):
            return self.start_on_level(table, body)
        if ("omega" in table) == ("momentum" in table):
            expected = "one of omega, momentum, h with f, or angles with rates"
            raise self.bad("start.omega", None, expected)
        if "omega" in table:
            omega = self.vector("start.omega", table["omega"])
        else:
            omega = body.omega(self.vector("start.momentum", table["momentum"]))
        if "gamma" in table or not body.torque_free:
            return omega, *self.vertical(table)
        for idle in ("psi", "normalise"):
            if idle in table:
                raise self.bad(f"start.{idle}", table[idle], "nothing without start.gamma")
        return omega, None, ZERO

    def start_on_level(self, table: Mapping[str, Any], body: Body) -> tuple[Vector, Vector, Exact]:
        for other in ("omega", "momentum"):
            if other in table:
                raise self.bad(f"start.{other}", table[other], "nothing beside h and f")
        for needed in ("h", "f"):
            if needed not in table:
                raise self.bad(f"start.{needed}", None, "a number, for a start on the level h, f")
        h, f = (self.number(f"start.{key}", table[key]) for key in ("h", "f"))
        side = self.word("start.sign", table.get("sign", SIGNS[0]))
        if side not in SIGNS:
            raise self.bad("start.sign", side, " or ".join(SIGNS))
        gamma, psi = self.vertical(table)
        return omega_on_level(body, gamma, h, f, side == SIGNS[0], self.name), gamma, psi

    def vertical(self, table: Mapping[str, Any]) -> tuple[Vector, Exact]:
        """Gamma, of length one, and psi."""
        psi = self.number("start.psi", table.get("psi", 0))
        normalise = table.get("normalise", False)
        if not isinstance(normalise, bool):
            raise self.bad("start.normalise", normalise, "true or false")
        if "gamma" not in table:
            expected = "given, since the weight has a moment"
            if "h" in table:
                expected = "given: a unit vector, for a start on the level h, f"
            raise self.bad("start.gamma", None, expected)
        gamma = self.vector("start.gamma", table["gamma"])
        square = dot(gamma, gamma)
        if square == 1:
            return gamma, psi
        shown = _as_written(table["gamma"])
        if not normalise:
            raise self.bad("start.gamma", shown, "length exactly 1, or normalise = true")
        if sign(square) == 0:
            raise self.bad("start.gamma", shown, "a vector that is not zero")
        return scaled(1 / exact.sqrt(square), gamma), psi

    def start_in_angles(self, table: Mapping[str, Any]) -> tuple[Vector, Vector, Exact]:
        for other in ("omega", "momentum", "gamma", "psi", "normalise", "h", "f", "sign"):
            if other in table:
                raise self.bad(f"start.{other}", table[other], "nothing beside angles and rates")
        for needed in ("angles", "rates"):
            if needed not in table:
                raise self.bad(f"start.{needed}", None, "three numbers (psi, theta, phi)")
        psi, theta, phi = self.vector("start.angles", table["angles"])
        psi_rate, theta_rate, phi_rate = self.vector("start.rates", table["rates"])
        try:
            sine, cosine = exact.sin(theta), exact.cos(theta)
            s, c = exact.sin(phi), exact.cos(phi)
        except ValueError as fault:
            shown = _as_written(table["angles"])
            raise self.bad("start.angles", shown, f"smaller angles ({fault})") from None
        if sign(sine) == 0:  # a pole: only psi ± phi has a meaning, and phi is counted as 0
            psi, phi = psi + phi * (1 if sign(cosine) > 0 else -1), ZERO
            s, c = ZERO, ONE
        gamma = (sine * s, sine * c, cosine)
        omega = (
            psi_rate * gamma[0] + theta_rate * c,
            psi_rate * gamma[1] - theta_rate * s,
            psi_rate * gamma[2] + phi_rate,
        )
        return omega, gamma, psi

    def times(self, run: Mapping[str, Any]) -> tuple[Exact, ...]:
        if "at" in run:
            for other in ("end", "samples"):
                if other in run:
                    raise self.bad(f"run.{other}", run[other], "nothing beside at")
            values = self.array("run.at", run["at"])
            if not values:
                raise self.bad("run.at", values, "at least one time")
            return tuple(self.number(f"run.at[{i + 1}]", t) for i, t in enumerate(values))
        if "end" not in run:
            if "samples" in run:
                raise self.bad("run.end", None, "given with samples")
            return ()
        end = self.number("run.end", run["end"])
        if sign(end) == 0:
            raise self.bad("run.end", run["end"], "a time other than 0")
        samples = run.get("samples", 2)
        if not _is_int(samples) or not 2 <= samples <= MAX_SAMPLES:
            raise self.bad("run.samples", samples, f"an integer from 2 to {MAX_SAMPLES}")
        return even_times(end, samples)

    def event(self, index: int, table: Mapping[str, Any]) -> Event:
        key = f"events[{index + 1}]"
        name = self.word(f"{key}.name", table.get("name", f"event {index + 1}"))
        if "zero" not in table and Event(name).needs_zero:
            known = nearest(name, [*READY_MADE, f"{SECTION}<expression>"])
            raise self.bad(f"{key}.zero", None, f"an expression, or one of the names {known}")
        if "zero" in table:
            zero = self.word(f"{key}.zero", table.get("zero"))
            self.readable(f"{key}.zero", zero, (*STATE, "t"))
        else:
            zero = ""
            if name.startswith(SECTION):
                self.readable(f"{key}.name", name.removeprefix(SECTION), (*STATE, "t"))
        direction = self.word(f"{key}.direction", table.get("direction", "any"))
        if direction not in DIRECTIONS:
            known = nearest(direction, [*DIRECTIONS])
            raise self.bad(f"{key}.direction", direction, known)
        stop = table.get("stop", False)
        if not isinstance(stop, bool):
            raise self.bad(f"{key}.stop", stop, "true or false")
        return Event(name, zero, direction, stop)

    def published(self, index: int, table: Mapping[str, Any]) -> Published:
        key = f"published[{index + 1}]"
        t = self.number(f"{key}.t", table.get("t"))
        quantity = self.word(f"{key}.quantity", table.get("quantity"))
        self.readable(f"{key}.quantity", quantity, (*STATE, *ANGLES, *ATTITUDE))
        value = self.word(f"{key}.value", table.get("value"))
        try:
            expression.decimal(value)
        except ExpressionError as fault:
            raise self.bad(f"{key}.value", value, f"a decimal as printed ({fault})") from None
        right = table.get("right")
        if right is not None and (not _is_int(right) or not 0 <= right <= 100):
            raise self.bad(f"{key}.right", right, "how many of its digits are right")
        return Published(t, quantity, value, self.word(f"{key}.cite", table.get("cite")), right)

    def section(self, table: Mapping[str, Any]) -> SectionPlan:
        plan = SectionPlan()
        by = self.word("section.by", table.get("by", plan.by))
        if by not in SECTIONS:
            self.readable("section.by", by, STATE)
        extremum = self.word("section.extremum", table.get("extremum", plan.extremum))
        if extremum not in EXTREMA:
            raise self.bad("section.extremum", extremum, nearest(extremum, [*EXTREMA]))
        crossings = table.get("crossings", plan.crossings)
        if not _is_int(crossings) or not 1 <= crossings <= MAX_SAMPLES:
            raise self.bad("section.crossings", crossings, f"an integer from 1 to {MAX_SAMPLES}")
        starts = tuple(
            self.row(f"section.starts[{k + 1}]", row)
            for k, row in enumerate(self.array("section.starts", table.get("starts", [])))
        )
        return SectionPlan(by, extremum, crossings, starts)

    def expect(self, table: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
        bands = {}
        for number, band in table.items():
            key = f"expect.{number}"
            least, most = (self.number(key, x) for x in self.array(key, band, 2))
            if not 0 <= least < most <= 10_000:
                raise self.bad(key, band, "the least and the most correct digits")
            bands[number] = (float(least), float(most))
        return bands

    # -- typed access -------------------------------------------------------------------------

    def bad(self, key: str, value: object, expected: str) -> BadInput:
        return BadInput(self.name, key, _as_written(value), expected)

    def known(self, section: str, table: Mapping[str, Any], where: str = "") -> None:
        allowed = list(_SECTIONS[section])
        for key, value in table.items():
            if key not in allowed:
                full = ".".join(filter(None, (where or section, key)))
                raise self.bad(full, value, f"one of the keys {nearest(key, allowed)}")

    def table(self, section: str, required: bool = True) -> Mapping[str, Any]:
        table = self.data.get(section)
        if table is None and not required:
            return {}
        if not isinstance(table, dict):
            raise self.bad(section, table, f"a table [{section}]")
        self.known(section, table)
        return table

    def tables(self, section: str) -> list[dict[str, Any]]:
        tables = self.data.get(section, [])
        if not isinstance(tables, list) or not all(isinstance(t, dict) for t in tables):
            raise self.bad(section, tables, f"tables [[{section}]]")
        for index, table in enumerate(tables):
            self.known(section, table, f"{section}[{index + 1}]")
        return tables

    def word(self, key: str, value: Any) -> str:
        if not isinstance(value, str) or isinstance(value, _Literal):
            raise self.bad(key, value, "a string")
        return value

    def words(self, key: str, value: Any) -> tuple[str, ...]:
        return tuple(self.word(key, item) for item in self.array(key, value))

    def array(self, key: str, value: Any, length: int | None = None) -> list[Any]:
        expected = "an array" if length is None else f"an array of {length} numbers"
        if not isinstance(value, list) or (length is not None and len(value) != length):
            raise self.bad(key, value, expected)
        return value

    def vector(self, key: str, value: Any) -> Vector:
        a, b, c = (self.number(key, item) for item in self.array(key, value, 3))
        return a, b, c

    def row(self, key: str, value: Any) -> tuple[Exact, ...]:
        return tuple(self.number(key, item) for item in self.array(key, value))

    def number(self, key: str, value: Any) -> Exact:
        try:
            if isinstance(value, _Literal):
                return expression.decimal(value)
            if _is_int(value):
                if abs(value).bit_length() > expression.MAX_BITS:
                    raise ExpressionError("too large")
                return Fraction(value)
            if isinstance(value, str):
                return expression.number(value)
            if isinstance(value, (Fraction, exact.Irrational)):  # a varied number
                return value
        except ExpressionError as fault:
            raise self.bad(key, value, f"a number ({fault})") from None
        raise self.bad(key, value, "a number")

    def readable(self, key: str, text: str, names: tuple[str, ...]) -> None:
        """Check an expression in named columns by computing it once with arbitrary values."""
        from polhode.scenes.columns import check

        try:
            check(text, names)
        except ExpressionError as fault:
            raise self.bad(key, text, f"an expression in {' '.join(names)} ({fault})") from None


_NOWHERE: Vector = (ZERO, ZERO, ZERO)


def _is_int(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _as_written(value: Any, depth: int = 4) -> Any:
    """A TOML value for an error message: as TOML, without quotes around decimals."""
    if isinstance(value, (list, dict)) and depth == 0:
        return "..."
    if isinstance(value, list):
        return "[" + ", ".join(_shown(item, depth) for item in value[:20]) + "]"
    if isinstance(value, dict):
        items = list(value.items())[:20]
        return "{" + ", ".join(f"{key} = {_shown(item, depth)}" for key, item in items) + "}"
    if isinstance(value, bool):
        return "true" if value else "false"
    return value


def _shown(item: Any, depth: int) -> str:
    return plain(_as_written(item, depth - 1))
