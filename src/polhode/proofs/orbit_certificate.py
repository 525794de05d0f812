"""The search for a certificate of a periodic orbit: an approximate one, its digits, box and grid.

Not trusted, as nothing of a certificate is but the body's and the level's numbers: what
``certificates/verify.py`` proves of it holds.  Krawczyk's test on a box of radius r knows the orbit
to about r^2, or to r times the error of the flow's derivative, if that is more: so a centre that is
right to half of the digits wanted is enough, or to a few less than these.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.certificates import certificate_file, verify
from polhode.certificates.certificate_file import JsonObject, by_checker
from polhode.common.errors import BadInput
from polhode.common.interrupts import Message
from polhode.dynamics import newton_shooting
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.newton_shooting import Closed, NotClosed, at_level, bordered, closed
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.exact import ONE, Exact, sign
from polhode.numbers.flint_context import ctx
from polhode.proofs.theorem import NotProved
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

# --- certificate --------------------------------------------------------------------------------


_DIVISORS = 2  # times as many as the steepness at the start asks: primes to divide the period by


class Problem(NamedTuple):
    """A body, the level, T* and x*.

    ``start``, ``period``: near an orbit, in the scene's axes and units.
    """

    body: Body
    h: Exact
    f: Exact
    start: Sequence[Fraction]
    period: Fraction


class Choice(NamedTuple):
    """``radius``: of the box, states being about 1; ``bits``; ``part``: of the radius of
    convergence that a step is."""

    radius: Fraction
    bits: int
    part: float


def guesses(problem: Problem, choice: Choice) -> JsonObject:
    """A certificate but for its statement."""
    wide = choice.bits + verify.COARSE
    numbers = certificate_file.body_numbers(problem.body, wide)
    level = [certificate_file.number(x, wide) for x in (problem.h, problem.f, ONE)]
    with ctx.workprec(choice.bits + 2 * verify.COARSE):
        steps = _steps(numbers, problem, choice)
    return {
        "format": verify.FORMAT,
        "kind": "orbit",
        "scene": {**numbers, "level": level},
        **steps,
        "bits": choice.bits,
    }


def zero_of(certificate: JsonObject) -> verify.Zero:
    """What the checker proves of guesses; raises its NotProved."""
    return by_checker(verify.zero_near, certificate)


def with_statement(certificate: JsonObject, statement: JsonObject, zero: verify.Zero) -> JsonObject:
    """The certificate with its statement, which the checker compares with what it proved."""
    with ctx.workprec(int(str(certificate["bits"])) + verify.COARSE):
        verify.check_orbit(verify.read_orbit(statement), zero)
    return {**certificate, "statement": statement}


def _steps(numbers: JsonObject, problem: Problem, choice: Choice) -> JsonObject:
    """Steps of one period, the box's radius, and by how much the period is divided."""
    bits, part = choice.bits, choice.part
    x = [verify.ball((x, Fraction(0))) for x in problem.start]
    steps = certificate_file.steps(numbers, x, problem.period, bits, bits, part)
    state_bits = bits + 8  # the first centre is x* itself
    centres = steps["centres"]
    assert isinstance(centres, list)
    more = state_bits - int(str(steps["state_bits"]))
    centres = [[x << more for x in row] for row in centres]
    centres[0] = [round(x * (1 << state_bits)) for x in problem.start]
    inertia, torque, _ = verify.balls_of(verify.read_body(numbers, ()))
    certificate = {**steps, "state_bits": state_bits, "centres": centres, "bits": bits}
    grid = verify.read_guesses([certificate[name] for name in verify.Guesses._fields])
    run = verify.Run(grid, inertia, torque)
    steep = max(float(verify.steepness(verify.slope(run.body, x)).mid()) for x in run.centres)
    steep *= float(problem.period * Fraction(2) ** run.shift)
    return {
        **steps,
        "state_bits": state_bits,
        "centres": centres,
        "radius_bits": math.floor(-math.log2(choice.radius)),
        "divided_to": math.ceil(_DIVISORS * steep / (2 * math.pi)),
    }


# --- search ---------------------------------------------------------------------------------------


BITS_A_DIGIT = math.log2(10)
_SPARE = 40  # bits beyond the digits wanted
_CENTRE = 9  # digits of the centre beyond half of those wanted
_FEWER = 7  # or so many less
_BOX = 3  # digits by which the box is wider than the centre's error
_TRIES = 5
_STEPS = (0.25, 0.15, 0.1)  # of the radius of convergence
_SINGULAR = 1e11  # condition of the ten equations
_ROUGH = Choice(Fraction(1, 1 << 40), 96, 0.25)  # of a guess that Newton's method cannot better
_BINARY = 200  # bits of such a guess


class Candidate(NamedTuple):
    """An approximate orbit; ``closed``: in double, or the reason why there is none."""

    on: LevelBody
    closed: Closed | str
    start: tuple[Fraction, ...]
    period: Fraction


class OrbitProof(NamedTuple):
    """What the checker proved, of which guesses; ``runs``: how often it was called."""

    zero: verify.Zero
    certificate: JsonObject
    digits: float
    runs: int


