"""The set that holds the error, carried from step to step; states at any time.

Trusted.  At the grid time t_n the exact state minus the approximation's end is

    z_n in { T G xi + H eta : |xi_i| <= 1, |eta_i| <= 1 },

G the columns as they were last settled, T the product of the V since, H the columns born since.
J_n = xhat_{n-1}(1) - xhat_n(0) is the jump of the approximation, so the step's z(0) is z_n + J_n,
and by the theorem of one step (``step_bound``)

    z_{n+1} in V (z_n + J_n) + [-s, s]**6.

T <- fl(V T) and H <- [fl(V H) | diag(b)] hold that, with

    b = s + |V| (|J_n| + gamma(7) (|T| |G|1 + |H|1)),

since an entry of a product of matrices of six rows is off by at most gamma(6) times the product of
absolute values.  After SETTLED steps G <- [fl(T G) | diag(|H|1 + gamma(7) |T| |G|1)], T <- I, H is
emptied: columns are kept and nothing is turned into new axes, so nothing is wrapped.

A step is accepted if r = 2 g (eps + delta + 2 h beta sigma**2) + tiny has
8 g h beta r <= 1: then the theorem's inequality holds, (sigma + r)**2 being at most
2 sigma**2 + 2 r**2.  Quantities are in units of 2**-P, so h beta stands times 2**-P.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_poly

from polhode.common.interrupts import NONE, Deadline
from polhode.enclosures.fixed_point_problem import (
    CLOCK,
    TIME_BITS,
    UP,
    Problem,
    TooImprecise,
    upper,
)
from polhode.enclosures.step_bound import TINY, Bounds, gamma
from polhode.enclosures.taylor_polynomials import difference, gaps
from polhode.numbers.flint_context import ctx

SETTLED = 24
MOST_COLUMNS = 80_000  # sums of more would need more than UP for their rounding
_IDENTITY = np.eye(6)


class Step(NamedTuple):
    """A step that was accepted: |z| <= r on it, and s of the theorem."""

    r: float
    s: float


@dataclass(frozen=True)
class ProofState:
    """Where a proof stands: at ``time`` (times 2**-CLOCK) the exact state is in ``centre`` + set.

    ``centre``: six integers times 2**-fine; ``columns``: G, (6, N), in units of 2**-noise.
    """

    time: int
    centre: tuple[int, ...]
    columns: Any

    @property
    def radii(self) -> Any:
        """Bounds of the set's components, (6,), in units of 2**-noise."""
        return UP * np.sum(np.abs(self.columns), axis=1) + TINY


def beginning(problem: Problem) -> ProofState:
    """The start of the motion, with the radii of its rounding."""
    return ProofState(0, problem.start, np.diag(problem.spread))


def advance(
    state: ProofState, bounds: Bounds, times: Sequence[Any], deadline: Deadline = NONE
) -> tuple[ProofState, list[list[Any]], list[Step]]:
    """Carry the set through a window's steps; balls at the times asked for, and the steps.

    ``times``: balls around times inside the window, increasing.  Raises TooImprecise where a step
    fails its test, TooLong at the deadline; nothing of the window is then to be used.
    """
    problem, pieces = bounds.problem, bounds.pieces
    if pieces.times[0] != state.time:
        raise TooImprecise("a window does not begin where the last one ended")
    jumps = _jumps(state, bounds)
    hbs = UP * pieces.lengths * problem.beta * math.ldexp(1.0, -problem.noise) + TINY
    carried = _Carried(state.columns)
    rows: list[list[Any]] = []
    steps: list[Step] = []
    with ctx.workprec(TIME_BITS):
        where = places(pieces.times, times)
    for n in range(pieces.count):
        hull = carried.hull()
        jump = jumps[n]
        eps = UP * (float(np.max(hull)) + float(np.max(jump)))
        step = _accepted(bounds, n, eps, float(hbs[n]))
        steps.append(step)
        if taus := where.get(n):
            deadline.check()
            rows += _balls(bounds, n, taus, carried, jump, hull, eps, step)
        carried.step(bounds.ends[n], jump, hull, step.s)
    centre, rest = _centre(bounds)
    carried.settle(rest)
    return ProofState(pieces.times[-1], centre, carried.settled), rows, steps


