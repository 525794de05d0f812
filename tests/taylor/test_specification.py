"""Variables that the equations keep: parameters of the rates, told whenever the state is."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.numbers.exact import exact
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD
from polhode.runs.problem.problem import problem
from polhode.scenes.event import Event
from polhode.taylor.backend.integrator_pool import Pool
from polhode.taylor.batches import batch_integrator, jobs
from polhode.taylor.integrator import compiled, stepping
from polhode.taylor.integrator.specification import built
from shared.policies import change_policy

#: Case, what the equations keep, and the products of two variables that are left.
TOPS = [
    ("lagrange/nutation", (2,), 4),
    ("lagrange/first-axis", (0,), 4),
    ("euler/oblate", (2,), 4),
    ("euler/sphere", (0, 1, 2), 0),
    ("euler/largest-axis", (), 9),
    ("kovalevskaya/generic", (), 8),
]


def plain(name: str, *times: int) -> polhode.Scene:
    return replace(polhode.load(name), times=times, outputs=(), events=(), published=())


def products(ta) -> int:
    """How many products of two variables, or of what was made of them, a step multiplies out."""
    return sum(bool(re.fullmatch(r"\(u_\d+ \* u_\d+\)", str(f))) for f, _ in ta.decomposition)


@pytest.mark.sample(6)
@pytest.mark.parametrize(("name", "kept", "left"), TOPS)
@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, QUAD], ids=lambda x: x.name)
def test_what_the_equations_keep_is_multiplied_as_a_number(name, kept, left, number):
    made = built(problem(plain(name, 1), number).prepared().blueprint, None, None)
    assert made.kept == kept
    assert products(made.heyoka) == left


@pytest.fixture
def told(monkeypatch) -> list:
    """At each advance, what the rates take the kept variables for, and what these are."""
    monkeypatch.setattr(compiled, "POOL", Pool())
    seen: list = []
    onwards = stepping.Integrator._onwards

    def spied(self, *arguments):
        told = [self.heyoka.pars[parameter] for parameter, _ in self.compiled.kept]
        seen.append((told, [self.state[column] for _, column in self.compiled.kept]))
        return onwards(self, *arguments)

    monkeypatch.setattr(stepping.Integrator, "_onwards", spied)
    return seen


def test_the_rates_go_with_every_change_of_the_state(told, monkeypatch):
    """A correction, another start of an idle integrator, and a chunk taken again."""
    change_policy(monkeypatch, chunk=30)
    scene = plain("lagrange/nutation", 100)
    run = polhode.integrate(scene, project=7)
    other = replace(scene, omega=(*scene.omega[:2], exact("4.3")))
    assert other.time_unit == scene.time_unit
    polhode.integrate(other, project=7)
    count = len(told)
    run([Fraction(k) for k in (77, 3, 50)])
    assert len(told) > count
    assert all(parameters == state for parameters, state in told)
    assert len({state[0] for _, state in told}) == 4  # two neighbours for each of the two spins


def test_another_spin_in_an_idle_integrator_has_the_bits_of_a_new_one(monkeypatch):
    monkeypatch.setattr(compiled, "POOL", Pool())
    scene = plain("lagrange/nutation", 100)
    other = replace(scene, omega=(*scene.omega[:2], exact("4.3")))
    polhode.integrate(scene)
    idle = polhode.integrate(other)
    compiled.POOL = Pool()
    assert np.array_equal(idle.states, polhode.integrate(other).states)


@pytest.mark.parametrize("number", ["double", "extended"])
def test_events_of_time_have_parameters_of_their_own(number):
    """Two parameters tell an event the time; the spin stands behind them."""
    zero = "gamma3 - 1/2 - t/200"
    run = polhode.integrate(
        replace(plain("lagrange/nutation", 40), events=(Event("e", zero),)), number
    )
    times = run.events[0].times
    assert len(times) > 3
    for t in times:
        g3 = float(run(t)[5])
        assert abs(g3 - 0.5 - float(t) / 200) < 1e-13


def test_each_lane_has_its_own_spin():
    """Lanes of other spins, and one that another lane's trouble sends alone, as single runs."""
    scene = plain("lagrange/nutation", 50)
    many = polhode.integrate_many(scene, {"start.omega[3]": "3.9:4.3:11"}, workers=1)
    for k, member in enumerate(many.members):
        one = polhode.integrate(member, "double", at=scene.times, project=False)
        assert one.steps == many.counts[k]
        assert np.max(np.abs(many.states[k] - one.states)) < 3e-14
    alone = polhode.integrate_many(scene, {"start.omega[3]": [3.9]}, workers=1)
    assert np.array_equal(alone.states[0], many.states[0])


def test_what_no_rate_asks_for_is_no_parameter():
    """A sphere turning freely, without gamma: nothing changes, one by one and in lanes."""
    scene = replace(plain("euler/sphere", 3), gamma=None)
    made = built(problem(scene, DOUBLE).prepared().blueprint, None, None)
    assert (made.kept, len(made.heyoka.pars)) == ((), 0)
    events = (Event("alarm", "t - 1"),)
    run = polhode.integrate(replace(scene, events=events))
    assert run.events[0].times == (1,)
    many = polhode.integrate_many(scene, {"start.omega[3]": [1, 2]}, workers=1)
    assert many.states[:, 0, 2].tolist() == [1, 2]


def test_lanes_multiply_out_as_little():
    zeros = np.zeros((8, 6))
    names = ("p.gamma2", "p.qr", "q.gamma1", "q.rp")
    lanes = jobs.Lanes(zeros[:, :4], zeros)
    times = (Fraction(0), Fraction(1))
    job = jobs.BatchJob(names, DOUBLE, None, 10, times, 0, lanes)
    ta = batch_integrator.prepared(job).heyoka
    assert products(ta) == 4
    assert ta.pars.shape[0] == 5
