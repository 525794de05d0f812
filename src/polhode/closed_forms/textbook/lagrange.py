"""Lagrange's top by Jacobi's functions of mpmath, phi by Legendre's third integral.

Axis 3 is the axis of symmetry, through the centre of mass.  With u = cos th = gamma3 (Whittaker,
Analytical Dynamics, art. 71; Goldstein, Classical Mechanics, section 5.7):

    u'^2 = a(b - u)(1 - u^2) - (F - n u)^2,    u = u1 + (u2 - u1) sn^2,
    psi' = (F - n u)/(1 - u^2),
    phi' = r - u psi' = r - n - (F - n)/(2(1 - u)) + (F + n)/(2(1 + u)).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from polhode.closed_forms.textbook.legendre import TooFewDigits, third_integral
from polhode.closed_forms.textbook.vectors import Row
from polhode.numbers.mpmath_context import mpf, mpmath

_EQUAL = 2**20  # rounding errors by which two equal roots may differ


def motion(
    equatorial: mpf, axial: mpf, weight: mpf, omega: Sequence[mpf], gamma: Sequence[mpf]
) -> Callable[[mpf], Row]:
    """The state p q r gamma1 gamma2 gamma3 in the top's axes, as a function of time.

    ``equatorial``, ``axial``: the moments.  ``weight``: Mg z0 > 0.  ``omega``, ``gamma``: at t = 0.
    Raises ValueError for a motion through a pole, where psi and phi have no rates.
    """
    (p, q, r), (g1, g2, u0) = omega, gamma
    a, n = 2 * weight / equatorial, axial * r / equatorial
    turning = p * g1 + q * g2
    F, b = turning + n * u0, u0 + (p * p + q * q) / a
    near = mpmath.sqrt(mpmath.eps)
    cubic = [a * b - F * F, 2 * F * n - a, -a * b - n * n, a]
    roots = mpmath.polyroots(cubic, asc=True, maxsteps=400, extraprec=4 * mpmath.prec)
    u1, u2, u3 = sorted(mpmath.re(z) for z in roots)
    if max(u2, u0) >= 1 - near or min(u1, u0) <= -1 + near:  # of nearly triple roots u0 knows more
        raise ValueError("a motion through a pole, where psi and phi have no rates")
    phi0 = mpmath.atan2(g1, g2)

    def psi_rate(u: mpf) -> mpf:
        return (F - n * u) / (1 - u * u)

    if u2 - u1 < _EQUAL * mpmath.eps:  # steady, or a pair that only rounding made complex
        if max(abs(mpmath.im(z)) for z in roots) > _EQUAL * near * mpmath.sqrt(1 - u0 * u0):
            raise TooFewDigits("three roots are equal to this precision")
        rate = r - u0 * psi_rate(u0)
        return lambda t: _state(u0, mpmath.mpf(0), psi_rate(u0), phi0 + rate * t, r)

    parameter = (u2 - u1) / (u3 - u1)
    rate = mpmath.sqrt(a * (u3 - u1)) / 2
    sine = mpmath.sqrt(min(1, max(0, (u0 - u1) / (u2 - u1))))
    way = -1 if g1 * q - g2 * p < 0 else 1
    phase = way * mpmath.ellipf(mpmath.asin(sine), parameter)

    def turned(v: mpf) -> mpf:
        """phi without its growth at the rate r - n."""
        above = third_integral((u2 - u1) / (1 - u1), v, parameter) * (F - n) / (1 - u1)
        below = third_integral((u1 - u2) / (1 + u1), v, parameter) * (F + n) / (1 + u1)
        return (below - above) / (2 * rate)

    begin = turned(phase)

    def state(t: mpf) -> Row:
        v = phase + rate * t
        sn, cn, dn = (mpmath.ellipfun(kind, v, m=parameter) for kind in ("sn", "cn", "dn"))
        u = u1 + (u2 - u1) * sn * sn
        slope = 2 * rate * (u2 - u1) * sn * cn * dn
        return _state(u, slope, psi_rate(u), phi0 + (r - n) * t + turned(v) - begin, r)

    return state


def _state(u: mpf, slope: mpf, psi_rate: mpf, phi: mpf, r: mpf) -> Row:
    """Euler's kinematic equations: w and gamma from the angles and their rates."""
    sine = mpmath.sqrt(1 - u * u)
    theta_rate = -slope / sine
    c, s = mpmath.cos(phi), mpmath.sin(phi)
    return [
        theta_rate * c + psi_rate * sine * s,
        psi_rate * sine * c - theta_rate * s,
        r,
        sine * s,
        sine * c,
        u,
    ]
