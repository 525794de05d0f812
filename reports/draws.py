"""The motions of the contest: random bodies of six kinds, each from a random start."""

from __future__ import annotations

import statistics
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import numpy as np

import polhode
from peers.field import TERMS, Top
from polhode.equations.forms import principal
from polhode.judging.correct_digits import digits_of, log10_rate
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, EXTENDED, Doubles, Rows, bits_for
from polhode.scenes.scene import even_times
from programs import DIAGRAM
from tops import CHAOTIC, STARTED, TOPS, random_scene

KINDS = tuple(STARTED)
DRAWS = 8  # of each kind: as many bodies, each with a start of its own
DIGITS = 24  # asked of the closed forms
JUDGED = 11  # even times at which a run is judged, the end alone where it has no more

ENDS = (1, 10, 100, 1000, 10_000)
OUTPUTS = (2, 101, 10_001)
#: Many starts at once: of which kinds, to which ends how many, and how many of them are judged.
MANY_KINDS = ("asymmetric", "chaotic")
MANY = ((1, 100), (10, 100), (100, 100), (1, 10_000), (10, 10_000))
MANY_JUDGED = 15
#: The kinds in the diagram, one start after the other; many starts to which end, and how many.
DRAWN_KINDS = ("euler", "lagrange", "kovalevskaya", "asymmetric", "chaotic")
DRAWN_MANY = ("asymmetric", 10, 10_000)
_SPREAD = 0.25  # of the draw's own |w|

#: The longest runs of kinds whose digits are gone, or whose turns are too many, later.
LAST = {"chaotic": 100, "fast": 1000}


class Cell(NamedTuple):
    """A kind of motion to an end with so many output times, both ends counted.

    ``starts``: how many of each body at once, whose states at the end are asked for; 0: one start
    after the other.
    """

    kind: str
    end: int
    outputs: int
    starts: int = 0

    @property
    def label(self) -> str:
        """Its name, by which one cell alone can be made again."""
        if self.starts:
            return f"{self.kind} t={self.end} starts={self.starts}"
        return f"{self.kind} t={self.end} outputs={self.outputs}"

    @property
    def drawn(self) -> bool:
        """Whether it is a panel of the work-precision diagram."""
        if self.starts:
            return (self.kind, self.end, self.starts) == DRAWN_MANY
        return self.every_tolerance

    @property
    def every_tolerance(self) -> bool:
        """Whether all tolerances are timed, not only those next to a level."""
        return not self.starts and self.kind in DRAWN_KINDS and self[1:3] == DIAGRAM


class Draw(NamedTuple):
    """One body and start of a kind, exact and rounded to doubles; or its starts, (N, 6)."""

    scene: polhode.Scene
    top: Top
    start: Any

    def run(self, tol: float) -> dict[str, Any]:
        """The run of a job of :mod:`peers.process`."""
        times = [float(t) for t in self.scene.times]
        top = [x.tolist() for x in self.top]
        return {"top": top, "start": self.start.tolist(), "times": times, "tol": tol}


class Truth(NamedTuple):
    """States at the judged times as sums of two doubles, and the scale of w, without dimensions.

    Of many starts the states at the end of the first ones, and the scale of each.
    """

    high: Doubles
    low: Doubles
    scale: Doubles


def cells(kind: str) -> list[Cell]:
    """Every length and number of outputs of a kind; and of starts."""
    ends = [end for end in ENDS if end <= LAST.get(kind, ENDS[-1])]
    every = [Cell(kind, end, outputs) for end in ends for outputs in OUTPUTS]
    if kind in MANY_KINDS:
        every += [Cell(kind, end, 2, starts) for end, starts in MANY]
    return every


def scene_of(kind: str, index: int, end: int, outputs: int) -> polhode.Scene:
    """A draw's scene at its output times, which are doubles."""
    number = CHAOTIC[index] if kind == "chaotic" else index
    return random_scene(kind, number, times(end, outputs))


def draw(kind: str, index: int, end: int, outputs: int, starts: int = 0) -> Draw:
    """A body of the kind and its start, or many starts: w about its own, gamma anywhere."""
    scene = scene_of(kind, index, end, outputs)
    body = scene.body
    terms = principal.coefficients(body)
    coefficients = np.array([to_double(terms.get(term, 0)) for term in TERMS])
    moments, torque = (np.array([*map(to_double, x)]) for x in (body.moments, body.torque))
    start = np.array([*map(to_double, scene.start)])
    if starts:
        dice = np.random.default_rng(index)
        omega, gamma = np.split(dice.normal(size=(starts, 6)), 2, axis=1)
        omega = start[:3] + _SPREAD * np.linalg.norm(start[:3]) * omega
        gamma /= np.linalg.norm(gamma, axis=1)[:, None]
        start = np.hstack([omega, gamma])
    return Draw(scene, Top(coefficients, moments, torque), start)


def present(kind: str) -> tuple[bool, ...]:
    """Which coefficients of the equations do not vanish for bodies of a kind."""
    there = [draw(kind, k, 1, 2).top.coefficients != 0 for k in range(DRAWS)]
    return tuple(bool(x) for x in sum(there) > 0)


def truth(kind: str, index: int, end: int, many: bool = False) -> Truth:
    """The motion at the judged times: by its closed form, else by a refined run in quad.

    ``many``: of the first of many starts the states at the end.
    """
    scene = scene_of(kind, index, end, JUDGED)
    states: Rows
    if many:
        rows = draw(kind, index, end, 2, MANY_JUDGED).start
        members = polhode.integrate_many(scene, starts=rows, at=[0]).members
        runs = [polhode.integrate(member.at([end]), "quad") for member in members]
        states = [run.states[-1] for run in runs]
        scale = np.array([10 ** log10_rate(run.states, run.scene) for run in runs])
    else:
        if kind in TOPS:
            states = polhode.reference(scene).at(scene.times, DIGITS)
        else:
            states = polhode.integrate(scene, "quad").states
        scale = np.array(10 ** log10_rate(states, scene))
    from polhode.numbers.mpmath_context import mpmath

    with mpmath.workprec(bits_for(DIGITS) + 32):
        high = np.array([[float(x) for x in row] for row in states])
        low = np.array([[float(x - float(x)) for x in row] for row in states])
        return Truth(high, low, scale)


def digits(states: Any, true: Truth) -> float:
    """Correct digits, the worst over the judged times: the end alone of a single state."""
    rows = np.asarray(states)
    number = EXTENDED if rows.dtype == np.longdouble else DOUBLE
    if number is DOUBLE:
        rows = rows.astype(float)
    picked = slice(-1, None) if len(rows) == 1 else slice(None)
    errors = np.abs((rows - true.high[picked]) - true.low[picked])
    errors[:, :3] /= true.scale
    worst = float(errors.max())
    with np.errstate(divide="ignore"):
        return float(digits_of(np.log10(worst), number.most_digits)) if np.isfinite(worst) else 0.0


def median_digits(states: Any, true: Truth) -> float:
    """Correct digits of the states of many starts, the median over those that are judged."""
    rows = zip(states, true.high, true.low, true.scale, strict=True)
    each = [digits([row], Truth(high[None], low[None], scale)) for row, high, low, scale in rows]
    return statistics.median(each)


def judged(states: Any, outputs: int) -> Any:
    """Those of the states of a run that are judged."""
    return states[-1:] if outputs == 2 else states[:: (outputs - 1) // (JUDGED - 1)]


@cache
def times(end: int, outputs: int) -> tuple[Exact, ...]:
    """Even output times from 0 on, as doubles."""
    return tuple(DOUBLE.rounded(t) for t in even_times(Fraction(end), outputs))
