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
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import kit
import polhode
from peers import process
from peers.process import ask
from programs import BY_NAME, ENGINE, EPS
from tops import TOPS, draw, present, random_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
    def scene(self) -> polhode.Scene:
        """The exact scene."""
        return random_scene(self.top, self.index, self.times)


def rows(quick: bool, say: kit.Say, only: kit.Only) -> dict[str, Any]:
    """The study's rows; no figure in them depends on the clock."""
    tops = [*ensembles((2, 4) if quick else (2, 6), STARTS, say, only)]
    end = 10_000 if quick else 100_000
    return {
        "brouwer": BROUWER,
        "tops": tops,
        "at": far_rows(end, STARTS, quick, say, only),
    }


def ensembles(
    decades: tuple[int, int], starts: int, say: kit.Say, only: kit.Only, workers: int = 2
) -> Iterator[dict[str, Any]]:
    """One row per top: medians over its starts at every half decade, and exponents."""
    times = half_decades(*decades)
    methods = (PLAIN, PROJECTED)
    tops = [top for top in TOPS if only(f"{top} growth", *FAR)]
    starts_of = [RunStart(top, k, times, methods) for top in tops for k in range(starts)]
    members: list[Member] = []

    def tell(start: RunStart) -> None:
        say(f"{start.scene.name} of {starts}")

    for start, member in zip(
        starts_of, kit.in_order(follow, starts_of, workers, tell), strict=True
    ):
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
    reference = polhode.reference(scene).at(scene.times, DIGITS)
    errors, strayed, projection, left = {}, {}, None, []
    for method in start.methods:
        run = polhode.integrate(scene, "double", project=method == PROJECTED)
        errors[method] = polhode.state_errors(run.states, reference, scene).tolist()
        if method == PROJECTED:
            corrections = run.projection
            assert corrections is not None
            projection = corrections.onto, corrections.largest, corrections.sum
            left = _inputs(scene, corrections.every)
        else:
            departed = polhode.departures(scene, run.states)
            strayed = {name: [float(x) for x in column] for name, column in departed.items()}
    return Member(errors, strayed, projection, left)


def _inputs(scene: polhode.Scene, every: int) -> list[float]:
    """What rounding the inputs leaves of a run that is projected so often, at the first times."""
    first = [t for t in scene.times if t <= INPUTS_UNTIL]
    digits = polhode.conditioning(scene, first).inputs(kit.DOUBLE, every)
    return [10.0**-x for x in digits if x is not None]


def _top_row(top: str, times: Sequence[Fraction], members: Sequence[Member]) -> dict[str, Any]:
    first = RunStart(top, 0, tuple(times), ()).scene
    shown = [float(t) for t in times]
    since = min(FIT_SINCE, shown[-1] / 100)
    methods = []
    for method in members[0].errors:
        row: dict[str, Any] = {"method": method}
        for name, series in (
            ("error", [m.errors[method] for m in members]),
            ("drift", [m.drift for m in members] if method == PLAIN else []),
        ):
            if series:
                row[name] = {
                    "median": _short(np.median(series, axis=0)),
                    "largest": _short(np.max(series, axis=0)),
                    **_exponents(exponent(shown, series, since)),
                    "law": LINEAR if method == PROJECTED else BROUWER[name],
                }
        if method == PLAIN:
            row["integrals"] = _integrals(shown, members, since)
        if method == PROJECTED:
            onto, largest, total = zip(
                *(m.projection for m in members if m.projection), strict=True
            )
            row["projection"] = {
                "onto": sorted({name for names in onto for name in names}),
                "largest": kit.significant(max(largest), 3),
                "sum": kit.significant(max(total), 3),
            }
            row["inputs"] = _beside_inputs(members)
        methods.append(row)
    reference = polhode.reference(first)
    assert isinstance(reference, polhode.Reference)
    limit = kit.significant(float(reference.error(first.times[-1:], DIGITS)), 3)
    least = min(x for row in methods for x in row["error"]["median"])
    return {
        "top": top,
        "starts": len(members),
        "times": [int(t) for t in times],
        "fitted_since": since,
        "reference_error": limit,
        "wall": limit > least / 10,
        "methods": methods,
    }


def _short(values: Any) -> list[float]:
    """Numbers as they are kept in files."""
    return [kit.significant(float(x), 3) for x in values]


