"""A plugin of pytest: the fixture ``assert_digits``, and the digits of each test at the end.

pytest finds it where polhode is installed; polhode itself is imported by the first test that asks
for the fixture.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from polhode.judging.score.judgement import Judgement

#: Properties of a test, one of each for each judgement; they stand in JUnit's XML.
_DIGITS, _SCENE = "correct_digits", "correct_digits_scene"


class _Digits:
    """The digits of each test, from the reports, which pytest-xdist's processes send too."""

    def __init__(self) -> None:
        self.lines: dict[str, list[str]] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """The last report of a test has all its properties."""
        values = {
            wanted: [value for name, value in report.user_properties if name == wanted]
            for wanted in (_DIGITS, _SCENE)
        }
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


def pytest_configure(config: pytest.Config) -> None:
    """A place for what the tests find."""
    config.pluginmanager.register(_Digits(), "polhode-digits")


@pytest.fixture
def assert_digits(request: pytest.FixtureRequest) -> Callable[..., Judgement]:
    """:func:`polhode.testing.assert_digits`; its digits are told at the end, and in JUnit's XML."""
    from polhode import testing

    def tell(found: Judgement) -> None:
        properties = request.node.user_properties
        properties.append((_DIGITS, round(found.worst, 2)))
        properties.append((_SCENE, found.reference.scene.name))

    return partial(testing.assert_digits, told=tell)
