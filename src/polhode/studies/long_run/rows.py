"""Study ``long-run``: growth of error and drift in double over four decades of time and more.

Brouwer's law (Brouwer 1937): where roundings are independent, errors of the integrals grow like
t^(1/2) and those of the phase like t^(3/2).  Ensembles of random bodies of the three kinds, each
with a random start, all numbers decimals of two places that no double holds, are judged against
closed forms.
"""

from __future__ import annotations

import math
import random
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from polhode.equations.integrals import drift
from polhode.judging.digits import errors, rate_scale
from polhode.judging.reference import Reference
from polhode.judging.reference import reference as reference_of
from polhode.numbers.number_types import DOUBLE, bits_for
from polhode.runs.integrate import integrate
from polhode.runs.workers import in_order
from polhode.scenes.body import Body, Vector
from polhode.scenes.scene import Scene, even_times
from polhode.studies.long_run import growth
from polhode.studies.processes import Curve, Method, Task, plain_scene, run_all

NAME = "long-run"
QUESTION = (
    "How do error and drift of a double run grow with time, with and without projection, and which "
    "double methods are still right to ten digits at t = 100 000?"
)
BROUWER = {"error": 1.5, "drift": 0.5}
STARTS = 16
SEED = 20
DIGITS = 24  # asked of the closed forms
FIT_SINCE = 1000.0  # the roundings of the inputs, which grow like t, come first
PLAIN, PROJECTED = "double", "double projected"

Tick = Callable[[str], None]


def hundredths(dice: random.Random, least: float, most: float) -> Fraction:
    """A random decimal of two places, not a double's as a rule."""
    return Fraction(dice.randint(round(100 * least), round(100 * most)), 100)


def free(dice: random.Random) -> Body:
    """A free body of any moments, in any order."""
    a, b = hundredths(dice, 1, 3), hundredths(dice, 1, 3)
    c = hundredths(dice, float(abs(a - b)) + 0.1, float(a + b) - 0.1)
    moments = [a, b, c]
    dice.shuffle(moments)
    return Body.of_moments(moments)


def symmetric(dice: random.Random) -> Body:
    """A symmetric top, disc or needle, its centre on the axis."""
    a = hundredths(dice, 0.7, 2)
    c = hundredths(dice, 0.2, 1.8 * float(a))
    return Body.of_moments((a, a, c), (0, 0, hundredths(dice, 0.3, 1.5)), 1)


def kovalevskayas(dice: random.Random) -> Body:
    """A = B = 2C, the centre anywhere in the equator."""
    c = hundredths(dice, 0.5, 1.5)
    x, y = hundredths(dice, -1.2, 1.2), hundredths(dice, 0.2, 1.2)
    return Body.of_moments((2 * c, 2 * c, c), (x, y, 0), 1)


TOPS = {"euler": free, "lagrange": symmetric, "kovalevskaya": kovalevskayas}


class Member(NamedTuple):
    """One start's errors at the times for each method, the drift, and what projection took.

    ``drift``: of the run that is not projected; after a projection it says nothing about accuracy.
    ``projection``: the integrals' names, and the largest and the sum of the corrections.
    """

    errors: dict[str, list[float]]
    drift: list[float]
    projection: tuple[tuple[str, ...], float, float] | None


@dataclass(frozen=True)
class RunStart:
    """One member of an ensemble: a top, the number of the start, the times, the methods."""

    top: str
    index: int
    times: tuple[Fraction, ...]
    methods: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        """The exact scene: any body of the kind, |components| of w at most 1, any gamma."""
        dice = random.Random(f"{SEED} {self.top} {self.index}")
        body = TOPS[self.top](dice)
        omega = [Fraction(dice.randint(-100, 100), 100) for _ in range(3)]
        u, v = (Fraction(dice.randint(-20, 20), 10) for _ in range(2))
        square = u * u + v * v
        gamma = (2 * u / (1 + square), 2 * v / (1 + square), (1 - square) / (1 + square))
        p, q, r = omega
        start: Vector = (p, q, r)
        name = f"{self.top} start {self.index + 1}"
        return Scene(body, start, gamma, times=self.times, name=name)


