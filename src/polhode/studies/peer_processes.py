"""Methods run as processes of their own: what is asked of them, what came back, what became of it.

Every process gets the same numbers: coefficients, start and output times of the exact scene,
rounded once to double.  Two rounds are made, the first with empty caches of compiled code, the
second with those that the first left; the clocks of both count.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from polhode.common.progress import Message
from polhode.equations.forms import principal
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.peers.field import TERMS
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.studies import ensembles


class Method(NamedTuple):
    """A curve: its name, the module that runs it, the module's word for it, and its number type.

    ``limit``: seconds that the module's process is given in a round.
    """

    name: str
    module: str
    method: str
    tolerances: tuple[float, ...]
    number: str = "double"
    limit: float = 60.0


class Task(NamedTuple):
    """One method on one scene at its times; the states come back of one time in ``every``.

    ``repeats``: timed runs a tolerance and round; a run longer than ``patience`` seconds is made
    once in all.  ``late``: only in the last round, with the caches that the others filled.
    """

    method: Method
    scene: Scene
    every: int = 1
    repeats: int = 2
    patience: float = 10.0
    late: bool = False


@dataclass
class Point:
    """What one tolerance gave: exact states, every clock's seconds, or why there are none."""

    rows: list[list[Fraction]] | None = None
    steps: int | None = None
    seconds: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    fault: str = ""
    stale: bool = False


@dataclass
class Curve:
    """What one method gave on one scene; seconds of import and compilation, cold and cached."""

    points: dict[float, Point] = field(default_factory=dict)
    version: str = ""
    importing: float | None = None
    compiling: list[float] = field(default_factory=list)
    missing: str = ""

    @property
    def status(self) -> str:
        """In a word: ok, missing, stale or failed; the worst of what happened at a tolerance."""
        if self.missing:
            return "missing"
        if any(point.stale for point in self.points.values()):
            return "stale"
        return "failed" if any(point.fault for point in self.points.values()) else "ok"

    @property
    def reason(self) -> str:
        """Why it is not ok."""
        faults: dict[str, list[str]] = {}
        for tol, point in self.points.items():
            if point.fault:
                faults.setdefault(point.fault, []).append(f"{tol:.2g}")
        told = (f"at tolerance {', '.join(tols)}: {fault}" for fault, tols in faults.items())
        return self.missing or "; ".join(told)


def run_all(
    tasks: Sequence[Task], cache: Path, tick: Message | None = None, rounds: int = 2
) -> list[Curve]:
    """The curves of the tasks, in their order; ``cache``: an empty folder for compiled code.

    All tasks of a module share a process in each round, and with it what it imports and compiles.
    """
    curves = [Curve() for _ in tasks]
    modules = dict.fromkeys(task.method.module for task in tasks)
    for turn in range(rounds):
        for module in modules:
            chosen = [
                (curve, task, tolerances)
                for curve, task in zip(curves, tasks, strict=True)
                if task.method.module == module
                and not curve.missing
                and (turn == rounds - 1 or not task.late)
                and (tolerances := _left(curve, task.method))
            ]
            if not chosen:
                continue
            if tick is not None:
                tick(f"{module.rpartition('.')[2]}, {'warm' if turn else 'cold'} caches")
            job = {"problems": [_problem(task, tols) for _, task, tols in chosen]}
            limit = sum(task.method.limit for _, task, _ in chosen)
            answers, fault = ask(module, job, limit, cache)
            kept = [(curve, len(task.scene.times[:: task.every])) for curve, task, _ in chosen]
            _enter(kept, answers)
            for curve, _, tolerances in chosen:
                for tol in tolerances:
                    if tol not in curve.points and not curve.missing:
                        curve.points[tol] = Point(fault=fault or "no answer")
    return curves


def ask(
    module: str, job: Mapping[str, Any], limit: float, cache: Path
) -> tuple[list[dict[str, Any]], str]:
    """The answers of ``python -m module`` to a job, and what ended it early, if anything did."""
    command = [sys.executable, "-m", module]
    try:
        done = subprocess.run(
            command,
            input=json.dumps(job).encode(),
            capture_output=True,
            timeout=limit,
            env=environment(cache),
        )
    except subprocess.TimeoutExpired as late:
        return _lines(late.stdout or b""), f"stopped after {limit:g} s"
    if done.returncode == 0:
        return _lines(done.stdout), ""
    last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
    told = f": {last[0]}" if last else ""
    return _lines(done.stdout), f"process ended with {done.returncode}{told}"


