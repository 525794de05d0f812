"""Angles and attitude of runs against closed forms, for every case that asks for them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import mpmath
import pytest

import polhode
from polhode import library, precision
from polhode.precision import exactly

CASES = [
    name
    for name in library.names()
    if polhode.load(name).outputs and polhode.reference(name).is_closed_form
]


def worst_error(mine, exact) -> float:
    """The largest difference; a value that one side leaves undefined must be so on both."""
    worst = mpmath.mpf(0)
    with mpmath.workprec(200):
        for row, true in zip(mine, exact, strict=True):
            for x, y in zip(row, true, strict=True):
                assert (x is None) == (y is None)
                if x is not None:
                    worst = max(worst, abs(precision.to_mpf(exactly(x), 200) - y))
        return float(worst)


@pytest.mark.parametrize("name", CASES)
def test_outputs_of_a_run_are_those_of_the_closed_form(name):
    """In quad at a few times: absolute errors as small as those of the state allow."""
    scene = polhode.load(name)
    truth = polhode.reference(scene)
    end = min(abs(scene.end), 10) * (1 if scene.end > 0 else -1)
    scene = replace(scene, times=tuple(end * Fraction(k, 7) for k in range(8)))
    run = polhode.integrate(scene, "quad")
    state = 10.0 ** -polhode.compare(run, truth).worst
    bound = 1e4 * max(state, 1e-33)
    if run.attitude is not None:
        assert worst_error(run.attitude, truth.attitude(run.times, 40)) < bound
    if run.angles is not None:
        assert worst_error(run.angles, truth.angles(run.times, 40)) < bound
