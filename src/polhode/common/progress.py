"""How progress is shown: in Python by tqdm's bar, where it is installed; else by one line."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from polhode.common.text_tables import printable

#: Told the part done, from 0 to 1, and how many of what is counted that is.
Progress = Callable[[float, int], None]

#: Told what is being done, in words.
Message = Callable[[str], None]

#: Asked now and then: whether the work is to end before its time.
Stop = Callable[[], bool]


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
        began, is_foretold = time.monotonic(), False

        def show(fraction: float, steps: int) -> None:
            nonlocal is_foretold
            passed = time.monotonic() - began
            if not is_foretold and passed > 2 and fraction > 0:
                is_foretold = True
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

        def told(fraction: float, count: int) -> None:
            shown.n = min(100.0, 100 * fraction)
            shown.set_postfix_str(f"{count} done", refresh=False)
            shown.refresh()

        yield told
