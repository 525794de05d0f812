"""The derivative of the flow along a proved motion: the truth is in its balls."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

import polhode
from polhode.enclosures import fixed_point_problem, proof_loop
from polhode.enclosures.proof_loop import SHORT_STEPS
from polhode.enclosures.variations import variational_bound
from polhode.enclosures.variations.variational_bound import Derivatives
from shared import orbit_newton
from shared.mutation import without

CHAOTIC = polhode.load("general/asymmetric-chaotic")


def body_of(scene):
    return list(scene.body.moments), list(scene.body.axes.components(scene.body.torque))


@cache
def truth_at(time):
    return orbit_newton.derivative(*body_of(CHAOTIC), [*CHAOTIC.omega, *CHAOTIC.gamma], time)


def altered(first):
    """The honest matrices but for one number of V_1, or of V_0, of one step."""

    def matrices(a):
        found = SHORT_STEPS.matrices(a)
        found[min(2, len(found) - 1), 0 if first else 1, 3, 1] += 1e-6
        return found

    return replace(SHORT_STEPS, matrices=matrices)


#: V = 0: all that is known of the derivative is its bound.
ZEROED = replace(SHORT_STEPS, matrices=lambda a: 0.0 * SHORT_STEPS.matrices(a))


def derivative_off(untrusted, time):
    """The largest |truth - middle|/radius with faulty matrices."""
    what = fixed_point_problem.motion(CHAOTIC, unit=0)
    problem = fixed_point_problem.problem(what, 110)
    times = fixed_point_problem.times(what, [time])
    watch = Derivatives(times)
    proof_loop.run(problem, times, untrusted=untrusted, watchers=[watch])
    exact = np.array([[float(x) for x in row] for row in truth_at(time)])
    return float(np.max(np.abs(exact - watch.found[0].centre) / watch.found[0].radius))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("untrusted", "least"), [(altered(False), 1e-4), (altered(True), 1e-4), (ZEROED, 0)]
)
def test_faulty_matrices_widen_the_balls(untrusted, least):
    assert least < derivative_off(untrusted, Fraction(2)) <= 1


#: The term, and how it is dropped; a fault in V shows each.
DROPPED = {
    "rho": (variational_bound, "missed", "float(known.rho[n])", "0.0"),
    "the error that the next error multiplies": (
        variational_bound,
        "Product.noise",
        "np.max(error, axis=0)",
        "0.0",
    ),
    "eps in the weights": (variational_bound, "Product.noise", "eps * size", "0.0 * size"),
    "weights when settled": (variational_bound, "Product.settle", "UP * box + TINY", "0.0 * box"),
    "settled ones at an output": (
        variational_bound,
        "Product.at",
        "carried + recent",
        "0.0 * carried + recent",
    ),
    "born ones at an output": (
        variational_bound,
        "Product.at",
        "carried + recent",
        "carried + 0.0 * recent",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("term", DROPPED)
def test_a_dropped_term_is_noticed(term):
    # 24 steps are settled: the fault is before them, or just before the output
    time = Fraction(9) if "settled" in term else Fraction(2)
    untrusted = ZEROED if "next error" in term else altered(False)
    with without(*DROPPED[term]):
        assert derivative_off(untrusted, time) > 1
