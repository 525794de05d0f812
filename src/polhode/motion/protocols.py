"""What every method of integration gives: the state at any time of a motion, and its reading."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Protocol

from polhode.motion.outcomes import Outcome
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
