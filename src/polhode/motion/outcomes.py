"""How a run ended, and what events and corrections left behind.  Immutable."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Protocol, SupportsIndex, overload

from polhode.common.errors import counted, nearest
from polhode.common.values import ByValue, may_wait
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import decimal_string, digits_of, in_full
from polhode.numbers.number_types import (
    DOUBLE,
    EXTENDED,
    QUAD,
    Gapped,
    Given,
    NumberType,
    Row,
    Rows,
    States,
)
from polhode.results.cells import DOUBLE as DOUBLE_WORD
from polhode.results.cells import INTEGER
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import row_columns, text_column, time_column
from polhode.scenes.vocabulary import STATE

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


class Outcome(Enum):
    """How a run ended; ``cause`` says what happened and ``advice`` what to do.

    >>> import polhode
    >>> run = polhode.integrate("euler/long", max_steps=100)
    >>> run.outcome, run.outcome.done
    (<Outcome.STEP_LIMIT: 'step limit'>, False)
    >>> run.outcome.cause
    'the end needs more steps than the limit allows'
    """

    REACHED_END = "reached end"
    STOPPED_AT_EVENT = "stopped at event"
    NON_FINITE = "non-finite"
    STEP_UNDERFLOW = "step underflow"
    STEP_LIMIT = "step limit"
    TIME_LIMIT = "time limit"
    SINGULAR = "singular set"
    TOO_FEW_DIGITS = "too few digits"
    INTERRUPTED = "interrupted"
    NOT_RUN = "not run"
    TOO_WIDE = "too wide"

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


#: The outcomes by number, as arrays hold them.
OUTCOMES = tuple(Outcome)
_CODES = {outcome: number for number, outcome in enumerate(OUTCOMES)}


def code(outcome: Outcome) -> int:
    """The number of an outcome among OUTCOMES."""
    return _CODES[outcome]


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
    "time limit": (
        "the end needs more seconds than the limit allows",
        "raise the limit (--max-seconds), or ask for fewer digits or a shorter run",
    ),
    "singular set": (
        "the form of the equations met its singular set",
        "use a form that is regular there, such as principal (--form)",
    ),
    "too few digits": (
        "the end was reached with fewer correct digits than were asked for",
        "ask for fewer digits or a shorter run, and let --digits choose number type and tolerance",
    ),
    "interrupted": ("the run was interrupted", "run again, or ask for a shorter run"),
    "too wide": (
        "the motions from the start's intervals are by then too far apart for one proof of all",
        "give narrower intervals, or earlier times",
    ),
    "not run": ("the sweep was interrupted before this member was done", "run it again"),
}


@may_wait("times")
@dataclass(frozen=True, eq=False, repr=False)
class EventTimes(Result, ByValue):
    """The times of one event of a scene, in order of integration, and the states there.

    ``times``: in the scene's unit, rounded to the run's type.  ``states``: an array as in a
    trajectory, p q r [gamma1 gamma2 gamma3] at the event itself, read-only: on the section to the
    type's precision, even if the time has no digits left for that.  ``signs``: 1 rising, -1
    falling, 0 a contact, of which rounding decides whether it has no zero, one or two; contacts
    are told for every direction.  ``uncertainty``: how far rounding can move each time in this
    motion; the run's own error comes on top.  ``depths``: how far the expression goes beyond zero
    at the extrema beside a crossing, or at the ends of the run, the lesser of both; at a contact,
    how far from zero it is.  Where that is less than the run's error, the exact motion may have
    other events.  ``complete``: whether no crossing was lost, and no pole of the expression passed.

    >>> from dataclasses import replace
    >>> import polhode
    >>> scene = replace(polhode.load("lagrange/nutation"), events=(polhode.Event("nutation"),))
    >>> (found,) = polhode.integrate(scene, at=[10]).events
    >>> len(found.times), round(float(found.times[0]), 12), found.signs[:3]
    (6, 0.46599315847, (1, -1, 1))
    """

    name: str
    times: tuple[Fraction, ...]
    states: States
    signs: tuple[int, ...]
    uncertainty: tuple[float, ...] = ()
    depths: tuple[float, ...] = ()
    complete: bool = True

    @property
    def grazing(self) -> tuple[bool, ...]:
        """Which are contacts."""
        return tuple(sign == 0 for sign in self.signs)

    def __setstate__(self, state: Mapping[str, object]) -> None:
        super().__setstate__(state)
        self.states.flags.writeable = False

    def table(self) -> Table:
        """One row per event."""
        width = self.states.shape[1]
        columns = [Column("event", [*range(1, len(self.times) + 1)], type=INTEGER)]
        return Table([*columns, *_columns(None, STATE[:width], [self], self._number)])

    def facts(self) -> list[Fact]:
        """Which event, and whether all of its times were found."""
        return [
            Fact("name", self.name),
            Fact("complete", self.complete, "whether no crossing was lost, and no pole passed"),
        ]

    @property
    def _number(self) -> NumberType:
        """A type that holds the states: that of the run, or one of as many bits as they have."""
        if self.states.dtype.kind == "f":
            return DOUBLE if self.states.dtype.itemsize == 8 else EXTENDED
        widths = (x._mpf_[3] for row in self.states.tolist() for x in row)
        return NumberType("mp", max(QUAD.bits, *widths, 0))

    def __repr__(self) -> str:
        first = f", the first at t = {self.shown(0)}" if self.times else ""
        return f"<EventTimes of {self.name}: {len(self.times)}{first}>"

    def shown(self, k: int) -> str:
        """The k-th time for people, to as many digits as the run's type has."""
        text = decimal_string(self.times[k], digits_of(self.times))
        return text if "." not in text or "e" in text else text.rstrip("0").rstrip(".")

    def until(self, last: Fraction) -> EventTimes:
        """Those that are not beyond a time."""
        count = bisect_right(self.times, abs(last), key=abs)
        if count == len(self.times):
            return self
        columns = "times", "states", "signs", "uncertainty", "depths"
        return replace(self, **{name: getattr(self, name)[:count] for name in columns})

    @property
    def t(self) -> npt.NDArray[np.float64]:
        """The times as doubles, the nearest ones."""
        import numpy as np

        return np.array([to_double(t) for t in self.times])

    def time_strings(self) -> list[str]:
        """The times, every digit."""
        return [in_full(t) for t in self.times]


