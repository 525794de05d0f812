"""A plugin of pytest: the fixture ``assert_digits``, and the digits of each test at the end.

pytest finds it where polhode is installed; polhode itself is imported by the first test that asks
for the fixture.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, ParamSpec

import pytest

if TYPE_CHECKING:
    from polhode.judging.score.judgement import Judgement

P = ParamSpec("P")

_LINES = pytest.StashKey[list[str]]()


def pytest_configure(config: pytest.Config) -> None:
    """A place for what the tests find."""
    config.stash[_LINES] = []


@pytest.fixture
def assert_digits(
    request: pytest.FixtureRequest, record_property: Callable[[str, object], None]
) -> Callable[..., Judgement]:
    """:func:`polhode.testing.assert_digits`; its digits are told at the end, and in JUnit's XML."""
    from polhode import testing

    def tell(found: Judgement) -> None:
        record_property("correct_digits", round(found.worst, 2))
        told = f"{found.worst:.2f} correct digits of {found.reference.scene.name}"
        request.config.stash[_LINES].append(f"{request.node.nodeid}: {told}")

    return _telling(testing.assert_digits, tell)


def _telling(
    function: Callable[P, Judgement], tell: Callable[[Judgement], None]
) -> Callable[P, Judgement]:
    """A function whose answer is told, too."""

    @wraps(function)
    def asked(*arguments: P.args, **options: P.kwargs) -> Judgement:
        found = function(*arguments, **options)
        tell(found)
        return found

    return asked


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, exitstatus: int, config: pytest.Config
) -> None:
    """The digits of each test that passed."""
    if lines := config.stash.get(_LINES, []):
        terminalreporter.section("correct digits")
        for line in lines:
            terminalreporter.line(line)
