"""Page of the study long-run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text

TITLE = "Long runs: growth of error and drift"


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    tops = found["tops"]
    if not tops:
        yield from _far(found)
        return
    yield Text(
        f"{tops[0]['starts']} random bodies of each kind, each from a random start, all numbers "
        f"decimals of two places, are followed to t = {tops[0]['times'][-1]} in double at the "
        "tolerance eps and judged against their closed forms at each moment. Error: the larger of "
        "the error of w over the largest |w| and the error of gamma. Drift: the largest of the "
        "relative departures of h, f and |gamma|² from the exact scene's values, of runs that are "
        "not projected. Exponents are slopes of the ensemble's median on log–log from "
        f"t = {tops[0]['fitted_since']:g} on, by weighted least squares; their uncertainty is the "
        "standard error of a bootstrap over the bodies."
    )
    yield Figure(
        "long-run",
        "Growth of error and drift with time, beside Brouwer's exponents; a bar leads from the "
        "median to the worst start; projected runs have no drift to show",
    )
    yield Heading("Exponents")
    yield Text(
        "Brouwer's law for independent roundings: 3/2 for the error, 1/2 for the drift. Rounding "
        "the inputs once shifts the frequencies: an error that grows like t, 1. That is what is "
        "left of a projected run's error, whose integrals stay."
    )
    yield _exponents(tops, found["brouwer"])
    for name, title in (("error", "Error"), ("drift", "Drift")):
        yield Heading(f"{title}: median and largest of the ensemble")
        yield _growth(tops, name)
    yield from _corrections(tops)
    blamed = [top["top"] for top in tops if top["wall"]]
    yield Text(
        "The closed forms' own errors at the last time are "
        + ", ".join(f"{_power(top['reference_error'])} ({top['top']})" for top in tops)
        + (f": a wall for {', '.join(blamed)}." if blamed else ": no wall.")
    )
    yield from _far(found)


def finding(found: dict[str, Any]) -> str:
    """The study in a sentence."""
    told = []
    for top in found["tops"]:
        plain, projected = (m["error"]["median"][-1] for m in top["methods"])
        told.append(f"{_power(projected)} ({top['top']}; {_power(plain)} without)")
    return (
        f"At t = {found['tops'][0]['times'][-1]} half of the runs in double of random bodies are "
        f"within {', '.join(told)} of the truth where they are put back on their first integrals."
    )


def _exponents(tops: list[dict[str, Any]], brouwer: dict[str, float]) -> PageTable:
    rows = []
    for top in tops:
        for method in top["methods"]:
            for name in ("error", "drift"):
                found = method.get(name)
                if found is not None and found["exponent"] is not None:
                    rows.append(
                        (
                            top["top"],
                            method["method"],
                            name,
                            f"{found['exponent']:.2f} ± {found['uncertainty']:.2f}",
                            f"{found['last_decade']:.2f} ± {found['last_uncertainty']:.2f}",
                            f"{brouwer[name]:g}",
                        )
                    )
    header = ("top", "method", "of", "exponent", "last decade alone", "Brouwer")
    return PageTable(header, tuple(rows), "lllrrr")


def _growth(tops: list[dict[str, Any]], name: str) -> PageTable:
    times = tops[0]["times"]
    rows = []
    for top in tops:
        for method in top["methods"]:
            if name in method:
                pairs = zip(method[name]["median"], method[name]["largest"], strict=True)
                cells = (f"{_power(middle)} / {_power(most)}" for middle, most in pairs)
                rows.append((top["top"], method["method"], *cells))
    header = ("top", "method", *(f"t = {t}" for t in times))
    return PageTable(header, tuple(rows), "ll" + "r" * len(times))


def _corrections(tops: list[dict[str, Any]]) -> Iterator[Block]:
    """What projection took, which stands in for the drift of projected runs."""
    rows = tuple(
        (
            top["top"],
            ", ".join(method["projection"]["onto"]),
            _power(method["projection"]["largest"]),
            _power(method["projection"]["sum"]),
        )
        for top in tops
        for method in top["methods"]
        if "projection" in method
    )
    if rows:
        yield Heading("Projection")
        yield Text(
            "The drift of a projected run is no evidence of accuracy. Instead: the largest single "
            "correction of the state and the largest sum of a run's corrections, over all starts."
        )
        yield PageTable(("top", "onto", "largest", "sum"), rows, "llrr")


def _far(found: dict[str, Any]) -> Iterator[Block]:
    """Every double method at its tightest tolerance, on the same starts."""
    far = found["at"]
    if not far["tops"] and not found["tops"]:
        return
    yield Heading(f"Every double method at t = {far['t']}")
    yield Text(
        f"Median and largest error of {far['starts']} random bodies and starts of each kind, at "
        "each method's tightest tolerance: eps for heyoka, 3e-15 for CyRK, "
        "1e-8 for the splitting (a shorter step takes minutes a top). Each column alone: `polhode "
        "study long-run --only 'euler t=100000'`."
    )
    yield far_table(found)
    told = [
        f"{m['method']}, {top['top']}: {fault}"
        for top in far["tops"]
        for m in top["methods"]
        for fault in m["faults"]
    ]
    told += [f"{name}: not run ({why})" for name, why in far["not_run"].items()]
    yield Items(tuple(told))


def far_table(found: dict[str, Any]) -> PageTable:
    """Median and largest error of every method at the far moment, a column a kind of top."""
    far = found["at"]
    columns: dict[str, dict[str, str]] = {}
    for top in found["tops"]:
        at = top["times"].index(far["t"])
        for method in top["methods"]:
            name = "polhode" if "projected" in method["method"] else "polhode, not projected"
            middle, most = (method["error"][key][at] for key in ("median", "largest"))
            columns.setdefault(name, {})[top["top"]] = f"{_power(middle)} / {_power(most)}"
    columns = dict(sorted(columns.items()))
    for top in far["tops"]:
        for method in top["methods"]:
            cell = f"{_power(method['median'])} / {_power(method['largest'])}"
            if method["reached"] == 0:
                cell = "failed"
            columns.setdefault(method["method"], {})[top["top"]] = cell
    tops = list(dict.fromkeys(top["top"] for top in (*found["tops"], *far["tops"])))
    rows = tuple((name, *(cells.get(top, "–") for top in tops)) for name, cells in columns.items())
    return PageTable(("method", *tops), rows, "l" + "r" * len(tops))


def _power(x: float | None) -> str:
    return "–" if x is None else f"{x:.1e}"
