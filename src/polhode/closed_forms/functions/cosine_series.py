"""Cosine series of even periodic functions: trapezoid sums by a fast Fourier transform.

F(x) = A_0 + sum A_k cos k x of an analytic even function of period 2 pi: the values at pi j/N give
the coefficients up to N, with an error of the size of those left out (Trefethen & Weideman, SIAM
Rev. 56 (2014) 385).  N is doubled until the last ones are below the precision.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

from polhode.numbers.private import mpc, mpf, mpmath

_FIRST = 32
_MOST = 1 << 13
_GUARD = 24  # bits that the values carry more: their rounding must not look like a tail


def cosine_series(F: Callable[[Any], Any]) -> list[Any]:
    """A_0, A_1, ... of F, given as a function of cos x, at the precision in force.

    Raises ArithmeticError where more than 8192 terms would be needed.
    """
    precision = mpmath.prec
    with mpmath.extraprec(_GUARD):
        return _grown(F, precision)


def _grown(F: Callable[[Any], Any], precision: int) -> list[Any]:
    count: int = _FIRST
    known: dict[int, Any] = {}
    while count <= _MOST:
        cosines = _cosines(2 * count, mpmath.prec)
        for j in range(count + 1):
            place = j * (_MOST // count)
            if place not in known:
                known[place] = F(cosines[j].real)
        found = _coefficients([known[j * (_MOST // count)] for j in range(count + 1)])
        size = max(abs(x) for x in found)
        small = mpmath.ldexp(size, -precision)
        if max(abs(x) for x in found[-4:]) <= small:
            while len(found) > 1 and abs(found[-1]) <= small / 4:
                found.pop()
            return found
        count *= 2
    raise ArithmeticError("a motion too near a degenerate one: its Fourier series is too long")


def integral(series: Sequence[Any], x: Any) -> Any:
    """A_0 x + sum A_k sin(k x)/k (Clenshaw 1955); ``series`` from :func:`integrated`."""
    c, s = mpmath.cos_sin(x)
    one, two = mpf(0), mpf(0)
    for a in reversed(series[1:]):
        one, two = 2 * c * one - two + a, one
    return series[0] * x + s * one


def integrated(series: Sequence[Any]) -> list[Any]:
    """A_0 and A_k/k."""
    return [series[0], *(a / k for k, a in enumerate(series[1:], 1))]


def _coefficients(values: Sequence[Any]) -> list[Any]:
    """From the values at pi j/n, j = 0 ... n; n is a power of two."""
    n = len(values) - 1
    points = [mpc(x) for x in (*values, *values[n - 1 : 0 : -1])]
    found = [z.real / n for z in _transform(points)[: n + 1]]
    found[0] /= 2
    found[-1] /= 2
    return found


def _transform(points: list[Any]) -> list[Any]:
    """sum_j z_j exp(-2 pi i j k/n), n a power of two (Cooley & Tukey 1965)."""
    n = len(points)
    if n == 1:
        return points
    even, odd = _transform(points[::2]), _transform(points[1::2])
    turned = [w.conjugate() * z for w, z in zip(_cosines(n, mpmath.prec), odd, strict=False)]
    return [a + b for a, b in zip(even, turned, strict=True)] + [
        a - b for a, b in zip(even, turned, strict=True)
    ]


@functools.lru_cache(maxsize=32)
def _cosines(n: int, prec: int) -> tuple[Any, ...]:
    """exp(2 pi i j/n) for j = 0 ... n/2."""
    with mpmath.workprec(prec):
        return tuple(mpmath.expjpi(mpf(2 * j) / n) for j in range(n // 2 + 1))
