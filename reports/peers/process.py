"""One program as a process: ``python -m peers.process ANSWERS < job``, which imports nothing else.

A job: {"module", "method", "present", "runs": [(top, start, times, tol)]}; see :mod:`peers.field`.
An answer a run is added to the file ANSWERS as it is made, so that a process that dies or is
stopped leaves what it had: {"state": the last one} or {"failed": why}.  Both are pickles.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

_SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux


def answers_to(job: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The answers to a job, one a run."""
    run = import_module(job["module"]).prepared(job["present"], job["method"])
    for arguments in job["runs"]:
        try:
            rows = run(*arguments)
        except Exception as fault:  # whatever a program raises is a result of the study
            yield {"failed": fault_text(fault)}
        else:
            yield {"state": [float(x) for x in rows[-1]]}


def fault_text(fault: Exception) -> str:
    """A fault, whatever it is, in words."""
    return f"{type(fault).__name__}: {fault}"


def serve(answers: Callable[[dict[str, Any]], Iterable[dict[str, Any]]]) -> None:
    """Add the answers to the job on stdin to those of this process, each at once."""
    end_with_parent()
    for answer in answers(pickle.load(sys.stdin.buffer)):
        with open(sys.argv[1], "ab") as file:
            pickle.dump(answer, file)


def end_with_parent() -> None:
    """Ask the system to end this process when the one that started it ends, in whatever way.

    On Linux; elsewhere a process whose parent was killed goes on until its work is done.
    """
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGKILL, 0, 0, 0)


if __name__ == "__main__":
    serve(answers_to)


# --- processes ------------------------------------------------------------------------------------
#
# Other programs as processes of their own: what is asked of them, and what came back.


def ask(
    job: Mapping[str, Any], limit: float, cache: Path | None = None, module: str = __name__
) -> tuple[list[Any], str]:
    """The answers of ``python -m module`` to a job, and what ended it early, if anything did.

    ``cache``: of compiled code, empty and not kept unless it is given.
    """
    with tempfile.TemporaryDirectory() as folder:
        path, fault = Path(folder) / "answers", ""
        path.touch()
        try:
            ended = subprocess.run(
                [sys.executable, "-m", module, path],
                input=pickle.dumps(job),
                capture_output=True,
                timeout=limit,
                env=environment(cache or Path(folder)),
            )
        except subprocess.TimeoutExpired:
            return [*_answers(path)], f"stopped after {limit:g} s"
        if ended.returncode:
            last = ended.stderr.decode(errors="replace").strip().splitlines()[-1:]
            fault = ": ".join([f"process ended with {ended.returncode}", *last])
        return [*_answers(path)], fault


def environment(cache: Path) -> dict[str, str]:
    """The environment of a process whose compiled code is kept below ``cache``."""
    paths = [str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    return {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, paths)),
        "HEYOKA_CACHE_DIR": str(cache / "heyoka"),
        "NUMBA_CACHE_DIR": str(cache / "numba"),
        "JAX_COMPILATION_CACHE_DIR": str(cache / "jax"),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
        "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
        "JAX_PLATFORMS": "cpu",
    }


def _answers(path: Path) -> Iterator[Any]:
    """The answers in a file, of which the last may not be whole."""
    with path.open("rb") as file, suppress(EOFError, pickle.UnpicklingError):
        while True:
            yield pickle.load(file)
