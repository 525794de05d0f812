"""The promise that holds for any input at all, and the machinery that looks whether it is kept.

No traceback; where the input is refused, exit code 2, nothing on stdout, and one line on stderr
that names the file, the key and what was expected; nothing written that was not asked for; an end
within so much processor time and memory; no thread, process or file left behind.
"""

import contextlib
import io
import os
import re
import resource
import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

from polhode import BadInput, cli

SECONDS = 30.0  # of processor time for one case
MEGABYTES = 1500  # that one case may add to the largest memory so far
CODES = {0, 2, 3}
REFUSAL = re.compile(r"polhode: [^\n]+: expected [^\n]+\n")


class Slow(BaseException):
    """A case that takes too much processor time; no handler of the program's own stops it."""


@contextlib.contextmanager
def limited(seconds: float = SECONDS) -> Iterator[None]:
    """Processor time, not the clock's: the machine may be busy."""

    def ring(*_: Any) -> None:
        raise Slow(f"more than {seconds:g} s of processor time")

    before = signal.signal(signal.SIGVTALRM, ring)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def leftovers() -> tuple[Any, ...]:
    """What a case must leave as it is: files, threads, processes, open handles."""
    files = {p: (p.stat().st_size, p.stat().st_mtime_ns) for p in Path().iterdir()}
    handles = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").is_dir() else 0
    threads = {t.name for t in threading.enumerate()}
    return files, threads, children(), handles


def children() -> int:
    """Processes begun by this one that are there, of multiprocessing and others."""
    count = 0
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # ended meanwhile
            count += int(path.read_text().rpartition(")")[2].split()[1]) == os.getpid()
    return count


def broken(
    work: Callable[[], Any], outputs: Callable[[Any], set[Path]] = lambda answer: set()
) -> tuple[list[str], Any]:
    """Which parts of the promise some work breaks, and what it gave.

    ``outputs``: the files that may be written by work that gave this.
    """
    before, peak = leftovers(), _peak()
    faults: list[str] = []
    answer: Any = None
    try:
        with limited():
            answer = work()
    except Slow as slow:
        faults.append(str(slow))
    except Exception:
        faults.append(traceback.format_exc())
    after = leftovers()
    for files in (before[0], after[0]):
        for path in outputs(answer):
            files.pop(path, None)
    names = ("files", "threads", "processes", "open handles")
    for name, old, new in zip(names, before, after, strict=True):
        if name != "open handles" and old != new:
            faults.append(f"{name} changed: {old} -> {new}")
        elif name == "open handles" and new > old + 8:  # libraries open some for good
            faults.append(f"{new - old} handles left open")
    if _peak() - peak > MEGABYTES:
        faults.append(f"{_peak() - peak} MB of memory")
    return faults, answer


def of_command(arguments: list[str]) -> tuple[list[str], int | None]:
    """The faults of a command, and its exit code; unless refused, it may write its -o, or new's."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2))

    def outputs(code: int | None) -> set[Path]:
        if code not in CODES - {2}:
            return set()
        named = {Path(name) for flag, name in pairwise(arguments) if flag in ("-o", "new")}
        return named | {path.with_name(f"{path.name}.json") for path in named if path.name}

    def work() -> int:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            return cli.main(arguments)

    faults, code = broken(work, outputs)
    if faults:
        return faults, code
    printed, notes = (_read(stream) for stream in (out, err))
    if code not in CODES:
        faults.append(f"exit code {code}")
    if "Traceback" in notes:
        faults.append(notes)
    if code == 2:
        if printed:
            faults.append(f"refused, and yet on stdout: {printed[:200]!r}")
        if not REFUSAL.fullmatch(notes):
            faults.append(f"not one line of refusal: {notes[:500]!r}")
    if any(not (c.isprintable() or c == "\n") for c in notes + printed):
        faults.append("a character that is not for terminals")
    return faults, code


def _read(stream: io.TextIOWrapper) -> str:
    """What was written; of bytes that are no text (a figure), nothing."""
    stream.flush()
    content: bytes = stream.buffer.getvalue()  # type: ignore[attr-defined]
    return "" if b"\0" in content or content.startswith(b"<?xml") else content.decode()


def of_call(call: Callable[[], Any]) -> tuple[list[str], bool]:
    """The faults of a call in Python, which may raise BadInput of one line; whether it did."""

    def work() -> bool:
        try:
            call()
        except BadInput as refusal:
            text = str(refusal)
            if "\n" in text or ": expected " not in text or not text.isprintable():
                raise AssertionError(f"not a line of refusal: {text!r}") from None
            return True
        return False

    faults, refused = broken(work)
    return faults, bool(refused)


def _peak() -> int:
    """The largest memory of this process so far, in megabytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
