"""Jobs of plain data carried out by threads here, or by any executor, and kept as they end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from typing import Any, TypeVar

from polhode.common import executors
from polhode.dynamics.kept import Kept

T = TypeVar("T")

#: Told the part done, from 0 to 1, and how many orbits that is.
Progress = Callable[[float, int], None]


def carried_out(
    solve: Callable[..., T],
    jobs: Sequence[Any],
    sizes: Sequence[int],
    count: int | None = None,
    executor: Executor | None = None,
    kept: Kept | None = None,
    packed: Callable[[T], dict[str, Any]] | None = None,
    unpacked: Callable[[dict[str, Any]], T] | None = None,
    progress: Progress | None = None,
    processes: bool = False,
) -> tuple[list[T | None], bool]:
    """The result of each job, None where Ctrl-C came first; and whether it did.

    ``solve``: of a job and a function that says whether to stop.  ``sizes``: orbits of each job.
    ``count``: threads, or processes of our own where ``processes``: for jobs that hold the lock
    that Python's threads share; one of those is this process itself.  ``packed``, ``unpacked``: a
    result as arrays, and back, for ``kept``.
    """
    found: list[T | None] = [None] * len(jobs)
    done = 0

    def told(size: int) -> None:
        nonlocal done
        done += size
        if progress is not None:
            progress(done / max(1, sum(sizes)), done)

    for k in range(len(jobs)):
        held = None if kept is None or unpacked is None else kept.load(k)
        if held is not None and unpacked is not None:
            found[k] = unpacked(held)
            told(sizes[k])
    left = [k for k in range(len(jobs)) if found[k] is None]

    def ready(at: int, result: T) -> None:
        k = left[at]
        found[k] = result
        if kept is not None and packed is not None:
            kept.save(k, packed(result))
        told(sizes[k])

    waiting = [jobs[k] for k in left]
    if executor is not None:
        finished, lost = executors.elsewhere(solve, waiting, ready, executor)
        for at in lost:
            ready(at, solve(waiting[at]))
        return found, not finished
    if processes:
        try:
            for at, result in enumerate(executors.in_order(solve, waiting, count or 1)):
                ready(at, result)
        except KeyboardInterrupt:
            return found, True
        return found, False
    whole = executors.here(_Whole(solve), waiting, _only_whole(ready), count)
    return found, not whole


class _Whole:
    """A job's result, or None where it was stopped before its end."""

    def __init__(self, solve: Callable[..., Any]) -> None:
        self._solve = solve

    def __call__(self, job: Any, stop: Callable[[], bool]) -> Any:
        found = self._solve(job, stop)
        return None if stop() else found


def _only_whole(ready: Callable[[int, Any], None]) -> Callable[[int, Any], None]:
    def handed(at: int, result: Any) -> None:
        if result is not None:
            ready(at, result)

    return handed
