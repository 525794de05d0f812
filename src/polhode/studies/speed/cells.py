"""The contest's cells: who reaches how many digits, in what time, and how it compares with polhode.

Each kind of motion is held in several processes, so that everything compiled is made as often, and
the fastest of all counts, for all alike; but what in the first process takes more than ten times as
long as the fastest, at every level, is not held again: equal builds differ by less than two.  At
each level the seconds of each draw are read between its two tolerances next to it; a program
reaches a level where at least seven of eight draws do.  Ratios are medians over the draws that both
reach, with a bootstrap interval: a tie holds 1.
"""

from __future__ import annotations

import math
import random
import statistics
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from polhode.common.interrupts import Message
from polhode.common.processes import cores, in_order
from polhode.numbers.decimals import significant
from polhode.studies.processes import ask
from polhode.studies.row_filter import Only
from polhode.studies.speed import draws
from polhode.studies.speed.contest import LEVELS, Points, timed_again
from polhode.studies.speed.draws import DRAWS, Cell, Truth
from polhode.studies.speed.programs import OURS, OWN, Program
from polhode.studies.speed.work_precision import WorkPoint, seconds_at

PROCESSES = 3
NEARLY_ALL = 7  # of the draws
PATIENCE, QUICK_PATIENCE = 0.5, 0.05
QUICK_CELLS = ((10, 2, 0), (10, 101, 0), (1, 2, 100))
QUICK_KINDS = ("kovalevskaya", "asymmetric")
_FAR = 10.0  # times the fastest: no other build makes that up
_LIMIT = 900.0  # seconds of a process
_RESAMPLED, _SURE = 2000, 0.95
_MODULE = "polhode.studies.speed.contest"


def wanted_cells(quick: bool, wanted: Only) -> dict[str, list[Cell]]:
    """The cells to hold, by kind."""
    found: dict[str, list[Cell]] = {}
    for kind in QUICK_KINDS if quick else draws.KINDS:
        here = [
            cell
            for cell in draws.cells(kind)
            if (not quick or cell[1:] in QUICK_CELLS) and wanted(cell.label)
        ]
        if here:
            found[kind] = here
    return found


def rows(
    asked: Mapping[str, Sequence[Cell]],
    programs: Sequence[Program],
    cache: Path,
    quick: bool,
    say: Message,
) -> list[dict[str, Any]]:
    """A row a cell, in the order asked."""
    truths = _truths(asked, say)
    with ThreadPoolExecutor(1 if quick else cores()) as pool:
        held = {  # the kind that takes longest, of fast spins, begins first
            kind: pool.submit(_kind, kind, asked[kind], programs, truths, cache, quick, say)
            for kind in reversed([*asked])
        }
        return [row for kind in asked for row in held[kind].result()]


def _kind(
    kind: str,
    cells: Sequence[Cell],
    programs: Sequence[Program],
    truths: Mapping[tuple[str, int, bool, int], Truth],
    cache: Path,
    quick: bool,
    say: Message,
) -> list[dict[str, Any]]:
    """The rows of one kind, from as many processes as are made."""
    points: dict[str, dict[str, Points]] = {cell.label: {} for cell in cells}
    faults: dict[str, dict[str, str]] = {cell.label: {} for cell in cells}
    job: dict[str, Any] = {
        "kind": kind,
        "cells": [
            {
                **{"end": cell.end, "outputs": cell.outputs, "starts": cell.starts},
                "truths": [
                    _plain(truths[kind, cell.end, cell.starts > 0, k]) for k in range(DRAWS)
                ],
            }
            for cell in cells
        ],
        "programs": [program.name for program in programs],
        "tolerances": None,
        "patience": QUICK_PATIENCE if quick else PATIENCE,
    }
    for turn in range(1 if quick else PROCESSES):
        say(f"contest: {kind}, process {turn + 1}")
        answers, fault = ask(_MODULE, job, _LIMIT, cache)
        ended = {f"process {turn + 1}": fault} if fault else {}
        for answer in answers:
            if "failed" in answer:
                ended[answer["failed"]] = answer["fault"]
            else:
                _enter(points[answer["cell"]], answer["points"])
                faults[answer["cell"]] |= answer["faults"]
        for cell in cells:
            faults[cell.label] |= ended
        job["tolerances"] = {
            cell.label: held_again(points[cell.label], cell.every_tolerance) for cell in cells
        }
    return [row(cell, points[cell.label], faults[cell.label]) for cell in cells]


