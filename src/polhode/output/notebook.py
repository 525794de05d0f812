"""Results as a notebook shows them: a report, or a line and the first rows of a table."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from polhode.common.errors import printable
from polhode.numbers import decimals
from polhode.results import writer
from polhode.results.result import Result, Storable
from polhode.results.table import Table
from polhode.scenes.body import kind_of_body

if TYPE_CHECKING:
    from polhode.scenes.scene import Scene

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
    report = str(found)
    if report != repr(found) and report.count("\n") < MOST_LINES:
        return f"<pre>{escape(printable(report))}</pre>"
    heading = f"<p>{escape(printable(repr(found).strip('<>')))}</p>"
    return heading + _rows(found.table()) if isinstance(found, Result) else heading


def _rows(table: Table) -> str:
    few_rows = [column._replace(values=column.values[:MOST_ROWS]) for column in table.columns]
    header, rows = writer.cells(table._replace(columns=few_rows))
    head = "".join(f"<th>{escape(name)}</th>" for name in header)
    lines = "".join(
        "<tr>" + "".join(f"<td>{escape(printable(x[:24]))}</td>" for x in row) + "</tr>"
        for row in rows
    )
    more = f"<p>{table.rows} rows in all</p>" if table.rows > MOST_ROWS else ""
    return f"<table><tr>{head}</tr>{lines}</table>{more}"


def _table(title: str, facts: dict[str, str]) -> str:
    rows = "".join(
        f'<tr><th style="text-align:left">{escape(name)}</th>'
        f'<td style="text-align:left">{escape(printable(value))}</td></tr>'
        for name, value in facts.items()
    )
    return f"<table><caption>{escape(printable(title))}</caption>{rows}</table>"
