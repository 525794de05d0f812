"""What one step rounds: against numpy's spacings, a count by hand, and steps that were taken."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from polhode.judging.conditioning import spacing, variances
from polhode.numbers.conversion import exactly
from polhode.numbers.exact_sequences import ExactNumbers
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, extended_here
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.taylor.error_growth import passage
from polhode.taylor.motion import Motion
from polhode.taylor.system import system
from polhode.taylor.variations import Flow
from tops import random_scene

F = Fraction


def test_spacings_are_those_of_doubles():
    x = np.array([1.0, -1.0, np.nextafter(2, 0), 2.0, -3.9, 0.1, 1e-9, 1e300])
    assert np.array_equal(spacing(x) * 2.0**-52, np.spacing(np.abs(x)))
    assert spacing(0.0) == 0


def test_a_count_by_hand():
    """p' = q r/2 + k gamma2, q' = -r p/2 - k gamma1, r' = 0, in a step of 2^-4 of the own unit.

    The state once, the increment four times.
    """
    body = Body.of_moments((4, 4, 2), (0, 0, 8), 1)
    scene = Scene(body, (F(3, 2), F(5, 4), 3), (0, 0, 1), times=(F(1),))
    along, k = passage(scene), 2 * 4.0**scene.time_unit
    state, step = np.array([1.5, 1.25, 3.0, 0.25, 0.75, 0.5]), 2.0**-4
    rates = [
        1.25 * 3 / 2 + k * 0.75,
        -3 * 1.5 / 2 - k * 0.25,
        0.0,
        3 * 0.75 - 1.25 * 0.5,
        1.5 * 0.5 - 3 * 0.25,
        1.25 * 0.25 - 1.5 * 0.75,
    ]

    def square(x: float) -> float:
        return float((np.spacing(abs(x)) * 2.0**52) ** 2) if x else 0.0

    expected = [
        (square(x) + 4 * square(step * rate)) / 12 if rate else 0.0
        for x, rate in zip(state, rates, strict=True)
    ]
    assert expected[2] == expected[4] == 0  # a spin that is kept; a rate of zero
    (found,) = variances(along, state[None], step)
    assert [*found] == pytest.approx(expected, rel=1e-14, abs=0)
    alone = [square(x) / 12 if e else 0 for x, e in zip(state, expected, strict=True)]
    (found,) = variances(along, state[None], 0.0)
    assert [*found] == pytest.approx(alone, rel=1e-14, abs=0)


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize(
    ("number", "wide"), [(DOUBLE, EXTENDED if extended_here() else QUAD), (EXTENDED, QUAD)]
)
@pytest.mark.parametrize("kind", ["lagrange", "euler"])
def test_steps_that_are_taken_round_so_much(number, wide, kind):
    """Each step's error against the exact flow from where it began: mean squares over many.

    The state alone is 2 to 3 times less in the Lagrange top; (eps x)² more than 2 times more.
    """
    if number is EXTENDED and not extended_here():
        pytest.skip("no extended numbers here")
    scene = random_scene(kind, 16, [F(60)])
    plain = system(replace(scene, form="principal"), number=number)
    motion, along = Motion(plain), passage(scene)
    motion.begin(plain)
    flow = Flow({name: number.rounded(x) for name, x in plain.coefficients.items()}, wide)
    squares, expected = np.zeros(6), np.zeros(6)
    for _ in range(100):
        before, began = [exactly(x) for x in motion.state.tolist()], motion.time
        motion.advance(ExactNumbers((F(10**4),)), motion.steps + 1)
        after, step = [exactly(x) for x in motion.state], motion.time - began
        true = [exactly(x) for x in flow.after(before, step).state]
        errors = [float((x - y) * 2 ** (number.bits - 1)) for x, y in zip(after, true, strict=True)]
        squares += np.square(errors)
        expected += variances(along, np.array([[float(x) for x in after]]), float(step))[0]
    assert not squares[expected == 0].any()
    assert 0.65 < squares.sum() / expected.sum() < 1.55
