"""Page of the study long-run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text

TITLE = "Long runs: growth of error and drift"
_AGAIN = "polhode study long-run --only '{0} growth'"


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
        "relative departures of h, f, |gamma|² and the fourth integral from the exact scene's "
        "values, of runs that are not projected. Exponents are slopes of the ensemble's median on "
        f"log–log from t = {tops[0]['fitted_since']:g} on, by weighted least squares; their "
        "uncertainty is the standard error of a bootstrap over the bodies."
    )
    yield Figure(
        "long-run",
        "Growth of error and drift with time; a bar leads from the median to the worst start. "
        "Dotted: the laws' slopes. Dashed grey: what rounding the inputs leaves of projected runs, "
        "as far as it was followed, and from there like t. "
        "Below: the departure of h, standard deviation (line) and size of the mean (open marks)",
    )
    yield Heading("Exponents")
    yield Text(
        "Brouwer's law for independent roundings: 3/2 for the error, 1/2 for the drift. A "
        "projected run's integrals stay, and the law for it is another: rounded coefficients shift "
        "the frequencies once and for all, an error that grows like t, 1; before that shows, "
        "roundings within the level add up like t^1/2."
    )
    yield _exponents(tops)
    yield from _walks(tops)
    yield from _beside_inputs(tops)
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


def _exponents(tops: list[dict[str, Any]]) -> PageTable:
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
                            *_fitted(found),
                            f"{found['law']:g}",
                        )
                    )
    header = ("top", "method", "of", "exponent", "last decade alone", "law")
    return PageTable(header, tuple(rows), "lllrrr", _AGAIN)


def _fitted(found: dict[str, Any]) -> tuple[str, str]:
    """An exponent and that of the last decade, each with its standard error."""
    if found["exponent"] is None:
        return "–", "–"
    if found["exponent"] == found["uncertainty"] == 0:  # such as the spin of a Lagrange top
        return "stays", "stays"
    return (
        f"{found['exponent']:.2f} ± {found['uncertainty']:.2f}",
        f"{found['last_decade']:.2f} ± {found['last_uncertainty']:.2f}",
    )


def _walks(tops: list[dict[str, Any]]) -> Iterator[Block]:
    """Each integral's mean departure beside its standard deviation: bias against random walk."""
    walks = [(top, row) for top in tops for m in top["methods"] for row in m.get("integrals", ())]
    if not walks:
        return
    yield Heading("Bias against random walk")
    yield Text(
        "Each integral's departure has a sign. Where roundings are independent its mean over the "
        "ensemble is zero but for chance, and its standard deviation grows like t^1/2; a bias of "
        "one sign lifts the mean off zero, by many of its standard errors (the standard deviation "
        "over the root of the number of starts), one that differs from body to body lifts the "
        f"exponent. {bias(tops)}"
    )
    rows = []
    for top, row in walks:
        mean, deviation = row["mean"][-1], row["deviation"][-1]
        rows.append(
            (
                *(top["top"], _named(row)),
                f"{mean:+.1e} ± {_standard_error(top, row):.1e}",
                f"{deviation:.1e}",
                f"{_pull(top, row):+.1f}",
                *_fitted(row),
                f"{row['law']:g}",
            )
        )
    header = (
        *("top", "integral", f"mean at t = {tops[0]['times'][-1]}", "standard deviation"),
        *("mean / its error", "exponent of the deviation", "last decade alone", "law"),
    )
    yield PageTable(header, tuple(rows), "llrrrrrr", _AGAIN)


def bias(tops: list[dict[str, Any]]) -> str:
    """Which means are off zero, in a sentence; Student's t of 15 is beyond 4 once in a thousand."""
    walks = [(top, row) for top in tops for m in top["methods"] for row in m.get("integrals", ())]
    pulls = {f"{_named(row)} ({top['top']})": _pull(top, row) for top, row in walks}
    off = [f"{name}, {pull:+.1f} standard errors" for name, pull in pulls.items() if abs(pull) > 4]
    if off:
        return f"A bias is seen in {'; '.join(off)}."
    return (
        f"Of {len(pulls)} means none is further off than {max(map(abs, pulls.values())):.1f} "
        "standard errors: no bias is seen."
    )


