"""A plugin of pytest: the fixture ``assert_digits``, and the digits of each test at the end.

pytest finds it where polhode is installed; polhode itself is imported by the first test that asks
for the fixture.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from polhode.judging.judgement import Judgement

#: Properties of a test, one of each for each judgement; they stand in JUnit's XML.
_DIGITS, _SCENE = "correct_digits", "correct_digits_scene"
#: With --polhode-report all that stands on the page.
_REPORT, _OPTION = "correct_digits_report", "--polhode-report"
_MOST_TIMES = 101  # of a judgement on the page


class _Digits:
    """The digits of each test, from the reports, which pytest-xdist's processes send too."""

    def __init__(self, place: Path | None) -> None:
        self.lines: dict[str, list[str]] = {}
        self.rows: dict[str, list[dict[str, Any]]] = {}
        self.place = place

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """The last report of a test has all its properties."""
        values: dict[str, list[Any]] = {
            key: [value for name, value in report.user_properties if name == key]
            for key in (_DIGITS, _SCENE, _REPORT)
        }
        failed = report.failed or any(not row["passed"] for row in self.rows.get(report.nodeid, ()))
        self.rows[report.nodeid] = [
            {"test": report.nodeid, "passed": not failed, **row} for row in values[_REPORT]
        ]
        if values[_DIGITS]:
            self.lines[report.nodeid] = [
                f"{report.nodeid}: {digits:.2f} correct digits of {scene}"
                for digits, scene in zip(values[_DIGITS], values[_SCENE], strict=True)
            ]

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """The digits of each test, of those that failed too."""
        if self.lines:
            terminalreporter.section("correct digits")
            for lines in self.lines.values():
                for line in lines:
                    terminalreporter.line(line)

    def pytest_sessionfinish(self) -> None:
        """The page of all judgements, in the process that has all reports."""
        if self.place is None:
            return
        from polhode.output import report_page

        rows = [row for rows in self.rows.values() for row in rows]
        report_page.write(report_page.of_tests(self.place, rows))


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option for a page of all judgements."""
    help_text = "write the judgements of assert_digits as a page, .html or .md"
    parser.addoption(_OPTION, metavar="FILE", help=help_text)


def pytest_configure(config: pytest.Config) -> None:
    """A place for what the tests find."""
    place = config.getoption(_OPTION)
    if place is not None:
        from polhode.common.errors import BadInput
        from polhode.common.files import check_writable, refuse_foreign
        from polhode.output.report_page import ENDINGS

        try:
            check_writable(Path(place), ENDINGS)
            refuse_foreign(Path(place))
        except BadInput as fault:
            raise pytest.UsageError(f"{_OPTION}: {fault}") from None
    is_worker = hasattr(config, "workerinput")  # of pytest-xdist
    digits = _Digits(Path(place) if place and not is_worker else None)
    config.pluginmanager.register(digits, "polhode-digits")


@pytest.fixture
def assert_digits(request: pytest.FixtureRequest) -> Callable[..., Judgement]:
    """:func:`polhode.testing.assert_digits`; its digits are told at the end, and in JUnit's XML."""
    from polhode import testing

    def tell(judgement: Judgement) -> None:
        properties = request.node.user_properties
        properties.append((_DIGITS, round(judgement.worst, 2)))
        properties.append((_SCENE, judgement.reference.scene.name))
        if request.config.getoption(_OPTION):
            properties.append((_REPORT, _row_of(judgement)))

    return partial(testing.assert_digits, told=tell)


def _row_of(judgement: Judgement) -> dict[str, Any]:
    """What a page tells of a judgement, in plain values, which pytest-xdist sends."""
    from polhode.common.errors import few
    from polhode.output.accuracy import AccuracyLine

    line = AccuracyLine("", judgement)
    shown = few(len(judgement.times), _MOST_TIMES)
    digits = [line.digits[k] for k in shown]
    return {
        "scene": judgement.reference.scene.name,
        "worst": judgement.worst,
        "verdict": judgement.verdict,
        "t": [float(judgement.times[k]) for k in shown],
        "digits": [math.nan if d is None else d for d in digits],
    }
