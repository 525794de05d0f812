"""What the tests of the families with one orbit share: the same questions to each of them.

A start is moments, Mg r0, omega, gamma, in principal axes.  Errors are asked to lie in a band: more
than 0 digits beyond those asked for (a check that compares a thing with itself is none), never
fewer.
"""

import itertools
import json
import random
from fractions import Fraction
from pathlib import Path

import pytest

from polhode.closed_forms._engine.normal_form import shortfall
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.numbers import exact
from polhode.numbers.expression import number as parsed
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import fast_series
from shared.closed_form_checks import distance, number

F = Fraction
PSI = F(7, 10)
TINY = F(1, 10**30)
DATA = Path(__file__).parents[1] / "data" / "other-50-digits.json"
EVEN = ((0, 1, 2), (1, 2, 0), (2, 0, 1))

#: A rational rotation: rows are axes of the body in the scene's axes.
ROWS = (
    (F(2, 3), F(-1, 3), F(2, 3)),
    (F(2, 3), F(2, 3), F(-1, 3)),
    (F(-1, 3), F(2, 3), F(2, 3)),
)


def seen(v):
    """A vector in the scene's axes, where ROWS are the principal ones."""
    return tuple(sum(ROWS[i][j] * v[i] for i in range(3)) for j in range(3))


def renamed(start, order, signs):
    """The same motion in axes of other names and senses: w is axial, the rest polar."""
    moments, torque, omega, gamma = start
    side = signs[0] * signs[1] * signs[2] * (1 if order in EVEN else -1)
    return (
        tuple(moments[i] for i in order),
        tuple(s * torque[i] for s, i in zip(signs, order, strict=True)),
        tuple(side * s * omega[i] for s, i in zip(signs, order, strict=True)),
        tuple(s * gamma[i] for s, i in zip(signs, order, strict=True)),
    )


def all_names():
    """All 48 orders and senses of the axes."""
    return itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3))


def some_names():
    """Eight of them: every order, and every choice of senses."""
    orders = itertools.cycle(itertools.permutations(range(3)))
    return zip(orders, itertools.product((1, -1), repeat=3), strict=False)


def back(row, order, signs):
    """A state in the first axes again."""
    found = [None] * 6
    side = signs[0] * signs[1] * signs[2] * (1 if order in EVEN else -1)
    for n, (i, s) in enumerate(zip(order, signs, strict=True)):
        found[i] = row[n] if side * s > 0 else _negated(row[n])
        found[3 + i] = row[3 + n] if s > 0 else _negated(row[3 + n])
    return found


def _negated(x):
    """-x with all its digits, whatever the precision in force."""
    return mpmath.fneg(x, exact=True)


def data(group):
    """The stored scenes of a group: start, times, states."""
    found = []
    for case in json.loads(DATA.read_text())["cases"]:
        if case["group"] != group:
            continue
        weight = parsed(case["weight"])
        rows = [tuple(map(parsed, case[k])) for k in ("moments", "centre", "omega", "gamma")]
        rows[1] = tuple(weight * x for x in rows[1])
        with mpmath.workdps(60):
            states = [[mpf(x) for x in row] for row in case["states"]]
        found.append((tuple(rows), list(map(parsed, case["times"])), states))
    return found


def taylor(start, times, digits, quaternion=None):
    with mpmath.workdps(digits + 30):
        rows = [[number(x) for x in row] for row in start]
        times = [number(t) for t in times]
    return fast_series.integrate(*rows, times, digits, quaternion)


def relative(one, other):
    """The distance of two tables of states, w over its largest value in them."""
    with mpmath.workdps(150):
        scale = max([abs(x) for row in one for x in row[:3]]) or mpf(1)
        return distance(one, other, scale)


def check_stored(family, group, digits=50):
    """Stored values that no formula here was tuned to: 50 digits printed."""
    cases = data(group)
    assert cases
    for start, times, states in cases:
        error = relative(states, family(*start).at(times, digits + 5))
        assert error < 2 * mpf(10) ** (1 - digits), mpmath.nstr(error, 3)
        assert error > mpf(10) ** (-digits - 10)  # they are rounded


def check_two_precisions(family, start):
    top = family(*start, PSI)
    far = [F(0), F(7, 3), F(-11), F(10**4), F(-(10**9))]
    for low, high, answers in ((20, 35, top.at), (50, 90, top.at), (20, 35, top.attitude)):
        error = distance(answers(far, low), answers(far, high))
        assert error < 4 * mpf(10) ** -low
        assert error == 0 or error > mpf(10) ** (-low - 20)
    assert distance(top.angles(far[1:], 20), top.angles(far[1:], 35)) < mpf(10) ** -20


