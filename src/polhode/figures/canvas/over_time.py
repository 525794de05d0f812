"""Errors and departures of the integrals over time, as the figures draw them: decimal logarithms.

nan stands for a departure of exactly 0, and where nothing was judged.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.equations.integrals import drift
from polhode.figures.canvas.curve_sampling import Samples
from polhode.judging.correct_digits import log10_errors, log10_rate
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import Reference
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import mpf_row, to_double
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Doubles, GivenRow
from polhode.numbers.scalars import Scalar
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene

SAMPLES = 501  # noise, not a curve
SPARE_DIGITS = 6


def errors_of_run(found: Trajectory, reference: Reference | Certified) -> Samples:
    """Errors against a reference: of omega over its largest modulus, and of gamma."""
    digits = math.ceil(found.number.most_digits) + SPARE_DIGITS
    logs = _errors([*found.states], reference.at(found.times, digits), found.scene)
    return _samples(found.scene.name, found.times, logs, found.scene, found.number)


def errors_of_table(
    table: Table, reference: Reference | Certified, number: NumberType | None
) -> Samples:
    """The same of a file, as far as it has columns of the state."""
    scene = reference.scene
    there = [name for name in scene.columns if name in table.columns]
    if not there:
        raise BadInput(table.name, "header", None, f"a column of {', '.join(scene.columns)}")
    most = number.most_digits if number else table.printed + 2
    digits = math.ceil(min(most, 1000)) + SPARE_DIGITS
    order = in_order(table)
    rows = reference.at(table.times, digits)
    states = [[table.columns[n][k] if n in there else None for n in scene.columns] for k in order]
    logs = _errors(states, [rows[k] for k in order], scene)
    return _samples(table.name, [table.times[k] for k in order], logs, scene, number)


def departures_of_run(found: Trajectory) -> Samples:
    """Relative departures of the integrals from the exact scene's (see integrals.Drift)."""
    states = found.states
    flat = isinstance(states, np.ndarray)
    logs = _departures(
        lambda k: states[k : k + 1] if flat else [states[k]],
        len(found.times),
        found.scene,
        found.number.bits,
    )
    return _samples(found.scene.name, found.times, logs, found.scene, found.number)


def departures_of_table(table: Table, scene: Scene, number: NumberType | None) -> Samples:
    """The same of a file; it needs every column of the state."""
    missing = [name for name in scene.columns if name not in table.columns]
    if missing:
        raise BadInput(table.name, "header", None, f"columns {', '.join(missing)} for integrals")
    columns = [table.columns[name] for name in scene.columns]
    order = [k for k in in_order(table) if all(column[k] is not None for column in columns)]
    bits = number.bits if number else math.ceil(table.printed * math.log2(10)) + 8
    rows = [mpf_row([column[k] for column in columns], bits) for k in order]
    logs = _departures(lambda k: [rows[k]], len(rows), scene, bits)
    return _samples(table.name, [table.times[k] for k in order], logs, scene, number)


def in_order(table: Table) -> list[int]:
    """The indices of a file's rows in order of time."""
    return sorted(range(len(table.times)), key=lambda k: table.times[k])


def _samples(
    name: str,
    times: Sequence[Scalar],
    logs: dict[str, Any],
    scene: Scene,
    number: NumberType | None,
) -> Samples:
    columns = {"t": np.array([to_double(t) for t in times])} | logs
    return Samples(name, columns, scene, float(number.eps) if number else None)


def _errors(
    states: Sequence[GivenRow], rows: Sequence[Sequence[Scalar]], scene: Scene
) -> dict[str, Any]:
    rate = log10_rate(rows, scene)
    logs = {}
    for name, part in (("omega", range(3)), ("gamma", range(3, len(scene.columns)))):
        judged = [[x if i in part else None for i, x in enumerate(row)] for row in states]
        if any(x is not None for row in judged for x in row):
            found = log10_errors(judged, rows, rate)
            logs[name] = np.where(np.isinf(found), math.nan, found)
    return logs


def _departures(row: Callable[[int], Any], count: int, scene: Scene, bits: int) -> dict[str, Any]:
    found = [drift(scene, row(k), bits)._asdict() for k in range(count)]
    names = [name for name, value in found[0].items() if value is not None]
    return {name: _log10([departure[name] for departure in found]) for name in names}


def _log10(values: Sequence[Scalar]) -> Doubles:
    from polhode.numbers.mpmath_context import mpmath

    with mpmath.workprec(53):
        return np.array([float(mpmath.log10(x)) if x else math.nan for x in values])
