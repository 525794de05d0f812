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
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_poly, fmpz

from polhode.enclosures.fixed_point_problem import CLOCK, UP, Problem
from polhode.enclosures.step_bound import TINY, Bounds
from polhode.enclosures.taylor_polynomials import (
    Pieces,
    improved,
    of_doubles,
    packing,
    size,
    words_of,
)
from polhode.enclosures.zonotope import Step
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Doubles
from polhode.numbers.vectors import quaternion_product

_ROOT_OF_3 = 1.7320508076  # above it
#: (sign, component of v, component of w) of the terms of each component of v (0, w).
PRODUCT = (
    ((-1, 1, 0), (-1, 2, 1), (-1, 3, 2)),
    ((1, 0, 0), (1, 2, 2), (-1, 3, 1)),
    ((1, 0, 1), (1, 3, 0), (-1, 1, 2)),
    ((1, 0, 2), (1, 1, 1), (-1, 2, 0)),
)

#: e' = A e - d from A, d and e(0), as ``approximation.forced``; may be wrong in any way.
Solution = Callable[[Doubles, Doubles, Doubles], Doubles]


class TurnBounds(NamedTuple):
    """The turns v of each step of a window, four polynomials each.

    ``near``: doubles of their coefficients, (W, count, 4), off by UNPACKED roundings; ``miss``:
    (W,), of the module's theorem.
    """

    pieces: Pieces
    near: Any
    miss: Any


class Turned:
    """The turn since the start as the steps of a proof go by."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.centre = (1 << problem.fine, 0, 0, 0)  # times 2**-fine
        self.radius = 0.0

    def at(self, turns: TurnBounds, n: int, tau: Any) -> tuple[Sequence[Any], float]:
        """The turn at tau in step n: the four balls of Q~ v(tau), and its distance from U."""
        with ctx.workprec(self.problem.noise + 104):
            unit = arb((1, -turns.pieces.level))
            v = [arb_poly(x)(tau) * unit for x in turns.pieces.polynomials(n)]
            before = [arb((x, -self.problem.fine)) for x in self.centre]
            return quaternion_product(before, v), self._after(float(turns.miss[n]))

    def step(self, turns: TurnBounds, n: int) -> None:
        """To the end of step n, the centre rounded to 2**-fine."""
        exact = quaternion_product(self.centre, turns.pieces.ends[n].tolist())
        level = turns.pieces.level
        half = 1 << (level - 1)
        self.centre = tuple((x + half) >> level for x in exact)  # off by 1/2 each, 1 in all
        lost = math.ldexp(1.0, self.problem.noise - self.problem.fine)
        self.radius = UP * (self._after(float(turns.miss[n])) + lost) + TINY

    def _after(self, miss: float) -> float:
        grown = 1.0 + UP * math.ldexp(self.radius, -self.problem.noise)
        return UP * (self.radius + grown * miss) + TINY


def turns(bounds: Bounds, steps: Sequence[Step], solution: Solution) -> TurnBounds:
    """The turns of a window whose steps have been accepted, with their errors.

    v is found by Newton's corrections, until they make the defect no smaller.
    """
    noise, old = bounds.problem.noise, bounds.pieces
    state = improved(old, bounds.correction, noise, max(bounds.problem.fine, old.level))
    parts = tuple((level, part[:, :3]) for level, part in state.parts)
    w = replace(state, parts=parts, near=state.near[:, :, :3])
    a = np.zeros((*w.near.shape[:2], 4, 4))
    for i, terms in enumerate(PRODUCT):
        for sign, j, k in terms:
            a[:, :, i, j] = 0.5 * sign * w.near[:, :, k] * w.lengths[:, None]
    begin = np.array([1.0, 0.0, 0.0, 0.0])
    v = of_doubles(w.times, solution(a, np.zeros((w.count, 0, 4)), begin), 4)
    least = math.inf
    while True:
        near, values, defect = defects(w, v, noise)
        largest = float(np.max(defect))
        if largest < 1.0 or not largest < 0.5 * least:
            break
        least = largest
        e = np.array(solution(a, values, np.zeros(4)))
        v = improved(v, e, noise, max(v.level, min(w.level, 53 - size(e, noise))))
    # w is within r of x~ + e, whose coefficients are rounded by half a unit of 2**-level each
    rounded = 0.5 * w.near.shape[1] * math.ldexp(1.0, noise - w.level)
    off = _ROOT_OF_3 * (np.array([step.r for step in steps]) + rounded)
    first = np.array([_start(row, v.level, noise) for row in v.starts.tolist()])
    return TurnBounds(v, near, UP * (first + defect + 0.5 * w.lengths * off) + TINY)


def _start(row: Sequence[int], level: int, noise: int) -> float:
    """A bound of |1 - v(0)|."""
    wrong = abs(row[0] - (1 << level)) + sum(map(abs, row[1:]))
    if not wrong:
        return 0.0
    with ctx.workprec(64):
        return UP * float((arb(wrong) * arb((1, noise - level))).abs_upper())


def defects(w: Pieces, v: Pieces, noise: int) -> tuple[Any, Any, Any]:
    """v as doubles, (W, K, 4), d of every step, (W, 2 K - 1, 4), and bounds of int |d|.

    Exact in integers, which are 2**(CLOCK + 1 + the levels of both) d, and then right to UNPACKED
    roundings, which UP holds.
    """
    used, terms = max(w.used, v.used), v.near.shape[1]
    largest = ((terms << (CLOCK + 1)) + 3 * v.longest) * v.most * w.most
    words = words_of(largest << (w.level + v.level))
    packs, shift = packing(used, words), w.level + CLOCK + 1
    turning, rates = v.packed(packs), w.packed(packs)
    numbers = []
    for n in range(w.count):
        length = fmpz(w.times[n + 1] - w.times[n])
        x, y = turning[4 * n : 4 * n + 4], rates[3 * n : 3 * n + 3]
        for i, row in enumerate(PRODUCT):
            integrand = sum((x[a] * y[b] * sign for sign, a, b in row), fmpz(0))
            numbers.append((packs.slope(x[i]) << shift) - integrand * length)
    power = np.full(len(turning), noise - v.level - shift)
    coefficients = packing(2 * used - 1, words).doubles(numbers, power)
    values = coefficients.reshape(w.count, 4, -1).transpose(0, 2, 1)
    near = packs.doubles(turning, np.full(len(turning), -v.level))
    sizes = np.sum(np.abs(values), axis=2)  # |.|_2 <= |.|_1
    weights = 1.0 / np.arange(1, values.shape[1] + 1)
    bound = UP * np.sum(sizes * weights, axis=1) + TINY
    return near.reshape(w.count, 4, -1).transpose(0, 2, 1), values, bound
