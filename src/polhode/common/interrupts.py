"""What ends or accompanies a long computation: Ctrl-C, a time limit, locks, progress."""

from __future__ import annotations

import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING, NamedTuple
from weakref import ReferenceType, WeakSet, ref

from polhode.common.errors import printable

if TYPE_CHECKING:
    from types import FrameType


# --- interrupts -----------------------------------------------------------------------------------
#
# How work is interrupted: by Ctrl-C, and by SIGTERM in a command.
#
# What is short and must be whole, such as the writing of files, they wait for. A command imports
# this before anything else, to hear them: it imports next to nothing.


INTERRUPTED = 130  # the exit code of an interrupted command


class _Heard:
    """KeyboardInterrupt, and a note that a signal came; the end, while polhode is being loaded.

    Compiled libraries that are being loaded may turn the exception into another one.
    """

    def __init__(self) -> None:
        self.came = False
        self.loaded = False

    def __call__(self, number: int, frame: FrameType | None) -> None:
        if not self.loaded:  # nothing has been done yet
            try:
                os.write(2, b"polhode: interrupted\n")
            finally:
                os._exit(INTERRUPTED)
        self.came = True
        raise KeyboardInterrupt


heard = _Heard()


def hear() -> None:
    """Let Ctrl-C and SIGTERM be heard, where nobody has said otherwise; in the main thread."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, heard)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, heard)  # ends like Ctrl-C


class Delay:
    """Lets a block end first; then KeyboardInterrupt, if it was asked for.  A second one is heard.

    In the main thread; others are not interrupted.  ``came``: whether one came meanwhile.
    """

    def __init__(self) -> None:
        self.came = False
        self._before: dict[signal.Signals, signal._HANDLER] = {}

    def __enter__(self) -> Delay:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                handler = signal.getsignal(number)
                if handler in (signal.default_int_handler, heard):
                    self._before[number] = handler
                    signal.signal(number, self._note)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        if self.came and kind is None:
            raise KeyboardInterrupt

    def forget(self) -> None:
        """What was waited for is all there is: nothing is left to interrupt."""
        self.came = False

    def _note(self, number: int, _: object) -> None:
        if self.came:
            raise KeyboardInterrupt
        self.came = True


# --- deadline -------------------------------------------------------------------------------------
#
# Work that must end in time.


class TooLong(Exception):
    """The work took longer than it may."""


class Deadline(NamedTuple):
    """The reading of time.monotonic() at which work is to end."""

    at: float = math.inf

    @classmethod
    def after(cls, seconds: float) -> Deadline:
        """So many seconds from now."""
        return cls(time.monotonic() + seconds)

    @property
    def passed(self) -> bool:
        """Whether it is over."""
        return time.monotonic() > self.at

    def check(self) -> None:
        """Raise TooLong once it is over."""
        if self.passed:
            raise TooLong


#: For work that may take as long as it takes.
NONE = Deadline()


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Raise TooLong inside the block once so many seconds have passed.

    In the main thread of systems with interval timers; elsewhere nothing is limited.  An alarm that
    was set before rings when it was to ring, or after the block.
    """
    main = threading.current_thread() is threading.main_thread()
    if not main or not hasattr(signal, "setitimer"):
        yield
        return

    def ring(*_: object) -> None:
        raise TooLong

    left, interval = signal.setitimer(signal.ITIMER_REAL, 0)
    before, began = signal.signal(signal.SIGALRM, ring), time.monotonic()
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        if left:
            soon = max(1e-6, left - time.monotonic() + began)
            signal.setitimer(signal.ITIMER_REAL, soon, interval)


# --- locks ----------------------------------------------------------------------------------------
#
# The locks of polhode, all of them, and the one order in which a thread may take them.
#
# Two threads that take the same two locks in different orders wait for each other for ever. So
# each lock has a place in an order, and a thread that holds one takes only those of later places:
# whoever compiles may need a precision, whoever holds a precision may look into a store, and
# nobody the other way. Every taking is checked, so that any test that takes them in a wrong order
# fails at once, with one thread or many.
#
# Nothing else that holds a lock while it computes belongs in polhode: properties are kept by
# :mod:`polhode.common.values`, and ``functools.lru_cache`` holds none.


class LockPlace(IntEnum):
    """What a lock guards, in the order of taking."""

    COMPILING = 1  # an integrator that all threads wait for, rather than each compile its own
    PRECISION = 2  # of mpmath's private context and of FLINT; may be taken again by its holder
    STORE = 3  # a few steps on plain containers, which call nothing


