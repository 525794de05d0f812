"""Attitude and angles as proven balls: closed forms, independent runs, faults, dropped terms."""

from __future__ import annotations

import ctypes
import platform
import random
import statistics
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import polhode
from polhode import NumberType, Scene
from polhode.enclosures import (
    approximation,
    attitude,
    fixed_point_problem,
    integral_contraction,
    task,
)
from polhode.enclosures.quaternion import TurnBounds, Turned
from polhode.enclosures.taylor_polynomials import Pieces
from polhode.numbers import vectors
from shared import enclosures as trials
from shared.tools import exactly, of_table, tiers

OUTPUTS = ("angles", "attitude")
TRUTH = NumberType("mp", 160)  # far more than any proof here has


def _ratios(enclosure: Any, run: Any, first: int = 0) -> list[float]:
    """|truth - midpoint|/radius of every number that is known, from a row on."""
    ratios = []
    for part, rows in ((enclosure.attitude, run.attitude), (enclosure.angles, run.angles)):
        for centres, radii, true in zip(
            part.centres[first:], part.radii[first:], rows, strict=True
        ):
            for x, r, y in zip(centres, radii, true, strict=True):
                if x is not None:
                    ratios.append(float(abs(x - exactly(y)) / Fraction(r)))
    return ratios


def _random(rng: random.Random, kind: str, digits: int, longest: int) -> list[float]:
    scene = replace(trials.random_scene(rng, kind), outputs=OUTPUTS)
    times = [Fraction(rng.randrange(1, 1000), 1001) * longest, Fraction(longest)]
    enclosure = polhode.certify(scene, at=times, digits=digits)
    assert enclosure.complete
    run = polhode.integrate(scene.at(times), TRUTH, max_steps=10**6)
    return _ratios(enclosure, run)


@pytest.mark.parametrize("kinds", tiers([], [(("generic",),)]))
def test_random_tops_have_their_attitude_and_angles_inside(kinds: Sequence[str]) -> None:
    rng = random.Random(31)
    ratios: list[float] = []
    for kind in kinds:
        digits, longest = (rng.choice((8, 16, 30)), rng.choice((2, 10, 30)))
        ratios += _random(rng, kind, digits, 5 if len(kinds) == 1 else longest)
    assert max(ratios) <= 1.0
    assert statistics.median(ratios) > 1e-6


# -- one term alone, and without it ----------------------------------------------------------


def _turn(scene: Scene, problem: Any, last: int, solution: Any) -> tuple[list[Any], float]:
    """The midpoint of the turn since the start, in principal axes, and its claimed error."""
    motion = fixed_point_problem.motion(replace(scene, outputs=("attitude",)))
    times = [fixed_point_problem.ball(Fraction(last), 400)]
    watch = attitude.AttitudeWatch(motion, problem, times, solution, False)
    task.run(problem, times, integral_contraction.prepared(motion, 400), watchers=[watch])
    centre = [Fraction(int(x), 1 << problem.fine) for x in watch._turned.centre]
    return centre, watch._turned.radius * 2.0**-problem.noise


def _off(centre: Sequence[Fraction], true: Sequence[Fraction]) -> float:
    return float(sum((x - y) ** 2 for x, y in zip(centre, true, strict=True))) ** 0.5


SPHERE = Scene(
    polhode.Body.of_moments((1, 1, 1), (0, 0, 1), 0),
    (0, 0, Fraction(1, 2)),
    (0, Fraction(3, 5), Fraction(4, 5)),
)


def _of_the_sphere(rate: Fraction, last: int) -> list[Fraction]:
    """(cos, 0, 0, sin) of half the angle."""
    import mpmath

    with mpmath.workprec(500):
        half = mpmath.mpf(rate.numerator) / rate.denominator * last / 2
        return [exactly(mpmath.cos(half)), Fraction(0), Fraction(0), exactly(mpmath.sin(half))]


def _wrong_start(a: Any, defects: Any, start: Any) -> Any:
    table = approximation.forced(a, defects, start)
    table[:, 0, 3] += 2.0**-40 * bool(np.any(start))  # of v itself, not of a correction
    return table


