"""Part of the page of speed: what its rows do not show, and which claims were withdrawn for that.

It goes once the study calls every program at its best, from new starts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

from polhode.studies.page.blocks import Block, Heading, Items, Text
from polhode.studies.speed.rows import as_it_comes
from polhode.studies.speed.work_precision import WorkPoint, seconds_at

#: Part of the study's JSON object: the whole, a motion, a cell.
Told: TypeAlias = dict[str, Any]

SHORT = (
    "At t = 10 it is behind compiled Runge–Kutta codes: there a new start of a prepared body costs "
    "it 0.2 to 0.5 ms and a new scene about one, and them nothing (measured apart from these rows)."
)
SMALLER = (
    "That is of runs repeated from one start; with new starts, and every program called at its "
    "best, the lead is smaller."
)
CYRK = (
    "CyRK was called in a slow way, from the interpreter (one njit wrapper makes it 2 to 9 times "
    "faster at t = 10, output equal to the bit)"
)
CYRK_DRAWN = "CyRK's times hold 60 to 110 microseconds of calls from the interpreter"
RERUNS = "only reruns of one start were counted"
BUILDS = (
    "Each integrator was built once, and equal builds of heyoka can differ by 1.2 to 1.6 times: "
    "factors nearer to 1 decide nothing."
)
TWO_OUTPUTS = (
    "With two outputs heyoka was called by `propagate_grid`, where `propagate_until` is 8 to 42 % "
    "faster"
)
#: Of the cells' design, for the page alone.
_DESIGN = (
    "Each kind of motion is one body, none of them chaotic; the ratios have no intervals.",
    "The tolerances are not bracketed: where a method's loosest already has 12 digits, its times "
    "to 6, 9 and 12 digits are one number.",
)
#: Reaches 12 digits, and was left out of the cells.
_COMPENSATED, _TWELVE = "splitting 8 compensated", 12.0


def withdrawn(motions: Sequence[Told]) -> str:
    """Which claim was withdrawn, and why, in a paragraph."""
    return (
        "What stood here before (“12 of 12 cells”, “the fastest of all programs tried”) does not "
        "stand and is withdrawn until speed is measured again: "
        f"{'; '.join([CYRK, *_missing(motions), RERUNS])}."
    )


def blocks(found: Told) -> Iterator[Block]:
    """All that speaks against reading more from the rows."""
    motions = found["motions"]
    yield Heading("What these rows do not show")
    yield Text(withdrawn(motions))
    more = [BUILDS, f"{TWO_OUTPUTS}: the factors of those cells flatter polhode.", *_DESIGN]
    if left_out := compensated(motions):
        more.insert(0, left_out)
    yield Items(tuple(more))


def compensated(motions: Sequence[Told]) -> str:
    """What a program that was left out of the cells reaches on the long regular motions."""
    regular = [m for m in motions if m["kind"] == "regular"]
    ran = [m for m in regular if any(x["method"] == _COMPENSATED for x in m["methods"])]
    both = []
    for motion in ran:
        (theirs,) = (x["points"] for x in motion["methods"] if x["method"] == _COMPENSATED)
        points = [WorkPoint(p["digits"], p["seconds_min"]) for p in theirs if "digits" in p]
        seconds = seconds_at(points, _TWELVE), seconds_at(as_it_comes(motion["methods"]), _TWELVE)
        both.append(seconds)
    reached = sum(theirs is not None for theirs, _ in both)
    factors = [theirs / ours for theirs, ours in both if theirs is not None and ours is not None]
    if not factors:
        return ""
    ends = ", ".join(sorted({f"{motion['end']:g}" for motion in ran}, key=float))
    return (
        f"{_COMPENSATED.capitalize()} was left out of the cells. It reaches {_TWELVE:g} digits on "
        f"{reached} of {len(ran)} regular motions to t = {ends}; where polhode does too, in "
        f"{min(factors):.2g} to {max(factors):.2g} times its time."
    )


def _missing(motions: Sequence[Told]) -> list[str]:
    """The programs that were not there."""
    names = [m["method"] for x in motions for m in x["methods"] if m["status"] == "missing"]
    programs = ", ".join(dict.fromkeys(name.partition(" ")[0] for name in names))
    return [f"{programs} was missing"] if programs else []
