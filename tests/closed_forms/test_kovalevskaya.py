"""The Kovalevskaya top against its equations, an independent integration, and 50-digit data.

Errors are asked to lie in a band: asked for 45 digits, less than 1e-45 and more than 1e-65 (a check
that compares a thing with itself is none).
"""

import functools
import json
import random
from fractions import Fraction
from pathlib import Path

import pytest
from mpmath import libmp

from polhode.closed_forms.kovalevskaya import axes as top_axes
from polhode.closed_forms.kovalevskaya.top import KovalevskayaTop
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.scenes.body import OWN_AXES, PrincipalAxes, cross, dot
from shared import orbit_checks, series
from shared.closed_form_checks import (
    belongs,
    fractions,
    in_band,
    in_scene,
    number,
    unwound,
)
from shared.kovalevskaya_motions import GENERIC

F = Fraction
fits = belongs(top_axes.fits)
BODY = (F(2), F(2), F(1))
TORQUE = (F(1), F(0), F(0))
DATA = Path(__file__).parents[1] / "data" / "closed-form-50-digits.json"
CASES = [c for c in json.loads(DATA.read_text())["cases"] if c["group"] == "kovalevskaya"]


#: Starts with q = 0, at rest, or with separation variables on branch points, by type.
BRANCH_POINTS = {
    "q = 0, -eee+": (("-5/2", 0, 0), (0, "3/5", "4/5"), "-eee+"),
    "q = 0, e-ee+": (("-19/10", 0, "7/5"), ("12/25", "16/25", "3/5"), "e-ee+"),
    "q = 0, ee-e+": (("-19/10", 0, 0), ("3/7", "-6/7", "2/7"), "ee-e+"),
    "q = 0, e-+": (("-3/5", 0, "-12/5"), ("1/3", "2/3", "-2/3"), "e-+ (complex pair)"),
    "at rest": ((0, 0, 0), ("3/5", "12/25", "16/25"), "-e+ (complex pair)"),
    "at rest, level": ((0, 0, 0), (0, "3/5", "4/5"), "-e+ (complex pair)"),
    "q = 1e-9": (("-3/5", "1e-9", "-12/5"), ("1/3", "2/3", "-2/3"), "e-+ (complex pair)"),
    "q = 1e-30": (("-3/5", "1e-30", "-12/5"), ("1/3", "2/3", "-2/3"), "e-+ (complex pair)"),
    "gamma along x": ((0, "1/2", "3/2"), (1, 0, 0), None),
    "gamma along y": (("1/2", "1/2", "3/2"), (0, 1, 0), None),
    "gamma along z": (("1/2", 0, "3/2"), (0, 0, -1), None),
}
#: Appelrot's special motion: xh = 1/2, ro + xh cos ps = 3/5, cos ps = 3/5, r = 8/5.
SPECIAL = {
    "hanging": ((0, 0, 0), (-1, 0, 0), "rest, hanging"),
    "upright": ((0, 0, 0), (1, 0, 0), "rest, upright"),
    "rotation": ((1, 0, 0), (1, 0, 0), "permanent rotation"),
    "pendulum z": ((0, 0, 1), ("3/5", "4/5", 0), "pendulum about the axis of symmetry"),
    "separatrix z": ((0, 0, 2), (-1, 0, 0), "pendulum about the axis of symmetry"),
    "pendulum y": ((0, 1, 0), ("3/5", 0, "4/5"), "pendulum about an equatorial axis"),
    "separatrix y": ((0, 1, 0), (0, 0, 1), "pendulum about an equatorial axis"),
    "at rest": ((0, 0, 0), (0, 0, 1), "pendulum about an equatorial axis"),
    "Bobylev-Steklov": (("4/5", 0, "4/5"), ("-12/25", "3/5", "16/25"), "Bobylev-Steklov"),
    "Delaunay": (("4/5", "2/5", "7/10"), ("12/25", "16/25", "3/5"), "Delaunay"),
    "Appelrot": (
        ("17/25", "6/25", "8/5"),
        ("9/25", "12/25", "4/5"),
        "Appelrot, special motion",
    ),
    "Appelrot, r = 0": (
        ("-7/25", "26/25", 0),
        ("-3/5", "4/5", 0),
        "Appelrot, special motion",
    ),
}
DEGENERATE = {
    "isolated node": (
        ("1/2", 1, "3/2"),
        ("-12/25", "16/25", "3/5"),
        "degenerate curve, quasi-periodic",
    ),
    "node reached": (
        ("2/5", "1/5", "-8/5"),
        ("-9/25", "-12/25", "-4/5"),
        "degenerate curve, asymptotic",
    ),
    "double root of S": (
        ("8/5", 0, "-1/2"),
        (0, "3/5", "4/5"),
        "degenerate curve, quasi-periodic",
    ),
    "two double points": (("4/5", "3/5", 1), (0, 0, 1), "multiply degenerate curve"),
    "gamma along z, q = 0": (("8/5", 0, "1/2"), (0, 0, 1), "degenerate curve, asymptotic"),
}


