"""Page of the study long-run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text

TITLE = "Long runs: growth of error and drift"
ENOUGH = 1e-10  # the error that the far table asks for


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    tops = found["tops"]
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
    yield Figure("long-run", "Growth of error and drift with time, beside Brouwer's exponents")
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
    yield from _far(found["at"])


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


def _far(far: dict[str, Any]) -> Iterator[Block]:
    """Every double method at its tightest tolerance, on one motion a top."""
    yield Heading(f"Every double method at t = {far['t']}")
    names = [method["method"] for method in far["tops"][0]["methods"]]
    by_top = [{m["method"]: m for m in top["methods"]} for top in far["tops"]]
    rows = [(name, *(_error(top[name]) for top in by_top)) for name in names]
    yield Text("The largest error of eleven output times, at each method's tightest tolerance.")
    header = ("method", *(f"`{top['case']}`" for top in far["tops"]))
    yield PageTable(header, tuple(rows), "l" + "r" * len(by_top))
    below = [name for name in names if all(top[name].get("error", 1.0) < ENOUGH for top in by_top)]
    yield Text(f"Below {ENOUGH:g} on every one: {', '.join(below) or 'none'}.")
    told = {
        f"{m['method']}: {m['status']} ({m['reason']})": None
        for top in far["tops"]
        for m in top["methods"]
        if m["status"] != "ok"
    }
    if told:
        yield Items(tuple(told))


def _error(method: dict[str, Any]) -> str:
    return _power(method["error"]) if "error" in method else str(method["status"])


def _power(x: float | None) -> str:
    return "–" if x is None else f"{x:.1e}"
