"""What is left of a table: noise is called white where it is; angles are in degrees."""

from __future__ import annotations

import json
import math
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging.limits import SIGNIFICANCE, are_white
from shared import drifting_files as files
from shared.tables import ATTITUDE, STATE, right
from shared.tools import exactly

SCENE = "lagrange/nutation"
TIMES = [Fraction(k, 8) for k in range(160)]


def table(*parts):
    return right(SCENE, TIMES, *(parts or ("at",)))


def with_noise(columns, size, seed=3):
    draw = np.random.default_rng(seed)
    noise = {n: size * draw.normal(size=len(x)) for n, x in columns.items() if n != "t"}
    return {n: x + noise.get(n, 0) for n, x in columns.items()}


@pytest.mark.parametrize("size", [1e-2, 1e-5])
def test_white_noise_is_told_with_its_size_and_bias(size):
    """It was called the program's steps, noise, or another motion."""
    columns = with_noise(table(), size)
    columns["q"] += 3 * size
    judgement = polhode.compare(columns, SCENE)
    assert judgement.limit == "noise (white)"
    assert "fewer than double precision allows: noise that is white at this level" in str(judgement)
    assert (judgement.causes, judgement.readings, judgement.chance) == ((), (), None)
    assert [residual.column for residual in judgement.residuals] == list(STATE)
    for residual in judgement.residuals:
        assert residual.rms == pytest.approx(size, rel=0.2)
        assert residual.bias_error == pytest.approx(residual.rms / math.sqrt(len(TIMES)))
        assert abs(residual.bias - 3 * size * (residual.column == "q")) < 4 * residual.bias_error
    document = json.loads(judgement.to_json())["residuals"]
    assert document["rms"] == [residual.rms for residual in judgement.residuals]


def test_a_bias_that_is_more_than_the_noise_limits_the_digits():
    """It was called noise that is white at this level, with digits that the bias alone costs."""
    columns = with_noise(table(), 1e-6)
    columns["r"] -= 1e-3
    judgement = polhode.compare(columns, SCENE)
    assert (judgement.limit, judgement.causes) == ("bias (constant)", ())
    assert "allows: a constant bias, with white noise about it" in str(judgement)
    assert "(-0.001 ± 8e-08), gamma1" in str(judgement)


def test_a_noisy_attitude_has_its_own_limit():
    columns = with_noise(table("attitude"), 1e-3)
    length = np.sqrt(sum(columns[n] ** 2 for n in ATTITUDE))
    judgement = polhode.compare(
        {n: x / length if n != "t" else x for n, x in columns.items()}, SCENE
    )
    assert (judgement.limit, judgement.attitude_limit) == ("", "noise (white)")
    assert "of attitude, fewer than double precision allows: noise that is white" in str(judgement)
    assert [residual.column[:-1] for residual in judgement.residuals] == ["rotation_"] * 3
    exact = polhode.compare(table("at", "attitude"), SCENE)
    assert (exact.limit, exact.attitude_limit) == ("rounding", "rounding")


@pytest.mark.parametrize(("fewer", "limit"), [(0.9, "conditioning"), (3, "method")])
def test_an_attitude_may_lose_the_digits_of_the_angle_that_was_turned(fewer, limit):
    """At t = 20 that is 1.9 digits: omega's error is the rate at which it goes wrong."""
    columns = table("at", "attitude")
    (least, *_) = polhode.compare(columns, SCENE, details=True).expected[-1]
    half = 10 ** (fewer - least)
    columns["q1"][-1] += columns["q0"][-1] * half
    columns["q0"][-1] -= columns["q1"][-1] * half
    judgement = polhode.compare(columns, SCENE)
    assert judgement.attitude_limit.partition(" ")[0] in (
        limit,
        limit.replace("condition", "round"),
    )
    assert judgement.limit == "rounding"


def growing(columns):
    noise = with_noise({n: 0 * x for n, x in columns.items()}, 1e-3)
    return {n: x + noise[n] * columns["t"] / 20 for n, x in columns.items()}