def _exponents(fitted: Exponent | None) -> dict[str, float | None]:
    """An exponent and that of the last decade, each with its standard error; None of nothing."""
    if fitted is None:
        return dict.fromkeys(Exponent._fields)
    return {name: round(x, 3) for name, x in fitted._asdict().items()}


def _integrals(
    times: Sequence[float], members: Sequence[Member], since: float
) -> list[dict[str, Any]]:
    """Each integral's departure over the ensemble: mean beside standard deviation."""
    integrals = []
    for name in members[0].departures:
        series = [m.departures[name] for m in members]
        fitted = exponent(times, series, since, np.std)
        integrals.append(
            {
                "integral": name,
                "mean": _short(np.mean(series, axis=0)),
                "deviation": _short(np.std(series, axis=0, ddof=1)),
                **_exponents(fitted),
                "law": BROUWER["drift"],
            }
        )
    return integrals


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


# --- growth ---------------------------------------------------------------------------------------
#
# Growth of an ensemble's errors with time: medians, mean and spread, the exponent of a power law.
#
# The exponent is the slope of log10 of the ensemble's median (or standard deviation) over log10
# t, by least squares, every time weighted by the inverse variance of its median; variances and
# the exponent's uncertainty come from the same bootstrap over whole members, since the times of
# one member are not independent. Efron & Tibshirani, An Introduction to the Bootstrap, 1993.


RESAMPLES = 400


class Exponent(NamedTuple):
    """A fitted exponent and that of the last decade alone, each with its standard error."""

    exponent: float
    uncertainty: float
    last_decade: float
    last_uncertainty: float


def exponent(
    times: Sequence[float],
    members: Sequence[Sequence[float]],
    since: float,
    middle_of: Callable[..., Any] = np.median,
) -> Exponent | None:
    """The exponent of the median's growth from ``since`` on; None where it is zero somewhere.

    ``members``: one row of errors a member.  ``middle_of``: numpy's function that grows.
    """
    late = np.array(times) >= since
    x, y = np.log10(np.array(times))[late], np.array(members)[:, late]
    if late.sum() < 3 or (middle_of(y, axis=0) <= 0).any():
        return None
    drawn = np.random.default_rng(1).integers(0, len(y), (RESAMPLES, len(y)))
    samples = np.log10(np.maximum(middle_of(y[drawn], axis=1), np.finfo(float).tiny))
    weights = 1 / np.maximum(samples.var(axis=0), 1e-6)
    middle = np.log10(middle_of(y, axis=0))
    last = x >= x[-1] - 1 - 1e-9
    slopes_of = []
    for part in (slice(None), last):
        slopes = [_slope(x[part], sample[part], weights[part]) for sample in samples]
        slopes_of += [_slope(x[part], middle[part], weights[part]), float(np.std(slopes, ddof=1))]
    return Exponent(*slopes_of)


def _slope(x: Any, y: Any, weights: Any) -> float:
    """The slope of a weighted line through the points."""
    centre = (weights * x).sum() / weights.sum()
    return float((weights * (x - centre) * y).sum() / (weights * (x - centre) ** 2).sum())


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


class Asked(NamedTuple):
    """A program on the first starts of a kind of top."""

    top: str
    program: str
    starts: int