def rows(quick: bool = False, tick: Tick | None = None) -> dict[str, Any]:
    """The study's results as a JSON object; no figure in it depends on the clock."""
    decades = (2, 4) if quick else (2, 6)
    tops = list(ensembles(decades, STARTS, tick))
    end = 10_000 if quick else 100_000
    found = {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "brouwer": BROUWER,
        "tops": tops,
        "at": far(end, quick, tick),
    }
    return found


def ensembles(
    decades: tuple[int, int], starts: int, tick: Tick | None = None, workers: int = 2
) -> Iterator[dict[str, Any]]:
    """A row a top: medians over its starts at every half decade, and exponents."""
    times = half_decades(*decades)
    methods = (PLAIN, PROJECTED)
    asked = [RunStart(top, k, times, methods) for top in TOPS for k in range(starts)]
    members: list[Member] = []

    def begun(start: RunStart) -> None:
        if tick is not None:
            tick(f"{NAME}: {start.scene.name} of {starts}")

    for start, member in zip(asked, in_order(follow, asked, workers, begun), strict=True):
        members.append(member)
        if len(members) == starts:
            yield _top_row(start.top, times, members)
            members = []


def half_decades(first: int, last: int) -> tuple[Fraction, ...]:
    """Whole numbers nearest to 10**first, 10**(first + 1/2), ..., 10**last."""
    return tuple(Fraction(round(10 ** (k / 2))) for k in range(2 * first, 2 * last + 1))


def follow(start: RunStart) -> Member:
    """Integrate one start by every method and judge it at every time."""
    scene = start.scene
    reference = reference_of(scene).at(scene.times, DIGITS)
    bits = bits_for(DIGITS) + 32
    scale = rate_scale(reference, scene, bits)
    made, departures, taken = {}, [], None
    for method in start.methods:
        run = integrate(scene, "double", project=method == PROJECTED)
        made[method] = [float(e) for e in errors(run.states, reference, scale, bits)]
        if method == PROJECTED:
            put = run.projection
            assert put is not None
            taken = put.onto, put.largest, put.sum
        else:
            departures = [
                max(x for x in drift(scene, run.states[k : k + 1], DOUBLE.bits) if x is not None)
                for k in range(len(run.states))
            ]
    return Member(made, departures, taken)


def far(end: int, quick: bool, tick: Tick | None = None) -> dict[str, Any]:
    """Every double method on one motion a top to ``end``, at its tightest tolerance."""
    scenes = {
        top: plain_scene(case, even_times(Fraction(end), 11))
        for top, case in (
            ("euler", "euler/largest-axis"),
            ("lagrange", "lagrange/nutation"),
            ("kovalevskaya", "kovalevskaya/generic"),
        )
    }
    asked = FAR[:3] if quick else FAR
    tasks = [Task(method, scene) for scene in scenes.values() for method in asked]
    with tempfile.TemporaryDirectory() as cache:
        step = None if tick is None else lambda what: tick(f"{NAME}: {what}")
        curves = run_all(tasks, Path(cache), 0, 0.0, step, rounds=1)
    made = iter(curves)
    return {
        "t": end,
        "tops": [
            {
                "top": top,
                "case": scene.name,
                "methods": [
                    *_judged(scene, [(method, next(made)) for method in asked]),
                    *({"method": m, "status": "not run", "reason": r} for m, r in NOT_RUN.items()),
                ],
            }
            for top, scene in scenes.items()
        ],
    }


