"""``polhode check``: the regression of the library."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import Any

from polhode import answers
from polhode.precision import shown
from polhode.verbs.terminal import DONE, FAILED, Progress, print_json

HELP = "regression against references and published figures"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names, patterns or paths")
    parser.add_argument("--number", action="append", help="this number type instead of the case's")


def main(options: Namespace) -> int:
    """The library's regression."""
    from polhode.studies.regression import check as checks

    reports = []
    with Progress("check") as progress:
        for report in checks(options.scenes, options.number or (), progress.say):
            reports.append(report)
            if not options.json:
                progress.clear()
                _print_check(report)
    passed = all(report.passed for report in reports)
    if options.json:
        print_json({"passed": passed, "cases": [answers.of_check(r) for r in reports]})
    else:
        bad = sum(not r.passed for r in reports)
        print(f"{len(reports) - bad} passed, {bad} failed")
    return DONE if passed else FAILED


def _print_check(report: Any) -> None:
    mark = "ok  " if report.passed else "FAIL"
    print(f"{mark} {report.scene.name} ({report.regime}, {report.reference})")
    for line in report.lines:
        band = "" if line.band is None else f" in [{line.band[0]:g}, {line.band[1]:g}]"
        why = line.limit and f", limited by {line.limit}"
        print(f"     {line.number:<9}{line.digits:6.2f} digits{band}: {line.verdict}{why}")
    for figure in report.figures:
        p = figure.published
        print(f"     {p.quantity} at t = {shown(p.t)}: {figure.verdict}  ({p.cite})")
        print(f"         printed {p.value}")
        print(f"         ours    {figure.ours}")