def row(cell: Cell, points: Mapping[str, Points], faults: Mapping[str, str]) -> dict[str, Any]:
    """A cell's seconds at each level, and their ratios to polhode's."""
    levels = []
    for level in LEVELS:
        seconds = {name: seconds_of(found, level) for name, found in points.items()}
        own = seconds.get(OURS, {})
        there = [
            {
                "program": name,
                "reached": len(found),
                "seconds": significant(statistics.median(found.values()), 3) if found else None,
                "ratio": None
                if name == OURS
                else ratio(found, own, f"{cell.label} {level} {name}"),
            }
            for name, found in seconds.items()
        ]
        levels.append({"digits": level, "programs": there, "verdict": verdict(there)})
    drawn = {"curves": curves(points)} if cell.drawn else {}
    return {**cell._asdict(), "draws": DRAWS, "levels": levels, **drawn, "faults": dict(faults)}


def curves(points: Mapping[str, Points]) -> dict[str, list[list[float]]]:
    """Of each program, by tolerance, the medians over the draws: digits and seconds."""
    found: dict[str, list[list[float]]] = {}
    for name, there in points.items():
        for tol in sorted({tol for _, tol in there}, reverse=True):
            marks = [there[k, tol] for k in range(DRAWS) if (k, tol) in there]
            if len(marks) >= NEARLY_ALL:
                digits, seconds = (statistics.median(x) for x in zip(*marks, strict=True))
                curve = found.setdefault(name, [])
                curve.append([round(digits, 2), significant(seconds, 3)])
    return found


def seconds_of(points: Points, level: float) -> dict[int, float]:
    """Seconds to a level, by draw, of those that reach it."""
    found = {}
    for k in range(DRAWS):
        marks = [WorkPoint(*point) for (draw, _), point in points.items() if draw == k]
        seconds = seconds_at(marks, level)
        if seconds is not None:
            found[k] = seconds
    return found


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
    by_name = {told["program"]: told for told in programs}
    ours = by_name.get(OURS)
    if ours is None or ours["reached"] < NEARLY_ALL:
        return {"stands": "not reached"}
    others = {name: told["ratio"] for name, told in by_name.items() if name not in OWN}
    if not others:
        return {"stands": "not run"}
    met = [(*ratio, name) for name, ratio in others.items() if ratio is not None]
    if not met:
        return {"stands": "alone"}
    middle, least, most, name = min(met)
    stands = "ahead" if least > 1 else "behind" if most < 1 else "even"
    return {"stands": stands, "best": name, "ratio": [middle, least, most]}


def _truths(
    asked: Mapping[str, Sequence[Cell]], say: Message
) -> dict[tuple[str, int, bool, int], Truth]:
    """The references by kind, end and draw, the longest first: no clock runs beside them."""
    ends = {(c.kind, c.end, c.starts > 0) for cells in asked.values() for c in cells}
    jobs = [(*x, k) for x in sorted(ends, key=lambda x: (-x[1], x)) for k in range(DRAWS)]

    def begun(job: tuple[str, int, bool, int]) -> None:
        if job[-1] == 0:
            say(f"references of {job[0]} to t = {job[1]}{', many starts' if job[2] else ''}")

    return dict(zip(jobs, in_order(_truth, jobs, cores(), begun), strict=True))


def _truth(job: tuple[str, int, bool, int]) -> Truth:
    kind, end, many, k = job
    return draws.truth(kind, k, end, many)


def _plain(true: Truth) -> list[Any]:
    return [x.tolist() for x in true]


def _enter(points: dict[str, Points], told: Mapping[str, Sequence[Sequence[float]]]) -> None:
    for name, found in told.items():
        here = points.setdefault(name, {})
        for draw, tol, digits, seconds in found:
            key = int(draw), tol
            known = here.get(key, (digits, math.inf))
            here[key] = known[0], min(known[1], seconds)


def held_again(points: Mapping[str, Points], every: bool) -> dict[str, list[float]]:
    """The tolerances of each program that are timed once more: none of one that is far behind.

    ``every``: all of the others.
    """
    seconds = [{n: seconds_of(there, x) for n, there in points.items()} for x in LEVELS]
    middles = [{n: statistics.median(t.values()) for n, t in x.items() if t} for x in seconds]
    found = {}
    for name, there in points.items():
        met = [times[name] <= _FAR * min(times.values()) for times in middles if name in times]
        again = timed_again(there, every) if any(met) or not met else ()
        found[name] = sorted({tol for _, tol in again}, reverse=True)
    return found