def slopes(answers, digits):
    """The rows at t = 1.3 and their derivatives: five points, a step of digits/5 places.

    Truncation and rounding are about 10^(-4 digits/5) each.
    """
    step = F(1, 10 ** (digits // 5))
    rows = answers([F(13, 10) + k * step for k in (-2, -1, 0, 1, 2)])
    one, two, now, four, five = rows
    return now, [
        (s - 8 * t + 8 * u - v) / (12 * number(step))
        for s, t, u, v in zip(one, two, four, five, strict=True)
    ]


def check_equations(family, start):
    """The residual of the six equations at 200 digits, of attitude and angles at 30."""
    top = family(*start, PSI)
    with mpmath.workdps(230):
        A, K = ([number(x) for x in row] for row in start[:2])
        now, found = slopes(lambda times: top.at(times, 200), 200)
        p, q, r, g1, g2, g3 = now
        rules = [
            ((A[1] - A[2]) * q * r + g2 * K[2] - g3 * K[1]) / A[0],
            ((A[2] - A[0]) * r * p + g3 * K[0] - g1 * K[2]) / A[1],
            ((A[0] - A[1]) * p * q + g1 * K[1] - g2 * K[0]) / A[2],
            g2 * r - g3 * q,
            g3 * p - g1 * r,
            g1 * q - g2 * p,
        ]
        error = max(abs(s - t) for s, t in zip(found, rules, strict=True))
        assert mpf(10) ** -200 < error < mpf(10) ** -150, mpmath.nstr(error, 3)
    with mpmath.workdps(80):
        (a, x, y, z), found = slopes(lambda times: top.attitude(times, 30), 30)
        rules = [
            -(x * p + y * q + z * r) / 2,
            (a * p + y * r - z * q) / 2,
            (a * q + z * p - x * r) / 2,
            (a * r + x * q - y * p) / 2,
        ]
        turns = slopes(lambda times: [row[::2] for row in top.angles(times, 30)], 30)[1]
        rate = (p * g1 + q * g2) / (g1 * g1 + g2 * g2)
        rules += [rate, r - rate * g3]
        error = max(abs(s - t) for s, t in zip(found + turns, rules, strict=True))
        assert mpf(10) ** -30 < error < mpf(10) ** -20 * (1 + abs(rate)), mpmath.nstr(error, 3)


def check_taylor(family, start, times=(7.3,), digits=40):
    """An integration that shares nothing, both ways in time; attitude and psi at 20 digits."""
    top = family(*start, PSI)
    for moments in ([F(str(t)) for t in times], [F(-26, 5)]):
        error = relative(taylor(start, moments, digits), top.at(moments, digits))
        assert mpf(10) ** (-digits - 15) < error < mpf(10) ** (1 - digits), mpmath.nstr(error, 3)
    moments, attitude = [F(26, 5)], top.attitude([F(0)], 30)[0]
    (row,) = taylor(start, moments, 20, attitude)
    with mpmath.workdps(30):
        assert distance([row[6:10]], top.attitude(moments, 20)) < mpf(10) ** -19
        (one, _, other), (psi, _, phi) = top.angles([F(0), *moments], 20)
        grown = psi - one, phi - other
        assert abs(grown[0] - row[10] - row[11]) < 1e-13
        assert abs(grown[1] - row[10] + row[11]) < 1e-13


def check_names_and_axes(family, start, names=some_names):
    """Axes renamed, reflected and turned: the same regime and motion."""
    plain, times = family(*start, PSI), [F(7, 3), F(-4)]
    rows = plain.at(times, 40)
    for order, signs in names():
        other = family(*renamed(start, order, signs), PSI)
        assert other.regime == plain.regime
        found = [back(row, order, signs) for row in other.at(times, 40)]
        assert relative(rows, found) < mpf(10) ** -39
    moments, torque, omega, gamma = start
    turned = family(moments, torque, seen(omega), seen(gamma), PSI, ROWS)
    assert turned.regime == plain.regime
    with mpmath.workdps(50):
        sought = [[*seen_mpf(row[:3]), *seen_mpf(row[3:])] for row in rows]
    assert relative(sought, turned.at(times, 40)) < mpf(10) ** -39
    attitudes = turned.attitude(times, 20), plain.attitude(times, 20)
    starts = turned.attitude([F(0)], 20)[0], plain.attitude([F(0)], 20)[0]
    with mpmath.workdps(30):
        one, other = (
            [growth(q, begin) for q in rows] for rows, begin in zip(attitudes, starts, strict=True)
        )
        assert distance(one, [[c, *seen_mpf(v)] for c, *v in other]) < mpf(10) ** -18


def growth(q, start):
    """start^-1 q: the turn since the start, in the body's axes."""
    a, x, y, z = start[0], -start[1], -start[2], -start[3]
    b, u, v, w = q
    return [
        a * b - x * u - y * v - z * w,
        a * u + x * b + y * w - z * v,
        a * v - x * w + y * b + z * u,
        a * w + x * v - y * u + z * b,
    ]


def seen_mpf(v):
    return [sum(number(ROWS[i][j]) * v[i] for i in range(3)) for j in range(3)]


def check_backward(family, start):
    """Time reversed: w -> -w, and the motion runs back."""
    moments, torque, omega, gamma = start
    plain = family(*start)
    reverse = family(moments, torque, tuple(-x for x in omega), gamma)
    assert reverse.regime == plain.regime
    rows = [[*map(_negated, row[:3]), *row[3:]] for row in reverse.at([F(-5, 2), F(9)], 40)]
    assert relative(plain.at([F(5, 2), F(-9)], 40), rows) < mpf(10) ** -39


def check_membership(family, start, frozen=()):
    """Any datum changed by 1e-30 is refused, and the condition that fails is named.

    ``frozen``: (row, column) of data that the family leaves free.
    """
    scene = tuple(tuple(map(exact.exact, row)) for row in start)
    assert shortfall(family.conditions, PrincipalScene(*scene)) is None
    for i, j in itertools.product((0, 1, 2), range(3)):
        if (i, j) in frozen:
            continue
        rows = [list(row) for row in scene]
        rows[i][j] = rows[i][j] + TINY
        changed = tuple(map(tuple, rows))
        with pytest.raises(ValueError, match="not a motion"):
            family(*changed)
        found = shortfall(family.conditions, PrincipalScene(*changed))
        assert found is not None
        assert found.condition
        assert 1e-34 < float(found.off) < 1e-26, (i, j, str(found))


def check_random(family, member, seeds):
    """Members at random, their axes renamed at random, against Taylor runs."""
    regimes = set()
    for seed in seeds:
        rng = random.Random(seed)
        start = member(rng)
        order = tuple(rng.sample(range(3), 3))
        start = renamed(start, order, [rng.choice((1, -1)) for _ in range(3)])
        top = family(*start)
        regimes.add(top.regime)
        sense = rng.choice((1, -1))
        with mpmath.workdps(40):
            rate = mpmath.sqrt(number(max(exact.ONE, sum(x * x for x in start[2]))))
            t = F(sense * int(1000 * 3 / rate), 1000)
        error = relative(taylor(start, [t], 25), top.at([t], 25))
        assert error < mpf(10) ** -24, (seed, top.regime, mpmath.nstr(error, 3))
    return regimes


def check_period(family, start):
    top = family(*start)
    period = top.period(60)
    assert abs(top.frequencies(60)["body"] * period - 2 * mpmath.pi) < 1e-14
    with mpmath.workdps(70):
        exactly = exact.binary(*_parts(period))
        assert relative(top.at([F(1)], 50), top.at([1 + exactly], 50)) < mpf(10) ** -48
        # ... and no part of it: the state differs at halves and thirds.
        for part in (2, 3, 5):
            assert relative(top.at([F(1)], 50), top.at([1 + exactly / part], 50)) > 1e-6


def _parts(x):
    sign, mantissa, exponent, _ = x._mpf_
    return (-int(mantissa) if sign else int(mantissa)), exponent


class Corrupted:
    """An orbit whose time runs faster by 1e-30: right at t = 0, wrong everywhere else."""

    def __init__(self, orbit):
        self.orbit, self.period, self.fastest = orbit, orbit.period, orbit.fastest

    def at(self, t):
        return self.orbit.at(t * (1 + mpf(10) ** -30))


def check_corrupted(family, start, monkeypatch):
    """A formula wrong by 1e-30 in its rate, or by a sign, does not pass."""
    made = family._orbit
    with monkeypatch.context() as patch:
        patch.setattr(family, "_orbit", lambda self, bits: Corrupted(made(self, bits)))
        with pytest.raises(AssertionError):
            check_equations(family, start)
        with pytest.raises(AssertionError):
            check_taylor(family, start, times=(7.3,))
    for which in (0, 2, 4):

        class Flipped(Corrupted):
            def at(self, t, which=which):
                row = list(self.orbit.at(t))
                row[which] = -row[which]
                return row

        with monkeypatch.context() as patch:
            patch.setattr(family, "_orbit", lambda self, bits, f=Flipped: f(made(self, bits)))
            with pytest.raises(ArithmeticError, match="reproduce the start"):
                family(*start).at([F(1)], 20)
