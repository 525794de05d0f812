"""Every digit that ``reference`` prints is right to half a unit of its last place."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import pytest

import polhode
from polhode.numbers.conversion import exactly
from polhode.output import json_results

# Before: 0.5 to 0.64 units off in the last place (the first three), noise of 1e-39 for zeros (the
# last two, a pendulum's components off its plane).
SCENES = (
    "euler/dzhanibekov",
    "euler/fast-spin",
    "kovalevskaya/type-e-ee",
    "lagrange/planar-librating",
    "lagrange/planar-rotating",
)


@pytest.mark.parametrize("name", SCENES)
def test_the_last_printed_digit_is_right(name):
    reference = polhode.reference(name)
    scene, digits = reference.scene, 20
    times = (scene.times[len(scene.times) // 2], scene.end)
    answer = json_results.of_reference(reference, times, digits)
    finer = reference.at([Fraction(t) for t in answer["times"]], digits + 80)
    for row, true in zip(answer["states"], finer, strict=True):
        for text, x in zip(row, true, strict=True):
            printed, right = Decimal(text), exactly(x)
            if abs(right) < Fraction(10) ** -70:  # an exact zero
                assert text == "0"
                continue
            unit = Fraction(10) ** printed.as_tuple().exponent
            assert abs(Fraction(printed) - right) <= Fraction(501, 1000) * unit


def test_a_small_component_keeps_its_digits():
    """p on a separatrix falls like e^-lambda t: it is no zero."""
    answer = json_results.of_reference(polhode.reference("euler/separatrix"), (Fraction(400),), 20)
    p = Decimal(answer["states"][0][0])
    assert p != 0
    fine = exactly(polhode.reference("euler/separatrix").at([400], 80)[0][0])
    assert abs(Fraction(p) - fine) <= Fraction(501, 1000) * Fraction(10) ** p.as_tuple().exponent