class Events(tuple[EventTimes, ...]):
    """The events of a run, by place or by name.

    >>> from dataclasses import replace
    >>> import polhode
    >>> scene = replace(polhode.load("lagrange/nutation"), events=(polhode.Event("nutation"),))
    >>> polhode.integrate(scene, at=[10]).events["nutation"].t.round(6).tolist()[:2]
    [0.465993, 2.316887]
    """

    __slots__ = ()

    @overload
    def __getitem__(self, which: SupportsIndex) -> EventTimes: ...
    @overload
    def __getitem__(self, which: slice) -> tuple[EventTimes, ...]: ...
    @overload
    def __getitem__(self, which: str) -> EventTimes: ...
    def __getitem__(
        self, which: SupportsIndex | slice | str
    ) -> EventTimes | tuple[EventTimes, ...]:
        if not isinstance(which, str):
            return super().__getitem__(which)
        for event in self:
            if event.name == which:
                return event
        raise KeyError(f"{which}: expected {nearest(which, [event.name for event in self])}")

    def table(self, scene: Scene, number_type: NumberType) -> Table:
        """One row per event, of a run of this scene in numbers of a type."""
        names = [event.name for event in self for _ in event.times]
        counts = [k for event in self for k in range(1, len(event.times) + 1)]
        columns = [
            text_column("event", names),
            Column("count", counts, "with those before", type=INTEGER),
        ]
        return Table([*columns, *_columns(scene, scene.columns, self, number_type)], 2)


_SIGN = "1 rising, -1 falling, 0 a contact"
_UNSURE = "how far rounding can move the time"
_DEPTH = "how far the expression goes beyond zero beside it; at a contact, how far from zero it is"


def _columns(
    scene: Scene | None, names: Sequence[str], events: Sequence[EventTimes], number_type: NumberType
) -> list[Column]:
    """Times, signs, uncertainties, depths and states of events, one after the other."""

    def joined(name: str) -> list[Any]:
        return [x for event in events for x in getattr(event, name)]

    return [
        time_column(scene, joined("times"), number_type),
        Column("sign", joined("signs"), _SIGN, type=INTEGER),
        Column("uncertainty", joined("uncertainty"), _UNSURE, type=DOUBLE_WORD, digits=2),
        Column("depth", joined("depths"), _DEPTH, type=DOUBLE_WORD, digits=2),
        *row_columns(scene, names, joined("states"), number_type),
    ]


NO_EVENTS = Events()


@may_wait("onto")
@dataclass(frozen=True, eq=False)
class Projection(ByValue):
    """The corrections that projected a run onto its first integrals.

    ``onto``: the integrals' names.  ``every``: steps between two corrections.  ``count``: how many
    there were.  ``largest`` and ``sum``: of the corrections' lengths, w measured in the run's own
    unit, in which the fastest rate at the start is of order 1.

    >>> import polhode
    >>> found = polhode.integrate("kovalevskaya/generic", at=[1000]).projection
    >>> found.onto, found.every, 1e-16 < found.largest < 1e-12
    (('h', 'f', '|gamma|^2', 'K^2'), 320, True)
    """

    onto: tuple[str, ...]
    every: int
    count: int
    largest: float
    sum: float

    def __str__(self) -> str:
        return (
            f"onto {', '.join(self.onto)} {counted(self.count, 'time')}: largest correction "
            f"{self.largest:.1e}, sum {self.sum:.1e}"
        )


# --- protocols ------------------------------------------------------------------------------------
#
# What every method of integration gives: the state at any time of a motion, and its reading.


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
