"""What a proof is asked for: a scene or a box of starts, times and digits, and what they take."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from numbers import Real
from typing import Any, NamedTuple, TypeVar

from polhode.common.arguments import steps, whole
from polhode.common.errors import BadInput
from polhode.common.interrupts import NONE, Deadline, Progress
from polhode.common.values import cached_property
from polhode.enclosures import fixed_point_problem, integral_contraction, proof_loop
from polhode.enclosures.approximation import precision_choice
from polhode.enclosures.approximation.precision_choice import Forecast
from polhode.enclosures.fixed_point_problem import (
    LEAST_NOISE,
    MOST_NOISE,
    Motion,
    Problem,
    Refused,
    motion,
)
from polhode.enclosures.proof_loop import HONEST, SHORT_STEPS, Proof, Watcher
from polhode.numbers import exact
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, sign
from polhode.scenes.scene import Scene
from polhode.scenes.start_box import StartBox

MOST_DIGITS = 250
MAX_STEPS = 300_000
_BEYOND_A_BOX = 8  # digits that the proof has more than the box
_OF_A_BOX = 2  # tries: no precision makes it narrower

Watchers = TypeVar("Watchers", bound=Sequence[Watcher])


class Side(NamedTuple):
    """The times of one sign, in order away from 0 and once each.

    ``places``: of each time that was asked for, where it is among them.
    """

    motion: Motion
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
    progress: Progress | None = None

    @cached_property
    def sides(self) -> list[Side]:
        """The times forward, and those backward, where there are any."""
        found = []
        for backward in (False, True):
            chosen = [n for n, t in enumerate(self.times) if (sign(t) < 0) == backward]
            ordered: list[Exact] = []
            places = {}
            for n in sorted(chosen, key=lambda n: abs(self.times[n])):  # exact, and so compared
                if not ordered or sign(self.times[n] - ordered[-1]) != 0:
                    ordered.append(self.times[n])
                places[n] = len(ordered) - 1
            if ordered:
                what = motion(self.box.scene, backward, radii=self.box.radii)
                found.append(Side(what, ordered, places))
        return found

    @cached_property
    def forecasts(self) -> list[Forecast]:
        """What each side takes, roughly."""
        return [
            precision_choice.forecast(side.motion, side.last, self.digits, self.deadline)
            for side in self.sides
        ]

    @property
    def noise(self) -> int:
        """The noise level to begin with."""
        needed = (math.ceil(found.bits + found.grown) for found in self.forecasts)
        return min(MOST_NOISE, max(LEAST_NOISE, *needed))

    def foretell(self, forecast: Callable[[float], None] | None, dearer: float = 1.0) -> None:
        """Tell about how many seconds a proof takes."""
        if forecast is not None:
            turned = bool({"angles", "attitude"} & {*self.box.scene.modelled})
            noise = self.noise
            forecast(dearer * sum(found.seconds(noise, turned) for found in self.forecasts))

    def raised(self, noise: int, why: Refused, tries: int) -> int | None:
        """The noise level after so many tries, the last one refused; None if more are of no use."""
        if noise == MOST_NOISE or (self.box.radii is not None and tries >= _OF_A_BOX):
            return None
        bits = max(found.bits for found in self.forecasts)
        return min(MOST_NOISE, precision_choice.raised(noise, bits, why))

    def proofs(
        self, noise: int, watch: Callable[[Side, Problem, Sequence[Any]], Watchers]
    ) -> Iterator[tuple[Side, Watchers, Proof]]:
        """Each side's proof at a noise level, until one does not reach its end; raises Refused.

        ``watch``: what looks on, made of the side, its problem and the times as balls.
        """
        for side in self.sides:
            problem = fixed_point_problem.problem(side.motion, noise)
            asked = fixed_point_problem.times(side.motion, side.ordered)
            bits = 2 * problem.fine + 100
            watchers = watch(side, problem, asked)
            proof = proof_loop.run(
                problem,
                asked,
                integral_contraction.prepared(side.motion, bits),
                untrusted=HONEST if self.box.radii is None else SHORT_STEPS,
                progress=self.progress,
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
    max_seconds: float | None,
    progress: Progress | None,
) -> Task:
    """What is asked for, checked; ``key``: of the times.  Raises BadInput."""
    name = box.scene.name
    digits = whole(name, "digits", digits, 1, MOST_DIGITS)
    max_steps = steps(name, max_steps)
    deadline = time_limit(box.scene, max_seconds)
    digits = min(digits, digits_of_box(box))
    found = Task(box, times, digits, deadline, progress)
    for side in found.sides:
        if (needed := precision_choice.steps(side.motion, side.last)) > max_steps:
            expected = f"a time that {max_steps} steps reach; this one takes about {needed:.2g}"
            raise BadInput(name, key, shown(side.last), expected)
    return found


def digits_of_box(box: StartBox) -> int:
    """Digits beyond those that a box leaves of the start."""
    most = max(box.radii or (Fraction(0),))
    if not most:
        return MOST_DIGITS
    mantissa, exponent = exact.rounded(most, 8)
    left = -(exponent + mantissa.bit_length()) / precision_choice.BITS_A_DIGIT
    return min(MOST_DIGITS, max(1, math.ceil(left)) + _BEYOND_A_BOX)


def time_limit(scene: Scene, seconds: float | None) -> Deadline:
    """The deadline so many seconds from now; raises BadInput."""
    if seconds is None:
        return NONE
    if isinstance(seconds, bool) or not isinstance(seconds, Real) or not seconds > 0:
        raise BadInput(scene.name, "max_seconds", seconds, "a number above 0")
    return Deadline.after(float(seconds))
