"""Study ``published``: figures that somebody printed, beside ours."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from polhode.checks.published_figures import PrintedFigure, figures, last_unit, significant_digits
from polhode.checks.time_labels import TimeLabel, time_labels
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers.decimals import decimal_string
from polhode.scenes import library
from polhode.studies.row_filter import Only

NAME = "published"
QUESTION = (
    "Do figures that others printed agree with polhode's, and to how many digits? polhode's come "
    "from closed forms, or from proven enclosures where there is none."
)
QUICK_CASES = ("published/nasa-brick", "published/curtis", "published/detest-b5")


def rows(
    quick: bool = False,
    tick: Callable[[str], None] | None = None,
    only: Only | None = None,
) -> dict[str, Any]:
    """The study's results as a JSON object."""
    cases = []
    wanted = only or Only()
    for name in QUICK_CASES if quick else library.names():
        scene = library.load(name)
        if not scene.published or not wanted(name):
            continue
        if tick is not None:
            tick(f"{NAME}: {name}")
        reference = reference_of(scene)
        found = figures(scene, reference)
        cases.append(
            {
                "case": name,
                "title": scene.title,
                "reference": reference.kind,
                "cite": [*scene.cite],
                "figures": [_row(figure) for figure in found],
                "time_labels": [label_row(x) for x in time_labels(scene, reference, found)],
            }
        )
    return {"study": NAME, "question": QUESTION, "quick": quick, "cases": cases}


def _row(figure: PrintedFigure) -> dict[str, Any]:
    printed = figure.published
    return {
        "t": float(printed.t),
        "quantity": printed.quantity,
        "cite": printed.cite,
        "recomputed": printed.recomputed,
        "printed": printed.value,
        "ours": figure.ours,
        "difference": decimal_string(figure.difference, 2),
        "last_units": float(f"{float(figure.difference / last_unit(printed.value)):.2g}"),
        "digits_shown": significant_digits(printed.value),
        "digits_right": round(figure.digits_right, 1),
        "stands": figure.complete,
        "verdict": figure.verdict,
    }


def label_row(found: TimeLabel) -> dict[str, Any]:
    """A source whose figures hold at another time."""
    return {
        "cite": found.cite,
        "t": float(found.t),
        "shift": float(f"{found.shift:.4g}"),
        "before": float(f"{found.before:.2g}"),
        "after": float(f"{found.after:.2g}"),
    }