PSI = F(7, 10)


@functools.cache
def top_of(omega, gamma):
    """One motion for all tests that ask for it: its constants are made once."""
    return KovalevskayaTop(BODY, TORQUE, fractions(omega), fractions(gamma), PSI)


def distance(one, other):
    """Largest difference of two tables, w over its largest modulus."""
    with mpmath.workdps(150):
        scale = max(abs(x) for row in other for x in row[:3]) or mpf(1)
        return max(
            abs(x - y) / (scale if i < 3 else 1)
            for a, b in zip(one, other, strict=True)
            for i, (x, y) in enumerate(zip(a, b, strict=True))
        )


def true_rows(omega, gamma, times, digits, body=BODY, torque=TORQUE, **more):
    return series.integrate(
        body, fractions(omega), fractions(gamma), times, digits, torque=torque, **more
    )


@pytest.mark.sample(3)
@pytest.mark.parametrize("case", CASES, ids=lambda c: c["name"])
def test_fifty_digit_data(case):
    """Data of two independent programs (Taylor runs at high precision), t up to 1e4."""
    torque = tuple(F(case["weight"]) * F(x) for x in case["centre"])
    top = KovalevskayaTop(
        fractions(case["moments"]), torque, fractions(case["omega"]), fractions(case["gamma"])
    )
    rows = top.at([F(t) for t in case["times"]], 50)
    with mpmath.workdps(70):
        right = [[mpf(x) for x in row] for row in case["states"]]
        assert mpf(10) ** -60 < distance(rows, right) < mpf(10) ** -49


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", GENERIC)
def test_each_type_against_an_independent_integration(name):
    top = top_of(*GENERIC[name])
    assert top.regime == name
    times = [F(1), F(12)]
    assert in_band(distance(top.at(times, 45), true_rows(*GENERIC[name], times, 47)), 45)
    back = [F(-3)]
    assert in_band(distance(top.at(back, 45), true_rows(*GENERIC[name], back, 47)), 45)


@pytest.mark.sample(1, slow=3)
@pytest.mark.parametrize("name", BRANCH_POINTS)
def test_starts_on_and_near_branch_points(name):
    omega, gamma, regime = BRANCH_POINTS[name]
    top = top_of(omega, gamma)
    assert regime in (None, top.regime)
    times = [F(0), F(1), F(5)]
    assert in_band(distance(top.at(times, 45), true_rows(omega, gamma, times, 47)), 45)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", SPECIAL)
def test_one_frequency_motions(name):
    omega, gamma, regime = SPECIAL[name]
    top = top_of(omega, gamma)
    assert top.regime == regime
    times = [F(1), F(8)]
    error = distance(top.at(times, 45), true_rows(omega, gamma, times, 47))
    steady = regime.startswith(("rest", "permanent"))
    assert error == 0 if steady else in_band(error, 45)
    period = top.period(50)
    assert (period is None) == (steady or name.startswith("separatrix"))
    if period is None:
        assert top.frequencies(40) == {}
    else:
        with mpmath.workdps(60):
            start = [[number(x) for x in (*fractions(omega), *fractions(gamma))]]
        turned = exact.exact(F(*map(int, libmp.to_rational(period._mpf_))))
        assert distance(top.at([turned], 45), start) < mpf(10) ** -44
        with mpmath.workdps(60):
            turn = top.frequencies(40)["body"] * period / (2 * mpmath.pi)
            assert in_band(abs(turn - 1), 40, 10)


