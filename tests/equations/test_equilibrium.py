"""Relative equilibria stand still, whatever their stability, to the last digit."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import mpmath
import pytest

import polhode
from polhode import Event, Outcome
from polhode.cli import main
from shared.closed_forms import number as number_at
from shared.tools import DOUBLE, EXTENDED, QUAD, exactly, mp, tiers

NUMBERS = [DOUBLE, EXTENDED, QUAD, mp(50)]
F = Fraction
CENTRE = (F(2, 7), F(3, 7), F(6, 7))  # of length 1


def body(*moments: int) -> polhode.Body:
    return polhode.Body.of_moments(moments or (3, 4, 5), CENTRE, 1)


def staude() -> polhode.Scene:
    """A permanent rotation of angular velocity sqrt(3) about a unit vector e.

    gamma_i = Mg r0_i/(om² A_i - mu) (Staude) with mu = 0: r0_i = om² A_i e_i.
    """
    square, e = F(3), (F(1, 3), F(2, 3), F(2, 3))
    moments = (1, 2, 2)
    centre = [square * a * x for a, x in zip(moments, e, strict=True)]
    body = {"moments": moments, "centre": centre, "weight": 1}
    return polhode.top(**body, omega=[f"sqrt({square})*{x}" for x in e], gamma=e, name="staude")


RESTS = {
    "upright": polhode.Scene(body(), (0, 0, 0), CENTRE),
    "hanging": polhode.Scene(body(), (0, 0, 0), tuple(-x for x in CENTRE)),
    "staude": staude(),
    "free, along its axis": polhode.Scene(
        polhode.Body.of_moments((1, 2, 3)), (0, F(11, 10), 0), (0, 1, 0)
    ),
    "free, without gamma": polhode.Scene(polhode.Body.of_moments((1, 2, 3)), (0, F(11, 10), 0)),
    "a sphere": polhode.Scene(polhode.Body.of_moments((1, 1, 1)), CENTRE, CENTRE),
    "free, at rest": polhode.Scene(polhode.Body.of_moments((1, 2, 3)), (0, 0, 0), CENTRE),
    "sleeping": replace(polhode.load("lagrange/sleeping-unstable"), outputs=()),
    "turned": replace(polhode.load("euler/turned-permanent"), gamma=None, outputs=()),
}


@pytest.mark.parametrize("number", NUMBERS, ids=lambda n: n.name)
@pytest.mark.parametrize("name", RESTS)
def test_a_relative_equilibrium_stands_still(name, number):
    scene = RESTS[name].at((F(0), F(1), F(1000), F(10) ** 9))
    run = polhode.integrate(scene, number)
    assert run.outcome is Outcome.REACHED_END
    assert run.reached == 10**9
    assert run.steps == 0
    assert run.projection is None
    assert all(list(row) == list(run.states[0]) for row in run.states)
    for x, exact in zip(run.states[0], scene.start, strict=True):
        error = abs(exactly(x) - mp(100).rounded(exact))
        assert error <= number.eps * 2


@pytest.mark.parametrize("name", ["upright", "staude", "sleeping", "free, along its axis"])
def test_a_hair_off_is_a_motion(name):
    scene = RESTS[name]
    p, q, r = scene.omega
    off = replace(scene, omega=(p + F(1, 10**30), q, r + F(1, 10**30)))
    assert polhode.integrate(off, at=[1]).steps > 0


def test_a_free_body_about_its_axis_turns_a_vertical_that_is_across():
    """w stands still, and gamma does not."""
    scene = replace(RESTS["free, along its axis"], gamma=(F(3, 5), F(4, 5), 0))
    run = polhode.integrate(scene, at=[10])
    assert (run.omega[0] == [0, 1.1, 0]).all()
    assert polhode.compare(run).worst > 14


@pytest.mark.parametrize(
    ("number", "end"),
    tiers([(DOUBLE, 500), (QUAD, 500), (EXTENDED, -500)], [(EXTENDED, 500), (DOUBLE, -500)]),
    ids=lambda x: getattr(x, "name", None),
)
def test_a_permanent_rotation_turns_uniformly(number, end):
    """psi grows like |w| t; the quaternion keeps its length, and says the same turns."""
    scene = replace(staude(), psi=F(1, 3), outputs=("angles", "attitude"))
    run = polhode.integrate(scene, number, at=[0, end])
    with mpmath.workprec(number.bits + 64):
        psi, theta, phi = (number_at(exactly(x)) for x in run.angles[1])
        near = 1000 * mpmath.mpf(2) ** -number.bits
        assert abs(psi - (mpmath.mpf(1) / 3 + mpmath.sqrt(3) * end)) <= near
        assert [float(theta), float(phi)] == [float(x) for x in run.angles[0][1:]]
        q0, q1, q2, q3 = (number_at(exactly(x)) for x in run.attitude[1])
        # psi + phi = 2 arg(q0 + i q3), psi - phi = 2 arg(q1 + i q2)
        pairs = (psi + phi, mpmath.atan2(q3, q0)), (psi - phi, mpmath.atan2(q2, q1))
        turns = [(whole / 2 - half) / mpmath.pi for whole, half in pairs]
        assert all(abs(x - mpmath.nint(x)) <= near for x in turns)


@pytest.mark.parametrize("number", tiers(NUMBERS[:2], NUMBERS[2:]), ids=lambda n: n.name)
def test_events_of_the_time_still_happen(number):
    events = (
        Event("level", "gamma1 - 1/2"),
        Event("alarm", "t - 3"),
        Event("wave", "sin(t) * gamma1"),
        Event("end", "t**2 - 49", stop=True),
    )
    scene = RESTS["upright"].at(tuple(F(k) for k in range(11)))
    run = polhode.integrate(replace(scene, events=events), number)
    assert run.outcome is Outcome.STOPPED_AT_EVENT
    assert [len(e.times) for e in run.events] == [0, 1, 2, 1]
    assert run.events[1].times == (3,)
    assert abs(run.reached - 7) <= 8 * number.eps
    assert list(run.times)[:7] == list(range(7))
    assert len(run.times) <= 8
    assert list(run.events[1].states[0]) == list(run.states[0])


def test_show_names_it(capsys):
    for name, kind in (("pendulum/upright", "rest"), ("lagrange/sleeping-stable", "permanent")):
        assert main(["show", name, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["motion"].startswith(kind)
    assert main(["show", "lagrange/nutation", "--json"]) == 0
    assert "motion" not in json.loads(capsys.readouterr().out)