def _wrong_slope(a: Any, defects: Any, start: Any) -> Any:
    """A coefficient that is wrong by 2**-40, of v and again by whatever is corrected."""
    table = approximation.forced(a, defects, start)
    table[:, 1, 3] += 2.0**-40 if np.any(start) else 2.0**50  # 2**(90 - 40)
    return table


def _by_a_fault(solution: Any) -> float:
    problem = fixed_point_problem.problem(fixed_point_problem.motion(SPHERE), 90)
    centre, claimed = _turn(SPHERE, problem, 24, solution)
    return _off(centre, _of_the_sphere(Fraction(1, 2), 24)) / claimed


def _by_the_state() -> float:
    """The start is a box and the truth at its edge: the turn is off by what w is."""
    problem = fixed_point_problem.problem(fixed_point_problem.motion(SPHERE), 90)
    unit = fixed_point_problem.motion(SPHERE).unit
    ticks = 1 << (problem.fine - 50)
    start = (*problem.start[:2], problem.start[2] + ticks, *problem.start[3:])
    boxed = replace(problem, start=start, spread=(0.0, 0.0, 2.0**40, 0.0, 0.0, 0.0))
    centre, claimed = _turn(SPHERE, boxed, 4, approximation.forced)
    assert unit == 0
    return _off(centre, _of_the_sphere(Fraction(1, 2), 4)) / claimed


def _by_rounding() -> float:
    """Products of exact quaternions, of which only the rounding of each is charged."""
    rng = random.Random(5)
    problem = fixed_point_problem.problem(fixed_point_problem.motion(SPHERE), 90)
    turn, true = Turned(problem), [Fraction(1), Fraction(0), Fraction(0), Fraction(0)]
    for _ in range(30):
        a, b, c = (rng.randrange(-9, 9) for _ in range(3))
        size = a * a + b * b + c * c  # the square of 1 + (a, b, c) has rational length
        level = 60
        unit = [Fraction(1 - size, 1 + size), *(Fraction(2 * x, 1 + size) for x in (a, b, c))]
        v = [round(x * 2**level) for x in unit]
        table = np.array([[[x] for x in v]], dtype=np.int64)
        pieces = Pieces((0, 1), level, ((level, table),), np.zeros((1, 1, 4)), np.zeros((1, 1)))
        turn.step(TurnBounds(pieces, None, np.zeros(1)), 0)
        true = vectors.quaternion_product(true, [Fraction(x, 2**level) for x in v])
    centre = [Fraction(int(x), 1 << problem.fine) for x in turn.centre]
    return _off(centre, true) / (turn.radius * 2.0**-problem.noise)


def _overwriting(a: Any, defects: Any, start: Any) -> Any:
    """Right, and all that it was given is other numbers afterwards."""
    table = approximation.forced(a, defects, start)
    for argument in (a, defects, start):
        argument[:] = 1.0
    return table


def _of_zeroed(a: Any, defects: Any, start: Any) -> Any:
    """The turn of a body that stands still."""
    a[:] = 0.0
    return approximation.forced(a, defects, start)


class _Hoarding:
    """Right; what it has returned is other numbers as soon as it is asked again."""

    def __init__(self) -> None:
        self.kept: list[Any] = []

    def __call__(self, a: Any, defects: Any, start: Any) -> Any:
        for x in self.kept:
            x *= 2.0
        self.kept.append(approximation.forced(a, defects, start))
        return self.kept[-1]


#: The turn that shows a term, or a fault of what approximates; and how far it is off at least.
TERMS: dict[str, tuple[Any, float]] = {
    "defect": (lambda: _by_a_fault(_wrong_slope), 1e-3),
    "v(0)": (lambda: _by_a_fault(_wrong_start), 1e-3),
    "w": (_by_the_state, 1e-3),
    "rounding": (_by_rounding, 1e-3),
    "what it is given is overwritten": (lambda: _by_a_fault(_overwriting), 0.0),
    "what it is given is 0": (lambda: _by_a_fault(_of_zeroed), 0.0),
    "what it has returned is overwritten": (lambda: _by_a_fault(_Hoarding()), 0.0),
}


