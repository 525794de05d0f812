"""What the command prints of each kind of result, as JSON, arrays and rows of text."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from polhode.judging.references.reference import reference
from polhode.output import csv_tables, json_results
from polhode.output.json_object import JsonObject
from polhode.output.results.tables import table
from polhode.output.results.texts import text_of
from polhode.results.result import Result
from polhode.runs.sweep.ensemble import Ensemble
from polhode.runs.trajectory import Trajectory

#: By the name of the class: the room that has its arrays, and its function for JSON.
_ROOMS = {
    "ChaosMap": ("maps", "of_map"),
    "Frequencies": ("frequencies", "of_frequencies"),
    "Levels": ("levels", "of_levels"),
    "Orbit": ("orbits", "of_orbit"),
    "OrbitFamily": ("orbits", "of_family"),
    "OrbitSearch": ("orbits", "of_search"),
    "Reductions": ("reductions", "of_reductions"),
    "Section": ("sections", "of_section"),
    "Ensemble": ("sweeps", "of_ensemble"),
    "Enclosure": ("json_results", "of_enclosure"),
    "CertifiedEvents": ("json_results", "of_certified_events"),
    "Judgement": ("json_results", "of_judgement"),
}
_WITH_ARRAYS = ("ChaosMap", "Levels", "OrbitFamily", "OrbitSearch", "Reductions", "Section")


def summary(found: Result, *, beside: bool = False) -> JsonObject:
    """The JSON object of a result; ``beside``: a table, without what that has."""
    kind = type(found).__name__
    if isinstance(found, Trajectory):
        answer = json_results.of_run(found, reference(found.scene).regime)
        if beside:
            answer = csv_tables.beside(answer)
        return answer
    if isinstance(found, Ensemble):
        from polhode.output import sweeps

        bits = {"t_bits": found.number.bits} if beside else {}
        return bits | sweeps.of_ensemble(found, states=not beside)
    if beside or kind not in _ROOMS:
        return {"kind": kind, "about": repr(found)}
    room, name = _ROOMS[kind]
    made: JsonObject = getattr(import_module(f"polhode.output.{room}"), name)(found)
    return made


def arrays(found: Result) -> JsonObject:
    """The arrays of a result's NPZ file, none of which needs pickle."""
    kind = type(found).__name__
    if kind in _WITH_ARRAYS or isinstance(found, Ensemble):
        make: Callable[[Result], JsonObject]
        make = import_module(f"polhode.output.{_ROOMS[kind][0]}").arrays
        return make(found)
    return {name: _array(column) for name, column in table(found).columns.items()}


def _array(column: Any) -> Any:
    """A column as an array of numbers where numpy has the type, else of texts."""
    held = np.asarray(column)
    return np.array(text_of(column), dtype=np.str_) if held.dtype.kind == "O" else held


def rows(found: Result) -> list[list[str]]:
    """Header and rows of a result's CSV file."""
    if isinstance(found, Trajectory):
        answer = json_results.of_run(found, "")
        header, lines = csv_tables.rows_of(answer, short=True)
        return [header, *lines]
    if isinstance(found, Ensemble):
        from polhode.output import sweeps

        return [*sweeps.rows(found)]
    return table(found).rows()
