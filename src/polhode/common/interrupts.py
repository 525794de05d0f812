"""How work is interrupted: by Ctrl-C, and by SIGTERM in a command.

What is short and must be whole, such as the writing of files, they wait for.  A command imports
this before anything else, to hear them: it imports next to nothing.
"""

from __future__ import annotations

import os
import signal

TYPE_CHECKING = False  # typing's, which takes longer to import than all of this

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


class Delay:
    """Lets a block end first; then KeyboardInterrupt, if it was asked for.  A second one is heard.

    In the main thread; others are not interrupted.  ``came``: whether one came meanwhile.
    """

    def __init__(self) -> None:
        self.came = False
        self._before: dict[signal.Signals, signal._HANDLER] = {}

    def __enter__(self) -> Delay:
        import threading

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
