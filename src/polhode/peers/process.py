"""One program as a process: ``python -m polhode.peers.process < job``, which imports nothing else.

A job: {"module", "method", "present", "runs": [{"top": [coefficients, moments, torque], "start",
"times", "tol"}]}; see :mod:`polhode.peers.prepared`.  The answer is a line of JSON a run, flushed
as it is made, so that a process that dies or is stopped leaves what it had: {"state": the last one}
or {"failed": why}.
"""

from __future__ import annotations

import json
import signal
import sys
from importlib import import_module
from typing import Any

_SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux


def main() -> None:
    """Answer the job on stdin."""
    import numpy as np

    from polhode.peers.prepared import Top

    end_with_parent()
    job = json.load(sys.stdin)
    run = import_module(job["module"]).prepared(job["present"], job["method"])
    for asked in job["runs"]:
        top = Top(*map(np.array, asked["top"]))
        try:
            rows = run(top, np.array(asked["start"]), np.array(asked["times"]), asked["tol"])
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
