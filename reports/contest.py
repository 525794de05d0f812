"""All programs on one kind of motion, side by side in a process as :mod:`peers.process` has them.

Of many starts those that are judged are run alone, and all of them where it is timed.

A job: {"kind", "cells": [(cell, [exact states a draw])], "programs": names, "tolerances": {cell:
{program: [tolerances]}} or {}, "patience": seconds}.  Without
tolerances each program is run once at all of its own, judged, and only those next to a level are
timed further, in cells of the work-precision diagram all.  A short call is timed in a block of
them, as a loop makes them; each has another start than the one before: the draw's, its first
component off by some units in the last place.  What is judged has the draw's own.

The answers: {"failed": program, "fault"} of one that could not be prepared, and for each cell
{"cell", "points": {program: {(draw, tol): (digits, seconds)}}, "faults"}.
"""

from __future__ import annotations

import math
import random
import statistics
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

import tops
from kit import Only, Say, clocked, groups, rows_by_part
from peers.field import Run
from peers.process import ask, fault_text, serve
from polhode.common.processes import cores
from polhode.numbers.decimals import significant
from programs import BY_NAME, MANY, OURS, OWN, Program
from tops import DRAWS, MANY_JUDGED, Cell, Draw, States

LEVELS = (6.0, 9.0, 12.0)
ROUNDS = 5  # of timed blocks of calls, fewer where they take longer than the job's patience
_BLOCK = 2e-4  # seconds of a block: what a loop pays, with the program's code in the caches
_MOST = 30  # calls of a block
_NUDGE = 2.0**-50

#: Of one program in a cell: (draw, tolerance) -> correct digits and the least seconds.
Points = dict[tuple[int, float], tuple[float, float]]


