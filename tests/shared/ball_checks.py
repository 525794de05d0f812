"""What is asked of every closed form in balls: few bits against many, and a Taylor run."""

from fractions import Fraction

import mpmath
from flint import arb
from mpmath import mpf

import polhode
from polhode.closed_forms.balls.core import TooFewBits, ball
from polhode.closed_forms.balls.frames import Frame, conjugate
from polhode.closed_forms.families import FAMILIES, closed_form, form_of
from polhode.closed_forms.membership import PrincipalScene
from polhode.numbers import exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import ordinary
from polhode.numbers.vectors import quaternion_product
from shared import fast_series
from shared.closed_form_motions import number

F = Fraction
PSI = F(3, 7)
FEW_BITS = 24, 30, 40, 53, 64, 90, 128, 200, 330
TIMES = F(3, 2), F(-7), F(1000)


def motion_of_family(family, plain):
    moments, torque, omega, gamma = plain
    body = polhode.Body.of_moments(moments, torque, 1 if any(torque) else 0)
    kind, motion = closed_form(polhode.Scene(body, omega, gamma, psi=PSI), family)
    assert kind == family
    return motion


def form(family, moments, torque, omega, gamma, psi=exact.ZERO, axes=None):
    """The closed form of a family, or of one by its name, of any exact numbers."""
    if isinstance(family, str):
        (family,) = (member for member in FAMILIES if member.name == family)
    into = Frame(within=axes).into
    scene = PrincipalScene(moments, torque, into(omega), into(gamma))
    return form_of(family, scene, (omega, gamma, psi), axes)


def row_at(motion, t, bits):
    """The balls of so many bits, whatever their radii; None where they do not tell."""
    with ctx.workprec(bits):
        try:
            return motion.row_at(ball(t), attitude=motion.place.has_attitude)[0]
        except TooFewBits:
            return None


def every_ball_holds_its_value(motion, times=TIMES, few=FEW_BITS, many=900, sure_to="1e-60"):
    """Says how many were finite; those of many bits are ``sure_to`` so much."""
    finite = 0
    for t in times:
        sure = row_at(motion, t, many)
        assert sure is not None
        assert all(x.is_finite() and x.rad() < arb(sure_to) for x in sure[3:])
        for bits in few:
            for x, y in zip(row_at(motion, t, bits) or (), sure, strict=False):
                if x.is_finite():
                    assert x.overlaps(y), (t, bits)
                    finite += 1
    return finite


def agrees_with_taylor(motion, plain, digits=28):
    """The state, and the attitude of a family that has it; the run is long where |w| is large."""
    t, columns = TIMES[0], 6 + 4 * motion.place.has_attitude
    identity = (mpf(1), mpf(0), mpf(0), mpf(0)) if motion.place.has_attitude else None
    (row,) = ordinary(motion.at([t], digits + 4))
    with mpmath.workdps(60):
        start = [[number(x) for x in row] for row in plain]
        (right,) = fast_series.integrate(*start, [number(t)], digits + 2, identity)
        largest = max([mpf(1), *(abs(x) for x in right[:3])])
        if motion.place.has_attitude:
            q0, q = ordinary(motion.attitude([0, t], digits + 4))
            row = [*row, *quaternion_product(conjugate(q0), q)]
        sizes = [*[largest] * 3, *[1] * (columns - 3)]
        off = [abs(x - y) / size for x, y, size in zip(row, right[:columns], sizes, strict=True)]
        assert max(off) < mpf(10) ** -digits
