"""Study ``events``: event times and counts against closed forms, and what events cost."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

import mpmath

import kit
import polhode
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import significant
from polhode.numbers.exact import rounded
from polhode.numbers.number_types import NAMES

PERIODS = 10  # over which every event is judged in every number type
#: The number types, the ends of far runs by them, and the end of proofs.
WHOLE = NAMES, {"double": 10_000, "extended": 10_000, "quad": 1_000}, 100
QUICK = ("double", "quad"), {"double": 1000}, 10
KEPT = 24  # errors of a far run that the figure shows
PROVEN = ("general/asymmetric-regular", "general/asymmetric-chaotic")


class EventMotion(NamedTuple):
    """A case, what vanishes, and what it is to people."""

    name: str
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


def rows(quick: bool, say: kit.Say, only: kit.Only) -> dict[str, Any]:
    """The study's rows; only the seconds in them depend on the clock."""
    motions = [m for m in (MOTIONS[:1] if quick else MOTIONS) if only(m.name, m.what)]
    proven = [name for name in PROVEN[: 1 if quick else 2] if only(name)]
    numbers, far, end = QUICK if quick else WHOLE
    motion_row, proven_row = partial(_motion, near=numbers, far=far), partial(_proven, end=end)
    parts: kit.Parts = {"proven": (proven_row, proven), "motions": (motion_row, motions)}
    costed = [name for name in numbers if only("cost", name)]
    cost: kit.Parts = {"cost": (partial(_cost_row, repeats=1 if quick else 9), costed)}
    # a clock runs beside nothing else
    return kit.rows_by_part(parts, quick, say) | kit.rows_by_part(cost, True, say)


# -- times and counts -------------------------------------------------------------------------


def _motion(motion: EventMotion, near: Iterable[str], far: dict[str, int]) -> dict[str, Any]:
    scene = _watching(polhode.load(motion.name), motion.zero)
    zeros = Zeros(scene)
    end = math.floor(PERIODS * zeros.period)
    return {
        "case": motion.name,
        "zero": motion.zero,
        "what": motion.what,
        "period": polhode.as_decimal(zeros.period, 18),
        "near": [_run(scene, zeros, name, end) for name in near],
        "far": [_run(scene, zeros, name, end) for name, end in far.items()],
    }


