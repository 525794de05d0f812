"""The physical pendulum against its equations, an independent integration and elementary limits.

Errors are asked to lie in a band: asked for 50 digits, more than 1e-75 (a check that compares a
thing with itself is none) and less than 1e-50.
"""

import functools
import itertools
import json
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from polhode.closed_forms.pendulum import conditions
from polhode.closed_forms.pendulum.top import Pendulum
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.scenes.body import cross
from shared import series
from shared.closed_form_checks import (
    belongs,
    error_of_1000_digits,
    fractions,
    in_scene,
    number,
    rational_axes,
    residuals,
    rotation,
    unwound,
)
from shared.closed_form_checks import distance as gap
from shared.examples import examples

F = Fraction
fits = belongs(conditions.fits)
PSI = F(7, 10)
DATA = Path(__file__).parents[1] / "data" / "closed-form-50-digits.json"
TINY = F(1, 10**30)


#: name: moments, Mg r0, omega, gamma, regime.  Swings about axis 1 have P = |Mg r0| = 5 and
#: Mg r0.gamma = -7/5; the separatrix is 1/2 A p^2 = 5 + 7/5, so p = 2 for A = 16/5.
PLANE = (("3.2", "2.5", 2), (0, 3, 4))
START = (0, "0.6", "-0.8")
MOTIONS = {
    "libration": (*PLANE, ("0.5", 0, 0), START, "pendulum, librating"),
    "released": (*PLANE, (0, 0, 0), START, "pendulum, librating"),
    "released at a pole": (*PLANE, (0, 0, 0), (0, 0, 1), "pendulum, librating"),
    "from the lowest point": (*PLANE, ("-1.9", 0, 0), (0, "-0.6", "-0.8"), "pendulum, librating"),
    "rotation": (*PLANE, (3, 0, 0), START, "pendulum, rotating"),
    "rotation from the top": (*PLANE, ("-0.3", 0, 0), (0, "0.6", "0.8"), "pendulum, rotating"),
    "fast": (*PLANE, ("1e6", 0, 0), START, "pendulum, rotating"),
    "separatrix": (*PLANE, (2, 0, 0), START, "pendulum, separatrix"),
    "separatrix, backward": (*PLANE, (-2, 0, 0), START, "pendulum, separatrix"),
    "separatrix, irrational": (
        ("1.5", 1, 1),
        (0, 1, 1),
        (exact.sqrt(exact.sqrt(F(2)) * F(8, 3)), 0, 0),
        (0, -exact.sqrt(F(1, 2)), -exact.sqrt(F(1, 2))),
        "pendulum, separatrix",
    ),
    "below the separatrix by 1e-10": (
        *PLANE,
        (2 - F(1, 10**10), 0, 0),
        START,
        "pendulum, librating",
    ),
    "above the separatrix by 1e-60": (
        *PLANE,
        (-2 - F(1, 10**60), 0, 0),
        START,
        "pendulum, rotating",
    ),
    "below the separatrix by 1e-60": (
        *PLANE,
        (2 - F(1, 10**60), 0, 0),
        START,
        "pendulum, librating",
    ),
    "negative weight": (
        ("2", "3.5", "2.5"),
        (-1, 0, "-0.5"),
        (0, "-0.7", 0),
        ("-0.28", 0, "0.96"),
        "pendulum, librating",
    ),
    "about axis 3": (
        (1, "1.5", 2),
        ("0.3", "-1.2", 0),
        (0, 0, "1.1"),
        ("0.8", "0.6", 0),
        "pendulum, librating",
    ),
    "around axis 3": (
        (1, "1.5", 2),
        ("0.3", "-1.2", 0),
        (0, 0, "-2.5"),
        ("0.8", "0.6", 0),
        "pendulum, rotating",
    ),
    "sphere about a diagonal": (
        (2, 2, 2),
        (1, 2, 3),
        (1, 1, -1),
        (exact.sqrt(F(1, 2)), 0, exact.sqrt(F(1, 2))),
        "pendulum, rotating",
    ),
    "hanging": (*PLANE, (0, 0, 0), (0, "-0.6", "-0.8"), "rest, hanging"),
    "upright": (*PLANE, (0, 0, 0), (0, "0.6", "0.8"), "rest, upright"),
    "hanging askew": (
        (1, "1.5", 2),
        (-1, -2, -2),
        (0, 0, 0),
        ("1/3", "2/3", "2/3"),
        "rest, hanging",
    ),
}
MOVING = [name for name in MOTIONS if "rest" not in MOTIONS[name][4]]