class _Carried:
    """T, G and H of the module's set while a window is walked through."""

    def __init__(self, columns: Any) -> None:
        self.settled = columns
        self.base = UP * np.sum(np.abs(columns), axis=1) + TINY  # |G|1
        self.turn = _IDENTITY
        self.born = np.zeros((6, 6 * SETTLED))
        self.count = 0

    def hull(self) -> Any:
        """|T| |G|1 + |H|1, rounded up: bounds of the components."""
        recent = np.sum(np.abs(self.born[:, : self.count]), axis=1)
        return UP * (np.abs(self.turn) @ self.base + recent) + TINY

    def step(self, v: Any, jump: Any, hull: Any, s: float) -> None:
        """z <- V (z + J) + [-s, s]**6."""
        noise = UP * (s + np.abs(v) @ (jump + gamma(7) * hull)) + TINY
        self.turn = v @ self.turn
        count = self.count
        self.born[:, :count] = v @ self.born[:, :count]
        self.born[:, count : count + 6] = np.diag(noise)
        self.count = count + 6
        if self.count == self.born.shape[1]:
            self.settle(0.0)
            if self.settled.shape[1] > MOST_COLUMNS:
                raise TooImprecise("the set has too many columns")

    def settle(self, rest: Any) -> None:
        """G <- [fl(T G) | box], the box holding H, what rounding lost and ``rest``."""
        recent = np.sum(np.abs(self.born[:, : self.count]), axis=1)
        box = recent + gamma(7) * (np.abs(self.turn) @ self.base) + rest
        self.settled = np.hstack([self.turn @ self.settled, np.diag(UP * box + TINY)])
        self.base = UP * np.sum(np.abs(self.settled), axis=1) + TINY
        self.turn = _IDENTITY
        self.count = 0


def _accepted(bounds: Bounds, n: int, eps: float, hb: float) -> Step:
    """The test of the step theorem; raises TooImprecise.  A number that is none fails it."""
    growth, delta = float(bounds.growth[n]), float(bounds.delta[n])
    sigma, rho = float(bounds.sigma[n]), float(bounds.rho[n])
    r = UP * 2.0 * growth * (eps + delta + 2.0 * hb * sigma * sigma) + TINY
    if not 8.0 * growth * hb * r <= 0.999 or not sigma + r < 1e150:  # whose square is a number
        raise TooImprecise("the set has grown too large for the next step")
    for _ in range(1 + bounds.problem.is_box):  # an r that (2) gives makes another s; see there
        s = UP * (growth * (delta + hb * (sigma + r) ** 2) + rho * eps) + TINY
        if not s < 1e300:
            raise TooImprecise("the error of a step has no bound")
        r = min(r, UP * (float(bounds.sizes[n]) * eps + s) + TINY)
    return Step(r, s)


def _jumps(state: ProofState, bounds: Bounds) -> Any:
    """Bounds of |J_n|, (W, 6): exact integer parts, and the corrections at both ends."""
    e = bounds.correction
    ends, sizes = np.sum(e, axis=1), np.sum(np.abs(e), axis=1)
    whole = gaps(bounds.problem, bounds.pieces, state.centre)
    before = np.vstack([np.zeros((1, 6)), ends[:-1]])
    rounding = np.vstack([np.zeros((1, 6)), sizes[:-1]]) + np.abs(e[:, 0]) + np.abs(whole)
    return UP * (np.abs(whole + before - e[:, 0]) + _lost(bounds) * rounding) + TINY


def _lost(bounds: Bounds) -> float:
    """The relative rounding of a sum of a correction's coefficients."""
    return gamma(bounds.correction.shape[1] + bounds.matrices.shape[1] + 40)


