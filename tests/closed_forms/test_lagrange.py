"""Lagrange's top against its equations, an independent integration, and stored values.

Errors are asked to lie in a band: asked for 50 digits, more than 1e-70 (a check that compares a
thing with itself is none) and less than 1e-50.
"""

import itertools
import json
import random
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from polhode.closed_forms.lagrange import axes as top_axes
from polhode.closed_forms.lagrange.top import LagrangeTop
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import series
from shared.closed_form_checks import (
    belongs,
    distance,
    error_of_1000_digits,
    fractions,
    full_inertia,
    in_scene,
    number,
    rational_axes,
    residuals,
    rotation,
)
from shared.examples import examples
from shared.lagrange_motions import (
    CONSTANT,
    GAMMA,
    MOTIONS,
    PSI,
    TILT,
    motion,
    small,
    speed,
    tilted,
    top_of,
)

F = Fraction
fits = belongs(top_axes.fits)
DATA = Path(__file__).parents[1] / "data" / "closed-form-50-digits.json"
CASES = [c for c in json.loads(DATA.read_text())["cases"] if c["group"] == "lagrange"]
FAST = ["fast"]


@pytest.mark.parametrize("name", MOTIONS)
def test_regime_is_named(name):
    assert top_of(name).regime == MOTIONS[name][4]


@pytest.mark.parametrize(
    ("moments", "torque", "fit"),
    [
        ((1, 1, 2), (0, 0, 1), True),
        ((1, 1, 2), (0, 0, -1), True),
        ((2, 1, 1), (3, 0, 0), True),
        ((1, 2, 1), (0, 3, 0), True),
        ((1, 1, 1), (1, 2, 3), True),
        ((1, 1, 1), (0, 0, 0), False),
        ((1, 1, 2), (0, 0, 0), False),
        ((1, 1, 2), (0, 1, 1), False),
        ((1, 1, 2), (1, 0, 0), False),
        ((1, F(3, 2), 2), (0, 0, 1), False),
    ],
)
def test_which_bodies_fit(moments, torque, fit):
    assert fits(fractions(moments), fractions(torque)) is fit
    if not fit:
        with pytest.raises(ValueError, match="not a Lagrange top"):
            LagrangeTop(fractions(moments), fractions(torque), fractions((0, 0, 1)), GAMMA)


@pytest.mark.sample(8)
@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree(name):
    top, times = top_of(name), [F(0), F(7, 3), F(-11), F(10**4), F(-(10**12))]
    for low, high in ((15, 33), (50, 90)):
        for answers, scale in ((top.at, speed(name)), (top.attitude, 1)):
            error = distance(answers(times, low), answers(times, high), scale)
            constant = MOTIONS[name][4].startswith(("rest", "sleep", "hang"))
            if constant and answers == top.at:
                assert error == 0
            else:
                assert mpf(10) ** (-low - 25) < error < mpf(10) ** -low


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "nutation",
        "homoclinic",
        pytest.param("upper pole", marks=pytest.mark.slow),
        pytest.param("next to the pole 1e-30", marks=pytest.mark.slow),
    ],
)
def test_1000_digits(name):
    error = error_of_1000_digits(top_of(name), [F(10**12) if name != "homoclinic" else F(20)])
    assert mpf(10) ** -1015 < error < mpf(10) ** -1000


@pytest.mark.sample(8, first=1)
@pytest.mark.parametrize("name", MOTIONS)
def test_equations_are_satisfied(name):
    step = F(1, 10 ** (46 if name in FAST else 40))
    errors, psi = residuals(top_of(name), *motion(name)[:2], step, angles=True)
    scale = max(speed(name), 1)
    errors = [error / scale for error in errors]
    assert max(errors[:10]) < mpf(10) ** -150
    # Near a pole psi turns fast: what the five-point rule leaves out grows with psi'.
    assert max(errors) < mpf(10) ** (-150 if psi < 10 * scale else -90)
    assert max(errors) == 0 if name in CONSTANT else max(errors) > mpf(10) ** -185