def test_degenerate_curves_are_told_apart():
    """Isolated nodes from those that are reached, and both from what is neither."""
    for omega, gamma, regime in DEGENERATE.values():
        assert top_of(omega, gamma).regime == regime


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", DEGENERATE)
def test_motions_on_a_degenerate_curve(name):
    omega, gamma, regime = DEGENERATE[name]
    top = top_of(omega, gamma)
    assert top.regime == regime
    times = [F(1), F(10)]
    assert in_band(distance(top.at(times, 35), true_rows(omega, gamma, times, 40)), 35)


@pytest.mark.slow
def test_asymptotic_motion_says_how_far_it_goes():
    top = top_of(*DEGENERATE["node reached"][:2])
    with pytest.raises(ValueError, match=r"amplifies errors.* 0 are known.* \|t\| = \d+"):
        top.at([F(10**6)], 20)
    one, other = top.at([F(100)], 20), top.at([F(100)], 30)
    assert in_band(distance(one, other), 20)


@pytest.mark.sample(1, slow=3)
@pytest.mark.parametrize("gap", [3, 10, 20])
@pytest.mark.parametrize("name", ["isolated node", "node reached", "Delaunay", "hanging"])
def test_next_to_a_degenerate_motion(name, gap):
    (p, q, r), gamma = map(fractions, (DEGENERATE | SPECIAL)[name][:2])
    omega = p + F(2, 10**gap), q + F(1, 10**gap), r + F(1, 2 * 10**gap)
    top = top_of(omega, gamma)
    assert top.regime in GENERIC
    times = [F(1), F(6)]
    error = distance(top.at(times, 45), true_rows(omega, gamma, times, 47 + gap))
    assert in_band(error, 45, 20 + gap)


@pytest.mark.sample(2, slow=3)
@pytest.mark.parametrize("time", [10**4, 10**12])
@pytest.mark.parametrize("name", GENERIC)
def test_two_precisions_and_the_integrals_at_long_times(name, time):
    omega, gamma = map(fractions, GENERIC[name])
    top = top_of(omega, gamma)
    rows, more = top.at([F(time)], 45), top.at([F(time)], 60)
    assert in_band(distance(rows, more), 45)
    with mpmath.workdps(70):
        now, then = integrals(more[0]), integrals([number(x) for x in (*omega, *gamma)])
        for a, b in zip(now, then, strict=True):
            assert abs(a - b) < abs(b) * mpf(10) ** -58 + mpf(10) ** -58


def integrals(state):
    """h, f, |gamma|^2 and Kovalevskaya's K^2, of the body (2, 2, 1), r0 = (1, 0, 0), Mg = 1."""
    p, q, r, g1, g2, g3 = state
    return (
        p * p + q * q + r * r / 2 + g1,
        2 * p * g1 + 2 * q * g2 + r * g3,
        g1 * g1 + g2 * g2 + g3 * g3,
        (p * p - q * q - g1) ** 2 + (2 * p * q - g2) ** 2,
    )


@pytest.mark.sample(5)
@pytest.mark.parametrize("name", [*GENERIC, "Delaunay", "Appelrot", "Bobylev-Steklov"])
def test_residual_in_the_differential_equations(name):
    top = top_of(*(GENERIC | SPECIAL)[name][:2])
    step, t = F(1, 10**18), F(7, 3)
    rows = top.at([t - step, t, t + step], 70)
    with mpmath.workdps(75):
        p, q, r, g1, g2, g3 = rows[1]
        right = [
            q * r / 2,
            (g3 - p * r) / 2,
            -g2,
            g2 * r - g3 * q,
            g3 * p - g1 * r,
            g1 * q - g2 * p,
        ]
        misses = [
            abs((after - before) / (2 * number(step)) - slope)
            for before, after, slope in zip(rows[0], rows[2], right, strict=True)
        ]
        assert in_band(max(misses), 32, 10)  # step^2 times the third derivative


