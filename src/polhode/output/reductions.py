"""What the members of a sweep were reduced to, as JSON, CSV or NPZ; names and shapes are a
contract."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.files import is_stream, npz, write_whole
from polhode.common.interrupts import Delay
from polhode.common.json_text import JsonObject, as_json
from polhode.motion.outcomes import OUTCOMES
from polhode.numbers.decimals import shown, strings
from polhode.output import csv_tables
from polhode.output.sweeps import values, values_of

if TYPE_CHECKING:
    from polhode.dynamics.observables.reduce_many import Reductions


def of_reductions(found: Reductions) -> JsonObject:
    """The object that ``sweep --keep --json`` prints; null where there is no number."""
    members = [
        {
            "values": varied,
            "outcome": outcome,
            "steps": steps,
            "numbers": {name: x or None for name, x in zip(found.names, row, strict=True)},
        }
        for varied, outcome, steps, row in _rows(found)
    ]
    return {**_about(found), "members": members, "provenance": dict(found.provenance)}


def arrays(found: Reductions) -> JsonObject:
    """The arrays of an NPZ file: each number by its name (members,), beside those of a sweep."""
    import numpy as np

    about = {**_about(found), "provenance": dict(found.provenance)}
    return {
        **found.numbers,
        "names": np.array(found.names),
        "varied": np.array(found.varied.keys),
        **values_of(found.varied),
        "outcomes": np.array([outcome.value for outcome in OUTCOMES])[found.endings],
        "steps": found.counts,
        "about": np.array(as_json(about)),
    }


def table(found: Reductions) -> tuple[list[str], list[list[str]]]:
    """Header and a line for each member."""
    header = ["member", *found.varied.keys, "outcome", "steps", *found.names]
    lines = [
        [str(k + 1), *varied, outcome, str(steps), *row]
        for k, (varied, outcome, steps, row) in enumerate(_rows(found))
    ]
    return header, lines


def write(path: Path, found: Reductions) -> None:
    """Write them whole, ``.npz`` or ``.csv`` by the path's ending; raises BadInput."""
    if is_stream(path):
        _write(path, found)
        return
    with Delay():  # Ctrl-C waits for it
        _write(path, found)


def _write(path: Path, found: Reductions) -> None:
    if path.suffix.lower() == ".npz":
        write_whole({path: npz(arrays(found))})
        return
    header, lines = table(found)
    csv_tables.write_table(path, [header, *lines], _about(found) | {"provenance": found.provenance})


def _about(found: Reductions) -> JsonObject:
    return {
        "scene": found.scene.name,
        "number": found.number.name,
        "bits": found.number.bits,
        "end": shown(found.scene.end),
        "varied": list(found.varied.keys),
        "keep": list(found.keep),
        "projected": False,
        "interrupted": found.interrupted,
    }


def _rows(found: Reductions) -> Iterator[tuple[list[str], str, int, list[str]]]:
    """Of each member its values, outcome, steps and numbers as text, empty where there is none."""
    columns = [
        [strings([[x]], found.number)[0][0] if x == x else "" for x in found[name]]
        for name in found.names
    ]
    outcomes = [OUTCOMES[k].value for k in found.endings.tolist()]
    each = zip(values(found.varied), outcomes, found.counts.tolist(), *columns, strict=True)
    for varied, outcome, steps, *row in each:
        yield varied, outcome, steps, row
