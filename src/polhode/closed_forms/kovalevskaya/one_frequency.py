"""The one-frequency motions of the Kovalevskaya top, and its states of rest and rotation.

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

from collections.abc import Callable
from dataclasses import dataclass

from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya import regimes
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.theta.weierstrass import (
    Quartic,
    WeierstrassSolution,
    solution,
)
from polhode.numbers.exact import ZERO, Exact, exact, sign, sqrt
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

State = list[Scalar]


@dataclass(frozen=True)
class Special:
    """One motion at one precision; ``state(t)`` in the top's axes and units."""

    state: Callable[[Scalar], State]
    period: Scalar  # infinite where there is none
    defect: Scalar

    def at(self, t: Scalar) -> tuple[State, Scalar]:
        """The state at t; there is no rest that could tell an error."""
        return self.state(t), mpf(0)


def special(start: KovalevskayaStart, name: str, bits: int) -> Special:
    """The motion of a regime in ``STEADY`` or ``ONE_FREQUENCY``, at ``bits`` bits."""
    with mpmath.workprec(bits):
        w, G = start.numbers(bits)
        if name in regimes.STEADY:
            return Special(lambda t: [*w, *G], mpmath.inf, mpf(0))
        make = {
            regimes.DELAUNAY: _delaunay,
            regimes.BOBYLEV: _bobylev,
            regimes.PENDULUM_Z: _bobylev,
            regimes.PENDULUM_Y: _pendulum,
            regimes.APPELROT: _appelrot,
        }[name]
        state, elliptic = make(start, bits)
        scale = max(1, *(abs(x) for x in w))
        weight = number(start.weight, bits)
        defect = mpf(0)
        found = state(mpf(0))
        for x, y, size in zip(found, [*w, *G], [scale] * 3 + [weight] * 3, strict=True):
            defect = max(defect, abs(x - y) / size)
        return Special(state, elliptic.P.period, defect)


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
        return Quartic(
            (
                (E + 2 * xh * ro - xh * xh) / 4,
                ZERO,
                (E + xh * xh) / 12,
                ZERO,
                (E - 2 * xh * ro - xh * xh) / 4,
            )
        )
    lift = H - 2 * p * p
    return Quartic((-exact(1) / 4, ZERO, lift / 6, ZERO, G2 * G2 - lift * r * r + r**4 / 4))


def _delaunay(
    start: KovalevskayaStart, bits: int
) -> tuple[Callable[[Scalar], State], WeierstrassSolution]:
    (p, q, r), (_, _, G3) = start.numbers(bits)
    x0 = mpc(p, q)
    y = solution(quartic(start, regimes.DELAUNAY), x0, 1j * (G3 - r * x0) / 2, bits)
    H, m = number(start.H, bits), number(start.m, bits)

    def state(t: Scalar) -> State:
        x, x1 = y.value(t)
        p, q, p1, q1 = x.real, x.imag, x1.real, x1.imag
        # q1 r = m - p H + p (p^2 - q^2), q r = 2 p1
        r = (2 * p1 * q + q1 * (m - p * H + p * (p * p - q * q))) / (q * q + q1 * q1)
        return [p, q, r, p * p - q * q, 2 * p * q, 2 * q1 + p * r]

    return state, y


def _bobylev(
    start: KovalevskayaStart, bits: int
) -> tuple[Callable[[Scalar], State], WeierstrassSolution]:
    (p, _, r0), (_, G2, _) = start.numbers(bits)
    y = solution(quartic(start, regimes.BOBYLEV), r0, -G2, bits)
    H = number(start.H, bits)

    def state(t: Scalar) -> State:
        r, r1 = y.value(t)
        return [p, mpf(0), r, H - p * p - r * r / 2, -r1, p * r]

    return state, y


def _pendulum(
    start: KovalevskayaStart, bits: int
) -> tuple[Callable[[Scalar], State], WeierstrassSolution]:
    (_, q0, _), (_, _, G3) = start.numbers(bits)
    y = solution(quartic(start, regimes.PENDULUM_Y), q0, G3 / 2, bits)
    H = number(start.H, bits)

    def state(t: Scalar) -> State:
        q, q1 = y.value(t)
        return [mpf(0), q, mpf(0), H - q * q, mpf(0), 2 * q1]

    return state, y


def _appelrot_numbers(start: KovalevskayaStart) -> tuple[Exact, Exact, Exact]:
    """xh, ro (of the sign of p - xh) and p - xh."""
    xh = regimes.centre(start)
    assert xh is not None
    p, q, _ = start.omega
    x = p - xh
    ro = sqrt(x * x + q * q)
    return xh, (-ro if sign(x) < 0 else ro), x


def _appelrot(
    start: KovalevskayaStart, bits: int
) -> tuple[Callable[[Scalar], State], WeierstrassSolution]:
    xh, ro, x = (number(v, bits) for v in _appelrot_numbers(start))
    (_, q0, r0), _ = start.numbers(bits)
    y0 = q0 / (ro + x)  # tan of half of ps
    y = solution(quartic(start, regimes.APPELROT), y0, -r0 * (1 + y0 * y0) / 4, bits)

    def state(t: Scalar) -> State:
        Y, Z, Y1, Z1 = y.at(t)
        over = 1 / (Z * Z + Y * Y)
        c, s = (Z * Z - Y * Y) * over, 2 * Y * Z * over
        r = -4 * (Y1 * Z - Y * Z1) * over
        G = 2 * xh * (ro + xh * c)
        return [xh + ro * c, ro * s, r, G * c, G * s, xh * r]

    return state, y
