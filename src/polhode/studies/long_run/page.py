"""Page of the study long-run."""

from __future__ import annotations

import math
from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text
from polhode.studies.page.columns import Column, at_times, table
from polhode.studies.page.words import formatted

TITLE = "Long runs: growth of error and drift"
_AGAIN = "polhode study long-run --only '{0} growth'"
_SPREAD = "median / largest of the ensemble"
_LEFT = "the error that the rounded inputs leave, and × the run's own error over it"

_TOP = Column("top", "top")
_METHOD = Column("method", "method")
_LAW = Column("law", "law", "g", "the exponent of the law above")
_LAST_DECADE = Column(
    "last decade alone", lambda row: _fitted(row, "last_decade"), ">", "fitted to the last decade"
)
_EXPONENTS = (
    _TOP,
    _METHOD,
    Column("of", "of"),
    Column("exponent", lambda row: _fitted(row, "exponent"), ">", "of t, ± its standard error"),
    _LAST_DECADE,
    _LAW,
)
_PROJECTION = (
    _TOP,
    Column(
        "onto",
        lambda row: _squared(", ".join(row["projection"]["onto"])),
        meaning="integrals that were kept",
    ),
    Column("largest", "projection.largest", ".1e", "the largest correction of the state"),
    Column("sum", "projection.sum", ".1e", "the largest sum of a run's corrections"),
)


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    tops = found["tops"]
    if not tops:
        yield from _far(found)
        return
    yield Text(
        f"{tops[0]['starts']} random bodies of each kind, each with a random start and all numbers "
        f"decimals of two places, are integrated to t = {tops[0]['times'][-1]} in double at the "
        "tolerance eps, and judged against their closed forms at each time. Error: the larger of "
        "the error of w, over the largest |w|, and the error of gamma. Drift: the largest "
        "relative departure of h, f, |gamma|² and the fourth integral from the values of the "
        "exact scene, in runs that are not projected. Exponents are slopes of the median of the "
        f"ensemble in log–log from t = {tops[0]['fitted_since']:g} on, by weighted least squares; "
        "their uncertainty is the standard error of a bootstrap over the bodies."
    )
    yield Figure(
        "long-run",
        "Growth of error and drift with time. A bar leads from the median to the worst start. "
        "Dotted: the slopes of the laws. Dashed grey: what rounding the inputs leaves of "
        "projected runs, as far as it was computed, and from there on proportional to t. Below: "
        "the departure of h, its standard deviation (line) and the size of its mean (open marks).",
    )
    yield Heading("Exponents")
    yield Text(
        "Brouwer's law holds for independent rounding errors: exponent 3/2 for the error, 1/2 for "
        "the drift. Another law holds for projected runs, whose integrals do not drift. Rounded "
        "coefficients shift the frequencies once and for all, which is an error that grows like "
        "t: exponent 1. Before that shows, rounding errors within the level add up like t^1/2."
    )
    yield table(_exponents(tops), _EXPONENTS, _AGAIN)
    yield from _walks(tops)
    yield from _beside_inputs(tops)
    for name, title in (("error", "Error"), ("drift", "Drift")):
        yield Heading(f"{title}: median and largest of the ensemble")
        yield _growth(tops, name)
    yield from _corrections(tops)
    blamed = [top["top"] for top in tops if top["wall"]]
    yield Text(
        "The closed forms' own errors at the last time are "
        + ", ".join(f"{formatted(top['reference_error'], '.1e')} ({top['top']})" for top in tops)
        + (
            f"; those of {', '.join(blamed)} limit the errors above."
            if blamed
            else "; they limit no error above."
        )
    )
    yield from _far(found)


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    if not found["tops"]:
        return ""
    told = []
    for top in found["tops"]:
        plain, projected = (m["error"]["median"][-1] for m in top["methods"])
        told.append(f"{projected:.1e} ({top['top']}; {plain:.1e} without projection)")
    return (
        f"At t = {found['tops'][0]['times'][-1]} the median error of runs in double of random "
        f"bodies is {', '.join(told)} where they are put back on their first integrals."
    )


def _methods(tops: list[JsonObject]) -> list[JsonObject]:
    """Every method on every kind of top, each with what is said of the top."""
    return [{**top, **method} for top in tops for method in top["methods"]]


