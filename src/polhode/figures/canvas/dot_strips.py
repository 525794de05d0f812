"""Strips of dots: correct digits of many runs, a row a group of cases, a colour a number type."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import COLOURS, MARKS
from polhode.figures.canvas.direct_labels import Look
from polhode.figures.canvas.panel import Axis, Guide, Panel, Point, Rows, Series

HELD = {"double": 53 * 0.30103, "extended": 64 * 0.30103, "quad": 113 * 0.30103}
LABEL = (
    "correct digits, worst of all output times\n"
    "(dotted: what the type holds; ringed: fewer\nthan nine in ten such runs)"
)
ASKED = 50  # digits that the runs in mp are asked for
_PITCH = 0.052  # inches from a dot to the next where several are level


class Dot(NamedTuple):
    """One run: its digits, and whether it has fewer than the least expected."""

    digits: float
    number: str
    behind: bool


def dot(run: Mapping[str, Any]) -> Dot | None:
    """The dot of a run in a study's JSON; None where the run has no digits."""
    if "correct_digits" not in run:
        return None
    digits, expected = run["correct_digits"], run.get("expected")
    return Dot(digits, run["number"], expected is not None and digits < expected[0])


def svg(groups: Mapping[str, Sequence[Dot]], label: str) -> str:
    """A strip a group, from the top down; rings are runs with fewer digits than expected."""
    heights = [
        max(0.16 + _PITCH * _depth(dots), 0.06 + 0.135 * len(name.splitlines()))
        for name, dots in groups.items()
    ]
    edges = [0.0, *accumulate(heights or [0.3])]
    levels = [(low + high) / 2 for low, high in pairwise(edges)][: len(groups)]
    names = dict(zip(levels, groups, strict=True))
    rows = Rows(names, [*pairwise(edges)][::2], (0.0, edges[-1]), {})
    placed = [
        (one, y)
        for level, dots in zip(levels, groups.values(), strict=True)
        for one, y in _strip(dots, level)
    ]
    most = max((one.digits for one, _ in placed), default=float(ASKED))
    guides = [Guide("x", digits, COLOURS[name]) for name, digits in HELD.items()]
    x = Axis(label, low=-1.0, high=most + 1.5)
    series = [one for number in COLOURS for one in _series(number, placed)]
    return panel.svg([Panel(series, x, rows=rows, guides=guides, legend=4)], 0.9 + edges[-1])


def _series(number: str, placed: Sequence[tuple[Dot, float]]) -> Iterator[Series]:
    """The dots of a number type, and those with a ring."""
    look = Look(COLOURS[number], MARKS[number], "", size=3.4, rim_width=0, alpha=0.85)
    name = f"{number}, {ASKED} asked" if number == "mp" else number
    for ringed, told, style in (
        (False, name, look),
        (True, "", look._replace(rim="#000000", rim_width=0.9)),
    ):
        points = [
            Point(one.digits, y)
            for one, y in placed
            if (one.number, one.behind) == (number, ringed)
        ]
        yield Series(points, style, told)


def _strip(dots: Sequence[Dot], middle: float) -> Iterator[tuple[Dot, float]]:
    """The dots of one group about a level: those that would overlap, one above the other."""
    for members in _piles(dots).values():
        for k, one in enumerate(members):
            yield one, middle + _PITCH * (k - (len(members) - 1) / 2)


def _piles(dots: Sequence[Dot]) -> dict[tuple[str, int], list[Dot]]:
    """Dots of one type that are within a digit of one another."""
    piles: dict[tuple[str, int], list[Dot]] = {}
    for one in sorted(dots):
        piles.setdefault((one.number, round(one.digits)), []).append(one)
    return piles


def _depth(dots: Sequence[Dot]) -> int:
    return max((len(pile) for pile in _piles(dots).values()), default=1)
