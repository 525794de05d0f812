"""Study ``events``: event times and counts against closed forms, and what events cost."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from polhode.common.interrupts import Message
from polhode.common.processes import cores, in_order
from polhode.enclosures.events import certify_events
from polhode.judging.adaptive_precision import integrate
from polhode.numbers import decimals, exact, number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import NumberType
from polhode.scenes import library
from polhode.scenes.scene import Event, Scene
from polhode.studies.events.zeros import Zeros, ulp
from polhode.studies.row_filter import Only

QUESTION = (
    "How close are event times to those of closed forms, in units in the last place of the time? "
    "Is every event counted once to t = 10 000, and what does an event cost?"
)
PERIODS = 10  # over which every event is judged in every number type
FAR = {"double": 10_000, "extended": 10_000, "quad": 1_000}
QUICK_FAR = {"double": 10_000}
KEPT = 24  # errors of a far run that the figure shows

PROVEN = ("general/asymmetric-regular", "general/asymmetric-chaotic")
PROVEN_END = 100


@dataclass(frozen=True)
class EventMotion:
    """A case, what vanishes, and what it is to people."""

    case: str
    zero: str
    what: str


MOTIONS = (
    EventMotion("euler/largest-axis", "q", "half periods of the polhode"),
    EventMotion("lagrange/nutation", "p*gamma2 - q*gamma1", "turning points of the nutation"),
    EventMotion("pendulum/librating", "gamma3", "pendulum, libration: third axis horizontal"),
    EventMotion("pendulum/rotating", "gamma3", "pendulum, rotation: third axis horizontal"),
    EventMotion("kovalevskaya/delaunay", "q", "Delaunay's motion: q = 0"),
)

COSTED = "general/asymmetric-regular"
COST_ENDS = {"double": 2000, "extended": 200, "quad": 5, "mp": 2}
COST_EVENTS = ("p*gamma2 - q*gamma1", "q", "gamma3 - 1/2")


def rows(quick: bool, say: Message, wanted: Only) -> dict[str, Any]:
    """The study's rows; only the seconds in them depend on the clock."""
    far = QUICK_FAR if quick else FAR
    jobs: list[tuple[Any, ...]] = [
        *(
            ("motions", m, far)
            for m in (MOTIONS[:3] if quick else MOTIONS)
            if wanted(m.case, m.what)
        ),
        *(("proven", name, PROVEN_END) for name in PROVEN[: 1 if quick else 2] if wanted(name)),
    ]
    workers = 1 if quick or len(jobs) == 1 else cores()
    made = in_order(_made, jobs, workers, lambda job: say(f"{job[0]}, {_told(job[1])}"))
    parts: dict[str, list[dict[str, Any]]] = {part: [] for part in _MAKERS}
    for job, row in zip(jobs, made, strict=True):
        parts[job[0]].append(row)
    cost = []
    for name in number_types.NAMES:  # alone: a clock runs
        if wanted("cost", name):
            say(f"cost in {name}")
            cost.append(_cost(name, 3 if quick else 9))
    return {**parts, "cost": cost}


def _made(job: tuple[Any, ...]) -> dict[str, Any]:
    """A row: the part of the study that it belongs to, and what it is made of."""
    part, *given = job
    return _MAKERS[part](*given)


def _told(subject: EventMotion | str) -> str:
    return subject if isinstance(subject, str) else f"{subject.case}, {subject.what}"


# -- times and counts -------------------------------------------------------------------------


def _motion(motion: EventMotion, far: dict[str, int]) -> dict[str, Any]:
    scene = _watching(library.load(motion.case), motion.zero)
    zeros = Zeros(scene, motion.zero)
    near = math.floor(PERIODS * zeros.period)
    return {
        "case": motion.case,
        "zero": motion.zero,
        "what": motion.what,
        "period": decimals.decimal_string(zeros.period, 18),
        "near": [_run(scene, zeros, name, near) for name in number_types.NAMES],
        "far": [_run(scene, zeros, name, end) for name, end in far.items()],
    }


