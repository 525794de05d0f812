"""Study ``long-run``: growth of error and drift in double over four decades of time and more.

Brouwer's law (Brouwer 1937): where roundings are independent, errors of the integrals grow like
t^(1/2) and those of the phase like t^(3/2).  Where a run is put back on its integrals, no phase
gathers from their errors: what rounded coefficients do to the frequencies is left, which grows like
t.  Ensembles of random bodies of the three kinds, each with a random start, all numbers decimals of
two places that no double holds, are judged against closed forms.

A drift of independent roundings is a random walk: over the ensemble each integral's departure has
the mean zero within its standard error, and a standard deviation that grows like t^(1/2).  A bias
of one sign would show in the mean, one that differs from body to body in the exponent.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.common.interrupts import Message
from polhode.common.processes import in_order
from polhode.equations.integrals import departures
from polhode.judging.adaptive_precision import integrate
from polhode.judging.conditioning import conditioning
from polhode.judging.correct_digits import log10_errors, log10_rate
from polhode.judging.reference import Reference
from polhode.judging.reference import reference as reference_of
from polhode.numbers.decimals import significant
from polhode.numbers.number_types import DOUBLE, Doubles
from polhode.scenes.scene import Scene
from polhode.studies.ensembles import TOPS, random_scene
from polhode.studies.long_run import growth, late_time
from polhode.studies.row_filter import Only

QUESTION = (
    "How do error and drift of a double run grow with time, with and without projection, and how "
    "far off are other programs in double at t = 100 000?"
)
#: Exponents: Brouwer's, and that of projected runs.
BROUWER = {"error": 1.5, "drift": 0.5}
LINEAR = 1.0
STARTS = 16
DIGITS = 24  # asked of the closed forms
FIT_SINCE = 1000.0  # the roundings of the inputs, which grow like t, come first
PLAIN, PROJECTED = "double", "double projected"
#: What rounding the inputs leaves of a projected run is followed so far: 35 µs a step.
INPUTS_UNTIL = 3163

#: Labels of the rows of polhode in the table of the far moment.
FAR = ("polhode, not projected", "far")


class Member(NamedTuple):
    """One start's errors at the times for each method, departures, and what projection took.

    ``departures``: of each integral, relative, with its sign, in the run that is not projected;
    after a projection they say nothing about accuracy.  ``projection``: the integrals' names, and
    the largest and the sum of the corrections.  ``inputs``: errors that rounding the inputs leaves
    of a projected run, at the first times.
    """

    errors: dict[str, list[float]]
    departures: dict[str, list[float]]
    projection: tuple[tuple[str, ...], float, float] | None
    inputs: list[float]

    @property
    def drift(self) -> list[float]:
        """The largest departure of any integral, at each time."""
        return [max(map(abs, row)) for row in zip(*self.departures.values(), strict=True)]


@dataclass(frozen=True)
class RunStart:
    """One member of an ensemble: a top, the number of the start, the times, the methods."""

    top: str
    index: int
    times: tuple[Fraction, ...]
    methods: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        """The exact scene."""
        return random_scene(self.top, self.index, self.times)


def rows(quick: bool, say: Message, wanted: Only) -> dict[str, Any]:
    """The study's rows; no figure in them depends on the clock."""
    tops = [*ensembles((2, 4) if quick else (2, 6), STARTS, say, wanted)]
    end = 10_000 if quick else 100_000
    return {
        "brouwer": BROUWER,
        "tops": tops,
        "at": late_time.rows(end, STARTS, quick, say, wanted),
    }


def ensembles(
    decades: tuple[int, int], starts: int, say: Message, wanted: Only, workers: int = 2
) -> Iterator[dict[str, Any]]:
    """One row per top: medians over its starts at every half decade, and exponents."""
    times = half_decades(*decades)
    methods = (PLAIN, PROJECTED)
    tops = [top for top in TOPS if wanted(f"{top} growth", *FAR)]
    asked = [RunStart(top, k, times, methods) for top in tops for k in range(starts)]
    members: list[Member] = []

    def begun(start: RunStart) -> None:
        say(f"{start.scene.name} of {starts}")

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
    rate = log10_rate(reference, scene)
    made, strayed, taken, left = {}, {}, None, []
    for method in start.methods:
        run = integrate(scene, "double", project=method == PROJECTED)
        made[method] = (10 ** log10_errors(run.states, reference, rate)).tolist()
        if method == PROJECTED:
            put = run.projection
            assert put is not None
            taken = put.onto, put.largest, put.sum
            left = _inputs(scene, put.every)
        else:
            found = departures(scene, run.states)
            strayed = {name: [float(x) for x in column] for name, column in found.items()}
    return Member(made, strayed, taken, left)


def _inputs(scene: Scene, every: int) -> list[float]:
    """What rounding the inputs leaves of a run that is projected so often, at the first times."""
    first = [t for t in scene.times if t <= INPUTS_UNTIL]
    digits = conditioning(scene, first).inputs(DOUBLE, every)
    return [10.0**-x for x in digits if x is not None]


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
                found[name] = {
                    "median": _short(np.median(series, axis=0)),
                    "largest": _short(np.max(series, axis=0)),
                    **_exponents(growth.exponent(shown, series, since)),
                    "law": LINEAR if method == PROJECTED else BROUWER[name],
                }
        if method == PLAIN:
            found["integrals"] = _integrals(shown, members, since)
        if method == PROJECTED:
            onto, largest, total = zip(
                *(m.projection for m in members if m.projection), strict=True
            )
            found["projection"] = {
                "onto": sorted({name for names in onto for name in names}),
                "largest": significant(max(largest), 3),
                "sum": significant(max(total), 3),
            }
            found["inputs"] = _beside_inputs(members)
        made.append(found)
    reference = reference_of(first)
    assert isinstance(reference, Reference)
    limit = significant(float(reference.error(first.times[-1:], DIGITS)), 3)
    least = min(x for found in made for x in found["error"]["median"])
    return {
        "top": top,
        "starts": len(members),
        "times": [int(t) for t in times],
        "fitted_since": since,
        "reference_error": limit,
        "wall": limit > least / 10,
        "methods": made,
    }


def _short(values: Doubles) -> list[float]:
    """Numbers as they are kept in files."""
    return [significant(float(x), 3) for x in values]


def _exponents(fitted: growth.Exponent | None) -> dict[str, float | None]:
    """An exponent and that of the last decade, each with its standard error; None of nothing."""
    if fitted is None:
        return dict.fromkeys(growth.Exponent._fields)
    return {name: round(x, 3) for name, x in fitted._asdict().items()}


def _integrals(
    times: Sequence[float], members: Sequence[Member], since: float
) -> list[dict[str, Any]]:
    """Each integral's departure over the ensemble: mean beside standard deviation."""
    found = []
    for name in members[0].departures:
        series = [m.departures[name] for m in members]
        fitted = growth.exponent(times, series, since, np.std)
        found.append(
            {
                "integral": name,
                "mean": _short(np.mean(series, axis=0)),
                "deviation": _short(np.std(series, axis=0, ddof=1)),
                **_exponents(fitted),
                "law": BROUWER["drift"],
            }
        )
    return found


def _beside_inputs(members: Sequence[Member]) -> dict[str, Any]:
    """What rounding the inputs leaves of projected runs, and their errors over it, at first.

    Medians over the ensemble.
    """
    over = [
        [error / alone for error, alone in zip(m.errors[PROJECTED], m.inputs, strict=False)]
        for m in members
    ]
    return {
        "median": _short(np.median([m.inputs for m in members], axis=0)),
        "error_over_it": _short(np.median(over, axis=0)),
    }
