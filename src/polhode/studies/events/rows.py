"""Study ``events``: event times and counts against closed forms, grazing, and what events cost."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from polhode.enclosures.events import certify_events
from polhode.judging.reference import Reference
from polhode.judging.reference import reference as reference_of
from polhode.numbers import decimals, exact, number_types
from polhode.numbers.convert import exactly, to_mpf
from polhode.numbers.number_types import NumberType
from polhode.runs.integrate import integrate
from polhode.scenes import columns as columns_
from polhode.scenes import library
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.studies.only import Only

NAME = "events"
QUESTION = (
    "How close are event times to those of closed forms, in units in the last place of the time? "
    "Is every event counted once to t = 10 000? What becomes of contacts that rounding decides, "
    "and what does an event cost?"
)
DIGITS = 65  # of the closed form where its zeros are located
BITS = 240
PERIODS = 10  # over which every event is judged in every number type
FAR = {"double": 10_000, "extended": 10_000, "quad": 1_000}
QUICK_FAR = {"double": 10_000}
KEPT = 24  # errors of a far run that the figure shows

PROVEN = ("general/asymmetric-regular", "general/asymmetric-chaotic")
PROVEN_END = 100

Tick = Callable[[str], None]


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

#: q of euler/largest-axis reaches sqrt(7/25) once a period: (2hC - G²)/(B(C - B)) where p = 0.
TOUCHING = EventMotion("euler/largest-axis", "q - sqrt(7/25)", "q touches its largest value")
TOUCHES = EventMotion("euler/largest-axis", "p", "")
SHIFTS = ("0", "1e-6", "-1e-6", "1e-10", "-1e-10")

COSTED = "general/asymmetric-regular"
COST_ENDS = {"double": 2000, "extended": 200, "quad": 5, "mp": 2}
COST_EVENTS = ("p*gamma2 - q*gamma1", "q", "gamma3 - 1/2")


def rows(quick: bool = False, tick: Tick | None = None, only: Only | None = None) -> dict[str, Any]:
    """The study's results as a JSON object; only the seconds in it depend on the clock."""
    say = tick or (lambda _: None)
    wanted = only or Only()
    motions = []
    for motion in MOTIONS[:3] if quick else MOTIONS:
        if not wanted(motion.case, motion.what):
            continue
        say(f"{NAME}: {motion.case}, {motion.what}")
        motions.append(_motion(motion, QUICK_FAR if quick else FAR))
    say(f"{NAME}: grazing contacts")
    names = number_types.NAMES[: 2 if quick else 4]
    grazing = [_grazing(n, s) for n in names for s in SHIFTS if wanted("grazing", n, s)]
    cusps = [_cusps(n) for n in names if wanted("cusps", n)]
    cost = []
    for name in number_types.NAMES:
        if not wanted("cost", name):
            continue
        say(f"{NAME}: cost in {name}")
        cost.append(_cost(name, 3 if quick else 9))
    say(f"{NAME}: proven events")
    proven = [_proven(name, PROVEN_END) for name in PROVEN[: 1 if quick else 2] if wanted(name)]
    return {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "proven": proven,
        "motions": motions,
        "grazing": grazing,
        "cusps": cusps,
        "cost": cost,
    }


# -- the reference --------------------------------------------------------------------------------


class Zeros:
    """The zeros of an expression along a periodic closed form, to 60 digits, any number of periods.

    They are found in one period alone, by signs at many times and then by the secant rule.
    """

    def __init__(self, scene: Scene, zero: str, samples: int = 64) -> None:
        reference = reference_of(replace(scene, events=()))
        assert isinstance(reference, Reference)
        self._reference, self._zero, self._columns = reference, zero, scene.columns
        self.period = exactly(reference.period)
        times = [self.period * k / samples for k in range(samples + 1)]
        values = [exact.sign(v) for v in self._values(times, 20)]
        self.first: list[Fraction] = []
        for k in range(samples):
            if values[k] * values[k + 1] < 0:
                self.first.append(self._refined(times[k], times[k + 1]))
            elif values[k] == 0 and k > 0:
                self.first.append(times[k])

    def until(self, end: int) -> list[Fraction]:
        """All zeros in 0 < t <= end."""
        count = math.ceil(end / self.period) + 1
        every = [self.period * n + t for n in range(count) for t in self.first]
        return [t for t in every if 0 < t <= end]

    def _values(self, times: Sequence[Any], digits: int) -> list[Fraction]:
        found = []
        for t, row in zip(times, self._reference.at(times, digits), strict=True):
            columns = dict(zip(self._columns, row, strict=True), t=to_mpf(exactly(t), BITS))
            value = exactly(columns_.value(self._zero, columns, BITS))
            found.append(value if abs(value) > Fraction(1, 10 ** (digits - 3)) else Fraction(0))
        return found

    def _refined(self, low: Fraction, high: Fraction) -> Fraction:
        from polhode.numbers.private import mpmath

        def value(t: Any) -> Any:
            row = self._reference.at([t], DIGITS)[0]
            columns = dict(zip(self._columns, row, strict=True), t=t)
            return columns_.value(self._zero, columns, BITS)

        with mpmath.workprec(BITS):
            between = (to_mpf(low, BITS), to_mpf(high, BITS))
            root = mpmath.findroot(value, between, solver="anderson", tol=1e-120, maxsteps=60)
            return exactly(root)


def ulp(t: Fraction, bits: int) -> Fraction:
    """The distance between neighbours of a type of so many bits at t."""
    mantissa, exponent = exact.rounded(t, bits)
    return Fraction(2) ** (exponent + abs(mantissa).bit_length() - bits)


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


# -- contacts ---------------------------------------------------------------------------------


def _grazing(name: str, shift: str) -> dict[str, Any]:
    """q against its largest value less a shift: a contact, two crossings, or none, once a period.

    Within sqrt(eps) of a touch rounding decides, and one undecided contact is to be reported.
    """
    scene = library.load(TOUCHING.case)
    end = 100 if name in ("double", "extended") else 40
    zeros = Zeros(scene, TOUCHES.zero)
    reference = reference_of(scene)
    touches = sum(reference.at([t], 10)[0][1] > 0 for t in zeros.until(end))
    text = TOUCHING.zero if shift == "0" else f"{TOUCHING.zero} + {shift}"
    run = integrate(_watching(scene, text), name, at=[end])
    (event,) = run.events
    undecided = abs(float(shift)) < math.sqrt(run.number.eps)
    expected = (touches, touches) if undecided else (2 * touches * (float(shift) > 0), 0)
    return {
        "number": name,
        "shift": shift,
        "touches": touches,
        "found": len(event.times),
        "grazing": sum(event.grazing),
        "as_expected": expected == (len(event.times), sum(event.grazing)),
    }


def _cusps(name: str) -> dict[str, Any]:
    """psi' of the cusped top vanishes at each cusp and is positive else: a grazing contact each."""
    scene = library.load("lagrange/cusped")
    reference = reference_of(scene)
    end = 100 if name in ("double", "extended") else 20
    run = integrate(_watching(scene, "p*gamma1 + q*gamma2"), name, at=[end])
    (event,) = run.events
    return {
        "number": name,
        "cusps": math.floor(end / exactly(reference.period)),
        "found": len(event.times),
        "grazing": sum(event.grazing),
    }


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


# -- cost -------------------------------------------------------------------------------------


def _cost(name: str, repeats: int) -> dict[str, Any]:
    """Microseconds a step with none, one and three events: the least of many, interleaved."""
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