class Held:
    """``with Held(steps):`` runs a generator to its one yield, and on to its end afterwards.

    Ctrl-C or an alarm may raise between any two steps of Python.  What the generator holds it
    gives back however it ends: by an exception inside, or because nobody knows it any more.  An
    exception at the entry of what leaves the block keeps that frame alive with its traceback, as
    long as somebody keeps the exception: so the frame must not know the generator.
    """

    __slots__ = ("_steps",)

    def __init__(self, steps: Generator[None, None, None]) -> None:
        self._steps = steps

    def __enter__(self) -> None:
        try:
            next(self._steps)
        except BaseException:
            self._steps.close()
            raise

    @property
    def __exit__(self) -> Callable[..., None]:
        """What leaves the block: ``with`` looks it up before the block and drops it with it."""
        return _Leave(self._steps)


class _Leave(partial[None]):
    """Ends a generator that its own call refers to weakly; it is alive as long as this is."""

    __slots__ = ("steps",)
    steps: Generator[None, None, None]

    def __new__(cls, steps: Generator[None, None, None]) -> _Leave:
        leave = super().__new__(cls, _leave, ref(steps))
        leave.steps = steps
        return leave


def _leave(generator: ReferenceType[Generator[None, None, None]], *fault: object) -> None:
    steps = generator()
    if steps is not None:
        steps.close()


class Lock:
    """A lock with a place in the order; a forked child, where nobody holds it, gets a new one."""

    __slots__ = ("__weakref__", "bare", "place")

    def __init__(self, place: LockPlace) -> None:
        self.place = place
        self.renew()
        _ALL.add(self)

    def renew(self) -> None:
        """A lock that nobody holds."""
        again = self.place is LockPlace.PRECISION
        self.bare = threading.RLock() if again else threading.Lock()

    def held(self) -> Held:
        """``with lock.held():`` it is this thread's to the end of the block."""
        return Held(self._holding())

    def _holding(self) -> Generator[None, None, None]:
        places, place = _mine.places, self.place
        latest = places[-1] if places else 0
        assert place > latest or place is latest is LockPlace.PRECISION, (
            f"{place!r} after {latest!r}"
        )
        with self.bare:
            before = len(places)
            try:
                places.append(place)
                yield
            finally:
                del places[before:]


class _Mine(threading.local):
    """The places of the locks that this thread holds, the last one taken last."""

    def __init__(self) -> None:
        self.places: list[LockPlace] = []


_mine = _Mine()
_ALL: WeakSet[Lock] = WeakSet()


def _renew() -> None:
    for lock in _ALL:
        lock.renew()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew)


# --- progress -------------------------------------------------------------------------------------
#
# How progress is shown: in Python by tqdm's bar, where it is installed; else by one line.


#: Told the part done, from 0 to 1, and how many of what is counted that is.
Progress = Callable[[float, int], None]

#: Told what is being done, in words.
Message = Callable[[str], None]

#: Asked now and then: whether the work is to end before its time.
StopRequest = Callable[[], bool]


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
        passed, gain = now - self.first[0], fraction - self.first[1]
        left = f", {passed / gain * (1 - fraction):.0f} s left" if passed > 1 and gain > 0 else ""
        self.say(f"{100 * fraction:.1f} %, {steps} {what}{left}")

    def foretelling(self, foretell: Callable[[float], None]) -> Callable[[float, int], None]:
        """What shows progress, and tells once, early, how many seconds the work will take."""
        began, is_foretold = time.monotonic(), False

        def show(fraction: float, steps: int) -> None:
            nonlocal is_foretold
            passed = time.monotonic() - began
            if not is_foretold and passed > 2 and fraction > 0:
                is_foretold = True
                self.clear()
                foretell(passed / fraction)
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


def _columns() -> int:
    """The width of stderr's terminal; 80 where it does not tell."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError):
        return 80


@contextmanager
def bar(name: str) -> Iterator[Progress]:
    """What to call with the fraction done and a count, as long as the work lasts."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        with ProgressLine(name) as line:
            yield partial(line.show, what="done")
        return
    form = "{l_bar}{bar}| {elapsed}<{remaining}{postfix}"
    with tqdm(total=100.0, desc=name, bar_format=form, leave=False) as shown:

        def show(fraction: float, count: int) -> None:
            shown.n = min(100.0, 100 * fraction)
            shown.set_postfix_str(f"{count} done", refresh=False)
            shown.refresh()

        yield show
