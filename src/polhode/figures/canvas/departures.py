"""Errors and departures of the integrals over time, as the figures draw them: decimal logarithms.

nan stands for a departure of exactly 0, and where nothing was judged.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.equations import integrals
from polhode.figures.canvas.curve_sampling import Samples
from polhode.judging.correct_digits import largest, log10_differences, log10_rate, scaled
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import Reference
from polhode.judging.score.answers import Answers
from polhode.judging.tables.table import PARTS, Table
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, mpf_row, to_double
from polhode.numbers.double_double import Pairs
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Rows
from polhode.numbers.scalars import Scalar
from polhode.scenes.scene import Scene

SAMPLES = 501  # noise, not a curve
SPARE_DIGITS = 6
_NAMES = {integrals.ENERGY: "h", integrals.AREA: "f", integrals.LENGTH: "gamma"}


def errors(table: Table, reference: Reference | Certified, number: NumberType | None) -> Samples:
    """Errors against a reference: of omega over its largest modulus, and of gamma.

    As far as the table has columns of the state; ``number``: the type of its numbers, if known.
    """
    scene = reference.scene
    table = in_order(table)
    if not {*scene.columns} & table.columns.keys():
        raise BadInput(table.name, "header", None, f"a column of {', '.join(scene.columns)}")
    most = number.most_digits if number else table.printed + 2
    answers = Answers(reference, table.times, False, None)
    true = answers.rows("at", math.ceil(min(most, 1000)) + SPARE_DIGITS)
    states = table.numbers(scene.columns, in_pairs=isinstance(true, Pairs))
    found = scaled(log10_differences(states, true), log10_rate(true, scene))
    parts = {"omega": largest(found[:, :3]), "gamma": largest(found[:, 3:])}
    for name, logs in parts.items():
        logs[table.gaps(PARTS[name])] = math.nan  # of no whole vector
    judged = {name: logs for name, logs in parts.items() if not np.isnan(logs).all()}
    shown = {name: np.where(np.isinf(logs), math.nan, logs) for name, logs in judged.items()}
    return _samples(table, shown, scene, number)


def departures(table: Table, scene: Scene, number: NumberType | None) -> Samples:
    """Relative departures of the integrals from the exact scene's (see integrals.Drift).

    The table needs every column of the state.
    """
    missing = [name for name in scene.columns if name not in table.columns]
    if missing:
        raise BadInput(table.name, "header", None, f"columns {', '.join(missing)} for integrals")
    rows = table.rows(scene.columns) or []
    table = in_order(table.some([k for k, row in enumerate(rows) if None not in row]))
    bits = number.bits if number else math.ceil(table.printed * math.log2(10)) + 8
    states: Rows = [mpf_row(row, bits) for row in table.rows(scene.columns) or []]
    if table.run is not None:
        states = table.run.states
    found = integrals.departures(scene, states, bits)
    shown = {_NAMES.get(name, "fourth"): _log10(values) for name, values in found.items()}
    return _samples(table, shown, scene, number)


def in_order(table: Table) -> Table:
    """A table's rows in order of time; a run's are."""
    if table.run is not None:
        return table
    return table.some(sorted(range(len(table.times)), key=lambda k: table.times[k]))


def _samples(
    table: Table, logs: dict[str, Any], scene: Scene, number: NumberType | None
) -> Samples:
    columns = {"t": np.array([to_double(t) for t in table.times])} | logs
    return Samples(table.name, columns, scene, float(number.eps) if number else None)


def _log10(values: list[Scalar]) -> Any:
    return np.array([exact.log10(abs(exactly(x))) if x else math.nan for x in values])