def data(name):
    moments, torque, omega, gamma, _ = MOTIONS[name]
    return [
        tuple(x if isinstance(x, exact.Irrational) else F(x) for x in row)
        for row in (moments, torque, omega, gamma)
    ]


@functools.cache
def top_of(name, psi=PSI):
    """One motion for all tests that ask for it: its constants are made once."""
    return Pendulum(*data(name), psi)


def taylor(moments, torque, omega, gamma, times, digits, **more):
    with mpmath.workdps(digits + 30):
        omega, gamma = ([number(x) for x in row] for row in (omega, gamma))
    return series.integrate(moments, omega, gamma, times, digits, torque=torque, **more)


def distance(one, other):
    """Largest difference of two tables: w over its largest value in the tables, the rest as is."""
    with mpmath.workdps(150):
        scale = max([abs(x) for row in one for x in row[:3]]) or mpf(1)
        return gap(one, other, scale)


def by_angles(psi, theta, phi):
    def turn(axis, angle):
        half = [mpf(0)] * 4
        half[0], half[axis] = mpmath.cos(angle / 2), mpmath.sin(angle / 2)
        return rotation(half)

    return turn(3, psi) * turn(1, theta) * turn(3, phi)


@pytest.mark.parametrize("name", MOTIONS)
def test_regime_is_named(name):
    assert top_of(name).regime == MOTIONS[name][4]


@pytest.mark.sample(8)
@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree(name):
    top, times = top_of(name), [F(0), F(7, 3), F(-11), F(10**4), F(-(10**12))]
    for low, high in ((15, 33), (50, 90)):
        for answers in (top.at, top.attitude):
            error = distance(answers(times, low), answers(times, high))
            assert mpf(10) ** (-low - 20) < error < mpf(10) ** -low


@pytest.mark.sample(6)
@pytest.mark.parametrize("name", MOVING)
def test_two_precisions_of_the_angles_agree(name):
    top, times = top_of(name), [F(7, 3), F(-11), F(10**12)]
    error = gap(top.angles(times, 20), top.angles(times, 45))
    assert mpf(10) ** -40 < error < mpf(10) ** -20


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["libration", "rotation", "separatrix"])
def test_1000_digits(name):
    error = error_of_1000_digits(top_of(name), [F(10**12) if name != "separatrix" else F(3)])
    assert mpf(10) ** -1010 < error < mpf(10) ** -1000


@pytest.mark.sample(8, first=1)
@pytest.mark.parametrize("name", MOTIONS)
def test_equations_are_satisfied(name):
    error = max(residuals(top_of(name), *data(name)[:2])[0])
    assert error < mpf(10) ** (-150 if name != "fast" else -120)
    assert error > mpf(10) ** -185 if name in MOVING else error < mpf(10) ** -195


@pytest.mark.sample(5, slow=4)
@pytest.mark.parametrize("name", MOTIONS)
def test_independent_integration_agrees(name):
    moments, torque, omega, gamma = data(name)
    top = top_of(name)
    end = F(1, 10**6) if name == "fast" else F(3)
    times = [end / 4, end]
    start = top.attitude([F(0)], 75)[0]
    done = taylor(moments, torque, omega, gamma, times, 55, quaternion=start)
    closed = [a + b for a, b in zip(top.at(times, 50), top.attitude(times, 50), strict=True)]
    error = distance(done, closed)
    assert error < mpf(10) ** -50
    assert error > mpf(10) ** -62


def test_stored_values():
    """States made by another program at 55 digits."""
    (case,) = (
        c for c in json.loads(DATA.read_text())["cases"] if c["name"] == "planar pendulum, rotating"
    )
    weight = F(case["weight"])
    torque = tuple(weight * F(x) for x in case["centre"])
    moments, omega, gamma = (fractions(case[key]) for key in ("moments", "omega", "gamma"))
    top = Pendulum(moments, torque, omega, gamma)
    assert top.regime == "pendulum, rotating"
    with mpmath.workdps(70):
        stored = [list(map(mpf, row)) for row in case["states"]]
    assert mpf(10) ** -58 < distance(stored, top.at(fractions(case["times"]), 50)) < mpf(10) ** -49


