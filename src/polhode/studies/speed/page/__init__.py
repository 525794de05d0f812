"""Page of the study speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Items, Text
from polhode.studies.page.columns import DIGITS, Column, table
from polhode.studies.page.words import between
from polhode.studies.speed.page import contest, contest_tables

TITLE = "Speed: what a correct digit costs"

_MOTION = Column("motion", "motion")
_BEST = (
    _MOTION,
    Column("method", "method", "", "the number type, and whether the run is projected"),
    Column("to", lambda row: f"{row['motion']}, t = {row['end']}"),
    Column("tol", "tol", ".1e", "the tolerance of the steps, the tightest of several"),
    DIGITS,
    Column("least s", "seconds_min", ".3g", "seconds of a run, the least of all"),
)
_ELSEWHERE = (
    Column("program", "program"),
    Column("written in", "language"),
    Column("problem", "problem"),
    Column("figure (read)", "figure"),
    Column("read where", "source"),
)
_REFINED = (
    _MOTION,
    Column("t", "end", "d"),
    Column("bits", "bits", "d", "bits of the number type"),
    Column("steps, s", "taylor.cpu", ".3g", "CPU seconds of heyoka's steps in that type"),
    Column("steps, digits", "taylor.digits", ".1f", "their correct digits at the end"),
    Column("refined, s", "refined.cpu", ".3g", "CPU seconds of the refined run"),
    Column("refined, digits", "refined.digits", ".1f", "its correct digits at the end"),
    Column("agreement", "agreement", ".1f", "digits to which the two agree"),
    Column("estimate", "estimate", ".3g", "the refined run's own estimate of its error"),
    Column("gain", "gain", ".1f", "seconds of the steps over those of the refined run"),
)


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    if points := contest.points(found):
        yield Text(points[0])
        yield Items(tuple(points[1:]))
    if found["cells"] or found["first"]:
        yield Text("The rules of the comparison: `polhode guide fair-speed`.")
        yield from contest_tables.blocks(found)
    if found["motions"]:
        yield Heading("polhode's number types")
        yield Text(
            "Error is the larger of the error of w, over the largest |w|, and the error of gamma, "
            "at the worst of eleven output times and against the exact scene, so rounding the "
            "inputs is part of it. Seconds are the least of all timed runs of one start after one "
            f"run that warms up; a run of more than {found['once_above']:g} seconds is made once. "
            "Making the integrator is not included. Points further left and below are better. The "
            "dotted line is three times kappa·eps of a double."
        )
        yield Figure("speed", "Error against seconds of polhode in its number types")
        again = "polhode study speed --only '{0}' --only '{1}'"
        yield table(_best(found["motions"]), _BEST, again)
        yield from _absent(found["motions"])
    yield from _refined(found.get("refined", []))
    yield from _elsewhere(found.get("elsewhere", ()))


def _best(motions: Sequence[JsonObject]) -> Iterator[JsonObject]:
    """Each number type at its tightest tolerance on each motion."""
    for motion in motions:
        for method in motion["methods"]:
            points = [p for p in method["points"] if "digits" in p]
            if points:
                yield {**motion, **method, **min(points, key=lambda p: p["tol"])}


def _elsewhere(rows: Sequence[JsonObject]) -> Iterator[Block]:
    """What was read of programs that are not run here."""
    if not rows:
        return
    yield Heading("Figures of other sources, not measured here")
    yield Text(
        "Programs that are not measured here, most of them not written for Python, with what "
        "their own tests, pages or authors say of a rigid body. Each figure was read in the place "
        "named, and none was measured for this report. Machines, problems and measures of error "
        "differ, so that no figure can be compared with the tables above."
    )
    yield table(rows, _ELSEWHERE)


def _refined(rows: list[JsonObject]) -> Iterator[Block]:
    """Refined runs beside heyoka's own steps."""
    if not rows:
        return
    yield Heading("Refined runs")
    times = [1 / row["gain"] for row in rows]
    better = [row["refined"]["digits"] - row["taylor"]["digits"] for row in rows]
    yield Text(
        "A run in double is corrected by exact arithmetic, and compared with heyoka's own steps "
        "in the same number type. CPU seconds in one process with compiled code loaded, the least "
        "of several refined runs and one run of steps. Correct digits at the end are judged by "
        "the closed form, or by heyoka's steps with 12 digits more; here they are not limited to "
        f"what the type holds. Refinement takes {between(times, '.3f')} of the time and gives "
        f"{between(better, '+.1f')} digits more. The two share only a first guess."
    )
    yield table(rows, _REFINED, "polhode study speed --only 'refined: {0} t={1}'")


def _absent(motions: list[JsonObject]) -> Iterator[Block]:
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
