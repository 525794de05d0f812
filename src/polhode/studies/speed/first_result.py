"""The time to a first result in a new process: imports, compilation, one run.

``python -m polhode.studies.speed.first_result < job`` is such a process; it imports nothing but the
program that it is asked for.  A job: {"module", "method", "present", "top": [coefficients, moments,
torque], "start", "times", "tol"}.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from polhode.common.progress import Message
    from polhode.studies.speed.programs import Program

KIND, END, OUTPUTS, TOLERANCE = "kovalevskaya", 10, 101, 1e-9
REPEATS, ENOUGH = 3, 8.0  # times; none more once a program's processes took so many seconds
_LIMIT = 120.0


def main() -> None:
    """Answer the job on stdin with the last state."""
    import numpy as np

    job = json.load(sys.stdin)
    from polhode.peers.prepared import Top

    run = import_module(job["module"]).prepared(job["present"], job["method"])
    top = Top(*(np.array(x) for x in job["top"]))
    rows = run(top, np.array(job["start"]), np.array(job["times"]), job["tol"])
    print(json.dumps([float(x) for x in rows[-1]]))


def rows(
    programs: Sequence[Program], quick: bool, tick: Message | None = None
) -> Iterator[dict[str, Any]]:
    """A row a program: wall and processor seconds, with empty caches of compiled code and after."""
    from polhode.studies.peer_processes import environment
    from polhode.studies.speed import draws

    one = draws.draw(KIND, 0, END, OUTPUTS)
    shared = {
        "present": draws.present(KIND),
        "top": [x.tolist() for x in one.top],
        "start": one.start.tolist(),
        "times": [float(t) for t in one.scene.times],
        "tol": TOLERANCE,
    }
    for program in programs:
        if tick is not None:
            tick(f"first result: {program.name}")
        job = json.dumps({**shared, "module": program.module, "method": program.method})
        clocks: dict[str, tuple[float, float]] = {}
        fault = ""
        began = time.perf_counter()
        for _ in range(1 if quick else REPEATS):
            with tempfile.TemporaryDirectory() as cache:
                for word in ("cold", "warm"):
                    found = _clocked(job, environment(Path(cache)))
                    if isinstance(found, str):
                        fault = found
                        break
                    clocks[word] = min(found, clocks.get(word, found))
            if fault or time.perf_counter() - began > ENOUGH:
                break
        told = {
            word: {"wall": round(wall, 3), "processor": round(processor, 3)}
            for word, (wall, processor) in clocks.items()
        }
        yield {"program": program.name, **told, "fault": fault}


def _clocked(job: str, environment: dict[str, str]) -> tuple[float, float] | str:
    """Wall and processor seconds of one process from its start to its end, or what went wrong."""
    command = [sys.executable, "-m", "polhode.studies.speed.first_result"]
    before, began = os.times(), time.perf_counter()
    try:
        done = subprocess.run(
            command, input=job, capture_output=True, text=True, timeout=_LIMIT, env=environment
        )
    except subprocess.TimeoutExpired:
        return f"stopped after {_LIMIT:g} s"
    wall, after = time.perf_counter() - began, os.times()
    if done.returncode:
        return (done.stderr.strip().splitlines() or ["no message"])[-1]
    spent = sum(
        getattr(after, name) - getattr(before, name)
        for name in ("children_user", "children_system")
    )
    return wall, spent


if __name__ == "__main__":
    main()
