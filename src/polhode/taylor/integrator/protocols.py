"""What integrates, what looks for events, what puts the state back: what each asks of the others.

Whoever builds an integrator gives it its watcher and its corrector, and gives the corrector the
watcher; none of the three reaches for one through another.  No heyoka is needed to name them.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple, Protocol

from polhode.motion.outcomes import Outcome, Projection
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Row, Rows
from polhode.taylor.backend.types import (
    CompiledFunction,
    Expression,
    HeyokaEvent,
    HeyokaIntegrator,
    HeyokaNumber,
)


@dataclass(frozen=True)
class Memory:
    """What a correction takes from those before it.

    ``waits``: how often it has stepped aside for an event.  ``rests``: by column, what was rounded
    off, as numbers of heyoka's.
    """

    waits: int = 0
    rests: Mapping[int, HeyokaNumber] = field(default_factory=dict)


class Mark(NamedTuple):
    """Where a chunk began: exact time, state as heyoka's numbers; where to, in how many steps.

    Then the steps taken before, those at which a correction is due, and the corrector's memory.
    """

    offset: Fraction
    state: tuple[HeyokaNumber, ...]
    end: Fraction
    steps: int
    taken: int
    due: int
    memory: Memory


class Piece(Protocol):
    """The motion over some steps: Taylor polynomials, times counted from a chunk's beginning."""

    @property
    def begun(self) -> HeyokaNumber:
        """The time from which it holds, a number of heyoka's."""

    @property
    def bytes(self) -> int:
        """About the memory that it takes."""

    def at(self, time: HeyokaNumber, number: NumberType) -> Row:
        """The state at a time, a number of heyoka's."""


class Integrating(Protocol):
    """What integrates: a system on its way (polhode.taylor.integrator.stepping.Integrator)."""

    @property
    def number(self) -> NumberType:
        """The type of its numbers."""

    @property
    def time(self) -> Fraction:
        """The exact time reached."""

    @property
    def steps(self) -> int:
        """The steps taken."""

    @property
    def marks(self) -> list[Mark]:
        """Where each chunk began."""

    def chunk(self, times: Sequence[Fraction], steps: int) -> tuple[Rows, Outcome]:
        """Take up to so many steps towards the last time; rows at the times passed, how it ended.

        STEP_LIMIT: the steps were taken, and the last time lies ahead.
        """

    def again(self, mark: Mark) -> Sequence[Piece]:
        """The polynomials of a chunk, taken again with the same steps to the bit."""

    def release(self) -> None:
        """Leave the compiled code to the next run of the same equations; the last call of all."""


class Desk:
    """What belongs to an integrator with events, whichever run takes it up: ``watch`` is that of
    the run.

    ``jets``: of each expression, compiled: see :class:`polhode.taylor.events.jets.Jet`.
    """

    def __init__(self) -> None:
        self.watch: Watcher | None = None
        self.jets: list[CompiledFunction] = []


class Watcher(Protocol):
    """What looks for events while a run is under way (polhode.taylor.events.watch.Watch)."""

    @property
    def stop(self) -> Fraction | None:
        """The time of the event that ended the run, in the run's unit; None while none has."""

    @property
    def after_step(self) -> Callable[[HeyokaIntegrator], bool] | None:
        """heyoka's question after each step, go on? None where no event ends the run."""

    @property
    def any_step(self) -> bool:
        """Whether steps may be long: of a state that rests, or of angles, which keep them short."""

    @property
    def key(self) -> Hashable:
        """What tells its events from others along the same equations."""

    @property
    def damping(self) -> Sequence[Fraction]:
        """Numbers that an integrator with its events takes as parameters, one for each."""

    def attach(
        self,
        variables: Sequence[Expression],
        rates: Sequence[Expression],
        known: Sequence[Expression],
    ) -> tuple[list[HeyokaEvent], Desk]:
        """heyoka's events for an integrator about to be built, in its variables; and their desk.

        ``rates``: with the integrator's parameters, which its events share with its equations.
        ``known``: the same rates with the parameters of the desk's functions.
        """

    def sit_down(self, desk: Desk, numbers: Array) -> None:
        """Take over the desk of an integrator's events: what they meet is told to this watcher.

        ``numbers``: the coefficients that are parameters.
        """

    def met(self, k: int, order: int, ta: HeyokaIntegrator, t: HeyokaNumber) -> None:
        """heyoka met a zero of expression k (0) or of its rate (1), at t in the last step."""

    def counts_from(self, offset: Fraction, heyoka: HeyokaIntegrator) -> None:
        """Take note of heyoka's integrator, and of the exact time at which its own begins."""

    def marks(self) -> object:
        """What is known so far, to be given to ``take_back``."""

    def take_back(self, found: object) -> None:
        """Forget what was found since."""

    def still(self) -> list[int]:
        """The events that start at zero and stay within rounding of it for some steps."""

    def disturbed(self, state: Array, moved: Array) -> bool:
        """Whether moving the first components of the state there would disturb an event."""


class Corrector(Protocol):
    """What puts the state back now and then (polhode.taylor.corrections.integral_projection,
    .unit_norm)."""

    @property
    def every(self) -> int:
        """Steps between two corrections."""

    @property
    def seconds(self) -> float:
        """The time spent on compiling."""

    def correct(self, state: Array) -> bool:
        """Correct a state, heyoka's numbers, where it stands; False: try again a step later."""

    def memory(self) -> Memory:
        """What the next correction takes from those before, for ``recall``."""

    def recall(self, memory: Memory) -> None:
        """Stand where another corrector of the same run stood."""

    def found(self) -> Projection:
        """What was corrected so far."""
