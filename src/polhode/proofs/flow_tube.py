"""The flow of a box of starts: where it is at chosen times, its derivative, its steepness.

Trusted.  Every motion that starts within r of the centre, in the max-norm, is enclosed beside the
centre's own, over the same polynomials: the box is the first columns of the set (``zonotope``).
``steepness`` bounds |f'(x)| in the Euclidean norm wherever these motions pass, by
|M|_2**2 <= |M|_1 |M|_inf and sup |x_i| <= sum_k |coefficient k of x~_i| + gap + sigma + r a step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from flint import arb

from polhode.enclosures import zonotope
from polhode.enclosures.fixed_point_problem import TIME_BITS, UP, Problem, Refused
from polhode.enclosures.step_bound import TINY, Bounds, jacobian
from polhode.enclosures.variations.variational_bound import Derivatives
from polhode.enclosures.zonotope import State, Step, inside
from polhode.numbers.flint_context import ctx
from polhode.proofs.level import Balls, LevelBalls, largest, row_sum

_WIDENINGS = 30
_LARGEST = 2.0**400  # squares of what the set holds are doubles


class Tube:
    """Watches the proof of the centre's motion; ``rows``: boxes at the times, increasing."""

    def __init__(self, problem: Problem, radius: float, times: Sequence[arb]) -> None:
        """``radius``: of the box, in units of 2**-noise; ``times``: balls, the last one the end."""
        if not 0.0 < radius < _LARGEST:
            raise Refused("the box does not fit the noise level")
        self.times = times
        self.rows: list[list[arb]] = []
        self.steepness, self.fine = 0.0, problem.fine
        box = UP * np.array(problem.spread) + radius
        self._state = State(0, problem.start, np.diag(box))
        self._derivatives = Derivatives(times[-1:])

    def window(self, known: Bounds, steps: Sequence[Step]) -> None:
        """A window of the centre's proof; the box has steps of its own."""
        asked = inside(self.times[len(self.rows) :], known.pieces.times[-1])
        self._state, rows, taken = zonotope.advance(self._state, known, asked)
        self.rows += rows
        self._derivatives.window(known, taken)
        self.steepness = max([self.steepness, *_steepness(known, taken)])

    def finish(self) -> None:
        """Nothing is left at the end."""

    def derivative(self) -> tuple[list[list[arb]], list[arb]]:
        """Balls around the entries at the last time, and the largest moduli of its columns."""
        if len(self._derivatives.found) != 1 or len(self.rows) != len(self.times):
            raise Refused("the enclosure did not reach the period")
        centre, radius = self._derivatives.found[0]
        rows = [
            [arb(x, r) for x, r in zip(*pair, strict=True)]
            for pair in zip(centre.tolist(), radius.tolist(), strict=True)
        ]
        return rows, [largest([row[j] for row in rows]) for j in range(6)]


def _steepness(known: Bounds, steps: Sequence[Step]) -> list[float]:
    problem, pieces = known.problem, known.pieces
    spread = zip(known.sigma, steps, strict=True)
    off = [math.ldexp(float(sigma) + step.r, -problem.noise) for sigma, step in spread]
    size = np.sum(np.abs(pieces.near) + pieces.gap[:, :, None], axis=1)
    size = UP * (size + np.array(off)[:, None]) + TINY
    matrices = np.abs(jacobian(problem, size[:, None, :], np.ones(len(size)))[:, 0])
    slack = max(problem.factor_slack) * (1.0 + size.max(axis=1))
    matrices = UP * (matrices + slack[:, None, None]) + TINY
    squares = matrices.sum(axis=1).max(axis=1) * matrices.sum(axis=2).max(axis=1)
    found: list[float] = (UP * np.sqrt(UP * squares)).tolist()
    return found


class Around(NamedTuple):
    """S: where motions are for a short time before and after; ``speed`` is above |f| there."""

    box: list[arb]
    speed: arb


def around(box: Balls, span: arb, level: LevelBalls) -> Around:
    """All that the motions through a box reach within +- span; raises Refused.

    S = box + [-span v, span v]**6 with |f| < v on S: no motion can leave it sooner.
    """
    speed = 2 * largest(level.field(box)) + arb((1, -100))
    for _ in range(_WIDENINGS):
        speed = speed.upper()
        wide = (span * speed).upper()
        found = [x + arb(0, wide) for x in box]
        if largest(level.field(found)) < speed:
            return Around(found, speed)
        speed = 2 * speed
    raise Refused("the motion near the period's end has no bound")


def spread_of_derivative(reached: Around, span: arb, level: LevelBalls) -> arb:
    """A bound of exp(span L) - 1, L >= |f'| on S in the max-norm; raises Refused."""
    x = span * row_sum(level.jacobian(reached.box))
    if not x <= 1:
        raise Refused("the period's box is too long")
    return (x + x * x).upper()


def exactly(x: int, bits: int) -> arb:
    """x·2**-bits, a ball of radius 0."""
    return arb((x, -bits))


def part(period: int, bits: int, by: int) -> arb:
    """A ball around a part of a period."""
    with ctx.workprec(TIME_BITS):
        return exactly(period, bits) / by