@pytest.mark.sample(1)
@pytest.mark.parametrize("axis", range(3))
def test_every_axis_and_every_sign(axis):
    """One body turned so that it swings about each axis, in all quadrants and both senses."""

    def placed(row):
        return tuple(row[(i - axis) % 3] for i in range(3))

    moments = placed(fractions((2, 3, "2.5")))
    for signs in itertools.product((1, -1), repeat=2):
        torque = placed((F(0), F(3, 2), F((2, -2)[axis % 2])))
        gamma = placed((F(0), signs[0] * F(3, 5), signs[1] * F(4, 5)))
        for rate in (F(0), F(1, 2), F(-1, 2), F(3), F(-3)):
            omega = placed((rate, F(0), F(0)))
            top = Pendulum(moments, torque, omega, gamma)
            start = top.attitude([F(0)], 40)[0]
            done = taylor(moments, torque, omega, gamma, [F(1)], 15, quaternion=start)
            closed = [top.at([F(1)], 15)[0] + top.attitude([F(1)], 15)[0]]
            assert distance(done, closed) < mpf(10) ** -15


def test_what_fits():
    body = fractions((1, "1.5", 2))
    zero, g = fractions((0, 0, 0)), fractions((0, "0.6", "0.8"))
    assert fits(body, fractions((0, 1, 2)), fractions((1, 0, 0)), g)
    assert fits(body, fractions((0, 1, 2)), zero, g)
    assert fits(body, fractions((0, -3, -4)), zero, g)
    assert fits(body, fractions((1, 2, 2)), zero, fractions(("-1/3", "-2/3", "-2/3")))
    assert not fits(body, zero, fractions((1, 0, 0)), g)  # no weight: Euler's top
    assert not fits(body, fractions((1, 1, 2)), fractions((1, 0, 0)), g)  # centre off the plane
    assert not fits(body, fractions((0, 1, 2)), fractions((1, TINY, 0)), g)
    assert not fits(body, fractions((0, 1, 2)), fractions((1, 0, 0)), fractions(("0.6", 0, "0.8")))
    assert not fits(body, fractions((1, 2, 2)), zero, g)  # not about a principal axis
    assert not fits(
        body, fractions((1, 2, 2)), fractions((0, 0, 1)), fractions(("1/3", "2/3", "2/3"))
    )
    assert fits(fractions((1, 1, 1)), fractions((1, 2, 2)), zero, g)
    with pytest.raises(ValueError, match="does not swing about a horizontal principal axis"):
        Pendulum(body, fractions((1, 2, 2)), zero, g)


@pytest.mark.parametrize("sign", [1, -1])
def test_symmetric_body_swings_about_an_axis_that_is_no_axis_of_the_scene(sign):
    """A = B: the horizontal axis (4, -3, 0)/5 is principal."""
    moments, torque = fractions((2, 2, "1.3")), fractions((3, 4, 2))
    omega = tuple(sign * x for x in fractions(("0.8", "-0.6", 0)))
    gamma = fractions(("0.36", "0.48", "-0.8"))
    top = Pendulum(moments, torque, omega, gamma)
    assert top.regime == "pendulum, librating"
    start = top.attitude([F(0)], 60)[0]
    done = taylor(moments, torque, omega, gamma, [F(4)], 45, quaternion=start)
    closed = [top.at([F(4)], 40)[0] + top.attitude([F(4)], 40)[0]]
    assert mpf(10) ** -55 < distance(done, closed) < mpf(10) ** -40


@pytest.mark.parametrize("name", ["separatrix", "separatrix, backward"])
def test_separatrix_is_elementary(name):
    """tan((del + pi)/4) grows as exp(om t); in infinite time the body stands upright."""
    top, times = top_of(name), [F(0), F(-7), F(2), F(9), F(10**12), F(-(10**12))]
    s = 1 if name == "separatrix" else -1
    with mpmath.workdps(80):
        om = mpmath.sqrt(mpf(5) / mpf("3.2"))
        rows = top.at(times, 60)
        # cos del = 7/25, sin del = P-component of T x gamma = -24/25
        start = mpmath.atan2(-24 * s, 7)
        first = mpmath.tan((start + mpmath.pi) / 4)
        for t, row in zip(times, rows, strict=True):
            grown = mpmath.log(first) + om * number(t)
            assert abs(s * row[0] / (2 * om * mpmath.sech(grown)) - 1) < mpf(10) ** -59
            angle = s * (4 * mpmath.atan(mpmath.exp(grown)) - mpmath.pi)
            c, d = mpmath.cos(angle), mpmath.sin(angle)
            assert abs(row[4] - (-3 * c - 4 * d) / 5) < mpf(10) ** -59
            assert abs(row[5] - (3 * d - 4 * c) / 5) < mpf(10) ** -59
        for row in rows[-2:]:
            assert 0 < s * row[0] < mpf(10) ** -(10**11)
            assert gap([row[4:]], [[mpf("0.6"), mpf("0.8")]]) < mpf(10) ** -59


