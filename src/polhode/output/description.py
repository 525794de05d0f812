"""What a scene is: body, regime, integrals, frequencies, and what a run of it will model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from polhode.closed_forms.families import near
from polhode.common.errors import BadInput, one_line
from polhode.common.interrupts import TooLong, within
from polhode.common.texts import JsonObject
from polhode.common.values import ByValue
from polhode.equations import readout
from polhode.equations.form import equations, source
from polhode.judging.reference import Reference
from polhode.judging.reference import reference as reference_of
from polhode.numbers import number_types
from polhode.numbers.decimals import shown, strings
from polhode.numbers.number_types import NumberType, Real
from polhode.results.cells import TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library
from polhode.scenes.body import kind_of_body
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, unit_of
from polhode.scenes.vocabulary import COLUMNS, REQUESTS

SECONDS = 1.0  # that frequencies may take
_BOOK = "Yehia, Rigid Body Dynamics: A Lagrangian Approach"
_IN_FULL = {"period": "period of omega"}  # in the body


@dataclass(frozen=True, repr=False, eq=False)
class Description(Result, ByValue):
    """What a scene is; ``described``: the facts of :func:`described`."""

    scene: Scene
    described: Mapping[str, Any]

    def __repr__(self) -> str:
        return f"<Description of {self.scene.name}: {one_line(self.scene.title)}>"

    def __str__(self) -> str:
        return "\n".join(
            f"{key:<14}{one_line(_in_words(key, value))}"
            for key, value in self.described.items()
            if value not in (None, "", [])
        )

    def table(self) -> Table:
        """A row for each column that a run of the scene gives: its name and unit."""
        names = self.described["columns"]
        units = [unit_of(self.scene, name) for name in names]
        return Table([Column("column", names, type=TEXT), Column("unit", units, type=TEXT)])

    def facts(self) -> list[Fact]:
        """All that is told but the columns; decimals are texts of 17 digits or all that there are.

        The title is ``scene_title``: every file of a result has a ``title`` of its own.
        """
        named = {"title": "scene_title"}
        values = {named.get(key, key): x for key, x in self.described.items()}
        values |= values.pop("integrals")
        if "axes" in values:
            values["axes"] = dict(zip("123", values["axes"], strict=True))
        return [
            *scene_facts(self.scene),
            *(Fact(key, x) for key, x in values.items() if key not in ("scene", "columns")),
            provenance_fact(self.scene.provenance()),
        ]


def describe(scene: Scene | str | Path) -> Description:
    """Tell body, regime, integrals, frequencies, columns to be integrated.

    Parameters
    ----------
    scene : Scene, str or Path
        A case that ships, or a path.
    """
    scene = library.load(scene, takes=REQUESTS)
    return Description(scene, described(scene))


def _in_words(key: str, value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{_IN_FULL.get(k, k)} = {v}" for k, v in value.items() if v is not None)
    if isinstance(value, list):
        rows = (f"[{', '.join(x)}]" if isinstance(x, list) else str(x) for x in value)
        return ", ".join(rows)
    return f"{_BOOK}, {value}" if key == "source" else str(value)


def described(scene: Scene) -> JsonObject:
    """The facts about a scene by name, decimals as texts."""
    reference = reference_of(scene)
    body = scene.body
    values = scene.integrals
    facts: JsonObject = {
        "scene": scene.name,
        "title": scene.title,
        "tags": list(scene.tags),
        "cite": list(scene.cite),
        "body": kind_of_body(body),
        "regime": reference.regime,
        "reference": reference.kind,
        "moments": [shown(x) for x in body.moments],
        "torque": [shown(x) for x in body.torque],
    }
    if scene.units:
        facts["units"] = scene.units
    if not body.axes.trivial:
        facts["axes"] = [[shown(x) for x in row] for row in body.axes.rows]
    facts["integrals"] = {"h": shown(values.energy)}
    if values.area is not None:
        facts["integrals"] |= {"f": shown(values.area)}
    if reference.is_closed_form:
        if reference.conditions:
            facts["conditions"] = list(reference.conditions)
        facts |= _frequencies(reference)
    facts |= _near(scene)
    if (still := readout.name(scene)) is not None:
        facts["motion"] = f"{still}: the state is constant"
    facts |= {
        "form": scene.form,
        "source": source(scene.form),
        "variables": list(equations(scene).variables),
        "columns": _columns(scene),
        "coefficients": sorted(equations(scene).coefficients),
        "times": len(scene.times),
        "end": shown(scene.end),
        "time_unit": f"2**{equations(scene).frame.exponent}",
    }
    return facts


def _columns(scene: Scene) -> list[str]:
    """All columns that a run of the scene gives."""
    names_of_outputs = (column.names for word, column in COLUMNS.items() if word in scene.outputs)
    return [*scene.columns, *(name for names in names_of_outputs for name in names)]


def _near(scene: Scene) -> JsonObject:
    """Families that the scene is near to, and the condition that fails."""
    lines = [f"{name}: {missed}" for name, missed in near(scene)]
    return {"near": lines} if lines else {}


def _frequencies(reference: Reference) -> JsonObject:
    """Period, frequencies and curve, as far as they are to be had in a moment."""
    texts: JsonObject = {}
    try:
        with within(SECONDS):
            texts["frequencies"] = frequencies(reference)
            if reference.rates_of:
                texts["rates_of"] = reference.rates_of
            if reference.curve is not None:
                texts["curve"] = _curve(reference.curve)
            if (rate := reference.approach) is not None:
                fall = f"differences fall as exp(-{float(rate):.6g} t)"
                texts["tends"] = f"to a periodic motion, {fall}"
    except TooLong:
        texts["not_told"] = f"frequencies take longer than {SECONDS:g} s here"
    except BadInput as fault:
        texts["not_told"] = f"frequencies are not known here: {fault.expected}"
    return texts


def frequencies(reference: Reference, digits: int = 17) -> dict[str, str | None]:
    """Period and frequencies of a reference as decimal strings."""
    number = NumberType("mp", number_types.bits_for(digits))
    rates: dict[str, Real | None] = {"period": reference.period, **reference.frequencies}
    return {
        name: None if value is None else strings([[value]], number)[0][0]
        for name, value in rates.items()
    }


def _curve(curve: JsonObject) -> JsonObject:
    """The curve of a Kovalevskaya top, in time units of 2**-exponent, to 17 digits."""
    from polhode.numbers.mpmath_context import mpmath

    def text(x: Any) -> Any:
        if isinstance(x, list):
            return [text(element) for element in x]
        return x if x is None or isinstance(x, int) else str(mpmath.nstr(x, 17))

    return {name: text(value) for name, value in curve.items()}