def _centre(bounds: Bounds) -> tuple[tuple[int, ...], Any]:
    """The approximation's end rounded to 2**-fine, and bounds of what that leaves, (6,)."""
    level, fine, noise = bounds.pieces.level, bounds.problem.fine, bounds.problem.noise
    ends = np.sum(bounds.correction[-1], axis=0)
    sizes = np.sum(np.abs(bounds.correction[-1]), axis=0)
    end = bounds.pieces.ends[-1]
    moved = [round(math.ldexp(x, fine - noise)) for x in ends.tolist()]
    centre = ((end << max(0, fine - level)) >> max(0, level - fine)) + np.array(moved, dtype=object)
    exact = difference(end, level, centre, fine, noise).astype(float)
    rest = UP * (np.abs(exact + ends) + _lost(bounds) * (sizes + np.abs(exact)))
    return tuple(centre.tolist()), rest + TINY


def inside(times: Sequence[Any], end: int) -> list[Any]:
    """Those of the times that come before the end of a window."""
    with ctx.workprec(TIME_BITS):
        return [*takewhile(lambda t: t * arb((1, CLOCK)) <= end, times)]


def places(times: Sequence[int], times_asked: Sequence[Any]) -> dict[int, list[Any]]:
    """The times as tau in the steps that hold their balls, by step; raises TooImprecise outside."""
    by_step: dict[int, list[Any]] = {}
    n = 0
    for t in times_asked:
        ticks = t * arb((1, CLOCK))  # exact
        while n + 1 < len(times) - 1 and ticks > times[n + 1]:
            n += 1
        if not (times[n] <= ticks.lower() and ticks.upper() <= times[n + 1]):
            raise TooImprecise("a time asked for is not inside a step")
        tau = (ticks - times[n]) / (times[n + 1] - times[n])
        by_step.setdefault(n, []).append(tau)
    return by_step


def _balls(
    bounds: Bounds,
    n: int,
    taus: Sequence[Any],
    carried: _Carried,
    jump: Any,
    hull: Any,
    eps: float,
    step: Step,
) -> list[list[Any]]:
    """Six balls around the exact state at each tau in step n, by (2) of ``step_bound``."""
    v = bounds.matrices[n]
    terms = v.shape[0]
    near = np.array([float(tau.mid()) for tau in taus])
    with ctx.workprec(64):
        off = np.array([upper(tau - arb(x)) for tau, x in zip(taus, near.tolist(), strict=True)])
    powers = np.cumprod(
        np.hstack([np.ones((len(near), 1)), *[near[:, None]] * (terms - 1)]), axis=1
    )
    w = np.tensordot(powers, v, axes=1)
    radii = np.sum(np.abs(w @ carried.turn @ carried.settled), axis=2)
    radii = radii + np.sum(np.abs(w @ carried.born[:, : carried.count]), axis=2)
    radii = radii + np.abs(w) @ (jump + gamma(16) * hull)
    lost = gamma(2 * terms + 6) + UP * terms * off  # |V(tau) - V(near)| <= sum k |V_k| off
    radii = UP * (radii + step.s + (lost * float(bounds.sizes[n]) * eps)[:, None]) + TINY
    noise = bounds.problem.noise
    with ctx.workprec(noise + 104):
        centre = approximation(bounds, n)
        return [widened(centre, *at, noise) for at in zip(taus, radii.tolist(), strict=True)]


def approximation(bounds: Bounds, n: int) -> list[arb_poly]:
    """The polynomials of step n, corrections added to them, to the working precision."""
    pieces = bounds.pieces
    unit, level = arb((1, -bounds.problem.noise)), arb((1, -pieces.level))
    return [
        arb_poly(x) * level + arb_poly([arb(float(c)) for c in bounds.correction[n, :, i]]) * unit
        for i, x in enumerate(pieces.polynomials(n))
    ]


def widened(
    polynomials: Sequence[arb_poly], tau: arb, radii: Sequence[float], noise: int
) -> list[arb]:
    """The values at tau as balls, widened by radii in units of 2**-noise."""
    unit = arb((1, -noise))
    return [p(tau) + arb(0, float(r)) * unit for p, r in zip(polynomials, radii, strict=True)]