@pytest.mark.sample(4)
@pytest.mark.parametrize("exponent", [10, 20, 40, 60, 200, 1000])
@pytest.mark.parametrize("side", [1, -1])
def test_near_the_separatrix(exponent, side):
    """Period by mpmath's K at twice the exponent's digits; states by two precisions."""
    moments, torque = fractions(PLANE[0]), fractions(PLANE[1])
    omega, gamma = (2 + side * F(1, 10**exponent), F(0), F(0)), fractions(START)
    top = Pendulum(moments, torque, omega, gamma)
    assert top.regime == f"pendulum, {'rotating' if side > 0 else 'librating'}"
    with mpmath.workdps(2 * exponent + 60):
        om2, p = mpf(5) / mpf("3.2"), number(omega[0])
        k2 = mpf("0.36") + p * p / 4 / om2
        m = 1 / k2 if side > 0 else k2
        period = mpmath.ellipk(m) * (2 * mpmath.sqrt(m) if side > 0 else 4) / mpmath.sqrt(om2)
        found = top.period(60)
        assert abs(found / period - 1) < mpf(10) ** -60
        times = [F(5), F(40), F(10**5)]
        low, high = top.at(times, 50), top.at(times, 80)
    assert mpf(10) ** -75 < distance(high, low) < mpf(10) ** -50


@pytest.mark.parametrize("exponent", [10, 20])
def test_near_the_separatrix_by_integration(exponent):
    moments, torque = fractions(PLANE[0]), fractions(PLANE[1])
    for side in (1, -1):
        omega, gamma = (2 + side * F(1, 10**exponent), F(0), F(0)), fractions(START)
        top = Pendulum(moments, torque, omega, gamma)
        digits, end = 30 + 2 * exponent, F(2 * exponent)  # past the highest point, to the next fall
        done = taylor(moments, torque, omega, gamma, [end], digits)
        assert distance(done, top.at([end], 30)) < mpf(10) ** -30


def test_tiny_amplitude_is_the_linear_oscillator():
    """Amplitude 1e-30: the relative difference from p(0) cos(om t) is 1e-60."""
    moments, torque = fractions(PLANE[0]), fractions(PLANE[1])
    top = Pendulum(moments, torque, (TINY, F(0), F(0)), fractions((0, "-0.6", "-0.8")))
    assert top.regime == "pendulum, librating"
    times = [F(1), F(-17, 3), F(10**6)]
    with mpmath.workdps(80):
        om = mpmath.sqrt(mpf(5) / mpf("3.2"))
        for t, row in zip(times, top.at(times, 50), strict=True):
            angle = number(TINY) / om * mpmath.sin(om * number(t))
            assert abs(row[0] / (number(TINY) * mpmath.cos(om * number(t))) - 1) < mpf(10) ** -49
            assert abs(row[4] - (mpf(-3) - 4 * angle) / 5) < mpf(10) ** -50
            assert abs(row[5] - (mpf(-4) + 3 * angle) / 5) < mpf(10) ** -50
        assert abs(top.period(50) * om / 2 / mpmath.pi - 1) < mpf(10) ** -50