def _run(scene: polhode.Scene, zeros: Zeros, name: str, end: int) -> dict[str, Any]:
    """Events to a time: how many, and their distances from the closed form's."""
    run = polhode.integrate(scene, name, at=[end])
    (event,) = run.events
    true = zeros.until(end)
    row: dict[str, Any] = {
        "number": name,
        "end": end,
        "true": len(true),
        "found": len(event.times),
        "complete": event.complete,
        "grazing": sum(event.grazing),
    }
    if len(event.times) == len(true) > 0:
        off = [abs(t - x) for t, x in zip(event.times, true, strict=True)]
        ulps = [float(gap / ulp(x, run.number.bits)) for gap, x in zip(off, true, strict=True)]
        relative = max(gap / x for gap, x in zip(off, true, strict=True))
        most = run.number.most_digits
        samples = [*zip(true, ulps, strict=True)][:: max(1, len(true) // KEPT)]
        row |= {
            "ulps": significant(max(ulps), 3),
            "error": significant(float(max(off)), 3),
            "digits": round(min(most, -math.log10(relative)) if relative else most, 2),
            "samples": [[round(float(x), 3), significant(u, 3)] for x, u in samples],
        }
    return row


def _watching(scene: polhode.Scene, *zeros: str) -> polhode.Scene:
    events = tuple(polhode.Event(f"event {k}", zero) for k, zero in enumerate(zeros, 1))
    return replace(scene, events=events, outputs=())


# -- proven -----------------------------------------------------------------------------------


def _proven(name: str, end: int) -> dict[str, Any]:
    """Events proven to be these and no others, and how far heyoka's in double are from them."""
    scene = _watching(polhode.load(name), *COST_EVENTS)
    run = polhode.integrate(scene, "double", at=[end])
    certified, seconds = kit.clocked(partial(polhode.certify_events, scene, end))
    rows = []
    for true, event in zip(certified, run.events, strict=True):
        row: dict[str, Any] = {
            "zero": next(e for e in scene.events if e.name == true.name).zero,
            "proven": len(true.times),
            "undecided": len(true.undecided),
            "double": len(event.times),
        }
        if len(true.times) == len(event.times) > 0:
            off = [abs(exactly(x) - t.time) for x, t in zip(event.times, true.times, strict=True)]
            row["error"] = significant(float(max(off)), 3)
            row["radius"] = significant(max(t.radius for t in true.times), 2)
        rows.append(row)
    return {"case": name, "end": end, "events": rows, "seconds": significant(seconds, 2)}


# -- cost -------------------------------------------------------------------------------------


def _cost_row(name: str, repeats: int) -> dict[str, Any]:
    """Microseconds a step with none, one and three events: the least of runs in turns."""
    scene, events = polhode.load(COSTED).at((Fraction(COST_ENDS[name]),)), (0, 1, 3)
    scenes = [_watching(scene, *COST_EVENTS[:n]) for n in events]
    calls = [partial(polhode.integrate, watched, name) for watched in scenes]
    timed = kit.timed(calls, repeats, math.inf)
    counts = [sum(len(event.times) for event in x.answer.events) for x in timed]
    extra = [1e6 * (x.seconds - timed[0].seconds) for x in timed]
    costs = [significant(x / n, 3) if n else None for x, n in zip(extra, counts, strict=True)]
    return {
        "number": name,
        "events": [*events],
        "steps": [x.answer.steps for x in timed],
        "found": counts,
        "microseconds_a_step": [significant(1e6 * x.seconds / x.answer.steps, 3) for x in timed],
        "microseconds_an_event": costs,
    }


# --- zeros ----------------------------------------------------------------------------------------
#
# The reference of the study of events: proven zeros along periodic motions.


ZERO_DIGITS = 65  # of the zeros of one period
BITS = 240


class Zeros:
    """The zeros of a scene's event along a periodic motion, any number of periods of it.

    Those of one period alone are proven, without a run.  The period is that of omega by the closed
    form, or of the nutation where omega has none.
    """

    def __init__(self, scene: polhode.Scene) -> None:
        reference = polhode.reference(scene)
        with mpmath.workprec(BITS):
            period = reference.period or 2 * mpmath.pi / reference.frequencies["nutation"]
        self.period = exactly(period)
        past = self.period * Fraction(5, 4)  # an event at the end of a proof is not decided
        (event,) = polhode.certify_events(scene, past, digits=ZERO_DIGITS)
        self.first = [x.time for x in event.times if x.time <= self.period + Fraction(x.radius)]

    def until(self, end: int) -> list[Fraction]:
        """All zeros in 0 < t <= end."""
        count = math.ceil(end / self.period) + 1
        every = [self.period * n + t for n in range(count) for t in self.first]
        return [t for t in every if 0 < t <= end]


def ulp(t: Fraction, bits: int) -> Fraction:
    """The distance between neighbours of a type of so many bits at t."""
    mantissa, exponent = rounded(t, bits)
    return Fraction(2) ** (exponent + mantissa.bit_length() - bits)


# --- page -----------------------------------------------------------------------------------------
#
# Rows of the tables and facts of the events study's page.


def tables(results: kit.JsonObject) -> dict[str, Iterable[kit.JsonObject]]:
    """The rows of the page's tables from the study's JSON object."""
    return {
        "near": kit.inner_rows(results["motions"], "near"),
        "far": kit.inner_rows(results["motions"], "far"),
        "proven": kit.inner_rows(results["proven"], "events"),
        "cost": results["cost"],
    }


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    near, far = (kit.inner_rows(results["motions"], part) for part in ("near", "far"))
    proven = kit.inner_rows(results["proven"], "events")
    return {
        "end": max((run["end"] for run in far), default=0),
        "true": sum(run["true"] for run in far),
        "found": sum(run["found"] for run in far),
        "whole": kit.share(run["complete"] for run in far),
        "ulps": max((run["ulps"] for run in near if "ulps" in run), default=0),
        "exact": kit.share(run["complete"] and run["found"] == run["true"] for run in near + far),
        "same": kit.share(not x["undecided"] and x["proven"] == x["double"] for x in proven),
        "steps": kit.share(len({*row["steps"]}) == 1 for row in results["cost"]),
    }


# --- figure ---------------------------------------------------------------------------------------
#
# Figure of the study of events: errors of their times.


FLOOR = 0.01  # ulps: smaller errors are drawn there, on the axis


def svgs(results: kit.JsonObject) -> dict[str, str]:
    """How large errors of event times are, in ulps."""
    return {"events": kit.drawn(partial(_draw_errors, motions=results["motions"]), 3)}


def _draw_errors(axes: kit.Axes, motions: Sequence[kit.JsonObject]) -> None:
    """How many events have no larger error than that: a curve a number type."""
    for name, colour in kit.COLOURS.items():
        sizes = [
            max(ulps, FLOOR)
            for run in kit.inner_rows(motions, "near", "far")
            if run["number"] == name
            for _, ulps in run.get("samples", ())
        ]
        if sizes:
            look: dict[str, Any] = {"marker": kit.MARKS[name], "ms": 4, "color": colour}
            axes.ecdf(sizes, label=name, markevery=max(len(sizes) // 8, 1), **look)
    axes.set(xscale="log", xlabel="error of the time, in units of its last place")
    axes.set(xlim=(FLOOR, None), ylim=(0, 1), ylabel="events with no larger error")
    kit.plain(axes)
