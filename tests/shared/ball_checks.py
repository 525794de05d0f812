"""What is asked of every closed form in balls: few bits against many, and a Taylor run."""

from fractions import Fraction

from flint import arb

import polhode
from polhode.closed_forms.balls.core import TooFewBits, ball
from polhode.closed_forms.balls.frames import conjugate, product
from polhode.closed_forms.families import closed_form
from polhode.numbers import exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import fast_series

F = Fraction
PSI = F(3, 7)
FEW_BITS = 24, 30, 40, 53, 64, 90, 128, 200, 330
TIMES = F(3, 2), F(-7), F(1000)


def number(x):
    """An exact number as mpf, at the precision in force."""
    return mpf(exact.rounded(x, mpmath.prec))


def made(family, plain):
    moments, torque, omega, gamma = plain
    body = polhode.Body.of_moments(moments, torque, 1 if any(torque) else 0)
    kind, motion = closed_form(polhode.Scene(body, omega, gamma, psi=PSI), family)
    assert kind == family
    return motion


def row_at(motion, t, bits):
    """The balls of so many bits, whatever their radii; None where they do not tell."""
    with ctx.workprec(bits):
        try:
            return motion.row_at(ball(t), attitude=True)[0]
        except TooFewBits:
            return None


def every_ball_holds_its_value(motion, times=TIMES, few=FEW_BITS, many=900):
    """Says how many were finite."""
    finite = 0
    for t in times:
        sure = row_at(motion, t, many)
        assert sure is not None
        assert all(x.is_finite() and x.rad() < arb("1e-60") for x in sure[3:])
        for bits in few:
            for x, y in zip(row_at(motion, t, bits) or (), sure, strict=False):
                if x.is_finite():
                    assert x.overlaps(y), (t, bits)
                    finite += 1
    return finite


def agrees_with_taylor(motion, plain):
    """To 28 digits; not where |w| is so large that the run would be long."""
    t = TIMES[0]
    (row,), (q,), (q0,) = motion.at([t], 32), motion.attitude([t], 32), motion.attitude([0], 32)
    with mpmath.workdps(60):
        given = [[number(x) for x in row] for row in plain]
        identity = mpf(1), mpf(0), mpf(0), mpf(0)
        (right,) = fast_series.integrate(*given, [number(t)], 30, identity)
        largest = max([mpf(1), *(abs(x) for x in right[:3])])
        off = [abs(x - y) / largest for x, y in zip(row[:3], right[:3], strict=True)]
        off += [abs(x - y) for x, y in zip(row[3:], right[3:6], strict=True)]
        turned = product(conjugate(q0), q)
        off += [abs(x - y) for x, y in zip(turned, right[6:10], strict=True)]
        assert max(off) < mpf("1e-28")
