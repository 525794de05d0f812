"""The time to a first result in a new process: imports, compilation, one run."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from polhode.common.interrupts import Message
from polhode.peers import process
from polhode.studies.processes import ask
from polhode.studies.speed import draws
from polhode.studies.speed.programs import Program

KIND, END, OUTPUTS, TOLERANCE = "kovalevskaya", 10, 101, 1e-9
REPEATS, ENOUGH = 3, 8.0  # times; none more once a program's processes took so many seconds
_LIMIT = 120.0


def rows(programs: Sequence[Program], quick: bool, say: Message) -> Iterator[dict[str, Any]]:
    """A row a program: wall and processor seconds, with empty caches of compiled code and after."""
    run, present = draws.draw(KIND, 0, END, OUTPUTS).run(TOLERANCE), draws.present(KIND)
    for program in programs:
        say(f"first result: {program.name}")
        job = program.job(present, [run])
        clocks: dict[str, tuple[float, float]] = {}
        fault = ""
        began = time.perf_counter()
        for _ in range(1 if quick else REPEATS):
            with tempfile.TemporaryDirectory() as cache:
                for word in ("cold", "warm"):
                    found = _clocked(job, Path(cache))
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


def _clocked(job: dict[str, Any], cache: Path) -> tuple[float, float] | str:
    """Wall and processor seconds of one process from its start to its end, or what went wrong."""
    before, began = os.times(), time.perf_counter()
    answers, fault = ask(process.__name__, job, _LIMIT, cache)
    wall, after = time.perf_counter() - began, os.times()
    if fault or "failed" in answers[0]:
        return fault or str(answers[0]["failed"])
    spent = sum(
        getattr(after, name) - getattr(before, name)
        for name in ("children_user", "children_system")
    )
    return wall, spent
