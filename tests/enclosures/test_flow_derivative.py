"""The derivative of the flow along a proved motion: the truth is in its balls."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

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


@pytest.mark.slow
def test_it_holds_what_an_integration_in_plain_mpmath_gives():
    time = Fraction(7, 2)
    found = polhode.certify(CHAOTIC, at=[time], digits=20, derivatives=True)
    state = [*CHAOTIC.omega, *CHAOTIC.gamma]
    truth = orbit_newton.derivative(*body_of(CHAOTIC), state, time)
    (matrix,) = found.derivatives.matrices
    off = [
        float(abs(x - y) / Fraction(r))
        for row, centres, radii in zip(truth, matrix.centres, matrix.radii, strict=True)
        for x, y, r in zip(row, centres, radii, strict=True)
    ]
    assert 1e-8 < max(off) <= 1  # slack by less than 1e8, since doubles are
    assert max(map(max, matrix.radii)) < 1e-9


SCENES = ["grioli/turned-axes", "euler/backward", "euler/tiny-units", "lagrange/negative-weight"]


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", SCENES)
def test_axes_units_and_the_sign_of_time_are_those_of_the_scene(name):
    """Against differences of proven states."""
    scene = polhode.load(name)
    time = next(t for t in scene.times if t)
    found = polhode.certify(scene, at=[time], digits=20, derivatives=True)
    (matrix,) = found.derivatives.matrices
    unit = Fraction(found.derivatives.unit)
    for k in range(3):
        step = unit / 10**12
        ends = []
        for side in (1, -1):
            omega = list(scene.omega)
            omega[k] += side * step
            moved = replace(scene, omega=tuple(omega))
            ends.append(polhode.certify(moved, at=[time], digits=36).centres[0])
        scales = [unit] * 3 + [Fraction(1)] * 3
        for i, (a, b) in enumerate(zip(*ends, strict=True)):
            slope = (a - b) / (2 * step)
            off = abs(slope - matrix.centres[i][k]) * unit / scales[i]
            allowed = Fraction(matrix.radii[i][k]) * unit / scales[i]
            assert off <= allowed + Fraction(1, 10**18)
            assert allowed < 1e-5


def test_amplification_and_exponent_are_bounds():
    found = polhode.certify(CHAOTIC, at=[5, 10, -3], digits=15, derivatives=True).derivatives
    for t, matrix, (low, high), exponent in zip(
        found.times, found.matrices, found.amplification, found.exponents, strict=True
    ):
        scale = np.array([found.unit] * 3 + [1.0] * 3)
        middle = np.array([[float(x) for x in row] for row in matrix.centres])
        about = np.linalg.norm(middle * scale / scale[:, None], 2)
        assert low <= about * (1 + 1e-12)
        assert high >= about * (1 - 1e-12)
        assert high < 1.01 * low
        assert exponent[0] <= np.log(about) / abs(float(t)) <= exponent[1]


def test_a_body_without_gamma_has_three_rows():
    found = polhode.certify("euler/no-gamma", at=[0, 1], derivatives=True)
    assert [len(m.centres) for m in found.derivatives.matrices] == [3, 3]
    start = found.derivatives.matrices[0]
    assert np.max(np.abs(np.array(start.centres, dtype=float) - np.eye(3))) < 1e-12
    assert polhode.certify("euler/no-gamma", at=[1]).derivatives is None


def altered(by, first):
    """The honest matrices but for one number of V_1, or of V_0, of one step."""

    def matrices(a):
        found = SHORT_STEPS.matrices(a)
        found[min(2, len(found) - 1), 0 if first else 1, 3, 1] += by
        return found

    return replace(SHORT_STEPS, matrices=matrices)


def zeroed():
    """V = 0: all that is known of the derivative is its bound."""

    def matrices(a):
        return 0.0 * SHORT_STEPS.matrices(a)

    return replace(SHORT_STEPS, matrices=matrices)


def derivative_off(untrusted, time):
    """The largest |truth - middle|/radius with faulty matrices."""
    what = fixed_point_problem.motion(CHAOTIC, unit=0)
    problem = fixed_point_problem.problem(what, 110)
    times = fixed_point_problem.times(what, [time])
    watch = Derivatives(times)
    proof_loop.run(problem, times, untrusted=untrusted, watchers=[watch])
    truth = orbit_newton.derivative(*body_of(CHAOTIC), [*CHAOTIC.omega, *CHAOTIC.gamma], time)
    exact = np.array([[float(x) for x in row] for row in truth])
    return float(np.max(np.abs(exact - watch.found[0].centre) / watch.found[0].radius))


@pytest.mark.slow
@pytest.mark.parametrize("first", [False, True])
def test_faulty_matrices_widen_the_balls(first):
    assert 1e-4 < derivative_off(altered(1e-6, first), Fraction(3)) <= 1


@pytest.mark.slow
def test_without_matrices_the_balls_are_wide_and_right():
    assert 0 < derivative_off(zeroed(), Fraction(2)) <= 1


#: The term, and how it is dropped; a fault in V shows each.
DROPPED = {
    "rho": (variational_bound, "missed", "float(known.rho[n])", "0.0"),
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
    with without(*DROPPED[term]):
        assert derivative_off(altered(1e-6, False), time) > 1


@pytest.mark.slow
def test_the_error_that_the_next_error_multiplies_is_not_forgotten():
    with without(variational_bound, "Product.noise", "np.max(error, axis=0)", "0.0"):
        assert derivative_off(zeroed(), Fraction(2)) > 1
