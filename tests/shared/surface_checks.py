"""What the tests of the motions on a surface of their own share: Goryachev-Chaplygin and Hess.

``make(moments, torque, omega, gamma)`` gives a closed form; a start is these four, in principal
axes.  Errors lie in bands: below what is asked, and above 1e-90, so that nothing is compared with
itself.
"""

import itertools
from fractions import Fraction

import numpy as np

from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared import orbit_checks
from shared.closed_form_checks import number

F = Fraction
LEAST = mpf("1e-90")

#: A rational rotation: row i of a turned vector.
TURN = ((F(1, 3), F(2, 3), F(2, 3)), (F(-2, 3), F(2, 3), F(-1, 3)), (F(-2, 3), F(-1, 3), F(2, 3)))


def largest(one, other):
    """The largest difference of two rows."""
    with mpmath.workdps(120):
        return max(abs(x - y) for x, y in zip(one, other, strict=True))


def off(make, start, times, digits=40, attitudes=False):
    """The largest difference of a closed form from a Taylor run that shares nothing with it."""
    found, first = make(*start), None
    rows = found.at(times, digits)
    if attitudes:
        first = found.attitude([F(0)], digits)[0]
        rows = [a + b for a, b in zip(rows, found.attitude(times, digits), strict=True)]
    truth = orbit_checks.taylor(start, times, digits, first)
    return max(largest(a, b[: len(a)]) for a, b in zip(rows, truth, strict=True))


def check_stored(make, group):
    """Stored values that no formula here was tuned to: 50 digits printed."""
    cases = orbit_checks.data(group)
    assert cases
    for start, times, states in cases:
        rows = make(*start).at(times, 50)
        with mpmath.workdps(60):
            for row, expected in zip(rows, states, strict=True):
                assert largest(row, expected) < mpf("5e-50")


def check_equations(make, start, bound):
    """The six equations by the five-point rule at 60 digits: truncation, rounding about 1e-48."""
    found, step = make(*start), F(1, 10**12)
    one, two, now, four, five = found.at([F(13, 10) + k * step for k in (-2, -1, 0, 1, 2)], 65)
    with mpmath.workdps(80):
        (A, B, C), (K1, K2, K3) = ([number(x) for x in row] for row in start[:2])
        p, q, r, g1, g2, g3 = now
        rules = [
            ((B - C) * q * r + g2 * K3 - g3 * K2) / A,
            ((C - A) * r * p + g3 * K1 - g1 * K3) / B,
            ((A - B) * p * q + g1 * K2 - g2 * K1) / C,
        ]
        rules += [g2 * r - g3 * q, g3 * p - g1 * r, g1 * q - g2 * p]
        for s, t, u, v, rule in zip(one, two, four, five, rules, strict=True):
            slope = (s - 8 * t + 8 * u - v) / (12 * number(step))
            assert abs(slope - rule) < bound


def turned(v):
    """A vector in axes turned by TURN."""
    return tuple(sum(TURN[i][j] * v[j] for j in range(3)) for i in range(3))


def turned_scene(start, kind="auto", move=0):
    """The start in turned axes, p larger by ``move``."""
    moments, torque, omega, gamma = start
    inertia = tuple(
        tuple(sum(TURN[i][k] * moments[k] * TURN[j][k] for k in range(3)) for j in range(3))
        for i in range(3)
    )
    body = Body(inertia, turned(torque), F(1))
    w = turned((omega[0] + move, *omega[1:]))
    return Scene(body=body, omega=w, gamma=turned(gamma), reference=kind)


def check_turned(make, form, start):
    """A closed form found in turned axes gives the same motion."""
    (row,), (plain,) = form.at([F(2)], 30), make(*start).at([F(2)], 30)
    with mpmath.workdps(50):
        for part in (slice(0, 3), slice(3, 6)):
            expected = [
                sum(number(x) * y for x, y in zip(line, plain[part], strict=True)) for line in TURN
            ]
            assert largest(row[part], expected) < mpf("1e-29")


def check_period(make, start):
    """After a period the state is the start's, and not after a part of it."""
    found = make(*start)
    period = found.period(40)
    with mpmath.workdps(80):
        body = found.frequencies(40)["body"]
        assert abs(body * period - 2 * mpmath.pi) < mpf("1e-38")
        times = [F(int(mpmath.nint(mpmath.ldexp(period / n, 160))), 2**160) for n in (1, 2, 3, 5)]
    row, *parts = found.at(times, 40)
    with mpmath.workdps(60):
        begin = [number(x) for x in (*start[2], *start[3])]
        assert largest(row, begin) < mpf("1e-37")
        assert min(largest(part, begin) for part in parts) > 1e-6


def check_frequencies(make, start, names):
    """gamma1 over 100 units of time is a sum of waves of two frequencies, up to the order 8.

    Of no other two: what is left over grows a hundredfold where one of them is off by 1e-3.
    """
    found, times = make(*start), [F(2 * k, 7) for k in range(350)]
    values = np.array([float(row[3]) for row in found.at(times, 15)])
    told = found.frequencies(20)
    assert list(told) == list(names)
    pairs = itertools.product(range(9), range(-8, 9))
    orders = np.array([(j, k) for j, k in pairs if (j, k) > (0, 0) and j + abs(k) <= 8])

    def left_over(rates):
        waves = np.exp(1j * np.outer(np.array(times, dtype=float), orders @ rates))
        columns = np.hstack([np.ones((len(times), 1)), waves.real, waves.imag])
        return np.abs(columns @ np.linalg.lstsq(columns, values, rcond=None)[0] - values).max()

    rates = np.array([float(x) for x in told.values()])
    right = left_over(rates)
    assert right < 1e-4
    assert min(left_over(rates * (1.001, 1)), left_over(rates * (1, 1.001))) > 100 * right
