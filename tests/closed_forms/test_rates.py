"""Frequencies are mean rates of angles and of waves; the side on which angles pass a pole."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from mpmath import mpf

import polhode
from shared.closed_forms import all_motions, gap, number
from shared.tools import exactly

F = Fraction
MOTIONS = {str(motion): motion for motion in all_motions()}


@pytest.mark.parametrize(
    "name",
    [
        *(f"euler: about its momentum, {how}" for how in ("around C", "around A", "oblate")),
        *("euler: about its momentum, prolate", "euler/gamma-along-momentum"),
        *("lagrange: nutation", "lagrange: looping", "lagrange: cusped", "lagrange: needle"),
        *("lagrange: near pole 1e-12", "lagrange: near homoclinic 1e-20", "lagrange/backward"),
    ],
)
def test_over_a_period_angles_grow_by_their_mean_rates(name):
    """Of the axis that is circled; about another axis but for whole turns."""
    top = MOTIONS[name].reference
    mean = top.frequencies
    with mpmath.workdps(60):
        period = 2 * mpmath.pi / abs(mean.get("nutation", mean.get("polhode")))
        (psi, _, phi), (after, _, phi_after) = top.angles([1, 1 + exactly(period)], 40)
        off = [after - psi - mean["precession"] * period]
        if "proper rotation" in mean:
            off.append(phi_after - phi - mean["proper rotation"] * period)
        if "/" in name:
            off = [x - 2 * mpmath.pi * mpmath.nint(x / 2 / mpmath.pi) for x in off]
        assert max(map(abs, off)) < mpf("1e-38")


@pytest.mark.parametrize(
    ("name", "rates"),
    [
        ("lagrange: steady slow", {"precession": 1, "proper rotation": F(13, 5)}),
        ("lagrange: sleeping, stable", {"proper rotation": 4}),
        ("lagrange: hanging", {"proper rotation": F(3, 2)}),
        ("lagrange: homoclinic", {"precession": 2, "proper rotation": 3}),  # n/2, r - n/2
        ("euler: separatrix", {"precession": F(9, 10)}),  # G/B
        ("staude: mu = 11", {"precession": 2}),
    ],
)
def test_rates_of_uniform_motions(name, rates):
    frequencies = MOTIONS[name].reference.frequencies
    assert frequencies.keys() == rates.keys()
    with mpmath.workdps(50):
        assert max(abs(frequencies[key] - number(x)) for key, x in rates.items()) < mpf("1e-48")


@pytest.mark.parametrize("off", ["1e-3", "1e-9", "-1e-3", "-1e-9"])
def test_past_a_pole_psi_turns_to_the_side_of_f_minus_c_r(off):
    """Ten nutations: on either side of f = C r psi differs by a turn a nutation, phi likewise."""
    through = MOTIONS["lagrange: upper pole"]
    p, *rest = through.scene.omega
    near = polhode.reference(replace(through.scene, omega=(p + F(off), *rest)))
    mean, side = through.reference.frequencies, 1 if F(off) > 0 else -1
    with mpmath.workdps(60):
        span = 10 * 2 * mpmath.pi / mean["nutation"]
        (psi, _, phi), (after, _, phi_after) = near.angles([0, exactly(span)], 30)
        most = max(mpf("1e-28"), 300 * abs(number(F(off))))
        assert abs(after - psi - mean["precession"] * span - side * 10 * mpmath.pi) < most
        assert abs(phi_after - phi - mean["proper rotation"] * span + side * 10 * mpmath.pi) < most


ORDERS = np.array(
    [
        (j, k)
        for j, k in itertools.product(range(9), range(-8, 9))
        if (j, k) > (0, 0) and j + abs(k) <= 8
    ]
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "column", "growth"),
    [("goryachev-chaplygin/inner-band", 3, 100), ("kovalevskaya/type-eee-inside", 5, 4)],
)
def test_a_column_is_a_sum_of_waves_of_the_two_expected_frequencies(name, column, growth):
    """Up to the order 8.  What is left over grows where one of them is off by 1e-3."""
    motion = MOTIONS[name]
    times = motion.times(*(F(2 * k, 7) for k in range(300)))
    values = np.array([float(row[column]) for row in motion.reference.at(times, 15)])
    rates = np.array([float(x) for x in motion.reference.frequencies.values()])
    rates /= 2 if motion.family == "kovalevskaya" else 1
    assert len(rates) == 2

    def left_over(rates):
        waves = np.exp(1j * np.outer(np.array(times, dtype=float), ORDERS @ rates))
        columns = np.hstack([np.ones((len(times), 1)), waves.real, waves.imag])
        return np.abs(columns @ np.linalg.lstsq(columns, values, rcond=None)[0] - values).max()

    right = left_over(rates)
    assert right < 3e-3
    assert min(left_over(rates * (1.001, 1)), left_over(rates * (1, 1.001))) > growth * right


@pytest.mark.slow
def test_a_motion_of_hess_tends_to_a_periodic_one_at_the_rate_told():
    """What a period of gamma1 along r0 changes in the state decays at that rate."""
    motion = MOTIONS["hess/general"]
    rate, nutation = motion.reference.approach, motion.reference.frequencies["nutation"]
    assert MOTIONS["hess/turned-axes"].reference.approach is None
    with mpmath.workdps(60):
        period = 2 * mpmath.pi / nutation
        times = [exactly(n * period) for n in (20, 21, 30, 31)]
        rows = motion.reference.at(times, 50)
        early, late = gap(rows[0], rows[1]), gap(rows[2], rows[3])
        assert abs(mpmath.log(early / late) / (10 * period) - rate) < mpf("1e-6") * rate


@pytest.mark.slow
def test_separation_variables_of_kovalevskayas_top_pass_to_and_fro_at_the_rates_told():
    """q^2 s^2 + R s/2 + R1/4 = 0: s makes om t/pi passages between its ends in the time t."""
    motion = MOTIONS["kovalevskaya: e-ee+"]
    rates, span = motion.reference.frequencies, 60
    rows = motion.reference.at([F(k, 20) for k in range(20 * span)], 16)
    p, q, r, g1, g2, g3 = np.array([[float(x) for x in row] for row in rows]).T
    H, m = p * p + q * q + r * r / 2 + g1, p * g1 + q * g2 + r * g3 / 2
    b = 1 - (p * p - q * q - g1) ** 2 - (2 * p * q - g2) ** 2
    sg, pi = 2 * p, p * p + q * q
    R = -pi * pi + 2 * H * pi - 2 * m * sg + b
    R1 = -2 * H * pi * pi - b * sg * sg + 4 * m * pi * sg + 2 * H * b - 4 * m * m
    large = -(R / 2 + np.sign(R) * np.sqrt(R * R / 4 - q * q * R1)) / (2 * q * q)
    small = R1 / (4 * q * q * large)
    for name, s in (("s1", np.minimum(large, small)), ("s2", np.maximum(large, small))):
        s = s if name == "s2" else 1 / s  # s1 passes infinity
        turns = np.count_nonzero(np.diff(np.sign(np.diff(s))))
        assert abs(turns / span - float(rates[name]) / np.pi) < 3 / span


PSI = F(3, 7)


@pytest.mark.parametrize(
    ("off", "up", "sense"),
    [("1e-9", 1, 1), ("-1e-9", 1, -1), ("1e-40", 1, -1), ("-1e-40", -1, 1)],
)
@pytest.mark.parametrize("weight", [0, 1])
def test_phi_leaves_a_pole_on_the_side_of_the_start(weight, off, up, sense):
    """Next to pi or -pi: an argument that was known to 2^-25 was taken for pi, a whole turn off."""
    body = polhode.Body.of_moments((1, 1, F(1, 2)), (0, 0, weight), weight)
    scene = polhode.Scene(body, (F(-sense * up), F(off), F(3)), (0, 0, F(up)), psi=PSI)
    ((psi, _, phi),) = polhode.reference(scene).angles([sense * F(1, 1000)], 20)
    side = -1 if sense * up * F(off) > 0 else 1
    assert abs(phi - side * mpmath.pi) < 0.01
    assert abs(psi + up * phi - 3 / 7) < 0.01


@pytest.mark.slow
def test_phi_leaves_a_pole_from_rest_on_the_side_of_the_slope():
    """A body whose centre is off axis 2 by a little, released with the third axis vertical."""
    for off, t in (("1e-9", F(1, 100)), ("-1e-9", F(-1, 100))):
        body = polhode.Body.of_moments((3, 3, 4), (-F(off), 1, 0), 1)
        scene = polhode.Scene(body, (0, 0, 0), (0, 0, 1), psi=PSI)
        ((_, _, phi),) = polhode.reference(scene).angles([t], 20)
        assert abs(phi - (1 if F(off) > 0 else -1) * mpmath.pi) < 0.01
