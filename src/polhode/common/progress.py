"""A progress bar for Python: tqdm's where it is installed, which notebooks show; else one line."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: Told the part done, from 0 to 1, and how many of what is counted that is.
Progress = Callable[[float, int], None]

#: Told what is being done, in words.
Message = Callable[[str], None]

#: Asked now and then: whether the work is to end before its time.
Stop = Callable[[], bool]


@contextmanager
def bar(name: str) -> Iterator[Progress]:
    """What to call with the fraction done and a count, as long as the work lasts."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        with _line(name) as tell:
            yield tell
        return
    form = "{l_bar}{bar}| {elapsed}<{remaining}{postfix}"
    with tqdm(total=100.0, desc=name, bar_format=form, leave=False) as shown:

        def told(fraction: float, count: int) -> None:
            shown.n = min(100.0, 100 * fraction)
            shown.set_postfix_str(f"{count} done", refresh=False)
            shown.refresh()

        yield told


@contextmanager
def _line(name: str) -> Iterator[Progress]:
    terminal = sys.stderr.isatty()

    def told(fraction: float, count: int) -> None:
        if terminal:
            sys.stderr.write(f"\r\x1b[K{name}: {100 * fraction:.0f} %, {count} done")
            sys.stderr.flush()

    try:
        yield told
    finally:
        if terminal:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