#: Directions of length 3, 3, 3 and of lengths sqrt 2, sqrt 2, 1: rational and irrational axes.
RATIONAL = ((F(1), F(2), F(2)), (F(2), F(-2), F(1)), (F(2), F(1), F(-2)))
IRRATIONAL = ((F(1), F(1), F(0)), (F(-1), F(1), F(0)), (F(0), F(0), F(1)))


@pytest.mark.sample(2, slow=4)
@pytest.mark.parametrize("third", range(3))
@pytest.mark.parametrize("torque", [("3/5", "4/5"), (1, 1), (0, "-3/2"), (-2, "1/3")])
def test_labellings_and_centres(third, torque):
    """The torque (1, 1) has the irrational length sqrt 2."""
    moments, weight = [F(2, 3)] * 3, list(fractions(torque))
    moments[third] = F(1, 3)
    weight.insert(third, F(0))
    omega, gamma = fractions(("1/2", "-7/10", "9/10")), fractions(("2/7", "3/7", "-6/7"))
    assert fits(tuple(moments), tuple(weight))
    top = KovalevskayaTop(tuple(moments), tuple(weight), omega, gamma)
    right = true_rows(omega, gamma, [F(3)], 42, moments, weight)
    assert in_band(distance(top.at([F(3)], 40), right), 40)


@pytest.mark.parametrize("rows", [RATIONAL, IRRATIONAL])
def test_turned_axes(rows):
    a, b, _ = rows
    axes = PrincipalAxes((a, b, cross(a, b)), (dot(a, a), dot(b, b), dot(cross(a, b), cross(a, b))))
    omega, gamma = map(fractions, GENERIC["e-ee+"])
    top = KovalevskayaTop(
        BODY, TORQUE, in_scene(omega, axes.rows), in_scene(gamma, axes.rows), F(0), axes.rows
    )
    assert top.regime == "e-ee+"
    straight = top_of(*GENERIC["e-ee+"]).at([F(3)], 55)
    with mpmath.workdps(70):
        matrix = [[number(x) for x in row] for row in axes.rows]
        right = [
            [
                sum(matrix[i][j] * row[k + i] for i in range(3))
                for row in straight
                for k in (0, 3)
                for j in range(3)
            ]
        ]
    assert in_band(distance(top.at([F(3)], 40), right), 40)


@pytest.mark.parametrize("unit", [F(1, 10**30), F(1, 3), F(10**30)])
def test_units_of_time(unit):
    """Time in other units: w and Mg scale, gamma does not."""
    omega, gamma = map(fractions, GENERIC["ee-e+"])
    scaled = tuple(x * unit for x in omega)
    torque = tuple(x * unit * unit for x in TORQUE)
    rows = KovalevskayaTop(BODY, torque, scaled, gamma).at([F(4) / unit], 40)
    right = top_of(omega, gamma).at([F(4)], 55)
    with mpmath.workdps(70):
        right = [[*(x * number(unit) for x in right[0][:3]), *right[0][3:]]]
    assert in_band(distance(rows, right), 40)


