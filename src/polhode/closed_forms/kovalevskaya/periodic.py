"""The one-frequency motions of the Kovalevskaya top in balls.

Symbols as in :mod:`polhode.closed_forms.kovalevskaya.axes`; every one reduces to y'^2 = f(y):

Delaunay, k = 0:  x = p + iq,  4x'^2 = x^4 - 2H x^2 + 4m x - a^2,  G1 + iG2 = x^2.
Bobylev-Steklov, q = 0 and p constant:  r'^2 = (H - 2p^2) r^2 - r^4/4 + const,  G3 = p r.
Pendulum about y, p = r = G2 = 0:  q'^2 = H q^2/2 - q^4/4 + const,  G3 = 2q'.
Appelrot's special motion, xh and ro constant:  p = xh + ro cos ps, q = ro sin ps, r = -2 ps',
G3 = xh r, G1 + iG2 = 2 xh (ro + xh cos ps) exp(i ps),
E = r^2/4 + 2 xh ro cos ps + xh^2 cos^2 ps, and for y = tan(ps/2)
y'^2 = [E (1 + y^2)^2 - 2 xh ro (1 - y^4) - xh^2 (1 - y^2)^2]/4.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.weierstrass import Quartic, Weierstrass, WeierstrassSolution
from polhode.closed_forms.kovalevskaya import regimes
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.numbers.exact import ZERO, Exact, exact, sign, sqrt

#: p, q, r, G1, G2, G3 of a complex time.
ComplexState: TypeAlias = Callable[[acb], Sequence[acb]]

_I = acb(0, 1)


class Periodic:
    """The state of a regime in ``regimes.ONE_FREQUENCY``, at the precision in force."""

    def __init__(self, start: KovalevskayaStart, regime: str) -> None:
        make = {
            regimes.DELAUNAY: _delaunay,
            regimes.BOBYLEV: _bobylev,
            regimes.PENDULUM_Z: _bobylev,
            regimes.PENDULUM_Y: _pendulum,
            regimes.APPELROT: _appelrot,
        }[regime]
        self.speed = start.speed_bound()
        function = Weierstrass(quartic(start, regime))
        self.complex_state: ComplexState = make(start, function)
        #: The period; None of a motion that tends to a steady one.
        self.period = function.period

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, G1, G2, G3."""
        return [x.real for x in self.complex_state(acb(t))]


def quartic(start: KovalevskayaStart, name: str) -> Quartic:
    """The f of the motion, exact."""
    (p, q, r), (_, G2, G3) = start.omega, start.G
    H = start.H
    if name == regimes.DELAUNAY:
        return Quartic((exact(1) / 4, ZERO, -H / 12, start.m / 4, -start.a2 / 4))
    if name == regimes.PENDULUM_Y:
        rest = G3 * G3 / 4 - H * q * q / 2 + q * q * q * q / 4
        return Quartic((-exact(1) / 4, ZERO, H / 12, ZERO, rest))
    if name == regimes.APPELROT:
        xh, ro, x = _appelrot_numbers(start)
        # E = r^2/4 + 2 xh (p - xh) + xh^2 cos^2 ps, the cosine (p - xh)/ro
        E = r * r / 4 + 2 * xh * x + xh * xh * x * x / (ro * ro)
        ends = (E + 2 * xh * ro - xh * xh) / 4, (E - 2 * xh * ro - xh * xh) / 4
        return Quartic((ends[0], ZERO, (E + xh * xh) / 12, ZERO, ends[1]))
    lift = H - 2 * p * p
    return Quartic((-exact(1) / 4, ZERO, lift / 6, ZERO, G2 * G2 - lift * r * r + r**4 / 4))


def _balls(start: KovalevskayaStart) -> list[arb]:
    """w and G."""
    return [ball(x) for x in (*start.omega, *start.G)]


def _delaunay(start: KovalevskayaStart, P: Weierstrass) -> ComplexState:
    p0, q0, r0, _, _, G3 = _balls(start)
    f = quartic(start, regimes.DELAUNAY)
    # x and its conjugate, each analytic in t.
    solutions = []
    for side in (1, -1):
        x0 = acb(p0, side * q0)
        solutions.append(WeierstrassSolution(f, x0, side * _I * (G3 - r0 * x0) / 2, P))
    H, m = ball(start.H), ball(start.m)

    def state(t: acb) -> Sequence[acb]:
        (x, x1), (y, y1) = (solution.value(t) for solution in solutions)
        p, q, p1, q1 = (x + y) / 2, (x - y) / (2 * _I), (x1 + y1) / 2, (x1 - y1) / (2 * _I)
        # q1 r = m - p H + p (p^2 - q^2), q r = 2 p1
        r = (2 * p1 * q + q1 * (m - p * H + p * (p * p - q * q))) / (q * q + q1 * q1)
        return [p, q, r, p * p - q * q, 2 * p * q, 2 * q1 + p * r]

    return state


def _bobylev(start: KovalevskayaStart, P: Weierstrass) -> ComplexState:
    p0, _, r0, _, G2, _ = _balls(start)
    y = WeierstrassSolution(quartic(start, regimes.BOBYLEV), acb(r0), acb(-G2), P)
    H, p = ball(start.H), acb(p0)

    def state(t: acb) -> Sequence[acb]:
        r, r1 = y.value(t)
        return [p, acb(0), r, H - p * p - r * r / 2, -r1, p * r]

    return state


def _pendulum(start: KovalevskayaStart, P: Weierstrass) -> ComplexState:
    _, q0, _, _, _, G3 = _balls(start)
    y = WeierstrassSolution(quartic(start, regimes.PENDULUM_Y), acb(q0), acb(G3 / 2), P)
    H, nil = ball(start.H), acb(0)

    def state(t: acb) -> Sequence[acb]:
        q, q1 = y.value(t)
        return [nil, q, nil, H - q * q, nil, 2 * q1]

    return state


def _appelrot_numbers(start: KovalevskayaStart) -> tuple[Exact, Exact, Exact]:
    """xh, ro (of the sign of p - xh) and p - xh."""
    xh = regimes.centre(start)
    assert xh is not None
    p, q, _ = start.omega
    x = p - xh
    ro = sqrt(x * x + q * q)
    return xh, (-ro if sign(x) < 0 else ro), x


def _appelrot(start: KovalevskayaStart, P: Weierstrass) -> ComplexState:
    xh, ro, x = (ball(v) for v in _appelrot_numbers(start))
    _, q0, r0 = _balls(start)[:3]
    y0 = q0 / (ro + x)  # tan of half of ps
    f = quartic(start, regimes.APPELROT)
    y = WeierstrassSolution(f, acb(y0), acb(-r0 * (1 + y0 * y0) / 4), P)

    def state(t: acb) -> Sequence[acb]:
        Y, Z, moved = y.quotient(t)
        over = 1 / (Z * Z + Y * Y)
        c, s = (Z * Z - Y * Y) * over, 2 * Y * Z * over
        r = -4 * moved * over
        G = 2 * xh * (ro + xh * c)
        return [xh + ro * c, ro * s, r, G * c, G * s, xh * r]

    return state