@pytest.mark.sample(6, slow=8)
@pytest.mark.parametrize("name", MOTIONS)
def test_independent_integration_agrees(name):
    moments, torque, omega, gamma = motion(name)
    top = top_of(name)
    end = F(1, 10**5) if name in FAST else F(3)
    start = top.attitude([F(0)], 75)[0]
    for times in ([end / 4, end], [-end / 3]):
        taylor = series.integrate(moments, omega, gamma, times, 56, torque=torque, quaternion=start)
        closed = [a + b for a, b in zip(top.at(times, 50), top.attitude(times, 50), strict=True)]
        assert mpf(10) ** -62 < distance(taylor, closed, speed(name)) < mpf(10) ** -50


@pytest.mark.parametrize("case", CASES, ids=[c["name"] for c in CASES])
def test_stored_values(case):
    """States, psi, and a second vector fixed in space that only the attitude can follow."""
    weight = F(case["weight"])
    top = LagrangeTop(
        fractions(case["moments"]),
        tuple(weight * F(x) for x in case["centre"]),
        fractions(case["omega"]),
        fractions(case["gamma"]),
    )
    times = fractions(case["times"])
    with mpmath.workdps(70):
        stored = [list(map(mpf, row)) for row in case["states"]]
        error = distance(stored, top.at(times, 50))
        assert error < mpf(10) ** -49
        assert error > mpf(10) ** -60 or "sleeping" in case["regime"]
        begin = rotation(top.attitude([F(0)], 60)[0])
        fixed = begin * mpmath.matrix([mpf(x) for x in case["second_axis_start"]])
        for row, attitude in zip(case["second_axis"], top.attitude(times, 50), strict=True):
            seen = rotation(attitude).T * fixed
            assert max(abs(mpf(x) - y) for x, y in zip(row, seen, strict=True)) < mpf(10) ** -49
        for psi, row in zip(case.get("psi", ()), top.angles(times, 50), strict=False):
            assert abs(mpf(psi) - row[0]) < mpf(10) ** -49


@pytest.mark.sample(3)
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [1, -1])
def test_every_labelling_and_every_sign(axis, side):
    for signs in itertools.product((1, -1), repeat=3):
        moments, torque = [F(1)] * 3, [F(0)] * 3
        moments[axis], torque[axis] = F(7, 10), F(13 * side, 10)
        omega = tuple(s * x for s, x in zip(signs, (F(3, 10), F(2, 5), F(3, 2)), strict=True))
        top = LagrangeTop(tuple(moments), tuple(torque), omega, GAMMA, PSI)
        start = top.attitude([F(0)], 40)[0]
        taylor = series.integrate(
            moments, omega, GAMMA, [F(3, 2)], 25, torque=torque, quaternion=start
        )
        closed = [top.at([F(3, 2)], 20)[0] + top.attitude([F(3, 2)], 20)[0]]
        assert mpf(10) ** -32 < distance(taylor, closed) < mpf(10) ** -20


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize(
    "name", ["nutation", "upper pole", "cusped", "first axis", "homoclinic", "sphere"]
)
def test_turned_axes(name):
    """A body given in axes that are not principal, against the integration of its full matrix."""
    moments, torque, omega, gamma = motion(name)
    axes = rational_axes()
    omega, gamma = in_scene(omega, axes), in_scene(gamma, axes)
    top, times = LagrangeTop(moments, torque, omega, gamma, PSI, axes), [F(1), F(4)]
    assert top.regime == top_of(name).regime
    start = top.attitude([F(0)], 60)[0]
    taylor = series.integrate(
        full_inertia(moments, axes),
        omega,
        gamma,
        times,
        45,
        torque=in_scene(torque, axes),
        quaternion=start,
    )
    closed = [a + b for a, b in zip(top.at(times, 40), top.attitude(times, 40), strict=True)]
    assert mpf(10) ** -52 < distance(taylor, closed) < mpf(10) ** -40


