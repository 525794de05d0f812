"""Results as a notebook shows them: a small table of facts, and the curves of a run."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from polhode.common.text_tables import few, printable
from polhode.figures.canvas.canvas import BODY, REST, SPACE
from polhode.numbers import decimals
from polhode.numbers.conversion import to_double
from polhode.results import shown
from polhode.results.result import Result, Storable
from polhode.results.table import Table
from polhode.runs.trajectory import Trajectory
from polhode.scenes.classification import kind_of_body

if TYPE_CHECKING:
    from polhode.scenes.scene import Scene

WIDE, HIGH = 360, 120  # of the curves, in pixels
MOST_POINTS = 400
MOST_ROWS, MOST_LINES = 8, 40


def of_scene(scene: Scene) -> str:
    """A scene's facts."""
    body = scene.body
    facts = {
        "body": kind_of_body(body),
        "moments": ", ".join(decimals.shown(x) for x in body.moments),
        "Mg r0": ", ".join(decimals.shown(x) for x in body.torque),
        "omega": ", ".join(decimals.shown(x) for x in scene.omega),
    }
    if scene.gamma is not None:
        facts["gamma"] = ", ".join(decimals.shown(x) for x in scene.gamma)
    if scene.times:
        facts["times"] = f"{len(scene.times)}, to t = {decimals.shown(scene.end)}"
    return _table(scene.title or scene.name, facts)


def of_result(found: Storable) -> str:
    """What a notebook shows of any result: a report where it has one, else its table's first rows.

    Nothing that must be computed for it.
    """
    if isinstance(found, Trajectory):
        return of_run(found)
    report = str(found)
    if report != repr(found) and report.count("\n") < MOST_LINES:
        return f"<pre>{escape(printable(report))}</pre>"
    heading = f"<p>{escape(printable(repr(found).strip('<>')))}</p>"
    return heading + _rows(found.table()) if isinstance(found, Result) else heading


def _rows(table: Table) -> str:
    few_rows = [column._replace(values=column.values[:MOST_ROWS]) for column in table.columns]
    header, rows = shown.cells(table._replace(columns=few_rows))
    head = "".join(f"<th>{escape(name)}</th>" for name in header)
    lines = "".join(
        "<tr>" + "".join(f"<td>{escape(printable(x[:24]))}</td>" for x in row) + "</tr>"
        for row in rows
    )
    more = f"<p>{table.rows} rows in all</p>" if table.rows > MOST_ROWS else ""
    return f"<table><tr>{head}</tr>{lines}</table>{more}"


def of_run(run: Trajectory) -> str:
    """A run's line, omega over time, and its table's first rows."""
    return f"<p>{escape(printable(repr(run).strip('<>')))}</p>{_curves(run)}{_rows(run.table())}"


def _table(title: str, facts: dict[str, str]) -> str:
    rows = "".join(
        f'<tr><th style="text-align:left">{escape(name)}</th>'
        f'<td style="text-align:left">{escape(printable(value))}</td></tr>'
        for name, value in facts.items()
    )
    return f"<table><caption>{escape(printable(title))}</caption>{rows}</table>"


def _curves(run: Trajectory) -> str:
    """p, q and r over time as SVG, no package needed; nothing where they make no curve."""
    kept = few(len(run.times), MOST_POINTS)
    t = np.array([to_double(run.times[k]) for k in kept])
    values = np.array([[float(x) for x in run.states[k][:3]] for k in kept])
    if len(kept) < 3 or not np.isfinite(values).all():
        return ""
    low, high = float(values.min()), float(values.max())
    x = (t - t.min()) / (float(np.ptp(t)) or 1.0) * WIDE
    y = HIGH - (values - low) / ((high - low) or 1.0) * HIGH
    lines = "".join(
        f'<polyline fill="none" stroke="{colour}" points="{_points(x, column)}"/>'
        f'<text x="{WIDE + 6}" y="{14 + 16 * k}" fill="{colour}" font-size="12">{name}</text>'
        for k, (name, colour, column) in enumerate(
            zip("pqr", (BODY, SPACE, REST), y.T, strict=True)
        )
    )
    size = f'width="{WIDE + 24}" height="{HIGH + 4}" viewBox="0 -2 {WIDE + 24} {HIGH + 4}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{lines}</svg>'


def _points(x: Iterable[float], y: Iterable[float]) -> str:
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
