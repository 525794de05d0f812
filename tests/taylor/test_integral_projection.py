"""Projection onto the first integrals: what it gains, and what it leaves alone."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import Event
from polhode.cli import main
from polhode.taylor.motion import Motion
from polhode.taylor.projection import Projector
from shared.tools import DOUBLE, change_policy, exactly, tiers

TOPS = ("euler/largest-axis", "lagrange/nutation", "kovalevskaya/generic")


def chaplygin(order: tuple[int, int, int] = (0, 1, 2)) -> polhode.Scene:
    """A Goryachev–Chaplygin body, its axes relabelled cyclically, f = 0."""

    def permuted(vector):
        components = [Fraction(0)] * 3
        for value, k in zip(vector, order, strict=True):
            components[k] = Fraction(value)
        return tuple(components)

    centre = (Fraction(3, 5), Fraction(4, 5), 0)
    body = polhode.Body.of_moments(permuted((4, 4, 1)), permuted(centre), 1)
    omega = (Fraction(1, 2), Fraction(1, 3), Fraction(-16, 9) * Fraction(9, 16))
    gamma = (0, Fraction(3, 5), Fraction(4, 5))
    return polhode.Scene(body, permuted(omega), permuted(gamma), times=(Fraction(20),))


# -- the integrals ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "onto"),
    tiers(
        [
            ("euler/turned-axes", ("h", "f", "|gamma|^2", "|G|^2")),
            ("lagrange/spherical-body", ("h", "f", "|gamma|^2", "spin")),
        ],
        [
            ("euler/no-gamma", ("h", "|G|^2")),
            ("lagrange/first-axis", ("h", "f", "|gamma|^2", "spin")),
            ("kovalevskaya/irrational-centre", ("h", "f", "|gamma|^2", "K^2")),
            (chaplygin((1, 2, 0)), ("h", "f", "|gamma|^2", "F")),
        ],
    ),
)
def test_each_exact_scene_has_its_integrals_and_a_run_keeps_them(scene, onto):
    """A quad run that was not projected keeps every one of them to its rounding."""
    run = polhode.integrate(scene, "quad", at=[10])
    assert run.projection is None
    drifts = [x for x in run.drift if x is not None]
    assert len(drifts) == len(onto)
    assert all(1e-38 < x < 1e-31 for x in drifts)
    assert polhode.integrate(scene, at=[10]).projection.onto == onto


def test_a_fourth_integral_needs_its_condition_exactly():
    scene = chaplygin()
    off = replace(scene, omega=(scene.omega[0] + Fraction(1, 10**40), *scene.omega[1:]))
    assert polhode.integrate(off).projection.onto[3:] == ("F",)  # f does not change
    off = replace(scene, omega=(*scene.omega[:2], scene.omega[2] + Fraction(1, 10**40)))
    assert polhode.integrate(off).drift.fourth is None


# -- what it gains ----------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(("number", "end"), [("double", 5000), ("extended", 1500)])
def test_a_projected_run_has_more_digits(number, end):
    """In the mean of some late times and starts: at one of them errors are small by chance."""
    scene = polhode.load("euler/largest-axis").at([Fraction(end * k, 40) for k in range(33, 41)])
    gains = []
    for k in range(4):  # a little faster each time: each rounds in its own way
        near = replace(scene, omega=tuple(x * (1 + Fraction(k, 1000)) for x in scene.omega))
        bare, projected = (
            np.mean(polhode.compare(polhode.integrate(near, number, project=p)).digits)
            for p in (False, None)
        )
        gains.append(projected - bare)
    assert 1 < np.mean(gains) < 5


def test_a_correction_that_is_no_rounding_is_not_made(monkeypatch):
    scene = polhode.load(TOPS[0]).at((Fraction(500),))
    wrong = "polhode.taylor.projection.exact_values"
    monkeypatch.setattr(wrong, lambda *_: [Fraction(2)] * 4)
    run = polhode.integrate(scene)
    assert run.projection.count == 0
    assert np.allclose(run.states, polhode.integrate(scene, project=False).states, 0, 1e-12)


def the_spin_of_a_symmetric_body_is_exact_on_average():
    """r' is 0: without memory of what was rounded off, r = 1.1 would be wrong all along."""
    scene = replace(
        polhode.load("lagrange/nutation"), times=tuple(Fraction(50 * k) for k in range(400))
    )
    spin = polhode.integrate(scene, project=1).states[1:, 2]
    exact = exactly(scene.omega[2])
    assert len(set(spin)) == 2
    mean = sum(exactly(x) - exact for x in spin) / len(spin)
    assert abs(mean) < abs(exactly(float(exact)) - exact) / 4


