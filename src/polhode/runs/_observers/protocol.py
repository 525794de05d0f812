"""What a way is to tell attitude and angles beside a run that integrates the state alone."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple, Protocol

from polhode.common.progress import Progress
from polhode.motion.outcomes import EventTimes, Outcome
from polhode.motion.protocols import CannotSolve, Motion
from polhode.numbers.rows import Rows
from polhode.runs.problem.problem import Problem
from polhode.taylor.backend.time_grid import Times


class CannotObserve(CannotSolve):
    """A motion of which a way cannot tell what is wanted: the next plan is taken."""


class Observed(NamedTuple):
    """What a motion came to: its rows, how it ended, the time reached, the events up to there.

    Before a way has seen them, rows of the state at the way's times; then, at the outputs, what is
    integrated beside the state, too.
    """

    rows: Rows
    outcome: Outcome
    reached: Fraction
    events: tuple[EventTimes, ...]


class Way(Protocol):
    """A way as it was planned for a problem and its output times; immutable, and kept with them."""

    @property
    def times(self) -> Times:
        """At which the state is needed: the outputs' times, and its own."""

    @property
    def share(self) -> float:
        """The part of the whole time that the plain run takes."""

    def observe(
        self, problem: Problem, motion: Motion, found: Observed, progress: Progress | None
    ) -> Observed:
        """What the way makes of a plain run that has ended; raises CannotObserve.

        ``progress`` goes on from the plain run's share.
        """
