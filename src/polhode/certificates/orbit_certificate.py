"""A certificate of a periodic orbit: guesses near an approximate one, and what the checker proves.

Nothing here is believed but the body's and the level's numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.certificates import certificate_file, verify
from polhode.certificates.certificate_file import Made, by_checker
from polhode.common.interrupts import Progress
from polhode.numbers.exact import ONE, Exact
from polhode.numbers.flint_context import ctx
from polhode.scenes.body import Body

_DIVISORS = 2  # times as many as the steepness at the start asks: primes to divide the period by


class Problem(NamedTuple):
    """A body, and every other one within a relative tolerance of it; the level; T* and x*.

    ``start``, ``period``: near an orbit, in the scene's axes and units; with a tolerance in the
    principal axes, where a body of the certificate has three moments and no more.
    """

    body: Body
    h: Exact
    f: Exact
    start: Sequence[Fraction]
    period: Fraction
    tolerance: Fraction = Fraction(0)


class Choice(NamedTuple):
    """``radius``: of the box, states being about 1; ``bits``; ``part``: of the radius of
    convergence that a step is."""

    radius: Fraction
    bits: int
    part: float


def guesses(problem: Problem, choice: Choice, progress: Progress | None = None) -> Made:
    """A certificate but for its statement."""
    wide = choice.bits + verify.COARSE
    numbers = certificate_file.body_numbers(problem.body, wide, problem.tolerance)
    level = [certificate_file.number(x, wide) for x in (problem.h, problem.f, ONE)]
    with ctx.workprec(choice.bits + 2 * verify.COARSE):
        steps = _steps(numbers, problem, choice, progress)
    return {
        "format": verify.FORMAT,
        "kind": "orbit",
        "scene": {**numbers, "level": level},
        **steps,
        "bits": choice.bits,
    }


def proved(certificate: Made, progress: Progress | None = None) -> verify.Zero:
    """What the checker proves of guesses; raises its NotProved."""
    return by_checker(verify.zero_near, certificate, progress)


def stated(certificate: Made, statement: Made, zero: verify.Zero) -> Made:
    """The certificate with its statement, which the checker compares with what it proved."""
    with ctx.workprec(int(str(certificate["bits"])) + verify.COARSE):
        verify.check_orbit(verify.read_orbit(statement), zero)
    return {**certificate, "statement": statement}


def _steps(
    numbers: dict[str, object], problem: Problem, choice: Choice, progress: Progress | None
) -> Made:
    """Steps of one period, the box's radius, and by how much the period is divided."""
    bits, part = choice.bits, choice.part
    x = [verify.ball((x, Fraction(0))) for x in problem.start]
    steps = certificate_file.steps(numbers, x, problem.period, bits, bits, part, progress)
    state_bits = bits + 8  # the first centre is x* itself
    centres = steps["centres"]
    assert isinstance(centres, list)
    more = state_bits - int(str(steps["state_bits"]))
    centres = [[x << more for x in row] for row in centres]
    centres[0] = [round(x * (1 << state_bits)) for x in problem.start]
    inertia, torque, _ = verify.balls_of(verify.read_body(numbers, ()))
    certificate = {**steps, "state_bits": state_bits, "centres": centres, "bits": bits}
    guesses = verify.read_guesses([certificate[name] for name in verify.Guesses._fields])
    run = verify.Run(guesses, inertia, torque)
    steep = max(float(verify.steepness(verify.slope(run.body, x)).mid()) for x in run.centres)
    steep *= float(problem.period * Fraction(2) ** run.shift)
    return {
        **steps,
        "state_bits": state_bits,
        "centres": centres,
        "radius_bits": math.floor(-math.log2(choice.radius)),
        "divided_to": math.ceil(_DIVISORS * steep / (2 * math.pi)),
    }
