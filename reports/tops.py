"""Random bodies of each kind with random starts, found again by their names; and what judges runs.

All numbers are decimals of two places, which no double holds as a rule, so that rounding the inputs
is part of every error.  A scene is named by its kind and number, ``euler start 3``, or where its
body is that of another start, ``euler body 1 start 3``.
"""

from __future__ import annotations

import random
import statistics
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np

import polhode
from kit import fewest_digits
from peers.field import Top
from polhode.equations.terms import coefficients_of
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import DOUBLE, EXTENDED

#: Exact states at some times, p q r gamma1 gamma2 gamma3 a row.
States: TypeAlias = list[list[Fraction]]
SEED = 20


def hundredths(dice: random.Random, least: float, most: float) -> Fraction:
    """A random decimal of two places, not a double's as a rule."""
    return Fraction(dice.randint(round(100 * least), round(100 * most)), 100)


def free(dice: random.Random) -> polhode.Body:
    """A free body of any moments, in any order."""
    moments = _moments(dice)
    dice.shuffle(moments)
    return polhode.Body.of_moments(moments)


def symmetric(dice: random.Random) -> polhode.Body:
    """A symmetric top, disc or needle, its centre on the axis."""
    a = hundredths(dice, 0.7, 2)
    c = hundredths(dice, 0.2, 1.8 * float(a))
    return polhode.Body.of_moments((a, a, c), (0, 0, hundredths(dice, 0.3, 1.5)), 1)


def kovalevskayas(dice: random.Random) -> polhode.Body:
    """A = B = 2C, the centre anywhere in the equator."""
    c = hundredths(dice, 0.5, 1.5)
    x, y = hundredths(dice, -1.2, 1.2), hundredths(dice, 0.2, 1.2)
    return polhode.Body.of_moments((2 * c, 2 * c, c), (x, y, 0), 1)


def asymmetric(dice: random.Random) -> polhode.Body:
    """Any moments, C the largest, the centre anywhere near."""
    moments = sorted(_moments(dice))
    return polhode.Body.of_moments(moments, [hundredths(dice, 0.1, 0.5) for _ in range(3)], 1)


#: The kinds of body that have closed forms in every motion.
TOPS = {"euler": free, "lagrange": symmetric, "kovalevskaya": kovalevskayas}
#: With those that have none, three of them started otherwise.
STARTED = {**TOPS, "asymmetric": asymmetric, "chaotic": asymmetric, "fast": asymmetric}
#: Of the kind "chaotic", whose bodies start without much spin: those that ``polhode.lyapunov`` to
#: t = 3000 calls so.
CHAOTIC = (0, 1, 3, 4, 7, 8, 9, 13)


def random_scene(kind: str, index: int, times: Sequence[Fraction] = ()) -> polhode.Scene:
    """The exact scene: any body of the kind, |components| of w at most 1, any gamma.

    An asymmetric body spins with 2.5 to 3.5 about z, where its motion is regular as a rule, a fast
    one with 20 to 40.
    """
    dice = random.Random(f"{SEED} {kind} {index}")
    body = STARTED[kind](dice)
    p, q, r = (Fraction(dice.randint(-100, 100), 100) for _ in range(3))
    if kind == "asymmetric":
        r = 3 + r / 2
    elif kind == "fast":
        r = 30 + 10 * r
    u, v = (Fraction(dice.randint(-20, 20), 10) for _ in range(2))
    square = u * u + v * v
    gamma = (2 * u / (1 + square), 2 * v / (1 + square), (1 - square) / (1 + square))
    name = f"{kind} start {index + 1}"
    return polhode.Scene(body, (p, q, r), gamma, times=tuple(times), name=name)


def _moments(dice: random.Random) -> list[Fraction]:
    """Three moments of a body."""
    a, b = hundredths(dice, 1, 3), hundredths(dice, 1, 3)
    return [a, b, hundredths(dice, float(abs(a - b)) + 0.1, float(a + b) - 0.1)]


# --- draws ----------------------------------------------------------------------------------------
#
# The motions of the contest: random bodies of six kinds, each from a random start.