# -- never spoils -----------------------------------------------------------------------------


PARALLEL = ["euler/sphere", "kovalevskaya/pendulum-equatorial", "lagrange/steady-slow"]


@pytest.mark.parametrize("name", [*PARALLEL, "euler/separatrix"])
def test_parallel_gradients_stop_no_correction_and_magnify_none(name):
    """Damping takes the step to zero along what the integrals do not determine.

    Without it most corrections here are refused, or are ten times a rounding.
    """
    run = polhode.integrate(name, project=4)
    due = run.steps // 4
    assert due - 1 <= run.projection.count <= due
    assert DOUBLE.eps / 4 < run.projection.largest < 4 * DOUBLE.eps


def next_to(motion: str, near: Fraction) -> polhode.Scene:
    """A motion so near to a permanent rotation that gradients of the integrals all but agree."""
    if motion == "rotation about C":
        body = polhode.Body.of_moments((1, Fraction(3, 2), 2))
        return polhode.Scene(body, (near, 0, 1), (Fraction(3, 5), 0, Fraction(4, 5)), times=(20,))
    top = polhode.Body.of_moments((1, 1, Fraction(1, 2)), (0, 0, 1), 1)
    if motion == "sleeping top, pushed":
        return polhode.Scene(top, (near, 0, 4), (0, 0, 1), times=(20,))
    tilt = 1 + near**2
    gamma = (2 * near / tilt, 0, (1 - near**2) / tilt)
    return polhode.Scene(top, (0, near, 4), gamma, times=(20,))


@pytest.mark.parametrize("exponent", tiers([5], [7]))
@pytest.mark.parametrize(
    "motion", ["rotation about C", "sleeping top, pushed", "sleeping top, tilted"]
)
def test_what_the_integrals_do_not_determine_is_left_alone(motion, exponent):
    """Undamped, the step would magnify the residual's rounding by ten to that exponent."""
    scene = next_to(motion, Fraction(1, 10**exponent))
    run = polhode.integrate(scene, project=4)
    assert run.projection.count >= 4
    assert 1e-17 < run.projection.largest < 2 * float(DOUBLE.eps)
    assert 15 < min(polhode.compare(run).digits) <= DOUBLE.most_digits


@pytest.mark.slow
def test_quad_and_mp_are_projected_where_asked():
    scene = polhode.load("kovalevskaya/generic")
    for number, largest in (("quad", 1e-32), ("mp", 1e-48)):
        run = polhode.integrate(scene, number, project=True)
        assert run.projection.every == 1
        assert 0 < run.projection.largest < largest
        assert run.drift.h < largest


# -- what it leaves alone ---------------------------------------------------------------------