def answers_to(job: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The answers to a job."""
    ready: dict[bool, dict[str, Run]] = {False: {}, True: {}}
    for name in job["programs"]:
        for many in sorted({cell.starts > 0 for cell, _ in job["cells"]}):
            if not many or name in MANY:
                try:
                    ready[many][name] = BY_NAME[name].prepared(tops.present(job["kind"]), many)
                except Exception as fault:  # of a package that does not fit the others
                    yield {"failed": name, "fault": fault_text(fault)}
    for cell, truths in job["cells"]:
        contest = _Contest(cell, truths, ready[cell.starts > 0])
        contest.hold(job["tolerances"].get(cell), job["patience"])
        yield {"cell": cell, "points": contest.timed_points(), "faults": contest.faults}


class _Contest:
    """One cell: its draws, and what each program has given on them so far."""

    def __init__(self, cell: Cell, truths: Sequence[States], ready: Mapping[str, Run]) -> None:
        self.cell, self.truths = cell, truths
        self.ready = {n: r for n, r in ready.items() if BY_NAME[n].runs(*cell[1:])}
        self.draws: list[Draw] = [tops.draw(cell.kind, k, *cell[1:]) for k in range(DRAWS)]
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
        again = [
            (k, name, tol)
            for name in self.ready
            for k, tol in timed_again(self.points[name], self.cell.every_tolerance)
        ]
        again.sort(key=lambda x: x[0])  # a draw after the other, the programs in turns
        if self.cell.starts:
            for k, name, tol in {name: (k, name, tol) for k, name, tol in again[::-1]}.values():
                # what is compiled for so many starts is not timed
                top, start = self.draws[k].top, self.draws[k].start.copy()
                with suppress(Exception):  # a fault of the timed call is told
                    self.ready[name](top, start, self.times / self.cell.end, tol)
        began = time.perf_counter()
        for _ in range(ROUNDS):
            for k, name, tol in again:
                self._block(name, k, tol)
            if time.perf_counter() - began > patience:
                return

    @contextmanager
    def _noting(self, name: str, tol: float) -> Iterator[None]:
        """What a program raises, whatever it is, is a result."""
        try:
            yield
        except Exception as fault:
            self.faults[f"{name} at {tol:.1g}"] = fault_text(fault)

    def _block(self, name: str, k: int, tol: float) -> None:
        """Calls one after the other, timed together, each with a start of its own."""
        right, least = self.points[name][k, tol]
        run, top = self.ready[name], self.draws[k].top
        starts = []
        for _ in range(min(_MOST, math.ceil(_BLOCK / least)) if least < math.inf else 1):
            self._calls += 1
            start = self.draws[k].start.copy()
            start[..., 0] += (1 + self._calls % 15) * _NUDGE
            starts.append(start)

        def block() -> None:
            for start in starts:
                run(top, start, self.times, tol)

        with self._noting(name, tol):
            _, seconds = clocked(block)
            self.points[name][k, tol] = right, min(least, seconds / len(starts))

    def _once(self, name: str, k: int, tol: float) -> None:
        """The call that is judged, timed alone; of many starts those that are judged, untimed."""
        scene, top, start = self.draws[k].scene, self.draws[k].top, self.draws[k].start.copy()
        run, truth, outputs = self.ready[name], self.truths[k], len(self.times)
        with self._noting(name, tol):
            if self.cell.starts:
                states = run(top, start[:MANY_JUDGED], self.times, tol)
                self.points[name][k, tol] = tops.median_digits(states, truth, scene), math.inf
                return
            # what is made on the first call, a short one, is not timed
            run(top, start, self.times / self.cell.end, tol)
            states, seconds = clocked(lambda: run(top, start, self.times, tol))
            if len(states) not in (1, outputs):
                raise ArithmeticError(f"{len(states)} of {outputs} states")
            right = tops.digits(tops.judged(states, outputs), truth, scene)
            self.points[name][k, tol] = right, seconds

    def timed_points(self) -> dict[str, Points]:
        """The points that were timed."""
        return {
            name: {key: (round(x, 3), t) for key, (x, t) in points.items() if t < math.inf}
            for name, points in self.points.items()
        }


def timed_again(points: Points, every: bool) -> Iterator[tuple[int, float]]:
    """The tolerances of each draw whose digits lie next to a level, on either side; or all."""
    if every:
        yield from points
        return
    for k in {k for k, _ in points}:
        line = sorted((right, tol) for (draw_of, tol), (right, _) in points.items() if draw_of == k)
        chosen = set()
        for level in LEVELS:
            below = [tol for right, tol in line if right < level][-1:]
            above = [tol for right, tol in line if right >= level][:2]
            chosen |= {*below, *above}
        yield from ((k, tol) for tol in sorted(chosen))


if __name__ == "__main__":
    serve(answers_to)


# --- work precision -------------------------------------------------------------------------------
#
# Curves of work against precision: seconds at equal digits.
#
# A curve is a set of points (correct digits, seconds). What counts is its frontier: the points
# that no other of the curve beats in both; between two of them log seconds is linear in digits.


class WorkPoint(NamedTuple):
    """A point of a curve."""

    digits: float
    seconds: float


def frontier(marks: Iterable[WorkPoint]) -> list[WorkPoint]:
    """The points that no other beats in digits and seconds, digits and seconds rising."""
    points: list[WorkPoint] = []
    for mark in sorted(marks, key=lambda m: (-m.digits, m.seconds)):
        if not points or mark.seconds < points[-1].seconds:
            points.append(mark)
    return points[::-1]


# --- cells ----------------------------------------------------------------------------------------
#
# The contest's cells: who reaches how many digits, in what time, and how it compares with
# polhode.
#
# Each kind of motion is held in several processes, so that everything compiled is made as often,
# and the fastest of all counts, for all alike; but what in the first process takes more than ten
# times as long as the fastest, at every level, is not held again: equal builds differ by less
# than two. At each level the seconds of each draw are read between its two tolerances next to it;
# a program reaches a level where at least seven of eight draws do. Ratios are medians over the
# draws that both reach, with a bootstrap interval: a tie holds 1.


PROCESSES = 3
NEARLY_ALL = 7  # of the draws
PATIENCE, QUICK_PATIENCE = 0.5, 0.05
QUICK_CELLS = ((10, 2, 0), (10, 101, 0), (1, 2, 100))
QUICK_KINDS = ("kovalevskaya", "asymmetric")
_FAR = 10.0  # times the fastest: no other build makes that up
_LIMIT = 1800.0  # seconds of a process
_RESAMPLED, _SURE = 2000, 0.95
_MODULE = "contest"


def wanted_cells(quick: bool, only: Only) -> dict[str, list[Cell]]:
    """The cells to hold, by kind."""
    return groups(
        (kind, cell)
        for kind in (QUICK_KINDS if quick else tops.KINDS)
        for cell in tops.cells(kind)
        if (not quick or cell[1:] in QUICK_CELLS) and only(cell.name)
    )


def rows(
    cells_of: Mapping[str, Sequence[Cell]], programs: Sequence[Program], quick: bool, say: Say
) -> list[dict[str, Any]]:
    """A row a cell, in the order asked."""
    truths = _truths(cells_of, say)
    jobs = [
        {
            "kind": kind,
            "cells": [(cell, truths[_judged_cell(cell)]) for cell in cells],
            "programs": [program.name for program in programs],
            "tolerances": {},
            "patience": QUICK_PATIENCE if quick else PATIENCE,
        }
        for kind, cells in cells_of.items()
    ]
    with TemporaryDirectory() as cache, ThreadPoolExecutor(1 if quick else cores()) as pool:
        hold = partial(_kind, processes=1 if quick else PROCESSES, cache=Path(cache), say=say)
        # the kind that takes longest, of fast spins, begins first
        last_first = [*pool.map(hold, reversed(jobs))]
    return [row for rows in reversed(last_first) for row in rows]


def _kind(job: Mapping[str, Any], processes: int, cache: Path, say: Say) -> list[dict[str, Any]]:
    """The rows of one kind, from so many processes."""
    cells: list[Cell] = [cell for cell, _ in job["cells"]]
    points: dict[Cell, dict[str, Points]] = {cell: {} for cell in cells}
    faults: dict[Cell, dict[str, str]] = {cell: {} for cell in cells}
    for process in range(1, processes + 1):
        say(f"contest: {job['kind']}, process {process}")
        answers, fault = ask(job, _LIMIT, cache, _MODULE)
        missing = {*cells}
        for answer in answers:
            if "failed" in answer:
                for cell in cells:
                    faults[cell][answer["failed"]] = answer["fault"]
            else:
                missing.discard(answer["cell"])
                _enter(points[answer["cell"]], answer["points"])
                faults[answer["cell"]] |= answer["faults"]
        for cell in missing if fault else ():
            faults[cell][f"process {process}"] = fault
        # a cell that no process came to is held whole by the next one
        again = {x: held_again(points[x], x.every_tolerance) for x in cells if points[x]}
        job = {**job, "tolerances": again}
    return [row(cell, points[cell], faults[cell]) for cell in cells]


def row(cell: Cell, points: Mapping[str, Points], faults: Mapping[str, str]) -> dict[str, Any]:
    """A cell's seconds at each level, and their ratios to polhode's."""
    levels = []
    for level in LEVELS:
        seconds = {name: seconds_of(marks, level) for name, marks in points.items()}
        own = seconds.get(OURS, {})
        there = [
            {
                "program": name,
                "reached": len(marks),
                "seconds": significant(statistics.median(marks.values()), 3) if marks else None,
                "ratio": None if name == OURS else ratio(marks, own, f"{cell.name} {level} {name}"),
            }
            for name, marks in seconds.items()
        ]
        levels.append({"digits": level, "programs": there, "verdict": verdict(there)})
    drawn = {"curves": curves(points)} if cell.drawn else {}
    return {**cell._asdict(), "draws": DRAWS, "levels": levels, **drawn, "faults": dict(faults)}


def curves(points: Mapping[str, Points]) -> dict[str, list[list[float]]]:
    """Of each program, by tolerance, the medians over the draws: digits and seconds."""
    lines: dict[str, list[list[float]]] = defaultdict(list)
    for name, there in points.items():
        for tol in sorted({tol for _, tol in there}, reverse=True):
            marks = [there[k, tol] for k in range(DRAWS) if (k, tol) in there]
            if len(marks) >= NEARLY_ALL:
                digits, seconds = (statistics.median(x) for x in zip(*marks, strict=True))
                lines[name].append([round(digits, 2), significant(seconds, 3)])
    return lines


def seconds_of(points: Points, level: float) -> dict[int, float]:
    """Seconds to a level on the frontier of each draw, of those that reach it.

    Below its first point the first point's.
    """
    seconds_by_draw = {}
    for k in range(DRAWS):
        line = frontier(WorkPoint(*point) for (draw, _), point in points.items() if draw == k)
        if line and level <= line[-1].digits:
            at, seconds = zip(*line, strict=True)
            seconds_by_draw[k] = math.exp(np.interp(level, at, np.log(seconds)))
    return seconds_by_draw


def ratio(theirs: Mapping[int, float], own: Mapping[int, float], seed: str) -> list[float] | None:
    """The median of their seconds over ours, and its bootstrap interval.

    None where fewer than nearly all draws reach the level with both.
    """
    both = [theirs[k] / own[k] for k in sorted(theirs.keys() & own.keys())]
    if len(both) < NEARLY_ALL:
        return None
    dice = random.Random(seed)
    medians = sorted(statistics.median(dice.choices(both, k=len(both))) for _ in range(_RESAMPLED))
    least = medians[math.floor((1 - _SURE) / 2 * _RESAMPLED)]
    most = medians[math.ceil((1 + _SURE) / 2 * _RESAMPLED) - 1]
    return [significant(x, 3) for x in (statistics.median(both), least, most)]


def verdict(programs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """How polhode stands among the others, heyoka by hand and its own trajectories apart.

    "ahead", "behind" or "even" with the best of the others; "alone" where none of them reaches the
    level from nearly all draws, "not run" where none was run; "not reached" where polhode does not.
    """
    by_name = {by_program["program"]: by_program for by_program in programs}
    ours = by_name.get(OURS)
    if ours is None or ours["reached"] < NEARLY_ALL:
        return {"stands": "not reached"}
    others = {name: by_program["ratio"] for name, by_program in by_name.items() if name not in OWN}
    if not others:
        return {"stands": "not run"}
    met = [(*ratio, name) for name, ratio in others.items() if ratio is not None]
    if not met:
        return {"stands": "alone"}
    middle, least, most, name = min(met)
    stands = "ahead" if least > 1 else "behind" if most < 1 else "even"
    return {"stands": stands, "best": name, "ratio": [middle, least, most]}


def _judged_cell(cell: Cell) -> Cell:
    """What the references of a cell are of: its end, and the starts that are judged."""
    return cell._replace(outputs=2, starts=MANY_JUDGED * (cell.starts > 0))


def _truths(cells_of: Mapping[str, Sequence[Cell]], say: Say) -> dict[Cell, list[States]]:
    """The references of all draws, the longest first: no clock runs beside them."""
    every = {_judged_cell(cell) for cells in cells_of.values() for cell in cells}
    ends = sorted(every, key=lambda cell: (-cell.end, cell))
    truths = rows_by_part({"references": (_truths_of, ends)}, False, say)["references"]
    return dict(zip(ends, truths, strict=True))


def _truths_of(cell: Cell) -> list[States]:
    return [tops.truth(cell.kind, k, cell.end, cell.starts > 0) for k in range(DRAWS)]


def _enter(points: dict[str, Points], answers: Mapping[str, Points]) -> None:
    """The least seconds of all answers."""
    for name, answered in answers.items():
        here = points.setdefault(name, {})
        for key, (right, seconds) in answered.items():
            before = here.get(key, (right, math.inf))
            here[key] = before[0], min(before[1], seconds)


def held_again(points: Mapping[str, Points], every: bool) -> dict[str, list[float]]:
    """The tolerances of each program that are timed once more: none of one that is far behind.

    ``every``: all of the others.
    """
    seconds = [{n: seconds_of(there, x) for n, there in points.items()} for x in LEVELS]
    middles = [{n: statistics.median(t.values()) for n, t in x.items() if t} for x in seconds]
    again_by_name = {}
    for name, there in points.items():
        met = [times[name] <= _FAR * min(times.values()) for times in middles if name in times]
        again = timed_again(there, every) if any(met) or not met else ()
        again_by_name[name] = sorted({tol for _, tol in again}, reverse=True)
    return again_by_name