KINDS = tuple(STARTED)
DIAGRAM = 100, 101  # the end and the outputs of the cells of the work-precision diagram
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
    def name(self) -> str:
        """Its name, by which one cell alone can be made again."""
        count = f"starts={self.starts}" if self.starts else f"outputs={self.outputs}"
        return f"{self.kind} t={self.end} {count}"

    @property
    def drawn(self) -> bool:
        """Whether it is a panel of the work-precision diagram."""
        return self.every_tolerance or (self.kind, self.end, self.starts) == DRAWN_MANY

    @property
    def every_tolerance(self) -> bool:
        """Whether all tolerances are timed, not only those next to a level."""
        return not self.starts and self.kind in DRAWN_KINDS and self[1:3] == DIAGRAM


class Draw(NamedTuple):
    """One body and start of a kind, exact and rounded to doubles; or its starts, (N, 6)."""

    scene: polhode.Scene
    top: Top
    start: Any

    def run(self, tol: float) -> tuple[Any, ...]:
        """The run of a job of :mod:`peers.process`."""
        return self.top, self.start, np.array([*map(float, self.scene.times)]), tol


def cells(kind: str) -> list[Cell]:
    """Every length and number of outputs of a kind; and of starts."""
    ends = [end for end in ENDS if end <= LAST.get(kind, ENDS[-1])]
    every = [Cell(kind, end, outputs) for end in ends for outputs in OUTPUTS]
    many = MANY if kind in MANY_KINDS else ()
    return every + [Cell(kind, end, 2, starts) for end, starts in many]


def scene_of(kind: str, index: int, end: int, outputs: int) -> polhode.Scene:
    """A draw's scene at its output times, which are doubles."""
    number = CHAOTIC[index] if kind == "chaotic" else index
    return random_scene(kind, number, times(end, outputs))


def draw(kind: str, index: int, end: int, outputs: int, starts: int = 0) -> Draw:
    """A body of the kind and its start, or many starts: w about its own, gamma anywhere."""
    scene = scene_of(kind, index, end, outputs)
    moments, torque = scene.body.moments, scene.body.torque
    rows = coefficients_of([*moments, *torque]), moments, torque, scene.start
    *top, start = (np.array([*map(float, row)]) for row in rows)
    if starts:
        dice = np.random.default_rng(index)
        omega, gamma = np.split(dice.normal(size=(starts, 6)), 2, axis=1)
        omega = start[:3] + _SPREAD * np.linalg.norm(start[:3]) * omega
        gamma /= np.linalg.norm(gamma, axis=1)[:, None]
        start = np.hstack([omega, gamma])
    return Draw(scene, Top(*top), start)


def present(kind: str) -> tuple[bool, ...]:
    """Which coefficients of the equations do not vanish for bodies of a kind."""
    there = [draw(kind, k, 1, 2).top.coefficients != 0 for k in range(DRAWS)]
    return tuple(bool(x) for x in sum(there) > 0)


def truth(kind: str, index: int, end: int, many: bool = False) -> States:
    """The exact states at the judged times: by the closed form, else by a refined run in quad.

    ``many``: of the first of many starts those at the end.
    """
    scene = scene_of(kind, index, end, JUDGED)
    states: Any
    if many:
        rows = draw(kind, index, end, 2, MANY_JUDGED).start
        members = polhode.integrate_many(scene, starts=rows, at=[0]).members
        states = [polhode.integrate(x.at([end]), "quad").states[-1] for x in members]
    elif kind in TOPS:
        states = polhode.reference(scene).at(scene.times, DIGITS)
    else:
        states = polhode.integrate(scene, "quad").states
    return [[exactly(x) for x in row] for row in states]


def digits(states: Any, true: States, scene: polhode.Scene) -> float:
    """Correct digits, the worst over the judged times: the end alone of a single state."""
    rows = np.asarray(states)
    number = EXTENDED if rows.dtype == np.longdouble else DOUBLE
    before = true[: len(true) - len(rows)]
    return fewest_digits([*before, *rows], true, scene, number.most_digits)


def median_digits(states: Any, true: States, scene: polhode.Scene) -> float:
    """Correct digits of the states of many starts, the median over those that are judged."""
    pairs = zip(states, true, strict=True)
    return statistics.median(digits([row], [exact], scene) for row, exact in pairs)


def judged(states: Any, outputs: int) -> Any:
    """Those of the states of a run that are judged."""
    return states[-1:] if outputs == 2 else states[:: (outputs - 1) // (JUDGED - 1)]


@cache
def times(end: int, outputs: int) -> tuple[Fraction, ...]:
    """Even output times from 0 on, as doubles."""
    return tuple(DOUBLE.rounded(Fraction(end) * k / (outputs - 1)) for k in range(outputs))