def test_special_regimes_are_told_exactly_where_n_is_irrational():
    """Bobylev-Steklov in a body with Mg rho/C = sqrt 2: q = 0, G3 = p r, gamma of length 1."""
    root = exact.sqrt(F(2))
    torque = (F(1), F(1), F(0))
    omega = (F(1, 2), F(1, 2), F(1, 3))  # p = 1/sqrt 2 along the centre
    g3 = F(1, 6)  # sqrt 2 g3 = p r
    side = exact.sqrt(F(1) - g3 * g3)
    top = KovalevskayaTop(BODY, torque, omega, (side / root, -side / root, g3))
    assert top.regime == "Bobylev-Steklov"
    moved = KovalevskayaTop(
        BODY, torque, (omega[0], omega[1] + F(1, 10**60), omega[2]), (side, F(0), g3)
    )
    assert moved.regime in GENERIC


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", GENERIC)
def test_frequencies_are_those_of_the_periods_of_the_curve(name):
    """From real integrals between branch points; the variables come back together.

    ds1/w1 + ds2/w2 = 0 and s1 ds1/w1 + s2 ds2/w2 = dt: with P_i the integral of ds/w over the cycle
    of s_i and Q_i that of s ds/w, n1 P1 = n2 P2 and n1 Q1 - n2 Q2 = t after n1 and n2 cycles.
    """
    top = top_of(*GENERIC[name])
    found = top.frequencies(40)
    with mpmath.workdps(55):
        (P1, Q1), (P2, Q2) = (cycle_integrals(top.begin, s) for s in variables(top.begin))
        unit = 2 * mpmath.pi * mpmath.ldexp(1, top.begin.exponent) / abs(Q1 * P2 - Q2 * P1)
        for rate, right in ((found["s1"], P2 * unit), (found["s2"], P1 * unit)):
            assert in_band(abs(rate / right - 1), 40, 10)


def variables(start):
    """The separation variables s1, s2 of a start, roots of q^2 s^2 + R s/2 + R1/4."""
    p, q = (number(x) for x in start.omega[:2])
    H, m, b = (number(x) for x in (start.H, start.m, start.b))
    sg, pi = 2 * p, p * p + q * q
    R = -pi * pi + 2 * H * pi - 2 * m * sg + b
    R1 = -2 * H * pi * pi - b * sg * sg + 4 * m * pi * sg + 2 * H * b - 4 * m * m
    root = mpmath.sqrt(R * R / 4 - q * q * R1)
    return sorted((-R / 2 + side * root) / (2 * q * q) for side in (1, -1))


def cycle_integrals(start, s):
    """The integrals of ds/w and s ds/w over the cycle of s, w^2 = -2 (s^2 - k^2) S(s).

    Between two branch points s = centre + half sin x, below the least one s = a - tan^2 x.
    """
    H, m, b, k2 = (number(x) for x in (start.H, start.m, start.b, start.k2))
    cubic = mpmath.polyroots([H * b - 2 * m * m, b, H, 1], asc=True, maxsteps=500, extraprec=400)
    points = [*cubic, mpmath.sqrt(k2), -mpmath.sqrt(k2)]
    real = sorted(mpmath.re(a) for a in points if abs(mpmath.im(a)) < mpf(10) ** -30)
    above = next(a for a in real if a > s)
    below = max((a for a in real if a < s), default=None)
    rest = [a for a in points if a not in (above, below)]
    if below is None:
        ends = 0, mpmath.pi / 4, mpmath.pi / 2

        def place(x):
            return above - mpmath.tan(x) ** 2, 2 * mpmath.sec(x) ** 2
    else:
        ends = -mpmath.pi / 2, 0, mpmath.pi / 2

        def place(x):
            return (above + below) / 2 + (above - below) / 2 * mpmath.sin(x), mpf(1)

    def over_w(x):
        s, slope = place(x)
        return slope / mpmath.sqrt(2 * abs(mpmath.fprod(s - a for a in rest)))

    return (
        2 * mpmath.quad(over_w, ends),
        2 * mpmath.quad(lambda x: place(x)[0] * over_w(x), ends),
    )


@pytest.mark.slow
def test_frequencies_are_the_mean_rates_of_the_separation_variables():
    """s2 makes om2 t/pi passages between its ends in the time t: counted in the state itself."""
    top = top_of(*GENERIC["e-ee+"])
    found = top.frequencies(30)
    more = top.frequencies(50)
    assert all(in_band(abs(found[n] - more[n]), 29) for n in ("s1", "s2"))
    times = [F(k, 20) for k in range(2400)]
    signs = []
    H, m, b = (float(x) for x in (top.begin.H, top.begin.m, top.begin.b))
    for row in top.at(times, 16):
        p, q, *_ = map(float, row)
        sg, pi = 2 * p, p * p + q * q
        big = -pi * pi + 2 * H * pi - 2 * m * sg + b
        one = -2 * H * pi * pi - b * sg * sg + 4 * m * pi * sg + 2 * H * b - 4 * m * m
        root = max(0.0, big * big / 4 - q * q * one) ** 0.5
        s2 = one / (-2 * (big / 2 + (root if big > 0 else -root)))
        signs.append(s2)
    turns = sum((b - a) * (c - b) < 0 for a, b, c in zip(signs, signs[1:], signs[2:], strict=False))
    assert abs(turns / 120 - float(found["s2"]) / 3.14159265) < 2 / 120


