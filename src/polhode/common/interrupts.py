"""How work is interrupted: Ctrl-C (and SIGTERM, see polhode.verbs.terminal) waits for what is short
and must be whole, such as the writing of files."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from polhode.common.signals import heard


@dataclass
class Waiting:
    """Whether an interruption came meanwhile; ``forget`` takes it back."""

    came: bool = False

    def forget(self) -> None:
        """What was waited for is all there is: nothing is left to interrupt."""
        self.came = False


@contextmanager
def delayed() -> Iterator[Waiting]:
    """Let the block end first; then KeyboardInterrupt, if it was asked for.  A second one is heard.

    In the main thread; others are not interrupted.
    """
    waiting = Waiting()
    if threading.current_thread() is not threading.main_thread():
        yield waiting
        return

    def note(number: int, _: object) -> None:
        if waiting.came:
            raise KeyboardInterrupt
        waiting.came = True

    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    ours = [
        (number, handler)
        for number, handler in zip((signal.SIGINT, signal.SIGTERM), before, strict=True)
        if handler in (signal.default_int_handler, heard)
    ]
    for number, _ in ours:
        signal.signal(number, note)
    try:
        yield waiting
    finally:
        for number, handler in ours:
            signal.signal(number, handler)
    if waiting.came:
        raise KeyboardInterrupt
