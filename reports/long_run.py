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

import math
import statistics
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np

import kit
import polhode
from peers.process import ask
from polhode.numbers.decimals import significant
from polhode.numbers.number_types import DOUBLE
from programs import BY_NAME, ENGINE, EPS
from tops import TOPS, draw, present, random_scene

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
FAR = (f"polhode {PROJECTED}", "far")


class Member(NamedTuple):
    """One start's errors at the times for each method, departures, and what projection took.

    ``departures``: of each integral, relative, with its sign, in the run that is not projected;
    after a projection they say nothing about accuracy.  ``inputs``: errors that rounding the inputs
    leaves of a projected run, at the first times.
    """

    errors: dict[str, list[float]]
    departures: dict[str, list[float]]
    projection: polhode.Projection | None
    inputs: list[float]

    @property
    def drift(self) -> list[float]:
        """The largest departure of any integral, at each time."""
        return [max(map(abs, row)) for row in zip(*self.departures.values(), strict=True)]


def rows(quick: bool, say: kit.Say, only: kit.Only) -> dict[str, Any]:
    """The study's rows; no figure in them depends on the clock."""
    first, last, end, starts = (1, 2, 100, 2) if quick else (2, 6, 100_000, STARTS)
    # whole numbers nearest to 10**first, 10**(first + 1/2), ..., 10**last
    times = [Fraction(round(10 ** (k / 2))) for k in range(2 * first, 2 * last + 1)]
    tops = [top for top in TOPS if only(f"{top} growth", *FAR)]
    scenes = [random_scene(top, k, times) for top in tops for k in range(starts)]
    members = kit.rows_by_part({"growth": (follow, scenes)}, quick, say)["growth"]
    own = [slice(k * starts, (k + 1) * starts) for k in range(len(tops))]
    return {
        "brouwer": BROUWER,
        "tops": [_top_row(top, scenes[k], members[k]) for top, k in zip(tops, own, strict=True)],
        "at": far_rows(end, starts, quick, say, only),
    }


def follow(scene: polhode.Scene) -> Member:
    """Integrate one start by both methods and judge it at every time."""
    true = polhode.reference(scene).at(scene.times, DIGITS)
    plain, projected = (polhode.integrate(scene, "double", project=x) for x in (False, True))
    projection = projected.projection
    assert projection is not None
    # what rounding the inputs leaves of a run that is projected so often, at the first times
    first = [t for t in scene.times if t <= INPUTS_UNTIL]
    left = polhode.conditioning(scene, first).inputs(DOUBLE, projection.every)
    departed = polhode.departures(scene, plain.states)
    errors = (polhode.state_errors(run.states, true, scene).tolist() for run in (plain, projected))
    return Member(
        dict(zip((PLAIN, PROJECTED), errors, strict=True)),
        {name: [*map(float, column)] for name, column in departed.items()},
        projection,
        [10.0**-x for x in left if x is not None],
    )


def _top_row(
    top: str, scenes: Sequence[polhode.Scene], members: Sequence[Member]
) -> dict[str, Any]:
    """Of one kind: medians over its starts at every half decade, and exponents."""
    first, shown = scenes[0], [float(t) for t in scenes[0].times]
    since = min(FIT_SINCE, shown[-1] / 100)
    corrections = [m.projection for m in members if m.projection is not None]
    plain, projected = ([m.errors[method] for m in members] for method in (PLAIN, PROJECTED))
    methods = [
        {
            "method": PLAIN,
            "error": _growth(shown, plain, since, BROUWER["error"]),
            "drift": _growth(shown, [m.drift for m in members], since, BROUWER["drift"]),
            "integrals": _integrals(shown, members, since),
        },
        {
            "method": PROJECTED,
            "error": _growth(shown, projected, since, LINEAR),
            "projection": {
                "onto": sorted({name for x in corrections for name in x.onto}),
                "largest": significant(max(x.largest for x in corrections), 3),
                "sum": significant(max(x.sum for x in corrections), 3),
            },
            "inputs": _beside_inputs(members),
        },
    ]
    limit = significant(float(polhode.reference(first).error(first.times[-1:], DIGITS)), 3)
    least = min(np.median(errors, axis=0).min() for errors in (plain, projected))
    return {
        "top": top,
        "starts": len(members),
        "times": [int(t) for t in shown],
        "fitted_since": since,
        "reference_error": limit,
        "wall": bool(limit > least / 10),
        "methods": methods,
    }


