"""Power series of the motion in fixed-point integers: independent of the package, and quick.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    q' = q (0, w)/2

in principal axes; :mod:`shared.plain_taylor` does the same in mpmath, for numbers of any size.
Numbers are integers times 2^-bits, 60 of them beyond the digits asked for; every step sums the
series of the solution over a length at which its last terms are below the precision.
"""

import math
from operator import mul

import mpmath
from mpmath import mpf

CYCLE = ((1, 2), (2, 0), (0, 1))


def integrate(moments, torque, omega, gamma, times, digits, quaternion=None):
    """Rows p, q, r, g1, g2, g3 [, q0 ... q3, growth of arg(q0+iq3), of arg(q1+iq2)], one a time.

    All numbers are mpf; the times go away from 0.
    """
    bits = int(digits * 3.33) + 60
    order = int(0.35 * bits) + 10
    with mpmath.workprec(bits + 40):
        scale = mpf(2) ** bits

        def fixed(x):
            return int(mpmath.nint(x * scale))

        A, T = ([mpf(x) for x in row] for row in (moments, torque))
        spin = [fixed((A[j] - A[k]) / A[i]) for i, (j, k) in enumerate(CYCLE)]
        pull = [(fixed(T[k] / A[i]), fixed(T[j] / A[i])) for i, (j, k) in enumerate(CYCLE)]
        state = [fixed(x) for x in (*omega, *gamma, *(quaternion or ()))]
        now, rows, turns = mpf(0), [], [0.0, 0.0]
        for time in times:
            while now != time:
                series = _series(state, spin, pull, order, bits)
                step = _length(series, order, bits)
                left = time - now
                step = left if abs(left) <= step else mpmath.sign(left) * step
                x = fixed(step)
                before = state
                state = [_sum(row, x, bits) for row in series]
                now = time if step == left else now + step
                if quaternion is not None:
                    for n, (i, j) in enumerate(((6, 9), (7, 8))):
                        start, end = (
                            complex(s[i] / 2**bits, s[j] / 2**bits) for s in (before, state)
                        )
                        z = end * start.conjugate()
                        turns[n] += math.atan2(z.imag, z.real)
            row = [mpf(x) / scale for x in state]
            rows.append(row + (turns[:] if quaternion is not None else []))
    return rows


def _series(state, spin, pull, order, bits):
    x = [[c] for c in state]
    for n in range(order):
        w, g, q = x[0:3], x[3:6], x[6:10]

        def times(a, b, n=n):
            return sum(map(mul, a, b[n::-1])) >> bits

        new = []
        for i, (j, k) in enumerate(CYCLE):
            torque = (g[j][n] * pull[i][0] - g[k][n] * pull[i][1]) >> bits
            new.append(((spin[i] * times(w[j], w[k])) >> bits) + torque)
        new += [times(g[j], w[k]) - times(g[k], w[j]) for j, k in CYCLE]
        if q:
            new += [
                -(times(q[1], w[0]) + times(q[2], w[1]) + times(q[3], w[2])) // 2,
                (times(q[0], w[0]) + times(q[2], w[2]) - times(q[3], w[1])) // 2,
                (times(q[0], w[1]) + times(q[3], w[0]) - times(q[1], w[2])) // 2,
                (times(q[0], w[2]) + times(q[1], w[1]) - times(q[2], w[0])) // 2,
            ]
        for row, c in zip(x, new, strict=True):
            row.append(c // (n + 1))
    return x


def _sum(series, step, bits):
    total = 0
    for c in reversed(series):
        total = ((total * step) >> bits) + c
    return total


def _length(series, order, bits):
    """A step over which the last terms are below the precision: all numbers are of order 1."""
    step = mpf(1) / 2
    for n in (order - 1, order):
        last = max(abs(row[n]) for row in series)
        if last:
            step = min(step, (mpf(1) / last) ** (mpf(1) / n))
    return step
