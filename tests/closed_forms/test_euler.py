"""The torque-free body against its equations, an independent integration, and published-style data.

Errors are asked to lie in a band: asked for 50 digits, more than 1e-70 (a check that compares a
thing with itself is none) and less than 1e-50.
"""

import functools
import itertools
import json
import math
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import series
from shared.closed_form_checks import (
    check_attitude,
    distance,
    error_of_1000_digits,
    euler_top,
    fractions,
    full_inertia,
    in_scene,
    number,
    rational_axes,
    residuals,
    rotation,
    unwound,
)
from shared.examples import examples

F = Fraction
PSI = F(7, 10)
GAMMA = (F(12, 25), F(3, 5), F(16, 25))
DATA = Path(__file__).parents[1] / "data" / "closed-form-50-digits.json"
CASES = [c for c in json.loads(DATA.read_text())["cases"] if c["group"] == "euler"]


#: name: moments, omega, regime.  The separatrices: p^2 A(B-A) = r^2 C(C-B) makes G^2 = 2hB.
MOTIONS = {
    "rest": ((1, "1.5", 2), (0, 0, 0), "rest"),
    "sphere": (("1.1", "1.1", "1.1"), ("0.3", "-0.7", "1.1"), "sphere"),
    "spin about C": (
        (1, "1.5", 2),
        (0, 0, "-1.5"),
        "permanent rotation about the largest-moment axis",
    ),
    "spin about A": (
        (1, "1.5", 2),
        ("0.7", 0, 0),
        "permanent rotation about the smallest-moment axis",
    ),
    "spin about B": (
        (1, "1.5", 2),
        (0, "0.7", 0),
        "permanent rotation about the middle-moment axis",
    ),
    "symmetry axis": ((1, 1, 2), (0, 0, 2), "permanent rotation about the symmetry axis"),
    "equator": ((1, 1, 2), ("0.3", "0.4", 0), "permanent rotation about an equatorial axis"),
    "oblate": ((1, 1, "1.7"), ("0.5", "-0.3", "1.2"), "axisymmetric, oblate: regular precession"),
    "prolate": (("1.7", 1, "1.7"), ("0.5", "-0.3", 1), "axisymmetric, prolate: regular precession"),
    "needle": (("1e-6", 1, 1), (9, "0.1", 1), "axisymmetric, prolate: regular precession"),
    "around C": ((1, "1.5", 2), ("0.3", "0.4", "1.5"), "polhode about the largest-moment axis"),
    "around A": ((1, "1.5", 2), ("1.5", "-0.4", "0.3"), "polhode about the smallest-moment axis"),
    "lamina": ((1, "1.5", "2.5"), ("1", "-0.4", "-1"), "polhode about the largest-moment axis"),
    "separatrix": (("1.5", 2, 3), ("0.8", "0.3", "0.4"), "separatrix"),
    "turning point": ((1, "1.5", 2), ("0.3", 0, "1.5"), "polhode about the largest-moment axis"),
    "other turning point": (
        (1, "1.5", 2),
        (0, "1.5", "1.2"),
        "polhode about the largest-moment axis",
    ),
    "Dzhanibekov 1e-12": (
        (1, "1.5", 2),
        ("1e-12", 2, "-2e-12"),
        "polhode about the largest-moment axis",
    ),
    "Dzhanibekov 1e-100": (
        (1, "1.5", 2),
        ("1e-100", 2, 0),
        "polhode about the smallest-moment axis",
    ),
    "near C": ((1, "1.5", 2), ("1e-10", "-2e-10", "1.5"), "polhode about the largest-moment axis"),
    "nearly symmetric": (
        (1, "1.0000000000000000000000001", "1.3"),
        ("0.5", "0.2", "0.9"),
        "polhode about the largest-moment axis",
    ),
    "nearly a sphere": (
        (
            "1",
            "1.000000000000000000000000000000000000000000000000000000000001",
            F(1) + F(3, 10**300),
        ),
        ("0.5", "0.2", "0.9"),
        "polhode about the largest-moment axis",
    ),
    "next to the separatrix 1e-60": (
        ("1.5", 2, 3),
        ("0.8", "0.3", F(4, 10) + F(1, 10**60)),
        "polhode about the largest-moment axis",
    ),
}
MOVING = [name for name in MOTIONS if name != "rest"]