#: A row of numbers a member; numpy's functions of it, by their names.
Series: TypeAlias = Sequence[Sequence[float]]
Functions: TypeAlias = Mapping[str, Callable[..., Any]]
#: What is told of an ensemble's errors or drifts, and of departures with their signs.
SIZES: Functions = {"median": np.median, "largest": np.max}
SIGNED: Functions = {"mean": np.mean, "deviation": partial(np.std, ddof=1)}


def _growth(
    times: Sequence[float], series: Series, since: float, law: float, shown: Functions = SIZES
) -> dict[str, Any]:
    """How an ensemble's errors or departures grow; ``law``: the exponent that is expected."""
    return {
        **{name: _short(number(series, axis=0)) for name, number in shown.items()},
        **exponent(times, series, since, np.median if shown is SIZES else np.std),
        "law": law,
    }


def _short(values: Any) -> list[float]:
    """Numbers as they are kept in files."""
    return [significant(float(x), 3) for x in values]


def _integrals(
    times: Sequence[float], members: Sequence[Member], since: float
) -> list[dict[str, Any]]:
    """Each integral's departure over the ensemble: mean beside standard deviation."""
    series = {name: [m.departures[name] for m in members] for name in members[0].departures}
    return [
        {"integral": name, **_growth(times, rows, since, BROUWER["drift"], SIGNED)}
        for name, rows in series.items()
    ]


def _beside_inputs(members: Sequence[Member]) -> dict[str, Any]:
    """What rounding the inputs leaves of projected runs, and their errors over it, at first.

    Medians over the ensemble.
    """
    alone = np.array([m.inputs for m in members])
    errors = np.array([m.errors[PROJECTED][: alone.shape[1]] for m in members])
    medians = (_short(np.median(x, axis=0)) for x in (alone, errors / alone))
    return dict(zip(("median", "error_over_it"), medians, strict=True))


# --- growth ---------------------------------------------------------------------------------------
#
# Growth of an ensemble's errors with time: medians, mean and spread, the exponent of a power law.
#
# The exponent is the slope of log10 of the ensemble's median (or standard deviation) over log10
# t, by least squares, every time weighted by the inverse variance of its median; variances and
# the exponent's uncertainty come from the same bootstrap over whole members, since the times of
# one member are not independent. Efron & Tibshirani, An Introduction to the Bootstrap, 1993.


RESAMPLES = 400


#: A fitted exponent and that of the last decade alone, each with its standard error.
EXPONENTS = ("exponent", "uncertainty", "last_decade", "last_uncertainty")


def exponent(
    times: Sequence[float], members: Series, since: float, middle_of: Callable[..., Any] = np.median
) -> dict[str, float | None]:
    """The exponents of the median's growth from ``since`` on; None where it is zero somewhere.

    ``middle_of``: numpy's function that grows.
    """
    late = np.array(times) >= since
    x, y = np.log10(np.array(times))[late], np.array(members)[:, late]
    if late.sum() < 3 or (middle_of(y, axis=0) <= 0).any():
        return dict.fromkeys(EXPONENTS)
    drawn = np.random.default_rng(1).integers(0, len(y), (RESAMPLES, len(y)))
    samples = np.log10(np.maximum(middle_of(y[drawn], axis=1), np.finfo(float).tiny))
    weights = 1 / np.sqrt(np.maximum(samples.var(axis=0), 1e-6))
    lines = np.vstack([np.log10(middle_of(y, axis=0)), samples]).T
    fitted: list[float] = []
    for part in (np.full(len(x), True), x >= x[-1] - 1 - 1e-9):  # the last decade
        slope, *others = np.polyfit(x[part], lines[part], 1, w=weights[part])[0].tolist()
        fitted += [slope, float(np.std(others, ddof=1))]
    return dict(zip(EXPONENTS, (round(x, 3) for x in fitted), strict=True))


# --- late time ------------------------------------------------------------------------------------
#
# Other programs on the same random starts, each at its tightest tolerance, to one far moment.


_LIMIT = 600.0  # seconds of a start, at most
#: The programs and their tolerances, the longest first.
TOLERANCES = {
    "CyRK DOP853": 3e-15,
    "CyRK VERN8": 3e-15,
    "splitting 8 compensated": 1e-8,
    ENGINE: EPS,
}
#: Run from all starts; the others, up to 8 seconds each and no close call, from the first half.
CHEAP = (ENGINE,)
NOT_RUN = {
    "CyRK LSODA, diffrax Dopri8, splitting 4": "minutes a top",
    "SciPy DOP853, SciPy LSODA": "minutes a start: Python calls their right-hand sides",
    "mpmath odefun": "hours: a Taylor method in Python",
}


