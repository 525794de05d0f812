"""The first integrals shrink the set: a set-valued Kalman step.

Trusted.  H_i(x) = c_i along the exact motion.  With y the centre, e = x - y, |e| <= eps, and g_i
doubles near grad H_i(y), Taylor's theorem gives g_i · e = c_i - H_i(y) +- w_i with

    w_i = |g_i - grad H_i(y)|_1 eps + eps**2/2 sup sum_jl |H_i,jl| + the radius of c_i - H_i(y),

the supremum over |x - y| <= eps.  So for any 6 x k matrix K, with g of columns g_i,

    e = (I - K g^T) e + K (c - H(y)) +- |K| w.

K = G G^T g (g^T G G^T g)**-1 is not trusted; the result is kept only if its radii have a
smaller sum.  That grad H · f vanishes identically is decided on polynomials with rational
coefficients; h, f and |gamma|**2 are conserved for any body and are used with irrational data too.
Where |c_i - H_i(y)| exceeds what the set allows, the proof contradicts itself and an error is
raised.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from flint import arb

from polhode.enclosures.fixed_point_problem import UP, ExactMotion, Problem, upper
from polhode.enclosures.polynomial import (
    BallPolynomial,
    Polynomial,
    constant,
    rate,
    total,
    variable,
)
from polhode.enclosures.step_bound import TINY, gamma
from polhode.enclosures.zonotope import ProofState
from polhode.equations.integrals import AREA, ENERGY, KOVALEVSKAYA, LENGTH, MOMENTUM
from polhode.equations.integrals import first_integrals as integrals_of
from polhode.numbers.flint_context import ctx
from polhode.numbers.vectors import dot


class Contradiction(AssertionError):
    """The enclosure and a first integral exclude each other: polhode is at fault, not the input."""


class Integral(NamedTuple):
    """One first integral, ready for evaluation: itself, its gradient, second derivatives, value."""

    name: str
    value: Any
    at: BallPolynomial
    gradient: tuple[BallPolynomial, ...]
    second: tuple[BallPolynomial, ...]


def first_integrals(motion: ExactMotion) -> dict[str, Polynomial]:
    """The first integrals that the motion is proven to have, by name."""
    x, nothing = [variable(i) for i in range(6)], Polynomial({})
    formulas = integrals_of(motion.inside)
    k = {name: constant(value) for name, value in formulas.coefficients.items()}
    state = x[:3] if motion.inside.gamma is None else x
    named = dict(zip(formulas.onto, formulas.values(state, k, nothing), strict=True))
    proven = {name: named[name] for name in (ENERGY, AREA, LENGTH) if name in named}
    if all(row.rational for row in motion.field):
        momentum = [x[i] * k[f"I{i}"] for i in range(3)]
        candidates = {MOMENTUM: dot(momentum, momentum), **dict(zip("pqr", x, strict=False))}
        candidates["w.k"] = total([x[i] * k.get(f"2m{i}", nothing) for i in range(3)])
        candidates[KOVALEVSKAYA] = named.get(KOVALEVSKAYA, nothing)
        for name, candidate in candidates.items():
            if candidate.terms and not rate(candidate, motion.field).terms:
                proven[name] = candidate
    return proven


def prepared(motion: ExactMotion, bits: int) -> list[Integral]:
    """The first integrals with balls for their coefficients and values, to so many bits."""
    integrals = []
    with ctx.workprec(bits):
        start = motion.starts(bits)
        for name, h in first_integrals(motion).items():
            gradient = [h.derivative(i) for i in range(6)]
            second = [row.derivative(i) for row in gradient for i in range(6)]
            whole, slopes = h.balls(bits), tuple(p.balls(bits) for p in gradient)
            bends = tuple(p.balls(bits) for p in second if p.terms)
            integrals.append(Integral(name, whole.at(start), whole, slopes, bends))
    return integrals


def shrunk(problem: Problem, state: ProofState, integrals: Sequence[Integral]) -> ProofState:
    """The state with a set made smaller by the first integrals, or as it is.

    Raises Contradiction where no point of the set has their values.
    """
    if not integrals:
        return state
    radii = state.radii
    eps = float(np.max(radii))
    g, rest, width = _measured(problem, state, integrals, eps)
    reach = np.abs(g).T @ radii
    for integral, missing, allowed in zip(integrals, rest, UP * (reach + width), strict=True):
        if abs(missing) > allowed + TINY:
            raise Contradiction(f"the integral {integral.name} is not kept by its enclosure")
    gain = _gain(state.columns, g)
    if gain is None or not (np.all(np.isfinite(gain)) and np.all(np.isfinite(width))):
        return state
    size = np.abs(gain)
    columns = (np.eye(6) - gain @ g.T) @ state.columns
    rounding = size @ (np.abs(g).T @ radii) + radii + size @ np.abs(rest)
    ticks = np.ldexp(gain @ rest, problem.fine - problem.noise)
    if not np.all(np.abs(ticks) < 2.0**900):
        return state
    centre = tuple(x + round(by) for x, by in zip(state.centre, ticks.tolist(), strict=True))
    left = math.ldexp(1.0, problem.noise - problem.fine)
    lost = gamma(g.shape[1] + 8) * rounding  # products of k, then a difference and products of 6
    box = UP * (size @ width + lost + left) + TINY
    smaller = ProofState(state.time, centre, np.hstack([columns, np.diag(box)]))
    return smaller if np.sum(smaller.radii) < np.sum(radii) else state


def _measured(
    problem: Problem, state: ProofState, integrals: Sequence[Integral], eps: float
) -> tuple[Any, Any, Any]:
    """g, (6, k), the midpoints of c - H(y) in units of 2**-P, and w."""
    g = np.zeros((6, len(integrals)))
    rest, width = np.zeros(len(integrals)), np.zeros(len(integrals))
    scale = arb((1, problem.noise))
    with ctx.workprec(2 * problem.fine + 100):
        y = [arb((x, -problem.fine)) for x in state.centre]
        around = [x + arb(0, eps) / scale for x in y]
        for k, integral in enumerate(integrals):
            off = 0.0
            for i, row in enumerate(integral.gradient):
                slope = row.at(y)
                g[i, k] = float(slope.mid())
                off += upper(slope - arb(float(g[i, k])))
            missing = (integral.value - integral.at.at(y)) * scale
            rest[k] = float(missing.mid())
            curved = sum(upper(row.at(around)) for row in integral.second)
            width[k] = UP * (
                off * eps
                + 0.5 * eps * curved * upper(arb(eps) / scale)
                + upper(missing - arb(float(rest[k])))
            )
    return g, rest, width


def _gain(columns: Any, g: Any) -> Any:
    """K = G G^T g (g^T G G^T g)**-1, columns scaled for the inverse; None where there is none."""
    size = float(np.max(np.abs(columns)))
    if not 0.0 < size < math.inf:
        return None
    spread = (columns / size).T @ g
    try:
        inverse = np.linalg.pinv(spread.T @ spread, rcond=1e-12)
    except np.linalg.LinAlgError:
        return None
    return (columns / size) @ spread @ inverse
