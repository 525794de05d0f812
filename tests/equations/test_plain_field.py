"""The equations as a function of doubles: against high-precision derivatives of a closed form."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import polhode

EPS = np.finfo(float).eps


@pytest.mark.parametrize(
    "name", ["lagrange/turned-axes", "kovalevskaya/generic", "euler/separatrix"]
)
def test_the_rates_are_those_of_the_closed_form(name):
    """By central differences of 40 digits, at t = 1/2."""
    exact = polhode.reference(name)
    with mpmath.workdps(40):
        step = mpmath.mpf(10) ** -12
        ahead, here, back = exact.at([0.5 + step, 0.5, 0.5 - step], 40)
        rates = np.array([float((a - b) / (2 * step)) for a, b in zip(ahead, back, strict=True)])
    f = polhode.field(name)
    own = f(0.5, [float(x) for x in here])
    assert np.max(np.abs(own - rates)) < 64 * EPS * max(1.0, np.max(np.abs(rates)))
    both = f(0, np.array([here, here], dtype=float).T)
    assert both.shape == (len(here), 2)
    assert np.max(np.abs(both[:, 0] - own)) < 8 * EPS * max(1.0, np.max(np.abs(own)))


def test_a_scene_without_gamma_has_three_rates():
    f = polhode.field(polhode.top(moments=[1, 2, 3], omega=[1, 2, 3]))
    assert f(0, f.start).tolist() == [-6.0, 3.0, pytest.approx(-2 / 3, rel=2 * EPS)]
