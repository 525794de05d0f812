"""Lagrange's top by Jacobi's functions of mpmath, phi by Legendre's third integral.

Axis 3 is the axis of symmetry, through the centre of mass.  With u = cos th = gamma3 (Whittaker,
Analytical Dynamics, art. 71; Goldstein, Classical Mechanics, section 5.7):

    u'^2 = a(b - u)(1 - u^2) - (F - n u)^2,    u = u1 + (u2 - u1) sn^2,
    psi' = (F - n u)/(1 - u^2),
    phi' = r - u psi' = r - n - (F - n)/(2(1 - u)) + (F + n)/(2(1 + u)).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from polhode.closed_forms.textbook.third_integral import Along
from polhode.numbers.mpmath_context import mpf, mpmath

_EQUAL = 2**20  # rounding errors by which two equal roots may differ


def motion(
    moments: Any, weight: mpf, omega: Any, gamma: Any, regime: str
) -> Callable[[mpf], list[mpf]]:
    """The state p q r gamma1 gamma2 gamma3 in the top's axes, as a function of time.

    ``moments``, ``omega``, ``gamma``: at t = 0, in these axes.  ``weight``: Mg z0 > 0.  Raises
    ValueError for a motion through a pole, where psi and phi have no rates, ArithmeticError where
    rounding makes a pair of three roots that are nearly equal.
    """
    del regime
    (p, q, r), (g1, g2, u0) = omega, gamma
    a, n = 2 * weight / moments[0], moments[2] * r / moments[0]
    F, b = p * g1 + q * g2 + n * u0, u0 + (p * p + q * q) / a
    near = mpmath.sqrt(mpmath.eps)
    cubic = [a * b - F * F, 2 * F * n - a, -a * b - n * n, a]
    roots = mpmath.polyroots(cubic, asc=True, maxsteps=400, extraprec=4 * mpmath.prec)
    u1, u2, u3 = sorted(mpmath.re(z) for z in roots)
    if max(u2, u0) >= 1 - near or min(u1, u0) <= -1 + near:  # of nearly triple roots u0 knows more
        raise ValueError("a motion through a pole, where psi and phi have no rates")
    if max(abs(mpmath.im(z)) for z in roots) > _EQUAL * near * mpmath.sqrt(1 - u0 * u0):
        raise ArithmeticError("three roots are equal to this precision")
    parameter = (u2 - u1) / (u3 - u1)
    rate = mpmath.sqrt(a * (u3 - u1)) / 2
    steady = u2 - u1 < _EQUAL * mpmath.eps
    sine = 0 if steady else mpmath.sqrt(min(1, max(0, (u0 - u1) / (u2 - u1))))
    way = -1 if g1 * q - g2 * p < 0 else 1
    begin = way * mpmath.ellipf(mpmath.asin(sine), parameter)

    def turned(at: Along) -> mpf:
        """phi without its growth at the rate r - n."""
        above = at.third_integral((u2 - u1) / (1 - u1)) * (F - n) / (1 - u1)
        below = at.third_integral((u1 - u2) / (1 + u1)) * (F + n) / (1 + u1)
        return (below - above) / (2 * rate)

    phi0 = mpmath.atan2(g1, g2) - turned(Along(begin, parameter))

    def state(t: mpf) -> list[mpf]:
        at = Along(begin + rate * t, parameter)
        u = u1 + (u2 - u1) * at.sn * at.sn
        phi = phi0 + (r - n) * t + turned(at)
        # Euler's kinematic equations
        sine, c, s = mpmath.sqrt(1 - u * u), mpmath.cos(phi), mpmath.sin(phi)
        tilting = -2 * rate * (u2 - u1) * at.sn * at.cn * at.dn / sine  # theta'
        turning = (F - n * u) / sine  # psi' sin theta
        w = [tilting * c + turning * s, turning * c - tilting * s, r]
        return [*w, sine * s, sine * c, u]

    return state