@pytest.mark.parametrize("exponent", [30, 100])
def test_w_keeps_its_digits_next_to_the_unstable_equilibrium(exponent):
    """From upright with p = 1e-30: p cosh(om t), far below the largest p of the motion."""
    moments, torque = fractions(PLANE[0]), fractions(PLANE[1])
    gamma = fractions((0, "0.6", "0.8"))
    small = F(1, 10**exponent)
    top = Pendulum(moments, torque, (small, F(0), F(0)), gamma)
    times = [F(1, 10), F(3)]
    with mpmath.workdps(80):
        om = mpmath.sqrt(mpf(5) / mpf("3.2"))
        for t, row in zip(times, top.at(times, 40), strict=True):
            assert abs(row[0] / (number(small) * mpmath.cosh(om * number(t))) - 1) < mpf(10) ** -40
    # Released 1e-exponent from upright: p grows from 0 as sinh.
    root = exact.sqrt(1 - small * small)
    gamma = (F(0), F(3, 5) * root - F(4, 5) * small, F(4, 5) * root + F(3, 5) * small)
    top = Pendulum(moments, torque, fractions((0, 0, 0)), gamma)
    assert top.regime == "pendulum, librating"
    low, high = top.at(times, 30), top.at(times, 60)
    assert distance(high, low) < mpf(10) ** -30
    with mpmath.workdps(80):
        for t, row in zip(times, high, strict=True):
            linear = -om * number(small) * mpmath.sinh(om * number(t))
            assert abs(abs(row[0] / linear) - 1) < mpf(10) ** -50


def test_equilibria_stay_exactly_at_rest():
    for name in ("hanging", "upright", "hanging askew"):
        top, (_, _, _, gamma) = top_of(name), data(name)
        rows = top.at([F(0), F(10**12), F(-3)], 50)
        assert rows[0] == rows[1] == rows[2]
        assert rows[0][:3] == [0, 0, 0]
        with mpmath.workdps(70):
            assert gap([rows[0][3:]], [[number(x) for x in gamma]]) < mpf(10) ** -50
        assert top.attitude([F(10**12)], 50) == top.attitude([F(0)], 50)
        assert top.angles([F(10**12)], 50) == top.angles([F(0)], 50)
        assert top.period(50) is None
        assert top.frequencies(50) == {}
    upright = Pendulum(*(fractions(x) for x in ((1, 1, 2), (0, 0, 1), (0, 0, 0), (0, 0, 1))))
    assert upright.angles([F(0), F(5)], 20) == [[None, 0, None], [None, 0, None]]


@pytest.mark.parametrize("name", ["libration", "rotation", "negative weight", "around axis 3"])
def test_the_period_is_that_of_the_integrated_motion(name):
    moments, torque, omega, gamma = data(name)
    top = top_of(name)
    period = top.period(60)
    (done,) = taylor(moments, torque, omega, gamma, [period], 45)
    with mpmath.workdps(60):
        first = [number(x) for x in (*omega, *gamma)]
        assert mpf(10) ** -56 < distance([first], [done]) < mpf(10) ** -40
        key = "rotation" if "rotating" in top.regime else "libration"
        assert list(top.frequencies(50)) == [key]
        assert abs(top.frequencies(50)[key] - 2 * mpmath.pi / period) < mpf(10) ** -49


def test_the_quarter_period_by_integration():
    """From the lowest point to rest."""
    name = "from the lowest point"
    with mpmath.workdps(60):
        quarter = top_of(name).period(60) / 4
    moments, torque, omega, gamma = data(name)
    (done,) = taylor(moments, torque, omega, gamma, [quarter], 45)
    assert mpf(10) ** -70 < abs(done[0]) < mpf(10) ** -44


sizes = st.sampled_from([F(0), F(1, 10**3), F(1, 10**12), F(1, 10**60)])
signed = st.tuples(st.sampled_from([-1, 1]), sizes).map(lambda pair: pair[0] * pair[1])
plain = st.integers(-30, 30).map(lambda n: F(n, 10))
#: Half-angle tangents give rational unit vectors, next to the axes too.
component = st.one_of(plain, plain, signed)


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None, derandomize=True)
@given(
    st.integers(0, 2),
    st.tuples(*[st.integers(10, 19).map(lambda n: F(n, 10))] * 3),
    st.tuples(component, component),
    component,
    component,
    component,
    st.integers(-20, 20).filter(bool).map(lambda n: F(n, 10)),
)
def test_random_swings(axis, moments, arm, tangent, nearness, rate, end):
    """Random bodies and starts, released next to upright and with rates next to the separatrix."""
    assume(any(arm))
    c, s = (1 - tangent**2) / (1 + tangent**2), 2 * tangent / (1 + tangent**2)

    def placed(row):
        return tuple(row[(i - axis) % 3] for i in range(3))

    length = exact.sqrt(arm[0] ** 2 + arm[1] ** 2)
    if isinstance(length, F):  # gamma at the angle of the half-angle tangent from upright
        up = (arm[0] / length, arm[1] / length)
        gamma = placed((F(0), up[0] * c - up[1] * s, up[0] * s + up[1] * c))
    else:
        gamma = placed((F(0), c, s))
    torque, omega = placed((F(0), *arm)), placed((rate + nearness, F(0), F(0)))
    top = Pendulum(moments, torque, omega, gamma, PSI)
    start = top.attitude([F(0)], 60)[0]
    done = taylor(moments, torque, omega, gamma, [end], 20, quaternion=start)
    closed = [top.at([end], 15)[0] + top.attitude([end], 15)[0]]
    error = distance(done, closed) if any(done[0][:3]) else gap(done, closed)
    assert error < mpf(10) ** -15


