"""Coefficients as parameters: one compiled integrator serves every body of its zero pattern."""

from __future__ import annotations

import random
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import heyoka as hy
import numpy as np
import pytest

import polhode
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import NumberType
from polhode.taylor.backend.integrator_pool import Pool
from polhode.taylor.integrator import compiled
from shared.policies import change_policy

TYPES = ["double", "extended", "quad", "mp"]
CENTRES = {"free": [0, 0, 0], "on an axis": [0, 0, 1], "anywhere": ["1/3", "1/5", "1/7"]}

#: Of these every coefficient is there; among the second one's are 1, -1 and equal ones.
ORDINARY, SPECIAL = (
    {"moments": ["1.3", "0.9", "1.1"], "centre": ["1/3", "1/5", "1/7"], "weight": 1},
    {"moments": [1, 3, 2], "centre": [1, 3, 3], "weight": 1},
)


def top(**more) -> polhode.Scene:
    given = {"omega": ["0.3", "-0.2", "1.1"], "gamma": ["0.6", 0, "0.8"], "end": 10}
    return polhode.top(**{**ORDINARY, **given, **more})


def never_seen() -> dict[str, list[Fraction]]:
    """Moments whose code nothing can have compiled before."""
    return {"moments": [Fraction(random.randint(10**8, 14 * 10**7), 10**8) for _ in "abc"]}


@pytest.mark.parametrize("number", TYPES)
@pytest.mark.parametrize("centre", CENTRES)
def test_another_body_of_a_pattern_compiles_nothing(number, centre):
    """heyoka keeps in its memory whatever it compiles."""
    options = {"number": number, "method": "taylor", "project": False, "at": [1]}
    first = polhode.integrate(top(centre=CENTRES[centre], **never_seen()), **options)
    size = hy.llvm_state.get_memcache_size()
    other = polhode.integrate(top(centre=CENTRES[centre], **never_seen()), **options)
    assert hy.llvm_state.get_memcache_size() == size
    assert list(first.states[0]) != list(other.states[0])


@pytest.mark.parametrize("bits", [53, 61, 64, 65])
def test_few_bits_are_parameters_too(bits):
    """heyoka takes parameters of its own precision alone, and an exponent has 64 bits at least."""
    run = polhode.integrate(top(), NumberType("mp", bits), method="taylor", at=[1])
    assert abs(float(run.states[0][0]) - polhode.integrate(top(), at=[1]).states[0][0]) < 1e-14


def test_with_corrections_and_attitude_neither():
    first, other = (top(**never_seen(), outputs=["attitude", "angles"], end=300) for _ in "ab")
    polhode.integrate(first)
    size = hy.llvm_state.get_memcache_size()
    run = polhode.integrate(other)
    assert run.projection.count > 0
    assert hy.llvm_state.get_memcache_size() == size


@pytest.mark.parametrize("number", ["double", "extended"])
def test_what_is_1_or_equal_makes_no_pattern_and_what_is_0_does(built, number):
    for more, count in [
        ({}, 1),
        (SPECIAL, 1),
        ({"moments": [1, 1, "1.1"]}, 2),
        ({"moments": [1, "1.00000000000000000001", "1.1"]}, 2),
        ({"centre": ["1/3", 0, "1/7"]}, 3),
        ({"centre": ["1/3", "1e-300", "1/7"]}, 3),
        ({"weight": 0}, 4),
        ({"moments": [1, 1, "1.2"], "centre": [1, 2, 3], "weight": 7}, 4),
    ]:
        polhode.integrate(top(**more), number)
        assert len(built) == count, more


def test_a_form_with_a_singular_set_is_built_for_each_run(built):
    scene = top(form="lagrangian", end=1)
    one = polhode.integrate(scene)
    assert np.array_equal(polhode.integrate(scene).states, one.states)
    assert len(built) == 2


@pytest.mark.parametrize("number", ["double", "extended"])
def test_a_coefficient_that_underflows_is_no_zero(number, built):
    """Refused, whichever integrators are idle, and before anything is compiled."""
    large, tiny = (Fraction(10) ** 1500, Fraction(10) ** -3900)
    polhode.integrate(top(), number)
    polhode.integrate(top(centre=["1/3", 0, "1/7"]), number)
    more = {"moments": [large * k for k in (4, 3, 5)], "centre": [large, tiny, large]}
    with pytest.raises(polhode.BadInput, match="a type of wider range"):
        polhode.integrate(top(**more), number)
    assert len(built) == 2
    if number == "double":
        with pytest.raises(polhode.BadInput, match="a type of wider range"):
            polhode.integrate(top(moments=[1, 2, 2 + Fraction(10) ** -400]), number)


# -- neighbours ------------------------------------------------------------------------------------


@pytest.fixture
def alone(monkeypatch) -> list:
    """Two bodies of one pattern, each with its states where no other has used an integrator."""
    times, found = [*range(11)], []
    for body in (ORDINARY, SPECIAL):
        monkeypatch.setattr(compiled, "POOL", Pool())
        scene = top(**body)
        run = polhode.integrate(scene, at=times)
        fine = np.array(polhode.integrate(scene, "quad", at=times).states, float)
        assert np.abs(run.states - fine).max() < 1e-13
        found.append((scene.at(times), run.states, run(["1/3", "19/2"])))
    monkeypatch.setattr(compiled, "POOL", Pool())
    return found


def test_in_turn_and_with_corrections_in_between(alone):
    for _ in range(3):
        for scene, states, _ in alone:
            assert np.array_equal(polhode.integrate(scene).states, states)
            polhode.integrate(scene, project=3)


def test_in_threads(alone):
    with ThreadPoolExecutor(4) as pool:
        jobs = [pool.submit(polhode.integrate, alone[k % 2][0]) for k in range(24)]
    for k, job in enumerate(jobs):
        assert np.array_equal(job.result().states, alone[k % 2][1])


def test_trajectories_called_after_another_body_took_the_integrator(alone):
    runs = [polhode.integrate(scene) for scene, _, _ in alone]
    for _ in range(2):
        for run, (scene, states, between) in zip(runs, alone, strict=True):
            assert np.array_equal(run(["1/3", "19/2"]), between)
            assert np.array_equal(polhode.integrate(scene).states, states)


def test_propagators_in_turn(alone):
    goes = [polhode.propagator(scene) for scene, _, _ in alone]
    for t in (10.0, 3.0, -10.0, 10.0):
        for go, (scene, states, _) in zip(goes, alone, strict=True):
            there = go(t=t)
            assert np.array_equal(there, polhode.integrate(scene, at=[t], project=False).states[0])
            if t == 10:
                assert np.abs(there - states[-1]).max() < 1e-13


def test_after_an_interrupted_run(alone, monkeypatch):
    (one, states, _), (other, others, _) = alone

    def pressed(*_):
        raise KeyboardInterrupt

    for scene, wanted in ((other, states), (one, others)):
        with monkeypatch.context() as short:
            change_policy(short, chunk=20)
            stopped = polhode.integrate(scene.at([10]), progress=pressed)
        assert stopped.outcome is Outcome.INTERRUPTED
        assert np.array_equal(polhode.integrate(one if scene is other else other).states, wanted)
