"""Study ``stability``: the hard cases in every number type, and the way back from their ends."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from polhode.common.interrupts import Message
from polhode.common.processes import cores, in_order
from polhode.judging.conditioning import conditioning
from polhode.judging.reference import reference as reference_of
from polhode.numbers import number_types
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.studies.accuracy.rows import case_rows
from polhode.studies.row_filter import Only
from polhode.studies.stability import hard_cases, there_and_back

QUESTION = (
    "How many of the digits that a hard motion allows are left in each number type, and why not "
    "more? How far from its start does a run end that goes there and back?"
)
#: The number types of the way back, and the most radians one way.
LONGEST = {"double": 1e4, "extended": 1e4, "quad": 200.0}
SPARE_DIGITS = 40  # of the states from which kappa of the way back is computed
QUARTERS = 4  # of the way, each of whose ends is one of those states


def rows(quick: bool, say: Message, wanted: Only) -> dict[str, Any]:
    """The study's rows; no figure in them depends on the clock."""
    chosen = [name for name in hard_cases.names(quick) if wanted(name)]

    def begun(scene: Scene) -> None:
        say(f"{scene.name}, {chosen.index(scene.name) + 1} of {len(chosen)}")

    workers = 1 if quick else cores()
    scenes = [library.load(name) for name in chosen]
    made = zip(scenes, case_rows(scenes, workers, begun), strict=True)
    cases = [_hard(scene, row) for scene, row in made]
    asked = sorted(scenes, key=lambda scene: -scene.log10_angle)
    found = dict(zip((s.name for s in asked), in_order(_back, asked, workers, begun), strict=True))
    return {
        "kinds": [
            {"kind": kind, "cases": [name for name in names if name in chosen]}
            for kind, names in hard_cases.KINDS.items()
        ],
        "cases": cases,
        "back": [row for name in chosen for row in found[name]],
    }


def _hard(scene: Scene, row: dict[str, Any]) -> dict[str, Any]:
    """A case of the study of accuracy, with how far each run is behind what was expected."""
    return row | {"end": float(scene.end), "runs": [_judged(run) for run in row["runs"]]}


def _judged(run: dict[str, Any]) -> dict[str, Any]:
    if "correct_digits" not in run:
        return run
    expected = run["expected"]
    behind = None if expected is None else round(expected[0] - run["correct_digits"], 2)
    return run | {"behind": behind, "lost": run["lost"] or ""}


def _back(scene: Scene) -> list[dict[str, Any]]:
    """Errors of a run to the end and back to 0, beside what kappa of either way allows."""
    angle = 10**scene.log10_angle
    numbers = [name for name, longest in LONGEST.items() if angle <= longest]
    if not numbers:
        return []
    there = conditioning(scene, number=number_types.QUAD).log10_kappa[-1]
    times = [scene.end * Fraction(k, QUARTERS) for k in range(1, QUARTERS + 1)]
    ways = [
        there_and_back.way_back(scene, t, state)
        for t, state in zip(times, reference_of(scene).at(times, SPARE_DIGITS), strict=True)
    ]
    backs = [conditioning(way, number=number_types.QUAD).log10_kappa[-1] for way in ways]
    back = max((x for x in backs if x is not None), default=None)
    kappa = None if there is None or back is None else max(there, back)
    found = []
    for name in numbers:
        eps = there_and_back.error(scene, number_types.named(name))
        found.append(
            {
                "case": scene.name,
                "number": name,
                "log10_kappa": None if there is None else round(there, 2),
                "log10_kappa_back": None if back is None else round(back, 2),
                "error_eps": float(f"{eps:.2e}"),
                "times_kappa": None if kappa is None else float(f"{eps / 10**kappa:.2g}"),
                "within": None if kappa is None else eps <= 10**kappa,
            }
        )
    return found