def environment(cache: Path) -> dict[str, str]:
    """The environment of a process whose compiled code is kept below ``cache``."""
    return {
        **os.environ,
        "HEYOKA_CACHE_DIR": str(cache / "heyoka"),
        "NUMBA_CACHE_DIR": str(cache / "numba"),
        "JAX_COMPILATION_CACHE_DIR": str(cache / "jax"),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
        "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
        "JAX_PLATFORMS": "cpu",
    }


def plain_scene(case: str, times: Sequence[Exact]) -> Scene:
    """A case of the library, or of an ensemble, at these times, asked for its states alone."""
    scene = ensembles.named(case) or library.load(case)
    return replace(scene, times=tuple(times), outputs=(), events=(), published=())


def stale(rows: Sequence[Sequence[Any]]) -> bool:
    """Whether states of a moving body were left unchanged: one equals the start or the last."""
    later = rows[1:]
    return any(row in (rows[0], before) for before, row in zip(rows, later, strict=False))


def _left(curve: Curve, method: Method) -> tuple[float, ...]:
    """The tolerances to run in this round: all at first, then without what failed or was slow."""
    if not curve.points:
        return method.tolerances
    return tuple(tol for tol, point in curve.points.items() if len(point.seconds) > 1)


def _problem(task: Task, tolerances: tuple[float, ...]) -> dict[str, Any]:
    scene = task.scene
    if not scene.body.axes.trivial:
        raise ValueError("the peers take bodies given in principal axes")
    k = principal.coefficients(scene.body)
    return {
        "case": scene.name,
        "method": task.method.method,
        "tolerances": list(tolerances),
        "every": task.every,
        "repeats": task.repeats,
        "patience": task.patience,
        "coefficients": [to_double(k.get(name, 0)).hex() for name in TERMS],
        "start": [to_double(x).hex() for x in scene.start],
        "times": [to_double(t).hex() for t in scene.times],
        "body": [to_double(x).hex() for x in (*scene.body.moments, *scene.body.torque)],
    }


def _enter(asked: Sequence[tuple[Curve, int]], answers: Iterable[Mapping[str, Any]]) -> None:
    """Enter a process's answers into the curves of its problems, each with its number of times."""
    curves, preparing = [curve for curve, _ in asked], 0.0
    for answer in answers:
        if "missing" in answer:
            for curve in curves:
                curve.missing = answer["missing"]
        elif "version" in answer:
            preparing = answer["prepare"]
            for curve in curves:
                curve.version, before = answer["version"], curve.importing
                curve.importing = min(answer["import"], before or math.inf)
        elif "compile" in answer:
            curves[answer["problem"]].compiling.append(preparing + answer["compile"])
        else:
            curve, times = asked[answer["problem"]]
            _enter_point(curve.points.setdefault(answer["tol"], Point()), answer, times)


def _enter_point(point: Point, answer: Mapping[str, Any], times: int) -> None:
    if "failed" in answer:
        point.fault = answer["failed"]
        return
    point.seconds += answer["seconds"]
    point.cpu += answer["cpu"]
    if point.rows is not None:
        return
    point.steps = answer["steps"]
    try:
        rows = [[_exact(x) for x in row] for row in answer["rows"]]
    except (ValueError, OverflowError):
        point.fault = "states that are not finite"
        return
    if len(rows) != times:
        point.fault = f"{len(rows)} states at {times} times"
        return
    if stale(rows):
        point.stale, point.fault = True, "success reported, states left unchanged"
        return
    point.rows = rows


def _exact(text: str) -> Fraction:
    return Fraction(float.fromhex(text)) if "0x" in text else Fraction(text)


def _lines(output: bytes) -> list[dict[str, Any]]:
    """The whole lines of JSON in an output; what else a process printed is passed over."""
    found = []
    for line in output.decode(errors="replace").splitlines():
        try:
            answer = json.loads(line)
        except ValueError:
            continue
        if isinstance(answer, dict):
            found.append(answer)
    return found