def _exponents(tops: list[JsonObject]) -> list[JsonObject]:
    """What grew by each method on each kind of top, of which an exponent was found."""
    return [
        {**row, **row[name], "of": name}
        for row in _methods(tops)
        for name in ("error", "drift")
        if row.get(name) is not None and row[name]["exponent"] is not None
    ]


def _fitted(found: JsonObject, name: str) -> str | None:
    """An exponent, or that of the last decade, with its standard error."""
    if found["exponent"] is None:
        return None
    if found["exponent"] == found["uncertainty"] == 0:  # such as the spin of a Lagrange top
        return "stays"
    error = {"exponent": "uncertainty", "last_decade": "last_uncertainty"}[name]
    return f"{found[name]:.2f} ± {found[error]:.2f}"


def _walks(tops: list[JsonObject]) -> Iterator[Block]:
    """Each integral's mean departure beside its standard deviation: bias against random walk."""
    if not _integrals(tops):
        return
    yield Heading("Bias against random walk")
    yield Text(
        "The departure of each integral has a sign. Where rounding errors are independent, its "
        "mean over the ensemble is zero up to chance, and its standard deviation grows like "
        "t^1/2. A bias of one sign moves the mean away from zero by many of its standard errors "
        "(the standard deviation over the root of the number of starts); a bias that differs from "
        f"body to body raises the exponent. {bias(tops)}"
    )
    columns = (
        _TOP,
        Column("integral", lambda row: _squared(row["integral"])),
        Column(
            f"mean at t = {tops[0]['times'][-1]}",
            lambda row: f"{row['mean'][-1]:+.1e} ± {_standard_error(row):.1e}",
            ">",
        ),
        Column("standard deviation", lambda row: row["deviation"][-1], ".1e"),
        Column("mean / its error", _pull, "+.1f", "the mean in its own standard errors"),
        Column("exponent of the deviation", lambda row: _fitted(row, "exponent"), ">"),
        _LAST_DECADE,
        _LAW,
    )
    yield table(_integrals(tops), columns, _AGAIN)


def _integrals(tops: list[JsonObject]) -> list[JsonObject]:
    """Every integral of every kind of top."""
    return [{**row, **one} for row in _methods(tops) for one in row.get("integrals", ())]


def bias(tops: list[JsonObject]) -> str:
    """Which means are off zero, in a sentence; Student's t of 15 is beyond 4 once in a thousand."""
    pulls = {f"{_squared(r['integral'])} ({r['top']})": _pull(r) for r in _integrals(tops)}
    off = [f"{name}, {pull:+.1f} standard errors" for name, pull in pulls.items() if abs(pull) > 4]
    if off:
        return f"A bias is seen in {'; '.join(off)}."
    return (
        f"None of {len(pulls)} means is further from zero than {max(map(abs, pulls.values())):.1f} "
        "standard errors: no bias is seen."
    )


def _squared(names: str) -> str:
    return names.replace("^2", "²")


def _standard_error(row: JsonObject) -> float:
    found: float = row["deviation"][-1] / math.sqrt(row["starts"])
    return found


def _pull(row: JsonObject) -> float:
    error = _standard_error(row)
    return 0.0 if error == 0 else row["mean"][-1] / error


def _beside_inputs(tops: list[JsonObject]) -> Iterator[Block]:
    """Errors of projected runs over what rounding the inputs leaves of them."""
    rows = [method for method in _methods(tops) if "inputs" in method]
    if not rows:
        return
    times, end = tops[0]["times"][: len(rows[0]["inputs"]["median"])], tops[0]["times"][-1]
    yield Heading("Projected runs beside what rounding the inputs leaves")
    yield Text(
        "The error of projected runs if rounding each scene's numbers to double were their only "
        "error, by the variational equations (known differences, not a bound): its median over "
        "the ensemble, and the median of the run's own error over it. It was computed to t = "
        f"{times[-1]}. The last column extrapolates it to t = {end} in proportion to t, and "
        "divides the median error there by that. Where the quotient is near one, the error of a "
        "projected run comes almost only from its inputs."
    )
    columns = (
        _TOP,
        *at_times(times, _over_inputs, _LEFT),
        Column(f"t = {end}, like t", _like_t, ">"),
    )
    yield table(rows, columns, _AGAIN)


