"""From a state of the Kovalevskaya top to its points on the Jacobian, in balls.

The variables s1, s2 are the roots of q^2 s^2 + (R/2) s + R1/4, with sg = 2p, pi = p^2 + q^2,

    R = -pi^2 + 2H pi - 2m sg + b,    R1 = -2H pi^2 - b sg^2 + 4m pi sg + 2Hb - 4m^2,

and w_i = T' s_i - N', T = s1 + s2, N = s1 s2, sg' = q r, pi' = q G3, 2q' = -p r + G3 (Kowalevski
1889; Mumford's form of the divisor).  Then A(s1, w1) + A(s2, w2) moves as u(0) + t (0, 1).

Where q = 0, s1 is infinite, A of it 0, and w2^2 = -2 (s^2 - k^2) S(s), of either sign.  Next to
q = 0 the form loses some five digits for a decade of q; more bits pay for them.
"""

from __future__ import annotations

from collections.abc import Iterator

from flint import acb, arb

from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.quadrature import Pair
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.theta.jacobian import Jacobian
from polhode.numbers.exact import Exact, sign


def places(start: KovalevskayaStart, jacobian: Jacobian) -> Iterator[Pair]:
    """u(0): one place, or two of which one is right."""
    if sign(start.omega[1]) == 0:
        yield from _without_q(start, jacobian)
        return
    p, q, r = (ball(x) for x in start.omega)
    G3 = ball(start.G[2])
    H, m, b = ball(start.H), ball(start.m), ball(start.b)
    sg, pi, q2 = 2 * p, p * p + q * q, q * q
    R, R1 = _coefficients(H, m, b, sg, pi)
    sg1, pi1, q1 = q * r, q * G3, (G3 - p * r) / 2
    R_1 = 2 * (H - pi) * pi1 - 2 * m * sg1
    R1_1 = -4 * H * pi * pi1 - 2 * b * sg * sg1 + 4 * m * (pi1 * sg + pi * sg1)
    # T = -R/(2 q^2), N = R1/(4 q^2).
    T_1 = (R * q1 / q - R_1 / 2) / q2
    N_1 = (R1_1 / 4 - R1 * q1 / (2 * q)) / q2
    root = (R * R / 4 - q2 * R1).sqrt()
    larger = -(R / 2 + (root if R.mid() >= 0 else -root)) / 2  # q^2 s1, no difference
    one, two = (
        jacobian.image(acb(s), acb(T_1 * s - N_1)) for s in (larger / q2, R1 / (4 * larger))
    )
    yield one[0] + two[0], one[1] + two[1]


def _without_q(start: KovalevskayaStart, jacobian: Jacobian) -> Iterator[Pair]:
    """The same where q = 0."""
    p, H, m, b = ball(start.omega[0]), ball(start.H), ball(start.m), ball(start.b)
    R, R1 = _coefficients(H, m, b, 2 * p, p * p)
    s = -R1 / (2 * R)
    if at_branch_point(start):
        # Told by exact numbers: a root of a ball around 0 would cost half of the bits.
        yield jacobian.image(acb(s), acb(0))
        return
    k2 = ball(start.k2)
    w = (-2 * (s * s - k2) * ((s + H) * (s * s + b) - 2 * m * m)).sqrt()
    for ordinate in (w, -w):
        yield jacobian.image(acb(s), acb(ordinate))


def at_branch_point(start: KovalevskayaStart) -> bool:
    """Whether s2 is a branch point, where q = 0: exactly."""
    p, H, b, m2 = start.omega[0], start.H, start.b, start.m2
    p2, mp = p * p, p * start.m
    R: Exact = -p2 * p2 + 2 * H * p2 - 4 * mp + b
    R1: Exact = -2 * H * p2 * p2 - 4 * b * p2 + 8 * mp * p2 + 2 * H * b - 4 * m2
    # With s2 = -R1/2R: each factor times a power of -2R.
    square = R1 * R1 - 4 * R * R * start.k2
    cubic = (2 * R * H - R1) * (R1 * R1 + 4 * R * R * b) - 16 * R * R * R * m2
    return sign(square) == 0 or sign(cubic) == 0


def _coefficients(H: arb, m: arb, b: arb, sg: arb, pi: arb) -> tuple[arb, arb]:
    """R and R1."""
    R = -pi * pi + 2 * H * pi - 2 * m * sg + b
    R1 = -2 * H * pi * pi - b * sg * sg + 4 * m * pi * sg + 2 * H * b - 4 * m * m
    return R, R1
