"""Turns of the Kovalevskaya top's psi and phi at any time: beside counted ones and other runs."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.closed_forms.functions.rounding import number as rounded
from polhode.closed_forms.kovalevskaya import regimes
from polhode.closed_forms.kovalevskaya.attitude import axis_turns, theta_argument
from polhode.closed_forms.kovalevskaya.attitude.real_periods import real_periods
from polhode.closed_forms.kovalevskaya.attitude.theta_argument import ThetaSum
from polhode.closed_forms.kovalevskaya.attitude.theta_turns import TorusTurns
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import solved
from polhode.closed_forms.kovalevskaya.top import KovalevskayaTop
from polhode.numbers.conversion import exactly
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from shared.closed_form_checks import fractions, rational_axes
from shared.kovalevskaya_motions import GENERIC

F = Fraction
BODY, TORQUE = (F(2), F(2), F(1)), (F(1), F(0), F(0))
#: Motions whose third axis is vertical again and again, the last two from there.
THROUGH_POLES = {
    "isolated node": (("1/2", 1, "3/2"), ("-12/25", "16/25", "3/5")),
    "node reached": (("2/5", "1/5", "-8/5"), ("-9/25", "-12/25", "-4/5")),
    "from a pole, asymptotic": (("8/5", 0, "1/2"), (0, 0, 1)),
    "from a pole, multiply degenerate": (("4/5", "3/5", 1), (0, 0, 1)),
}
SKEW = rational_axes((3, -1, 2, 4))
CYCLIC = (F(0), F(1), F(0)), (F(0), F(0), F(1)), (F(1), F(0), F(0))
TAU = mpc("0.2", "0.9"), mpc("-0.3", "0.25"), mpc("-0.4", "1.7")
COEFFICIENTS = mpc("0.3", "-1"), mpc("0.8", "0.1"), mpc("-0.2", "0.6"), mpc("1.1", "0.4")


def top_of(start):
    return KovalevskayaTop(BODY, TORQUE, *map(fractions, start))


def attitudes_of(top):
    return top._attitudes


def turned(start, axes):
    """A top in other axes of the scene."""
    rows = [
        tuple(sum((axes[i][j] * v[i] for i in range(3)), F(0)) for j in range(3))
        for v in map(fractions, start)
    ]
    return KovalevskayaTop(BODY, TORQUE, *rows, F(1, 3), axes)


def about_axis(attitude, t):
    """Growth about the scene's third axis, in closed form and counted."""
    return attitude.about_axis(mpmath.ldexp(t, attitude.exponent)), attitude.counted(t)


def value(z, coefficients):
    """The theta sum as its series says, for small z."""
    total = 0
    for n1 in range(-9, 10):
        for n2 in range(-9, 10):
            form = TAU[0] * n1 * n1 + 2 * TAU[1] * n1 * n2 + TAU[2] * n2 * n2
            power = mpmath.pi * 1j * (form / 2 + n1 * z[0] + n2 * z[1])
            total += coefficients[2 * (n1 % 2) + n2 % 2] * mpmath.exp(power)
    return total


def test_growth_of_a_theta_sum_is_that_of_small_steps():
    z, way = (mpc("0.1", "-0.4"), mpc("0.7", "1.3")), (mpc("2.5", "2.2"), mpc("2", "1.7"))
    found = ThetaSum(TAU, COEFFICIENTS).growth(z, way)
    t11, t12, t22 = map(complex, TAU)
    n1, n2 = (n.ravel()[:, None] for n in np.mgrid[-12:13, -12:13])
    s = np.arange(2001) / 2000
    z1, z2 = (complex(a) + complex(b) * s for a, b in zip(z, way, strict=True))
    power = (t11 * n1 * n1 + 2 * t12 * n1 * n2 + t22 * n2 * n2) / 2 + n1 * z1 + n2 * z2
    A = np.array([complex(x) for x in COEFFICIENTS])[2 * (n1 % 2) + n2 % 2]
    steps = (A * np.exp(1j * np.pi * power)).sum(axis=0)
    differences = np.angle(steps[1:] / steps[:-1])
    assert abs(differences).max() < 1  # no turn is missed
    assert abs(found - differences.sum()) < 1e-9
    assert abs(found) > 2 * np.pi