def of_closed(on: LevelBody, orbit: Closed) -> Candidate:
    """The candidate that a search in double gives."""
    return Candidate(on, orbit, (), Fraction(0))


def of_scene(on: LevelBody, near: Scene) -> Candidate:
    """The candidate near a scene's start whose period is about its end; raises BadInput."""
    if near.gamma is None or near.end is None or sign(near.end) <= 0:
        raise BadInput(near.name, "orbit", None, "a start with gamma, and run.end, its period")
    exact_start = (*near.omega, *near.gamma)
    start = [exact.nearest(x, _BINARY) if x else Fraction(0) for x in exact_start]
    period = exact.nearest(near.end, _BINARY)
    inside = on.scene.body.axes.components
    scaled = tuple(on.unit * w for w in inside(near.omega))
    state = np.array([to_double(x) for x in (*scaled, *inside(near.gamma))])
    orbit: Closed | str
    try:
        orbit = closed(on, state, to_double(period / on.unit), at_level(on, state))
    except NotClosed as why:
        orbit = str(why)
    return Candidate(on, orbit, tuple(start), period)


def proof_of(candidate: Candidate, digits: int, progress: Message | None = None) -> OrbitProof:
    """The first certificate with so many digits that the checker proves; raises NotProved."""
    place = max(digits // 2 + _CENTRE, digits - _FEWER)
    bits = math.ceil(BITS_A_DIGIT * digits) + _SPARE
    why, have = "", 0.0
    for tried in range(_TRIES):
        if progress is not None:
            progress(f"certificate {tried + 1}, {bits} bits")
        part = _STEPS[min(tried, len(_STEPS) - 1)]
        problem, choice = _chosen(candidate, place, Choice(Fraction(1), bits, part))
        certificate = guesses(problem, choice)
        try:
            zero = zero_of(certificate)
        except verify.NotProved as refused:
            why = str(refused)
            if isinstance(candidate.closed, str) or _condition(candidate) > _SINGULAR:
                break
            place, bits = place + 8, bits + 48
            continue
        have, why = _digits_of(candidate, zero), zero.repeated
        if have >= digits or why:
            break
        more = math.ceil(digits - have) + 1
        place, bits = place + more // 2 + 1, bits + math.ceil(BITS_A_DIGIT * more)
    if why or have < digits:
        why = why or f"{have:.1f} digits are proved, not {digits}"
        raise NotProved(f"{candidate.on.scene.name}: {_refusal(candidate, why)}")
    return OrbitProof(zero, certificate, have, tried + 1)


def _chosen(candidate: Candidate, place: int, choice: Choice) -> tuple[Problem, Choice]:
    """The problem with a centre that is right to so many digits, and its box."""
    on = candidate.on
    if isinstance(candidate.closed, str):
        return Problem(on.scene.body, on.h, on.f, candidate.start, candidate.period), _ROUGH
    orbit = candidate.closed
    try:
        fine = newton_shooting.refined(on, orbit, [exactly(x) for x in orbit.state.tolist()], place)
    except NotClosed as fault:
        raise NotProved(f"{candidate.on.scene.name}: {_refusal(candidate, str(fault))}") from None
    start = [Fraction(x) for x in (*fine.omega, *fine.gamma)]
    radius = Fraction(1, 10 ** (place - _BOX))
    problem = Problem(on.scene.body, on.h, on.f, start, Fraction(fine.period))
    return problem, choice._replace(radius=radius)


def _digits_of(candidate: Candidate, zero: verify.Zero) -> float:
    """Proven digits of start and period: the state's in parts of its scale."""
    on, guess = candidate.on, candidate.closed
    assert not isinstance(guess, str)
    scales = [*(on.scale(guess.state) / [*[float(on.unit)] * 3, 1.0, 1.0, 1.0]).tolist()]
    worst = max(float(x.rad()) / scale for x, scale in zip(zero.start, scales, strict=True))
    worst = max(worst, float(zero.period.rad()) / float(zero.period.mid()))
    return -math.log10(worst) if worst else math.inf


def _condition(candidate: Candidate) -> float:
    """Of the ten equations, in double."""
    on, orbit = candidate.on, candidate.closed
    assert not isinstance(orbit, str)
    rows = at_level(on, orbit.state)(orbit.state, orbit.period)[1]
    sizes = np.linalg.svd(bordered(on, orbit.state, orbit.state, orbit.monodromy, rows))[1]
    return float(sizes[0] / sizes[-1]) if sizes[-1] else math.inf


def _refusal(candidate: Candidate, why: str) -> str:
    """What the checker refused, and what may be done about it."""
    if isinstance(candidate.closed, str):
        return f"no periodic orbit is near the start, {candidate.closed}: {why}; try another start"
    condition = _condition(candidate)
    if condition > _SINGULAR:
        return (
            f"the orbit is not isolated, or nearly so: {why}; the ten equations have the condition "
            f"{condition:.1g}, a further multiplier is about 1; try another level"
        )
    times, _, rest = why.removeprefix("the period may be ").partition(" times the least one")
    if not rest and times.isdigit():
        shorter = candidate.closed.period * float(candidate.on.unit) / int(times)
        return f"{why}; try the period {shorter:.10g}"
    return f"{why}; try more digits, or another orbit"
