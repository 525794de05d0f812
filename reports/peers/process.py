"""One program as a process: ``python -m peers.process < job``, which imports nothing else.

A job: {"module", "method", "present", "runs": [{"top": [coefficients, moments, torque], "start",
"times", "tol"}]}; see :mod:`peers.field`.  The answer is a line of JSON a run, flushed
as it is made, so that a process that dies or is stopped leaves what it had: {"state": the last one}
or {"failed": why}.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

_SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux


def main() -> None:
    """Answer the job on stdin."""
    import numpy as np

    from peers.field import Top

    end_with_parent()
    job = json.load(sys.stdin)
    run = import_module(job["module"]).prepared(job["present"], job["method"])
    for job_run in job["runs"]:
        top = Top(*map(np.array, job_run["top"]))
        try:
            rows = run(top, np.array(job_run["start"]), np.array(job_run["times"]), job_run["tol"])
        except Exception as fault:  # whatever a program raises is a result of the study
            write({"failed": f"{type(fault).__name__}: {fault}"})
        else:
            write({"state": [float(x) for x in rows[-1]]})


def end_with_parent() -> None:
    """Ask the system to end this process when the one that started it ends, in whatever way.

    On Linux; elsewhere a process whose parent was killed goes on until its work is done.
    """
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGKILL, 0, 0, 0)


def write(answer: dict[str, Any]) -> None:
    """One line of JSON, at once."""
    print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()


# --- processes ------------------------------------------------------------------------------------
#
# Other programs as processes of their own: what is asked of them, and what came back.


def ask(
    module: str, job: Mapping[str, Any], limit: float, cache: Path
) -> tuple[list[dict[str, Any]], str]:
    """The answers of ``python -m module`` to a job, and what ended it early, if anything did."""
    command = [sys.executable, "-m", module]
    try:
        ended = subprocess.run(
            command,
            input=json.dumps(job).encode(),
            capture_output=True,
            timeout=limit,
            env=environment(cache),
        )
    except subprocess.TimeoutExpired as late:
        return _lines(late.stdout or b""), f"stopped after {limit:g} s"
    if ended.returncode == 0:
        return _lines(ended.stdout), ""
    last = ended.stderr.decode(errors="replace").strip().splitlines()[-1:]
    message = f": {last[0]}" if last else ""
    return _lines(ended.stdout), f"process ended with {ended.returncode}{message}"


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


def _lines(output: bytes) -> list[dict[str, Any]]:
    """The whole lines of JSON in an output; what else a process printed is passed over."""
    answers = []
    for line in output.decode(errors="replace").splitlines():
        try:
            answer = json.loads(line)
        except ValueError:
            continue
        if isinstance(answer, dict):
            answers.append(answer)
    return answers
