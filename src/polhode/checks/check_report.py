"""The checks of many cases as a result: what ``polhode check`` shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from polhode.checks.form_cross_checks import CrossCheck, cross_checks
from polhode.checks.regression import PROPOSED, Report, check
from polhode.common.errors import BadInput, counted, one_line
from polhode.common.interrupts import Message
from polhode.common.processes import cores
from polhode.common.values import ByValue
from polhode.numbers.decimals import decimal_string, shown
from polhode.results.cells import DOUBLE, TEXT
from polhode.results.result import Result
from polhode.results.table import Fact, Table, table_of_rows
from polhode.scenes import library
from polhode.scenes.scene import Scene

_MANY = 8  # cases: for fewer, processes of their own take longer to start than they save
_MARKS = {True: "ok  ", False: "FAIL", None: "--  "}
_WORDS = {True: "true", False: "false", None: ""}


@dataclass(frozen=True, repr=False, eq=False)
class CheckReport(Result, ByValue):
    """Cases against their references and bands, and the forms of the equations against each other.

    ``proposing``: whether bands are asked for, and not whether they hold.  ``interrupted``: whether
    Ctrl-C ended it, before all cases.
    """

    cases: Sequence[Report]
    forms: Sequence[CrossCheck]
    proposing: bool = False
    interrupted: bool = False

    def __repr__(self) -> str:
        return f"<CheckReport of {counted(len(self.cases), 'case')}: {self._verdict}>"

    @property
    def verdicts(self) -> list[bool]:
        """Of all that was judged, whether it stands."""
        every = [*(x.passed for x in self.cases), *(x.passed for x in self.forms)]
        return [passed for passed in every if passed is not None]

    @property
    def passed(self) -> bool | None:
        """Whether all stands, or all have bands to propose; None where nothing was judged."""
        if self.proposing:
            return all(report.proposal for report in self.cases)
        return all(self.verdicts) if self.verdicts else None

    @property
    def complete(self) -> bool:
        """Whether anything was judged."""
        return self.passed is not None

    @property
    def _verdict(self) -> str:
        good, judged = sum(self.verdicts), len(self.verdicts)
        left = len(self.cases) + len(self.forms) - judged
        return f"{good} passed, {judged - good} failed" + f", {left} without a band" * bool(left)

    def __str__(self) -> str:
        return self._text(details=False)

    def details(self) -> str:
        """All that was checked, of cases that pass, too."""
        return self._text(details=True)

    def _text(self, details: bool) -> str:
        lines = [
            line
            for report in self.cases
            for line in (
                [_line(report)]
                if report.passed and not details and not self.proposing
                else _lines(report, self.proposing)
            )
        ]
        for found in self.forms:
            digits = "" if found.digits is None else f"{found.digits:.1f} digits, "
            mark = _MARKS[found.passed]
            lines.append(f"{mark} {found.scene} in the form {found.form}: {digits}{found.note}")
        return "\n".join([*lines, self._verdict])

    def table(self) -> Table:
        """A row for each case and number type: its digits, its band, and the verdict."""
        rows = [
            (
                *(report.scene.name, report.regime, report.reference, line.number),
                *(None if line.lost else line.digits, *(line.band or (None, None))),
                *(line.outcome, _WORDS[line.passed], line.verdict, line.limit),
            )
            for report in self.cases
            for line in report.lines
        ]
        types = _texts("scene", "regime", "reference", "number")
        types |= dict.fromkeys(("correct_digits", "expected_least", "expected_most"), DOUBLE)
        types |= _texts("outcome", "passed", "verdict", "limit")
        return table_of_rows(types, rows, labels=4)

    def facts(self) -> list[Fact]:
        """Whether all passed; published figures, textbook's formulas, forms, and bands proposed."""
        published = [
            (
                *(report.scene.name, shown(x.published.t), x.published.quantity),
                *(x.published.value, x.ours, decimal_string(x.difference, 2), x.published.cite),
                *(x.verdict, _WORDS[x.passed]),
            )
            for report in self.cases
            for x in report.figures
        ]
        names = ("scene", "t", "quantity", "printed", "ours", "difference", "cite", "verdict")
        digits = {"digits": DOUBLE}
        textbook = [(x.scene.name, x.textbook) for x in self.cases if x.textbook is not None]
        forms = [(x.scene, x.form, x.digits, x.note, _WORDS[x.passed]) for x in self.forms]
        proposed = [
            (report.scene.name, number, *band)
            for report in self.cases
            for number, band in report.proposal.items()
        ]
        of_forms = _texts("scene", "form") | digits | _texts("note", "passed")
        bands = _texts("scene", "number") | dict.fromkeys(("least", "most"), DOUBLE)
        return [
            Fact("passed", self.passed, "whether all stands that was judged"),
            Fact("published", table_of_rows(_texts(*names, "passed"), published)),
            Fact("textbook", table_of_rows(_texts("scene") | digits, textbook)),
            Fact("forms", table_of_rows(of_forms, forms, labels=2)),
            *([Fact("proposed", table_of_rows(bands, proposed, labels=2))] * self.proposing),
        ]


