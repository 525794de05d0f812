"""Results as a notebook shows them: a small table of facts, and the curves of a run."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from polhode.common.text_tables import counted, few, printable
from polhode.figures.canvas.canvas import BODY, REST, SPACE
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import Reference
from polhode.judging.score.judgement import Judgement
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.decimals import brief, shown
from polhode.output.results.tables import table
from polhode.results.result import Storable
from polhode.runs.sweep.ensemble import Ensemble
from polhode.runs.trajectory import Trajectory
from polhode.scenes.classification import kind_of_body
from polhode.scenes.vocabulary import COLUMNS

if TYPE_CHECKING:
    from polhode.scenes.scene import Scene

WIDE, HIGH = 360, 120  # of the curves, in pixels
MOST_POINTS = 400
MOST_ROWS = 8


def of_scene(scene: Scene) -> str:
    """A scene's facts."""
    body = scene.body
    facts = {
        "body": kind_of_body(body),
        "moments": ", ".join(shown(x) for x in body.moments),
        "Mg r0": ", ".join(shown(x) for x in body.torque),
        "omega": ", ".join(shown(x) for x in scene.omega),
    }
    if scene.gamma is not None:
        facts["gamma"] = ", ".join(shown(x) for x in scene.gamma)
    if scene.times:
        facts["times"] = f"{len(scene.times)}, to t = {shown(scene.end)}"
    return _table(scene.title or scene.name, facts)


def of_result(found: Storable) -> str:
    """What a notebook shows of any result."""
    if isinstance(found, Trajectory):
        return of_run(found)
    if isinstance(found, Ensemble):
        return of_ensemble(found)
    if isinstance(found, Judgement):
        return of_judgement(found)
    return _head(found)


def _head(found: Storable) -> str:
    """The line that names a result, and the first rows of its table; not of what must compute."""
    told = f"<p>{escape(printable(repr(found).strip('<>')))}</p>"
    if isinstance(found, (Reference, Certified)):
        return told
    header, *rows = table(found).rows()
    head = "".join(f"<th>{escape(name)}</th>" for name in header)
    lines = "".join(
        "<tr>" + "".join(f"<td>{escape(printable(x[:24]))}</td>" for x in row) + "</tr>"
        for row in rows[:MOST_ROWS]
    )
    more = f"<p>{len(rows)} rows in all</p>" if len(rows) > MOST_ROWS else ""
    return f"{told}<table><tr>{head}</tr>{lines}</table>{more}"


def of_run(run: Trajectory) -> str:
    """A run's facts, and omega over time."""
    facts = {
        "number type": f"{run.number.name}, {run.number.bits} bits",
        "outcome": f"{run.outcome.value}, {counted(run.steps, 'step')}, "
        f"{counted(len(run.times), 'time')}",
        "reached": f"t = {brief(run.reached, 17)}",
    }
    if run.correct_digits is not None:
        facts["correct digits"] = f"{run.correct_digits:.1f}, by the {run.checked_by}"
    elif run.times:
        facts["digits expected"] = f"{min(run.expected.digits):.1f} at the worst"
    for word, rows in run.outputs.items():
        if len(rows):
            pairs = zip(COLUMNS[word].names, rows[-1], strict=True)
            told = [f"{name} {'none' if x is None else brief(exactly(x))}" for name, x in pairs]
            facts[word] = f"{', '.join(told)} at the end"
    if run.events:
        facts["events"] = ", ".join(f"{len(e.times)} {e.name}" for e in run.events)
    return _table(run.scene.title or run.scene.name, facts) + _curves(run)


def of_ensemble(found: Ensemble) -> str:
    """A sweep's facts."""
    ended: dict[str, int] = {}
    for outcome in found.outcomes:
        ended[outcome.value] = ended.get(outcome.value, 0) + 1
    facts = {
        "members": str(len(found)),
        "varied": ", ".join(found.varied.keys),
        "number type": f"{found.number.name}, {found.number.bits} bits",
        "outcomes": ", ".join(f"{n} {name}" for name, n in ended.items()),
        "times": f"{len(found.times)}, to t = {brief(found.times[-1], 17)}",
    }
    return _table(found.scene.title or found.scene.name, facts)


def of_judgement(found: Judgement) -> str:
    """A judgement as it is printed."""
    return f"<pre>{escape(str(found))}</pre>"


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
