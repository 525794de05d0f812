"""What a peer's process does: read a job, time its parts one by one, write what came out.

A job: {"problems": [...]}.  A problem: {"coefficients": nine doubles, "start": six, "times": output
times from 0 on, "body": principal moments and Mg r0, all as hex floats; "method": which of the
driver's methods; "tolerances"; "every": the states of one output time in so many are written;
"repeats": timed runs a tolerance; "patience": seconds above which a run is not repeated}.

The answer is lines of JSON, written as they are made, so that a process that dies or is stopped
leaves what it had: first {"version", "import", "prepare"} or {"missing"}; for each problem
{"problem": its index, "compile"}; for each of its tolerances {"problem", "tol", "rows", "steps",
"seconds", "cpu"}: states as hex floats, wall and processor seconds of every run; or {"problem",
"tol", "failed"}.
"""

from __future__ import annotations

import json
import signal
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

_SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux


@dataclass(frozen=True)
class Problem:
    """The equations' nine coefficients, the start, the output times and the method's name.

    ``body``: principal moments and the components of Mg r0, for a peer that needs the Hamiltonian.
    """

    coefficients: tuple[float, ...]
    start: tuple[float, ...]
    times: tuple[float, ...]
    method: str
    body: tuple[float, ...] = ()

    @classmethod
    def read(cls, job: dict[str, Any]) -> Problem:
        """From the job's JSON."""
        c, start, times = (_doubles(job[key]) for key in ("coefficients", "start", "times"))
        return cls(c, start, times, job["method"], _doubles(job["body"]))


class Solution(NamedTuple):
    """States at the output times, and the steps taken where the peer tells them.

    ``building``: seconds of the run that belong to the compile column.
    """

    rows: Any
    steps: int | None = None
    building: float = 0.0


Solve = Callable[[float], Solution]


def serve(
    load: Callable[[], str],
    build: Callable[[Any], Solve],
    prepare: Callable[[], None] = lambda: None,
    read: Callable[[dict[str, Any]], Any] = Problem.read,
    written: Callable[[Any], str] = lambda x: float(x).hex(),
) -> None:
    """Answer the job on stdin.

    ``load``: imports the peer's packages and returns their version.  ``prepare``: compiles what all
    problems share.  ``build``: compiles for one problem and returns the function from a tolerance
    to a solution.  ``read``: the problem from its JSON.  ``written``: a number as exact text.
    """
    end_with_parent()
    job = json.load(sys.stdin)
    try:
        version, importing = _clocked(load)
    except ImportError as fault:
        return write({"missing": str(fault)})
    _, preparing = _clocked(prepare)
    write({"version": version, "import": importing[0], "prepare": preparing[0]})
    for k, wanted in enumerate(job["problems"]):
        try:
            solve, building = _clocked(partial(build, read(wanted)))
        except Exception as fault:  # whatever a peer raises is a result of the study
            for tolerance in wanted["tolerances"]:
                write({"problem": k, "tol": tolerance, "failed": _told(fault)})
            continue
        write({"problem": k, "compile": building[0]})
        for tolerance in wanted["tolerances"]:
            label = {"problem": k, "tol": tolerance}
            try:
                run = partial(solve, tolerance)
                solution, clocks = timed(run, wanted["repeats"], wanted["patience"])
            except Exception as fault:
                write({**label, "failed": _told(fault)})
                continue
            rows = [[written(x) for x in row] for row in solution.rows[:: wanted["every"]]]
            write({**label, "rows": rows, "steps": solution.steps, **clocks})


def end_with_parent() -> None:
    """Ask the system to end this process when the one that started it ends, in whatever way.

    On Linux; elsewhere a process whose parent was killed goes on until its work is done.
    """
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGKILL, 0, 0, 0)


def timed(
    run: Callable[[], Solution], repeats: int, patience: float
) -> tuple[Solution, dict[str, Any]]:
    """A run's solution, and wall and processor seconds of ``repeats`` runs after one to warm up.

    Where one run takes longer than ``patience`` it is not repeated and its own time counts.
    """
    solution, clock = _run(run)
    clocks = [clock]
    if clock[0] <= patience:
        clocks = [_run(run)[1] for _ in range(repeats)]
    return solution, {"seconds": [c[0] for c in clocks], "cpu": [c[1] for c in clocks]}


def _run(run: Callable[[], Solution]) -> tuple[Solution, tuple[float, float]]:
    """A solution and its clocks without what belongs to the compile column."""
    solution, (wall, cpu) = _clocked(run)
    return solution, (max(0.0, wall - solution.building), max(0.0, cpu - solution.building))


def write(answer: dict[str, Any]) -> None:
    """One line of JSON, at once."""
    print(json.dumps(answer), flush=True)


def _clocked(run: Callable[[], Any]) -> tuple[Any, tuple[float, float]]:
    wall, cpu = time.perf_counter(), time.process_time()
    result = run()
    return result, (time.perf_counter() - wall, time.process_time() - cpu)


def _told(fault: Exception) -> str:
    return f"{type(fault).__name__}: {fault}"


def _doubles(texts: Sequence[str]) -> tuple[float, ...]:
    return tuple(float.fromhex(text) for text in texts)
