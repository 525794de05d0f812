"""Processes of our own, each doing one job after another: they know polhode and not the caller.

Those of :mod:`multiprocessing` first run the caller's main module again, for what it may define:
all of a script that has no guard, and what was read from stdin cannot be found at all.  Jobs here
are polhode's own functions and values.  A job goes as a pickle to a process's stdin, and its answer
comes back from what was its stdout.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.spawn import get_executable
from queue import SimpleQueue
from typing import IO, TypeVar

J = TypeVar("J")
T = TypeVar("T")

_HEAD = 8  # bytes that say how many follow


class WorkerDied(Exception):
    """The process that had a job is not there any more."""


class Process:
    """A process of polhode's, idle but for :meth:`do`."""

    def __init__(self) -> None:
        places = [x for x in sys.path if isinstance(x, str)]
        code = f"import sys; sys.path[:] = {places!r}; import {__name__} as own; own.work()"
        self._process = subprocess.Popen(
            [get_executable(), "-P", "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def do(self, solve: Callable[[J], T], job: J) -> T:
        """The result of a job, or the fault that it raised; raises WorkerDied."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        request = pickle.dumps((solve, job))
        try:
            _write(self._process.stdin, request)
            reply = _read(self._process.stdout)
        except (OSError, ValueError):  # gone, or ended by :meth:`end`
            reply = None
        if reply is None:
            raise WorkerDied
        fault, result = pickle.loads(reply)
        if fault is not None:
            raise fault
        answer: T = result
        return answer

    def end(self) -> None:
        """Whatever it does."""
        self._process.kill()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with suppress(OSError):  # by what was left to be written
                pipe.close()
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
    """What such a process does: jobs, until nobody is there to ask."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    asked, told = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDWR), 0)
    try:
        os.dup2(2, 1)  # what a library may print is no answer
    except OSError:  # no stderr
        os.dup2(0, 1)
    jobs: SimpleQueue[bytes] = SimpleQueue()

    def listen() -> None:
        while (job := _read(asked)) is not None:
            jobs.put(job)
        os._exit(0)  # in the middle of a job too: nobody is there to whom its answer could go

    threading.Thread(target=listen, daemon=True).start()
    with suppress(OSError):
        while True:
            _write(told, _answer(jobs.get()))
    os._exit(0)


def _answer(asked: bytes) -> bytes:
    """A job's fault, or None, and its result."""
    try:
        solve, job = pickle.loads(asked)
        return pickle.dumps((None, solve(job)))
    except Exception as fault:
        try:
            pickle.loads(packed := pickle.dumps((fault, None)))
        except Exception:
            packed = pickle.dumps((RuntimeError(repr(fault)), None))
        return packed


def _write(pipe: IO[bytes], data: bytes) -> None:
    pipe.write(len(data).to_bytes(_HEAD, "big"))
    pipe.write(data)
    pipe.flush()


def _read(pipe: IO[bytes]) -> bytes | None:
    """What was written; None where the writer has gone."""
    head = pipe.read(_HEAD)
    size = int.from_bytes(head, "big")
    data = pipe.read(size) if len(head) == _HEAD else b""
    return data if len(head) == _HEAD and len(data) == size else None
