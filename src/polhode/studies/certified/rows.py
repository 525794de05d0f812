"""Study ``certified``: enclosures against closed forms, over time, their price, what they judge."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from polhode.closed_forms.families import closed_form
from polhode.common.executors import cores, in_order
from polhode.common.progress import Message
from polhode.enclosures import fixed_point_problem
from polhode.enclosures.approximation import precision_choice
from polhode.enclosures.certify import certify
from polhode.judging.adaptive_precision import integrate
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import NumberType
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.studies.row_filter import Only

NAME = "certified"
QUESTION = (
    "Does every closed form lie in its enclosure, how many digits are proven over time with and "
    "without the integrals, what does a proof cost beside a run that proves nothing, and what is "
    "the error of a run in double, proven?"
)
CONTAINED_STEPS = 60  # of a proof: how far each closed form is followed
CONTAINED_DIGITS = 16
QUICK_CONTAINED = (
    "euler/separatrix",
    "lagrange/nutation",
    "pendulum/rotating",
    "grioli/precession",
)
MOTIONS = (
    *("general/asymmetric-regular", "general/asymmetric-chaotic"),
    *("lagrange/nutation", "kovalevskaya/generic"),
)
TIMES = (1, 2, 5, 10, 20, 50, 100, 200, 500)
QUICK_TIMES = (1, 2, 5, 10, 20)
COSTED = ("general/asymmetric-regular", "lagrange/nutation", "kovalevskaya/generic")
COST_DIGITS = (16, 30, 60)
COST_END, QUICK_COST_END = 100, 5
COST_TRIALS, LEAST_TRIALS = 5, 3
COST_BUDGET = 4.0  # CPU seconds of a price, beyond which there are no more trials than the least
JUDGED = (1, 10, 100)

_BUILT = "built: "


def rows(
    quick: bool = False, tick: Message | None = None, only: Only | None = None
) -> dict[str, Any]:
    """The study's results as a JSON object; only the seconds in it depend on the clock."""
    say = tick or (lambda _: None)
    wanted = only or Only()
    scenes = [library.load(name) for name in (QUICK_CONTAINED if quick else library.names())]
    there = [
        replace(scene, reference="auto", outputs=())
        for scene in scenes
        if wanted(scene.name) and scene.times and closed_form(scene) is not None
    ]

    def begun(scene: Scene) -> None:
        say(f"{NAME}: {scene.name} in its enclosure")

    contained = [*in_order(contained_in, there, 1 if quick else cores(), begun)]
    growth, cost, judged = [], [], []
    for name in MOTIONS[1:3] if quick else MOTIONS:
        if not wanted(name):
            continue
        say(f"{NAME}: {name} over time")
        growth.append(_growth(name, QUICK_TIMES if quick else TIMES))
        judged += _judged(name, JUDGED[:2] if quick else JUDGED)
    for name in COSTED[1:2] if quick else COSTED:
        for digits in COST_DIGITS[: 2 if quick else 3]:
            if not wanted(name, f"{digits} digits"):
                continue
            say(f"{NAME}: price of {digits} digits of {name}")
            cost.append(_cost(name, digits, QUICK_COST_END if quick else COST_END))
    return {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "contained": contained,
        "growth": growth,
        "cost": cost,
        "judged": judged,
    }


def contained_times(scene: Scene) -> list[Exact]:
    """Three times, the last at most so many steps away."""
    away = precision_choice.steps(fixed_point_problem.motion(scene), scene.end)
    last = scene.end * min(Fraction(1), Fraction(CONTAINED_STEPS) / Fraction(math.ceil(away) + 1))
    return [last * Fraction(k, 3) for k in (1, 2, 3)]


def contained_in(scene: Scene, digits: int = CONTAINED_DIGITS) -> dict[str, Any]:
    """A closed form against its enclosure: |closed form - midpoint| over the radius, the worst."""
    times = contained_times(scene)
    found = certify(scene, times, digits=digits)
    exact = reference_of(scene)
    true = exact.at(times, 2 * digits + 20)
    ratios = [
        float(abs(exactly(x) - middle) / Fraction(radius))
        for row, middles, radii in zip(true, found.centres, found.radii, strict=True)
        for x, middle, radius in zip(row, middles, radii, strict=True)
    ]
    return {
        "case": scene.name,
        "reference": exact.kind,
        "end": float(f"{float(times[-1]):.4g}"),
        "ratio": float(f"{max(ratios):.2g}"),
        "inside": max(ratios) <= 1.0,
        "digits": round(found.proven, 2),
        "tries": found.tries,
    }


