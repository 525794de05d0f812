"""Attitude and angles of refined runs: closed forms, other intervals, windings near poles."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging.adaptive_precision import integrate
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.refined.attitude import Following
from polhode.refined.refinement import QUAD, refine
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared.motions import asymmetric

OUTPUTS = ("angles", "attitude", "hodographs")


def refined(scene, at, number="quad", outputs=OUTPUTS):
    run = integrate(replace(scene, outputs=outputs), number, at=at, method="refined")
    assert run.method == "refined"
    return run


def apart(rows, others):
    """The largest difference of two tables."""
    return max(
        abs(float(exactly(a) - exactly(b)))
        for row, other in zip(rows, others, strict=True)
        for a, b in zip(row, other, strict=True)
    )


CLOSED = [  # case, times, worst error: psi is rounded at 113 bits, to 2e-33 beyond 16
    pytest.param("kovalevskaya/generic", ["1/3", 5, 20], 4e-33, marks=pytest.mark.slow),
    ("euler/backward", [-1, -50], 4e-33),
    ("euler/turned-axes", [0, 1, 50], 4e-33),
    ("lagrange/nutation", [1, 5, 10], 4e-33),
    ("lagrange/spherical-pendulum", [1, 40], 4e-33),
    ("euler/dzhanibekov", [1, 30], 4e-31),
]


@pytest.mark.parametrize(("name", "at", "worst"), CLOSED)
def test_closed_forms(name, at, worst):
    run = refined(polhode.load(name), at)
    true = polhode.reference(run.scene)
    assert 0 < apart(run.angles, true.angles(run.times, 45)) < worst
    assert 0 < apart(run.attitude, true.attitude(run.times, 45)) < worst / 4
    assert 0 < apart(run.hodographs.space, true.hodographs(run.times, 45).space) < worst


def test_closed_forms_to_fifty_digits():
    run = refined(polhode.load("lagrange/nutation"), [2, 7], number_types.mp(50))
    true = polhode.reference(run.scene)
    assert 0 < apart(run.angles, true.angles(run.times, 62)) < 1e-49
    assert 0 < apart(run.attitude, true.attitude(run.times, 62)) < 1e-50


def test_heyokas_own_run_in_quad():
    scene = replace(polhode.load("general/asymmetric-chaotic"), outputs=OUTPUTS)
    ours, steps = (
        integrate(scene, "quad", at=[3, 15], method=method) for method in ("refined", "taylor")
    )
    assert ours.method == "refined"
    assert 0 < apart(ours.angles, steps.angles) < 1e-30
    assert 0 < apart(ours.attitude, steps.attitude) < 1e-30


def attitudes(scene, end, m=6):
    following = Following(scene, QUAD.limbs.finest, angles=True)
    return refine(scene, [Fraction(end)], QUAD, m, following=following).attitudes[0]


def test_another_grouping_of_steps_agrees_and_the_length_is_one():
    for end in (200, -30):
        six, five = attitudes(asymmetric(), end), attitudes(asymmetric(), end, 5)
        pairs = zip(six.quaternion, five.quaternion, strict=True)
        assert 0 < max(abs(a - b) for a, b in pairs) < 1e-33
        assert np.allclose(six.windings, five.windings, atol=1e-9)
        assert abs(sum(x * x for x in six.quaternion) - 1) < 1e-34


def test_the_momentum_of_a_free_body_stays_in_space():
    scene = polhode.load("euler/flat")
    run = refined(scene, [1, 10, 90], outputs=("attitude",))
    from polhode.equations.hodographs import in_space

    momentum = [scene.body.momentum([exactly(x) for x in row[:3]]) for row in run.states]
    space = in_space(run.attitude, momentum, run.number)
    start = in_space(
        [polhode.reference(scene).attitude([0], 40)[0]],
        [scene.body.momentum(scene.omega)],
        run.number,
    )
    assert apart(space, start * 3) < 2e-33


def sphere(near):
    """A free sphere that turns about its first axis; gamma passes the pole at such a distance."""
    across = Fraction(3, 5)
    body = Body.of_moments([1, 1, 1])
    length = (1 + near**2) / (1 - near**2)  # rational: gamma1 = 2 near/(1 + near²)
    gamma1, rest = 2 * near / (1 + near**2), 1 / length
    return Scene(body, (1, 0, 0), (gamma1, across * rest, Fraction(4, 5) * rest), outputs=OUTPUTS)


@pytest.mark.parametrize("near", [Fraction(1, 10), Fraction(1, 10**4), -Fraction(1, 10**9)])
def test_windings_past_both_poles(near):
    scene = sphere(near)
    run = refined(scene, [5, 33])
    true = polhode.reference(scene).angles(run.times, 60)
    assert apart(run.angles, true) < 1e-32 / abs(near)
    assert abs(run.angles[1][0]) > 10  # psi turns by pi at each pole


def test_a_motion_through_a_pole_takes_heyokas_steps():
    run = integrate(sphere(Fraction(0)), "quad", at=[5], method="refined")
    assert run.method == "taylor"
    assert "pole" in run.provenance["not refined"]
    attitude = integrate(
        replace(sphere(Fraction(0)), outputs=("attitude",)), "quad", at=[5], method="refined"
    )
    assert attitude.method == "refined"


@pytest.mark.slow
def test_events_beside_the_outputs_change_nothing():
    scene = polhode.load("lagrange/nutation")
    with_events = replace(scene, events=(polhode.Event("nutation"),))
    a, b = (refined(s, [1, 9]) for s in (scene, replace(with_events, tags=())))
    assert apart(a.attitude, b.attitude) < 1e-33
    assert apart(a.angles, b.angles) < 1e-33
    assert len(b.events[0].times) > 3