@pytest.mark.sample(6)
@pytest.mark.parametrize("regime", ["looping", "nutation"])
@pytest.mark.parametrize("seed", range(10))
def test_looping_is_a_change_of_sign_of_the_precession(seed, regime):
    """psi' sampled over a nutation; the names were decided from the exact start alone."""
    draw = random.Random(seed)
    torque = (F(0), F(0), F(1))
    while True:
        omega = tuple(F(draw.randint(-20, 20), 10) for _ in range(3))
        moments = F(1), F(1), F(draw.randint(1, 20), 10)
        top = LagrangeTop(moments, torque, omega, GAMMA)
        if top.regime == regime:
            break
    period = F(float(top.nutation(17)))
    rows = top.at([period * F(k, 200) for k in range(200)], 15)
    signs = {mpmath.sign(p * g1 + q * g2) for p, q, _, g1, g2, _ in rows}
    assert len(signs) == (2 if regime == "looping" else 1)


sizes = st.sampled_from([F(0), small(3), small(12), small(30), small(60)])
plain = st.integers(-30, 30).map(lambda n: F(n, 10))
signed = st.tuples(st.sampled_from([-1, 1]), sizes).map(lambda pair: pair[0] * pair[1])
component = st.one_of(plain, plain, signed)
spin = st.one_of(plain, signed, st.tuples(plain, signed).map(sum))


@st.composite
def verticals(draw):
    """Rational unit vectors, near each axis too."""
    x, y = draw(component), draw(component)
    n = 1 + x * x + y * y
    row = [2 * x / n, 2 * y / n, draw(st.sampled_from([-1, 1])) * (2 - n) / n]
    return tuple(row[i] for i in draw(st.permutations(range(3))))


@pytest.mark.slow
@settings(max_examples=examples(100), deadline=None, derandomize=True)
@given(
    st.integers(0, 2),
    st.one_of(st.integers(1, 20).map(lambda n: F(n, 10)), signed.map(lambda x: 1 + x)),
    st.one_of(plain.filter(bool), sizes.filter(bool)),
    st.tuples(spin, component, component),
    verticals(),
    st.integers(-15, 15).filter(bool).map(lambda n: F(n, 10)),
)
def test_random_motions_with_zeros_equal_values_and_tiny_differences(axis, C, K, w, gamma, end):
    moments, torque = [F(1)] * 3, [F(0)] * 3
    moments[axis], torque[axis] = C, K
    omega = (*w[1:], w[0])
    omega = tuple(omega[(i - axis - 1) % 3] for i in range(3))
    top = LagrangeTop(tuple(moments), tuple(torque), omega, gamma)
    start = top.attitude([F(0)], 40)[0]
    taylor = series.integrate(moments, omega, gamma, [end], 38, torque=torque, quaternion=start)
    closed = [a + b for a, b in zip(top.at([end], 30), top.attitude([end], 30), strict=True)]
    with mpmath.workdps(50):
        scale = max([abs(number(x)) for x in omega] + [mpmath.sqrt(abs(number(K)))])
        rest = max(abs(x) for x in taylor[0][:3])
    assert distance(taylor, closed, min(scale, max(rest, *map(abs, start)))) < mpf(10) ** -30


@pytest.mark.parametrize(
    "name", [n for n in MOTIONS if n not in ("homoclinic", "separatrix", "fast", *CONSTANT)]
)
def test_invariants_at_1e12(name):
    moments, torque, _, _ = motion(name)
    before, after = top_of(name).at([F(0), F(10**12)], 50)
    with mpmath.workdps(60):
        A, K = ([number(a) for a in row] for row in (moments, torque))

        def invariants(row):
            w, g = row[:3], row[3:]
            G = [a * x for a, x in zip(A, w, strict=True)]
            energy = mpmath.fdot(G, w) / 2 + mpmath.fdot(K, g)
            return [energy, mpmath.fdot(G, g), mpmath.fdot(g, g), mpmath.fdot(G, K)]

        drift = [abs(x - y) for x, y in zip(invariants(before), invariants(after), strict=True)]
        assert max(drift) < mpf(10) ** -49 * max(speed(name), 1) ** 2