@functools.cache
def top_of(name, gamma=GAMMA, psi=PSI):
    """One motion for all tests that ask for it: its constants are made once."""
    moments, omega, _ = MOTIONS[name]
    return euler_top(fractions(moments), fractions(omega), gamma, psi)


def speed(omega):
    with mpmath.workdps(150):
        return max(abs(number(F(x))) for x in omega) or mpf(1)


@pytest.mark.parametrize("name", MOTIONS)
def test_regime_is_named(name):
    assert top_of(name).regime == MOTIONS[name][2]


@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree(name):
    top, times = top_of(name), [F(0), F(7, 3), F(-11), F(10**4), F(-(10**12))]
    scale = speed(MOTIONS[name][1])
    for low, high in ((15, 33), (50, 90)):
        for answers in (top.at, top.attitude):
            error = distance(answers(times, low), answers(times, high), scale)
            assert mpf(10) ** (-low - 20) < error < mpf(10) ** -low


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", ["around C", "around A", "separatrix", "sphere"])
def test_1000_digits(name):
    error = error_of_1000_digits(top_of(name), [F(10**12)])
    assert mpf(10) ** -1010 < error < mpf(10) ** -1000


@pytest.mark.parametrize("name", MOTIONS)
def test_equations_are_satisfied(name):
    errors, _ = residuals(top_of(name), fractions(MOTIONS[name][0]))
    error = max(errors) / speed(MOTIONS[name][1])
    assert error < mpf(10) ** -150
    assert error == 0 if name == "rest" else error > mpf(10) ** -180


@pytest.mark.parametrize("name", MOTIONS)
def test_attitude_carries_the_vertical_and_starts_with_psi(name):
    top = top_of(name)
    times = [F(0), F(5, 3), F(-9)]
    states, attitudes, angles = (f(times, 50) for f in (top.at, top.attitude, top.angles))
    with mpmath.workdps(60):
        for row in zip(states, attitudes, angles, strict=True):
            check_attitude(*row)
        assert attitudes[0][0] >= 0
        assert abs(angles[0][0] - mpf(7) / 10) < mpf(10) ** -50
        assert abs(angles[0][2] - mpmath.atan2(number(GAMMA[0]), number(GAMMA[1]))) < mpf(10) ** -50


@pytest.mark.sample(4, slow=5)
@pytest.mark.parametrize("name", MOVING)
def test_independent_integration_agrees(name):
    moments, omega, _ = MOTIONS[name]
    top = top_of(name)
    end = F(1, 2) if name == "needle" else F(7)  # the needle precesses 9 times less than it spins
    times = [end / 4, end]
    start = top.attitude([F(0)], 75)[0]
    taylor = series.integrate(
        fractions(moments), fractions(omega), GAMMA, times, 55, quaternion=start
    )
    closed = [a + b for a, b in zip(top.at(times, 50), top.attitude(times, 50), strict=True)]
    error = distance(taylor, closed, speed(omega))
    assert error < mpf(10) ** -50
    assert error > mpf(10) ** -60


