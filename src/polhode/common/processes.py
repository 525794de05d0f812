"""Work in other threads and processes."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import nullcontext, suppress
from multiprocessing.connection import Connection, Pipe
from multiprocessing.spawn import get_executable
from queue import SimpleQueue
from typing import TYPE_CHECKING, Generic, NamedTuple, Protocol, TypeVar, cast

from polhode.common.checkpoint import JobArrays, JobCheckpoint
from polhode.common.interrupts import Delay, Progress, StopRequest

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


# --- jobs -----------------------------------------------------------------------------------------
#
# Jobs of plain data carried out by threads here, or by any executor, and kept as they end.


J = TypeVar("J")
J_contra = TypeVar("J_contra", contravariant=True)
T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Solver(Protocol[J_contra, T_co]):
    """What does one job; asked to stop, it may give back what it has, which then does not count."""

    def __call__(self, job: J_contra, stop: StopRequest | None = None, /) -> T_co:
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
    unpacked: Callable[[JobArrays], T] | None = None,
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
    finished = 0

    def ready(k: int, result: T) -> None:
        nonlocal finished
        if results[k] is not None:  # handed on once more, since Ctrl-C came while it was
            return
        with Delay():
            if kept is not None and packed is not None:
                kept.save(k, packed(result))
            results[k] = result
            finished += sizes[k]
        if progress is not None:
            progress(finished / max(1, sum(sizes)), finished)

    whole = True
    with kept or nullcontext():
        for k in range(len(jobs)):
            if kept is not None and unpacked is not None and (piece := kept.load(k)) is not None:
                results[k] = unpacked(piece)
                finished += sizes[k]
        left = [k for k in range(len(jobs)) if results[k] is None]
        if executor is not None:
            whole, lost = solve_in_executor(
                solve, [jobs[k] for k in left], lambda at, result: ready(left[at], result), executor
            )
            left = [left[at] for at in lost]
        waiting = [jobs[k] for k in left]
        if processes:
            try:
                for at, result in enumerate(in_order(solve, waiting, count or 1)):
                    ready(left[at], result)
            except KeyboardInterrupt:
                whole = False
        elif waiting:

            def whole_result(job: J, stop: StopRequest) -> T | None:
                """None where the job was stopped before its end."""
                result = solve(job, stop)
                return None if stop() else result

            def hand_on(at: int, result: T | None) -> None:
                if result is not None:
                    ready(left[at], result)

            whole = solve_in_threads(whole_result, waiting, hand_on, count) and whole
        if kept is not None and (not whole or kept.pieces()):
            with Delay() as delay:
                kept.write_waiting()
                delay.forget()
    if not whole and all(result is None for result in results):
        raise KeyboardInterrupt
    return Finished(results, sizes, not whole)


# --- executors ------------------------------------------------------------------------------------
#
# Jobs carried out by threads or processes of our own, or by any executor of
# ``concurrent.futures``.


def cores() -> int:
    """How many processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def solve_in_threads(
    solve: Callable[[J, StopRequest], T],
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
    solve: Callable[[J, StopRequest], T], jobs: Sequence[J], ready: Callable[[int, T], None]
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
    announce: Callable[[J], None] | None = None,
) -> Iterator[T]:
    """The results of the jobs, in their order, from so many processes; with one, from this one.

    ``announce`` is called with the job whose result is waited for.  The job of a process that died
    is done here; where the caller goes, by Ctrl-C too, the processes are ended.
    """
    if workers == 1:
        for job in jobs:
            if announce is not None:
                announce(job)
            yield solve(job)
        return
    workers_pool = WorkerPool()
    pool = ThreadPoolExecutor(workers, initializer=workers_pool.begin)
    try:
        futures = [pool.submit(workers_pool.do, solve, job) for job in jobs]
        for job, future in zip(jobs, futures, strict=True):
            if announce is not None:
                announce(job)
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
    solve: Callable[[J], T], jobs: Sequence[J], ready: Callable[[int, T], None], executor: Executor
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


# --- worker processes -----------------------------------------------------------------------------
#
# Processes of our own, each doing one job after another: they know polhode and not the caller.
#
# Those of :mod:`multiprocessing` first run the caller's main module again, for what it may
# define: all of a script that has no guard, and what was read from stdin cannot be found at all.
# Jobs here are polhode's own functions and values. They go and their answers come back as pickles,
# by a connection that is given to the process as its stdin: no other handle is surely none of those
# that it begins with.


class WorkerDied(Exception):
    """The process that had a job is not there any more."""


class Process:
    """A process of polhode's, idle but for :meth:`do`."""

    def __init__(self) -> None:
        places = [x for x in sys.path if isinstance(x, str)]
        self._connection, theirs = Pipe()
        code = f"import sys; sys.path[:] = {places!r}; import {__name__} as own; own.work()"
        self._process = subprocess.Popen(
            [get_executable(), "-P", "-c", code], stdin=theirs.fileno(), stdout=subprocess.DEVNULL
        )
        theirs.close()

    def do(self, solve: Callable[[J], T], job: J) -> T:
        """The result of a job, or the fault that it raised; raises WorkerDied."""
        request = pickle.dumps((solve, job))
        try:
            self._connection.send_bytes(request)
            reply = self._connection.recv_bytes()
        except (OSError, EOFError):  # gone, or ended by :meth:`end`
            raise WorkerDied from None
        fault, result = pickle.loads(reply)
        if fault is not None:
            raise fault
        answer: T = result
        return answer

    def end(self) -> None:
        """Whatever it does."""
        self._process.kill()
        self._process.wait()


class WorkerPool:
    """Processes for the threads that ask: one each, made when its thread first asks."""

    def __init__(self) -> None:
        self._mine = threading.local()
        self._all: list[Process] = []
        self._over = False

    def begin(self) -> None:
        """What such a thread does first: Ctrl-C in a terminal reaches no process that it starts."""
        if hasattr(signal, "pthread_sigmask"):
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})

    def do(self, solve: Callable[[J], T], job: J) -> T:
        """The result of a job from this thread's process; after WorkerDied the next has another."""
        process: Process | None = getattr(self._mine, "process", None)
        if process is None:
            process = self._mine.process = Process()
            self._all.append(process)
            if self._over:  # meanwhile
                process.end()
        try:
            return process.do(solve, job)
        except WorkerDied:
            self._mine.process = None
            process.end()
            raise

    def end(self) -> None:
        """All of them, at once."""
        self._over = True
        for process in list(self._all):
            process.end()


def work() -> None:
    """What such a process does: jobs of its connection, until nobody is there to ask."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    connection = Connection(os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDWR), 0)
    with suppress(OSError):  # no stderr
        os.dup2(2, 1)  # what a library may print
    jobs: SimpleQueue[bytes] = SimpleQueue()

    def listen() -> None:
        with suppress(OSError, EOFError):
            while True:
                jobs.put(connection.recv_bytes())
        os._exit(0)  # in the middle of a job too: nobody is there to whom its answer could go

    threading.Thread(target=listen, daemon=True).start()
    with suppress(OSError):
        while True:
            connection.send_bytes(_answer(jobs.get()))
    os._exit(0)


def _answer(question: bytes) -> bytes:
    """A job's fault, or None, and its result."""
    try:
        solve, job = pickle.loads(question)
        return pickle.dumps((None, solve(job)))
    except Exception as fault:
        try:
            pickle.loads(packed := pickle.dumps((fault, None)))
        except Exception:
            packed = pickle.dumps((RuntimeError(repr(fault)), None))
        return packed
