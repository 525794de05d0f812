"""The study of events: its truth is made without a run."""

from __future__ import annotations

from fractions import Fraction

import pytest

import polhode
from polhode.studies.events import rows
from polhode.studies.events.zeros import Zeros, ulp


def test_zeros_of_a_closed_form_lie_half_a_period_apart():
    zeros = Zeros(polhode.load("euler/largest-axis"), "q")
    first, second = zeros.first
    assert abs(second - first - zeros.period / 2) < Fraction(1, 10**45)
    every = zeros.until(98)
    assert every == sorted({*every})
    assert len(every) == 20
    # a zero at the start is none of the run's
    at_start = Zeros(polhode.load("lagrange/cusped"), "p*gamma2 - q*gamma1")
    assert at_start.until(7)[0] > 1


@pytest.mark.parametrize(("t", "size"), [(1, 52), (Fraction(3, 2), 52), (2, 51), (1000, 43)])
def test_an_ulp_is_the_distance_between_neighbours(t, size):
    assert ulp(Fraction(t), 53) == Fraction(1, 2**size)


def test_a_lost_event_is_seen(monkeypatch):
    """A count that is not the closed form's shows, and no error is then made up."""
    scene = rows._watching(polhode.load("euler/largest-axis"), "q")
    zeros = Zeros(scene, "q")
    honest = rows._run(scene, zeros, "double", 20)
    assert honest["true"] == honest["found"] == 4
    assert 0 < honest["ulps"] < 8
    monkeypatch.setattr(zeros, "first", zeros.first[:1])
    corrupted = rows._run(scene, zeros, "double", 20)
    assert corrupted["true"] == 2 != corrupted["found"]
    assert "ulps" not in corrupted
