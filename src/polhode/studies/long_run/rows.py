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

from polhode.common.executors import in_order
from polhode.common.progress import Message
from polhode.equations.integrals import departures
from polhode.judging.adaptive_precision import integrate
from polhode.judging.conditioning.conditioning import conditioning
from polhode.judging.correct_digits import log10_errors, log10_rate
from polhode.judging.references.reference import Reference
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers.decimals import significant
from polhode.numbers.number_types import DOUBLE
from polhode.scenes.scene import Scene
from polhode.studies.ensembles import TOPS, random_scene
from polhode.studies.long_run import growth, late_time
from polhode.studies.row_filter import Only

NAME = "long-run"
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


def rows(
    quick: bool = False, tick: Message | None = None, only: Only | None = None
) -> dict[str, Any]:
    """The study's results as a JSON object; no figure in it depends on the clock."""
    decades = (2, 4) if quick else (2, 6)
    wanted = only or Only()
    tops = list(ensembles(decades, STARTS, tick, only=wanted))
    end = 10_000 if quick else 100_000
    found = {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "brouwer": BROUWER,
        "tops": tops,
        "at": late_time.rows(end, STARTS, quick, tick, wanted),
    }
    return found


def ensembles(
    decades: tuple[int, int],
    starts: int,
    tick: Message | None = None,
    workers: int = 2,
    only: Only | None = None,
) -> Iterator[dict[str, Any]]:
    """A row a top: medians over its starts at every half decade, and exponents."""
    times = half_decades(*decades)
    methods = (PLAIN, PROJECTED)
    tops = [top for top in TOPS if only is None or only(f"{top} growth", *FAR)]
    asked = [RunStart(top, k, times, methods) for top in tops for k in range(starts)]
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
                    "median": [significant(x, 3) for x in growth.medians(series)],
                    "largest": [
                        significant(max(column), 3) for column in zip(*series, strict=True)
                    ],
                    **_exponents(growth.exponent(shown, series, since)),
                    "law": LINEAR if method == PROJECTED else BROUWER[name],
                }
        if method == PLAIN:
            found["integrals"] = _integrals(shown, members, since)
        taken = [m.projection for m in members if m.projection is not None]
        if method == PROJECTED and taken:
            found["projection"] = {
                "onto": sorted({name for onto, _, _ in taken for name in onto}),
                "largest": significant(max(largest for _, largest, _ in taken), 3),
                "sum": significant(max(total for _, _, total in taken), 3),
            }
            found["inputs"] = _beside_inputs(members)
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


def _exponents(fitted: growth.Exponent | None) -> dict[str, float | None]:
    """An exponent and that of the last decade, each with its standard error; None of nothing."""
    names = ("exponent", "uncertainty", "last_decade", "last_uncertainty")
    values = (None,) * 4 if fitted is None else fitted
    return {k: None if x is None else round(x, 3) for k, x in zip(names, values, strict=True)}


def _integrals(
    times: Sequence[float], members: Sequence[Member], since: float
) -> list[dict[str, Any]]:
    """Each integral's departure over the ensemble: mean beside standard deviation."""
    found = []
    for name in members[0].departures:
        series = [m.departures[name] for m in members]
        fitted = growth.exponent_of_deviation(times, series, since)
        found.append(
            {
                "integral": name,
                "mean": [significant(x, 3) for x in growth.means(series)],
                "deviation": [significant(x, 3) for x in growth.deviations(series)],
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
        "median": [significant(x, 3) for x in growth.medians([m.inputs for m in members])],
        "error_over_it": [significant(x, 3) for x in growth.medians(over)],
    }


def _reference_error(scene: Scene) -> float | None:
    """An estimate of the closed form's own error at the last time; None where there is none."""
    reference = reference_of(scene)
    if not isinstance(reference, Reference):
        return None
    return significant(float(reference.error(scene.times[-1:], DIGITS)), 3)