def far_rows(end: int, starts: int, quick: bool, say: kit.Say, only: kit.Only) -> dict[str, Any]:
    """For each kind of top the errors of every other program at ``end``, over the starts."""
    runs = [
        (top, name, starts if name in CHEAP else starts // 2)
        for name in (CHEAP if quick else TOLERANCES)
        for top in [*TOPS][: 1 if quick else None]
        if only(f"{top} t={end}", name, "far")
    ]
    rows = kit.rows_by_part({"far": (partial(_row, end=end), runs)}, quick, say)["far"]
    methods = kit.groups((top, row) for (top, *_), row in zip(runs, rows, strict=True))
    tops = [{"top": top, "methods": own} for top, own in methods.items()]
    return {"t": end, "starts": starts, "tops": tops, "not_run": NOT_RUN}


def _row(of: tuple[str, str, int], end: int) -> dict[str, Any]:
    """A program on the first starts of a kind of top: median and largest error over those that
    came back, and why others did not."""
    top, program, starts = of
    scenes = [draw(top, k, end, 2) for k in range(starts)]
    job = BY_NAME[program].job(present(top), [x.run(TOLERANCES[program]) for x in scenes])
    answers, fault = ask(job, starts * _LIMIT)
    pairs = zip(scenes, answers, strict=False)
    errors = [_error(start.scene, answer["state"]) for start, answer in pairs if "state" in answer]
    faults = [fault] * (len(answers) < starts) + [x["failed"] for x in answers if "failed" in x]
    return {
        "method": program,
        "tol": TOLERANCES[program],
        "starts": starts,
        "reached": len(errors),
        "median": significant(statistics.median(errors), 3) if errors else None,
        "largest": significant(max(errors), 3) if errors else None,
        "faults": [*dict.fromkeys(faults)],
    }


def _error(scene: polhode.Scene, state: Sequence[float]) -> float:
    """Of the last state, against the closed form."""
    true = polhode.reference(scene).at(scene.times, DIGITS)
    rows: list[Any] = [*true[:-1], state]
    return float(polhode.state_errors(rows, true, scene)[-1])


# --- page -----------------------------------------------------------------------------------------
#
# Rows of the tables and facts of the long-run study's page.


def tables(results: kit.JsonObject) -> dict[str, Iterable[kit.JsonObject]]:
    """The rows of the page's tables from the study's JSON object."""
    rows, far = kit.inner_rows(results["tops"], "methods"), results["at"]
    growth = [at_time for row in rows for at_time in _over_time(row)]
    own = [
        {**x, "method": f"polhode {x['method']}", **x["error"]}
        for x in growth
        if x["t"] == far["t"]
    ]
    others = kit.inner_rows(far["tops"], "methods")
    return {
        "exponents": [
            {**row, **row[name], "of": name}
            for row in rows
            for name in ("error", "drift")
            if name in row and row[name]["exponent"] is not None
        ],
        "walks": _walks(rows),
        "growth": growth,
        "projection": [row for row in rows if "projection" in row],
        "far": sorted([*own, *others], key=lambda row: [*TOPS].index(row["top"])),
        "faults": _faults(others, far["not_run"]),
    }


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    tops, far = results["tops"], results["at"]
    pulls = [abs(row["pull"]) for row in _walks(kit.inner_rows(tops, "methods"))]
    return {
        "starts": far["starts"],
        "end": tops[0]["times"][-1] if tops else kit.DASH,
        "since": f"{tops[0]['fitted_since']:g}" if tops else kit.DASH,
        "means": len(pulls),
        "pull": max(pulls, default=0),
        "reference_error": max((top["reference_error"] for top in tops), default=0),
        "walls": sum(top["wall"] for top in tops),
        "followed": INPUTS_UNTIL,
        "far_end": far["t"],
    }


def _walks(rows: list[kit.JsonObject]) -> Iterator[kit.JsonObject]:
    """Every integral of every kind of top: its departure at the end, the mean over its error."""
    for row in kit.inner_rows(rows, "integrals"):
        error = row["deviation"][-1] / math.sqrt(row["starts"])
        pull = row["mean"][-1] / error if error else 0.0
        yield {**row, "mean_error": error, "pull": pull}


def _over_time(row: kit.JsonObject) -> Iterator[kit.JsonObject]:
    """A method on a kind of top at each time: error, drift, and what its inputs leave.

    That goes on like t where it was not followed.
    """
    followed = row.get("inputs", {}).get("median", [])
    for k, t in enumerate(row["times"]):
        sizes: kit.JsonObject = {
            name: {size: row[name][size][k] for size in SIZES}
            for name in ("error", "drift")
            if name in row
        }
        if followed[k:]:
            left, over = followed[k], row["inputs"]["error_over_it"][k]
            sizes["inputs"] = {"median": left, "over": over}
        elif followed:
            left = followed[-1] * t / row["times"][len(followed) - 1]
            sizes["inputs"] = {"median": left, "over": row["error"]["median"][k] / left}
        yield {**row, "t": t, **sizes}


def _faults(rows: list[kit.JsonObject], not_run: dict[str, str]) -> list[kit.JsonObject]:
    """Runs at the far moment that failed, and programs that were not run."""
    failed = [{**row, "fault": fault} for row in rows for fault in row["faults"]]
    return failed + [{"method": k, "fault": f"not run: {why}"} for k, why in not_run.items()]


# --- figure ---------------------------------------------------------------------------------------
#
# Figure of the study long-run: growth of error and drift with time, beside the laws for them.


_MARKS = {"euler": "o", "lagrange": "s", "kovalevskaya": "D"}
_COLOURS = dict(zip(_MARKS, kit.SERIES, strict=False))
_SLOPES = {"error": (1.5, "slope 3/2"), "drift": (0.5, "slope 1/2")}
_DOTTED: dict[str, Any] = {"color": kit.GUIDE, "ls": ":", "lw": 0.8}


def svgs(results: kit.JsonObject) -> dict[str, str]:
    """Medians over the ensembles against time, and above each what the worst start has."""
    tops = results["tops"]
    growth = f"median of {tops[0]['starts']} starts, bar to the worst"

    def draw(*panels: kit.Axes) -> None:
        for axes, name in zip(panels, _SLOPES, strict=True):
            _draw_growth(axes, tops, name)
            if name == "error":
                _draw_inputs(axes, tops)
            axes.set(xscale="log", yscale="log", ylabel=name)
            axes.set_title(f"{name.capitalize()}: {growth}", size=9, loc="left")
            kit.plain(axes)
        panels[-1].set(xlabel="t (units of the scene)")

    return {"long-run": kit.drawn(draw, 6.6, names=2, nrows=2, sharex=True)}


def _draw_growth(axes: kit.Axes, tops: Sequence[kit.JsonObject], name: str) -> None:
    """Medians of error or drift, and Brouwer's slope above the first that is not projected."""
    for top in tops:
        for method in top["methods"]:
            if name in method:
                put_back = "projected" if "projected" in method["method"] else "not projected"
                row, look = method[name], kit.LOOKS[method["method"]]
                look = look | {"marker": _MARKS[top["top"]], "color": _COLOURS[top["top"]]}
                axes.plot(top["times"], row["median"], label=f"{top['top']}, {put_back}", **look)
                bars = {"color": look["color"], "lw": 2, "alpha": 0.3}
                axes.vlines(top["times"], row["median"], row["largest"], **bars)
    times, (slope, label) = tops[0]["times"], _SLOPES[name]
    since = next(k for k, t in enumerate(times) if t >= tops[0]["fitted_since"])
    height = 3 * tops[0]["methods"][0][name]["median"][since]
    line = (times[since], height), (times[-1], height * (times[-1] / times[since]) ** slope)
    axes.plot(*zip(*line, strict=True), **_DOTTED)
    x, y = ((first * last) ** 0.5 for first, last in zip(*line, strict=True))
    axes.annotate(label, (x, y), (-3, 3), textcoords="offset points", ha="right", size=8)


def _draw_inputs(axes: kit.Axes, tops: list[kit.JsonObject]) -> None:
    """What rounding the inputs leaves of projected runs, followed at first, then like t."""
    for row in kit.inner_rows(tops, "methods"):
        points = [(x["t"], x["inputs"]["median"]) for x in _over_time(row) if "inputs" in x]
        look = _DOTTED | {"ls": "--", "marker": _MARKS[row["top"]], "ms": 2.5}
        axes.plot(*np.array(points or [(np.nan,) * 2]).T, label="rounded inputs", **look)