def test_the_curve_is_shown():
    shown = top_of(*GENERIC["-eee+"]).curve(30)
    assert [isinstance(e, mpf) for e in shown["e"]] == [True] * 3
    assert all(t.imag > 0 for t in (shown["tau"][0], shown["tau"][2]))
    with mpmath.workdps(30):
        assert abs(sum(shown["e"]) + shown["H"]) < mpf(10) ** -28


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["e-+ (complex pair)", "isolated node", "Appelrot"])
def test_the_error_bounds_the_true_error(name):
    top = top_of(*(GENERIC | SPECIAL | DEGENERATE)[name][:2])
    times = [F(2), F(9)]
    rows, better = top.at(times, 30), top.at(times, 60)
    assert distance(rows, better) < top.error(30, times) < mpf(10) ** -30


def test_a_corrupted_start_is_outside_the_band():
    (p, q, r), gamma = map(fractions, GENERIC["e-ee+"])
    right = true_rows((p, q, r), gamma, [F(2)], 47)
    wrong = top_of((p, q + F(1, 10**40), r), gamma).at([F(2)], 45)
    assert not in_band(distance(wrong, right), 45)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["-e+ (complex pair)", "Delaunay"])
def test_attitude_and_angles(name):
    omega, gamma = (GENERIC | SPECIAL)[name][:2]
    top = top_of(omega, gamma)
    times = [F(1), F(4)]
    rows, angles = top.attitude(times, 25), top.angles(times, 25)
    start = top.attitude([F(0)], 50)[0]
    assert start[0] > 0
    right = true_rows(omega, gamma, times, 30, quaternion=start, psi=PSI)
    with mpmath.workdps(40):
        for q, (psi, theta, phi), row in zip(rows, angles, right, strict=True):
            assert max(abs(a - b) for a, b in zip(q, row[6:10], strict=True)) < mpf(10) ** -25
            assert abs(psi - row[10]) < mpf(10) ** -25
            assert abs(mpmath.cos(theta) - row[5]) < mpf(10) ** -25
            assert abs(mpmath.sin(theta) * mpmath.sin(phi) - row[3]) < mpf(10) ** -25


@pytest.mark.slow
def test_attitude_from_a_pole():
    """gamma along axis 3 at t = 0, where psi + phi = 7/10 is all that is known."""
    omega, gamma = (1, "-1/2", "4/5"), (0, 0, 1)
    top = top_of(omega, gamma)
    assert top.regime == "Appelrot, special motion"
    times = [F(-2), F(3)]
    (first, *rows), angles = top.attitude([F(0), *times], 25), top.angles([F(0), *times], 25)
    assert angles[0] == [None, 0, None]
    for t, q, (psi, theta, phi) in zip(times, rows, angles[1:], strict=True):
        right = true_rows(omega, gamma, [t], 30, quaternion=first)[0][6:10]
        with mpmath.workdps(40):
            al, bt = mpc(q[0], q[3]), mpc(q[1], q[2])
            assert max(abs(a - b) for a, b in zip(q, right, strict=True)) < mpf(10) ** -24
            turn = mpmath.expj((psi + phi) / 2) * mpmath.cos(theta / 2)
            assert min(abs(turn - al), abs(turn + al)) < mpf(10) ** -24
            turn = mpmath.expj((psi - phi) / 2) * mpmath.sin(theta / 2)
            assert min(abs(turn - bt), abs(turn + bt)) < mpf(10) ** -24


