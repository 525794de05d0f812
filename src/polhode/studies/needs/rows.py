"""Study ``needs``: the command for each need, run as it is typed, its digits and its seconds."""

from __future__ import annotations

import json
import math
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from polhode.common.progress import Message
from polhode.judging.correct_digits import worst_digits
from polhode.judging.references.reference import reference as reference_of
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.studies.row_filter import Only

NAME = "needs"
QUESTION = "How many digits do I get, at what cost, for my need?"
REPEATS, QUICK_REPEATS = 2, 1  # of each command, after one that fills the caches
_SPARE = 8  # digits that a reference has more than what it judges


class Need(NamedTuple):
    """What somebody wants, the command for it, and who judges its answer.

    ``judge``: of a run or a closed form, "states"; "proven" and "compare" tell their own digits.
    """

    what: str
    command: str
    judge: str = "states"
    quick: bool = False


NEEDS = (
    Need("a motion in double", "polhode run published/nasa-brick -o brick.csv", quick=True),
    Need(
        "is my own program's file right?",
        "polhode compare brick.csv published/nasa-brick",
        "compare",
        quick=True,
    ),
    Need("a long run in double", "polhode run kovalevskaya/generic --at 100000"),
    Need("18 digits", "polhode run kovalevskaya/generic --at 100 --digits 18"),
    Need("30 digits", "polhode run kovalevskaya/generic --at 100 --digits 30"),
    Need("50 digits", "polhode run kovalevskaya/generic --at 100 --digits 50"),
    Need(
        "the far future, by a closed form",
        "polhode reference kovalevskaya/generic --at 1e9 --digits 30",
    ),
    Need(
        "digits that are proven, without a closed form",
        "polhode reference general/asymmetric-chaotic --at 100 --digits 15 --certified",
        "proven",
        quick=True,
    ),
)


def rows(
    quick: bool = False, tick: Message | None = None, only: Only | None = None
) -> dict[str, Any]:
    """The study's results as a JSON object; only the seconds in it depend on the clock."""
    wanted = only or Only()
    found = []
    with tempfile.TemporaryDirectory() as place:
        for need in NEEDS:
            if (quick and not need.quick) or not wanted(need.what, need.command):
                continue
            if tick is not None:
                tick(f"{NAME}: {need.what}")
            _prepare(Path(place), need)
            found.append(_row(need, Path(place), QUICK_REPEATS if quick else REPEATS))
    return {"study": NAME, "question": QUESTION, "quick": quick, "needs": found}


def _prepare(place: Path, need: Need) -> None:
    """Make the file that a command reads, where it is not there yet."""
    if need.judge == "compare" and not (place / "brick.csv").exists():
        _run(NEEDS[0].command, place)


def _row(need: Need, place: Path, repeats: int) -> dict[str, Any]:
    clocks = []
    for _ in range(1 + repeats):
        began = time.perf_counter()
        answer = _run(need.command, place)
        clocks.append(time.perf_counter() - began)
    digits, of = _JUDGES[need.judge](answer)
    return {
        "need": need.what,
        "command": need.command,
        "digits": round(digits, 1),
        "proven": of,
        "t": max(abs(float(Fraction(t))) for t in answer["times"]),
        "seconds": float(f"{min(clocks[1:]):.3g}"),
    }


def _run(command: str, place: Path) -> dict[str, Any]:
    """A command's answer as JSON; its own cache of compiled code is used."""
    program, *arguments = shlex.split(command)
    assert program == "polhode"
    done = subprocess.run(
        [sys.executable, "-m", "polhode", *arguments, "--json"],
        cwd=place,
        capture_output=True,
        check=True,
    )
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def _of_states(answer: Mapping[str, Any]) -> tuple[float, bool]:
    """Correct digits of the states against the scene's reference; whether that is proof."""
    scene = _scene(answer)
    cap = max(len(x.strip("-").replace(".", "")) for row in answer["states"] for x in row)
    reference = reference_of(scene)
    true = reference.at(scene.times, cap + _SPARE)
    states = [[Fraction(x) for x in row] for row in answer["states"]]
    return worst_digits(states, true, scene, float(cap)), True


def _scene(answer: Mapping[str, Any]) -> Scene:
    times = tuple(Fraction(t) for t in answer["times"])
    scene = library.load(answer["scene"])
    return replace(scene, times=times, outputs=(), events=(), published=())


def _of_proof(answer: Mapping[str, Any]) -> tuple[float, bool]:
    return min(answer["digits_proven"]), True


def _of_comparison(answer: Mapping[str, Any]) -> tuple[float, bool]:
    found = [x for x in answer["correct_digits"] if x is not None]
    return min(found, default=math.nan), bool(answer["proven"])


_JUDGES = {"states": _of_states, "proven": _of_proof, "compare": _of_comparison}
