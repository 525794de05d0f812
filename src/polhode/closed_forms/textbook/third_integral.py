"""Jacobi's elliptic functions, and Legendre's integral of the third kind by Carlson's R_J."""

from __future__ import annotations

from polhode.numbers.mpmath_context import mpf, mpmath


class Along:
    """``sn``, ``cn`` and ``dn`` at v to the parameter m, and integrals from 0 to there.

    Half periods of sn are counted; at m = 1 there are none.
    """

    def __init__(self, v: mpf, parameter: mpf) -> None:
        self._v, self._parameter = v, parameter
        self._turns, rest = mpmath.mpf(0), v
        if parameter < 1:
            half = 2 * mpmath.ellipk(parameter)
            self._turns = mpmath.nint(v / half)
            rest = v - self._turns * half
        self._sn, self._cn, self.dn = (
            mpmath.ellipfun(kind, rest, m=parameter) for kind in ("sn", "cn", "dn")
        )
        side = -1 if self._turns % 2 else 1
        self.sn, self.cn = side * self._sn, side * self._cn

    def third_integral(self, number: mpf) -> mpf:
        """The integral of dv/(1 - number sn^2 v) (DLMF 19.25.14)."""
        sn2, whole = self._sn**2, mpmath.mpf(0)
        if self._turns:
            whole = 2 * self._turns * mpmath.elliprj(0, 1 - self._parameter, 1, 1 - number)
        if self._sn:
            whole += self._sn**3 * mpmath.elliprj(self._cn**2, self.dn**2, 1, 1 - number * sn2)
        return self._v + number / 3 * whole
