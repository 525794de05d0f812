"""Levels and candidates of orbits to be proved, for tests of the proof's parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import polhode
from polhode.enclosures.fixed_point_problem import motion, problem
from polhode.enclosures.proof_loop import SHORT_STEPS
from polhode.numbers.flint_context import ctx
from polhode.proofs import flow_tube, orbit_candidate
from polhode.proofs.level import Level
from polhode.proofs.orbit_candidate import Found
from polhode.proofs.periodic_orbit import Candidate

#: The body and the level of the examples; the orbits as a search in double found them.
MOMENTS = [Fraction(2), Fraction(3, 2), Fraction(1)]
TORQUE = [Fraction(3, 10), Fraction(1, 5), Fraction(1, 2)]
H, F = Fraction(261, 200), Fraction(31, 25)
BODY = polhode.top(
    moments=MOMENTS, centre=TORQUE, weight=1, omega=["3/10", "1/5", 1], gamma=["3/5", 0, "4/5"]
)
ELLIPTIC = (
    *(0.24648456378902078, 0.3484822174895774, -1.880218379593652),
    *(-0.4532503649457642, -0.26342557792225096, -0.8515697690576267),
    3.221902062960887,
)
HYPERBOLIC = (
    *(0.39248732502901934, -1.4931034249442232, -0.3812431760503589),
    *(-0.304878314545795, -0.5252810140625632, -0.7944363219195862),
    4.265751022846151,
)
INVERSE = (
    *(-0.2570580570985149, -0.22188153703552527, 1.623437027381608),
    *(-0.7715547273133809, -0.4761773622001807, 0.4218511852400707),
    5.625116696318105,
)
NOISE = 110
FOLLOW = orbit_candidate.follower(SHORT_STEPS)


def level(h: Fraction = H, f: Fraction = F, body: polhode.Scene = BODY) -> Level:
    """A level of a body, time in the scene's unit."""
    return Level(motion(body, unit=0), h, f)


def proved(point: Sequence[float], on: Level | None = None, digits: int = 30) -> Found:
    """An orbit corrected and proved."""
    exact = [Fraction(x) for x in point]
    return orbit_candidate.corrected(on or level(), exact, digits, (2, 3, 5), SHORT_STEPS)


def sharp(point: Sequence[float]) -> Candidate:
    """The candidate of an orbit, right to thirty digits, with the box of its noise level."""
    found = proved(point)
    middle = [middle_of(x) for x in (*found.theorem.start, found.theorem.period)]
    return orbit_candidate.candidate(level(), middle, NOISE, (2, 3, 5))


def middle_of(x: object) -> Fraction:
    """The exact midpoint of a ball."""
    mantissa, exponent = x.mid().man_exp()  # type: ignore[attr-defined]
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def moved(candidate: Candidate, component: int, by: Fraction) -> Candidate:
    """The candidate with one of its seven numbers changed."""
    ticks = round(by * 2 ** (candidate.noise + 12))
    if component == 6:
        return replace(candidate, period=candidate.period + ticks)
    start = list(candidate.start)
    start[component] += ticks
    return replace(candidate, start=tuple(start))


class Followed(NamedTuple):
    """A tube to the candidate's period, and DF(Y) as balls' ends: middle and radius."""

    tube: flow_tube.Tube
    slope: list[list[tuple[Fraction, Fraction]]]


def followed(
    candidate: Candidate, on: Level | None = None, start_box: int | None = None
) -> Followed:
    """The tube of a candidate's box, or of one of 2**-start_box, and DF(Y)."""
    from polhode.proofs import periodic_orbit

    on = on or level()
    fine = candidate.noise + 12
    start = tuple(Fraction(x, 1 << fine) for x in candidate.start)
    known = problem(replace(on.motion, start=start), candidate.noise)
    box = candidate.bits if start_box is None else start_box
    times = [flow_tube.part(candidate.period, fine, 1)]
    tube = flow_tube.Tube(known, 2.0 ** (candidate.noise - box), times)
    FOLLOW(known, times, (tube,))
    with ctx.workprec(candidate.noise + 128):
        matrix = periodic_orbit.slope(on.balls(candidate.noise + 100), candidate, tube)
        rows = [
            [(middle_of(matrix[i, j]), middle_of(matrix[i, j].rad())) for j in range(10)]
            for i in range(10)
        ]
    return Followed(tube, rows)