@pytest.mark.parametrize("case", CASES, ids=[c["name"] for c in CASES])
def test_stored_values(case):
    """States, and a second vector fixed in space that only the attitude can follow."""
    top = euler_top(*(fractions(case[key]) for key in ("moments", "omega", "gamma")))
    times = fractions(case["times"])
    with mpmath.workdps(70):
        stored = [list(map(mpf, row)) for row in case["states"]]
        assert mpf(10) ** -60 < distance(stored, top.at(times, 50)) < mpf(10) ** -49
        begin = rotation(top.attitude([F(0)], 60)[0])
        fixed = begin * mpmath.matrix([mpf(x) for x in case["second_axis_start"]])
        for row, attitude in zip(case["second_axis"], top.attitude(times, 50), strict=True):
            seen = rotation(attitude).T * fixed
            assert max(abs(mpf(x) - y) for x, y in zip(row, seen, strict=True)) < mpf(10) ** -49


@pytest.mark.sample(3)
@pytest.mark.parametrize("order", list(itertools.permutations((F(1), F(3, 2), F(2)))))
def test_every_order_of_moments_and_every_sign(order):
    for signs in itertools.product((1, -1), repeat=3):
        for size in ((F(3, 10), F(2, 5), F(3, 2)), (F(1), F(0), F(1, 2))):
            omega = tuple(s * x for s, x in zip(signs, size, strict=True))
            top = euler_top(order, omega, GAMMA)
            (state,) = series.integrate(order, omega, GAMMA, [F(3, 2)], 20)
            assert mpf(10) ** -32 < distance([state], top.at([F(3, 2)], 20)) < mpf(10) ** -20


@pytest.mark.slow
def test_every_pattern_of_zeros_on_and_off_the_separatrix():
    for order in itertools.permutations((F(3, 2), F(2), F(3))):
        for omega in itertools.product((F(0), F(-2, 5), F(4, 5)), repeat=3):
            top = euler_top(order, omega, GAMMA)
            (state,) = series.integrate(order, omega, GAMMA, [F(1, 2)], 18)
            assert distance([state], top.at([F(1, 2)], 18)) < mpf(10) ** -18


sizes = st.sampled_from([F(0), F(1, 10**3), F(1, 10**12), F(1, 10**60)])
plain = st.integers(-30, 30).map(lambda n: F(n, 10))
signed = st.tuples(st.sampled_from([-1, 1]), sizes).map(lambda pair: pair[0] * pair[1])
component = st.one_of(plain, plain, signed)
difference = st.one_of(st.integers(-9, 9).map(lambda n: F(n, 20)), signed)


@pytest.mark.slow
@settings(max_examples=examples(120), deadline=None, derandomize=True)
@given(
    st.tuples(difference, difference, difference),
    st.tuples(component, component, component),
    st.integers(-20, 20).filter(bool).map(lambda n: F(n, 10)),
)
def test_random_motions_with_zeros_equal_values_and_tiny_differences(differences, omega, end):
    moments = tuple(1 + x for x in differences)
    top = euler_top(moments, omega, GAMMA)
    start = top.attitude([F(0)], 40)[0]
    if not any(omega):
        assert top.at([end], 30)[0][:3] == [0, 0, 0]
        return
    taylor = series.integrate(moments, omega, GAMMA, [end], 35, quaternion=start)
    closed = [a + b for a, b in zip(top.at([end], 30), top.attitude([end], 30), strict=True)]
    assert distance(taylor, closed, speed(omega)) < mpf(10) ** -30