def irrational_axes():
    c, s, u, v = exact.cos(F(1, 3)), exact.sin(F(1, 3)), exact.cos(F(1)), exact.sin(F(1))
    return ((c, s * u, s * v), (-s, c * u, c * v), (F(0), -v, u))


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize(
    "name", ["libration", "rotation", "separatrix", "released", "around axis 3"]
)
@pytest.mark.parametrize(
    "axes", [rational_axes(), irrational_axes()], ids=["rational", "irrational"]
)
def test_turned_axes(name, axes):
    """A body given in axes that are not principal, against the integration of its full matrix."""
    moments, torque, omega, gamma = data(name)
    top = Pendulum(moments, torque, in_scene(omega, axes), in_scene(gamma, axes), PSI, axes)
    assert top.regime == MOTIONS[name][4]
    times = [F(1, 2), F(3, 2)]
    start = top.attitude([F(0)], 60)[0]
    with mpmath.workdps(60):
        rows = [[number(x) for x in row] for row in axes]
        inertia = [
            [sum(number(moments[k]) * rows[k][i] * rows[k][j] for k in range(3)) for j in range(3)]
            for i in range(3)
        ]
        arm = [number(x) for x in in_scene(torque, axes)]
    done = taylor(
        inertia,
        arm,
        in_scene(omega, axes),
        in_scene(gamma, axes),
        times,
        30,
        quaternion=start,
        psi=PSI,
    )
    closed = [
        a + b + c[:1]
        for a, b, c in zip(
            top.at(times, 25), top.attitude(times, 25), top.angles(times, 25), strict=True
        )
    ]
    assert mpf(10) ** -40 < distance(done, closed) < mpf(10) ** -25
    psi, _, phi = top.angles([F(5)], 15)[0]
    start = top.angles([F(0)], 15)[0]
    more_psi, more_phi = unwound(top, F(0), F(5), 400)
    assert abs(psi - start[0] - more_psi) < 1e-12
    assert abs(phi - start[2] - more_phi) < 1e-12


@pytest.mark.sample(8, first=2)
@pytest.mark.parametrize("name", MOTIONS)
def test_attitude_angles_and_states_agree(name):
    top = top_of(name)
    times = [F(0), F(5, 3), F(-9), F(40)]
    rows = zip(*(f(times, 50) for f in (top.at, top.attitude, top.angles)), strict=True)
    with mpmath.workdps(60):
        for state, attitude, (psi, theta, phi) in rows:
            turned = rotation(attitude)
            assert abs(mpmath.norm(mpmath.matrix(attitude)) - 1) < mpf(10) ** -50
            assert max(abs(turned[2, i] - state[3 + i]) for i in range(3)) < mpf(10) ** -50
            if psi is None:
                assert abs(state[3]) + abs(state[4]) == 0
            else:
                difference = turned - by_angles(psi, theta, phi)
                assert max(abs(x) for x in difference) < mpf(10) ** -49
        if name != "released at a pole":
            psi, _, phi = top.angles([F(0)], 50)[0]
            _, _, _, (g1, g2, _) = data(name)
            assert abs(psi - mpf(7) / 10) < mpf(10) ** -50
            assert abs(phi - mpmath.atan2(number(g1), number(g2))) < mpf(10) ** -50
        assert top.attitude([F(0)], 50)[0][0] >= 0


@pytest.mark.sample(6)
@pytest.mark.parametrize("name", [name for name in MOVING if name != "fast"])
def test_quaternion_never_changes_sign(name):
    top = top_of(name)
    rows = top.attitude([F(k - 200, 12) for k in range(400)], 15)
    assert max(gap([a], [b]) for a, b in itertools.pairwise(rows)) < 0.2


