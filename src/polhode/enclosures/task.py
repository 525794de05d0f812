"""What a proof is asked for: a scene or a box of starts, times and digits, and what they take."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from numbers import Real
from typing import Any, NamedTuple, Protocol, TypedDict, TypeVar

import numpy as np
from flint import arb

from polhode.common.arguments import steps, whole
from polhode.common.errors import BadInput, TooManySteps
from polhode.common.interrupts import NONE, Deadline, Progress, TooLong
from polhode.common.values import cached_property
from polhode.enclosures import (
    approximation,
    fixed_point_problem,
    integral_contraction,
    step_bound,
    taylor_polynomials,
    zonotope,
)
from polhode.enclosures.approximation import Forecast
from polhode.enclosures.fixed_point_problem import (
    CLOCK,
    LEAST_NOISE,
    MOST_NOISE,
    TIME_BITS,
    ExactMotion,
    Problem,
    TooImprecise,
    motion,
)
from polhode.enclosures.zonotope import ProofState
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.scenes.library import StartBox
from polhode.scenes.scene import Scene

# --- proof loop -----------------------------------------------------------------------------------
#
# One run of a proof: windows of steps are approximated, corrected, bounded, and carried on.
#
# Nothing here is believed: a state and balls come only out of ``zonotope.advance``.


_LOST = -34  # a correction above 2**_LOST: the approximation has lost the motion
_FEWEST, _FIRST, _WIDEST = 4, 32, 128
_MOST_ROUNDS = 60


@dataclass(frozen=True)
class Untrusted:
    """The parts that may be wrong in any way; tests put faulty ones in their place.

    They may write into all that they are given, copies or what nobody else uses, and into what they
    have returned, which is copied.
    """

    window: Callable[..., Any] = approximation.window
    matrices: Callable[..., Any] = approximation.matrices
    correction: Callable[..., Any] = approximation.correction


HONEST = Untrusted()
#: For boxes: exp(int |A|) of a step multiplies the errors of V.
SHORT_STEPS = Untrusted(window=partial(approximation.window, turn=0.5))


class Watcher(Protocol):
    """Something that looks at the windows of a proof as they are accepted."""

    def window(self, bounds: step_bound.Bounds, steps: Sequence[zonotope.Step]) -> None:
        """A window whose steps have been accepted."""


@dataclass(frozen=True)
class Proof:
    """Balls at the times asked for, in the principal axes and the proof's unit, and its cost.

    ``outcome``: REACHED_END; TIME_LIMIT, INTERRUPTED or TOO_WIDE where the rows are those up to
    ``end``.
    """

    rows: list[list[arb]]
    steps: int
    end: ProofState
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
    """Balls around the states at times >= 0, increasing, given as balls.  Raises TooImprecise.

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
                    raise TooImprecise("the approximation loses the motion")
                wide = max(_FEWEST, wide // 2)
                continue
            times_inside = zonotope.inside(times[len(rows) :], tried.pieces.times[-1])
            before = state.time
            try:
                state, balls, accepted = zonotope.advance(state, tried, times_inside, deadline)
            except TooImprecise:
                if problem.is_box and wide > _FEWEST:  # as far as a box can be followed
                    wide = _FEWEST
                    continue
                raise
            rows += balls
            for watcher in watchers:
                watcher.window(tried, accepted)
            steps += len(accepted)
            pace = math.ldexp(state.time - before, -CLOCK) / len(accepted)
            state = integral_contraction.shrunk(problem, state, integrals)
            whole, wide = state, min(most, 2 * wide)
            if progress is not None:
                progress(state.time / end, steps)
    except TooImprecise as why:
        if problem.is_box and whole.time > 0:
            outcome = Outcome.TOO_WIDE
        else:
            grown = math.log2(max(1.0, float(np.max(whole.radii))))
            raise TooImprecise(str(why), whole.time / end, grown) from why
    except TooLong:
        outcome = Outcome.TIME_LIMIT
    except KeyboardInterrupt:
        outcome = Outcome.INTERRUPTED
    return Proof(rows, steps, whole, outcome)


def _window(
    problem: Problem,
    state: ProofState,
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
    guess = untrusted.window(problem, replace(state, columns=state.columns.copy()), end, wide, pace)
    if guess is None:
        return None
    shape = taylor_polynomials.of_doubles(guess.times, guess.series)
    a = step_bound.jacobian(problem, shape.near, shape.lengths)
    v = untrusted.matrices(a)
    last = 10**6
    for _ in range(_MOST_ROUNDS):
        deadline.check()
        exact_defects = taylor_polynomials.defects(problem, shape)
        gaps = taylor_polynomials.gaps(problem, shape, state.centre)
        e = untrusted.correction(a, exact_defects.values.copy(), v, gaps)
        size = taylor_polynomials.size(e, problem.noise)
        if size > _LOST or size >= last:
            return None
        # its square and its rounding are noise
        if max(2 * size, size - 40) <= -problem.noise:
            step_bound.check_arithmetic()
            return step_bound.bounds(problem, exact_defects, e, v)
        shape = taylor_polynomials.improved(shape, e, problem.noise, 53 - size)
        last = size
    raise TooImprecise("the corrections do not converge")


def _last_tick(times: Sequence[arb]) -> int:
    """The first point of the grid that is not before the last time."""
    if not times:
        return 0
    with ctx.workprec(TIME_BITS):
        last = (times[-1] * arb((1, CLOCK))).upper().ceil().unique_fmpz()
    if last is None or last >= 1 << 60:
        raise TooImprecise("the last time is too far away")
    return max(1, int(last))


# --- task -----------------------------------------------------------------------------------------


MOST_DIGITS = 250
MAX_STEPS = 300_000
_BEYOND_A_BOX = 8  # digits that the proof has more than the box
_OF_A_BOX = 2  # tries: no precision makes it narrower

Watchers = TypeVar("Watchers", bound=Sequence[Watcher])


class ProofOptions(TypedDict, total=False):
    """How a motion is enclosed: options of :func:`certify` and :func:`certify_events`.

    Parameters
    ----------
    progress : callable, optional
        Called with the fraction of the time done and the steps taken.
    max_seconds : float, optional
        A limit on the time by the clock; what is proven until then is kept, as after Ctrl-C, and
        the ``outcome`` says so; events after the time that was reached are undecided.
    forecast : callable, optional
        Called once, before the proof, with a rough estimate of its seconds.
    omega_radius : number or three numbers, optional
        The balls then hold every motion whose omega at the start differs from the scene's by at
        most this, in each component in body axes, and each event is one of all of them.  As many
        digits are proven as the box allows, ``digits`` at most; it is followed as far as possible,
        and the ``outcome`` says so.
    """

    progress: Progress | None
    max_seconds: float | None
    forecast: Callable[[float], None] | None
    omega_radius: AnyNumber | AnyVector | None


class Side(NamedTuple):
    """The times of one sign, in order away from 0 and once each.

    ``places``: of each time that was asked for, where it is among them.
    """

    motion: ExactMotion
    ordered: list[Exact]
    places: dict[int, int]

    @property
    def last(self) -> Exact:
        """The time farthest from 0."""
        return self.ordered[-1]


@dataclass(frozen=True)
class Task:
    """A box of starts, the times and digits asked for, and limits."""

    box: StartBox
    times: Sequence[Exact]
    digits: int
    deadline: Deadline = NONE
    how: ProofOptions = field(default_factory=ProofOptions)

    @cached_property
    def sides(self) -> list[Side]:
        """The times forward, and those backward, where there are any."""
        sides = []
        for backward in (False, True):
            chosen = [n for n, t in enumerate(self.times) if (sign(t) < 0) == backward]
            ordered: list[Exact] = []
            places = {}
            for n in sorted(chosen, key=lambda n: abs(self.times[n])):  # exact, and so compared
                if not ordered or sign(self.times[n] - ordered[-1]) != 0:
                    ordered.append(self.times[n])
                places[n] = len(ordered) - 1
            if ordered:
                exact_motion = motion(self.box.scene, backward, radii=self.box.radii)
                sides.append(Side(exact_motion, ordered, places))
        return sides

    @cached_property
    def forecasts(self) -> list[Forecast]:
        """What each side takes, roughly."""
        return [approximation.forecast(side.motion, side.last, self.digits) for side in self.sides]

    @property
    def noise(self) -> int:
        """The noise level to begin with."""
        needed = (math.ceil(forecast.bits + forecast.grown) for forecast in self.forecasts)
        return min(MOST_NOISE, max(LEAST_NOISE, *needed))

    def foretell(self, dearer: float = 1.0) -> None:
        """Tell about how many seconds a proof takes, where that is asked."""
        if (forecast := self.how.get("forecast")) is not None:
            noise, outputs = self.noise, bool(self.box.scene.modelled)
            forecast(dearer * sum(row.seconds(noise, outputs) for row in self.forecasts))

    def raised(self, noise: int, why: TooImprecise, tries: int) -> int | None:
        """The noise level after so many tries, the last one refused; None if more are of no use."""
        if noise == MOST_NOISE or (self.box.radii is not None and tries >= _OF_A_BOX):
            return None
        bits = max(forecast.bits for forecast in self.forecasts)
        return min(MOST_NOISE, approximation.raised(noise, bits, why))

    def proofs(
        self, noise: int, watch: Callable[[Side, Problem, Sequence[Any]], Watchers]
    ) -> Iterator[tuple[Side, Watchers, Proof]]:
        """Each side's proof at a noise level, until one does not reach its end.

        Raises TooImprecise.

        ``watch``: what looks on, made of the side, its problem and the times as balls.
        """
        for side in self.sides:
            problem = fixed_point_problem.problem(side.motion, noise)
            times = fixed_point_problem.times(side.motion, side.ordered)
            bits = 2 * problem.fine + 100
            watchers = watch(side, problem, times)
            proof = run(
                problem,
                times,
                integral_contraction.prepared(side.motion, bits),
                untrusted=HONEST if self.box.radii is None else SHORT_STEPS,
                progress=self.how.get("progress"),
                watchers=watchers,
                deadline=self.deadline,
            )
            yield side, watchers, proof
            if not proof.outcome.done:
                return


def task(
    box: StartBox,
    key: str,
    times: Sequence[Exact],
    digits: int,
    max_steps: int,
    how: ProofOptions,
) -> Task:
    """What is asked for, checked; ``key``: of the times.  Raises BadInput."""
    name = box.scene.name
    digits = whole(name, "digits", digits, 1, MOST_DIGITS)
    max_steps = steps(name, max_steps)
    deadline = time_limit(box.scene, how.get("max_seconds"))
    job = Task(box, times, min(digits, digits_of_box(box)), deadline, how)
    for side in job.sides:
        if (needed := approximation.steps(side.motion, side.last)) > max_steps:
            expected = f"a time that {max_steps} steps reach; this one takes about {needed:.2g}"
            raise TooManySteps(name, key, shown(side.last), expected)
    return job


def digits_of_box(box: StartBox) -> int:
    """Digits beyond those that a box leaves of the start."""
    most = max(box.radii or (Fraction(0),))
    if not most:
        return MOST_DIGITS
    mantissa, exponent = exact.rounded(most, 8)
    left = -(exponent + mantissa.bit_length()) / approximation.BITS_A_DIGIT
    return min(MOST_DIGITS, max(1, math.ceil(left)) + _BEYOND_A_BOX)


def time_limit(scene: Scene, seconds: float | None) -> Deadline:
    """The deadline so many seconds from now; raises BadInput."""
    if seconds is None:
        return NONE
    if isinstance(seconds, bool) or not isinstance(seconds, Real) or not seconds > 0:
        raise BadInput(scene.name, "max_seconds", seconds, "a number above 0")
    return Deadline.after(float(seconds))