@pytest.mark.slow
def test_corrections_depend_on_no_output_time_and_no_chunk(monkeypatch):
    scene = polhode.load("kovalevskaya/generic")
    whole = polhode.integrate(scene, at=[300], project=7)
    many = polhode.integrate(scene, at=[Fraction(k, 40) for k in range(12_001)], project=7)
    lumps = [Fraction(k, 10**6) for k in range(50)]
    uneven = [t + s for t in (0, 150, Fraction(299)) for s in lumps]
    lumped = polhode.integrate(scene, at=[*uneven, 300], project=7)
    assert whole.projection == many.projection == lumped.projection
    assert len(many.times) == 12_001
    assert len(lumped.times) == 151
    assert np.max(np.abs(many.states[-1] - whole.states[-1])) < 1e-14
    some = replace(many, times=many.times[::240], states=many.states[::240])
    for run in (some, lumped):
        assert min(polhode.compare(run).digits) > 13
    change_policy(monkeypatch, chunk=5)
    assert polhode.integrate(scene, at=[300], project=7).projection.count == whole.projection.count


def test_an_output_time_may_be_where_a_correction_is():
    scene = polhode.load("kovalevskaya/generic")
    run = polhode.integrate(scene, at=[100], max_steps=21, project=False)
    assert run.steps == 21
    ended = DOUBLE.rounded(run.reached)
    times = [ended, ended + Fraction(1, 2**40), 100]
    again = polhode.integrate(scene, at=times, project=7)
    assert list(again.times) == times
    assert min(polhode.compare(again).digits) > 13.5


@pytest.mark.slow
def test_a_zero_where_a_correction_would_jump_over_it_is_reported_once(monkeypatch):
    """Corrections wait where a watched expression is nearer to zero than they move it."""
    scene = polhode.load("kovalevskaya/generic").at((Fraction(600),))
    motions, jumps, begin, correct = [], [], Motion.begin, Projector.correct

    def begin_in_sight(motion, *parts):
        motions.append(motion)
        begin(motion, *parts)

    def correct_in_sight(projector, state):
        before = float(state[1])
        corrected = correct(projector, state)
        after = float(state[1])
        if abs(after - before) > 3e-16:
            jumps.append((motions[-1].time, (before + after) / 2))
        return corrected

    with monkeypatch.context() as patch:
        patch.setattr(Motion, "begin", begin_in_sight)
        patch.setattr(Projector, "correct", correct_in_sight)
        polhode.integrate(scene, project=40)
    assert len(jumps) >= 8
    for time, value in jumps[:8]:
        watched = replace(scene, events=(Event("level", f"q - {Fraction(value)}"),))
        run = polhode.integrate(watched.at((time + 1,)), project=40)
        assert run.projection.count > 0
        assert sum(abs(t - time) < Fraction(1, 10**6) for t in run.events[0].times) == 1
        assert run.events[0].complete


# -- how it is asked for ----------------------------------------------------------------------


def test_the_ways_to_ask():
    scene = polhode.load(TOPS[0])
    for options, every in (
        ({}, 320),
        ({"number": "extended"}, 32),
        ({"project": 9}, 9),
        ({"tol": "1e-9", "project": True}, 320),
        ({"project": False}, None),
        ({"tol": "1e-9"}, None),
        ({"number": "quad", "at": [1]}, None),
    ):
        run = polhode.integrate(scene, **options)
        if every is None:
            assert (run.projection, run.projected) == (None, False)
        else:
            assert run.projection.every == every


def test_drift_is_no_evidence_where_it_was_projected(capsys):
    command = ["run", "euler/long", "--at", "500"]
    for how, there, absent in (
        (("--project", "20"), "largest correction", "drift"),
        (("--no-project",), "drift h", "correction"),
    ):
        assert main([*command, *how]) == 0
        notes = capsys.readouterr().err
        assert there in notes
        assert absent not in notes
    assert main([*command, "--project", "20", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["projection"]["onto"] == ["h", "f", "|gamma|^2", "|G|^2"]
    assert answer["projection"]["every"] == 20
    assert float(answer["projection"]["largest"]) < 1e-14 < float(answer["projection"]["sum"])
    drift = {key for key in answer if key.startswith("drift_")}
    assert drift == {f"drift_{name}" for name in ("h", "f", "gamma", "fourth")}
    run = polhode.integrate("euler/long", at=[500])
    assert "largest correction" in polhode.compare(run).details()
