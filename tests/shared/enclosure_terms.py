"""Motions in which one term of a step's bound outweighs all others, so that dropping it shows.

Each function returns |truth - midpoint|/radius of the components that matter: never above 1, and
of the order of 1, because a term that is merely there is no evidence that it is needed.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb

from polhode.enclosures import (
    approximation,
    fixed_point_problem,
    integral_contraction,
    step_bound,
    taylor_polynomials,
    zonotope,
)
from polhode.enclosures.fixed_point_problem import CLOCK, Problem
from polhode.enclosures.task import Untrusted, run
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared.enclosure_trials import ratios, trial
from shared.motions import asymmetric

NOISE = 79


def sphere(rate: str = "1", gamma: Any = None) -> Scene:
    """A free sphere: w stays as it is."""
    return Scene(Body.of_moments((1, 1, 1)), (Fraction(rate), Fraction(0), Fraction(0)), gamma)


def generic() -> Scene:
    """An asymmetric heavy top."""
    return asymmetric("0.9")


def short_steps(*given: Any) -> Any:
    """An honest approximation on steps so short that exp(alpha) is near 1."""
    from polhode.enclosures import approximation

    return approximation.window(*given, turn=0.05)


def of_faulty(scene: Scene, untrusted: Untrusted, **changes: Any) -> list[float]:
    """The ratios of w in a proof whose untrusted parts are these, at t = 5 of its unit."""
    what = trial(scene, [Fraction(5)], 300)
    problem = replace(fixed_point_problem.problem(what.motion, NOISE), **changes)
    proof = run(problem, [fixed_point_problem.ball(t, 300) for t in what.times], (), untrusted)
    return ratios([row[:3] for row in proof.rows], [row[:3] for row in what.states])


def residual() -> list[float]:
    """int |d + e' - A e|: the correction drifts away from the motion without a jump."""

    def drifting(a: Any, defects: Any, v: Any, gaps: Any) -> Any:
        found = approximation.correction(a, defects, v, gaps)
        found[:, 0, 0] += 1e6 * np.arange(len(found))
        found[:, 1, 0] += 1e6
        return found

    return of_faulty(sphere(), Untrusted(window=short_steps, correction=drifting))


def jumps() -> list[float]:
    """|J_n|: the correction moves away in jumps; what is constant leaves no residual."""

    def jumping(a: Any, defects: Any, v: Any, gaps: Any) -> Any:
        found = approximation.correction(a, defects, v, gaps)
        found[:, 0, 0] += 1e6 * np.arange(1, len(found) + 1)
        return found

    return of_faulty(sphere(), Untrusted(window=short_steps, correction=jumping))


def start_box() -> list[float]:
    """The start's radii: the truth at a corner of the box."""
    worst: list[float] = []
    for signs in itertools.product((-1, 1), repeat=3):
        what = trial(generic(), [Fraction(5)], 300)
        problem = fixed_point_problem.problem(what.motion, 96)
        ticks = (1 << 20) << (problem.fine - problem.noise)
        corner = [*signs, 1, -1, 1]
        start = tuple(x + s * ticks for x, s in zip(problem.start, corner, strict=True))
        spread = tuple(2.0**20 * (1 + 1e-12) + r for r in problem.spread)
        problem = replace(problem, start=start, spread=spread)
        proof = run(problem, [fixed_point_problem.ball(t, 300) for t in what.times])
        worst.append(max(ratios(proof.rows, what.states)))
    return worst


def one_step(problem: Problem, length: int, moved: Any) -> tuple[Any, Any]:
    """A state after one step whose polynomial is wrong by ``moved`` (6,), corrected once."""
    from polhode.enclosures import approximation

    state = zonotope.beginning(problem)
    centre = tuple(
        x + (int(by * 2.0**40) << (problem.fine - 40))
        for x, by in zip(state.centre, moved, strict=True)
    )
    false = replace(state, centre=centre)
    found = approximation.window(problem, false, length, 1, 1.0)
    shape = taylor_polynomials.of_doubles(found.times, found.series)
    a = step_bound.jacobian(problem, shape.near, shape.lengths)
    matrices = approximation.matrices(a)
    known = taylor_polynomials.defects(problem, shape)
    gaps = taylor_polynomials.gaps(problem, shape, state.centre)
    e = approximation.correction(a, known.values, matrices, gaps)
    bounds = step_bound.bounds(problem, known, e, matrices)
    end = arb((length, -CLOCK))
    after, rows, _ = zonotope.advance(state, bounds, [end])
    return after, rows


def quadratic() -> list[float]:
    """h beta sigma**2: a polynomial wrong by 1e-6, whose correction is as large and linear."""
    worst = []
    for signs in ((1, 1, 1, 1, 1, 1), (1, -1, 1, 1, 1, -1), (-1, 1, 1, -1, 1, 1)):
        length = 1 << (CLOCK - 2)
        what = trial(generic(), [Fraction(1, 4)], 300)
        problem = fixed_point_problem.problem(what.motion, 60)
        _, rows = one_step(problem, length, [s * 2.0**-20 for s in signs])
        worst.append(max(ratios(rows, what.states)))
    return worst


def rounding() -> list[float]:
    """What is left where the next start is rounded: a correction that drifts by half a tick."""

    def single(problem: Any, state: Any, end: int, steps: int, pace: float) -> Any:
        return short_steps(problem, state, end, 1, pace)

    def drifting(a: Any, defects: Any, v: Any, gaps: Any) -> Any:
        found = approximation.correction(a, defects, v, gaps)
        found[:, 1, 0] += 0.51 * 2.0**-12  # a tick is 2**-(P + 12)
        return found

    return of_faulty(sphere(), Untrusted(window=single, correction=drifting))


def integrals() -> list[float]:
    """w of the first integrals: |gamma|**2 is curved, with the truth at the corners of a box."""
    worst = []
    truth = (*[Fraction(0)] * 3, Fraction(2, 15), Fraction(5, 15), Fraction(14, 15))
    motion = fixed_point_problem.motion(Scene(Body.of_moments((1, 1, 1)), truth[:3], truth[3:]))
    problem = fixed_point_problem.problem(motion, 96)
    known = [i for i in integral_contraction.prepared(motion, 400) if i.name == "|gamma|^2"]
    radius = 2.0 ** (problem.noise - 20)
    for signs in itertools.product((-1, 1), repeat=3):
        centre = list(problem.start)
        for k, s in enumerate(signs):
            centre[3 + k] += s * (1 << (problem.fine - 20))
        columns = np.diag([1.0, 1.0, 1.0, *(radius + r for r in problem.spread[3:])])
        state = zonotope.State(0, tuple(centre), columns)
        after = integral_contraction.shrunk(problem, state, known)
        assert after is not state
        for x, y, r in zip(truth[3:], after.centre[3:], after.radii[3:], strict=True):
            off = abs(x - Fraction(y, 1 << problem.fine)) * 2**problem.noise
            worst.append(float(off / Fraction(float(r))))
    return worst
