"""Work that must end in time."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple


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

    In the main thread of systems with interval timers; elsewhere nothing is limited.
    """
    main = threading.current_thread() is threading.main_thread()
    if not main or not hasattr(signal, "setitimer"):
        yield
        return

    def ring(*_: object) -> None:
        raise TooLong

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
