"""The turn of the body since the start, a unit quaternion, with a proven error.

Trusted.  U, the attitude at t after that at 0 in principal axes, obeys
U' = 1/2 U (0, w) with quaternion products, U(0) = 1.  On a step of length h let u' = h/2 u (0, w),
u(0) = 1, and let v be any four integer polynomials, d = v' - h/2 v (0, w~), |w - w~| <= m.  Then

    (u - v)' = h/2 (u - v) (0, w~) + h/2 u (0, w - w~) - d,

and since the first term is orthogonal to u - v and |u| = 1, in the Euclidean norm for all tau

    |u - v| <= |1 - v(0)| + int |d| + h m/2 =: miss.

Products of quaternions multiply norms: if Q~ is within R of U at the step's beginning, Q~ v(tau) is
within R + (1 + R) miss of U(tau).  Nothing grows but by what is added: no exponential enters.
Small quantities are in units of 2**-P.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_poly, fmpz, fmpz_poly

from polhode.enclosures.fixed_point_problem import CLOCK, UP, Problem, Refused
from polhode.enclosures.kronecker_substitution import floored
from polhode.enclosures.step_bound import TINY, Bounds
from polhode.enclosures.taylor_polynomials import Pieces, improved
from polhode.enclosures.zonotope import Step
from polhode.numbers.flint_context import ctx
from polhode.numbers.vectors import quaternion_product

_MOST_WIDTH = 10_000
_ROOT_OF_3 = 1.7320508076  # above it
#: (sign, component of v, component of w) of the terms of each component of v (0, w).
PRODUCT = (
    ((-1, 1, 0), (-1, 2, 1), (-1, 3, 2)),
    ((1, 0, 0), (1, 2, 2), (-1, 3, 1)),
    ((1, 0, 1), (1, 3, 0), (-1, 1, 2)),
    ((1, 0, 2), (1, 1, 1), (-1, 2, 0)),
)


class Turns(NamedTuple):
    """The turns v of each step of a window: W rows of four integer polynomials times 2**-level.

    ``miss``: (W,), of the module's theorem.
    """

    rows: Sequence[Sequence[Any]]
    level: int
    miss: Any


#: Turns of a window from w~; may be wrong in any way.
Approximation = Callable[[Pieces, int], tuple[Sequence[Sequence[Any]], int]]


class Turned:
    """The turn since the start as the steps of a proof go by."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.centre = (fmpz(1) << problem.fine, fmpz(0), fmpz(0), fmpz(0))  # times 2**-fine
        self.radius = 0.0

    def at(self, turns: Turns, n: int, tau: Any) -> tuple[Sequence[Any], float]:
        """The turn at tau in step n: the four balls of Q~ v(tau), and its distance from U."""
        with ctx.workprec(self.problem.noise + 104):
            unit = arb((1, -turns.level))
            v = [arb_poly(x)(tau) * unit for x in turns.rows[n]]
            before = [arb((int(x), -self.problem.fine)) for x in self.centre]
            return quaternion_product(before, v), self._after(float(turns.miss[n]))

    def step(self, turns: Turns, n: int) -> None:
        """To the end of step n, the centre rounded to 2**-fine."""
        exact = quaternion_product(self.centre, [x(1) for x in turns.rows[n]])
        half = fmpz(1) << (turns.level - 1)
        self.centre = tuple((x + half) >> turns.level for x in exact)  # off by 1/2 each, 1 in all
        lost = math.ldexp(1.0, self.problem.noise - self.problem.fine)
        self.radius = UP * (self._after(float(turns.miss[n])) + lost) + TINY

    def _after(self, miss: float) -> float:
        grown = 1.0 + UP * math.ldexp(self.radius, -self.problem.noise)
        return UP * (self.radius + grown * miss) + TINY


def turns(known: Bounds, steps: Sequence[Step], approximate: Approximation) -> Turns:
    """The turns of a window whose steps have been accepted, with their errors."""
    problem, old = known.problem, known.pieces
    level = max(problem.fine, old.level)
    sharp = improved(old, known.correction, problem.noise, level)
    made, level = approximate(sharp.copy(), problem.noise)
    fine = int(level)
    rows = [[fmpz_poly(x) for x in row] for row in made]  # who made them may change them
    if len(rows) != sharp.count or any(len(row) != 4 for row in rows):
        raise Refused("an approximation does not fit")
    _, defect = defects(sharp, rows, fine, problem.noise)
    # w is within r of x~ + e, whose coefficients are rounded by half a unit of 2**-level each
    rounded = 0.5 * old.near.shape[1] * math.ldexp(1.0, problem.noise - level)
    off = _ROOT_OF_3 * (np.array([step.r for step in steps]) + rounded)
    begin = np.array([_start(row, fine, problem.noise) for row in rows])
    miss = UP * (begin + defect + 0.5 * sharp.lengths * off) + TINY
    return Turns(rows, fine, miss)


def _start(row: Sequence[Any], level: int, noise: int) -> float:
    """A bound of |1 - v(0)|."""
    wrong = [abs(int(x[0]) - ((1 << level) if k == 0 else 0)) for k, x in enumerate(row)]
    if not any(wrong):
        return 0.0
    with ctx.workprec(64):
        return UP * float((arb(sum(wrong)) * arb((1, noise - level))).abs_upper())


def defects(sharp: Pieces, rows: Sequence[Any], level: int, noise: int) -> tuple[Any, Any]:
    """d of every step as doubles, (W, K, 4), and bounds of int |d|, exact in integers first."""
    shift = fmpz(1) << (sharp.level + CLOCK + 1)
    width = 2 * sharp.near.shape[1] - 1
    table = np.zeros((sharp.count, 4, width), dtype=np.int64)
    powers = np.zeros((sharp.count, 4), dtype=np.int64)
    for n, (v, w) in enumerate(zip(rows, sharp.rows, strict=True)):
        length = fmpz(sharp.times[n + 1] - sharp.times[n])
        for i, terms in enumerate(PRODUCT):
            turned = fmpz_poly([])
            for sign, a, b in terms:
                turned += v[a] * w[b] * sign
            found, bits = floored(v[i].derivative() * shift - turned * length)
            table[n, i, : len(found)] = found
            powers[n, i] = bits + noise - level - sharp.level - CLOCK - 1
    values = np.ldexp(table.astype(float), powers[:, :, None])
    weights = 1.0 / np.arange(1, width + 1)
    sizes = np.sum(np.abs(values), axis=1)  # |.|_2 <= |.|_1
    # UP holds what the floors take too: less than 1 a coefficient of a row whose largest, if any
    # was taken, is 2**59 at least, and has the weight 1/width at least: width**2/2**59 < 1e-9
    if width > _MOST_WIDTH:
        raise Refused("the polynomials are too long")
    return values.transpose(0, 2, 1), UP * np.sum(sizes * weights, axis=1) + TINY
