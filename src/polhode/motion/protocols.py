"""What every method of integration gives: a problem on its way, and the state at any time of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Protocol

from polhode.common.progress import Progress
from polhode.motion.outcomes import EventTimes, Outcome, Projection
from polhode.numbers.rows import Gapped, Given, Row, Rows


class CannotSolve(Exception):
    """What was tried does not serve here, and the next method is; the message says why."""


class RowReader(Protocol):
    """Reads a motion's rows."""

    def states(self, rows: Given) -> Rows:
        """p q r [gamma1 gamma2 gamma3] in the scene's axes and units."""

    def attitude(self, rows: Given, states: Rows) -> Rows | None:
        """q0 q1 q2 q3, where it is integrated."""

    def angles(self, rows: Given, states: Rows) -> Gapped | None:
        """psi theta phi, likewise; psi and phi None at a pole."""


class Interpolant(Protocol):
    """A motion at any time that it reached."""

    @property
    def read(self) -> RowReader:
        """What reads its rows."""

    def at(self, times: Sequence[Fraction]) -> tuple[Sequence[Row], Outcome, Fraction]:
        """Rows at exact times in the scene's unit, in the order in which they are reached.

        As many as are reached; how the motion ended, and the time come to.
        """


class Motion(Interpolant, Protocol):
    """A problem being solved by one method, once, from its start on.

    ``steps``: those taken.  ``reached``: the exact time come to, in the scene's unit.  ``events``:
    what the motion itself was watched for.  ``errors``: one a row, where the method estimates
    them.  ``build_seconds``: the time that compiling took.  ``remarks``: for the provenance.
    """

    method: str
    steps: int
    reached: Fraction
    events: tuple[EventTimes, ...]
    projection: Projection | None
    errors: tuple[float | None, ...] | None
    build_seconds: float
    remarks: Mapping[str, str]

    def advance(
        self, times: Sequence[Fraction], progress: Progress | None = None
    ) -> tuple[Rows, Outcome]:
        """Rows at the times, in the run's own unit, as far as they were reached; the outcome.

        A row: the form's variables, then what is integrated with them.
        """
