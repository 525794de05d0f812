"""The integral of a smooth function over an interval, as a Chebyshev series.

In ph, x = begin + (end - begin)(1 - cos ph)/2, the series is one of cosines (Clenshaw and Curtis,
Numer. Math. 2 (1960) 197).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from polhode.closed_forms.functions.fourier import WaveSeries, cosines
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar


@dataclass(frozen=True)
class Integral:
    """The integral from ``begin`` to anywhere up to ``end``."""

    begin: Scalar
    end: Scalar
    series: WaveSeries
    origin: Scalar  # of the series, at ``begin``

    def at(self, x: Scalar) -> Scalar:
        """The integral from begin to x."""
        cosine = 1 - 2 * (x - self.begin) / (self.end - self.begin)
        ph = mpmath.acos(max(mpf(-1), min(mpf(1), cosine)))
        return self.series.at(ph) - self.origin


def node(begin: Scalar, end: Scalar, j: int, count: int) -> Scalar:
    """Where a series of ``count`` samples asks the function, j = 0 ... count/2."""
    return _place(begin, end, mpmath.pi * (mpf(2 * j) / count))


def integral(
    function: Callable[[Scalar], Scalar],
    begin: Scalar,
    end: Scalar,
    *,
    first: int = 0,
    most: int,
    spoiled: int = 0,
) -> Integral:
    """The series at the precision in force.

    ``first``: a guess of the samples of a circle; ``spoiled``: the last bits of the values that are
    not right.  Beyond ``most`` samples TooManyTerms is raised.
    """
    half = (end - begin) / 2
    (found,) = cosines(lambda ph: [half * function(_place(begin, end, ph))], first, most, spoiled)
    series = found.times_sine()
    return Integral(begin, end, series, series.at(mpf(0)))


def _place(begin: Scalar, end: Scalar, ph: Scalar) -> Scalar:
    return begin + (end - begin) / 2 * (1 - mpmath.cos(ph))
