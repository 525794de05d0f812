"""Legendre's elliptic integral of the third kind along Jacobi's functions, by mpmath."""

from __future__ import annotations

from polhode.numbers.mpmath_context import mpf, mpmath


class TooFewDigits(ArithmeticError):
    """What differs is equal at the precision in force: the same is to be done with more digits."""


def third_integral(number: mpf, v: mpf, parameter: mpf) -> mpf:
    """The integral from 0 to v of dv/(1 - number sn^2 v), sn of the parameter m.

    Half periods of sn are counted, and the rest is Legendre's integral at the amplitude.  At m = 1
    sn is tanh, and the integral elementary: an amplitude next to pi/2 would tell nothing of v.
    """
    if parameter == 1:
        size, tanh = mpmath.sqrt(abs(number)), mpmath.tanh(v)
        if number > 0:
            return (v - size * mpmath.atanh(size * tanh)) / (1 - number)
        return (v + size * mpmath.atan(size * tanh)) / (1 - number)
    half = 2 * mpmath.ellipk(parameter)
    turns = mpmath.nint(v / half)
    rest = v - turns * half
    sn, cn = (mpmath.ellipfun(kind, rest, m=parameter) for kind in ("sn", "cn"))
    total = mpmath.ellippi(number, mpmath.atan2(sn, cn), parameter)
    return total + 2 * turns * mpmath.ellippi(number, parameter) if turns else total
