"""Study ``forms``: a motion of each kind in every form of the equations, steps, time and digits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.equations.form import source
from polhode.judging.comparison import compare
from polhode.judging.reference import Remembered
from polhode.judging.reference import reference as reference_of
from polhode.runs.integrate import integrate
from polhode.scenes import library
from polhode.scenes.body import Body, Vector
from polhode.scenes.scene import Scene, even_times
from polhode.scenes.words import FORMS
from polhode.studies.only import Only

NAME = "forms"
QUESTION = (
    "What does each form of the equations cost, how many digits does it keep, what does its own "
    "singular set take away, and which one should be used?"
)
#: Number types of the runs, and the part of a motion that each is given.
NUMBERS = {"double": Fraction(1), "quad": Fraction(1, 10)}
ROUNDS = 15  # the least time of so many runs, the forms taking turns


class FormMotion(NamedTuple):
    """A case that ships to a time; ``order``: its axes taken in this order."""

    case: str
    end: int
    what: str
    order: tuple[int, int, int] = (0, 1, 2)


MOTIONS = (
    FormMotion("euler/turned-axes", 200, "Euler top, full inertia matrix"),
    FormMotion("lagrange/nutation", 200, "Lagrange top"),
    FormMotion("kovalevskaya/generic", 200, "Kovalevskaya top"),
    FormMotion("general/asymmetric-regular", 200, "asymmetric, regular"),
    FormMotion("published/bruels-cardona-arnold", 20, "near a pole, 4e-5 degrees", (2, 0, 1)),
)


def rows(
    quick: bool = False,
    tick: Callable[[str], None] | None = None,
    only: Only | None = None,
) -> dict[str, Any]:
    """The study's results as a JSON object."""
    motions = []
    wanted = only or Only()
    for motion in MOTIONS[2:4] if quick else MOTIONS:
        if not wanted(motion.case, motion.what):
            continue
        if tick is not None:
            tick(f"{NAME}: {motion.case}")
        motions.append(_motion(motion, quick))
    return {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "sources": {form: source(form) for form in FORMS},
        "motions": motions,
    }


def _motion(motion: FormMotion, quick: bool) -> dict[str, Any]:
    scene = _reordered(library.load(motion.case), motion.order)
    scene = replace(scene, outputs=(), events=())
    reference = Remembered(reference_of(scene))
    runs = []
    for number in [*NUMBERS][:1] if quick else NUMBERS:
        part = scene.at(even_times(NUMBERS[number] * motion.end, 11))
        runs += _runs(part, reference, number, 2 if quick else ROUNDS)
    return {
        "case": motion.case,
        "what": motion.what,
        "axes": None if motion.order == (0, 1, 2) else "".join("xyz"[i] for i in motion.order),
        "end": motion.end,
        "reference": reference.kind,
        "runs": runs,
    }


def _runs(scene: Scene, reference: Remembered, number: str, rounds: int) -> list[dict[str, Any]]:
    found = [_run(replace(scene, form=form), reference, number) for form in FORMS]
    runs = {run["form"]: run for run in found if "seconds" in run}
    for _ in range(rounds - 1 if number == "double" else 0):
        for form, run in runs.items():
            again = integrate(replace(scene, form=form), number).seconds
            for part in ("run", "build"):
                run["seconds"][part] = min(run["seconds"][part], again[part])
    first = runs["principal"]
    for run in runs.values():
        run["time_against_principal"] = round(run["seconds"]["run"] / first["seconds"]["run"], 2)
        run["lost_digits"] = round(first["correct_digits"] - run["correct_digits"], 2)
    return found


def _run(scene: Scene, reference: Remembered, number: str) -> dict[str, Any]:
    known: dict[str, Any] = {"form": scene.form, "number": number}
    try:
        run = integrate(scene, number, method="taylor")
    except BadInput as refusal:
        return known | {"outcome": "refused", "reason": refusal.expected}
    known |= {"outcome": run.outcome.value, "steps": run.steps}
    if not run.outcome.done:
        return known | {"reason": run.cause, "reached": float(run.reached)}
    digits = round(compare(run, reference).worst, 2)
    return known | {"seconds": dict(run.seconds), "correct_digits": digits}


def _reordered(scene: Scene, order: tuple[int, int, int]) -> Scene:
    """The same motion in axes named in another (cyclic) order."""
    if order == (0, 1, 2):
        return scene

    def taken(vector: Vector) -> Vector:
        a, b, c = (vector[i] for i in order)
        return a, b, c

    assert scene.gamma is not None
    body = Body.of_moments(taken(scene.body.moments), taken(scene.body.centre), scene.body.weight)
    return replace(scene, body=body, omega=taken(scene.omega), gamma=taken(scene.gamma), source="")