def test_irrational_data_and_turned_axes():
    """A start along the angular momentum, seen in axes turned by 1/3, is the same motion turned."""
    c, s = exact.cos(F(1, 3)), exact.sin(F(1, 3))
    axes = ((c, s, F(0)), (-s, c, F(0)), (F(0), F(0), F(1)))
    moments, omega = (F(1), F(3, 2), F(2)), (F(3, 10), F(2, 5), exact.sqrt(F(2)))

    plain, turned = (
        euler_top(moments, omega, GAMMA),
        euler_top(moments, in_scene(omega, axes), in_scene(GAMMA, axes), axes=axes),
    )
    assert plain.regime == turned.regime
    times = [F(1), F(100)]
    with mpmath.workdps(60):
        for one, other in zip(plain.at(times, 50), turned.at(times, 50), strict=True):
            c1, s1 = mpmath.cos_sin(mpf(1) / 3)
            for i in (0, 3):
                assert abs(c1 * one[i] - s1 * one[i + 1] - other[i]) < mpf(10) ** -50
                assert abs(s1 * one[i] + c1 * one[i + 1] - other[i + 1]) < mpf(10) ** -50
        # The same body axes are seen from space, but for the turn and the different phi.
        for one, other in zip(plain.attitude(times, 50), turned.attitude(times, 50), strict=True):
            third = rotation(one)[:, 2] - rotation(other)[:, 2]
            psi = plain.angles([F(0)], 50)[0][0] - turned.angles([F(0)], 50)[0][0]
            assert psi == 0
            assert mpmath.norm(third) < mpf(10) ** -50


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", ["around C", "around A", "oblate", "separatrix", "spin about B"])
def test_full_inertia_matrix(name):
    """A body given in axes that are not principal, against the integration of its full matrix."""
    moments, _, _ = MOTIONS[name]
    moments, omega, axes = fractions(moments), (F(3, 10), F(-7, 10), F(11, 10)), rational_axes()
    if name in ("separatrix", "spin about B"):
        principal = fractions(MOTIONS[name][1])
        omega = in_scene(principal, axes)
    inertia = full_inertia(moments, axes)
    top, times = euler_top(moments, omega, GAMMA, PSI, axes), [F(1), F(4)]
    start = top.attitude([F(0)], 60)[0]
    taylor = series.integrate(inertia, omega, GAMMA, times, 45, quaternion=start)
    closed = [a + b for a, b in zip(top.at(times, 40), top.attitude(times, 40), strict=True)]
    assert mpf(10) ** -52 < distance(taylor, closed) < mpf(10) ** -40
    psi, _, phi = top.angles([F(9)], 15)[0]
    more_psi, more_phi = unwound(top, F(0), F(9), 540)
    assert abs(psi - mpf("0.7") - more_psi) < 1e-12
    assert abs(phi - mpmath.atan2(12, 15) - more_phi) < 1e-12


@pytest.mark.parametrize(
    "name", ["around C", "around A", "separatrix", "oblate", "prolate", "sphere"]
)
def test_invariants_at_1e12(name):
    top, A = top_of(name), fractions(MOTIONS[name][0])
    before, after = top.at([F(0), F(10**12)], 50)
    with mpmath.workdps(60):
        A = [number(a) for a in A]

        def invariants(row):
            w, g = row[:3], row[3:]
            G = [a * x for a, x in zip(A, w, strict=True)]
            return [mpmath.fdot(G, w), mpmath.fdot(G, G), mpmath.fdot(G, g), mpmath.fdot(g, g)]

        drift = [abs(x - y) for x, y in zip(invariants(before), invariants(after), strict=True)]
    assert max(drift) < mpf(10) ** -49


