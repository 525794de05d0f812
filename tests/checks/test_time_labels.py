"""Figures that hold at another time than their label says, and figures that do not."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode.checks.published_figures import figures, time_labels
from polhode.scenes.scene import Published


def labels(scene):
    reference = polhode.reference(scene)
    return [*time_labels(scene, reference, figures(scene, reference))]


def printed_late(late: Fraction, wrong: str = "") -> list:
    """The state at t = 5 + late, printed to 12 digits as if it were that at 5."""
    scene = polhode.load("lagrange/nutation")
    row = polhode.reference(scene).at([5 + late], 20)[0]
    texts = [f"{float(x):.12g}" for x in row]
    if wrong:
        texts[1] = wrong
    published = [
        Published(Fraction(5), q, x, "X") for q, x in zip(scene.columns, texts, strict=True)
    ]
    return labels(replace(scene, published=tuple(published)))


@pytest.mark.parametrize("late", [Fraction(1, 1000), Fraction(-1, 40), Fraction(1, 10**6)])
def test_a_shift_is_found_to_the_digits_printed(late):
    (label,) = printed_late(late)
    assert label.shift == pytest.approx(float(late), rel=1e-4, abs=1e-11)
    assert label.after < 1e-11
    assert label.before > 100 * label.after


def test_figures_that_are_right_or_wrong_in_another_way_have_none():
    assert printed_late(Fraction(0)) == []
    assert printed_late(Fraction(1, 1000), wrong="0.5") == []


def test_the_brick_of_simulation_six_is_half_a_millisecond_late():
    (label,) = labels(polhode.load("published/nasa-brick"))
    assert "simulation 6" in label.cite
    assert label.shift == pytest.approx(5e-4, rel=1e-4)
    assert label.after < label.before / 10_000