@pytest.mark.sample(1)
@pytest.mark.parametrize("gap", ["1e-6", "1e-13", "1e-25"])
def test_either_side_of_a_zero_is_told(gap):
    """The sides are a turn apart; doubles cannot tell them."""
    z, way = (mpc("0.1", "-0.2"), mpc("0.7", "0.1")), (mpc("0.5", "0.1"), mpc("-0.4", "0.2"))
    with mpmath.workprec(200):
        middle = [a + b * 3 / mpf(7) for a, b in zip(z, way, strict=True)]
        rest, first = value(middle, (0, *COEFFICIENTS[1:])), value(middle, (1, 0, 0, 0))
        # along the way f moves as its slope says: beside the zero it passes at right angles
        ahead = [a + b * mpf("1e-30") for a, b in zip(middle, way, strict=True)]
        exact_zero = (-rest / first, *COEFFICIENTS[1:])
        slope = value(ahead, exact_zero)
        aside = 1j * slope / abs(slope) * mpf(gap) / first
        grown = [
            ThetaSum(TAU, (exact_zero[0] + side * aside, *COEFFICIENTS[1:])).growth(z, way)
            for side in (1, -1)
        ]
    assert abs(abs(grown[0] - grown[1]) - 2 * np.pi) < 1e-4


@pytest.mark.slow
def test_a_way_through_a_zero_is_refused():
    z, way = (mpc("0.1", "0.2"), mpc("-0.3", "0.1")), (mpc("0.4"), mpc("0.3", "0.1"))
    with mpmath.workprec(100):
        row = list(COEFFICIENTS)
        row[0] = -value(z, (0, *COEFFICIENTS[1:])) / value(z, (1, 0, 0, 0))
        begin = [a - b / 3 for a, b in zip(z, way, strict=True)]
        with pytest.raises(ArithmeticError, match="too near 0"):
            ThetaSum(TAU, row).growth(begin, way)


@pytest.mark.parametrize("name", GENERIC)
def test_real_periods_are_those_of_the_cycles(name):
    top = top_of(GENERIC[name])
    curve = top._curve(20)
    with mpmath.workprec(120):
        one, other = real_periods(curve)
        rows = [solved((one.u, other.u), cycle) for cycle in curve.cycles]
        whole = [[int(mpmath.nint(x)) for x in row] for row in rows]
        assert max(
            abs(x - n) for r, s in zip(rows, whole, strict=True) for x, n in zip(r, s, strict=True)
        ) < mpf("1e-20")
        (a, b), (c, d) = whole
        assert abs(a * d - b * c) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "hard/near-bobylev-steklov",
        "hard/near-axial-pendulum",
        "hard/near-quasi-periodic",
        "hard/near-appelrot",
    ],
)
def test_next_to_a_degenerate_motion_turns_are_those_of_a_run(name):
    scene = replace(polhode.load(name), outputs=("angles",)).at((20, 100))
    run = polhode.integrate(scene, "quad")
    for row, other in zip(polhode.reference(scene).angles([20, 100], 20), run.angles, strict=True):
        assert max(abs(x - exactly(y)) for x, y in zip(row, other, strict=True)) < 1e-18


@pytest.mark.parametrize(
    ("name", "time"),
    [
        pytest.param(
            name, time, marks=pytest.mark.campaign if k % 2 == (time > 0) else pytest.mark.slow
        )
        for k, name in enumerate(THROUGH_POLES)
        for time in (5.5, -6.5)
    ],
)
def test_turns_through_poles_are_the_counted_ones(name, time):
    top = top_of(THROUGH_POLES[name])
    assert regimes.passes_poles(top._start)
    attitudes = attitudes_of(top)
    with mpmath.workprec(128):
        found, counted = attitudes._turns(128, mpf(time)), attitudes.tallied(mpf(time))
        assert max(abs(a - b) for a, b in zip(found, counted, strict=True)) < 1e-6


def test_the_axis_passes_poles_on_one_side():
    """Y of :func:`regimes.side` keeps its sign, and the neighbours' sides are the exact ones."""
    top = top_of(THROUGH_POLES["isolated node"])
    start = top._start
    assert regimes.side(start) == 0
    assert {regimes.side(start.moved(F(n, 2**60), 200)) for n in (1, -1)} == {1, -1}
    times = [F(n, 4) for n in range(40)]
    with mpmath.workprec(100):
        m, a, k = rounded(start.m, 100), 1, mpmath.sqrt(rounded(start.k2, 100))
        signs = set()
        for p, q, *_ in top.at(times, 20):
            Y = 2 * a * p - 2 * m / a * (p * p + q * q + k)
            signs.add(mpmath.sign(Y))
            assert abs(Y) > 1e-3
    assert len(signs) == 1


@pytest.mark.parametrize(
    "name", ["e-ee+", pytest.param("-e+ (complex pair)", marks=pytest.mark.slow)]
)
def test_turns_at_enormous_times_keep_their_phase(name):
    """Whole turns of many periods are not to be lost in doubles."""
    top, far = top_of(GENERIC[name]), F(10) ** 19
    times = [far + F(i, 32) for i in range(9)]
    rows, angles = top.at(times, 20), top.angles([times[0], times[-1]], 12)
    with mpmath.workprec(160):
        rates = [(r[0] * r[3] + r[1] * r[4]) / (r[3] ** 2 + r[4] ** 2) for r in rows]
        weights = [1, 4, 2, 4, 2, 4, 2, 4, 1]
        grown = mpmath.fdot(weights, rates) / 96
        assert abs(angles[1][0] - angles[0][0] - grown) < 1e-2
        first = top.angles([times[0]], 25)[0][0]
        assert abs(first - angles[0][0]) < 1e-6
        # the mean rate is that of a motion a million times shorter
        short = top.angles([F(10) ** 13], 12)[0][0]
        assert abs(first / mpf(10) ** 19 - short / mpf(10) ** 13) < mpf("1e-11")


