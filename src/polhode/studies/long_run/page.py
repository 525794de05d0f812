"""Tables and facts of the long-run study's page."""

from __future__ import annotations

import math

from polhode.common.texts import JsonObject
from polhode.studies.page.tables import Column, PageTable, at_times, table
from polhode.studies.page.words import DASH, formatted

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
_WALKS = (
    _TOP,
    Column("integral", lambda row: _squared(row["integral"])),
    Column(
        "mean at the end",
        lambda row: f"{row['mean'][-1]:+.1e} ± {_standard_error(row):.1e}",
        *(">", "of the integral's departure over the ensemble, ± its standard error"),
    ),
    Column("standard deviation", lambda row: row["deviation"][-1], ".1e"),
    Column(
        "mean / its error", lambda row: _pull(row), "+.1f", "the mean in its own standard errors"
    ),
    Column("exponent of the deviation", lambda row: _fitted(row, "exponent"), ">"),
    _LAST_DECADE,
    _LAW,
)
_FAULTS = (
    _METHOD,
    Column("top", "top", "", "a dash: every kind of top"),
    Column("why it is missing or failed", "fault"),
)


def tables(found: JsonObject) -> dict[str, PageTable]:
    """The page's tables from the study's JSON object."""
    tops = found["tops"]
    rows, times = _methods(tops), tops[0]["times"] if tops else []
    kept = [row for row in rows if "inputs" in row]
    followed = times[: len(kept[0]["inputs"]["median"])] if kept else []
    inputs = (_TOP, *at_times(followed, _over_inputs, _LEFT), Column("last, like t", _like_t, ">"))
    return {
        "exponents": table(_exponents(rows), _EXPONENTS, _AGAIN),
        "walks": table(_integrals(rows), _WALKS, _AGAIN),
        "inputs": table(kept, inputs, _AGAIN),
        "error": _growth(rows, times, "error"),
        "drift": _growth(rows, times, "drift"),
        "projection": table([row for row in rows if "projection" in row], _PROJECTION, _AGAIN),
        "far": far_table(found),
        "faults": table(_faults(found["at"]), _FAULTS),
    }


def facts(found: JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    tops, far = found["tops"], found["at"]
    pulls = [abs(_pull(row)) for row in _integrals(_methods(tops))]
    return {
        "starts": far["starts"],
        "end": tops[0]["times"][-1] if tops else DASH,
        "since": f"{tops[0]['fitted_since']:g}" if tops else DASH,
        "means": len(pulls),
        "pull": max(pulls, default=0),
        "reference_error": max((top["reference_error"] for top in tops), default=0),
        "walls": sum(top["wall"] for top in tops),
        "far_end": far["t"],
    }


def _methods(tops: list[JsonObject]) -> list[JsonObject]:
    """Every method on every kind of top, each with what is said of the top."""
    return [{**top, **method} for top in tops for method in top["methods"]]


def _exponents(rows: list[JsonObject]) -> list[JsonObject]:
    """What grew by each method on each kind of top, of which an exponent was found."""
    return [
        {**row, **row[name], "of": name}
        for row in rows
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


def _integrals(rows: list[JsonObject]) -> list[JsonObject]:
    """Every integral of every kind of top."""
    return [{**row, **one} for row in rows for one in row.get("integrals", ())]


def _squared(names: str) -> str:
    return names.replace("^2", "²")


def _standard_error(row: JsonObject) -> float:
    found: float = row["deviation"][-1] / math.sqrt(row["starts"])
    return found


def _pull(row: JsonObject) -> float:
    error = _standard_error(row)
    return 0.0 if error == 0 else row["mean"][-1] / error


def _over_inputs(row: JsonObject, k: int) -> str:
    """What rounding the inputs leaves at a time, and the run's error over it."""
    return f"{row['inputs']['median'][k]:.1e}; ×{row['inputs']['error_over_it'][k]:.3g}"


def _like_t(row: JsonObject) -> str:
    """The same at the last time, where it went on like t."""
    alone, times = row["inputs"]["median"], row["times"]
    grown = alone[-1] * times[-1] / times[len(alone) - 1]
    return f"{grown:.1e}; ×{row['error']['median'][-1] / grown:.3g}"


def _growth(rows: list[JsonObject], times: list[int], name: str) -> PageTable:
    """Median and largest error, or drift, at each time."""
    columns = at_times(times, lambda row, k: _middle_and_most(row[name], k), _SPREAD)
    return table([row for row in rows if name in row], (_TOP, _METHOD, *columns), _AGAIN)


def _middle_and_most(found: JsonObject, k: int) -> str:
    return f"{formatted(found['median'][k], '.1e')} / {formatted(found['largest'][k], '.1e')}"


def _faults(far: JsonObject) -> list[JsonObject]:
    """Runs at the far moment that failed, and programs that were not run."""
    failed = [{**row, "fault": fault} for row in _methods(far["tops"]) for fault in row["faults"]]
    return failed + [{"method": k, "fault": f"not run: {why}"} for k, why in far["not_run"].items()]


def far_table(found: JsonObject) -> PageTable:
    """Median and largest error of every method at the far moment, one column per kind of top."""
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
