"""Part of the study ``accuracy``: figures that somebody printed, beside the exact ones."""

from __future__ import annotations

import re
from typing import Any

from polhode.checks.published_figures import (
    PrintedFigure,
    TimeLabel,
    figures,
    last_unit,
    significant_digits,
    time_labels,
)
from polhode.judging.reference import reference as reference_of
from polhode.numbers.decimals import decimal_string
from polhode.scenes.scene import Scene

#: In the cite of a printout: the number of a simulation, or the time step of a run.
_SIMULATED = re.compile(r"\bsimulation \d|\bdt = ")


def printed_figures(scene: Scene) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """A row for each figure printed of a scene, and for each source that errs in the time."""
    reference = reference_of(scene)
    found = figures(scene, reference)
    labels = time_labels(scene, reference, found)
    return (
        [_figure(scene.name, reference.kind, figure) for figure in found],
        [label_row(scene.name, label) for label in labels],
    )


def kind_of(cite: str, recomputed: bool) -> str:
    """What a printed figure is: a value somebody stands for, a printout, or one made for this."""
    if recomputed:
        return "recomputed"
    return "printout" if _SIMULATED.search(cite) else "value"


def _figure(case: str, reference: str, figure: PrintedFigure) -> dict[str, Any]:
    printed = figure.published
    return {
        "case": case,
        "reference": reference,
        "t": float(printed.t),
        "quantity": printed.quantity,
        "cite": printed.cite,
        "kind": kind_of(printed.cite, printed.recomputed),
        "printed": printed.value,
        "ours": figure.ours,
        "difference": decimal_string(figure.difference, 2),
        "last_units": float(f"{float(figure.difference / last_unit(printed.value)):.2g}"),
        "digits_shown": significant_digits(printed.value),
        "digits_right": round(figure.digits_right, 1),
        "stands": figure.complete,
        "verdict": figure.verdict,
    }


def label_row(case: str, found: TimeLabel) -> dict[str, Any]:
    """A source whose figures hold at another time."""
    return {
        "case": case,
        "cite": found.cite,
        "t": float(found.t),
        "shift": float(f"{found.shift:.4g}"),
        "before": float(f"{found.before:.2g}"),
        "after": float(f"{found.after:.2g}"),
    }
