"""``polhode check``: the regression of the library."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from typing import TYPE_CHECKING

from polhode.checks import results
from polhode.common.errors import BadInput
from polhode.common.text_tables import counted, one_line
from polhode.numbers.decimals import shown
from polhode.verbs.options import word
from polhode.verbs.terminal import DONE, FAILED, ProgressLine, print_json, say

if TYPE_CHECKING:
    from polhode.checks.form_cross_checks import CrossCheck
    from polhode.checks.regression import Report

HELP = "regression against references and published figures"
_MANY = 8  # cases: for fewer, processes of their own take longer to start than they save


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "scenes", nargs="*", type=word, metavar="SCENE", help="names, patterns or paths"
    )
    parser.add_argument(
        "--forms", action="store_true", help="cross-checks between the forms, alone or after SCENEs"
    )
    parser.add_argument(
        "--number", action="append", help="this number type instead of the case's (may be repeated)"
    )
    parser.add_argument(
        "--propose",
        action="store_true",
        help="run SCENEs in double, extended and quad, and print [expect] bands to paste",
    )
    parser.add_argument(
        "--details", action="store_true", help="all that was checked, of cases that pass, too"
    )


def main(options: Namespace) -> int:
    """The library's regression, and without SCENE the cross-checks between the forms."""
    from polhode.checks.form_cross_checks import cross_checks
    from polhode.checks.regression import PROPOSED
    from polhode.checks.regression import check as checks
    from polhode.common.executors import cores
    from polhode.scenes import library

    if options.propose and not options.scenes:
        raise BadInput("check", "--propose", None, "SCENEs to propose bands for")
    reports, crossed = [], []
    numbers = options.number or (PROPOSED if options.propose else ())
    many = len(library.matching(options.scenes)) >= _MANY
    shared = cores() if many else 1
    with ProgressLine("check") as progress:
        if options.scenes or not options.forms:
            whole = options.details or options.propose or options.json
            for report in checks(options.scenes, numbers, progress.say, shared, whole):
                reports.append(report)
                if not options.json:
                    progress.clear()
                    _print_check(report, whole)
                    if options.propose:
                        say(_bands(report.proposal))
        if options.forms or not (options.scenes or options.number):
            for found in cross_checks(progress.say, shared):
                crossed.append(found)
                if not options.json:
                    progress.clear()
                    _print_cross_check(found)
    verdicts = [report.passed for report in reports] + [found.passed for found in crossed]
    judged = [verdict for verdict in verdicts if verdict is not None]
    passed = all(judged) if judged else None
    if options.json:
        cases = [
            results.of_check(r) | ({"proposed": r.proposal} if options.propose else {})
            for r in reports
        ]
        answer = {"passed": passed, "cases": cases}
        print_json(answer | {"forms": [results.of_cross_check(c) for c in crossed]})
    else:
        unjudged = len(verdicts) - len(judged)
        rest = f", {unjudged} without a band" if unjudged else ""
        say(f"{sum(judged)} passed, {len(judged) - sum(judged)} failed{rest}")
    if options.propose:
        return DONE if all(report.proposal for report in reports) else FAILED
    if passed is None:
        expected = "a case with bands of digits ([expect]), which --propose prints, or with figures"
        raise BadInput("polhode check", "SCENE", " ".join(options.scenes), expected)
    return DONE if passed else FAILED


def _print_cross_check(found: CrossCheck) -> None:
    mark = "ok  " if found.passed else "FAIL"
    digits = "" if found.digits is None else f"{found.digits:.1f} digits, "
    say(f"{mark} {found.scene} in the form {found.form}: {digits}{found.note}")


def _bands(proposal: Mapping[str, tuple[float, float]]) -> str:
    """The table of a scene file that holds the bands proposed."""
    rows = [f"{number:<8} = [{low}, {high}]" for number, (low, high) in proposal.items()]
    return "\n".join(["", "[expect]", *rows, ""]) if rows else "     no digits are left: no band"


def _print_check(report: Report, details: bool) -> None:
    """A line of a case that passes; without ``details`` no more than that."""
    mark = {True: "ok  ", False: "FAIL", None: "--  "}[report.passed]
    head = f"{mark} {report.scene.name} ({report.regime}, {report.reference})"
    if report.passed and not details:
        found = [
            f"{line.number} {line.lost or f'{line.digits:.2f} digits'}" for line in report.lines
        ]
        if report.figures:
            found.append(counted(len(report.figures), "published figure"))
        say(f"{head}: {', '.join(found)}")
        return
    say(head)
    for line in report.lines:
        band = "" if line.band is None else f" in [{line.band[0]:g}, {line.band[1]:g}]"
        why = line.limit and f", limited by {line.limit}"
        digits = line.lost or f"{line.digits:6.2f} digits"
        say(f"     {line.number:<9}{digits}{band}: {line.verdict}{why}")
    if report.textbook is not None:
        say(f"     mpmath's own functions agree to {report.textbook:.1f} digits")
    for figure in report.figures:
        p = figure.published
        say(f"     {p.quantity} at t = {shown(p.t)}: {figure.verdict}  ({one_line(p.cite)})")
        say(f"         printed {p.value}")
        say(f"         ours    {figure.ours}")
