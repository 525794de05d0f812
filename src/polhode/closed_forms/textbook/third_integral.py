"""Legendre's elliptic integral of the third kind along Jacobi's functions, by Carlson's R_J."""

from __future__ import annotations

from polhode.numbers.mpmath_context import mpf, mpmath


def third_integral(number: mpf, v: mpf, parameter: mpf) -> mpf:
    """The integral from 0 to v of dv/(1 - number sn^2 v), sn of the parameter m (DLMF 19.25.14).

    Half periods of sn are counted; at m = 1 there are none.
    """
    turns = mpmath.mpf(0)
    rest, whole = v, mpmath.mpf(0)
    if parameter < 1:
        half = 2 * mpmath.ellipk(parameter)
        turns = mpmath.nint(v / half)
        rest = v - turns * half
        whole = 2 * turns * mpmath.elliprj(0, 1 - parameter, 1, 1 - number) if turns else whole
    sn, cn, dn = (mpmath.ellipfun(kind, rest, m=parameter) for kind in ("sn", "cn", "dn"))
    part = sn**3 * mpmath.elliprj(cn**2, dn**2, 1, 1 - number * sn**2)
    return v + number / 3 * (part + whole)
