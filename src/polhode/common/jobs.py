"""Jobs of plain data carried out by threads here, or by any executor, and kept as they end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from typing import TYPE_CHECKING, Generic, NamedTuple, Protocol, TypeVar

from polhode.common import executors
from polhode.common.checkpoint import Arrays, JobCheckpoint
from polhode.common.interrupts import Delay
from polhode.common.progress import Progress, Stop

if TYPE_CHECKING:
    import numpy as np
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


class Finished(NamedTuple, Generic[T]):
    """``results``: of each job, None where Ctrl-C came first; ``sizes``: orbits of each job."""

    results: list[T | None]
    sizes: Sequence[int]
    interrupted: bool

    @property
    def done(self) -> list[T]:
        """The results there are."""
        return [result for result in self.results if result is not None]

    @property
    def rows(self) -> npt.NDArray[np.bool_]:
        """Which orbits, of those of all jobs one after the other, are done."""
        import numpy as np

        return np.repeat([result is not None for result in self.results], self.sizes)


def run_jobs(
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
) -> Finished[T]:
    """The results of jobs, as far as they came before Ctrl-C; KeyboardInterrupt where none did.

    ``solve``: of a job and a function that says whether to stop.  ``sizes``: orbits of each job.
    ``count``: threads, or processes of our own where ``processes``: for jobs that hold the lock
    that Python's threads share; one of those is this process itself.  ``packed``, ``unpacked``: a
    result as arrays, and back, for ``kept``, which other processes may then take.
    """
    results: list[T | None] = [None] * len(jobs)
    done = 0

    def ready(k: int, result: T) -> None:
        nonlocal done
        if results[k] is not None:  # handed on once more, since Ctrl-C came while it was
            return
        with Delay():
            if kept is not None and packed is not None:
                kept.save(k, packed(result))
            results[k] = result
            done += sizes[k]
        if progress is not None:
            progress(done / max(1, sum(sizes)), done)

    whole = True
    with kept or nullcontext():
        for k in range(len(jobs)):
            if kept is not None and unpacked is not None and (piece := kept.load(k)) is not None:
                results[k] = unpacked(piece)
                done += sizes[k]
        left = [k for k in range(len(jobs)) if results[k] is None]
        if executor is not None:
            whole, lost = executors.solve_in_executor(
                solve, [jobs[k] for k in left], lambda at, result: ready(left[at], result), executor
            )
            left = [left[at] for at in lost]
        waiting = [jobs[k] for k in left]
        if processes:
            try:
                for at, result in enumerate(executors.in_order(solve, waiting, count or 1)):
                    ready(left[at], result)
            except KeyboardInterrupt:
                whole = False
        elif waiting:

            def handed(at: int, result: T | None) -> None:
                if result is not None:
                    ready(left[at], result)

            whole = executors.solve_in_threads(_Whole(solve), waiting, handed, count) and whole
        if kept is not None and (not whole or kept.pieces()):
            with Delay() as delay:
                kept.write_waiting()
                delay.forget()
    if not whole and all(result is None for result in results):
        raise KeyboardInterrupt
    return Finished(results, sizes, not whole)


class _Whole(Generic[J, T]):
    """A job's result, or None where it was stopped before its end."""

    def __init__(self, solve: Solver[J, T]) -> None:
        self._solve = solve

    def __call__(self, job: J, stop: Stop) -> T | None:
        result = self._solve(job, stop)
        return None if stop() else result
