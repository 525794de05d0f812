"""heyoka on one thread while blocks are refined: threads cost more than the kernels do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

import heyoka as hy

_LOCK = Lock()
_STATE = {"inside": 0, "before": 0}


@contextmanager
def one_thread() -> Iterator[None]:
    """Within it heyoka's compiled functions run on the caller's thread alone.

    heyoka has one setting for the process: the first to enter sets it, the last to leave puts it
    back, so that refinements on several threads do not disturb each other.
    """
    with _LOCK:
        if _STATE["inside"] == 0:
            _STATE["before"] = hy.get_nthreads()
            hy.set_nthreads(1)
        _STATE["inside"] += 1
    try:
        yield
    finally:
        with _LOCK:
            _STATE["inside"] -= 1
            if _STATE["inside"] == 0:
                hy.set_nthreads(_STATE["before"])
