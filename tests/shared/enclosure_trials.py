"""Random tops for the tests of the enclosures, and where their motions truly go.

Truth is a run at many more bits than the proof has: heyoka's, in MPFR, whose own error is below
2**-40 of the radii that it judges; closed forms judge the same enclosures elsewhere.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

from flint import arb, ctx

from polhode.enclosures import fixed_point_problem
from polhode.enclosures.fixed_point_problem import Motion, Problem
from polhode.judging.adaptive_precision import integrate
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import NumberType
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

KINDS = (
    *("generic", "fast", "slow", "needle", "disc", "nearly symmetric", "free", "hanging", "zeros"),
    *("sphere", "kovalevskaya"),
)


def number(rng: random.Random, low: float, high: float, bits: int = 12) -> Fraction:
    """A fraction between two numbers, of a prime denominator half of the time."""
    bottom = rng.choice((1 << bits, 997))
    return Fraction(round(rng.uniform(low, high) * bottom), bottom)


def unit_vector(rng: random.Random) -> tuple[Fraction, Fraction, Fraction]:
    """A rational unit vector: the stereographic image of a rational point."""
    s, t = number(rng, -2, 2, 6), number(rng, -2, 2, 6)
    bottom = 1 + s * s + t * t
    return 2 * s / bottom, 2 * t / bottom, (bottom - 2) / bottom


def random_scene(rng: random.Random, kind: str) -> Scene:
    """A top of a kind, with a random start."""
    b, c = number(rng, 1, 2), number(rng, 1, 2)
    a = number(rng, float(abs(b - c)) + 0.1, float(b + c) - 0.1)
    centre = [number(rng, -1, 1) for _ in range(3)]
    omega = [number(rng, -1.5, 1.5) for _ in range(3)]
    weight = Fraction(1)
    if kind == "fast":
        omega[2] = number(rng, 20, 40)
    elif kind == "slow":
        omega = [x / 1000 for x in omega]
    elif kind == "needle":
        a, b = Fraction(1, 50), c
        b = c + number(rng, -0.015, 0.015)
    elif kind == "disc":
        a, b, c = b, c, b + c
    elif kind == "nearly symmetric":
        a = b + Fraction(1, 10**20)
    elif kind == "free":
        weight = Fraction(0)
    elif kind == "hanging":
        weight = Fraction(-2)
    elif kind == "zeros":
        centre[rng.randrange(3)] = omega[rng.randrange(3)] = Fraction(0)
    elif kind == "sphere":
        a = b = c
    elif kind == "kovalevskaya":
        a = b = 2 * c
        centre[2] = Fraction(0)
    moments = [a, b, c]
    if kind not in ("kovalevskaya",):
        rng.shuffle(moments)
    body = Body.of_moments(moments, centre, weight)
    return Scene(body, tuple(omega), unit_vector(rng), name=kind)


def truth(scene: Scene, times: Sequence[Any], bits: int) -> list[list[Fraction]]:
    """States in the scene's axes at times away from 0 in order, exact values of MPFR numbers."""
    asked = scene.at(tuple(exact.exact(t) for t in times))
    found = integrate(asked, NumberType("mp", bits), max_steps=10**6)
    assert found.outcome.done
    return [[exactly(x) for x in row] for row in found.states]


class Trial(NamedTuple):
    """A motion, times in its unit, and the true states there in its unit and axes."""

    motion: Motion
    times: list[Fraction]
    states: list[list[Fraction]]
    bits: int


def trial(scene: Scene, times: Sequence[Fraction], bits: int) -> Trial:
    """The true states of a scene given in principal axes, ready for proofs of any noise level."""
    motion = fixed_point_problem.motion(scene)
    by = Fraction(2) ** motion.unit
    asked = [t * by for t in times]
    rows = truth(replace(scene, outputs=()), asked, bits)
    return Trial(motion, list(times), [[*(by * x for x in r[:3]), *r[3:]] for r in rows], bits)


def asked(what: Trial, problem: Problem) -> list[Any]:
    """The times of a trial as balls."""
    return [fixed_point_problem.ball(t, problem.noise + 200) for t in what.times]


def ratios(balls: Sequence[Sequence[Any]], states: Sequence[Sequence[Any]]) -> list[float]:
    """|truth - midpoint|/radius of every component; at most 1 where the truth is inside."""
    found = []
    with ctx.workprec(2000):
        for row, true in zip(balls, states, strict=True):
            for x, y in zip(row, true, strict=True):
                off = abs(fixed_point_problem.ball(y, 2000) - x.mid())
                if x.rad() == 0:
                    found.append(0.0 if off == 0 else float("inf"))
                else:
                    found.append(float((off / arb(x.rad())).mid()))
    return found
