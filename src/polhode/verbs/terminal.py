"""What the verbs share: exit codes, options, and what goes to which stream."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.common.files import is_stdout, write_stdout
from polhode.common.interrupts import INTERRUPTED as INTERRUPTED
from polhode.common.interrupts import hear, heard
from polhode.common.text_tables import printable

if TYPE_CHECKING:
    from polhode.results.result import Result

LONG = 10.0  # seconds of a proof that are foretold
DONE, FAILED, BAD_INPUT, NOT_REACHED = 0, 1, 2, 3


class NotEnough(Exception):
    """A result that stands, and does not do what was asked; its text says why."""

    def __init__(self, found: Result, text: str) -> None:
        self.found = found
        super().__init__(text)


class _Closed(io.TextIOBase):
    """A stdout that the caller closed: the first result that goes there is refused."""

    def write(self, text: str) -> int:
        if text:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        return 0


class _Nowhere(io.TextIOBase):
    """A stderr that takes no more: what goes there is lost."""

    def write(self, text: str) -> int:
        return len(text)


def prepare() -> None:
    """Streams that are there, and that take any character; SIGTERM ends work as Ctrl-C does."""
    if sys.stdout is None:
        sys.stdout = _Closed()
    if sys.stderr is None:
        sys.stderr = _Nowhere()
    heard.came, heard.loaded = False, True
    if threading.current_thread() is threading.main_thread():
        hear()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def deaf() -> None:
    """From now on neither Ctrl-C nor SIGTERM is heard."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)


def give_up_stdout() -> None:
    """Let what is left in stdout's buffer go nowhere, so that leaving Python is no fault."""
    if not isinstance(sys.stdout, _Closed):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def say(text: str) -> None:
    """A result for people, on stdout."""
    write_stdout(printable(text) + "\n")


def _columns() -> int:
    """The width of stderr's terminal; 80 where it does not tell."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError):
        return 80


def refuse_two_on_stdout(path: Path, json: bool) -> None:
    """Refuse a file that is stdout beside results as JSON, which go there too."""
    if json and is_stdout(path):
        raise BadInput(str(path), "-o", None, "a file: the results as JSON go to stdout")


def print_json(value: Any) -> None:
    """One JSON value on stdout."""
    from polhode.common.json_text import as_json

    write_stdout(as_json(value))


def note(text: str) -> None:
    """A line on stderr; nowhere where that takes no more, as nobody could be told of it."""
    try:
        print(printable(text), file=sys.stderr)
    except OSError:
        sys.stderr = _Nowhere()


class ProgressLine:
    """One line on stderr, on a terminal only, once something takes longer than a second."""

    def __init__(self, verb: str) -> None:
        self.verb, self.shown = verb, False
        self.began = time.monotonic()
        self.fraction, self.first = 0.0, (self.began, 0.0)

    def __enter__(self) -> ProgressLine:
        return self

    def __exit__(self, *_: object) -> None:
        self.clear()

    def show(self, fraction: float, steps: int, what: str = "steps") -> None:
        """How far the work is, and how long it will go on at this pace."""
        now = time.monotonic()
        if fraction < self.fraction or self.fraction == 0.0:  # a new one
            self.first = now, fraction
        self.fraction = fraction
        passed, done = now - self.first[0], fraction - self.first[1]
        left = f", {passed / done * (1 - fraction):.0f} s left" if passed > 1 and done > 0 else ""
        self.say(f"{100 * fraction:.1f} %, {steps} {what}{left}")

    def foretelling(self, told: Callable[[float], None]) -> Callable[[float, int], None]:
        """What shows progress, and tells once, early, how many seconds the work will take."""
        began, asked = time.monotonic(), False

        def show(fraction: float, steps: int) -> None:
            nonlocal asked
            passed = time.monotonic() - began
            if not asked and passed > 2 and fraction > 0:
                asked = True
                self.clear()
                told(passed / fraction)
            self.show(fraction, steps)

        return show

    def say(self, text: str) -> None:
        """The line's new text, once something has taken long."""
        if sys.stderr.isatty() and time.monotonic() - self.began > 1:
            line = f"{self.verb}: {printable(text)}"
            sys.stderr.write("\r\x1b[K" + line[: _columns() - 1])  # a line that wraps stays behind
            sys.stderr.flush()
            self.shown = True

    def clear(self) -> None:
        """The line wiped."""
        if self.shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
            self.shown = False
