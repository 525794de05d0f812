"""Extreme and yet valid scenes against power series that share nothing with the package.

Moments' ratios, weights and spins of many powers of ten, starts a hair off special motions, times
from far below to far above one: what a closed form answers is right to every digit asked, and what
a run is said to be right to, it is.
"""

from __future__ import annotations

from fractions import Fraction
from random import Random

import pytest

import polhode
from polhode.numbers.mpmath_context import mpf, mpmath, own
from shared import series

DIGITS = 25
KINDS = ("euler", "lagrange", "kovalevskaya", "pendulum", "general")


def power(random: Random, most: int) -> Fraction:
    """A number of any size between 10**-most and 10**most."""
    return Fraction(random.randint(1, 99), 10) * Fraction(10) ** random.randint(-most, most)


def extreme(kind: str, seed: int) -> polhode.Scene:
    """A scene of a kind of top that turns by about a radian."""
    random = Random(f"{kind} {seed}")
    size, hair = power(random, 100), Fraction(1, 10 ** random.choice((1, 8, 30)))
    weight = power(random, 200)
    centre, omega = (0, 0, 0), [power(random, 3) * random.choice((-1, 1)) for _ in range(3)]
    if kind == "euler":
        moments = random.sample([Fraction(1), 1 + hair / 3, hair], 3)
        omega = random.choice([omega, [hair, 1, hair], [1, hair, 0]])
    elif kind == "lagrange":
        moments, centre = (Fraction(1), Fraction(1), power(random, 6) % 2 or 1), (0, 0, 1)
        omega = random.choice([omega, [hair, 0, 10 ** random.randint(0, 8)]])
    elif kind == "kovalevskaya":
        moments, centre = (Fraction(2), Fraction(2), Fraction(1)), (1, 0, 0)
    elif kind == "pendulum":
        moments, centre = (Fraction(2), Fraction(3), Fraction(4)), (1, 0, 0)
        omega = [0, 0, omega[2]]
    else:
        moments, centre = (Fraction(2), Fraction(3), 3 + hair), (1, 2, 3)
    gamma = (0, 1, 0) if kind == "pendulum" else random.choice(GAMMAS)
    # the unit of time in which a weight of that size turns the body by about a radian
    torque = weight * (centre != (0, 0, 0))
    rate = power(random, 100) if not torque else _root(torque / (size * max(moments)))
    top = max(abs(w) for w in omega)
    omega = [Fraction(w) / top * rate * random.choice((1, 2)) for w in omega]
    body = polhode.Body.of_moments([size * m for m in moments], centre, torque)
    fastest = max(abs(w) for w in omega)
    return polhode.Scene(body, omega, gamma, times=(random.choice((1, -1)) / fastest,), name=kind)


GAMMAS = [
    (Fraction(3, 5), 0, Fraction(4, 5)),
    (Fraction(2, 7), Fraction(3, 7), Fraction(6, 7)),
    (0, Fraction(-5, 13), Fraction(12, 13)),
]


def _root(x: Fraction) -> Fraction:
    """A power of ten near the root of a number: a rate of its size."""
    return Fraction(10) ** round((mpmath.log10(mpf(x.numerator)) - mpmath.log10(x.denominator)) / 2)


def true_rows(scene: polhode.Scene) -> list[list[mpf]]:
    """The motion by power series, in a unit of time in which the spin is about 1."""
    rate = max(abs(w) for w in scene.omega)
    moments = [m / max(scene.body.moments) for m in scene.body.moments]
    torque = [x / max(scene.body.moments) / rate**2 for x in scene.body.torque]
    omega, times = [w / rate for w in scene.omega], [t * rate for t in scene.times]
    return series.integrate(moments, omega, scene.gamma, times, DIGITS + 10, torque=torque)


def departure(rows: list[list[mpf]], true: list[list[mpf]], rate: Fraction) -> mpf:
    """The largest error of omega over the spin, or of gamma."""
    worst = mpf(0)
    for row, right in zip(rows, true, strict=True):
        for k, (x, y) in enumerate(zip(row, right, strict=True)):
            x = own(x)
            worst = max(worst, abs((x / series.number(rate) if k < 3 else x) - y))
    return worst


def judged(kind: str, seed: int) -> None:
    run = polhode.integrate(extreme(kind, seed))
    assert run.outcome.done
    scene = run.scene.at(run.times)  # those that the run was made for: rounded ones
    true, rate = true_rows(scene), max(abs(w) for w in scene.omega)
    reference = polhode.reference(scene)
    with mpmath.workdps(DIGITS + 15):
        if reference.is_closed_form:
            assert departure(reference.at(scene.times, DIGITS), true, rate) < mpf(10) ** (
                1 - DIGITS
            )
        else:
            assert kind == "general"
    found = polhode.compare(run)
    with mpmath.workdps(DIGITS + 15):
        error = departure([[mpf(float(x)) for x in row] for row in run.states], true, rate)
        fastest = max(mpmath.norm(mpmath.matrix(row[:3])) for row in true)
        assert error < max(1.01 * mpf(10) ** -found.worst * max(1, fastest), mpf(2) ** -50)
    assert found.worst > 12


@pytest.mark.sample(2)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", KINDS)
def test_an_extreme_scene_is_as_right_as_it_is_said_to_be(kind, seed):
    judged(kind, seed)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_more_extreme_scenes(kind):
    for seed in range(4, 12):
        judged(kind, seed)


@pytest.mark.campaign
@pytest.mark.parametrize("kind", KINDS)
def test_many_extreme_scenes_are_as_right_as_they_are_said_to_be(kind):
    for seed in range(12, 112):
        judged(kind, seed)
