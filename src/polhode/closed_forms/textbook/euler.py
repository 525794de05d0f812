"""Euler's top by Jacobi's functions of mpmath, its precession by Legendre's third integral.

With A < B < C or reversed, so that the polhode circles axis 3 (Whittaker, Analytical Dynamics, art.
69; Landau and Lifshitz, Mechanics, section 37), in angles about the angular momentum G:

    w = (a cn, b sn, c dn),    cos th = C r/G,    tan ph = A p/(B q),
    psi' = G (A p^2 + B q^2)/(A^2 p^2 + B^2 q^2) = G/C + G (2TC - G^2)/(C (G^2 - C^2 r^2)).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from polhode.closed_forms.textbook.legendre import TooFewDigits, third_integral
from polhode.closed_forms.textbook.vectors import Row, along, back, cross, dot, unit
from polhode.numbers.mpmath_context import mpf, mpmath

_ONE = 2**20  # rounding errors by which the parameter m of a separatrix may differ from 1


def motion(
    moments: Sequence[mpf], omega: Sequence[mpf], gamma: Sequence[mpf] | None, regime: str
) -> Callable[[mpf], Row]:
    """The state p q r [gamma1 gamma2 gamma3] in principal axes, as a function of time.

    ``moments``, ``omega``, ``gamma``: at t = 0, at the working precision of :data:`mpmath`.
    ``regime``: the motion's, by exact numbers.  Of a rotation about a fixed axis and of a
    separatrix all precisions agree on a motion next to it, however far that leads away: raises
    TooFewDigits where the numbers tell no difference and the regime does.
    """
    momentum = [a * x for a, x in zip(moments, omega, strict=True)]
    torque = cross(momentum, omega)
    negligible = mpmath.eps * 64 * max(map(abs, momentum)) * max(map(abs, omega))
    if regime in ("rest", "sphere") or regime.startswith("permanent"):
        return lambda t: [*omega, *([] if gamma is None else _turned(gamma, omega, t))]
    if max(map(abs, torque)) <= negligible:
        raise TooFewDigits("next to a rotation about a fixed axis")
    order = sorted(range(3), key=lambda i: moments[i])
    twice, squared = dot(momentum, omega), dot(momentum, momentum)
    if squared < twice * moments[order[1]]:
        order.reverse()
    # a cyclic order keeps the hand of the axes; of another one the second axis is turned round
    side = 1 if order in ([0, 1, 2], [1, 2, 0], [2, 0, 1]) else -1
    ways = (1, side, 1)
    (A, B, C) = (moments[i] for i in order)
    start = [k * omega[i] for k, i in zip(ways, order, strict=True)]
    own = _polhode((A, B, C), start, twice, squared, regime == "separatrix")
    if gamma is None:
        return lambda t: _back(own.omega(own.phase + own.rate * t), order, ways)

    size = mpmath.sqrt(squared)
    a, b, _ = own.amplitudes
    # G^2 - C^2 r^2 = A^2 p^2 + B^2 q^2 = (A a)^2 (1 - number sn^2)
    number = 1 - (B * b / (A * a)) ** 2
    factor = size * (twice * C - squared) / (C * (A * a) ** 2 * own.rate)
    begin = third_integral(number, own.phase, own.parameter)
    turned = [k * gamma[i] for k, i in zip(ways, order, strict=True)]
    first = _frame([A * start[0], B * start[1], C * start[2]])
    fixed = along(first, turned)

    def state(t: mpf) -> Row:
        v = own.phase + own.rate * t
        now = own.omega(v)
        psi = size / C * t + factor * (third_integral(number, v, own.parameter) - begin)
        c, s = mpmath.cos(psi), mpmath.sin(psi)
        # fixed in space, so turned back by psi about G against the body's node
        now_fixed = (c * fixed[0] + s * fixed[1], c * fixed[1] - s * fixed[0], fixed[2])
        seen = back(_frame([A * now[0], B * now[1], C * now[2]]), now_fixed)
        return _back(now, order, ways) + _back(seen, order, ways)

    return state


class _Polhode(NamedTuple):
    """w = (a cn, b sn, c dn) along sorted axes: a, b, c, the phase, its rate, the parameter m."""

    amplitudes: tuple[mpf, mpf, mpf]
    phase: mpf
    rate: mpf
    parameter: mpf

    def omega(self, v: mpf) -> Row:
        """w at a phase."""
        sn, cn, dn = (mpmath.ellipfun(kind, v, m=self.parameter) for kind in ("sn", "cn", "dn"))
        a, b, c = self.amplitudes
        return [a * cn, b * sn, c * dn]


def _polhode(
    moments: tuple[mpf, mpf, mpf], start: Row, twice: mpf, squared: mpf, separatrix: bool
) -> _Polhode:
    A, B, C = moments
    below, above = twice * C - squared, squared - twice * A
    divisor = (C - B) * above
    if divisor == 0:  # the axes' order was told by rounding
        raise TooFewDigits("next to a rotation about a fixed axis")
    parameter = (B - A) * below / divisor
    if separatrix:
        parameter = mpmath.mpf(1)
    elif 1 - parameter < _ONE * mpmath.eps:
        raise TooFewDigits("next to a separatrix")
    first, third = (1 if x >= 0 else -1 for x in (start[0], start[2]))
    second = (1 if C > B else -1) * first * third
    a = first * mpmath.sqrt(below / (A * (C - A)))
    b = second * mpmath.sqrt(below / (B * (C - B)))
    c = third * mpmath.sqrt(above / (C * (C - A)))
    rest = [(start[0] / a) ** 2, (start[2] / c) ** 2]
    phase = start[1] / b * mpmath.elliprf(*rest, 1)
    rate = mpmath.sqrt((C - B) * above / (A * B * C))
    return _Polhode((a, b, c), phase, rate, parameter)


def _frame(momentum: Row) -> list[Row]:
    """Rows: the node of axis 3 about G, what makes it right-handed, and G, in body axes."""
    x, y, _ = momentum
    across = mpmath.hypot(x, y)
    node, third = [y / across, -x / across, mpmath.mpf(0)], unit(momentum)
    return [node, cross(third, node), third]


def _back(row: Row, order: Sequence[int], ways: Sequence[int]) -> Row:
    """Components along the sorted axes, in the order that the body has."""
    found = [mpmath.mpf(0)] * 3
    for i, way, x in zip(order, ways, row, strict=True):
        found[i] = way * x
    return found


def _turned(gamma: Sequence[mpf], omega: Sequence[mpf], t: mpf) -> Row:
    """gamma of a body that turns about a fixed axis: gamma' = gamma x w."""
    size = mpmath.norm(omega)
    if size == 0:
        return list(gamma)
    axis = unit(omega)
    kept = dot(axis, gamma)
    c, s = mpmath.cos(size * t), mpmath.sin(size * t)
    side = cross(gamma, axis)
    return [c * x + s * y + (1 - c) * kept * n for x, y, n in zip(gamma, side, axis, strict=True)]
