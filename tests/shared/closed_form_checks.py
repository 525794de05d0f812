"""What the tests of all closed forms share: distances of tables, residuals, counted turns."""

import itertools
from fractions import Fraction

from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.euler.top import EulerTop
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath


def fractions(row):
    return tuple(map(Fraction, row))


def number(x):
    """An exact number as mpf, at the precision in force."""
    return mpf(exact.rounded(x, mpmath.prec))


def belongs(fits):
    """A family's ``fits`` as a function of moments, torque, omega and gamma in principal axes."""
    at_rest = (0, 0, 0), (0, 0, 1)
    return lambda moments, torque, omega=at_rest[0], gamma=at_rest[1]: fits(
        PrincipalScene(moments, torque, omega, gamma)
    )


def euler_top(moments, omega, gamma=None, psi=Fraction(0), axes=None):
    """A torque-free body."""
    return EulerTop(moments, (Fraction(0),) * 3, omega, gamma, psi, axes)


def distance(one, other, scale=1):
    """Largest difference of two tables: w over ``scale``, the rest as it is."""
    with mpmath.workdps(150):
        return max(
            abs(x - y) / (scale if i < 3 else 1)
            for a, b in zip(one, other, strict=True)
            for i, (x, y) in enumerate(zip(a, b, strict=True))
        )


def in_band(error, digits, width=20):
    """Whether an error keeps so many digits, and is no comparison of a thing with itself."""
    return mpf(10) ** (-digits - width) < error < mpf(10) ** -digits


def rational_axes(quaternion=(1, 2, 4, 2)):
    """The rotation of a quaternion of any length, by rows."""
    a, b, c, d = quaternion
    rows = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    square = a * a + b * b + c * c + d * d
    return tuple(tuple(Fraction(x, square) for x in row) for row in rows)


def in_scene(vector, axes):
    """From principal axes, given by rows in the scene's, to the scene's."""
    return tuple(
        sum((x * row[i] for x, row in zip(vector, axes, strict=True)), Fraction(0))
        for i in range(3)
    )


def full_inertia(moments, axes):
    """The inertia matrix in the scene's axes."""
    return [
        [sum(moments[k] * axes[k][i] * axes[k][j] for k in range(3)) for j in range(3)]
        for i in range(3)
    ]


def check_attitude(state, attitude, angles):
    """Quaternion, angles and gamma are one attitude, to 49 digits; psi and phi None at a pole."""
    psi, theta, phi = angles
    turned = rotation(attitude)
    assert abs(mpmath.norm(mpmath.matrix(attitude)) - 1) < mpf(10) ** -50
    assert max(abs(turned[2, i] - state[3 + i]) for i in range(3)) < mpf(10) ** -50
    c, v = mpmath.cos(theta), mpmath.sin(theta)
    assert abs(c - state[5]) < mpf(10) ** -49
    if psi is None:
        assert phi is None
        assert v < mpf(10) ** -50
        return
    third = mpmath.matrix([mpmath.sin(psi) * v, -mpmath.cos(psi) * v, c])
    assert mpmath.norm(turned[:, 2] - third) < mpf(10) ** -49
    assert abs(v * mpmath.sin(phi) - state[3]) < mpf(10) ** -49
    assert abs(v * mpmath.cos(phi) - state[4]) < mpf(10) ** -49


def rotation(q):
    """The matrix of a unit quaternion, body to space."""
    a, x, y, z = q
    return mpmath.matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - a * z), 2 * (x * z + a * y)],
            [2 * (x * y + a * z), 1 - 2 * (x * x + z * z), 2 * (y * z - a * x)],
            [2 * (x * z - a * y), 2 * (y * z + a * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def unwound(top, start, end, count):
    """The growth of psi and phi, by ``count`` principal differences of close samples."""
    rows = top.attitude([start + (end - start) * Fraction(k, count) for k in range(count + 1)], 40)
    args = []
    for i, j in ((0, 3), (1, 2)):
        points = [mpmath.mpc(row[i], row[j]) for row in rows]
        args.append(sum(mpmath.arg(b / a) for a, b in itertools.pairwise(points)))
    return args[0] + args[1], args[0] - args[1]


def error_of_1000_digits(top, times):
    """The difference between 1000 digits and 20 more, at one time."""
    with mpmath.workdps(1050):
        (x,), (y,) = top.at(times, 1000), top.at(times, 1020)
        return max(abs(a - b) for a, b in zip(x, y, strict=True))


def residuals(top, moments, torque=(0, 0, 0), step=Fraction(1, 10**40), angles=False):
    """By how much state, attitude (and psi, phi) miss their equations at t = 1.3; and psi'.

    Derivatives by the five-point rule on 200 digits; with a step of 1e-40 truncation and rounding
    are about 1e-160 each.
    """
    times = [Fraction(13, 10) + k * step for k in (-2, -1, 0, 1, 2)]
    rows = [a + b for a, b in zip(top.at(times, 200), top.attitude(times, 200), strict=True)]
    if angles:
        turns = [row[::2] for row in top.angles(times, 200)]
        if turns[2][0] is not None:
            rows = [a + b for a, b in zip(rows, turns, strict=True)]
    with mpmath.workdps(240):
        A, K = ([number(x) for x in row] for row in (moments, torque))
        one, two, now, four, five = rows
        p, q, r, g1, g2, g3, a, x, y, z = now[:10]
        slopes = [
            (s - 8 * t + 8 * u - v) / (12 * number(step))
            for s, t, u, v in zip(one, two, four, five, strict=True)
        ]
        rules = [
            ((A[1] - A[2]) * q * r + g2 * K[2] - g3 * K[1]) / A[0],
            ((A[2] - A[0]) * r * p + g3 * K[0] - g1 * K[2]) / A[1],
            ((A[0] - A[1]) * p * q + g1 * K[1] - g2 * K[0]) / A[2],
            g2 * r - g3 * q,
            g3 * p - g1 * r,
            g1 * q - g2 * p,
            -(x * p + y * q + z * r) / 2,
            (a * p + y * r - z * q) / 2,
            (a * q + z * p - x * r) / 2,
            (a * r + x * q - y * p) / 2,
        ]
        psi = mpf(0)
        if len(now) > 10:
            psi = (p * g1 + q * g2) / (g1 * g1 + g2 * g2)
            rules += [psi, r - psi * g3]
        return [abs(s - t) for s, t in zip(slopes, rules, strict=True)], abs(psi)