def test_about_axis_3_theta_stays_and_phi_swings():
    top = top_of("around axis 3")
    times = [F(k, 3) for k in range(-9, 10)]
    rows, states = top.angles(times, 30), top.at(times, 30)
    with mpmath.workdps(40):
        assert all(abs(row[0] - mpf(7) / 10) < mpf(10) ** -30 for row in rows)
        assert all(abs(row[1] - mpmath.pi / 2) < mpf(10) ** -30 for row in rows)
    # phi' = r
    assert all(b[2] < a[2] for a, b in itertools.pairwise(rows))
    step = F(1, 10**12)
    for t, state in zip(times, states, strict=True):
        before, after = top.angles([t - step, t + step], 50)
        with mpmath.workdps(60):
            slope = (after[2] - before[2]) / (2 * number(step))
            assert abs(slope - state[2]) < mpf(10) ** -22  # step^2 times the third derivative
    period = top.period(30)
    later = F(int(period.man)) * F(2) ** int(period.exp)
    (one,), (other,) = top.angles([F(1)], 25), top.angles([1 + later], 25)
    with mpmath.workdps(40):
        assert abs(other[2] - one[2] + 2 * mpmath.pi) < mpf(10) ** -24


def count_jumps(rows):
    """(steps of psi, steps of phi) in units of pi, between samples."""
    jumps = []
    for a, b in itertools.pairwise(rows):
        pair = tuple(float((b[i] - a[i]) / mpmath.pi) for i in (0, 2))
        assert all(abs(x - round(x)) < 1e-12 for x in pair)
        if any(abs(x) > 1e-12 for x in pair):
            jumps.append((round(pair[0]), round(pair[1])))
    return jumps


def test_through_the_poles():
    """psi jumps up by pi; psi + phi is continuous at theta = 0, psi - phi at theta = pi."""
    forward = top_of("rotation")
    rows = forward.angles([F(k, 50) for k in range(200)], 20)
    assert count_jumps(rows)[:4] == [(1, 1), (1, -1), (1, 1), (1, -1)]
    assert min(row[1] for row in rows) < 0.05
    backward = forward.angles([F(-k, 50) for k in range(200)], 20)
    assert count_jumps(backward)[:3] == [(1, -1), (1, 1), (1, -1)]
    # A libration takes the jump back where it returns.
    jumps = count_jumps(top_of("libration").angles([F(k, 20) for k in range(200)], 20))
    assert jumps[:3] == [(1, 1), (-1, -1), (1, 1)]


@pytest.mark.sample(3)
@pytest.mark.parametrize("third", [1, -1])
@pytest.mark.parametrize("rate", [F(3), F(-3), F(0)])
def test_from_a_pole(third, rate):
    """psi and phi are None there; afterwards they start from their limits."""
    moments, torque = fractions(PLANE[0]), fractions(PLANE[1])
    top = Pendulum(moments, torque, (rate, F(0), F(0)), (F(0), F(0), F(third)), PSI)
    tiny = F(1, 10**20)
    at_pole, after, before = top.angles([F(0), tiny, -tiny], 20)
    assert at_pole == [None, at_pole[1], None]
    # g2' = g3 p; released at rest p = -g3 t Mg y0/A, so g2 has the sign of -p'(0) third.
    ahead = third * rate if rate else -1
    behind = -ahead if rate else ahead
    for row, side in ((after, ahead), (before, behind)):
        assert abs(row[2] - (0 if side > 0 else mpmath.pi)) % (2 * mpmath.pi) < 1e-15
        assert abs(row[0] + third * row[2] - mpf("0.7")) < 1e-15  # psi +- phi is continuous


def test_a_pole_met_within_rounding():
    """Time a period, cut to 40 digits, after the start at a pole: the side of the pole is known."""
    top = Pendulum(
        fractions(PLANE[0]), fractions(PLANE[1]), fractions((3, 0, 0)), fractions((0, 0, 1)), PSI
    )
    period = top.period(60)
    with mpmath.workdps(80):
        later = F(mpmath.nstr(period, 40, strip_zeros=False))
        early = number(later) < period
    (row,) = top.angles([later], 15)
    assert row[0] is not None
    assert abs(row[1]) < 1e-30
    # One turn passes theta = pi once, and on the far side theta = 0 again.
    turns = (row[0] - mpf("0.7")) / mpmath.pi
    assert abs(turns - round(turns)) < 1e-12
    assert round(turns) == (1 if early else 2)


