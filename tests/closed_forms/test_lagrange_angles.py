"""Lagrange's top: Euler angles, periods, frequencies, and figures that others published."""

import itertools
from fractions import Fraction

import pytest

from polhode.closed_forms.lagrange.top import LagrangeTop
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import series
from shared.closed_form_checks import (
    check_attitude,
    distance,
    in_scene,
    number,
    rational_axes,
    rotation,
    unwound,
)
from shared.lagrange_motions import (
    MOTIONS,
    PSI,
    UP,
    motion,
    small,
    tilted,
    top_of,
)

F = Fraction
#: Motions that reach a pole: there psi and phi jump, and samples cannot say which way.
THROUGH = ("through", "planar", "homoclinic")
REGULAR = [n for n in MOTIONS if not MOTIONS[n][4].startswith((*THROUGH, "rest", "sleep", "hang"))]
#: Those of them whose axis of symmetry is the scene's third.
CLOSED = [n for n in REGULAR if n not in ("first axis", "second axis", "sphere")]
#: Near-poles are passed in less than a sample.
SMOOTH = [n for n in REGULAR if "pole" not in n and n not in ("fast", "almost hanging 1e-60")]


@pytest.mark.sample(10)
@pytest.mark.parametrize("name", MOTIONS)
def test_angles_are_those_of_the_attitude(name):
    top = top_of(name)
    times = [F(0), F(5, 3), F(-9)]
    states, attitudes, angles = (f(times, 50) for f in (top.at, top.attitude, top.angles))
    with mpmath.workdps(60):
        for row in zip(states, attitudes, angles, strict=True):
            check_attitude(*row)
        assert attitudes[0][0] >= 0
        gamma = motion(name)[3]
        if gamma[0] or gamma[1]:
            assert abs(angles[0][0] - mpf(7) / 10) < mpf(10) ** -50
            phi = mpmath.atan2(number(gamma[0]), number(gamma[1]))
            assert abs(angles[0][2] - phi) < mpf(10) ** -50