def slow_sine(columns):
    return {n: x + 1e-3 * np.sin(columns["t"]) * (n != "t") for n, x in columns.items()}


def fast_sine(columns):
    return {n: x + 1e-3 * np.sin(21.7 * columns["t"]) * (n != "t") for n, x in columns.items()}


def walk(columns):
    steps = with_noise({n: 0 * x for n, x in columns.items()}, 1e-4)
    return {n: x + np.cumsum(steps[n]) * (n != "t") for n, x in columns.items()}


def offset(columns):
    return {n: x + 1e-3 * (n == "p") for n, x in columns.items()}


def few(columns):
    return {n: x[:25] for n, x in with_noise(columns, 1e-3).items()}


def sampled(columns):
    """Another motion, seen so seldom that neighbours are far apart."""
    pendulum = polhode.top(
        moments=[1, 1, "0.5"],
        centre=[0, 0, 1],
        weight=1,
        omega=["0.16", "0.32", "4.1"],
        gamma=["0.8", 0, "0.6"],
    )
    states = np.array(polhode.integrate(pendulum, at=[7 * t for t in TIMES[:80]]).states)
    true = right(SCENE, [7 * t for t in TIMES[:80]])
    return {"t": true["t"], **dict(zip(STATE, states.T, strict=True))}


@pytest.mark.parametrize("wrong", [growing, slow_sine, fast_sine, walk, offset, few, sampled])
def test_what_is_no_white_noise_is_not_called_so(wrong):
    judgement = polhode.compare(wrong(table()), SCENE)
    assert judgement.limit.startswith("method") or judgement.limit == ""
    assert "white" not in str(judgement)


def test_noise_is_taken_for_something_else_as_seldom_as_is_said():
    draw = np.random.default_rng(8)
    are_noise = [are_white(draw.normal(size=(100, 6))) for _ in range(400)]
    assert 1 - 4 * SIGNIFICANCE < np.mean(are_noise) < 1
    rows = draw.normal(size=(400, 200, 1))
    coloured = rows[:, 1:] + 0.6 * rows[:, :-1]
    assert np.mean([are_white(x) for x in coloured]) < 0.02


@pytest.mark.parametrize("degrees", [30.0, 1e-3, 1e-9])
@pytest.mark.parametrize("length", [1, -1, 1.0004])
def test_the_angle_of_rotation_is_that_which_was_planted(degrees, length):
    half = math.radians(degrees) / 2
    turn = np.array([math.cos(half), 0, 0.6 * math.sin(half), 0.8 * math.sin(half)])
    columns = table("attitude")
    q = length * files.product(np.array([columns[n] for n in ATTITUDE]).T, turn)
    judgement = polhode.compare(
        {"t": columns["t"], **dict(zip(ATTITUDE, q.T, strict=True))},
        SCENE,
        as_it_stands=True,
        details=True,
    )
    angles = judgement.column("attitude_error")
    assert np.allclose(angles, degrees, rtol=1e-9 + 1e-14 / degrees)
    assert judgement.fact("attitude_error") == pytest.approx(degrees, rel=1e-4)
    if degrees > 1e-4:
        assert f"attitude off by {degrees:.3g}° at worst" in str(judgement)
    assert f"attitude off by {max(angles):.3g}° at worst" in judgement.details()
    assert np.allclose(
        [x.bias for x in judgement.residuals], degrees * np.array([0, 0.6, 0.8]), atol=1e-13
    )


def test_an_angle_beyond_doubles_is_right():
    rows = polhode.reference(SCENE).attitude([1, 2], 60)
    small = Fraction(1, 10**30)
    quaternions = [
        [a - small * b, b + small * a, c + small * d, d - small * c]
        for a, b, c, d in ([exactly(x) for x in row] for row in rows)
    ]
    judgement = polhode.compare(quaternions, SCENE, at=[1, 2], columns=ATTITUDE)
    assert judgement.rotation_angles == pytest.approx([math.degrees(2e-30)] * 2, rel=1e-9)
