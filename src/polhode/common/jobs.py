"""Jobs of plain data carried out by threads here, or by any executor, and kept as they end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from polhode.common import executors
from polhode.common.checkpoint import Arrays, JobCheckpoint
from polhode.common.progress import Progress, Stop

if TYPE_CHECKING:
    import numpy.typing as npt

J = TypeVar("J")
J_contra = TypeVar("J_contra", contravariant=True)
T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Solver(Protocol[J_contra, T_co]):
    """What does one job; asked to stop, it may give back what it has, which then does not count."""

    def __call__(self, job: J_contra, stop: Stop | None = None, /) -> T_co:
        """The job's result."""
        ...


def carried_out(
    solve: Solver[J, T],
    jobs: Sequence[J],
    sizes: Sequence[int],
    count: int | None = None,
    executor: Executor | None = None,
    kept: JobCheckpoint | None = None,
    packed: Callable[[T], Mapping[str, npt.ArrayLike]] | None = None,
    unpacked: Callable[[Arrays], T] | None = None,
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


class _Whole(Generic[J, T]):
    """A job's result, or None where it was stopped before its end."""

    def __init__(self, solve: Solver[J, T]) -> None:
        self._solve = solve

    def __call__(self, job: J, stop: Stop) -> T | None:
        found = self._solve(job, stop)
        return None if stop() else found


def _only_whole(ready: Callable[[int, T], None]) -> Callable[[int, T | None], None]:
    def handed(at: int, result: T | None) -> None:
        if result is not None:
            ready(at, result)

    return handed
