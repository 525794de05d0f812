"""What results tell of their scene, and its columns: times, states, outputs, what is varied."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from polhode.common.errors import BadInput
from polhode.numbers import exact
from polhode.numbers.conversion import ExactNumbers
from polhode.numbers.exact import Irrational
from polhode.numbers.number_types import DOUBLE, Doubles, Given, Indices, NumberType, Stack
from polhode.results.cells import EXACT, TEXT, bits_word
from polhode.results.table import Column, Fact, Value, Values
from polhode.scenes.scene import Scene
from polhode.scenes.scene_file import as_toml
from polhode.scenes.vary import Variation
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, INTEGRALS, MATRIX, RODRIGUES, SPACE, STATE

RATES, GAMMA = STATE[:3], STATE[3:]
_AXES = ("first", "second", "third")
_MEANINGS = {
    **{
        name: f"angular velocity along the {axis} body axis"
        for name, axis in zip(RATES, _AXES, strict=True)
    },
    **{
        name: f"the upward vertical along the {axis} body axis"
        for name, axis in zip(GAMMA, _AXES, strict=True)
    },
    **dict(zip(ANGLES, ("precession", "nutation", "proper rotation"), strict=True)),
    **{name: f"quaternion body to space, element {k}" for k, name in enumerate(ATTITUDE)},
    **{name: f"angular velocity along {name[-1]} of space" for name in SPACE},
    **dict.fromkeys(MATRIX, "element of the rotation matrix, body to space"),
    **dict.fromkeys(RODRIGUES, "modified Rodrigues parameter"),
    **dict(zip(INTEGRALS, ("energy", "vertical momentum"), strict=False)),
    **dict.fromkeys(INTEGRALS[2:], "departure from the start's integral, relative"),
}


def scene_facts(
    scene: Scene, *, name: str = "", times: Sequence[Fraction] | None = None
) -> list[Fact]:
    """The first facts of every result: the scene's name and text.

    ``times``: of the column t; the text leaves out an array of the same times.  Irrational times,
    which no text holds, stand in it as those of the column, or rounded to 160 bits.
    """
    outputs = scene.output_times
    in_column = times is not None and outputs.floats is not None and outputs == times
    if outputs.floats is None and any(isinstance(t, Irrational) for t in outputs.ends or outputs):
        scene = scene.at(times or tuple(exact.nearest(t, 160) for t in outputs))
    text = as_toml(scene.at(()) if in_column else scene)
    return [
        Fact("scene", name or scene.name, "the scene's name"),
        Fact("scene_text", text, "the scene as the text of a file"),
    ]


def page_text(scene: Scene) -> str:
    """The scene's text for a page: its file's where that still tells the motion, else a new one.

    Numbers that no text holds are told in short.
    """
    if scene.source and scene.text == scene.source:
        return scene.source
    try:
        return str(scene_facts(scene)[1].value)
    except BadInput:
        return repr(scene)


def provenance_fact(provenance: Mapping[str, object]) -> Fact:
    """The last fact of every result: versions, processor, the scene's fingerprint; no durations."""
    facts = {key: value for key, value in provenance.items() if key != "seconds"}
    return Fact("provenance", facts, "versions, processor, fingerprint of the scene")


def unit_of(scene: Scene | None, name: str) -> str:
    """The unit of a column of a state or an output, or of t; of no scene any consistent one."""
    time = "s" if scene is not None and scene.units == "SI" else "time"
    if name == "t":
        return time
    if name in ANGLES:
        return "rad"
    return f"rad/{time}" if name in (*RATES, *SPACE) else ""


def time_column(
    scene: Scene | None,
    times: Sequence[Fraction] | Doubles,
    number_type: NumberType,
    *,
    digits: int | None = None,
) -> Column:
    """Times of a type: doubles as they are, wider ones with every digit.

    ``digits``: on a terminal; unless given those that decimals of the type keep.
    """
    values: Values = times
    if number_type == DOUBLE and not hasattr(times, "dtype"):
        numbers = times if isinstance(times, ExactNumbers) else ExactNumbers(tuple(times))
        values = numbers.doubles()
    kind = bits_word(number_type) if number_type == DOUBLE else EXACT
    shown = number_type.printed_digits - 2 if digits is None else digits
    return Column("t", values, "time", unit_of(scene, "t"), kind, shown)


def row_columns(
    scene: Scene | None,
    names: Sequence[str],
    rows: Given | Stack | Sequence[Sequence[Value]],
    number_type: NumberType,
    *,
    digits: int | None = None,
) -> list[Column]:
    """Columns of rows of one type, which may have gaps.

    ``digits``: on a terminal; unless given as many as round-trip.
    """
    word, shown = bits_word(number_type), number_type.printed_digits if digits is None else digits
    return [
        Column(name, _column(rows, k), _MEANINGS.get(name, ""), unit_of(scene, name), word, shown)
        for k, name in enumerate(names)
    ]


def _column(rows: Given | Stack | Sequence[Sequence[Value]], k: int) -> Values:
    import numpy as np

    return rows[:, k] if isinstance(rows, np.ndarray) else [row[k] for row in rows]


def varied_columns(varied: Variation, member: Indices) -> list[Column]:
    """What is varied, one column per key: exact numbers, or those of arrays; of these members."""
    columns = []
    for key, values, repeat in zip(
        varied.keys, varied.rows.columns, varied.rows.repeats, strict=True
    ):
        place = member // repeat % max(1, len(values))
        floats = values.floats
        cells: Values = floats[place] if floats is not None else [values[k] for k in place.tolist()]
        typed = len(member) > 0 or floats is not None
        columns.append(Column(key, cells, "varied", type="" if typed else EXACT))
    return columns


def text_column(name: str, values: Sequence[str], meaning: str = "") -> Column:
    """Texts, of which there may be none."""
    return Column(name, values, meaning, type=TEXT)
