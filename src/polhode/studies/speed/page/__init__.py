"""Page of the study speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import (
    Block,
    Figure,
    Heading,
    Items,
    Number,
    PageTable,
    Text,
)
from polhode.studies.speed.page import contest

TITLE = "Speed: what a correct digit costs"


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    if found["cells"] or found["first"]:
        yield Text(finding(found))
        yield Text("The rules of the comparison: `polhode guide fair-speed`.")
        yield from contest.blocks(found)
    if found["motions"]:
        yield Heading("polhode's number types")
        yield Text(
            "Error is the larger of the error of w over the largest |w| and the error of gamma, "
            "worst of eleven output times, against the exact scene: rounding the inputs is part of "
            "it. Seconds are the least of all timed runs of one start after one that warms up; a "
            f"run of more than {found['once_above']:g} seconds is made once. Making the integrator "
            "is not among them. Left of and below is better. The dotted line is three times "
            "kappa·eps of a double."
        )
        yield Figure("speed", "Error against seconds of polhode in its number types")
        yield _best(found["motions"])
        yield from _absent(found["motions"])
    yield from _refined(found.get("refined", []))
    yield from _elsewhere(found.get("elsewhere", ()))


def finding(found: dict[str, Any]) -> str:
    """The study in a few sentences."""
    return contest.finding(found)


def brief(found: JsonObject) -> str:
    """Where polhode is ahead, and where it is not, in a sentence."""
    return contest.brief(found)


def headline(found: JsonObject) -> Number | None:
    """In how many cells it is ahead, with those in which it is not."""
    return contest.headline(found)


def _best(motions: Sequence[dict[str, Any]]) -> PageTable:
    """Each number type at its tightest tolerance on each motion."""
    rows = []
    for motion in motions:
        for method in motion["methods"]:
            points = [p for p in method["points"] if "digits" in p]
            if points:
                last = min(points, key=lambda p: p["tol"])
                cells = f"{last['digits']:.1f}", _seconds(last.get("seconds_min"))
                label = f"{motion['motion']}, t = {motion['end']}"
                rows.append(
                    (motion["motion"], method["method"], label, f"{last['tol']:.1e}", *cells)
                )
    header = ("motion", "method", "to", "tol", "digits", "least s")
    again = "polhode study speed --only '{0}' --only '{1}'"
    return PageTable(header, tuple(rows), "lllrrr", again)


def _elsewhere(rows: Sequence[dict[str, str]]) -> Iterator[Block]:
    """What was read of programs that are not run here."""
    if not rows:
        return
    yield Heading("Read elsewhere, not measured here")
    yield Text(
        "Programs that are not among the peers, most of them not written for Python, with what "
        "their own tests, pages or authors say of a rigid body. Each was read in the place named, "
        "none was measured for this report: machines, problems and measures of error differ, and "
        "nothing here can be set beside the tables above."
    )
    columns = ("program", "language", "problem", "figure", "source")
    header = ("program", "written in", "problem", "figure (read)", "read where")
    table = tuple(tuple(row[name] for name in columns) for row in rows)
    yield PageTable(header, table, "lllll")


def _refined(rows: list[dict[str, Any]]) -> Iterator[Block]:
    """Refined runs beside heyoka's own steps."""
    if not rows:
        return
    yield Heading("Refined runs")
    gains = [row["gain"] for row in rows]
    better = [row["refined"]["digits"] - row["taylor"]["digits"] for row in rows]
    yield Text(
        "A run in double corrected by exact arithmetic, beside heyoka's own steps in the same "
        "number type: CPU seconds in one process, what is compiled being loaded, the least of "
        "several refined runs and one of steps. Correct digits at the end are by the closed form, "
        "or by heyoka's steps in 12 digits more; here they are not held to what the type can "
        f"hold. Refinement takes {1 / max(gains):.3f} to {1 / min(gains):.3f} of the time and "
        f"gives {min(better):+.1f} to {max(better):+.1f} digits more. The two share only a first "
        "guess; *agreement*: the digits to which they agree."
    )
    yield PageTable(
        (
            *("motion", "t", "bits", "steps s", "digits", "refined s", "digits"),
            *("agreement", "estimate", "gain"),
        ),
        tuple(
            (
                row["motion"],
                str(row["end"]),
                str(row["bits"]),
                _seconds(row["taylor"]["cpu"]),
                f"{row['taylor']['digits']:.1f}",
                _seconds(row["refined"]["cpu"]),
                f"{row['refined']['digits']:.1f}",
                f"{row['agreement']:.1f}",
                _seconds(row.get("estimate")),
                f"{row['gain']:.1f}",
            )
            for row in rows
        ),
        "lrrrrrrrrr",
        "polhode study speed --only 'refined: {0} t={1}'",
    )


def _absent(motions: list[dict[str, Any]]) -> Iterator[Block]:
    """Each method that is missing, failed or stale, and why, once."""
    told = {
        f"{m['method']}: {m['status']} ({m['reason']})": None
        for motion in motions
        for m in motion["methods"]
        if m["status"] != "ok"
    }
    if told:
        yield Heading("Missing, failed, stale")
        yield Items(tuple(told))


def _seconds(x: float | None) -> str:
    return "–" if x is None else f"{x:.3g}"