def _over_inputs(row: JsonObject, k: int) -> str:
    """What rounding the inputs leaves at a time, and the run's error over it."""
    return f"{row['inputs']['median'][k]:.1e}; ×{row['inputs']['error_over_it'][k]:.3g}"


def _like_t(row: JsonObject) -> str:
    """The same at the last time, where it went on like t."""
    alone, times = row["inputs"]["median"], row["times"]
    grown = alone[-1] * times[-1] / times[len(alone) - 1]
    return f"{grown:.1e}; ×{row['error']['median'][-1] / grown:.3g}"


def _growth(tops: list[JsonObject], name: str) -> PageTable:
    """Median and largest error, or drift, at each time."""
    rows = [method for method in _methods(tops) if name in method]
    columns = at_times(tops[0]["times"], lambda row, k: _middle_and_most(row[name], k), _SPREAD)
    return table(rows, (_TOP, _METHOD, *columns), _AGAIN)


def _middle_and_most(found: JsonObject, k: int) -> str:
    return f"{formatted(found['median'][k], '.1e')} / {formatted(found['largest'][k], '.1e')}"


def _corrections(tops: list[JsonObject]) -> Iterator[Block]:
    """What projection took, which stands in for the drift of projected runs."""
    rows = [method for method in _methods(tops) if "projection" in method]
    if rows:
        yield Heading("Projection")
        yield Text(
            "The drift of a projected run is no evidence of its accuracy. The table gives the "
            "largest single correction of the state instead, and the largest sum of a run's "
            "corrections, over all starts."
        )
        yield table(rows, _PROJECTION, _AGAIN)


def _far(found: JsonObject) -> Iterator[Block]:
    """Every double method at its tightest tolerance, on the same starts."""
    far = found["at"]
    if not far["tops"] and not found["tops"]:
        return
    yield Heading(f"Every double method at t = {far['t']}")
    yield Text(
        f"Median and largest error of {far['starts']} random bodies and starts of each "
        f"kind{_fewer(far)}, each method at its tightest tolerance: eps for heyoka, 3e-15 for "
        "CyRK, 1e-8 for the splitting (a shorter step takes minutes for each top)."
    )
    yield far_table(found)
    methods = _methods(far["tops"])
    told = [f"{m['method']}, {m['top']}: {fault}" for m in methods for fault in m["faults"]]
    told += [f"{name}: not run ({why})" for name, why in far["not_run"].items()]
    yield Items(tuple(told))


def _fewer(far: JsonObject) -> str:
    """Which methods were given the first of the starts alone."""
    counts = {m["method"]: m.get("starts", far["starts"]) for m in _methods(far["tops"])}
    told = [f"{name}: the first {n}" for name, n in counts.items() if n < far["starts"]]
    return f" ({', '.join(told)})" if told else ""


def far_table(found: JsonObject) -> PageTable:
    """Median and largest error of every method at the far moment, a column a kind of top."""
    far = found["at"]
    rows: dict[str, JsonObject] = {}
    for method in _methods(found["tops"]):
        name = "polhode" if "projected" in method["method"] else "polhode, not projected"
        cell = _middle_and_most(method["error"], method["times"].index(far["t"]))
        rows.setdefault(name, {})[method["top"]] = cell
    rows = dict(sorted(rows.items()))
    for method in _methods(far["tops"]):
        cell = f"{formatted(method['median'], '.1e')} / {formatted(method['largest'], '.1e')}"
        if method["reached"] == 0:
            cell = "failed"
        elif method.get("starts", far["starts"]) < far["starts"]:
            cell += f", {method['starts']} starts"
        rows.setdefault(method["method"], {})[method["top"]] = cell
    tops = dict.fromkeys(top["top"] for top in (*found["tops"], *far["tops"]))
    return table(
        [{"method": name, **cells} for name, cells in rows.items()],
        (_METHOD, *(Column(top, top, ">") for top in tops)),
        "polhode study long-run --only far --only '{0}'",
    )
