"""Jobs carried out by threads or processes of our own, or by any executor of
``concurrent.futures``."""

from __future__ import annotations

import os
import pickle
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
)
from queue import SimpleQueue
from typing import TypeVar, cast

from polhode.common.interrupts import Delay
from polhode.common.progress import Stop
from polhode.common.worker_processes import WorkerDied, WorkerPool

J = TypeVar("J")
T = TypeVar("T")


def cores() -> int:
    """How many processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def solve_in_threads(
    solve: Callable[[J, Stop], T],
    jobs: Sequence[J],
    ready: Callable[[int, T], None],
    workers: int | None = None,
) -> bool:
    """Solve the jobs in threads (``solve`` must release the lock that Python's threads share).

    ``ready``: called, in the calling thread, with the index of each job and its result.  False
    if Ctrl-C came: ``solve`` is then told to stop by its second argument, and what it still gave
    back has been handed on.  A job alone, and jobs for one thread, are done in the calling one.
    """
    workers = workers or cores()
    if len(jobs) == 1 or workers == 1:
        return _solve_here(solve, jobs, ready)
    stop = threading.Event()
    futures: dict[Future[T], int] = {}
    with ThreadPoolExecutor(workers) as pool:
        try:  # from the first job on: the end of this block waits for those that have begun
            for k, job in enumerate(jobs):
                futures[pool.submit(solve, job, stop.is_set)] = k
            _collect(futures, ready)
        except BaseException as fault:
            stop.set()
            for future in futures:
                future.cancel()
            if not isinstance(fault, KeyboardInterrupt):  # such as a disk that is full
                raise
    if not stop.is_set():
        return True
    _collect({f: k for f, k in futures.items() if not f.cancelled()}, ready)
    return False


def _solve_here(
    solve: Callable[[J, Stop], T], jobs: Sequence[J], ready: Callable[[int, T], None]
) -> bool:
    """Solve the jobs one after the other; False if Ctrl-C came."""
    try:
        with Delay() as delay:
            for k, job in enumerate(jobs):
                ready(k, solve(job, lambda: delay.came))
                if delay.came:
                    break
    except KeyboardInterrupt:
        return False
    return True


def in_order(
    solve: Callable[[J], T],
    jobs: Sequence[J],
    workers: int,
    begun: Callable[[J], None] | None = None,
) -> Iterator[T]:
    """The results of the jobs, in their order, from so many processes; with one, from this one.

    ``begun`` is called with the job whose result is waited for.  The job of a process that died
    is done here; where the caller goes, by Ctrl-C too, the processes are ended.
    """
    if workers == 1:
        for job in jobs:
            if begun is not None:
                begun(job)
            yield solve(job)
        return
    workers_pool = WorkerPool()
    pool = ThreadPoolExecutor(workers, initializer=workers_pool.begin)
    try:
        futures = [pool.submit(workers_pool.do, solve, job) for job in jobs]
        for job, future in zip(jobs, futures, strict=True):
            if begun is not None:
                begun(job)
            try:
                result = future.result()
            except WorkerDied:
                result = solve(job)
            yield result
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        workers_pool.end()
        pool.shutdown()


def solve_in_executor(
    solve: Callable[[J], T],
    jobs: Sequence[J],
    ready: Callable[[int, T], None],
    executor: Executor,
) -> tuple[bool, list[int]]:
    """Solve the jobs in an executor: whether Ctrl-C did not come, and the jobs that it lost.

    A job is lost with the worker that died over it, or with the whole pool; a warning says so.
    Jobs travel as bytes: an executor that looks into what it carries (dask names a task by a hash
    of all that is in it) has nothing to look into.
    """
    futures: dict[Future[T], int] = {}
    lost: dict[int, BaseException] = {}
    solved = cast("Callable[[bytes], T]", _solved)  # the bytes hold ``solve``
    try:
        for k, job in enumerate(jobs):
            try:
                futures[executor.submit(solved, pickle.dumps((solve, job)))] = k
            except RuntimeError as fault:  # broken or shut down already: BrokenExecutor is one
                lost[k] = fault
        _collect(futures, ready, lost)
    except KeyboardInterrupt:
        for future in futures:
            future.cancel()
        return False, []
    if lost:
        first = next(iter(lost.values()))
        text = f"{len(lost)} of {len(jobs)} jobs were lost ({first!r}) and are run in this process"
        warnings.warn(text, RuntimeWarning, stacklevel=4)
    return True, sorted(lost)


def _solved(packed: bytes) -> object:
    """The result of a job that came as bytes."""
    solve, job = pickle.loads(packed)
    return solve(job)


def _collect(
    futures: dict[Future[T], int],
    ready: Callable[[int, T], None],
    lost: dict[int, BaseException] | None = None,
) -> None:
    """Hand on each result as it comes; a future without one raises, or is noted as lost."""
    came: SimpleQueue[Future[T]] = SimpleQueue()
    for future in list(futures):
        future.add_done_callback(came.put)
    while futures:
        future = came.get()
        k = futures[future]
        fault = CancelledError() if future.cancelled() else future.exception()
        if fault is None:
            ready(k, future.result())
        elif lost is None:
            raise fault
        else:
            lost[k] = fault
        del futures[future]
