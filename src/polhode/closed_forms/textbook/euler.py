"""Euler's top by Jacobi's functions of mpmath, its precession by Legendre's third integral.

With A < B < C or reversed, so that the polhode circles axis 3 (Whittaker, Analytical Dynamics, art.
69; Landau and Lifshitz, Mechanics, section 37), in angles about the angular momentum G:

    w = (a cn, b sn, c dn),    cos th = C r/G,    tan ph = A p/(B q),
    psi' = G (A p^2 + B q^2)/(A^2 p^2 + B^2 q^2) = G/C + G (2TC - G^2)/(C (G^2 - C^2 r^2)).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from polhode.closed_forms.textbook.third_integral import Along
from polhode.numbers.mpmath_context import mpf, mpmath

_ONE = 2**20  # rounding errors by which the parameter m of a separatrix may differ from 1


def motion(
    moments: Any, weight: mpf, omega: Any, gamma: Any, regime: str
) -> Callable[[mpf], list[mpf]]:
    """The state p q r gamma1 gamma2 gamma3 as a function of time, ``weight`` being 0.

    ``moments``, ``omega``, ``gamma``: at t = 0, along the axes above.  ``regime``: the motion's, by
    exact numbers.  Of a separatrix all precisions agree on a motion next to it, however far that
    leads away: raises ArithmeticError where the numbers tell no difference and the regime does.
    """
    del weight
    (A, B, C), (p, q, r) = moments, omega
    if regime in ("rest", "sphere") or regime.startswith("permanent"):
        spin = mpmath.matrix([[0, r, -q], [-r, 0, p], [q, -p, 0]])  # spin g = g x w
        return lambda t: [*omega, *(mpmath.expm(t * spin) * gamma)]
    twice, squared = A * p * p + B * q * q + C * r * r, (A * p) ** 2 + (B * q) ** 2 + (C * r) ** 2
    below, above = twice * C - squared, squared - twice * A
    parameter = (B - A) * below / ((C - B) * above)
    if regime == "separatrix":
        parameter = mpmath.mpf(1)
    elif 1 - parameter < _ONE * mpmath.eps or below / (C - A) <= 0:
        raise ArithmeticError(f"next to {'a separatrix' if parameter > 0 else 'a rotation'}")
    first, third = (1 if x >= 0 else -1 for x in (p, r))
    a = first * mpmath.sqrt(below / (A * (C - A)))
    b = first * third * mpmath.sign(C - B) * mpmath.sqrt(below / (B * (C - B)))
    c = third * mpmath.sqrt(above / (C * (C - A)))
    begin = q / b * mpmath.elliprf((p / a) ** 2, (r / c) ** 2, 1)
    rate = mpmath.sqrt((C - B) * above / (A * B * C))
    size = mpmath.sqrt(squared)
    # G^2 - C^2 r^2 = A^2 p^2 + B^2 q^2 = (A a)^2 (1 - number sn^2)
    number = 1 - (B * b / (A * a)) ** 2
    factor = size * below / (C * (A * a) ** 2 * rate)
    start = Along(begin, parameter).third_integral(number)
    fixed = _frame(A * p, B * q, C * r) * gamma

    def state(t: mpf) -> list[mpf]:
        at = Along(begin + rate * t, parameter)
        p, q, r = a * at.cn, b * at.sn, c * at.dn
        psi = size / C * t + factor * (at.third_integral(number) - start)
        cos, sin = mpmath.cos(psi), mpmath.sin(psi)
        # fixed in space, so turned back by psi about G against the body's node
        turn = mpmath.matrix([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
        return [p, q, r, *(_frame(A * p, B * q, C * r).T * turn * fixed)]

    return state


def _frame(x: mpf, y: mpf, z: mpf) -> Any:
    """Rows: the node of axis 3 about (x, y, z), what makes it right-handed, and (x, y, z)."""
    across, size = mpmath.hypot(x, y), mpmath.norm([x, y, z])
    return mpmath.matrix(
        [
            [y / across, -x / across, 0],
            [x * z / across / size, y * z / across / size, -across / size],
            [x / size, y / size, z / size],
        ]
    )