@pytest.mark.parametrize("term", TERMS)
def test_one_term_alone_is_enough_and_not_slack(term: str) -> None:
    ratio, least = TERMS[term]
    assert least <= ratio() <= 1.0


@pytest.mark.slow
def test_no_fault_in_the_approximated_turn_makes_a_wrong_attitude() -> None:
    rng = random.Random(33)
    scene = replace(trials.random_scene(rng, "generic"), outputs=OUTPUTS)
    run = polhode.integrate(scene.at((2,)), TRUTH, max_steps=10**6)
    true = [exactly(x) for x in run.attitude[0]]
    motion = fixed_point_problem.motion(scene)
    times = fixed_point_problem.times(motion, [Fraction(2)])
    spoiled = 0
    for _ in range(8):

        def faulty(a: Any, defects: Any, start: Any) -> Any:
            table = approximation.forced(a, defects, start)
            place = tuple(rng.randrange(n) for n in table.shape)
            table[place] += rng.choice((-1, 1)) * np.max(np.abs(table)) * 2.0 ** -rng.randrange(50)
            return table

        problem = fixed_point_problem.problem(motion, rng.choice((60, 90, 126)))
        watch = attitude.AttitudeWatch(motion, problem, times, faulty, True)
        task.run(problem, times, watchers=[watch])
        pose = watch.poses[0]
        ratios = trials.ratios([pose.quaternion], [true])
        assert max(ratios) <= 1.0
        spoiled += float(pose.quaternion[0].rad()) > 2.0 ** (20 - problem.noise)
    assert spoiled >= 2


# -- turns ------------------------------------------------------------------------------------


def _around(turns: float, size: float) -> Any:
    """A complex number that goes round 0, as psi and as phi."""

    def at(nodes: Any) -> Any:
        path = size * np.exp(2j * np.pi * turns * nodes)
        return np.array([path, path.conj()])

    return at


@pytest.mark.parametrize("mode", [0x400, 0x800, 0xC00])
def test_a_proof_refuses_doubles_that_are_rounded_otherwise(mode: int) -> None:
    proof: dict[str, Any] = {"scene": "euler/rest", "at": [1], "digits": 10}
    polhode.certify(**proof)  # whose engine is compiled
    libm = ctypes.CDLL(None)
    if not hasattr(libm, "fesetround") or platform.machine() != "x86_64":
        pytest.skip("no rounding mode to set")
    libm.fesetround(mode)
    try:
        with pytest.raises(polhode.BadInput, match="not rounded to the nearest"):
            polhode.certify(**proof)
    finally:
        libm.fesetround(0)


def test_turns_are_counted_however_many_there_are_in_a_step() -> None:
    points = np.array([0.5, 1.0])
    followed = attitude.Followed((2 * np.pi, -4 * np.pi))  # from one turn and from two back
    true = [[22 * np.pi, -24 * np.pi], [42 * np.pi, -44 * np.pi]]
    assert np.max(np.abs(followed.step(_around(20, 0.01), 1.0, points) - true)) < 1e-12
    on = followed.step(_around(0.25, 0.01), 1.0, points)
    assert on[1] == pytest.approx([42.5 * np.pi, -44.5 * np.pi], abs=1e-12)


@pytest.mark.parametrize("beside", [1e-3, -1e-3, 1e-9, -1e-9])
def test_a_pole_is_passed_on_its_side(beside: float) -> None:
    """psi turns by half a turn in next to no time, up or down."""

    def at(nodes: Any) -> Any:
        path = nodes - 0.4321 + 1j * beside
        return np.array([path, path.conj()])

    begin = float(np.angle(complex(-0.4321, beside)))
    end = float(np.angle(complex(0.5679, beside)))
    (row,) = attitude.Followed((begin, -begin)).step(at, 1.0, np.array([1.0]))
    assert row == pytest.approx([end, -end], abs=1e-9)