@pytest.mark.parametrize("size", [F(1, 10**20), F(-1, 10**100)])
def test_axes_turned_by_next_to_nothing(size):
    """gamma passes axis 3 at a distance of 1e-20: psi and phi turn by almost pi, nowhere lost."""
    root = exact.sqrt(1 - size * size)
    axes = ((root, F(0), size), (F(0), F(1), F(0)), (-size, F(0), root))
    moments, torque, omega, gamma = data("rotation")
    top = Pendulum(moments, torque, in_scene(omega, axes), in_scene(gamma, axes), PSI, axes)
    plain = top_of("rotation")
    times = [F(1, 3), F(2), F(11, 2), F(-3)]
    low, high = top.angles(times, 20), top.angles(times, 50)
    assert gap(low, high) < mpf(10) ** -20
    for one, two in zip(high, plain.angles(times, 30), strict=True):
        for i in (0, 2):  # the same but for turns: on which side a pole is passed decides
            turns = (one[i] - two[i]) / (2 * mpmath.pi)
            assert abs(turns - round(turns)) < 1e-15
        assert abs(one[1] - two[1]) < 1e-15


@pytest.mark.sample(3)
@pytest.mark.parametrize("scale", [F(1, 10**30), F(10**30)])
@pytest.mark.parametrize("name", ["libration", "rotation", "separatrix"])
def test_units_of_1e30(name, scale):
    moments, torque, omega, gamma = data(name)
    plain = top_of(name)
    scaled = Pendulum(
        tuple(x * scale for x in moments),
        tuple(x * scale**3 for x in torque),
        tuple(x * scale for x in omega),
        gamma,
        PSI,
    )
    times = [F(3), F(50)]
    there = [t / scale for t in times]
    with mpmath.workdps(60):
        ones = [[*(x * number(scale) for x in row[:3]), *row[3:]] for row in plain.at(times, 50)]
    assert distance(ones, scaled.at(there, 50)) < mpf(10) ** -50
    assert gap(plain.angles(times, 30), scaled.angles(there, 30)) < mpf(10) ** -30


@pytest.mark.parametrize("name", ["libration", "rotation", "below the separatrix by 1e-60"])
def test_energy_at_1e12(name):
    top, (moments, torque, _, _) = top_of(name), data(name)
    before, after = top.at([F(0), F(10**12)], 50)
    with mpmath.workdps(60):
        A, T = ([number(x) for x in row] for row in (moments, torque))

        def energy(row):
            kinetic = sum(a * x * x for a, x in zip(A, row, strict=False)) / 2
            return kinetic + mpmath.fdot(T, row[3:])

        assert abs(energy(before) - energy(after)) < mpf(10) ** -48
        assert abs(mpmath.norm(mpmath.matrix(after[3:])) - 1) < mpf(10) ** -49
        assert abs(before[4] - after[4]) > 1e-6


def _parts(x):
    sign, mantissa, exponent, _ = x._mpf_
    return (-int(mantissa) if sign else int(mantissa)), exponent


def test_there_and_back():
    """From the state at t = 7, back by 7: the start, through rounded and hence irrational data."""
    top = top_of("libration")
    (row,) = top.at([F(7)], 70)  # and two or three more
    values = [exact.binary(*_parts(x)) for x in row]
    size = exact.sqrt(values[4] ** 2 + values[5] ** 2)
    gamma = (F(0), values[4] / size, values[5] / size)
    moments, torque, _, _ = data("libration")
    back = Pendulum(moments, torque, (values[0], F(0), F(0)), gamma)
    error = distance(back.at([F(-4), F(-7)], 80), top.at([F(3), F(0)], 80))
    assert mpf(10) ** -76 < error < mpf(10) ** -70


def test_precision_in_force_is_left_alone():
    with mpmath.workprec(77):
        top = top_of("libration")
        top.angles([F(3)], 100)
        top.at([F(3)], 100)
        top.period(100)
        assert mpmath.prec == 77


def test_the_axis_of_a_motion_released_is_that_of_the_moment():
    moments, torque, _, gamma = data("released")
    n = cross(torque, gamma)
    assert n[1] == n[2] == 0
    assert fits(moments, torque, fractions((0, 0, 0)), gamma)