@pytest.mark.sample(4, slow=4)
@pytest.mark.parametrize("name", MOVING)
def test_quaternion_never_changes_sign(name):
    """Samples so close that the quaternion moves by less than 0.2."""
    top = top_of(name)
    count = 400
    step = F(1, 8) / max(1, *(abs(x) for x in fractions(MOTIONS[name][1])))
    rows = top.attitude([step * (k - count // 2) for k in range(count)], 15)
    assert max(distance([a], [b]) for a, b in itertools.pairwise(rows)) < 0.2
    assert rows[count // 2][0] >= 0


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("end", [F(17), F(-17)])
def test_psi_and_phi_count_their_turns(name, end):
    top = top_of(name)
    psi, _, phi = top.angles([end], 15)[0]
    if name == "needle":
        end = F(0)  # too fast for the samples below
        psi, _, phi = top.angles([end], 15)[0]
    more_psi, more_phi = unwound(top, F(0), end, 60 * math.ceil(abs(end))) if end else (0, 0)
    assert abs(psi - mpf("0.7") - more_psi) < 1e-12
    assert abs(phi - mpmath.atan2(12, 15) - more_phi) < 1e-12


@pytest.mark.slow
@pytest.mark.sample(2, first=1, rest="campaign")
@pytest.mark.parametrize("name", ["around C", "around A", "separatrix", "oblate", "sphere"])
def test_psi_is_the_integral_of_its_rate(name):
    moments, omega, _ = MOTIONS[name]
    top = top_of(name)
    row = series.integrate(fractions(moments), fractions(omega), GAMMA, [F(5)], 30, psi=F(7, 10))[0]
    assert mpf(10) ** -45 < abs(row[-1] - top.angles([F(5)], 30)[0][0]) < mpf(10) ** -30


def along_momentum(name, sign=1):
    moments, omega = (fractions(x) for x in MOTIONS[name][:2])
    G = [a * x for a, x in zip(moments, omega, strict=True)]
    size = sign * exact.sqrt(sum((x * x for x in G), F(0)))
    return top_of.__wrapped__(name, tuple(x / size for x in G))  # irrational ones have no hash


@pytest.mark.parametrize(
    ("gamma", "end"), [(("3/13", "12/13", "-4/13"), F(12)), (("-6/7", "2/7", "3/7"), F(-12))]
)
def test_turns_on_a_separatrix_where_the_vertical_is_far_from_the_momentum(gamma, end):
    """Towards the middle axis another term takes the lead: the start alone does not tell which."""
    top = top_of("separatrix", fractions(gamma))
    (psi, _, phi), (psi_1, _, phi_1) = top.angles([F(0), end], 15)
    grown = unwound(top, F(0), end, 120)
    assert abs(psi_1 - psi - grown[0]) < 1e-12
    assert abs(phi_1 - phi - grown[1]) < 1e-12


def straddling():
    return euler_top(
        (F(13, 10), F(11, 10), F(9, 5)), (F(0), F(3), F(29, 10)), (F(7, 25), F(0), F(24, 25))
    )


@pytest.mark.parametrize("third", [1, -1])
def test_from_a_pole(third):
    """psi and phi are None there; afterwards they start from their limits."""
    moments, omega, gamma = (
        (F(1), F(3, 2), F(2)),
        (F(3, 10), F(2, 5), F(3, 2)),
        (F(0), F(0), F(third)),
    )
    top = euler_top(moments, omega, gamma)
    tiny = F(1, 10**30)
    at_pole, after, later, before = top.angles([F(0), tiny, F(1), -tiny], 20)
    assert at_pole[0] is None
    assert at_pole[2] is None
    # gamma' = gamma x w: (g1, g2) starts along third (-q, p), so phi = atan2(-q, p) for third = 1.
    assert abs(after[2] - mpmath.atan2(-third * 4, third * 3)) < 1e-15
    assert abs(before[2] - mpmath.atan2(third * 4, -third * 3)) < 1e-15
    assert abs(after[0] + third * after[2]) < 1e-15  # psi +- phi is continuous
    assert abs(before[0] + third * before[2]) < 1e-15
    assert later[0] is not None


def test_always_at_a_pole():
    top = top_of("spin about C", (F(0), F(0), F(1)))
    assert top.angles([F(0), F(5)], 20) == [[None, 0, None], [None, 0, None]]


@pytest.mark.parametrize("scale", [F(1, 10**30), F(10**30)])
def test_units_of_1e30(scale):
    moments, omega, times = (F(1), F(3, 2), F(2)), (F(3, 10), F(2, 5), F(3, 2)), [F(3), F(50)]
    plain = euler_top(moments, omega, GAMMA)
    other = euler_top(tuple(scale * x for x in moments), tuple(x * scale for x in omega), GAMMA)
    times_there = [t / scale for t in times]
    with mpmath.workdps(60):
        for one, two in zip(plain.at(times, 50), other.at(times_there, 50), strict=True):
            for i, (x, y) in enumerate(zip(one, two, strict=True)):
                assert abs(x - (y / number(scale) if i < 3 else y)) < mpf(10) ** -50
    assert distance(plain.angles(times, 30), other.angles(times_there, 30)) < mpf(10) ** -29


@pytest.mark.parametrize("name", ["around C", "around A", "oblate", "prolate", "turning point"])
def test_period_brings_omega_back(name):
    top = top_of(name)
    with mpmath.workdps(70):
        period = top.period(60)
        man, exp = int(period.man), int(period.exp)
        later = F(man) * F(2) ** exp
        assert abs(top.frequencies(50)["polhode"] - 2 * mpmath.pi / period) < mpf(10) ** -50
        before, after, half = top.at([F(1), 1 + later, 1 + later / 2], 50)
        assert distance([before[:3]], [after[:3]]) < mpf(10) ** -50
        assert distance([before[:3]], [half[:3]]) > 0.1


#: Bodies that circle axis 3, as the motions of these names do.
CIRCLED = {
    "around C": (("1", "3/2", "2"), ("3/10", "2/5", "3/2")),
    "around A": (("3/2", "2", "1"), ("-2/5", "3/10", "3/2")),
    "oblate": (("1", "1", "17/10"), ("1/2", "-3/10", "6/5")),
    "prolate": (("17/10", "17/10", "1"), ("1/2", "-3/10", "1")),
}


@pytest.mark.sample(1, first=2)
@pytest.mark.parametrize("name", CIRCLED)
def test_frequency_of_precession_is_the_mean_rate_of_the_circled_axis(name):
    """About G, here vertical, over one period of w: psi integrated along, by Taylor's method."""
    moments, omega = (fractions(row) for row in CIRCLED[name])
    momentum = [a * w for a, w in zip(moments, omega, strict=True)]
    size = exact.sqrt(sum(x * x for x in momentum))
    top = euler_top(moments, omega, tuple(x / size for x in momentum))
    assert top.regime == MOTIONS[name][2]
    mean = top.frequencies(30)["precession"]
    with mpmath.workdps(70):
        period = top.period(60)
        vertical = [number(x) / number(size) for x in momentum]
        (row,) = series.integrate(moments, omega, vertical, [period], 45, psi=F(0))
        assert mpf(10) ** -40 < abs(row[-1] / period / mean - 1) < mpf(10) ** -30


def test_frequency_of_precession_on_the_separatrix():
    """It tends to the rotation about the middle axis, which is then along G: at the rate G/B."""
    moments, omega = (fractions(row) for row in MOTIONS["separatrix"][:2])
    size = exact.sqrt(sum((a * w) ** 2 for a, w in zip(moments, omega, strict=True)))
    mean = top_of("separatrix").frequencies(30)["precession"]
    with mpmath.workdps(50):
        assert mpf(10) ** -40 < abs(mean * number(moments[1]) / number(size) - 1) < mpf(10) ** -30


def test_motions_without_a_period():
    for name in ("separatrix", "rest", "sphere", "spin about B"):
        assert top_of(name).period(30) is None
        assert "polhode" not in top_of(name).frequencies(30)


def test_without_gamma_only_omega_is_known():
    top = euler_top((F(1), F(3, 2), F(2)), (F(3, 10), F(2, 5), F(3, 2)))
    assert top.at([F(4)], 30) == [row[:3] for row in top_of("around C").at([F(4)], 30)]
    for answers in (top.attitude, top.angles):
        with pytest.raises(ValueError, match="without gamma: only its omega is known"):
            answers([F(1)], 30)


def test_precision_in_force_is_left_alone():
    with mpmath.workprec(77):
        top_of("around C").angles([F(3)], 100)
        assert mpmath.prec == 77
