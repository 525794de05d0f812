"""One run of a proof: windows of steps are approximated, corrected, bounded, and carried on.

Nothing here is believed: a state and balls come only out of ``zonotope.advance``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol

import numpy as np
from flint import arb

from polhode.common.interrupts import NONE, Deadline, Progress, TooLong
from polhode.enclosures import (
    defect,
    integral_contraction,
    step_bound,
    taylor_polynomials,
    zonotope,
)
from polhode.enclosures.approximation import newton_correction, window_approximation
from polhode.enclosures.fixed_point_problem import CLOCK, TIME_BITS, Problem, Refused
from polhode.enclosures.zonotope import State
from polhode.motion.outcomes import Outcome
from polhode.numbers.flint_context import ctx

_LOST = -34  # a correction above 2**_LOST: the approximation has lost the motion
_FEWEST, _FIRST, _WIDEST = 4, 32, 128
_MOST_ROUNDS = 60


@dataclass(frozen=True)
class Untrusted:
    """The parts that may be wrong in any way; tests put faulty ones in their place.

    They may write into all that they are given, copies or what nobody else uses, and into what they
    have returned, which is copied.
    """

    window: Callable[..., Any] = window_approximation.window
    matrices: Callable[..., Any] = newton_correction.matrices
    correction: Callable[..., Any] = newton_correction.correction


HONEST = Untrusted()
#: For boxes: exp(int |A|) of a step multiplies the errors of V.
SHORT_STEPS = Untrusted(window=partial(window_approximation.window, turn=0.5))


class Watcher(Protocol):
    """Something that looks at the windows of a proof as they are accepted."""

    def window(self, known: step_bound.Bounds, steps: Sequence[zonotope.Step]) -> None:
        """A window whose steps have been accepted."""


@dataclass(frozen=True)
class Proof:
    """Balls at the times asked for, in the principal axes and the proof's unit, and its cost.

    ``outcome``: REACHED_END; TIME_LIMIT, INTERRUPTED or TOO_WIDE where the rows are those up to
    ``end``.
    """

    rows: list[list[arb]]
    steps: int
    end: State
    outcome: Outcome = Outcome.REACHED_END


def run(
    problem: Problem,
    times: Sequence[arb],
    integrals: Sequence[integral_contraction.Integral] = (),
    untrusted: Untrusted = HONEST,
    progress: Progress | None = None,
    watchers: Sequence[Watcher] = (),
    deadline: Deadline = NONE,
) -> Proof:
    """Balls around the states at times >= 0, increasing, given as balls.  Raises Refused.

    What is proven until the ``deadline``, or until Ctrl-C, is kept.  ``watchers``: what looks for
    zeros on the way, or follows the attitude; they may raise TooLong.

    Where the start is a box, the proof ends where the set has grown too large, too.
    """
    step_bound.check_arithmetic()
    state = zonotope.beginning(problem)
    rows: list[list[arb]] = []
    end = _last_tick(times)
    most = _WIDEST if problem.noise <= 150 else 48
    wide, pace, steps = _FIRST, 0.1, 0
    whole, outcome = state, Outcome.REACHED_END  # the watchers have seen all up to there
    try:
        while state.time < end:
            tried = _window(problem, state, end, wide, pace, untrusted, deadline)
            if tried is None:
                if wide <= _FEWEST:
                    raise Refused("the approximation loses the motion")
                wide = max(_FEWEST, wide // 2)
                continue
            asked = zonotope.inside(times[len(rows) :], tried.pieces.times[-1])
            before = state.time
            try:
                state, found, taken = zonotope.advance(state, tried, asked, deadline)
            except Refused:
                if problem.is_box and wide > _FEWEST:  # as far as a box can be followed
                    wide = _FEWEST
                    continue
                raise
            rows += found
            for watcher in watchers:
                watcher.window(tried, taken)
            steps += len(taken)
            pace = math.ldexp(state.time - before, -CLOCK) / len(taken)
            state = integral_contraction.shrunk(problem, state, integrals)
            whole, wide = state, min(most, 2 * wide)
            if progress is not None:
                progress(state.time / end, steps)
    except Refused as why:
        if problem.is_box and whole.time > 0:
            outcome = Outcome.TOO_WIDE
        else:
            grown = math.log2(max(1.0, float(np.max(whole.radii))))
            raise Refused(str(why), whole.time / end, grown) from why
    except TooLong:
        outcome = Outcome.TIME_LIMIT
    except KeyboardInterrupt:
        outcome = Outcome.INTERRUPTED
    return Proof(rows, steps, whole, outcome)


def _window(
    problem: Problem,
    state: State,
    end: int,
    wide: int,
    pace: float,
    untrusted: Untrusted,
    deadline: Deadline = NONE,
) -> step_bound.Bounds | None:
    """A window, corrected as far as the noise level asks; None where the motion is lost.

    Raises TooLong at the deadline.
    """
    deadline.check()
    found = untrusted.window(problem, replace(state, columns=state.columns.copy()), end, wide, pace)
    if found is None:
        return None
    shape = taylor_polynomials.of_doubles(found.times, found.series)
    a = step_bound.jacobian(problem, shape.near, shape.lengths)
    v = untrusted.matrices(a)
    last = 10**6
    for _ in range(_MOST_ROUNDS):
        deadline.check()
        known = defect.defects(problem, shape)
        gaps = defect.gaps(problem, shape, state.centre)
        e = untrusted.correction(a, known.values.copy(), v, gaps)
        size = taylor_polynomials.size(e, problem.noise)
        if size > _LOST or size >= last:
            return None
        # its square and its rounding are noise
        if max(2 * size, size - 40) <= -problem.noise:
            step_bound.check_arithmetic()
            return step_bound.bounds(problem, known, e, v)
        shape = taylor_polynomials.improved(shape, e, problem.noise, 53 - size)
        last = size
    raise Refused("the corrections do not converge")


def _last_tick(times: Sequence[arb]) -> int:
    """The first point of the grid that is not before the last time."""
    if not times:
        return 0
    with ctx.workprec(TIME_BITS):
        last = (times[-1] * arb((1, CLOCK))).upper().ceil().unique_fmpz()
    if last is None or last >= 1 << 60:
        raise Refused("the last time is too far away")
    return max(1, int(last))
