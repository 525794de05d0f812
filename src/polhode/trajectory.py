"""What a run gives back: times, states, outcome.  Immutable."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from fractions import Fraction
from functools import cached_property
from typing import Any

from polhode.forms import equations
from polhode.hodographs import Hodographs, hodographs
from polhode.integrals import Drift, drift
from polhode.precision import NumberType, decimal_in_full, decimal_string, exactly
from polhode.scene import Scene


class Outcome(Enum):
    """How a run ended; ``cause`` says what happened and ``advice`` what to do."""

    REACHED_END = "reached end"
    STOPPED_AT_EVENT = "stopped at event"
    NON_FINITE = "non-finite"
    STEP_UNDERFLOW = "step underflow"
    STEP_LIMIT = "step limit"
    SINGULAR = "singular set"
    INTERRUPTED = "interrupted"
    NOT_RUN = "not run"

    @property
    def cause(self) -> str:
        """What happened."""
        return _CAUSES[self.value][0]

    @property
    def advice(self) -> str:
        """What to do about it."""
        return _CAUSES[self.value][1]

    @property
    def done(self) -> bool:
        """Whether the run did what was asked of it."""
        return self in (Outcome.REACHED_END, Outcome.STOPPED_AT_EVENT)


_CAUSES = {
    "reached end": ("all output times were reached", ""),
    "stopped at event": ("an event that stops the run was met", ""),
    "non-finite": (
        "a state or a step became infinite or undefined",
        "ask for fewer outputs (angles are singular at theta = 0 and pi), for events that stay "
        "finite, or for a shorter run",
    ),
    "step underflow": (
        "the step became too short to change the time",
        "use a number type with more digits (--digits), or a shorter run",
    ),
    "step limit": (
        "the end needs more steps than the limit allows",
        "raise the limit (--max-steps), loosen --tol, or ask for a shorter run",
    ),
    "singular set": (
        "the form of the equations met its singular set",
        "use a form without one there, such as principal (--form)",
    ),
    "interrupted": ("the run was interrupted", "run again, or ask for a shorter run"),
    "not run": ("the sweep was interrupted before this member was done", "run it again"),
}


@dataclass(frozen=True)
class EventTimes:
    """When one event of a scene happened, in order of integration, and the states then.

    ``times``: rounded to the run's type.  ``states``: rows as in a trajectory, taken at the event
    itself: on the section to the type's precision, even where the time has no digits left for it.
    ``grazing``: whether rounding decides if there is a zero at all, or two.  ``complete``: whether
    rising and falling zeros alternate, as they do unless one was lost or a pole was passed.
    """

    name: str
    times: tuple[Fraction, ...]
    states: Any
    grazing: tuple[bool, ...]
    complete: bool = True

    def time_strings(self) -> list[str]:
        """The times, every digit."""
        return [decimal_in_full(t) for t in self.times]


@dataclass(frozen=True)
class Projection:
    """What putting a run back on its first integrals took.

    ``onto``: the integrals' names.  ``every``: steps between two corrections.  ``largest`` and
    ``sum``: of the corrections' lengths, w measured in the run's own unit, in which the fastest
    rate at the start is of order 1.
    """

    onto: tuple[str, ...]
    every: int
    count: int
    largest: float
    sum: float

    def __str__(self) -> str:
        return (
            f"onto {', '.join(self.onto)} {self.count} times: largest correction "
            f"{self.largest:.1e}, sum {self.sum:.1e}"
        )


@dataclass(frozen=True)
class Trajectory:
    """States of a scene at its output times, in body axes, as numbers of one type.

    ``times``: exact values of the times at which the states hold (already rounded to the type).
    ``states``: shape (len(times), 3 or 6), p q r [gamma1 gamma2 gamma3]: an ndarray for double and
    extended, rows of mpf above.  ``attitude``: there where hodographs were asked for, too.
    ``steps``: Taylor steps taken.  ``events``: one for each event of the scene.  ``projection``:
    None where the state was not put back on the first integrals.
    """

    scene: Scene
    number: NumberType
    times: tuple[Fraction, ...]
    states: Any
    outcome: Outcome
    steps: int
    reached: Fraction
    tolerance: float
    digits: int | None = None
    attitude: Any = None
    angles: Any = None
    events: tuple[EventTimes, ...] = ()
    projection: Projection | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    dense: Callable[[Any], Any] | None = field(default=None, repr=False, compare=False)

    def __call__(self, t: Any) -> Any:
        """The state at time t, or the states at several times, see :class:`polhode.dense.Dense`.

        Raises BadInput (a ValueError) for a time that the run did not reach.
        """
        if self.dense is None:
            raise ValueError("states at the output times only: nothing was integrated here")
        return self.dense(t)

    @cached_property
    def drift(self) -> Drift:
        """Largest drift of the first integrals from the exact scene's values.

        No evidence of accuracy where they were projected: then see ``projection``.
        """
        if not self.times:
            return Drift(None, None, None)
        return drift(self.scene, self.states, self.number.bits)

    @cached_property
    def hodographs(self) -> Hodographs | None:
        """omega in the body and in space, if asked for."""
        if "hodographs" not in self.scene.outputs:
            return None
        return hodographs(self.states, self.attitude, self.number)

    @property
    def cause(self) -> str:
        """Why the run ended."""
        if self.outcome is Outcome.SINGULAR:
            return f"the form {self.scene.form} met its singular set"
        return self.outcome.cause

    @property
    def advice(self) -> str:
        """What to do about it; empty where the run did what was asked."""
        if self.outcome is Outcome.SINGULAR:
            return f"use --form {equations(self.scene).instead}"
        return self.outcome.advice

    @property
    def projected(self) -> bool:
        """Whether the state was ever put back on the integrals: their drift then says nothing."""
        found = self.projection
        return found is not None and found.count > 0 and "h" in found.onto

    @property
    def at_full_tolerance(self) -> bool:
        """Whether the steps were made at the type's own eps."""
        return self.tolerance <= float(self.number.eps)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the state's columns."""
        return self.scene.columns

    def time_strings(self) -> list[str]:
        """The times, every digit."""
        return [decimal_in_full(t) for t in self.times]

    def state_strings(self) -> list[list[str]]:
        """The states as decimal strings that round-trip."""
        return strings(self.states, self.number)


def strings(rows: Any, number: NumberType) -> list[list[str]]:
    """Rows of numbers of one type as decimal strings that round-trip; None stays None."""
    if number.name == "double":
        return [[_double_string(float(x)) for x in row] for row in rows]
    digits = number.printed_digits
    return [
        [None if x is None else decimal_string(exactly(x), digits) for x in row]  # type: ignore[misc]
        for row in rows
    ]


def _double_string(x: float) -> str:
    return f"{x:#.17g}" if x else "0"
