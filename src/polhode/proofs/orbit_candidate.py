"""Candidates of periodic orbits, corrected until one is proved.

Not trusted, but for what ``periodic_orbit.prove`` gives.  Newton's method: the correction is the
one that Krawczyk's test finds, its derivative that of the last enclosure, right to about twelve
digits; each run of the proof makes what is missing so much smaller.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import arb

from polhode.common.progress import Message
from polhode.enclosures import proof_loop
from polhode.enclosures.approximation.precision_choice import BITS_A_DIGIT
from polhode.enclosures.fixed_point_problem import LEAST_FINE, MOST_NOISE, Problem, Refused
from polhode.enclosures.polynomial import midpoint
from polhode.enclosures.proof_loop import Proof, Untrusted
from polhode.motion.outcomes import Outcome
from polhode.numbers.flint_context import ctx
from polhode.proofs.flow_tube import Tube
from polhode.proofs.level import Level
from polhode.proofs.periodic_orbit import Candidate, Follow, Theorem, prove
from polhode.proofs.refusals import NotContracted, Unproved

BOX = 25  # r = 2**(BOX - P)
_SHRINKS = 33  # bits by which a correction makes what is missing smaller, at least
_SPARE = 10
_FIRST = 110  # the noise level of the first run, at most
_MOST_RUNS = 40
_FARTHEST = 1e-3  # a correction that is larger leads elsewhere
_SINGULAR = 1e11  # condition of the ten equations

#: Six components of a state and a period, in the proof's unit of time.
Point = Sequence[Fraction]


class Found(NamedTuple):
    """A theorem, its candidate, the runs of the proof that it took."""

    theorem: Theorem
    candidate: Candidate
    runs: int


def corrected(
    level: Level,
    point: Point,
    digits: int,
    parts: tuple[int, ...],
    untrusted: Untrusted,
    progress: Message | None = None,
) -> Found:
    """The orbit near a point, proved with so many digits of start and period; raises Refused."""
    follow = follower(untrusted)
    goal = min(MOST_NOISE, math.ceil(BITS_A_DIGIT * digits) + _SPARE)
    noise, wide, last = min(goal, _FIRST), 0, math.inf
    for runs in range(1, _MOST_RUNS + 1):
        if progress is not None:
            progress(f"run {runs} of the proof, at a noise level of 2**-{noise}")
        made = candidate(level, point, noise, parts, wide)
        try:
            theorem = prove(level, made, follow)
        except NotContracted as why:
            steps = [midpoint(x) for x in why.tested.newton[:7]]
            size = max(abs(float(x)) for x in steps)
            if not size < min(_FARTHEST, last / 2) or runs == _MOST_RUNS:
                raise Unproved(_cause(why, size)) from None
            point = [x + d for x, d in zip(point, steps, strict=True)]
            # the box is to hold what is left: by the noise level, or by its width
            left = BOX + _SHRINKS - math.ceil(math.log2(size)) if size else goal
            noise = min(goal, max(noise, left))
            last, wide = size, max(0, noise - left)
            continue
        except Unproved:
            raise
        except Refused:
            if noise >= MOST_NOISE or runs == _MOST_RUNS:
                raise
            noise, wide = min(MOST_NOISE, math.ceil(1.25 * noise) + 20), 0
            goal = max(goal, noise)
            continue
        more = {*theorem.open} - {*parts}
        parts = (*parts, *more)
        had = digits_of(theorem)
        # a box about a centre that is off by its own size tells of no neighbourhood
        if had >= digits and not more and theorem.near > 0:
            return Found(theorem, made, runs)
        if had < digits:
            if noise == goal and not wide:
                if goal >= MOST_NOISE:
                    break
                goal += math.ceil(BITS_A_DIGIT * (digits - had)) + 3
            goal = min(MOST_NOISE, goal)
            noise = min(goal, max(noise, BOX - 2 + math.floor(BITS_A_DIGIT * had)))
        point, wide = centre(theorem), 0
    raise Unproved(f"{digits} digits could not be proven in {runs} runs")


def centre(found: Theorem) -> list[Fraction]:
    """The middle of what is proved."""
    return [midpoint(x) for x in (*found.start, found.period)]


def follower(untrusted: Untrusted) -> Follow:
    """A run of the proof that an interrupt ends."""

    def follow(problem: Problem, times: Sequence[arb], watchers: Sequence[Tube]) -> Proof:
        found = proof_loop.run(problem, times, untrusted=untrusted, watchers=watchers)
        if found.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        return found

    return follow


def candidate(
    level: Level, point: Point, noise: int, parts: tuple[int, ...] = (), wide: int = 0
) -> Candidate:
    """The one at a point; its box is 2**wide times as large as the noise level asks."""
    return candidate_of_bits(level, point, noise, noise - BOX - wide, parts)


def candidate_of_bits(
    level: Level, point: Point, noise: int, bits: int, parts: tuple[int, ...] = ()
) -> Candidate:
    """The one at a point with a box of radius 2**-bits."""
    fine = max(noise + 12, LEAST_FINE)
    *start, period = (round(x * (1 << fine)) for x in point)
    state = [arb((x, -fine)) for x in start]
    with ctx.workprec(64):
        known = level.balls(64)
        gradients = [[float(x.mid()) for x in row] for row in known.gradients(state)]
        rates = [float(x.mid()) for x in known.field(state)]
    w = np.array(gradients).T
    return Candidate(noise, tuple(start), period, bits, w, np.array(rates), parts=parts)


def multiple_of(level: Level, found: Found, follow: Follow) -> tuple[int, Theorem] | None:
    """How many times the least period the period is, and the theorem of that; None if not known."""
    times, theorem = 1, found.theorem
    while theorem.open:
        times *= theorem.open[0]
        *start, period = centre(found.theorem)
        point = [*start, period / times]
        made = candidate(level, point, found.candidate.noise, found.candidate.parts)
        try:
            theorem = prove(level, made, follow)
        except Refused:
            return None
    return times, theorem


def digits_of(found: Theorem) -> float:
    """Proven digits of start and period: the state's are absolute, of numbers of about 1."""
    worst = max(float(x.rad()) for x in found.start)
    worst = max(worst, float((found.period.rad() / found.period).abs_upper()))
    return -math.log10(worst) if worst else math.inf


def _cause(why: NotContracted, size: float) -> str:
    if why.condition > _SINGULAR:
        return (
            f"the orbit is not isolated, or nearly so: the ten equations have the condition "
            f"{why.condition:.1g}, a further multiplier is about 1 ({why})"
        )
    if not size < _FARTHEST:
        return f"no periodic orbit is near the start: the first correction is {size:.2g} ({why})"
    return f"the corrections of the start end at {size:.2g} ({why})"
