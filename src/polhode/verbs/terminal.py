"""What the verbs share: exit codes, options, and what goes to which stream."""

from __future__ import annotations

import errno
import io
import os
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput, printable
from polhode.common.files import is_stdout, write_stdout
from polhode.common.interrupts import INTERRUPTED as INTERRUPTED
from polhode.common.interrupts import ProgressLine as ProgressLine
from polhode.common.interrupts import hear, heard

if TYPE_CHECKING:
    from polhode.results.result import Result

LONG = 10.0  # seconds of a proof that are foretold
DONE, FAILED, BAD_INPUT, NOT_REACHED = 0, 1, 2, 3


class NotEnough(Exception):
    """A result that stands, and does not reach what was wanted; its text says why."""

    def __init__(self, result: Result, text: str) -> None:
        self.result = result
        super().__init__(text)


class _ClosedStdout(io.TextIOBase):
    """A stdout that the caller closed: the first result that goes there is refused."""

    def write(self, text: str | bytes) -> int:
        if text:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        return 0

    @property
    def buffer(self) -> _ClosedStdout:
        """What takes bytes."""
        return self


class _Nowhere(io.TextIOBase):
    """A stderr that takes no more: what goes there is lost."""

    def write(self, text: str) -> int:
        return len(text)


def prepare() -> None:
    """Streams that are there, and that take any character; SIGTERM ends work as Ctrl-C does."""
    if sys.stdout is None:
        sys.stdout = _ClosedStdout()
    if sys.stderr is None:
        sys.stderr = _Nowhere()
    heard.came, heard.loaded = False, True
    if threading.current_thread() is threading.main_thread():
        hear()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def give_up_stdout() -> None:
    """Let what is left in stdout's buffer go nowhere, so that leaving Python is no fault."""
    if not isinstance(sys.stdout, _ClosedStdout):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def say(text: str) -> None:
    """A result for people, on stdout."""
    write_stdout(printable(text) + "\n")


def refuse_two_on_stdout(path: Path, json: bool) -> None:
    """Refuse a file that is stdout beside results as JSON, which go there too."""
    if json and is_stdout(path):
        raise BadInput(str(path), "-o", None, "a file: the results as JSON go to stdout")


def print_json(value: Any) -> None:
    """One JSON value on stdout."""
    from polhode.common.texts import as_json

    write_stdout(as_json(value))


def note(text: str) -> None:
    """A line on stderr; nowhere where that takes no more, as nobody could be told of it."""
    try:
        print(printable(text), file=sys.stderr)
    except OSError:
        sys.stderr = _Nowhere()
