"""What the verbs share: exit codes, options, and what goes to which stream."""

from __future__ import annotations

import argparse
import errno
import io
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.common.files import is_stdout, write_stdout
from polhode.common.interrupts import INTERRUPTED as INTERRUPTED
from polhode.common.interrupts import hear, heard
from polhode.common.text_tables import aligned, printable
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.expression import ExpressionError
from polhode.scenes.given_numbers import TIME, in_text
from polhode.scenes.output_times import even_times
from polhode.scenes.validation import MAX_SAMPLES
from polhode.scenes.variation.vary import numbers

if TYPE_CHECKING:
    from polhode.common.checkpoint import Checkpoint
    from polhode.scenes.scene import Scene

LONG = 10.0  # seconds of a proof that are foretold
DONE, FAILED, BAD_INPUT, NOT_REACHED = 0, 1, 2, 3


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


def whole(text: str) -> int:
    """An option that is a whole number."""
    try:
        if len(text) > 18 and text.strip("+-0123456789_ ") == "":
            expected = f"a whole number of at most 18 digits, not {text[:40]!r}"
            raise argparse.ArgumentTypeError(expected)
        return int(text[:40])  # a longer one is none
    except ValueError:
        raise argparse.ArgumentTypeError(f"a whole number, not {text[:40]!r}") from None


def word(text: str) -> str:
    """An argument that names a case or a file."""
    if not text:
        raise argparse.ArgumentTypeError("a name, not ''")
    return text


def folder(text: str) -> str:
    """An option that names a folder."""
    if not text:
        raise argparse.ArgumentTypeError("a folder's name; . is the current one")
    return text


def _columns() -> int:
    """The width of stderr's terminal; 80 where it does not tell."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError):
        return 80


def positive(text: str) -> int:
    """An option that is a whole number above 0."""
    steps = whole(text)
    if steps < 1:
        raise argparse.ArgumentTypeError(f"1 or more, not {steps}")
    return steps


def seconds(text: str) -> float:
    """An option that is a time in seconds, above 0."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not 0 < found < math.inf:
        raise argparse.ArgumentTypeError(f"seconds above 0, not {text[:40]!r}")
    return found


def time_options(parser: argparse.ArgumentParser) -> None:
    """The options: times listed, or evenly spaced from 0 on."""
    at = "output times instead of the scene's; one of them may be FROM:TO:N, for N evenly spaced"
    parser.add_argument("--at", metavar="T,T...", help=at)
    parser.add_argument("--end", metavar="T", help="last time instead of the scene's")
    spacing = parser.add_mutually_exclusive_group()
    spacing.add_argument(
        "--samples",
        type=whole,
        metavar="N",
        help="so many times from 0 to the end, both included (as many as the scene's)",
    )
    spacing.add_argument(
        "--every", metavar="DT", help="the times 0, DT, 2 DT, ... that are not beyond the end"
    )


def times_of(options: argparse.Namespace, scene: Scene) -> Sequence[Exact]:
    """The times that are asked for, exact: the scene's own unless an option says otherwise."""
    even = {"--end": options.end, "--samples": options.samples, "--every": options.every}
    if options.at is not None:
        for key, value in even.items():
            if value is not None:
                raise BadInput(scene.name, key, value, "no value together with --at")
        return tuple(numbers(options.at, "--at", scene.name, scene.units, TIME))
    if all(value is None for value in even.values()):
        return scene.times
    end = scene.end if options.end is None else _time(scene, "--end", options.end)
    if sign(end) == 0:
        raise BadInput(scene.name, "--end", options.end, "a time other than 0")
    if options.every is not None:
        return _multiples(scene, end, options.every)
    samples = max(2, len(scene.times)) if options.samples is None else options.samples
    if not 2 <= samples <= MAX_SAMPLES:
        raise BadInput(scene.name, "--samples", samples, f"a whole number from 2 to {MAX_SAMPLES}")
    return even_times(end, samples)


def _multiples(scene: Scene, end: Exact, text: str) -> Sequence[Exact]:
    """The multiples of a step from 0 to the end."""
    step = _time(scene, "--every", text)
    if sign(step) <= 0:
        raise BadInput(scene.name, "--every", text, "a time above 0; --end says the direction")
    last = abs(end)
    ratio = to_double(last / step)
    if not 1 <= ratio < MAX_SAMPLES:
        expected = f"a time that makes two to {MAX_SAMPLES} times until t = {to_double(end):g}"
        raise BadInput(scene.name, "--every", text, expected)
    count = round(ratio)
    count -= sign(count * step - last) > 0  # the double may be rounded to a whole number
    return even_times(count * step * sign(end), count + 1)


def _time(scene: Scene, key: str, text: str) -> Exact:
    try:
        return in_text(text, scene.units, TIME)
    except ExpressionError as fault:
        raise BadInput(scene.name, key, text, f"a time ({fault})") from None


def refuse_two_on_stdout(path: Path, json: bool) -> None:
    """Refuse a file that is stdout beside results as JSON, which go there too."""
    if json and is_stdout(path):
        raise BadInput(str(path), "-o", None, "a file: the results as JSON go to stdout")


def tell_certificate(name: str, file: str) -> None:
    """Where a scene's certificate is, and what checks it."""
    if is_stdout(Path(file)):
        note(f"{name}: certificate on the standard output; polhode verify - reads it")
    else:
        note(f"{name}: certificate in {file}; polhode verify {file}")


def print_json(value: Any) -> None:
    """One JSON value on stdout."""
    from polhode.common.json_text import as_json

    write_stdout(as_json(value))


def print_rows(answer: dict[str, Any], *, short: bool = False) -> None:
    """The rows of an answer as a table on stdout; ``short``: see ``rows_of``."""
    from polhode.output.csv_tables import rows_of

    header, rows = rows_of(answer, short=short)
    print_table(header, rows)


def print_table(header: Any, rows: Any) -> None:
    """A table of strings in columns on stdout."""
    for line in aligned(header, rows):
        say(line)


def note(text: str) -> None:
    """A line on stderr; nowhere where that takes no more, as nobody could be told of it."""
    try:
        print(printable(text), file=sys.stderr)
    except OSError:
        sys.stderr = _Nowhere()


def goes_on(kept: Checkpoint | None) -> int:
    """The exit code of work that was interrupted; a line says what is kept of it."""
    if kept is not None:
        note(f"polhode: the same command continues from {kept.folder}")
    return INTERRUPTED


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

    def say(self, text: str, at_once: bool = False) -> None:
        """The line's new text; ``at_once``: even if nothing has taken long yet."""
        if sys.stderr.isatty() and (at_once or time.monotonic() - self.began > 1):
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