@pytest.mark.sample(6, slow=8)
@pytest.mark.parametrize("name", MOTIONS)
def test_quaternion_never_changes_sign(name):
    """Samples so close that the quaternion moves by less than 0.2."""
    top, count = top_of(name), 300
    step = F(1, 20) / max(1, *(abs(x) for x in motion(name)[2]))
    rows = top.attitude([step * (k - count // 2) for k in range(count)], 15)
    assert max(distance([a], [b]) for a, b in itertools.pairwise(rows)) < 0.2
    assert rows[count // 2][0] >= 0


@pytest.mark.sample(6)
@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("end", [F(11), F(-11)])
def test_psi_and_phi_count_their_turns(name, end):
    top = top_of(name)
    (psi, _, phi), (psi0, _, phi0) = top.angles([end, F(0)], 15)
    more_psi, more_phi = unwound(top, F(0), end, 450)
    assert abs(psi - psi0 - more_psi) < 1e-11
    assert abs(phi - phi0 - more_phi) < 1e-11


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["nutation", "looping", "cusped", "first axis", "sphere"])
def test_psi_is_the_integral_of_its_rate(name):
    moments, torque, omega, gamma = motion(name)
    (row,) = series.integrate(moments, omega, gamma, [F(5)], 36, torque=torque, psi=PSI)
    assert mpf(10) ** -45 < abs(row[-1] - top_of(name).angles([F(5)], 30)[0][0]) < mpf(10) ** -30


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", CLOSED)
def test_about_the_axis_of_symmetry_psi_and_phi_are_closed(name):
    times = [F(10**12), F(-(10**12))]
    low, high = top_of(name).angles(times, 30), top_of(name).angles(times, 50)
    assert distance(low, high) < mpf(10) ** -30


def turned_by(name, quaternion):
    """The same motion where the top's axes are turned in the scene's."""
    moments, torque, omega, gamma = motion(name)
    axes = rational_axes(quaternion)
    omega, gamma = in_scene(omega, axes), in_scene(gamma, axes)
    return LagrangeTop(moments, torque, omega, gamma, PSI, axes), gamma


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", ["nutation", "looping", "cusped", "steady slow"])
@pytest.mark.parametrize("quaternion", [(12, 1, 0, 0), (1, 0, -12, 0)])
def test_about_an_axis_near_that_of_symmetry_too(name, quaternion):
    """There the turns are counted, and not to any time."""
    top, _ = turned_by(name, quaternion)
    more_psi, more_phi = unwound(top, F(-5), F(7), 450)
    (psi, _, phi), (psi0, _, phi0) = top.angles([F(7), F(-5)], 15)
    assert abs(psi - psi0 - more_psi) < 1e-12
    assert abs(phi - phi0 - more_phi) < 1e-12
    with pytest.raises(ValueError, match="ask for the attitude"):
        top.angles([F(10**12)], 15)


@pytest.mark.slow
def test_an_axis_that_is_upright_only_where_theta_turns():
    """The two terms are of one size there."""
    top, gamma = turned_by("cusped", (3, 0, 1, 0))
    assert gamma == UP
    assert top.nutation(15) > 2
    more_psi, more_phi = unwound(top, small(3), F(2), 450)
    for digits in range(15, 40, 3):
        (psi, _, phi), (psi0, _, phi0) = top.angles([F(2), small(3)], digits)
        assert abs(psi - psi0 - more_psi) < 1e-12
        assert abs(phi - phi0 - more_phi) < 1e-12


@pytest.mark.slow
def test_from_a_pole_towards_the_cut_one_branch_at_any_time_and_precision():
    """(psi - phi)/2 starts pi beyond (psi + phi)/2, counted as +pi whatever the digits asked."""
    top, _ = turned_by("cusped", (3, 0, 1, 0))
    for digits in (5, 15, 40, 120):
        for time in (small(30), small(12), small(9), small(3)):
            ((psi, _, phi),) = top.angles([time], digits)
            assert abs(phi + mpmath.pi) < 0.01
            assert abs(psi - mpmath.pi - number(PSI)) < 0.01


@pytest.mark.parametrize("off", [small(3), small(12), small(40), -small(3), -small(12), -small(40)])
def test_past_a_pole_psi_turns_by_half_a_turn_to_the_side_of_f_minus_c_r(off):
    """Ten nutations: on either side of f = C r psi differs by a turn a nutation, phi likewise."""
    moments, torque, omega, gamma = motion("upper pole")
    omega = (omega[0] + off, *omega[1:])
    through = top_of("upper pole")
    near = LagrangeTop(moments, torque, omega, gamma, PSI)
    with mpmath.workdps(40):
        period = through.nutation(30)
        end = F(exact.binary(int((10 * period).man), int((10 * period).exp)))
        (psi, _, phi), (start, _, phi0) = near.angles([end, F(0)], 30)
        mean = through.frequencies(30)
        side = 1 if off > 0 else -1
        expected = mean["precession"] * 10 * period + side * 10 * mpmath.pi
        other = mean["proper rotation"] * 10 * period - side * 10 * mpmath.pi
        tolerance = max(mpf(10) ** -28, 300 * number(abs(off)))
        assert abs(psi - start - expected) < tolerance
        assert abs(phi - phi0 - other) < tolerance
        assert off in (small(40), -small(40)) or abs(psi - start - expected) > number(abs(off)) / 99


@pytest.mark.parametrize("third", [1, -1])
def test_from_a_pole(third):
    """psi and phi are None there; afterwards they start from their limits."""
    name = "from the upper pole" if third > 0 else "from the lower pole"
    top, tiny = top_of(name, F(0)), small(30)
    at_pole, after, later, before = top.angles([F(0), tiny, F(1), -tiny], 20)
    assert at_pole[0] is None
    assert at_pole[2] is None
    # gamma' = gamma x w: (g1, g2) starts along third (-q, p).
    assert abs(after[2] - mpmath.atan2(-third * 1, third * 2)) < 1e-15
    assert abs(before[2] - mpmath.atan2(third * 1, -third * 2)) < 1e-15
    assert abs(after[0] + third * after[2]) < 1e-15  # psi +- phi is continuous
    assert abs(before[0] + third * before[2]) < 1e-15
    more_psi, more_phi = unwound(top, tiny, F(1), 450)
    assert abs(later[0] - after[0] - more_psi) < 1e-12
    assert abs(later[2] - after[2] - more_phi) < 1e-12


def test_always_at_a_pole():
    for name, theta in (("sleeping, stable", 0), ("hanging", mpmath.pi)):
        assert all(
            row[0] is None and abs(row[1] - theta) < 1e-15 and row[2] is None
            for row in top_of(name).angles([F(0), F(5)], 20)
        )


def exact_period(top):
    period = top.nutation(70)
    return exact.binary(int(period.man), int(period.exp)), period


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize(
    "name", ["nutation", "looping", "cusped", "spherical pendulum", "near cusp 1e-15", "needle"]
)
def test_over_a_period_psi_grows_by_its_mean_rate(name):
    """One nutation by the independent integration gives the mean of psi' to 40 digits."""
    moments, torque, omega, gamma = motion(name)
    top = top_of(name)
    with mpmath.workdps(60):
        end, period = exact_period(top)
        (row,) = series.integrate(moments, omega, gamma, [end], 45, torque=torque, psi=F(0))
        mean = top.frequencies(50)
        assert abs(mean["nutation"] - 2 * mpmath.pi / period) < mpf(10) ** -49
        assert abs(row[5] - number(gamma[2])) < mpf(10) ** -40
        assert mpf(10) ** -60 < abs(row[-1] / period - mean["precession"]) < mpf(10) ** -40
        phi = mpmath.atan2(row[3], row[4]) - mpmath.atan2(number(gamma[0]), number(gamma[1]))
        turns = (mean["proper rotation"] * period - phi) / (2 * mpmath.pi)
        assert abs(turns - mpmath.nint(turns)) < mpf(10) ** -40


@pytest.mark.parametrize("name", ["nutation", "cusped", "near pole 1e-12", "near homoclinic 1e-20"])
def test_frequencies_are_long_time_averages(name):
    top, end = top_of(name), F(10**15)
    psi, _, phi = top.angles([end], 30)[0]
    mean = top.frequencies(30)
    assert abs(psi / 10**15 - mean["precession"]) < 1e-13
    assert abs(phi / 10**15 - mean["proper rotation"]) < 1e-13


def test_jumps_at_a_pole_are_no_precession():
    """psi' = n/(1 + u) is regular there: its mean by quadrature over one nutation."""
    moments, torque, omega, gamma = motion("upper pole")
    top = top_of("upper pole")
    with mpmath.workdps(50):
        end, period = exact_period(top)
        # Across the pole the quadrature of psi' passes a regular 0/0, which no step hits.
        (row,) = series.integrate(moments, omega, gamma, [end], 25, torque=torque, psi=F(0))
        assert abs(row[-1] / period - top.frequencies(30)["precession"]) < mpf(10) ** -15


def test_motions_without_a_period():
    for name in MOTIONS:
        regime = MOTIONS[name][4]
        still = regime.startswith(("rest", "sleep", "hang", "steady", "homo")) or regime.endswith(
            ("separatrix", "conical")
        )
        assert (top_of(name).nutation(20) is None) is still
        assert ("nutation" not in top_of(name).frequencies(20)) is still


def test_frequencies_of_uniform_motions():
    assert top_of("sleeping, stable").frequencies(20) == {"proper rotation": 4}
    assert top_of("hanging").frequencies(20)["proper rotation"] == 1.5
    slow = top_of("steady slow").frequencies(20)
    with mpmath.workdps(30):
        assert abs(slow["precession"] - 1) < mpf(10) ** -20
        assert mpf(10) ** -30 < abs(slow["proper rotation"] - number(F(13, 5))) < mpf(10) ** -20
    # n/2 and r - n/2, n = C r/A.
    limit = top_of("homoclinic").frequencies(20)
    assert abs(limit["precession"] - 2) < mpf(10) ** -20
    assert abs(limit["proper rotation"] - 3) < mpf(10) ** -20


@pytest.mark.slow
def test_bruels_cardona_arnold_top():
    """Bruels, Cardona, Arnold, Mech. Mach. Theory 48 (2012) 121: the figures recomputed.

    It comes within 1 + cos = 2.6e-13 of a pole of its axis of symmetry, the body's y.
    """
    moments = (F("15.234375"), F("0.46875"), F("15.234375"))
    torque = (F(0), F(15) * F("9.81"), F(0))
    top = LagrangeTop(moments, torque, (F(0), F(150), F("-4.61538")), (F(0), F(0), F(1)))
    times = [F(1, 5), F(1), F(2)]
    published = [
        (".60555056137711977", "-.401042318205080842", "-.523983027430003185"),
        (".173343964098386043", "-.359911407929431217", "-.748490791133581309"),
        ("-.15041682274564176", "-1.72416559163689565", "-.673022269560444096"),
    ]
    attitudes = top.attitude(times, 30)
    with mpmath.workdps(40):
        for attitude, row in zip(attitudes, published, strict=True):
            centre = rotation(attitude) * mpmath.matrix([0, 1, 0]) - mpmath.matrix([0, 1, 0])
            for x, printed in zip(centre, row, strict=True):
                assert abs(x - mpf(printed)) < mpf(10) ** -17
        printed = (
            ".732943980679663718",
            "-.278285719337612679",
            ".531824611334162618",
            "-.320176142736249281",
        )
        for x, y in zip(attitudes[1], printed, strict=True):
            assert abs(x - mpf(y)) < mpf(10) ** -18
        assert abs(top.nutation(30) - mpf(".74520694761676905573")) < mpf(10) ** -20
    (psi0, _, phi0), (psi, _, phi) = top.angles([F(1, 10**4), F(1)], 15)
    more_psi, more_phi = unwound(top, F(1, 10**4), F(1), 4000)
    assert abs(psi - psi0 - more_psi) < 1e-10
    assert abs(phi - phi0 - more_phi) < 1e-10


def test_simo_wong_top():
    """Simo and Wong, Int. J. Numer. Methods Eng. 31 (1991) 19: the figures recomputed."""
    tilt = F(5, 100)
    gamma = (F(0), exact.sin(tilt), exact.cos(tilt))
    top = LagrangeTop((F(5), F(5), F(1)), (F(0), F(0), F(20)), (F(0), F(0), F(50)), gamma)
    assert top.regime == "cusped"
    with mpmath.workdps(40):
        apex = rotation(top.attitude([F(1)], 30)[0])[:, 2]
        printed = (".0215411049742639709", "-.0500103354833718594", ".998516372996120849")
        for x, y in zip(apex, printed, strict=True):
            assert abs(x - mpf(y)) < mpf(10) ** -18
        assert abs(top.nutation(30) - mpf(".6854584972896153183")) < mpf(10) ** -19


@pytest.mark.parametrize(
    ("root", "regime", "rpm"),
    [
        (-1, "steady precession, slow", "51.9301238699799"),
        (1, "steady precession, fast", "1148.0699"),
    ],
)
def test_curtis_steady_precession(root, regime, rpm):
    """Curtis, Orbital Mechanics for Engineering Students: phi' = 1000 rpm, theta = 60 degrees.

    (A - C) cos th W^2 - C phi' W + Mg l = 0; the data hold pi and roots, equal by the rule.
    """
    A, C, torque = F(12, 10**4), F(45, 10**5), F(1, 2) * F(5, 100) * F("9.807")
    own = 2 * exact.pi() * 1000 / 60
    c, s = F(1, 2), exact.sqrt(F(3, 4))
    half = C * own / 2
    W = (half + root * exact.sqrt(half * half - (A - C) * c * torque)) / ((A - C) * c)
    top = LagrangeTop((A, A, C), (F(0), F(0), torque), (W * s, F(0), own + W * c), (s, F(0), c))
    assert top.regime == regime
    with mpmath.workdps(40):
        found = top.frequencies(30)["precession"] * 30 / mpmath.pi
        assert abs(found / mpf(rpm) - 1) < mpf(10) ** -(len(rpm) - 2)
        assert abs(top.frequencies(30)["proper rotation"] * 30 / mpmath.pi - 1000) < mpf(10) ** -26


@pytest.mark.slow
def test_the_same_start_near_and_at_the_lower_pole():
    """pi - theta = 2e-30 at the start: psi and phi keep their digits and their turns."""
    top = LagrangeTop(
        (F(1), F(1), F(4, 5)),
        (F(0), F(0), F(1, 2)),
        (F(2, 5), F(11, 10), F(1)),
        tilted(small(30), -1),
        PSI,
    )
    times = [F(0), F(1, 10**31), F(1, 10**28), F(3), F(100)]
    low, high = top.angles(times, 30), top.angles(times, 50)
    assert distance(low, high) < mpf(10) ** -30
    with mpmath.workdps(40):
        assert abs(low[0][0] - mpf("0.7")) < mpf(10) ** -30
    more_psi, more_phi = unwound(top, F(0), F(1, 10**28), 4000)
    assert abs(low[2][0] - low[0][0] - more_psi) < 1e-12
    assert abs(low[2][2] - low[0][2] - more_phi) < 1e-12


def test_a_tiny_scalar_part_decides_the_sign_at_any_precision():
    """q0(0) = 1e-30 or so: asked for 15 digits or 90, the same of the two quaternions."""
    moments, torque, omega = (F(1), F(1), F(1, 2)), (F(0), F(0), F(1)), (F(1, 5), F(0), F(1))
    for tilt in (tilted(small(30), -1), tilted(-small(30), -1)):
        low, high = (
            LagrangeTop(moments, torque, omega, tilt).attitude([F(2)], digits)
            for digits in (15, 90)
        )
        assert distance(low, high) < mpf(10) ** -15


def test_planar_pendulum_keeps_its_plane():
    """psi only jumps by pi; theta goes to and fro."""
    top = top_of("rotating")
    for psi, theta, _ in top.angles([F(k, 3) for k in range(1, 20)], 20):
        turns = (psi - top.angles([F(1, 3)], 20)[0][0]) / mpmath.pi
        assert abs(turns - mpmath.nint(turns)) < 1e-15
        assert 0 <= theta <= mpmath.pi
