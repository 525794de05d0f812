"""All programs on one kind of motion, side by side in one process: ``python -m … < job``.

Of many starts those that are judged are run alone, and all of them where it is timed.

A job: {"kind", "cells": [{"end", "outputs", "starts", "truths": [[high, low, scale] a draw]}],
"programs": names, "tolerances": {cell's label: {program: [tolerances]}} or null, "patience":
seconds}.  Without tolerances each program is run once at all of its own, judged, and only those
next to a level are timed further, in cells of the work-precision diagram all.  A short call is
timed in a block of them, as a loop makes them; each has another start than the one before: the
draw's, its first component off by some units in the last place.  What is judged has the draw's own.

The answer is lines of JSON, flushed as they are made: {"failed": program, "fault"} of one that
could not be prepared, and for each cell {"cell", "points": {program: [[draw, tol, digits,
seconds]]}, "faults"}.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

from polhode.peers.prepared import Run
from polhode.peers.process import end_with_parent, write
from polhode.studies.speed.draws import (
    DRAWS,
    MANY_JUDGED,
    Cell,
    Draw,
    Truth,
    digits,
    draw,
    judged,
    median_digits,
    present,
)
from polhode.studies.speed.programs import BY_NAME, MANY

LEVELS = (6.0, 9.0, 12.0)
ROUNDS = 5  # of timed blocks of calls, fewer where they take longer than the job's patience
_BLOCK = 2e-4  # seconds of a block: what a loop pays, with the program's code in the caches
_MOST = 30  # calls of a block
_NUDGE = 2.0**-50

#: Of one program in a cell: (draw, tolerance) -> correct digits and the least seconds.
Points = dict[tuple[int, float], tuple[float, float]]


def main() -> None:
    """Answer the job on stdin."""
    end_with_parent()
    job = json.load(sys.stdin)
    ready: dict[bool, dict[str, Run]] = {False: {}, True: {}}
    asked_for = {bool(asked["starts"]) for asked in job["cells"]}
    for name in job["programs"]:
        for many in sorted(asked_for):
            if not many or name in MANY:
                try:
                    ready[many][name] = BY_NAME[name].prepared(present(job["kind"]), many)
                except Exception as fault:  # of a package that does not fit the others
                    write({"failed": name, "fault": _told(fault)})
    for asked in job["cells"]:
        cell = Cell(job["kind"], asked["end"], asked["outputs"], asked["starts"])
        contest = _Contest(cell, [*map(_truth, asked["truths"])], ready[bool(cell.starts)])
        contest.hold((job["tolerances"] or {}).get(cell.label), job["patience"])
        write({"cell": cell.label, "points": contest.told(), "faults": contest.faults})


class _Contest:
    """One cell: its draws, and what each program has given on them so far."""

    def __init__(self, cell: Cell, truths: Sequence[Truth], ready: Mapping[str, Run]) -> None:
        import numpy as np

        self.cell, self.truths = cell, truths
        self.ready = {n: r for n, r in ready.items() if BY_NAME[n].runs(*cell[1:])}
        self.draws: list[Draw] = [draw(cell.kind, k, *cell[1:]) for k in range(DRAWS)]
        self.times = np.array([float(t) for t in self.draws[0].scene.times])
        self.points: dict[str, Points] = defaultdict(dict)
        self.faults: dict[str, str] = {}
        self._calls = 0

    def hold(self, tolerances: Mapping[str, Sequence[float]] | None, patience: float) -> None:
        """Judge every program, then time all of them in turns until the patience is at its end."""
        for name in self.ready:
            for tol in BY_NAME[name].tolerances if tolerances is None else tolerances.get(name, ()):
                for k in range(DRAWS):
                    self._once(name, k, tol)
        every = self.cell.every_tolerance
        near = {name: [*timed_again(self.points[name], every)] for name in self.ready}
        if self.cell.starts:
            for name, asked in near.items():
                for k, tol in asked[:1]:  # what is compiled for so many starts is not timed
                    run, one = self.ready[name], self.draws[k]
                    with suppress(Exception):  # a fault of the timed call is told
                        run(one.top, one.start.copy(), self.times / self.cell.end, tol)
        began = time.perf_counter()
        for _ in range(ROUNDS):
            for k in range(DRAWS):
                for name, asked in near.items():
                    for draw_asked, tol in asked:
                        if draw_asked == k:
                            self._block(name, k, tol)
            if time.perf_counter() - began > patience:
                return

    def _block(self, name: str, k: int, tol: float) -> None:
        """Calls one after the other, timed together, each with a start of its own."""
        known, least = self.points[name][k, tol]
        run, top = self.ready[name], self.draws[k].top
        starts = []
        for _ in range(min(_MOST, math.ceil(_BLOCK / least)) if least < math.inf else 1):
            self._calls += 1
            start = self.draws[k].start.copy()
            start[..., 0] += (1 + self._calls % 15) * _NUDGE
            starts.append(start)
        try:
            began = time.process_time()
            for start in starts:
                run(top, start, self.times, tol)
            seconds = (time.process_time() - began) / len(starts)
        except Exception as fault:
            self._fail(name, tol, fault)
            return
        self.points[name][k, tol] = known, min(least, seconds)

    def _fail(self, name: str, tol: float, fault: Exception) -> None:
        """What a program raised, whatever it is: a result."""
        self.faults[f"{name} at {tol:.1g}"] = _told(fault)

    def _once(self, name: str, k: int, tol: float) -> None:
        """The call that is judged, timed alone; of many starts those that are judged, untimed."""
        start = self.draws[k].start.copy()
        run, top, truth = self.ready[name], self.draws[k].top, self.truths[k]
        try:
            if self.cell.starts:
                found = median_digits(run(top, start[:MANY_JUDGED], self.times, tol), truth)
                self.points[name][k, tol] = found, math.inf
                return
            # what is made on the first call, a short one, is not timed
            run(top, start, self.times / self.cell.end, tol)
            began = time.process_time()
            states = run(top, start, self.times, tol)
            seconds = time.process_time() - began
        except Exception as fault:
            self._fail(name, tol, fault)
            return
        expected = (1, len(self.times))
        if len(states) not in expected:
            self.faults[f"{name} at {tol:.1g}"] = f"{len(states)} of {expected[-1]} states"
            return
        found = digits(judged(states, self.cell.outputs), truth)
        self.points[name][k, tol] = found, seconds

    def told(self) -> dict[str, list[list[float]]]:
        """The points as plain lists."""
        return {
            name: [
                [k, tol, round(found, 3), seconds]
                for (k, tol), (found, seconds) in rows.items()
                if seconds < math.inf
            ]
            for name, rows in self.points.items()
        }


def timed_again(points: Points, every: bool) -> Iterator[tuple[int, float]]:
    """The tolerances of each draw whose digits lie next to a level, on either side; or all."""
    if every:
        yield from points
        return
    for k in {k for k, _ in points}:
        line = sorted((found, tol) for (draw_of, tol), (found, _) in points.items() if draw_of == k)
        chosen = set()
        for level in LEVELS:
            below = [tol for found, tol in line if found < level][-1:]
            above = [tol for found, tol in line if found >= level][:2]
            chosen |= {*below, *above}
        yield from ((k, tol) for tol in sorted(chosen))


def _told(fault: Exception) -> str:
    return f"{type(fault).__name__}: {fault}"


def _truth(given: Sequence[Any]) -> Truth:
    import numpy as np

    return Truth(*map(np.array, given))


if __name__ == "__main__":
    main()
