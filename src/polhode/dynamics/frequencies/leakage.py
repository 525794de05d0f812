"""How far a line shifts the maximum that another makes, under the window (1 + cos)^n.

The window's transform at x bins of 2 pi/T is

    W(x) = sin(pi x)/(pi x) prod_{k=1..n} k^2/(k^2 - x^2),   W''(0) = -2 sum_{k > n} 1/k^2,

so the maximum of a line of amplitude 1 shifts by up to |b W'(x)/W''(0)| bins for another one of
amplitude b at x bins; here an upper envelope of that over all that lie as far or farther.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from polhode.numbers.rows import Doubles

_FINE, _PAST = 100, 2  # points a bin; bins past the main lobe from which on the tail's law holds


def leak(bins: Doubles, power: int) -> Doubles:
    """The largest shift, in bins, by a line of equal amplitude so many bins away or farther."""
    at, table = _table(power)
    x = np.maximum(np.abs(bins), at[-1])
    tail = np.ones_like(x)
    for k in range(1, power + 1):
        tail = tail * (at[-1] ** 2 - k * k) / (x * x - k * k)
    shift: Doubles = np.interp(np.abs(bins), at, table) * tail * at[-1] / x
    return shift


@lru_cache(maxsize=4)
def _table(power: int) -> tuple[Doubles, Doubles]:
    """The envelope where the window's transform has its main lobe, and a little beyond."""
    last = power + 1 + _PAST
    at = (np.arange((last + 1) * _FINE) + 0.5) / _FINE  # no whole number: W is a limit there
    w = np.sinc(at)
    for k in range(1, power + 1):
        w = w * k * k / (k * k - at * at)
    slope = np.abs(np.gradient(w, at))
    curve = math.pi**2 / 3 - 2 * sum(1 / k**2 for k in range(1, power + 1))
    envelope = np.maximum.accumulate(slope[::-1])[::-1] / curve
    held = at <= last
    return at[held], envelope[held]
