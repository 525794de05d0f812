"""Fourier series in integers: transforms against sums, integrals against quadrature."""

from fractions import Fraction

import numpy as np
import pytest

from polhode.closed_forms._winding import torus_line_integral
from polhode.closed_forms.functions import fourier
from polhode.closed_forms.functions.fourier import (
    TooManyTerms,
    cosines,
    fixed,
    floating,
    transform,
    waves,
)
from polhode.numbers.mpmath_context import mpf, mpmath


def test_the_fast_transform_is_the_sum():
    bits, count = 200, 16
    values = [mpf(3 * j * j % 17) / 7 for j in range(count)]
    with mpmath.workprec(220):
        real = np.array([fixed(x, bits) for x in values], dtype=object)
        re, im = transform(real, 0 * real, bits)
        for k in range(count):
            total = sum(x * mpmath.expjpi(mpf(-2 * j * k) / count) for j, x in enumerate(values))
            assert abs(mpmath.ldexp(int(re[k]), -bits) - total.real) < mpf(2) ** -190
            assert abs(mpmath.ldexp(int(im[k]), -bits) - total.imag) < mpf(2) ** -190


def smooth(x):
    return 1 / (2 + mpmath.cos(x))


def test_integral_of_an_even_function():
    with mpmath.workprec(160):
        (series,) = cosines(lambda x: [smooth(x)])
        assert abs(series.mean - 1 / mpmath.sqrt(3)) < mpf(2) ** -155
        found = series.mean * 2 + series.bounded(mpf(2))
        assert abs(found - mpmath.quad(smooth, [0, 2])) < mpf(2) ** -150
        doubles = series.doubles()
        assert abs(doubles.bounded(np.array([2.0]))[0] - float(series.bounded(mpf(2)))) < 1e-15
        ps = mpf("0.9")
        odd = series.times_cosine().at(*mpmath.cos_sin(ps))
        wanted = mpmath.quad(lambda x: smooth(2 * x) * mpmath.cos(x), [0, ps])
        assert abs(odd - wanted) < mpf(2) ** -150
        turned = series.times_sine()
        wanted = mpmath.quad(lambda x: smooth(x) * mpmath.sin(x), [0, 2])
        assert abs(turned.at(mpf(2)) - turned.at(mpf(0)) - wanted) < mpf(2) ** -150


def test_a_series_that_is_known():
    """1/(1 - a cos x): a_0 = 1/sqrt(1 - a^2), a_k = 2 a_0 ((1 - sqrt(1 - a^2))/a)^k."""
    with mpmath.workdps(60):
        a = mpf(9) / 10
        root = mpmath.sqrt(1 - a * a)
        (found,) = cosines(lambda x: [1 / (1 - a * mpmath.cos(x))])
        assert abs(found.mean - 1 / root) < mpf(10) ** -58
        for k, term in enumerate(found.terms, 1):
            right = 2 / root * ((1 - root) / a) ** k
            assert abs(k * floating(term, found.bits) * found.scale - right) < mpf(10) ** -58
        assert 250 < len(found.terms) < 512


def test_integral_of_any_periodic_function():
    def function(x):
        return smooth(x) * (1 + mpmath.sin(x) / 3 + mpmath.cos(2 * x))

    with mpmath.workprec(160):
        series = waves(function)
        found = series.at(mpf(3)) - series.at(mpf(0))
        assert abs(found - mpmath.quad(function, [0, 1, 2, 3])) < mpf(2) ** -148
        small = series.doubles()
        assert (
            abs(small.at(np.array([3.0]))[0] - small.at(np.array([0.0]))[0] - float(found)) < 1e-14
        )


def test_too_many_terms():
    with mpmath.workprec(160), pytest.raises(TooManyTerms):
        cosines(lambda x: [abs(mpmath.cos(x))], most=128)


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("second", ["sqrt 2", "resonance", "near resonance"])
def test_integral_along_a_line_on_a_torus(second):
    """W = cos((al - be)/2)/(3 + cos al + cos be), h = g = 1/2: slow where the rates are equal."""
    with mpmath.workprec(128):
        rate = {
            "sqrt 2": mpmath.sqrt(2),
            "resonance": mpf(1),
            "near resonance": 1 + mpf(10) ** -9,
        }[second]

        def value(al, be):
            return mpmath.cos((al - be) / 2) / (3 + mpmath.cos(al) + mpmath.cos(be))

        def grid(n, m, bits):
            als, bes = (
                [
                    (mpmath.cospi(mpf(2 * j) / count), *mpmath.cos_sin(mpmath.pi * j / count))
                    for j in range(count)
                ]
                for count in (n, m)
            )
            turns = [[(c * b + s * d) / (3 + x + y) for y, b, d in bes] for x, c, s in als]
            return np.array([[fixed(x, bits) for x in row] for row in turns], dtype=object)

        half = Fraction(1, 2)
        made = torus_line_integral.plane(grid, (mpf(1), rate), (half, half))
        start, t = (mpf(1) / 3, mpf(1) / 5), mpf(25)
        found = made.at(start[0] + t, start[1] + rate * t) - made.at(*start) + made.slowly(start, t)
        wanted = mpmath.quad(
            lambda s: value(start[0] + s, start[1] + rate * s), mpmath.linspace(0, t, 9)
        )
        assert abs(found - wanted) < mpf(2) ** -110
        assert bool(made.slow) == (second != "sqrt 2")


def test_a_wrong_sample_is_noticed(monkeypatch):
    """A function with one wrong value is not smooth: its series does not end."""
    old = fourier._series

    def spoiled(values, *rest):
        return old([values[0] * (1 + mpf(10) ** -30), *values[1:]], *rest)

    monkeypatch.setattr(fourier, "_series", spoiled)
    with mpmath.workprec(160), pytest.raises(TooManyTerms):
        cosines(lambda x: [smooth(x)], most=1024)