def _texts(*names: str) -> dict[str, str]:
    """Columns of texts."""
    return dict.fromkeys(names, TEXT)


def check_cases(
    scenes: Sequence[Scene | str | Path] = (),
    forms: bool = False,
    number: Sequence[str] = (),
    propose: bool = False,
    details: bool = False,
    message: Message | None = None,
) -> CheckReport:
    """Check cases against references and published figures, and the forms against each other.

    Parameters
    ----------
    scenes : sequence of str or Path
        Names, patterns or paths; without any all that ship, and the forms.
    forms : bool
        Cross-checks between the forms, alone or after SCENEs.
    number : sequence of str
        These number types instead of the case's.
    propose : bool
        Run SCENEs in double, extended and quad, and print [expect] bands to paste.
    details : bool
        All that was checked, of cases that pass, too, and what limits their digits.
    message : callable, optional
        Called with the name of what is checked.
    """
    if propose and not scenes:
        raise BadInput("check", "--propose", None, "SCENEs to propose bands for")
    tick = message or (lambda _: None)
    patterns = [*map(str, scenes)]
    shared = cores() if len(library.matching(patterns)) >= _MANY else 1
    reports: list[Report] = []
    crossed: list[CrossCheck] = []
    try:
        if scenes or not forms:
            numbers = number or (PROPOSED if propose else ())
            for report in check(patterns, numbers, tick, shared, details or propose):
                reports.append(report)
        if forms or not (scenes or number):
            for found in cross_checks(tick):
                crossed.append(found)
    except KeyboardInterrupt:
        return CheckReport(reports, crossed, propose, interrupted=True)
    return CheckReport(reports, crossed, propose)


def _head(report: Report) -> str:
    return f"{_MARKS[report.passed]} {report.scene.name} ({report.regime}, {report.reference})"


def _line(report: Report) -> str:
    """A case that passes, in one line."""
    digits = [f"{line.number} {line.lost or f'{line.digits:.2f} digits'}" for line in report.lines]
    if report.figures:
        digits.append(counted(len(report.figures), "published figure"))
    return f"{_head(report)}: {', '.join(digits)}"


def _lines(report: Report, proposing: bool) -> Iterator[str]:
    """What is told of a case."""
    yield _head(report)
    for line in report.lines:
        band = "" if line.band is None else f" in [{line.band[0]:g}, {line.band[1]:g}]"
        why = line.limit and f", limited by {line.limit}"
        digits = line.lost or f"{line.digits:6.2f} digits"
        yield f"     {line.number:<9}{digits}{band}: {line.verdict}{why}"
    if report.textbook is not None:
        yield f"     mpmath's own functions agree to {report.textbook:.1f} digits"
    for figure in report.figures:
        p = figure.published
        yield f"     {p.quantity} at t = {shown(p.t)}: {figure.verdict}  ({one_line(p.cite)})"
        yield f"         printed {p.value}"
        yield f"         ours    {figure.ours}"
    if proposing:
        bands = [f"{name:<8} = [{low}, {high}]" for name, (low, high) in report.proposal.items()]
        yield from ["", "[expect]", *bands, ""] if bands else ["     no digits are left: no band"]