def _growth(name: str, times: Sequence[int]) -> dict[str, Any]:
    """Proven digits over time, with the first integrals and without, at one noise level each."""
    scene = replace(library.load(name), outputs=())
    found = certify(scene, times, digits=CONTAINED_DIGITS)
    without = certify(scene, times, digits=CONTAINED_DIGITS, integrals=False)
    # the radius is 2**-noise times what the motion makes of it
    return {
        "case": name,
        "times": list(times),
        "noise": found.noise,
        "digits": [round(x, 2) for x in found.digits],
        "lost": [round(found.noise * math.log10(2) - x, 2) for x in found.digits],
        "lost_without": [round(without.noise * math.log10(2) - x, 2) for x in without.digits],
    }


def _cost(name: str, digits: int, end: int) -> dict[str, Any]:
    """CPU seconds of a proof and of runs that prove nothing, interleaved: medians of several.

    What a run to a thousandth of the time takes, mostly for building, is taken off each run: the
    median of the differences, left out where the noise of building is larger.
    """
    scene = replace(library.load(name), outputs=())
    proof = certify(scene, [1], digits=digits)  # compiles
    wanted = proof.noise
    makers: dict[str, Callable[[], Any]] = {"proof": lambda: certify(scene, [end], digits=digits)}
    runs: dict[str, tuple[NumberType | str, str]] = {
        f"mp, {wanted} bits": (NumberType("mp", wanted), "taylor")
    }
    if digits <= 16:
        runs["double"] = ("double", "taylor")
    if digits <= 33:
        runs["quad"] = (number_types.QUAD, "taylor")
        runs["quad, refined"] = (number_types.QUAD, "refined")
    for label, (number, method) in runs.items():
        makers[label] = _run(scene.at((end,)), number, method)
        makers[_BUILT + label] = _run(scene.at((Fraction(end, 1000),)), number, method)
        makers[label]()  # compiles
    taken: dict[str, list[float]] = {label: [] for label in makers}
    start, trials = time.process_time(), 0
    while trials < COST_TRIALS:
        if trials >= LEAST_TRIALS and time.process_time() - start > COST_BUDGET:
            break
        trials += 1
        for label, make in makers.items():
            began = time.process_time()
            found = make()
            taken[label].append(time.process_time() - began)
            if label == "proof":
                proof = found
    seconds = {"proof": statistics.median(taken["proof"])}
    for label in runs:
        pairs = zip(taken[label], taken[_BUILT + label], strict=True)
        seconds[label] = statistics.median(run - building for run, building in pairs)
    seconds = {label: s for label, s in seconds.items() if s > 0}
    return {
        "case": name,
        "digits": digits,
        "end": end,
        "trials": trials,
        "proven": round(proof.proven, 2),
        "noise": proof.noise,
        "tries": proof.tries,
        "steps": proof.steps,
        "seconds": {label: float(f"{s:.3g}") for label, s in seconds.items()},
        "last_try": float(f"{proof.seconds:.3g}"),
    }


def _run(scene: Scene, number: NumberType | str, method: str) -> Callable[[], Any]:
    return lambda: integrate(scene, number, method=method, max_steps=10**6)


def _judged(name: str, times: Sequence[int]) -> list[dict[str, Any]]:
    """A run in double against the enclosure: its largest error at each time, and how sure it is."""
    scene = replace(library.load(name), outputs=()).at(times)
    run = integrate(scene, "double")
    found = certify(scene, run.times, digits=20)
    judged = []
    for t, state, middles, radii in zip(times, run.states, found.centres, found.radii, strict=True):
        errors = [abs(exactly(x) - m) for x, m in zip(state, middles, strict=True)]
        worst = max(range(len(errors)), key=errors.__getitem__)
        judged.append(
            {
                "case": name,
                "t": t,
                "column": scene.columns[worst],
                "error": f"{float(errors[worst]):.6e}",
                "uncertainty": f"{radii[worst]:.1e}",
            }
        )
    return judged
