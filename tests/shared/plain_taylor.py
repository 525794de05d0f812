"""An integrator in plain mpmath, for motions without a closed form; it imports nothing of polhode.

    p' = ((B - C) q r + T3 g2 - T2 g3)/A, ...,    g1' = r g2 - q g3, ...,    T = Mg r0

in principal axes.  Every step sums the Taylor series of the six functions, made term by term with
Cauchy products, over a length at which the last terms are below the working precision.  Precision
is an argument: the numbers belong to a context of this call alone.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import reduce
from typing import Any

from mpmath import MPContext

CYCLE = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
SPARE = 12  # digits of the working precision beyond those asked for


def integrate(
    moments: Sequence[Fraction],
    torque: Sequence[Fraction],
    omega: Sequence[Fraction],
    gamma: Sequence[Fraction],
    times: Sequence[Fraction],
    digits: int,
) -> list[list[Fraction]]:
    """Rows p, q, r, g1, g2, g3 at the times, which lead away from 0, as exact numbers.

    The error is about 10^-digits where the motion multiplies errors by no more than 10^10.
    """
    mp = MPContext()
    mp.dps = digits + SPARE

    def number(x: Fraction) -> Any:
        return mp.mpf(x.numerator) / x.denominator

    body = [number(x) for x in moments], [number(x) for x in torque]
    state = [number(x) for x in (*omega, *gamma)]
    order = mp.dps + 4  # a radius of convergence over e^(5/2) is a step
    now, rows = mp.mpf(0), []
    for time in map(number, times):
        while now != time:
            series = terms(mp, state, body, order)
            step, left = length(mp, series), time - now
            last = step >= abs(left)
            step = left if last else mp.sign(left) * step
            state = [total(row, step) for row in series]
            now = time if last else now + step
        rows.append([exact(x) for x in state])
    return rows


def terms(mp: Any, state: Sequence[Any], body: Any, order: int) -> list[list[Any]]:
    """The Taylor coefficients of the six functions at a state, up to the order."""
    moments, torque = body
    x: list[list[Any]] = [[value] for value in state]
    for n in range(order):
        w, g = x[:3], x[3:]

        def product(a: list[Any], b: list[Any], n: int = n) -> Any:
            return mp.fdot(zip(a, b[n::-1], strict=True))

        rates = [
            ((moments[j] - moments[k]) * product(w[j], w[k]) + g[j][n] * torque[k])
            - g[k][n] * torque[j]
            for i, j, k in CYCLE
        ]
        rates = [rate / moment for rate, moment in zip(rates, moments, strict=True)]
        rates += [product(g[j], w[k]) - product(g[k], w[j]) for i, j, k in CYCLE]
        for row, rate in zip(x, rates, strict=True):
            row.append(rate / (n + 1))
    return x


def total(row: Sequence[Any], step: Any) -> Any:
    """A series at a step, by Horner's rule."""
    return reduce(lambda partial, coefficient: partial * step + coefficient, reversed(row))


def length(mp: Any, series: Sequence[Sequence[Any]]) -> Any:
    """A step over which the last two terms are below the precision of the largest number."""
    size, order = max(abs(row[0]) for row in series), len(series[0]) - 1
    steps = []
    for n in (order - 1, order):
        last = max(abs(row[n]) for row in series)
        if last:
            steps.append((size * mp.eps / last) ** (mp.mpf(1) / n))
    return min(steps) if steps else mp.inf


def exact(x: Any) -> Fraction:
    """The number that an mpf is."""
    sign, man, exponent, _ = x._mpf_
    return (-1) ** sign * int(man) * Fraction(2) ** int(exponent)
