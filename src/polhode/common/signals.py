"""The handler of a command's signals.  It imports next to nothing, and so is there first."""

from __future__ import annotations

import os
import signal
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import FrameType

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
