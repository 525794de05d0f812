"""Compiled integrators taken up again: the same bits, never shared, never too many."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.scenes.event import Event
from polhode.taylor.backend.integrator_pool import Kind, Pool
from polhode.taylor.corrections import integral_projection
from polhode.taylor.integrator import compiled

NAME = "lagrange/nutation"


@pytest.mark.parametrize("number", ["double", "extended"])
def test_a_second_run_builds_nothing_and_has_the_same_bits(built, number):
    scene = replace(polhode.load(NAME), outputs=())
    one, other = (polhode.integrate(scene, number) for _ in range(2))
    assert len(built) == 1
    assert np.array_equal(one.states, other.states)
    assert one.steps == other.steps
    back = polhode.integrate(scene, number, at=[-1, -7])
    assert len(built) == 1
    assert np.array_equal(back.states, polhode.integrate(scene, number, at=[-1, -7]).states)


def test_another_start_of_the_body_takes_the_same_integrator(built):
    scene = polhode.load(NAME)
    first = polhode.integrate(scene)
    other = replace(scene, omega=(Fraction(1), Fraction(2), Fraction(41, 10)))
    assert other.time_unit == scene.time_unit
    taken = polhode.integrate(other).states
    assert len(built) == 1
    compiled.POOL = Pool()
    assert np.array_equal(polhode.integrate(other).states, taken)
    assert len(built) == 2
    assert np.array_equal(polhode.integrate(scene).states, first.states)
    assert len(built) == 2


def test_what_differs_in_type_tolerance_outputs_or_body_is_built(built):
    scene = replace(polhode.load(NAME), outputs=())
    asked = [
        (scene, {}, True),
        (scene, {"number": "extended"}, True),
        (scene, {"tol": "1e-9"}, True),
        (replace(polhode.load("lagrange/cusped"), outputs=()), {}, False),  # the same body
        (replace(polhode.load("lagrange/first-axis"), outputs=()), {}, True),
        (scene.at(scene.times[-1:]), {}, False),
        (replace(scene, outputs=("angles",)).at([1]), {}, True),  # too short to be had apart
    ]
    for one, options, built_anew in asked:
        count = len(built)
        polhode.integrate(one, **options)
        assert len(built) - count == built_anew
    for one, options, _ in asked:
        polhode.integrate(one, **options)
    assert len(built) == 5


def test_threads_never_share_an_integrator(built):
    wanted = polhode.integrate(NAME).states
    with ThreadPoolExecutor(4) as pool:
        found = [*pool.map(lambda _: polhode.integrate(NAME).states, range(12))]
    assert all(np.array_equal(states, wanted) for states in found)


@pytest.mark.parametrize("events", [(), (Event("side", "gamma2", stop=True),)])
def test_a_run_that_ended_badly_leaves_nothing(built, events):
    scene = replace(polhode.load(NAME), events=events)
    polhode.integrate(scene, max_steps=1)
    polhode.integrate(scene)
    assert len(built) == 2


def test_a_start_at_a_pole_leaves_both_of_its_integrators(built):
    scene = replace(polhode.load("euler/attitude"), outputs=("angles",))
    assert scene.starts_at_pole
    for _ in range(2):
        polhode.integrate(scene, at=[5])
        assert len(built) == 2


def test_the_oldest_goes_first():
    pool, two, other = Pool(), Kind[str](2), Kind[str](2)
    pool.put(other, "a", "another kind's")
    for key in "abc":
        pool.put(two, key, key.upper())
    assert [pool.take(two, key) for key in "abcc"] == [None, "B", "C", None]
    assert [pool.take(other, key) for key in "ab"] == ["another kind's", None]


def test_nothing_is_kept_without_a_key():
    pool, kind = Pool(), Kind[str](2)
    pool.put(kind, None, "A")
    assert pool.take(kind, None) is None


def test_one_thread_builds_and_the_others_wait():
    """Compiling takes long: who comes meanwhile takes what is put back, or builds after it."""
    pool, kind, building = Pool(), Kind[list[int]](4), []

    def build() -> list[int]:
        building.append(1)
        time.sleep(0.01)
        assert len(building) == 1
        building.pop()
        return []

    def used(_: int) -> None:
        mine = pool.taken_or_built(kind, "x", build)
        mine.append(1)
        time.sleep(0.001)
        assert mine.pop() == 1
        assert not mine
        pool.put(kind, "x", mine)

    with ThreadPoolExecutor(4) as threads:
        assert [*threads.map(used, range(20))] == [None] * 20


def test_one_correction_serves_all_starts_of_a_kind(monkeypatch):
    integral_projection._newton_step.cache_clear()
    scene = polhode.load(NAME)
    polhode.integrate(scene, project=20)
    before = integral_projection._newton_step.cache_info().misses
    other = polhode.Scene(scene.body, (1, 2, 3), scene.gamma, times=scene.times)
    polhode.integrate(other, project=20)
    assert integral_projection._newton_step.cache_info().misses == before == 1


def test_a_second_run_of_a_scene_makes_only_what_differs(monkeypatch):
    """Equations, times and integrals are the scene's; another `at` changes the times alone."""
    from polhode.runs.problem import problem

    scene = polhode.load(NAME)
    first = polhode.integrate(scene, project=20)

    def again(*_, **__):
        raise AssertionError("made twice")

    for module, name in ((problem, "system"), (integral_projection, "first_integrals")):
        monkeypatch.setattr(module, name, again)
    monkeypatch.setattr(integral_projection, "exact_values", again)
    assert polhode.integrate(scene.at(scene.times), project=20) == first
    monkeypatch.setattr(problem, "rounded_times", again)
    assert polhode.integrate(scene, project=20) == first
    with pytest.raises(AssertionError):
        polhode.integrate(replace(scene, psi=Fraction(1)), project=20)


def test_what_is_kept_with_a_scene_is_no_part_of_it():
    import pickle

    scene, other = polhode.load(NAME), polhode.load(NAME)
    run = polhode.integrate(scene)
    assert scene == other
    assert "identity" not in vars(pickle.loads(pickle.dumps(scene)))
    back = pickle.loads(pickle.dumps(run))
    assert back == run
    assert np.array_equal(back("1/3"), run("1/3"))