def far_rows(end: int, starts: int, quick: bool, say: kit.Say, only: kit.Only) -> dict[str, Any]:
    """For each kind of top the errors of every other program at ``end``, over the starts."""
    contests = [
        Asked(top, name, starts if name in CHEAP else starts // 2)
        for name in (CHEAP if quick else TOLERANCES)
        for top in TOPS
        if only(f"{top} t={end}", name, "far")
    ]

    def row(task: Asked) -> dict[str, Any]:
        say(f"{task.top}, {task.program}")
        return _row(task, end)

    with ThreadPoolExecutor(2) as two:  # no clock is read here
        answers = [*two.map(row, contests)]
    tops = [
        {
            "top": top,
            "methods": [x for task, x in zip(contests, answers, strict=True) if task.top == top],
        }
        for top in TOPS
        if any(task.top == top for task in contests)
    ]
    return {"t": end, "starts": starts, "tops": tops, "not_run": NOT_RUN}


def _row(task: Asked, end: int) -> dict[str, Any]:
    """Median and largest error over the starts that came back, and why others did not."""
    tol = TOLERANCES[task.program]
    scenes = [draw(task.top, k, end, 2) for k in range(task.starts)]
    job = BY_NAME[task.program].job(present(task.top), [x.run(tol) for x in scenes])
    with tempfile.TemporaryDirectory() as cache:
        answers, fault = ask(process.__name__, job, task.starts * _LIMIT, Path(cache))
    errors, faults = [], [fault] * (len(answers) < task.starts)
    for start, answer in zip(scenes, answers, strict=False):
        if "failed" in answer:
            faults.append(answer["failed"])
        else:
            errors.append(_error(start.scene, answer["state"]))
    return {
        "method": task.program,
        "tol": tol,
        "starts": task.starts,
        "reached": len(errors),
        "median": kit.significant(statistics.median(errors), 3) if errors else None,
        "largest": kit.significant(max(errors), 3) if errors else None,
        "faults": [*dict.fromkeys(faults)],
    }


def _error(scene: polhode.Scene, state: Sequence[float]) -> float:
    """Of the last state, against the closed form."""
    true = polhode.reference(scene).at(scene.times, DIGITS)
    rows: list[Any] = [*true[:-1], state]
    return float(polhode.state_errors(rows, true, scene)[-1])


# --- page -----------------------------------------------------------------------------------------
#
# Tables and facts of the long-run study's page.


_AGAIN = "python reports/make.py long-run --only '{0} growth'"
_SPREAD = "median / largest of the ensemble"
_LEFT = "the error that the rounded inputs leave, and × the run's own error over it"

_TOP = kit.Column("top", "top")
_METHOD = kit.Column("method", "method")
_LAW = kit.Column("law", "law", "g", "the exponent of the law above")
_LAST_DECADE = kit.Column(
    "last decade alone", lambda row: _fitted(row, "last_decade"), ">", "fitted to the last decade"
)
_EXPONENTS = (
    _TOP,
    _METHOD,
    kit.Column("of", "of"),
    kit.Column("exponent", lambda row: _fitted(row, "exponent"), ">", "of t, ± its standard error"),
    _LAST_DECADE,
    _LAW,
)
_PROJECTION = (
    _TOP,
    kit.Column(
        "onto",
        lambda row: _squared(", ".join(row["projection"]["onto"])),
        meaning="integrals that were kept",
    ),
    kit.Column("largest", "projection.largest", ".1e", "the largest correction of the state"),
    kit.Column("sum", "projection.sum", ".1e", "the largest sum of a run's corrections"),
)
_WALKS = (
    _TOP,
    kit.Column("integral", lambda row: _squared(row["integral"])),
    kit.Column(
        "mean at the end",
        lambda row: f"{row['mean'][-1]:+.1e} ± {_standard_error(row):.1e}",
        *(">", "of the integral's departure over the ensemble, ± its standard error"),
    ),
    kit.Column("standard deviation", lambda row: row["deviation"][-1], ".1e"),
    kit.Column(
        "mean / its error", lambda row: _pull(row), "+.1f", "the mean in its own standard errors"
    ),
    kit.Column("exponent of the deviation", lambda row: _fitted(row, "exponent"), ">"),
    _LAST_DECADE,
    _LAW,
)
_FAULTS = (
    _METHOD,
    kit.Column("top", "top", "", "a dash: every kind of top"),
    kit.Column("why it is missing or failed", "fault"),
)


def tables(results: kit.JsonObject) -> dict[str, kit.PageTable]:
    """The page's tables from the study's JSON object."""
    tops = results["tops"]
    rows, times = _methods(tops), tops[0]["times"] if tops else []
    projected = [row for row in rows if "inputs" in row]
    followed = times[: len(projected[0]["inputs"]["median"])] if projected else []
    inputs = (
        _TOP,
        *kit.at_times(followed, _over_inputs, _LEFT),
        kit.Column("last, like t", _like_t, ">"),
    )
    return {
        "exponents": kit.table(_exponent_rows(rows), _EXPONENTS, _AGAIN),
        "walks": kit.table(_integral_rows(rows), _WALKS, _AGAIN),
        "inputs": kit.table(projected, inputs, _AGAIN),
        "error": _growth_table(rows, times, "error"),
        "drift": _growth_table(rows, times, "drift"),
        "projection": kit.table([row for row in rows if "projection" in row], _PROJECTION, _AGAIN),
        "far": far_table(results),
        "faults": kit.table(_faults(results["at"]), _FAULTS),
    }


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    tops, far = results["tops"], results["at"]
    pulls = [abs(_pull(row)) for row in _integral_rows(_methods(tops))]
    return {
        "starts": far["starts"],
        "end": tops[0]["times"][-1] if tops else kit.DASH,
        "since": f"{tops[0]['fitted_since']:g}" if tops else kit.DASH,
        "means": len(pulls),
        "pull": max(pulls, default=0),
        "reference_error": max((top["reference_error"] for top in tops), default=0),
        "walls": sum(top["wall"] for top in tops),
        "far_end": far["t"],
    }


def _methods(tops: list[kit.JsonObject]) -> list[kit.JsonObject]:
    """Every method on every kind of top, each with what is said of the top."""
    return [{**top, **method} for top in tops for method in top["methods"]]


def _exponent_rows(rows: list[kit.JsonObject]) -> list[kit.JsonObject]:
    """What grew by each method on each kind of top, of which an exponent was found."""
    return [
        {**row, **row[name], "of": name}
        for row in rows
        for name in ("error", "drift")
        if row.get(name) is not None and row[name]["exponent"] is not None
    ]


def _fitted(row: kit.JsonObject, name: str) -> str | None:
    """An exponent, or that of the last decade, with its standard error."""
    if row["exponent"] is None:
        return None
    if row["exponent"] == row["uncertainty"] == 0:  # such as the spin of a Lagrange top
        return "stays"
    error = {"exponent": "uncertainty", "last_decade": "last_uncertainty"}[name]
    return f"{row[name]:.2f} ± {row[error]:.2f}"


def _integral_rows(rows: list[kit.JsonObject]) -> list[kit.JsonObject]:
    """Every integral of every kind of top."""
    return [{**row, **integral} for row in rows for integral in row.get("integrals", ())]


def _squared(names: str) -> str:
    return names.replace("^2", "²")


def _standard_error(row: kit.JsonObject) -> float:
    standard_error: float = row["deviation"][-1] / math.sqrt(row["starts"])
    return standard_error


def _pull(row: kit.JsonObject) -> float:
    error = _standard_error(row)
    return 0.0 if error == 0 else row["mean"][-1] / error


def _over_inputs(row: kit.JsonObject, k: int) -> str:
    """What rounding the inputs leaves at a time, and the run's error over it."""
    return f"{row['inputs']['median'][k]:.1e}; ×{row['inputs']['error_over_it'][k]:.3g}"


def _like_t(row: kit.JsonObject) -> str:
    """The same at the last time, where it went on like t."""
    alone, times = row["inputs"]["median"], row["times"]
    grown = alone[-1] * times[-1] / times[len(alone) - 1]
    return f"{grown:.1e}; ×{row['error']['median'][-1] / grown:.3g}"


def _growth_table(rows: list[kit.JsonObject], times: list[int], name: str) -> kit.PageTable:
    """Median and largest error, or drift, at each time."""
    columns = kit.at_times(times, lambda row, k: _middle_and_most(row[name], k), _SPREAD)
    return kit.table([row for row in rows if name in row], (_TOP, _METHOD, *columns), _AGAIN)


def _middle_and_most(row: kit.JsonObject, k: int) -> str:
    return f"{kit.formatted(row['median'][k], '.1e')} / {kit.formatted(row['largest'][k], '.1e')}"


def _faults(far: kit.JsonObject) -> list[kit.JsonObject]:
    """Runs at the far moment that failed, and programs that were not run."""
    failed = [{**row, "fault": fault} for row in _methods(far["tops"]) for fault in row["faults"]]
    return failed + [{"method": k, "fault": f"not run: {why}"} for k, why in far["not_run"].items()]


def far_table(results: kit.JsonObject) -> kit.PageTable:
    """Median and largest error of every method at the far moment, one column per kind of top."""
    far = results["at"]
    rows: dict[str, kit.JsonObject] = {}
    for method in _methods(results["tops"]):
        name = "polhode" if "projected" in method["method"] else "polhode, not projected"
        cell = _middle_and_most(method["error"], method["times"].index(far["t"]))
        rows.setdefault(name, {})[method["top"]] = cell
    rows = dict(sorted(rows.items()))
    for method in _methods(far["tops"]):
        cell = (
            f"{kit.formatted(method['median'], '.1e')} / {kit.formatted(method['largest'], '.1e')}"
        )
        if method["reached"] == 0:
            cell = "failed"
        elif method.get("starts", far["starts"]) < far["starts"]:
            cell += f", {method['starts']} starts"
        rows.setdefault(method["method"], {})[method["top"]] = cell
    tops = dict.fromkeys(top["top"] for top in (*results["tops"], *far["tops"]))
    return kit.table(
        [{"method": name, **cells} for name, cells in rows.items()],
        (_METHOD, *(kit.Column(top, top, ">") for top in tops)),
        "python reports/make.py long-run --only far --only '{0}'",
    )


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
    with polhode.paper() as plt:
        size = kit.WIDTH, 9.4
        figure, panels = plt.subplots(3, figsize=size, layout="constrained", sharex=True)
        for axes, name in zip(panels, ("error", "drift"), strict=False):
            _draw_growth(axes, tops, name)
            axes.set(ylabel=name)
            axes.set_title(f"{name.capitalize()}: {growth}", size=9, loc="left")
        _draw_inputs(panels[0], tops)
        _draw_walks(panels[2], tops)
        panels[2].set(ylabel="departure of h", xlabel="t (units of the scene)")
        walks = "Energy, not projected: deviation (filled), |mean| (open)"
        panels[2].set_title(walks, size=9, loc="left")
        for axes in panels:
            axes.set(xscale="log", yscale="log")
            kit.plain(axes)
        kit.legend(figure, 2)
        return {"long-run": kit.as_svg(figure)}


def _draw_growth(axes: Axes, tops: Sequence[kit.JsonObject], name: str) -> None:
    """Medians of error or drift, and Brouwer's slope above the first that is not projected."""
    for top in tops:
        for method in top["methods"]:
            if name in method:
                put_back = "projected" if "projected" in method["method"] else "not projected"
                row, look = method[name], _look(top, method["method"])
                axes.plot(top["times"], row["median"], label=f"{top['top']}, {put_back}", **look)
                bars = {"color": look["color"], "lw": 2, "alpha": 0.3}
                axes.vlines(top["times"], row["median"], row["largest"], **bars)
    times, (slope, label) = tops[0]["times"], _SLOPES[name]
    since = next(k for k, t in enumerate(times) if t >= tops[0]["fitted_since"])
    height = 3 * tops[0]["methods"][0][name]["median"][since]
    steep = height, height * (times[-1] / times[since]) ** slope
    _note(axes, (times[since], times[-1]), steep, label)


def _draw_inputs(axes: Axes, tops: Sequence[kit.JsonObject]) -> None:
    """What rounding the inputs leaves of projected runs, as far as it was followed, then like t."""
    for top in tops:
        for method in top["methods"]:
            if "inputs" in method:
                middle, last = method["inputs"]["median"], top["times"][-1]
                times = top["times"][: len(middle)]
                look = _DOTTED | {"ls": "--", "marker": _MARKS[top["top"]], "ms": 2.5}
                axes.plot(times, middle, label="rounded inputs", **look)
                ends = middle[-1], middle[-1] * last / times[-1]
                axes.plot((times[-1], last), ends, **_DOTTED)


def _draw_walks(axes: Axes, tops: Sequence[kit.JsonObject]) -> None:
    """The departure of h in runs that are not projected: standard deviation, size of the mean."""
    lowest = []
    for top in tops:
        for row in top["methods"][0]["integrals"]:
            if row["integral"] == "h":
                look = _look(top, "double") | {"lw": 0.8}
                axes.plot(top["times"], row["deviation"], **look)
                means = look | {"ls": "none", "ms": 5, "mfc": "none"}
                axes.plot(top["times"], [abs(x) for x in row["mean"]], **means)
                lowest.append(row["deviation"][-1])
    if lowest:
        low, high = tops[0]["fitted_since"], tops[0]["times"][-1]
        height = min(lowest) / 6
        _note(axes, (low, high), (height * (low / high) ** 0.5, height), "slope 1/2")


def _note(axes: Axes, x: tuple[float, float], y: tuple[float, float], text: str) -> None:
    """A dotted line and its name at its middle."""
    axes.plot(x, y, **_DOTTED)
    middle = (x[0] * x[1]) ** 0.5, (y[0] * y[1]) ** 0.5
    axes.annotate(text, middle, (-3, 3), textcoords="offset points", ha="right", size=8)


def _look(top: kit.JsonObject, method: str) -> dict[str, Any]:
    """A top's mark and colour, a method's line."""
    return kit.LOOKS[method] | {"marker": _MARKS[top["top"]], "color": _COLOURS[top["top"]]}