@pytest.mark.parametrize("scale", [F(1, 10**30), F(10**30)])
def test_units_of_1e30(scale):
    """Another unit of time, and another one of mass with it."""
    for name in ("nutation", "cusped", "upper pole", "near homoclinic 1e-20"):
        moments, torque, omega, gamma = motion(name)
        plain, times = top_of(name), [F(3), F(-50)]
        other = LagrangeTop(
            tuple(scale * x for x in moments),
            tuple(x * scale**3 for x in torque),
            tuple(x * scale for x in omega),
            gamma,
            PSI,
        )
        assert other.regime == plain.regime
        there = [t / scale for t in times]
        with mpmath.workdps(60):
            for one, two in zip(plain.at(times, 50), other.at(there, 50), strict=True):
                for i, (x, y) in enumerate(zip(one, two, strict=True)):
                    assert abs(x - (y / number(scale) if i < 3 else y)) < mpf(10) ** -49
        assert distance(plain.angles(times, 30), other.angles(there, 30)) < mpf(10) ** -29


def test_irrational_data():
    """By the rule for equal: a cusp, a sleeping top at its critical spin, a homoclinic motion."""
    c, s = exact.cos(F(1, 3)), exact.sin(F(1, 3))
    zero, one = F(0), F(1)
    cusp = LagrangeTop((one, one, F(1, 2)), (zero, zero, one), (zero, zero, F(5)), (s, zero, c))
    assert cusp.regime == "cusped"
    spin = 2 * exact.sqrt(F(2))
    critical = LagrangeTop(
        (one, one, one), (zero, zero, F(2)), (zero, zero, spin), (zero, zero, one)
    )
    assert critical.regime == "sleeping, critical spin"
    # F = n and b = 1, with a = 1: p s = n (1 - c) and p^2 = 1 - c.
    p = exact.sqrt(1 - c)
    homoclinic = LagrangeTop(
        (one, one, one), (zero, zero, F(1, 2)), (p, zero, p * s / (1 - c)), (s, zero, c)
    )
    assert homoclinic.regime == "homoclinic to the sleeping top"
    for top in (cusp, homoclinic):
        (low,), (high,) = top.at([F(3)], 40), top.at([F(3)], 60)
        assert mpf(10) ** -60 < distance([low], [high]) < mpf(10) ** -40


def test_the_name_does_not_depend_on_the_side_of_the_axis():
    """Hanging and upright change places with the sign of the weight; the motion does not."""
    moments, omega = (F(1), F(1), F(1, 2)), (F(1, 3), F(0), F(2))
    up = LagrangeTop(moments, (F(0), F(0), F(1)), omega, TILT)
    p, q, r = omega
    g1, g2, g3 = TILT
    down = LagrangeTop(moments, (F(0), F(0), F(-1)), (p, -q, -r), (g1, -g2, -g3))
    assert up.regime == down.regime
    (one,), (other,) = up.at([F(7)], 40), down.at([F(7)], 40)
    with mpmath.workdps(50):
        for i, (x, y) in enumerate(zip(one, other, strict=True)):
            assert abs(x - (y if i % 3 == 0 else -y)) < mpf(10) ** -40


@pytest.mark.slow
def test_close_to_the_vertical_nothing_is_lost():
    """gamma within 1e-200 of the axis of a stable sleeper: the tilt keeps its leading digits."""
    moments, torque = (F(1), F(1), F(4, 5)), (F(0), F(0), F(1))
    top = LagrangeTop(moments, torque, (F(0), F(0), F(4)), tilted(small(200)))
    (low,), (high,) = top.angles([F(9)], 220), top.angles([F(9)], 260)
    with mpmath.workdps(270):
        assert abs(low[1] - high[1]) < mpf(10) ** -219
        assert mpf(10) ** -201 < high[1] < mpf(10) ** -199


def test_precision_in_force_is_left_alone():
    with mpmath.workprec(77):
        top_of("nutation").angles([F(3)], 100)
        assert mpmath.prec == 77
