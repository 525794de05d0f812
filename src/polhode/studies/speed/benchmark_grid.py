"""Work against precision over run length and number of outputs, with the spread over many starts.

A cell is a body, a length and a number of output times.  In each, every method runs the same random
body from the same random starts (:mod:`polhode.studies.ensembles`) at several tolerances; at six,
nine and twelve digits its seconds are read from each start's own curve and set against polhode's.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from polhode.common.executors import cores, in_order
from polhode.common.progress import Message
from polhode.judging.adaptive_precision import integrate
from polhode.judging.correct_digits import digits_of, rate_scale
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, bits_for
from polhode.numbers.rows import Rows
from polhode.scenes.output_times import even_times
from polhode.scenes.scene import Scene
from polhode.studies.ensembles import TOPS, random_scene
from polhode.studies.peer_processes import Curve, Method, Task
from polhode.studies.row_filter import Only
from polhode.studies.speed.contenders import ENGINE, SPLITTINGS
from polhode.studies.speed.work_precision import WorkPoint, seconds_at

KINDS = ("euler", "lagrange", "kovalevskaya", "asymmetric")
STARTS, QUICK_STARTS = 8, 2
BODY = 0  # the start whose body all have: one a kind, as each is compiled
DIGITS = 24  # asked of the closed forms
LEVELS = (6.0, 9.0, 12.0)
OURS = "polhode"
JUDGED = 11  # even times at which a run is judged, or the end alone where it has no more
#: Ends and numbers of output times.
LENGTHS = tuple((end, outputs) for end in (10, 100, 1000, 10_000) for outputs in (2, 11, 1001))
QUICK_LENGTHS = ((10, 11), (100, 11))
REPEATS, PATIENCE = 2, 0.02

_TOLERANCES = (1e-6, 1e-9, 1e-12, 1e-14)
_OWN = "polhode.studies.isolated_process"
#: polhode as it comes is projected at the tolerance eps alone: two methods, one curve.
METHODS = (
    Method(OURS, _OWN, "double", _TOLERANCES),
    Method(OURS, _OWN, "double projected", (2.0**-52,)),
    Method(ENGINE, "polhode.peers.bare_heyoka", "", (*_TOLERANCES, 2.0**-52)),
    Method("CyRK DOP853", "polhode.peers.cyrk", "DOP853", _TOLERANCES),
    Method("CyRK VERN8", "polhode.peers.cyrk", "VERN8", _TOLERANCES),
    SPLITTINGS[1]._replace(tolerances=(1e-4, 1e-7, 1e-10)),
    Method("SciPy DOP853, Python", "polhode.peers.scipy_python", "DOP853", _TOLERANCES[:3]),
)
#: What takes too long in all cells: the longest length at which it runs, at 11 outputs alone.
SLOW = {"SciPy DOP853, Python": 10, "splitting 8": 1000}
QUICK_METHODS = (OURS, ENGINE)


class Cell(NamedTuple):
    """A kind of motion to an end with so many output times."""

    kind: str
    end: int
    outputs: int

    @property
    def label(self) -> str:
        """Its name, by which one cell alone can be made again."""
        return f"{self.kind} t={self.end} outputs={self.outputs}"

    def scene(self, start: int) -> Scene:
        """One of its starts, at output times that are doubles."""
        return random_scene(self.kind, start, _times(self.end, self.outputs), BODY)

    @property
    def every(self) -> int:
        """Output times from one that is judged to the next."""
        return max(1, (self.outputs - 1) // (JUDGED - 1))


class Truth(NamedTuple):
    """States at the judged times as sums of two doubles, and the scale of w."""

    high: Any
    low: Any
    scale: float


def wanted_cells(quick: bool, wanted: Only) -> dict[Cell, list[Method]]:
    """Which methods run in which cells; polhode always does."""
    asked: dict[Cell, list[Method]] = {}
    for cell in (Cell(kind, *length) for kind in KINDS for length in _lengths(quick)):
        methods = [m for m in METHODS if _runs(m, cell, quick) and wanted(cell.label, m.name)]
        if methods:
            ours = [m for m in METHODS if m.name == OURS and m not in methods]
            asked[cell] = [*ours, *methods]
    return asked


def tasks(asked: Mapping[Cell, Sequence[Method]], quick: bool) -> list[Task]:
    """What runs in the cells: after the motions, whose processes have compiled what all share."""
    return [
        Task(method, scene, cell.every, REPEATS, PATIENCE, late=True)
        for cell, methods in asked.items()
        for scene in map(cell.scene, _starts(quick))
        for method in methods
    ]


def rows(
    asked: Mapping[Cell, Sequence[Method]],
    curves: Iterable[Curve],
    quick: bool,
    tick: Message | None = None,
) -> list[dict[str, Any]]:
    """A row a cell, from the curves of its tasks."""
    made, truths = iter(curves), _truths(asked, quick, tick)
    found = []
    for cell, methods in asked.items():
        marks: dict[str, list[list[WorkPoint]]] = {
            m.name: [[] for _ in _starts(quick)] for m in methods
        }
        faults = {}
        for k in _starts(quick):
            for method in methods:
                curve = next(made)
                marks[method.name][k] += _marks(curve, truths[cell.kind, cell.end, k])
                if curve.status != "ok":
                    faults[method.name] = f"{curve.status}: {curve.reason}"
        found.append(cell_row(cell, marks, faults))
    return found


def _truths(
    asked: Iterable[Cell], quick: bool, tick: Message | None
) -> dict[tuple[str, int, int], Truth]:
    """The references by kind, end and start, the longest first: no clock runs beside them."""
    ends = sorted({(cell.kind, cell.end) for cell in asked}, key=lambda x: -x[1])
    jobs = [(kind, end, start) for kind, end in ends for start in _starts(quick)]

    def begun(job: tuple[str, int, int]) -> None:
        if tick is not None and job[2] == 0:
            tick(f"references of {job[0]} to t = {job[1]}")

    return dict(zip(jobs, in_order(_truth, jobs, 1 if quick else cores(), begun), strict=True))


def _truth(job: tuple[str, int, int]) -> Truth:
    kind, end, start = job
    return truth(Cell(kind, end, JUDGED), start)


def truth(cell: Cell, start: int) -> Truth:
    """The motion at the judged times: by its closed form, else by a refined run in quad."""
    import numpy as np

    from polhode.numbers.mpmath_context import mpmath

    times = _times(cell.end, JUDGED)
    scene = random_scene(cell.kind, start, times, BODY)
    if cell.kind in TOPS:
        states: Rows = reference_of(scene).at(times, DIGITS)
    else:
        states = integrate(scene, "quad").states
    bits = bits_for(DIGITS) + 32
    with mpmath.workprec(bits):
        high = np.array([[float(x) for x in row] for row in states])
        low = np.array([[float(x - float(x)) for x in row] for row in states])
        return Truth(high, low, float(rate_scale(states, scene, bits)))


def digits(states: Any, true: Truth) -> float:
    """Correct digits, the worst over the judged times that the states are of."""
    import numpy as np

    found = np.array(states, dtype=float)
    picked = [0, -1] if len(found) < len(true.high) else slice(None)
    errors = np.abs((found - true.high[picked]) - true.low[picked])
    errors[:, :3] /= true.scale
    worst = float(errors.max())
    return digits_of(worst, DOUBLE.most_digits)


def cell_row(
    cell: Cell, marks: Mapping[str, Sequence[Sequence[WorkPoint]]], faults: Mapping[str, str]
) -> dict[str, Any]:
    """Seconds at each level and over ours: median, least and most over the starts that reach it."""
    levels = []
    for level in LEVELS:
        own = [seconds_at(points, level) for points in marks[OURS]]
        methods = []
        for name, curves in marks.items():
            seconds = [seconds_at(points, level) for points in curves]
            both = zip(seconds, own, strict=True)
            factors = [x / y for x, y in both if x is not None and y is not None]
            methods.append(
                {
                    "method": name,
                    "reached": sum(x is not None for x in seconds),
                    "seconds": _spread([x for x in seconds if x is not None]),
                    "factor": None if name == OURS else _spread(factors),
                }
            )
        levels.append({"digits": level, "methods": methods})
    starts = len(marks[OURS])
    about = {**cell._asdict(), "starts": starts, "once_above": PATIENCE}
    return {**about, "levels": levels, "faults": dict(faults)}


@cache
def _times(end: int, outputs: int) -> tuple[Exact, ...]:
    """Even output times, as doubles."""
    return tuple(DOUBLE.rounded(t) for t in even_times(Fraction(end), outputs))


def _lengths(quick: bool) -> Sequence[tuple[int, int]]:
    return QUICK_LENGTHS if quick else LENGTHS


def _starts(quick: bool) -> range:
    return range(QUICK_STARTS if quick else STARTS)


def _runs(method: Method, cell: Cell, quick: bool) -> bool:
    """Whether a method runs in a cell."""
    if quick and method.name not in QUICK_METHODS:
        return False
    limit = SLOW.get(method.name)
    return limit is None or (cell.end <= limit and cell.outputs == JUDGED)


def _marks(curve: Curve, true: Truth) -> list[WorkPoint]:
    return [
        WorkPoint(digits(point.rows, true), min(point.seconds))
        for point in curve.points.values()
        if point.rows is not None
    ]


def _spread(values: Sequence[float]) -> list[float] | None:
    """Median, least and most; None of nothing."""
    if not values:
        return None
    return [float(f"{x:.3g}") for x in (statistics.median(values), min(values), max(values))]