def _named(row: dict[str, Any]) -> str:
    name: str = row["integral"].replace("^2", "²")
    return name


def _standard_error(top: dict[str, Any], row: dict[str, Any]) -> float:
    found: float = row["deviation"][-1] / math.sqrt(top["starts"])
    return found


def _pull(top: dict[str, Any], row: dict[str, Any]) -> float:
    error = _standard_error(top, row)
    return 0.0 if error == 0 else row["mean"][-1] / error


def _beside_inputs(tops: list[dict[str, Any]]) -> Iterator[Block]:
    """Errors of projected runs over what rounding the inputs leaves of them."""
    rows = []
    for top in tops:
        for method in top["methods"]:
            if "inputs" in method:
                alone, over = (method["inputs"][k] for k in ("median", "error_over_it"))
                cells = [_times(*pair) for pair in zip(alone, over, strict=True)]
                grown = alone[-1] * top["times"][-1] / top["times"][len(alone) - 1]
                cells.append(_times(grown, method["error"]["median"][-1] / grown))
                rows.append((top["top"], *cells))
    if not rows:
        return
    times, end = tops[0]["times"][: len(rows[0]) - 2], tops[0]["times"][-1]
    yield Heading("Projected runs beside what rounding the inputs leaves")
    yield Text(
        "The error that the rounding of each scene's own numbers to double leaves where the state "
        "is put back on the exact integrals, by the variational equations (known differences, not "
        "a bound): its median over the ensemble, and the median of the run's own error over it. "
        f"It is followed to t = {times[-1]}; the last column is what it would be at t = {end} if "
        "it went on like t, and the median error there over that. Where that is near one, a "
        "projected run's error is by then little else than that of its inputs."
    )
    header = ("top", *(f"t = {t}" for t in times), f"t = {end}, like t")
    yield PageTable(header, tuple(rows), "l" + "r" * (len(times) + 1), _AGAIN)


def _times(alone: float, over: float) -> str:
    return f"{_power(alone)}; ×{over:.3g}"


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
    return PageTable(header, tuple(rows), "ll" + "r" * len(times), _AGAIN)


def _corrections(tops: list[dict[str, Any]]) -> Iterator[Block]:
    """What projection took, which stands in for the drift of projected runs."""
    rows = tuple(
        (
            top["top"],
            ", ".join(method["projection"]["onto"]).replace("^2", "²"),
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
        yield PageTable(("top", "onto", "largest", "sum"), rows, "llrr", _AGAIN)


def _far(found: dict[str, Any]) -> Iterator[Block]:
    """Every double method at its tightest tolerance, on the same starts."""
    far = found["at"]
    if not far["tops"] and not found["tops"]:
        return
    yield Heading(f"Every double method at t = {far['t']}")
    yield Text(
        f"Median and largest error of {far['starts']} random bodies and starts of each kind"
        f"{_fewer(far)}, at each method's tightest tolerance: eps for heyoka, 3e-15 for CyRK, "
        "1e-8 for the splitting (a shorter step takes minutes a top)."
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


def _fewer(far: dict[str, Any]) -> str:
    """Which methods were given the first of the starts alone."""
    rows = [m for top in far["tops"] for m in top["methods"]]
    counts = {m["method"]: m.get("starts", far["starts"]) for m in rows}
    told = [f"{name}: the first {n}" for name, n in counts.items() if n < far["starts"]]
    return f" ({', '.join(told)})" if told else ""


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
            elif method.get("starts", far["starts"]) < far["starts"]:
                cell += f", {method['starts']} starts"
            columns.setdefault(method["method"], {})[top["top"]] = cell
    tops = list(dict.fromkeys(top["top"] for top in (*found["tops"], *far["tops"])))
    rows = tuple((name, *(cells.get(top, "–") for top in tops)) for name, cells in columns.items())
    again = "polhode study long-run --only far --only '{0}'"
    return PageTable(("method", *tops), rows, "l" + "r" * len(tops), again)


def _power(x: float | None) -> str:
    return "–" if x is None else f"{x:.1e}"