def attitude_off(name, time, digits):
    """Of the quaternion, from a Taylor run."""
    omega, gamma = (DEGENERATE | SPECIAL)[name][:2]
    top = top_of(omega, gamma)
    first, found = top.attitude([F(0), time], digits)
    (row,) = true_rows(omega, gamma, [time], digits + 4, quaternion=first)
    with mpmath.workdps(digits + 20):
        return max(abs(x - y) for x, y in zip(found, row[6:10], strict=True))


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["rotation", "separatrix z", "separatrix y", "upright"])
def test_attitude_of_what_is_or_becomes_a_permanent_rotation(name):
    for time in (F(6), F(-5)):
        error = attitude_off(name, time, 25)
        assert error < mpf("1e-25")
        assert error > mpf("1e-50") or name == "upright"
    top = top_of(*SPECIAL[name][:2])
    far = [F(45), F(-45)]
    one, other = top.attitude(far, 20), top.attitude(far, 35)
    assert distance(one, other) < mpf("1e-20")
    ends = [F(10**9), F(-(10**9))]
    if name.startswith("separatrix"):  # by neighbours, which it leaves behind
        with pytest.raises(ValueError, match="amplifies errors"):
            top.attitude(ends, 20)
        return
    after, before = (row[0] for row in top.angles(ends, 20))
    with mpmath.workdps(40):  # of the rotation w.gamma t
        grown = 2 * 10**9 if name == "rotation" else 0
        assert abs(after - before - grown) < mpf("1e-20")


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", DEGENERATE)
def test_attitude_on_a_degenerate_curve(name):
    for time in (F(4), F(-3)):
        error = attitude_off(name, time, 30)
        assert mpf("1e-60") < error < mpf("1e-30")


@pytest.mark.slow
def test_far_attitudes_on_a_degenerate_curve():
    """At t = 1e4: two precisions, whose neighbours are not the same."""
    top = top_of(*DEGENERATE["isolated node"][:2])
    far = [F(10**4), F(-(10**4))]
    one, other = top.attitude(far, 20), top.attitude(far, 35)
    assert mpf("1e-50") < distance(one, other) < mpf("1e-20")


@pytest.mark.slow
def test_turns_about_another_axis_than_the_tops_are_counted():
    omega, gamma = (fractions(row) for row in GENERIC["ee-e+"])
    moments, torque, omega, gamma = (
        (row[2], row[0], row[1]) for row in (BODY, TORQUE, omega, gamma)
    )
    top = KovalevskayaTop(moments, torque, omega, gamma, PSI)
    first = top.attitude([F(0)], 30)[0]
    for time in (F(5), F(-4)):
        (row,) = orbit_checks.taylor((moments, torque, omega, gamma), [time], 25, first)
        psi = top.angles([time], 20)[0][0]
        with mpmath.workdps(30):
            assert abs(psi - number(PSI) - row[10] - row[11]) < 1e-12


def test_what_is_no_kovalevskaya_top():
    assert fits(BODY, TORQUE)
    assert not fits(BODY, (F(0), F(0), F(0)))
    assert not fits(BODY, (F(1), F(0), F(1)))
    assert not fits((F(2), F(2), F(101, 100)), TORQUE)
    assert not fits((F(2), F(1), F(1)), TORQUE)
    with pytest.raises(ValueError, match="not a Kovalevskaya top"):
        KovalevskayaTop(BODY, (F(0), F(0), F(1)), TORQUE, TORQUE)
    assert OWN_AXES.trivial


