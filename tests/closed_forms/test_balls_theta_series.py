"""Theta functions as polynomials: FLINT's own, at any precision, and no wider than they must be."""

import pytest
from flint import acb, arb

from polhode.closed_forms.balls import jacobi
from polhode.closed_forms.balls.core import TooFewBits
from polhode.closed_forms.balls.jacobi import ThetaSeries
from polhode.numbers.flint_context import ctx

PLACES = ("0.49", "0.1", "-0.3", "0")
WIDTHS = ("0.07", "0.3", "1.1", "7", "60")


def values(series, z, y):
    """th1, ..., th4 at z, and th3, th4 at z + i y."""
    sine, cosine = z.sin_cos_pi()
    double = (2 * z).cos_pi()
    real = [
        sine * series.th1(double),
        cosine * series.th2(double),
        series.th3(double),
        series.th4(double),
    ]
    for third in (True, False):
        level, upright = series.above(y, third=third)
        real += [level(double), upright(double) * (2 * z).sin_pi()]
    return real


def flints(s, z, y):
    here = [x.real for x in acb.modular_theta(acb(z), acb(0, s))]
    above = acb.modular_theta(acb(z, y), acb(0, s))[2:]
    return here + [part for x in above for part in (x.real, x.imag)]


@pytest.mark.parametrize("width", WIDTHS)
def test_every_ball_holds_the_value(width):
    for place in PLACES:
        for share in ("0.5", "0.2", "-0.4"):
            with ctx.workprec(900):
                s, z = arb(width), arb(place)
                right = flints(s, z, arb(share) * s)
            for bits in (24, 53, 113, 330):
                with ctx.workprec(bits):
                    mine = values(ThetaSeries(s), z, arb(share) * s)
                    assert all(x.overlaps(y) for x, y in zip(mine, right, strict=True))


@pytest.mark.parametrize("width", WIDTHS[:3])
def test_what_is_left_out_is_in_the_ball_and_not_much_more(width, monkeypatch):
    """With few terms each ball holds its value, and with no bound of the rest hardly any would."""
    monkeypatch.setattr(jacobi.math, "ceil", lambda x: 3 if width == "0.07" else 1)
    with ctx.workprec(300):
        s, y = arb(width), arb(width) / 3
        series, missed = ThetaSeries(s), 0
        for place in PLACES[:3]:
            z = arb(place)
            for mine, right in zip(values(series, z, y), flints(s, z, y), strict=True):
                assert mine.overlaps(right)
                missed += not mine.mid().overlaps(right)
        assert missed > 20


def test_terms_that_do_not_fall_are_refused(monkeypatch):
    monkeypatch.setattr(jacobi.math, "ceil", lambda x: 1)
    with ctx.workprec(100), pytest.raises(TooFewBits):
        ThetaSeries(arb("0.01"))
    with ctx.workprec(100), pytest.raises(TooFewBits):
        ThetaSeries(arb(1)).above(arb("nan"), third=True)
