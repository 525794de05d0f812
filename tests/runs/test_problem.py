"""A problem is made once for a scene and all that differ from it in their times alone."""

from __future__ import annotations

import gc
import pickle
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode.common.recent import Recent
from polhode.numbers.number_types import DOUBLE, EXTENDED
from polhode.runs.problem.problem import Problem, problem
from polhode.taylor.events.rules import Rules


def scene(**more):
    given = {"moments": [3, 2, 1], "omega": [1, 2, 3], "end": 2} | more
    return polhode.top(**given)


def test_it_is_shared_by_scenes_of_other_times_and_by_no_other_scene():
    first = scene()
    known = problem(first, DOUBLE)
    assert problem(first.at([7]), DOUBLE) is known is problem(first, DOUBLE)
    assert problem(first, EXTENDED) is not known
    assert problem(first, DOUBLE, Fraction(1, 1000)) is not known
    assert problem(first, DOUBLE, None, EXTENDED) is not known
    assert problem(first.at([-7]), DOUBLE) is not known
    assert problem(replace(first), DOUBLE) is not known
    assert problem(pickle.loads(pickle.dumps(first)), DOUBLE) is not known


def test_nothing_of_it_is_part_of_the_scene_s_value():
    first, other = scene(), scene()
    polhode.integrate(first)
    assert first == other
    assert not {"identity", "kept"} & {*vars(pickle.loads(pickle.dumps(first)))}
    known = problem(first, DOUBLE)
    assert known.prepared() is known.prepared()
    assert [*vars(pickle.loads(pickle.dumps(known)))] == ["scene", "number", "tolerance", "inputs"]


def test_the_last_two_schedules_are_kept():
    one, two, three = scene(), scene().at([1]), scene().at([2])
    known = problem(one, DOUBLE)
    first, second = known.schedule(one), known.schedule(two)
    assert known.schedule(one) is first
    assert known.schedule(two) is second
    assert known.schedule(three) is not first
    assert known.schedule(one) is not first
    assert known.schedule(one).exact == first.exact


class Thing:
    pass


def test_of_each_owner_the_last_are_kept():
    recent, made = Recent(2), []

    def value(owner, key):
        return recent.get(owner, key, lambda: made.append(key) or len(made))

    one, two = Thing(), Thing()
    assert [value(one, "a"), value(one, "b"), value(two, "a")] == [1, 2, 3]
    assert value(one, "a") == 1
    assert value(one, "c") == 4  # a was made first: it goes
    assert [value(one, "b"), value(two, "a")] == [2, 3]
    assert value(one, "a") == 5


@pytest.mark.slow
def test_a_problem_goes_with_its_scene():
    asked = scene(end=1000, samples=100_001, gamma=[0, 0, 1], events=[polhode.Event("q", "q-1/9")])
    for number in (DOUBLE, EXTENDED):
        polhode.integrate(asked.at([1, 2]), number)
    run = polhode.integrate(asked)
    gone = weakref.ref(problem(asked, DOUBLE)), weakref.ref(asked.identity)
    gc.collect()
    del asked
    gc.collect()
    assert gone[1]() is not None  # the run can be asked for other times
    assert len(run.states) == 100_001
    del run
    gc.collect()
    assert gone[1]() is None


def test_many_scenes_in_turn_keep_their_problems():
    scenes = [scene(title=str(k)) for k in range(300)]
    known = [problem(one, DOUBLE) for one in scenes]
    assert all(problem(one, DOUBLE) is x for one, x in zip(scenes, known, strict=True))


def test_threads_that_ask_at_once_get_the_same_one():
    scenes = [scene() for _ in range(20)]
    with ThreadPoolExecutor(8) as pool:
        for one in scenes:
            asked = [pool.submit(problem, one, DOUBLE) for _ in range(16)]
            assert len({id(x.result()) for x in asked}) == 1


def test_what_counts_as_a_zero_of_t_is_of_the_run_s_own_times(monkeypatch):
    made = []

    class Noted(Rules):
        def __init__(self, scene, *rest):
            made.append(scene.end)
            super().__init__(scene, *rest)

    monkeypatch.setattr("polhode.taylor.events.rules.Rules", Noted)
    asked = scene(gamma=[0, 0, 1], events=[polhode.Event("x", "q + t/1000")])
    for times in ([1000], [2], [1000], [2]):
        polhode.integrate(asked.at(times))
    assert made == [1000, 2, 1000, 2]
    polhode.integrate(asked)
    polhode.integrate(asked)  # the same times: not again
    assert made[4:] == [2]


def test_equations_that_two_make_at_once_are_those_of_the_first(monkeypatch):
    """Who makes them meets those that another thread has put there meanwhile."""
    one = problem(scene(), DOUBLE)
    made, first = Problem.system, []

    def overtaken(self, variables=()):
        monkeypatch.undo()
        first.append(self.prepared(variables))
        return made(self, variables)

    monkeypatch.setattr(Problem, "system", overtaken)
    assert one.prepared() is first[0]
    assert one.prepared() is first[0]