def _run(scene: Scene, zeros: Zeros, name: str, end: int) -> dict[str, Any]:
    """Events to a time: how many, and their distances from the closed form's."""
    run = integrate(scene, name, at=[end])
    (event,) = run.events
    true = zeros.until(end)
    found: dict[str, Any] = {
        "number": name,
        "end": end,
        "true": len(true),
        "found": len(event.times),
        "complete": event.complete,
        "grazing": sum(event.grazing),
    }
    if len(event.times) == len(true) > 0:
        pairs = list(zip(event.times, true, strict=True))
        ulps = [float(abs(t - x) / ulp(x, run.number.bits)) for t, x in pairs]
        every = max(1, len(pairs) // KEPT)
        found |= {
            "ulps": float(f"{max(ulps):.3g}"),
            "error": float(f"{float(max(abs(t - x) for t, x in pairs)):.2e}"),
            "digits": round(min(_digits(t, x, run.number) for t, x in pairs), 2),
            "samples": [
                [round(float(x), 3), float(f"{u:.3g}")]
                for (_, x), u in list(zip(pairs, ulps, strict=True))[::every]
            ],
        }
    return found


def _digits(t: Fraction, true: Fraction, number: NumberType) -> float:
    error = abs(t - true) / true
    return number.most_digits if error == 0 else min(number.most_digits, -exact.log10(error))


def _watching(scene: Scene, *zeros: str) -> Scene:
    events = tuple(Event(f"event {k}", zero) for k, zero in enumerate(zeros, 1))
    return replace(scene, events=events, outputs=())


# -- proven -----------------------------------------------------------------------------------


def _proven(name: str, end: int) -> dict[str, Any]:
    """Events proven to be these and no others, and how far heyoka's in double are from them."""
    scene = _watching(library.load(name), *COST_EVENTS)
    run = integrate(scene, "double", at=[end])
    began = time.process_time()
    certified = certify_events(scene, end)
    seconds = time.process_time() - began
    rows = []
    for true, found in zip(certified, run.events, strict=True):
        row: dict[str, Any] = {
            "zero": next(e for e in scene.events if e.name == true.name).zero,
            "proven": len(true.times),
            "undecided": len(true.undecided),
            "double": len(found.times),
        }
        if len(true.times) == len(found.times) > 0:
            off = [abs(exactly(x) - t.time) for x, t in zip(found.times, true.times, strict=True)]
            row["error"] = float(f"{float(max(off)):.2e}")
            row["radius"] = float(f"{max(t.radius for t in true.times):.1e}")
        rows.append(row)
    return {"case": name, "end": end, "events": rows, "seconds": float(f"{seconds:.2g}")}


_MAKERS: dict[str, Callable[..., dict[str, Any]]] = {
    "proven": _proven,
    "motions": _motion,
}

# -- cost -------------------------------------------------------------------------------------


def _cost(name: str, repeats: int) -> dict[str, Any]:
    """Microseconds a step with none, one and three events: the minimum of many, interleaved."""
    scene = library.load(COSTED).at((Fraction(COST_ENDS[name]),))
    scenes = [_watching(scene, *COST_EVENTS[:n]) for n in (0, 1, 3)]
    seconds = [math.inf] * len(scenes)
    steps, found = [0] * len(scenes), [0] * len(scenes)
    for _ in range(repeats):
        for k, watched in enumerate(scenes):
            run = integrate(watched, name)
            steps[k], found[k] = run.steps, sum(len(event.times) for event in run.events)
            seconds[k] = min(seconds[k], run.seconds["run"])
    micros = [1e6 * s / n for s, n in zip(seconds, steps, strict=True)]
    return {
        "number": name,
        "events": [0, 1, 3],
        "steps": steps,
        "found": found,
        "microseconds_a_step": [float(f"{m:.3g}") for m in micros],
        "microseconds_an_event": [
            float(f"{1e6 * (s - seconds[0]) / n:.3g}") if n else None
            for s, n in zip(seconds, found, strict=True)
        ],
    }