_TIGHT = (1e-14,)
FAR = (
    Method("polhode double", "polhode.studies.own_process", "double", (2.0**-52,)),
    Method(
        "polhode double projected", "polhode.studies.own_process", "double projected", (2.0**-52,)
    ),
    Method("heyoka alone", "polhode.peers.bare_heyoka", "", (2.0**-52,)),
    Method("CyRK DOP853", "polhode.peers.cyrk", "DOP853", _TIGHT),
    Method("CyRK VERN8", "polhode.peers.cyrk", "VERN8", _TIGHT),
    Method("CyRK LSODA", "polhode.peers.cyrk", "LSODA", _TIGHT),
    Method("numbalsoda dop853", "polhode.peers.numbalsoda_cfunc", "dop853", _TIGHT),
    Method("numbalsoda lsoda", "polhode.peers.numbalsoda_cfunc", "lsoda", _TIGHT),
    Method("diffrax Dopri8", "polhode.peers.diffrax_dopri8", "Dopri8", _TIGHT),
)
NOT_RUN = {
    "SciPy DOP853": "a minute or more: the steps of the compiled DOP853, taken in Python",
    "SciPy LSODA": "a minute or more: the steps of the compiled LSODA, taken in Python",
    "mpmath odefun": "hours: a Taylor method in Python",
}


def _judged(scene: Scene, curves: Sequence[tuple[Method, Curve]]) -> Iterator[dict[str, Any]]:
    reference = reference_of(scene).at(scene.times, DIGITS)
    bits = bits_for(DIGITS) + 32
    scale = rate_scale(reference, scene, bits)
    for method, curve in curves:
        found: dict[str, Any] = {"method": method.name, "status": curve.status}
        for tol, point in curve.points.items():
            if point.rows is not None:
                worst = max(float(e) for e in errors(point.rows, reference, scale, bits))
                found |= {"tol": tol, "error": _short(worst), "digits": _digits(worst)}
        yield found | {"reason": curve.reason}


def _top_row(top: str, times: Sequence[Fraction], members: Sequence[Member]) -> dict[str, Any]:
    first = RunStart(top, 0, tuple(times), ()).scene
    shown = [float(t) for t in times]
    since = min(FIT_SINCE, shown[-1] / 100)
    made = []
    for method in members[0].errors:
        found: dict[str, Any] = {"method": method}
        for name, series in (
            ("error", [m.errors[method] for m in members]),
            ("drift", [m.drift for m in members] if method == PLAIN else []),
        ):
            if series:
                fitted = growth.exponent(shown, series, since)
                found[name] = {
                    "median": [_short(x) for x in growth.medians(series)],
                    "largest": [_short(max(column)) for column in zip(*series, strict=True)],
                    "exponent": None if fitted is None else round(fitted.value, 3),
                    "uncertainty": None if fitted is None else round(fitted.uncertainty, 3),
                    "last_decade": None if fitted is None else round(fitted.last_decade, 3),
                    "last_uncertainty": None
                    if fitted is None
                    else round(fitted.last_uncertainty, 3),
                }
        taken = [m.projection for m in members if m.projection is not None]
        if method == PROJECTED and taken:
            found["projection"] = {
                "onto": sorted({name for onto, _, _ in taken for name in onto}),
                "largest": _short(max(largest for _, largest, _ in taken)),
                "sum": _short(max(total for _, _, total in taken)),
            }
        made.append(found)
    limit = _reference_error(first)
    least = min(x for found in made for x in found["error"]["median"])
    return {
        "top": top,
        "starts": len(members),
        "times": [int(t) for t in times],
        "fitted_since": since,
        "reference_error": limit,
        "wall": limit is not None and limit > least / 10,
        "methods": made,
    }


def _reference_error(scene: Scene) -> float | None:
    """An estimate of the closed form's own error at the last time; None where there is none."""
    reference = reference_of(scene)
    if not isinstance(reference, Reference):
        return None
    return _short(float(reference.error(scene.times[-1:], DIGITS)))


def _digits(error: float) -> float:
    return round(min(DOUBLE.most_digits, max(0.0, -math.log10(error))), 2) if error else 0.0


def _short(x: float) -> float:
    return float(f"{x:.3g}")
