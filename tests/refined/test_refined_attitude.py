"""Attitude and angles of refined runs: closed forms, heyoka's steps, windings near poles."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode import Body, Scene
from polhode.refined import refinement
from shared.motions import asymmetric
from shared.tools import exactly

OUTPUTS = ("angles", "attitude", "hodographs")


def refined(scene, at, number="quad"):
    run = polhode.integrate(replace(scene, outputs=OUTPUTS), number, at=at, method="refined")
    assert run.method == "refined"
    return run


def apart(rows, others):
    """The largest difference of two tables."""
    return max(
        abs(float(exactly(a) - exactly(b)))
        for row, second in zip(rows, others, strict=True)
        for a, b in zip(row, second, strict=True)
    )


@pytest.mark.parametrize(
    ("name", "number", "at", "worst"),
    [  # psi is rounded at 113 bits, to 2e-33 beyond 16
        pytest.param("kovalevskaya/generic", "quad", ["1/3", 20], 4e-33, marks=pytest.mark.slow),
        ("euler/backward", "quad", [-1, -50], 4e-33),
        ("euler/turned-axes", "quad", [0, 1, 50], 4e-33),
        ("lagrange/nutation", "quad", [1, 5, 10], 4e-33),
        ("lagrange/spherical-pendulum", "quad", [1, 40], 4e-33),
        ("euler/dzhanibekov", "quad", [1, 30], 4e-31),
        ("lagrange/nutation", "mp", [2, 7], 1e-49),
    ],
)
def test_closed_forms(name, number, at, worst):
    run = refined(polhode.load(name), at, number)
    true = polhode.reference(run.scene)
    assert 0 < apart(run.angles, true.angles(run.times, 62)) < worst
    assert 0 < apart(run.attitude, true.attitude(run.times, 62)) < worst / 4
    assert 0 < apart(run.hodographs.space, true.hodographs(run.times, 62).space) < worst


def test_turns_are_counted_over_several_runs_in_double(monkeypatch):
    monkeypatch.setattr(refinement, "STEPS", 40)
    run = refined(polhode.load("euler/turned-axes"), [10, 30, 60])
    assert 0 < apart(run.angles, polhode.reference(run.scene).angles(run.times, 45)) < 1e-32
    assert abs(run.angles[-1][0]) > 10


@pytest.mark.parametrize("end", [15, -30])
def test_heyokas_own_run_in_quad(end):
    scene = replace(
        polhode.load("general/asymmetric-chaotic") if end > 0 else asymmetric(), outputs=OUTPUTS
    )
    ours, steps = (
        polhode.integrate(scene, "quad", at=[end / 5, end], method=method)
        for method in ("refined", "taylor")
    )
    assert ours.method == "refined"
    assert 0 < apart(ours.angles, steps.angles) < 2e-30
    assert 0 < apart(ours.attitude, steps.attitude) < 1e-30


def sphere(near):
    """A free sphere that turns about its first axis; gamma passes the pole at such a distance."""
    body = Body.of_moments([1, 1, 1])
    length = (1 + near**2) / (1 - near**2)  # rational: gamma1 = 2 near/(1 + near²)
    gamma1, rest = 2 * near / (1 + near**2), 1 / length
    gamma = gamma1, Fraction(3, 5) * rest, Fraction(4, 5) * rest
    return Scene(body, (1, 0, 0), gamma, outputs=OUTPUTS)


@pytest.mark.parametrize("near", [Fraction(1, 10), Fraction(1, 10**4), -Fraction(1, 10**9)])
def test_windings_past_both_poles(near):
    run = refined(sphere(near), [5, 33])
    true = polhode.reference(run.scene).angles(run.times, 60)
    assert apart(run.angles, true) < 1e-32 / abs(near)
    assert abs(run.angles[1][0]) > 10  # psi turns by pi at each pole


def test_a_motion_through_a_pole_takes_heyokas_steps():
    scene = sphere(Fraction(0))
    run, attitude = (
        polhode.integrate(replace(scene, outputs=outputs), "quad", at=[5], method="refined")
        for outputs in (OUTPUTS, ("attitude",))
    )
    assert (run.method, attitude.method) == ("taylor", "refined")
    assert "pole" in run.provenance["not refined"]
