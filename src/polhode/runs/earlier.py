"""JSON files that results of polhode 0.2 saved, as what such a file holds today.

They have what the command printed, by the names of 0.2, and as ``result`` a text that named classes
of polhode: of that the arrays of a run are read, and nothing is called.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from polhode.common.errors import UNREADABLE, say_doubt
from polhode.common.files import read_whole
from polhode.numbers.number_types import NumberType
from polhode.results.cells import EXACT, bits_word, decimal, values_of
from polhode.results.reader import KINDS, MOST_BYTES, is_result
from polhode.results.table import RESERVED, Column, Content, Fact, Table, Value
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, STATE

VERSION = "0.2"
#: Of a kind what numbers its rows; their columns, or the one list of them; and of these columns
#: those that list several for each row.
_MAP = ("at", "cell", "verdict", "fli", "megno", "growth", "exponent", "until")
_CROSSINGS = ("times", "l", "L_over_G", "states", "digits")
_ROWS: Mapping[str, tuple[str, tuple[str, ...], tuple[str, ...]]] = {
    "ChaosMap": ("motion", _MAP, ()),
    "Frequencies": ("line", ("frequencies",), ()),
    "Levels": ("arc", ("arcs",), ("f", "h")),
    "OrbitFamily": ("orbit", ("orbits",), ()),
    "OrbitSearch": ("orbit", ("orbits",), ()),
    "Section": ("orbit", _CROSSINGS, _CROSSINGS),
}
_NEW = {"times": "t", "digits": "digits_expected", "from": "first", "to": "last", "L/G": "L_over_G"}
_NEW_FACTS = {"scene_name": "scene", "source": "scene", "shape": "grid", "varied": "vary"}


def content_of(path: Path) -> Content | None:
    """The content of such a file; None for any other; ValueError for one that was changed."""
    if path.suffix.lower() != ".json" or not path.is_file() or is_result(path):
        return None
    try:
        held = json.loads(read_whole(path, MOST_BYTES, "a result that polhode saved"))
        stored = json.loads(held["result"])
        kind, value = stored["kind"], stored["value"]
        text = json.dumps([kind, value], separators=(",", ":"), allow_nan=False)
        is_whole = stored["sum"] == hashlib.sha256(text.encode()).hexdigest()
    except (LookupError, TypeError, *UNREADABLE):
        return None
    if not is_whole:
        raise ValueError("it was changed or cut")
    if kind not in KINDS:
        raise ValueError(f"a result {kind[:40]}, which is no longer made")
    if "events" in held:
        raise ValueError("one of polhode 0.2 with events, which are found otherwise: make it again")
    say_doubt(str(path), f"a result {kind} of polhode 0.2; save it again to keep it")
    if kind == "Trajectory":
        return _run({name: _array(*told["a"]) for name, told in value["run"]})
    held |= held.pop("scene") if isinstance(held.get("scene"), dict) else {}
    rows = [*_rows(kind, held)]
    columns = [Column(name, [row[name] for row in rows]) for name in (rows[0] if rows else ())]
    table = Table(columns, min(1, len(columns)))
    return Content(kind, VERSION, f"<{kind} of polhode 0.2>", table, (*_facts(kind, held),))


def _run(held: Mapping[str, Value]) -> Content:
    """The content of a run, of the arrays that were its NPZ file."""
    about = json.loads(held["about"])
    word = bits_word(NumberType(about["number"], about["bits"]))
    columns = [Column("t", values_of(held["times"], EXACT))]
    for part, names in (("states", STATE), ("attitude", ATTITUDE), ("angles", ANGLES)):
        width = len(held.get(part, ())) // max(1, len(held["times"]))
        for k, name in enumerate(names[:width]):
            columns.append(Column(name, values_of(held[part][k::width], word)))
    if "errors" in held:
        columns.append(Column("error", held["errors"]))
    told = about | {"scene": about["name"], "scene_text": held["scene"]}
    told |= {"scene_source": held["source"], "reached": decimal(about["reached"])}
    told |= {"tolerance": float.fromhex(about["tolerance"])}
    facts = [Fact(name, x) for name, x in told.items()]
    return Content("Trajectory", VERSION, "", Table(columns), facts)


def _array(kind: str, shape: list[int], elements: Value) -> Value:
    """The elements of an array, of one without axes its text."""
    if isinstance(elements, str):
        elements = np.frombuffer(base64.b64decode(elements), dtype=kind)
    return elements if shape else elements[0]


def _rows(kind: str, held: Mapping[str, Value]) -> Iterator[dict[str, Value]]:
    """The rows of a result, numbers and texts by the names of their columns."""
    label, keys, several = _ROWS.get(kind, ("", (), ()))
    rows = [dict(zip(keys, row, strict=True)) for row in zip(*map(held.get, keys), strict=True)]
    parts = {"states": STATE, "state": STATE, "at": held.get("keys", ())}
    for number, row in enumerate(held[keys[0]] if len(keys) == 1 else rows, 1):
        for k in range(len(row[several[0]]) if several else 1):
            told: dict[str, Value] = {label: number}
            for key, x in row.items():
                one = x[k] if key in several else x
                if isinstance(one, list):
                    told |= dict(zip(parts[key], one, strict=True))
                else:
                    told[_NEW.get(key, key)] = json.dumps(one) if isinstance(one, dict) else one
            yield told


def _facts(kind: str, held: Mapping[str, Value]) -> Iterator[Fact]:
    """What the rest tells: values, lists of them, and small objects."""
    told = (*RESERVED, *(_ROWS[kind][1] if kind in _ROWS else ()))
    for key, x in held.items():
        name = _NEW_FACTS.get(key, key)
        listed = x if isinstance(x, list) else [x]
        if key not in told and (
            isinstance(x, dict) or not any(isinstance(one, (dict, list)) for one in listed)
        ):
            yield Fact(name, x)
