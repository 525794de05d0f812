"""Study ``forms``: a motion of each kind in every form of the equations, steps, time and digits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.common.executors import cores, in_order
from polhode.equations.form import source
from polhode.judging.adaptive_precision import integrate
from polhode.judging.references.reference import Remembered
from polhode.judging.references.reference import reference as reference_of
from polhode.judging.score.compare import compare
from polhode.scenes import library
from polhode.scenes.body import Body, Vector
from polhode.scenes.output_times import even_times
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import FORMS
from polhode.studies.row_filter import Only

NAME = "forms"
QUESTION = (
    "What does each form of the equations cost, how many digits does it keep, what does its own "
    "singular set take away, and which one should be used?"
)
#: Number types of the runs, and the part of a motion that each is given.
NUMBERS = {"double": Fraction(1), "quad": Fraction(1, 10)}
ROUNDS = 9  # the least time of so many runs, the forms taking turns


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
    wanted = only or Only()
    asked = [m for m in (MOTIONS[2:4] if quick else MOTIONS) if wanted(m.case, m.what)]

    def begun(job: tuple[FormMotion, bool]) -> None:
        if tick is not None:
            tick(f"{NAME}: {job[0].case}")

    jobs = [(motion, quick) for motion in asked]
    workers = 1 if quick or len(jobs) == 1 else cores()
    motions = [*in_order(_motion, jobs, workers, begun)]
    for motion, found in zip(asked, motions, strict=True):  # alone: a clock runs
        if tick is not None:
            tick(f"{NAME}: {motion.case}, seconds")
        _time(motion, found["runs"], 2 if quick else ROUNDS)
    return {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "sources": {form: source(form) for form in FORMS},
        "motions": motions,
    }


def _motion(job: tuple[FormMotion, bool]) -> dict[str, Any]:
    """A motion in every form: outcomes, steps and digits."""
    motion, quick = job
    reference = Remembered(reference_of(_scene(motion)))
    runs = [
        _run(replace(_part(motion, number), form=form), reference, number)
        for number in ([*NUMBERS][:1] if quick else NUMBERS)
        for form in FORMS
    ]
    return {
        "case": motion.case,
        "what": motion.what,
        "axes": None if motion.order == (0, 1, 2) else "".join("xyz"[i] for i in motion.order),
        "end": motion.end,
        "reference": reference.kind,
        "runs": runs,
    }


def _time(motion: FormMotion, runs: list[dict[str, Any]], rounds: int) -> None:
    """Add to each run its seconds, the least of so many runs in double, and what it is beside
    the first form's."""
    for number in NUMBERS:
        done = {r["form"]: r for r in runs if r["number"] == number and "correct_digits" in r}
        part = _part(motion, number)
        for _ in range(rounds if number == "double" else 1):
            for form, run in done.items():
                taken = integrate(replace(part, form=form), number, method="taylor").seconds
                before = run.setdefault("seconds", dict(taken))
                run["seconds"] = {k: min(before[k], taken[k]) for k in ("run", "build")}
        for run in done.values():
            first = done["principal"]
            run["time_against_principal"] = round(
                run["seconds"]["run"] / first["seconds"]["run"], 2
            )
            run["lost_digits"] = round(first["correct_digits"] - run["correct_digits"], 2)


def _scene(motion: FormMotion) -> Scene:
    scene = _reordered(library.load(motion.case), motion.order)
    return replace(scene, outputs=(), events=())


def _part(motion: FormMotion, number: str) -> Scene:
    """The part of a motion that a number type is given."""
    return _scene(motion).at(even_times(NUMBERS[number] * motion.end, 11))


def _run(scene: Scene, reference: Remembered, number: str) -> dict[str, Any]:
    known: dict[str, Any] = {"form": scene.form, "number": number}
    try:
        run = integrate(scene, number, method="taylor")
    except BadInput as refusal:
        return known | {"outcome": "refused", "reason": refusal.expected}
    known |= {"outcome": run.outcome.value, "steps": run.steps}
    if not run.outcome.done:
        return known | {"reason": run.cause, "reached": float(run.reached)}
    digits = round(compare(run, reference).state_worst, 2)
    return known | {"correct_digits": digits}


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
