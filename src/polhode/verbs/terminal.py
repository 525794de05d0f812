"""What the verbs share: exit codes, options, and what goes to which stream."""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

from polhode.common.errors import BadInput
from polhode.common.text import aligned
from polhode.numbers import expression
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError
from polhode.output import results
from polhode.scenes.scene import Scene

DONE, FAILED, BAD_INPUT, NOT_REACHED, INTERRUPTED = 0, 1, 2, 3, 130


def whole(text: str) -> int:
    """An option that is a whole number."""
    try:
        if len(text) > 18:  # int() itself would take thousands of digits
            raise ValueError
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"a whole number, not {text[:40]!r}") from None


def positive(text: str) -> int:
    """An option that is a whole number above 0."""
    steps = whole(text)
    if steps < 1:
        raise argparse.ArgumentTypeError(f"1 or more, not {steps}")
    return steps


def read_times(scene: Scene, text: str) -> tuple[Exact, ...]:
    """The times of ``--at``, exact."""
    times = []
    for item in text.split(","):
        try:
            times.append(expression.number(item))
        except ExpressionError as fault:
            raise BadInput(scene.name, "--at", item, f"a time ({fault})") from None
    return tuple(times)


def print_json(value: Any) -> None:
    """One JSON value on stdout."""
    sys.stdout.write(results.as_json(value))


def print_rows(answer: dict[str, Any]) -> None:
    """The rows of an answer as a table on stdout."""
    header, rows = results.rows_of(answer)
    print_table(header, rows)


def print_table(header: Any, rows: Any) -> None:
    """A table of strings in columns on stdout."""
    for line in aligned(header, rows):
        print(line)


def note(text: str) -> None:
    """A line on stderr."""
    print(text, file=sys.stderr)


class Progress:
    """One line on stderr, on a terminal only, once something takes longer than a second."""

    def __init__(self, verb: str) -> None:
        self.verb, self.shown = verb, False
        self.began = time.monotonic()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self.clear()

    def show(self, fraction: float, steps: int) -> None:
        """How far an integration is."""
        self.say(f"{100 * fraction:.1f} %, {steps} steps")

    def say(self, text: str) -> None:
        """The line's new text."""
        if sys.stderr.isatty() and time.monotonic() - self.began > 1:
            sys.stderr.write(f"\r\x1b[K{self.verb}: {text}")
            sys.stderr.flush()
            self.shown = True

    def clear(self) -> None:
        """The line wiped."""
        if self.shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
            self.shown = False
