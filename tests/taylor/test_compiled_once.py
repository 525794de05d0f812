"""Compiled integrators taken up again: one for all bodies of a zero pattern, without a trace."""

import pickle
from dataclasses import replace
from fractions import Fraction

import heyoka as hy
import numpy as np
import pytest

import polhode
from polhode import Event, NumberType, Outcome
from shared.tools import change_policy, exactly, tiers

NAME = "lagrange/nutation"
#: Of these every coefficient is there; among the second one's are 1, -1 and equal ones.
ORDINARY, SPECIAL = (
    {"moments": ["1.3", "0.9", "1.1"], "centre": ["1/3", "1/5", "1/7"], "weight": 1},
    {"moments": [1, 3, 2], "centre": [1, 3, 3], "weight": 1},
)


def top(**more) -> polhode.Scene:
    keys = {"omega": ["0.3", "-0.2", "1.1"], "gamma": ["0.6", 0, "0.8"], "end": 10}
    return polhode.top(**{**ORDINARY, **keys, **more})


@pytest.fixture
def built(monkeypatch, no_idle_engines) -> list:
    """The integrators that heyoka makes from now on, none being idle."""
    builds: list = []
    make = hy.taylor_adaptive

    def counted(*arguments, **options):
        builds.append(make(*arguments, **options))
        return builds[-1]

    monkeypatch.setattr("heyoka.taylor_adaptive", counted)
    return builds


# -- what compiles, and what is built -------------------------------------------------------------


@pytest.mark.parametrize("bits", [53, 65])
def test_few_bits_are_parameters_too(bits):
    """heyoka takes parameters of its own precision alone, and an exponent has 64 bits at least."""
    run = polhode.integrate(top(), NumberType("mp", bits), method="taylor", at=[1])
    assert abs(float(run.states[0][0]) - polhode.integrate(top(), at=[1]).states[0][0]) < 1e-14


LAGRANGE = replace(polhode.load(NAME), outputs=())
OTHER_START = replace(LAGRANGE, omega=(Fraction(1), Fraction(2), Fraction(41, 10)))


def test_what_differs_in_type_tolerance_outputs_events_or_pattern_is_built(built):
    """Nothing else: no coefficient that is 1 or equal to another, no time, no start."""
    watched = replace(LAGRANGE, events=(Event("side", "gamma2"),))
    runs = [
        (LAGRANGE, {}, 1),
        (LAGRANGE, {"at": [-1, -7]}, 0),
        (OTHER_START, {}, 0),
        (replace(polhode.load("lagrange/cusped"), outputs=()), {}, 0),  # the same body
        (LAGRANGE, {"number": "extended"}, 1),
        (LAGRANGE, {"tol": "1e-9"}, 1),
        (replace(polhode.load("lagrange/first-axis"), outputs=()), {}, 1),
        (replace(LAGRANGE, outputs=("angles",)), {"at": [1]}, 1),
        (watched, {}, 1),
        (watched, {"at": [3]}, 0),
        (top(), {}, 1),
        (top(**SPECIAL), {}, 0),
        (top(moments=[1, 1, "1.1"]), {}, 1),
        (top(moments=[1, "1.00000000000000000001", "1.1"]), {}, 0),
        (top(centre=["1/3", 0, "1/7"]), {}, 1),
        (top(centre=["1/3", "1e-300", "1/7"]), {}, 0),
        (top(weight=0), {}, 1),
        (top(outputs=["attitude", "angles"], end=300), {}, 1),
        (top(**SPECIAL, outputs=["attitude", "angles"], end=300), {}, 0),
        (top(moments=[1, 1, "1.2"], centre=[1, 2, 3], weight=7), {}, 0),
    ]
    for again in (1, 0):
        for scene, options, count in runs:
            before = len(built)
            polhode.integrate(scene, **options)
            assert len(built) - before == count * again, (scene.name, options)


@pytest.mark.parametrize("form", tiers(["momentum"], ["quaternion"]))
def test_forms_whose_coefficients_are_constants_have_engines_of_their_own(form, built):
    """Another body builds one; the same again none, and it has the bits of a new one."""
    bodies = [replace(top(**body), form=form) for body in (ORDINARY, SPECIAL)]
    first = [polhode.integrate(scene, at=[3]) for scene in bodies]
    assert len(built) == 2
    again = [polhode.integrate(scene, at=[3]) for scene in bodies]
    assert len(built) == 2
    assert first == again
    for run, scene in zip(again, bodies, strict=True):
        plain = polhode.integrate(replace(scene, form="principal"), at=[3])
        assert np.abs(run.states - plain.states).max() < 1e-13


def test_a_run_that_ended_at_a_singular_set_leaves_no_trace(built):
    """Its engine goes on to the next run, as that of a run that came to its end does."""
    swing = {"moments": [1, 1, 2], "centre": [0, 0, 1], "omega": [1, 0, 0]}
    through = replace(top(**{**swing, "gamma": [0, "0.6", "0.8"]}), form="routhian")
    beside = replace(top(**{**swing, "gamma": ["0.6", 0, "0.8"]}), form="routhian")
    alone = polhode.integrate(beside)
    runs = [polhode.integrate(through) for _ in range(3)]
    assert runs[0].outcome is Outcome.SINGULAR
    assert runs[0] == runs[1] == runs[2]
    assert polhode.integrate(beside) == alone
    assert alone.outcome is Outcome.REACHED_END
    assert len(built) == 2


