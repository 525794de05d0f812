"""Checks as JSON objects; names and shapes are a contract."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from polhode.numbers.decimals import (
    decimal_string,
    shown,
)

if TYPE_CHECKING:  # a run needs none of these
    from polhode.checks.form_cross_checks import CrossCheck
    from polhode.checks.published_figures import PrintedFigure
    from polhode.checks.regression import Report


def of_check(report: Report) -> dict[str, Any]:
    """One case of ``check --json``."""
    return {
        "scene": report.scene.name,
        "regime": report.regime,
        "reference": report.reference,
        "passed": report.passed,
        "runs": [
            {
                "number": line.number,
                "correct_digits": None if line.lost else round(line.digits, 2),
                "expected": None if line.band is None else list(line.band),
                "outcome": line.outcome,
                "passed": line.passed,
                "verdict": line.verdict,
                "limit": line.limit or None,
            }
            for line in report.lines
        ],
        "published": [of_figure(figure) for figure in report.figures],
        "textbook": None if report.textbook is None else round(report.textbook, 2),
    }


def of_cross_check(found: CrossCheck) -> dict[str, Any]:
    """A scene in one form beside its principal form."""
    return {
        "scene": found.scene,
        "form": found.form,
        "digits": None if found.digits is None else round(found.digits, 2),
        "passed": found.passed,
        "note": found.note,
    }


def of_figure(figure: PrintedFigure) -> dict[str, Any]:
    """A published figure beside ours."""
    printed = figure.published
    return {
        "t": shown(printed.t),
        "quantity": printed.quantity,
        "printed": printed.value,
        "ours": figure.ours,
        "difference": decimal_string(figure.difference, 2),
        "cite": printed.cite,
        "verdict": figure.verdict,
        "passed": figure.passed,
    }