#: Released at a pole: the body, w, the pole, the sense of time.
HEAVY = ((2, Fraction(3, 2), 1), (0, 1, Fraction(1, 2)))
RELEASED = {
    "from rest": (HEAVY, (0, 0, 0), 1, 1),
    "with w across, back": (HEAVY, (Fraction(-1, 2), Fraction(1, 3), 2), -1, -1),
    "from the lower pole": (((2, Fraction(3, 2), 1), (1, -1, Fraction(1, 2))), (0, 0, -1), -1, 1),
    "fast": (HEAVY, (0, 0, 20), 1, 1),
    "axes not principal": (((2, 3, 2), (0, 0, 1), Fraction(1, 2)), (0, 0, 2), 1, 1),
}


@pytest.mark.parametrize("name", of_table(RELEASED, "from rest"))
def test_a_release_at_a_pole_is_left_as_a_run_leaves_it(name: str) -> None:
    """With w along the third axis gamma' = 0, and gamma'' = gamma x w' is of the second order."""
    (moments, centre, *off), omega, up, side = RELEASED[name]
    inertia = [[moments[i] if i == j else 0 for j in range(3)] for i in range(3)]
    if off:  # the centre on the third axis, which is not a principal one
        inertia[1][2] = inertia[2][1] = off[0]
    body = polhode.Body(inertia, centre, 1)
    scene = Scene(body, omega, (0, 0, up), psi=Fraction(4, 5), outputs=OUTPUTS)
    times = [side * Fraction(t) for t in ("1/1000000", "1/4")]
    enclosure = polhode.certify(scene, at=[0, *times], digits=15)
    assert enclosure.angles is not None
    assert enclosure.attitude is not None
    assert enclosure.angles.centres[0][0] is None is enclosure.angles.centres[0][2]
    assert None not in [x for row in enclosure.angles.centres[1:] for x in row]
    run = polhode.integrate(scene.at(times), TRUTH)
    assert max(_ratios(enclosure, run, first=1)) <= 1.0


def test_a_body_that_stays_at_a_pole_has_theta_alone() -> None:
    body = polhode.Body.of_moments((2, 2, 1), (0, 0, 1), 1)
    scene = Scene(body, (0, 0, 5), (0, 0, 1), outputs=OUTPUTS)
    enclosure = polhode.certify(scene, at=[2], digits=15)
    assert enclosure.angles is not None
    assert enclosure.angles.centres[0][0] is None is enclosure.angles.centres[0][2]
    ((psi, theta, phi),) = polhode.reference(scene, "certified").angles([2], 15)
    assert psi is None is phi
    assert theta is not None
    assert abs(theta) < 1e-15


def test_a_passage_through_a_pole_is_refused_where_angles_are_asked() -> None:
    """A pendulum about axis 1 that goes over the top."""
    body = polhode.Body.of_moments((3, 2, Fraction(3, 2)), (0, 1, 1), 1)
    scene = Scene(body, (3, 0, 0), (0, Fraction(3, 5), Fraction(4, 5)), outputs=OUTPUTS)
    with pytest.raises(polhode.BadInput, match="psi and phi are lost at t = "):
        polhode.reference(scene, "certified").angles([5], 15)
    enclosure = polhode.certify(scene, at=["1/100", 5], digits=15)
    ((since,), angles) = enclosure.lost, enclosure.angles
    assert angles is not None
    assert angles.centres[0][0] is not None is not angles.centres[0][2]
    assert angles.centres[1][0] is None is angles.centres[1][2]
    assert 0.0 <= since < 5.0


def test_digits_asked_for_are_those_of_angles_and_attitude_too() -> None:
    scene = replace(polhode.load("general/asymmetric-regular"), outputs=OUTPUTS)
    enclosure = polhode.certify(scene, at=[30], digits=20)
    assert enclosure.tries == 1
    assert enclosure.angles is not None
    assert enclosure.attitude is not None
    assert (
        20
        <= min(*enclosure.angles.digits, *enclosure.attitude.digits)
        == enclosure.fewest
        < enclosure.proven
    )