def test_a_propagator_leaves_its_engine_to_the_next_body(built):
    """And to that alone: of two at a time each has its own."""
    scenes = [top(**body) for body in (ORDINARY, SPECIAL)]
    runs = [polhode.integrate(scene, at=[3], project=False).states[0] for scene in scenes]
    for scene, state in zip(scenes, runs, strict=True):
        assert np.array_equal(polhode.propagator(scene)(t=3.0), state)
    assert len(built) == 1
    goes = [polhode.propagator(scene) for scene in scenes]
    assert len(built) == 2
    for go, state in zip(goes, runs, strict=True):
        assert np.array_equal(go(t=3.0), state)


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


# -- neighbours -----------------------------------------------------------------------------------


def test_runs_in_turn_have_the_bits_of_runs_alone(monkeypatch, no_idle_engines):
    """With corrections in between, calls of a run that another body's came after, and Ctrl-C."""

    def pressed(*_):
        raise KeyboardInterrupt

    between, alone = ["1/3", "19/2"], []
    for body in (ORDINARY, SPECIAL):
        no_idle_engines()  # that another has used
        run = polhode.integrate(top(**body), at=range(11))
        alone.append((run.scene, run.states, run(between)))
    no_idle_engines()
    runs = [polhode.integrate(scene) for scene, _, _ in alone]
    for _ in range(2):
        for run, (scene, states, there) in zip(runs, alone, strict=True):
            assert np.array_equal(polhode.integrate(scene).states, states)
            assert np.array_equal(run(between), there)
            polhode.integrate(scene, project=3)
            polhode.integrate(scene, max_steps=1)
            with monkeypatch.context() as short:
                change_policy(short, chunk=20)
                stopped = polhode.integrate(scene.at([10]), progress=pressed)
            assert stopped.outcome is Outcome.INTERRUPTED


@pytest.mark.parametrize(
    ("outputs", "number"),
    tiers([((), "double"), ((), "extended")], [(("angles",), "extended")]),
)
def test_another_start_in_an_idle_integrator_has_the_bits_of_a_new_one(
    number, outputs, no_idle_engines
):
    """Its spin, which the equations keep, is told whenever the state is, and in events of time."""
    zero = Event("e", "gamma3 - 1/2 - t/200")
    new, reused = (
        replace(scene, outputs=outputs, events=(zero,)).at([20])
        for scene in (LAGRANGE, OTHER_START)
    )
    first = polhode.integrate(new, number, project=7)
    idle = polhode.integrate(reused, number, project=7)
    assert idle.events[0].times
    for t, row in zip(idle.events[0].times, idle.events[0].states, strict=True):
        assert abs(exactly(row[5]) - Fraction(1, 2) - t / 200) < 2 * idle.number.eps
    no_idle_engines()
    fresh = polhode.integrate(reused, number, project=7)
    assert fresh == idle
    assert polhode.integrate(new, number, project=7) == first


def test_a_run_that_was_pickled_is_asked_without_a_compilation(monkeypatch):
    """Its number type is equal to double and another object."""
    run = polhode.integrate(top())
    again, there = pickle.loads(pickle.dumps(run)), run("10/3")
    monkeypatch.setattr("heyoka.taylor_adaptive", None)
    assert np.array_equal(again("10/3"), there)
    assert np.array_equal(polhode.integrate(top()).states, run.states)


def test_what_no_rate_asks_for_is_no_parameter():
    """A sphere turning freely, without gamma: nothing changes, one by one and in lanes."""
    scene = replace(polhode.load("euler/sphere"), gamma=None, outputs=(), published=()).at([3])
    run = polhode.integrate(replace(scene, events=(Event("alarm", "t - 1"),)))
    assert run.events[0].times == (1,)
    many = polhode.integrate_many(scene, {"start.omega[3]": [1, 2]}, workers=1)
    assert many.states[:, 0, 2].tolist() == [1, 2]


CHAOTIC = "general/asymmetric-chaotic"
WATCHED = replace(polhode.load(CHAOTIC), events=(Event("e", "gamma3 - t/8"),))


@pytest.mark.parametrize(
    "sweep",
    [
        lambda k: polhode.section(CHAOTIC, grid=(3, 3), crossings=4, h=3, f=Fraction(k, 8)).states,
        lambda k: polhode.reduce_many(
            WATCHED, {"start.omega[3]": f"{k}:{k + 1}:11"}, "first e", workers=1
        )["t of first e"],
        lambda k: (
            polhode.integrate_many(CHAOTIC, {"start.omega[3]": f"{k}:{k + 1}:11"}, workers=1).states
        ),
    ],
    ids=["sections", "first zeros", "sweeps"],
)
def test_a_batch_taken_up_again_has_no_trace_of_who_used_it_before(sweep, monkeypatch):
    fresh, reused = sweep(2), sweep(1)
    monkeypatch.setattr("heyoka.taylor_adaptive_batch", None)
    assert np.array_equal(sweep(2), fresh, equal_nan=True)
    assert not np.array_equal(fresh, reused, equal_nan=True)