@pytest.mark.parametrize("name", ["_loop", "along"])
def test_a_corrupted_way_is_noticed(name, monkeypatch):
    """Beside the attitude itself; and the growth over a period beside what the formula says."""
    top = top_of(GENERIC["e-ee+"])
    old = getattr(TorusTurns, name)
    monkeypatch.setattr(TorusTurns, name, lambda *a: [x + mpf("1e-4") for x in old(*a)])
    with pytest.raises(ArithmeticError, match="turns"):
        TorusTurns(attitudes_of(top).at(128).formula(0), 128).growth(mpf(1000))


def test_doubles_leave_no_piece_unsettled(monkeypatch):
    """What doubles settle, the precision in force settles the same."""
    z, way = (mpc("0.1", "-0.4"), mpc("0.7", "1.3")), (mpc("0.6", "0.4"), mpc("-0.5", "0.3"))
    plain = ThetaSum(TAU, COEFFICIENTS).growth(z, way)
    monkeypatch.setattr(theta_argument, "_LOST", 10.0)
    with mpmath.workprec(80):
        assert abs(ThetaSum(TAU, COEFFICIENTS).growth(z, way) - plain) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("axes", [SKEW, CYCLIC])
@pytest.mark.parametrize("name", GENERIC)
def test_turns_about_another_axis_are_the_counted_ones(name, axes):
    attitude = attitudes_of(turned(GENERIC[name], axes)).at(128)
    with mpmath.workprec(128):
        for t in (mpf(9), mpf(-14)):
            found, counted = about_axis(attitude, t)
            assert max(abs(a - b) for a, b in zip(found, counted, strict=True)) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["isolated node", "from a pole"])
def test_turns_about_another_axis_next_to_poles(name):
    """A motion on a degenerate curve, by two neighbours; a start with the scene's axis vertical."""
    with mpmath.workprec(128):
        if name == "from a pole":
            rows = [[str(x) for x in row] for row in SKEW]
            start = ("1/2", "1/3", 2), [rows[i][2] for i in range(3)]
            attitude = attitudes_of(turned(start, SKEW)).at(128)
            found, counted = about_axis(attitude, mpf(-7))
        else:
            attitudes = attitudes_of(turned(THROUGH_POLES[name], SKEW))
            found = attitudes.about_axis(attitudes.neighbours(mpf(9), 128), mpf(9))
            counted = attitudes.tallied(mpf(9))
        assert max(abs(a - b) for a, b in zip(found, counted, strict=True)) < 1e-9


def test_turns_about_another_axis_at_any_time():
    """psi far away grows as its rate says, and at the mean rate of a shorter motion."""
    top = turned(GENERIC["e-ee+"], SKEW)
    far = [F(10) ** 9 + F(i, 64) for i in range(9)]
    (first, *_, last), rows = top.angles([far[0], far[-1]], 12), top.at(far, 20)
    rates = [(r[0] * r[3] + r[1] * r[4]) / (r[3] ** 2 + r[4] ** 2) for r in rows]
    grown = mpmath.fdot([1, 4, 2, 4, 2, 4, 2, 4, 1], rates) / 192
    assert abs(last[0] - first[0] - grown) < 1e-2
    short = top.angles([F(10) ** 7], 12)[0]
    for i in (0, 2):
        assert abs(first[i] / far[0].numerator * far[0].denominator - short[i] / 10**7) < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["missed", "sign", "turned round"])
def test_a_zero_missed_or_of_the_wrong_sign_is_noticed(fault, monkeypatch):
    attitude = attitudes_of(turned(GENERIC["e-ee+"], CYCLIC)).at(128)
    with mpmath.workprec(128):
        _, counted = about_axis(attitude, mpf(23))
        (torus,) = attitude.axis_tori.values()
        known = torus.zeros
        if fault == "turned round":
            around = axis_turns.copies_enclosed
            monkeypatch.setattr(axis_turns, "copies_enclosed", lambda *a: -around(*a))
        elif fault == "sign":
            torus.zeros = [[z._replace(sign=-z.sign) for z in row] for row in known]
        else:
            torus.zeros = [row[1:] for row in known]
        other, _ = about_axis(attitude, mpf(23))
        assert max(abs(a - b) for a, b in zip(counted, other, strict=True)) > 6
