"""Levels (h, f): curves of permanent rotations, types, and regions, each found another way."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from flint import arb

import polhode
from polhode import Body
from polhode.dynamics.exact_levels import RationalBody, between
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import rational
from shared.tools import tiers

BODIES = {
    "generic": ((2, "3/2", 1), ("3/10", "1/5", "1/2")),
    "one plane": ((2, "3/2", 1), ("3/10", 0, "1/2")),
    "one plane, tilted alike": ((2, 3, 4), (1, 0, 1)),
    "one axis": ((2, "3/2", "6/5"), (0, 1, 0)),
    "kovalevskaya": ((2, 2, 1), (1, 0, 0)),
    "symmetric, off its axis": ((2, 2, 3), (1, 0, "1/2")),
    "lagrange": ((1, 1, "1/2"), (0, 0, 1)),
    "euler": ((3, 2, "3/2"), (0, 0, 0)),
}


def body(name):
    moments, centre = BODIES[name]
    return RationalBody.of(Body.of_moments(moments, centre, 1))


@pytest.mark.parametrize("name", BODIES)
def test_the_points_are_permanent_rotations_of_their_type(name):
    """At gamma and om the field vanishes; the eigenvalues of its derivative say the type.

    dh = om df, by differences of 1e-25 in balls of 320 bits: an error of their square.
    """
    top = body(name)
    for family in top.families:
        for piece in family.pieces:
            with ctx.workprec(320):
                at, step = between(piece.first, piece.last), Fraction(1, 10**25)
                low, point, high = (family.at(arb(rational(x))) for x in (at - step, at, at + step))
                slope = (high.h - low.h) / (high.f - low.f)
                assert abs(float(slope / point.om - 1)) < 1e-44
            gamma = np.array([float(x) for x in point.gamma])
            om = float(point.om)
            assert abs(float(np.linalg.norm(gamma)) - 1) < 1e-15
            assert np.abs(field(top, om * gamma, gamma)).max() < 1e-14 * max(1, om * om)
            inertia = gamma * gamma @ [float(a) for a in top.moments]
            assert float(point.f) == pytest.approx(om * inertia, rel=1e-14)
            energy = om * float(point.f) / 2 + gamma @ [float(t) for t in top.torque]
            assert float(point.h) == pytest.approx(energy, rel=1e-13, abs=1e-14)
            assert type_by_eigenvalues(top, om * gamma, gamma) == piece.type


def field(top, w, g):
    moments, torque = (
        np.array([float(x) for x in numbers]) for numbers in (top.moments, top.torque)
    )
    turning = (np.cross(g, torque) - np.cross(w, moments * w)) / moments
    return np.concatenate([turning, np.cross(g, w)])


def type_by_eigenvalues(top, w, g):
    x, columns = np.concatenate([w, g]), []
    for unit in np.eye(6):  # the field is quadratic: central differences are exact
        ahead, behind = x + unit, x - unit
        columns.append((field(top, ahead[:3], ahead[3:]) - field(top, behind[:3], behind[3:])) / 2)
    squares = sorted(np.linalg.eigvals(np.array(columns).T) ** 2, key=abs)[2:]
    scale = abs(squares[-1])
    if abs(squares[0]) < 1e-6 * scale:
        return "degenerate"
    if max(abs(s.imag) for s in squares) > 1e-6 * scale:
        return "focus-focus"
    positive = sum(s.real > 0 for s in squares)
    return {0: "centre-centre", 2: "centre-saddle", 4: "saddle-saddle"}[positive]


def test_special_points_of_the_generic_body():
    """Cusps and Hamiltonian-Hopf point of moments 2, 3/2, 1, Mg r0 = (.3, .2, .5), found before by
    other means in double precision; the Hopf point near upright rest by this package alone."""
    diagram = polhode.levels("general/asymmetric-chaotic")
    cusps = [tuple(float(x) for x in mark[2:]) for mark in diagram.cusps]
    assert np.allclose(
        cusps,
        [(1.26276262708, 1.624935039, 0.8715768927), (1.67745890471, 1.995702802, 1.084074255)],
        rtol=1e-9,
        atol=0,
    )
    upright, hopf = [mark for mark in diagram.marks if mark.kind == "Hamiltonian-Hopf"]
    hopf = [float(x) for x in hopf[2:]]
    assert np.allclose(hopf, [0.853221873842741, 1.87045561991, 2.26959975272], rtol=3e-12, atol=0)
    assert float(upright.parameter) == pytest.approx(-126.072520401141, rel=1e-14)
    types = [curve.type for curve in diagram.curves]
    assert types == [
        *("saddle-saddle", "focus-focus", "centre-centre", "centre-centre", "centre-saddle"),
        *("centre-saddle", "centre-centre", "centre-centre"),
    ]
    assert [curve.morse for curve in diagram.curves] == [2, 2, 2, 2, 1, 1, 0, 0]


def test_the_lagrange_top_sleeps_from_its_critical_spin_on():
    """L² = 4A Mg z0: A = 1, C = 1/2, f = L = 2, h = L²/2C + 1."""
    diagram = polhode.levels("lagrange/nutation")
    (hopf,) = [mark for mark in diagram.marks if mark.kind == "Hamiltonian-Hopf"]
    assert (float(hopf.f), float(hopf.h)) == (2.0, 5.0)


def test_no_curve_is_a_single_point():
    """At a branch that is a Hamiltonian-Hopf point as well a curve of 259 equal points was told."""
    diagram = polhode.levels("published/hairer-vilmart")
    marks = sorted(float(mark.parameter) for mark in diagram.marks if mark.family == "first")
    assert len(set(marks)) < len(marks)
    for curve in diagram.curves:
        assert curve.first is None or curve.last is None or curve.first < curve.last
        assert np.ptp(curve.points, axis=0).min() > 0


# -- regions, counted on a grid of the sphere ------------------------------------------------------


def test_a_level_has_two_discs_or_three_edges():
    """The levels at which the number of critical points alone would mislead."""
    start = {"omega": [0, 0, 1], "gamma": [0, 0, 1], "weight": 1}
    for name, h, f, parts in (
        ("generic", 1.495, "2.3", (1, 1)),
        ("kovalevskaya", 1.9, "1.9", (3,)),
    ):
        moments, centre = BODIES[name]
        top = polhode.top(moments=moments, centre=centre, **start)
        *_, region = (region for least, region in polhode.levels(top).regions(f) if least < h)
        assert region == parts


def test_on_a_bifurcation_there_is_no_region():
    diagram = polhode.levels("staude/stable")
    assert diagram.here.region is None
    assert diagram.here.remark == "the energy is that of a permanent rotation"
    assert polhode.levels("lagrange/steady-fast").here.region is not None
    assert polhode.levels("lagrange/sleeping-stable").here.region is None


# -- the verb --------------------------------------------------------------------------------------


@pytest.mark.parametrize("f", tiers(["1e3", "1e19"], ["1e16"]))
def test_a_symmetric_body_has_three_critical_energies_at_any_f(f):
    """f^2 - 1 and f^2 + 1 at the poles, and W(u) = f^2/(2 - u^2) + u where its slope is zero."""
    with mpmath.workdps(200):
        big = mpmath.mpf(f) ** 2
        u = mpmath.findroot(lambda u: 2 * u * big / (2 - u * u) ** 2 + 1, -2 / big)
        right = [big / (2 - u * u) + u, big - 1, big + 1]
    diagram = polhode.levels("lagrange/nutation").regions(f)
    assert [energy for energy, _ in diagram] == [float(x) for x in right]
    assert [region for _, region in diagram] == [(2,), (1,), (0,)]