@pytest.mark.slow
@pytest.mark.sample(1, rest="campaign")
@pytest.mark.parametrize("seed", range(4))
def test_sweep_of_starts_with_zeros_and_equal_values(seed):
    """75 starts a seed at 30 digits; the values repeat and vanish often."""
    draw = random.Random(seed)
    values = fractions(("0", "0", "1/2", "-1/2", "1", "-1", "3/10", "7/5", "-9/10", "2", "1/1000"))
    verticals = ((0, 0, 1), ("3/5", 0, "4/5"), ("12/25", "-3/5", "16/25"), ("2/7", "3/7", "-6/7"))
    regimes = set()
    for _ in range(75):
        third = draw.randrange(3)
        moments, torque = [F(2)] * 3, [F(draw.choice((1, -1, 2))), F(draw.choice((0, 0, 1, 3)))]
        moments[third] = F(1)
        draw.shuffle(torque)
        torque.insert(third, F(0))
        omega = tuple(draw.choice(values) for _ in range(3))
        gamma = list(fractions(draw.choice(verticals)))
        draw.shuffle(gamma)
        top = KovalevskayaTop(tuple(moments), tuple(torque), omega, tuple(gamma))
        regimes.add(top.regime)
        right = true_rows(omega, gamma, [F(4)], 33, moments, torque)
        assert distance(top.at([F(4)], 30), right) < mpf(10) ** -30, (torque, omega, gamma)
    assert len(regimes) > 5


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", GENERIC)
def test_attitude_of_every_type_as_theta_quotients(name):
    omega, gamma = map(fractions, GENERIC[name])
    top = top_of(omega, gamma)
    times = [F(-2), F(3)]
    (start, *rows), angles = top.attitude([F(0), *times], 30), top.angles(times, 30)
    for t, q, (psi, _, phi) in zip(times, rows, angles, strict=True):
        (right,) = orbit_checks.taylor((BODY, TORQUE, omega, gamma), [t], 32, start)
        with mpmath.workdps(45):
            assert mpf("1e-60") < max(abs(a - b) for a, b in zip(q, right[6:10], strict=True))
            assert max(abs(a - b) for a, b in zip(q, right[6:10], strict=True)) < mpf("1e-30")
            # psi is the sum of two arguments: its digits from them, its turns from their growth.
            w, x, y, z = right[6:10]
            turn = mpc(w, z) * mpc(x, y)
            assert abs(mpmath.expj(psi) - turn / abs(turn)) < mpf("1e-30")
            assert abs(psi - number(PSI) - right[10] - right[11]) < 1e-12
            assert abs(mpmath.tan(phi) * right[4] - right[3]) < mpf("1e-29")


#: Where the motion turns back at t = 0, the equations there do not tell the attitude's constants.
TURNING_BACK = {
    "at rest, level": ((0, 0, 0), (0, "3/5", "4/5")),
    "at rest": ((0, 0, 0), ("3/5", "12/25", "16/25")),
    "nearly at rest": (("1e-25", "-2e-25", "1e-25"), ("-3/5", "12/25", "-16/25")),
}


@pytest.mark.sample(1, first=1, slow=1)
@pytest.mark.parametrize("name", TURNING_BACK)
def test_attitude_and_angles_released_from_rest(name):
    omega, gamma = map(fractions, TURNING_BACK[name])
    top = top_of(omega, gamma)
    assert top.regime in GENERIC
    for t in (F(5), F(-2)):
        (start, q), (psi, _, phi) = top.attitude([F(0), t], 40), top.angles([t], 40)[0]
        (right,) = orbit_checks.taylor((BODY, TORQUE, omega, gamma), [t], 42, start)
        with mpmath.workdps(55):
            error = max(abs(a - b) for a, b in zip(q, right[6:10], strict=True))
            assert in_band(error, 40, 30)
            grown = [mpf(x) for x in right[10:12]]
            assert abs(psi - number(PSI) - grown[0] - grown[1]) < mpf("1e-12")
            begin = mpmath.atan2(number(gamma[0]), number(gamma[1]))
            assert abs(phi - begin - grown[0] + grown[1]) < mpf("1e-12")


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", GENERIC)
def test_far_attitudes_agree_at_two_precisions_and_their_turns_with_counting(name):
    top = top_of(*GENERIC[name])
    far = [F(10**6)]
    with mpmath.workdps(60):
        one, other = top.attitude(far, 25)[0], top.attitude(far, 45)[0]
        assert (
            mpf("1e-60") < max(abs(a - b) for a, b in zip(one, other, strict=True)) < mpf("1e-25")
        )
    first, last = F(1, 10), F(60)
    (psi, _, phi), (psi_1, _, phi_1) = top.angles([first, last], 15)
    grown = unwound(top, first, last, 500)
    assert abs(psi_1 - psi - grown[0]) < mpf("1e-11")
    assert abs(phi_1 - phi - grown[1]) < mpf("1e-11")
