"""Theta functions of a real variable as polynomials, in balls: the same ones at many rows.

With q = e^(-pi s), c = cos 2 pi z and Chebyshev's polynomials T, U (DLMF 18.5, 20.2)

    th3(z), th4(z) = 1 + sum a_n cos 2 pi n z,    a_n = 2 (+-1)^n q^(n^2),  cos 2 pi n z = T_n(c),
    th1(z) = sin pi z sum b_n (-1)^n W_n(c),      W_n = sin (2n + 1) pi z/sin pi z,
    th2(z) = cos pi z sum b_n V_n(c),             V_n = cos (2n + 1) pi z/cos pi z,

with b_n = 2 q^((n + 1/2)^2), and at a fixed distance above the real line

    Re th3, th4(z + i y) = 1 + sum a_n cosh(2 pi n y) T_n(c),
    Im th3, th4(z + i y) = -sin 2 pi z sum a_n sinh(2 pi n y) U_(n-1)(c).

All four kinds of polynomials have the recurrence p_(n+1) = 2c p_n - p_(n-1), and for real z they
are at most 2n + 1.  What is left out is bounded by twice its first term, once the terms are proven
to fall by half.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from flint import arb, arb_poly, fmpz_poly

from polhode.closed_forms.balls.core import TooFewBits
from polhode.numbers.flint_context import ctx

#: Below this s the series are long and cancel; FLINT's own functions turn it into 1/s.
LEAST = 1 / 16
_T, _U, _V, _W = (fmpz_poly(p) for p in ([0, 1], [], [1], [-1]))  # each before the first, 1
_TWICE = fmpz_poly([0, 2])


class ThetaSeries:
    """The functions of one ``s`` = tau/i, real and at least :data:`LEAST`."""

    def __init__(self, s: arb) -> None:
        self._s = s
        odd = self._weights(1, arb(0))
        signed = [-b if n % 2 else b for n, b in enumerate(odd)]
        even = self._weights(0, arb(0))
        self.th1, self.th2 = _sum(signed, _W), _sum(odd, _V)
        self.th3, self.th4 = _sum(even, _T), _sum(_alternating(even), _T)

    def above(self, y: arb, *, third: bool) -> tuple[arb_poly, arb_poly]:
        """The real part of th4(z + i y), or th3, and the imaginary one over sin 2 pi z."""
        up, down = self._weights(0, y), self._weights(0, -y)
        real = [(a + b) / 2 for a, b in zip(up, down, strict=True)]
        imaginary = [(b - a) / 2 for a, b in zip(up, down, strict=True)]
        if not third:
            real, imaginary = _alternating(real), _alternating(imaginary)
        imaginary[1] += imaginary[0]  # nothing but the ball of what is left out
        return _sum(real, _T), _sum(imaginary[1:], _U)

    def _weights(self, odd: int, y: arb) -> list[arb]:
        """2 q^(m^2) e^(2 pi m y) with m = n + ``odd``/2, of n = 0 half if it is even.

        In the first is a ball of what all those left out give, of polynomials up to 2n + 1.
        """
        least, most = self._s.lower(), y.abs_upper()
        reach, width = float(most), float(least)
        if not (math.isfinite(reach) and width > 0):
            raise TooFewBits
        count = 1 + math.ceil(reach / width + math.sqrt(ctx.prec * math.log(2) / (math.pi * width)))

        def weight(n: int, s: arb, y: arb) -> arb:
            m = arb(2 * n + odd) / 2
            return 2 * (arb.pi() * m * (2 * y - s * m)).exp()

        first, second = ((2 * n + 1) * weight(n, least, most) for n in (count, count + 1))
        if not 2 * second < first:  # the ratios fall from one to the next
            raise TooFewBits
        found = [weight(n, self._s, y) for n in range(count)]
        if not odd:
            found[0] = arb(1)
        found[0] += arb(0, (2 * first).abs_upper())
        return found


def _alternating(weights: Sequence[arb]) -> list[arb]:
    return [-a if n % 2 else a for n, a in enumerate(weights)]


def _sum(weights: Sequence[arb], before: fmpz_poly) -> arb_poly:
    """The sum of the polynomials with so many weights, of which the first is 1."""
    total, polynomial = arb_poly([0]), fmpz_poly([1])
    for weight in weights:
        total += arb_poly(polynomial) * weight
        before, polynomial = polynomial, _TWICE * polynomial - before
    return total
