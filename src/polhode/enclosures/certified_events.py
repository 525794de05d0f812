"""Proven events of a scene: what is known of each, as a result, and of all as facts of another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from polhode.numbers.balls import Ball
from polhode.results.cells import EXACT, INTEGER, TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes.vocabulary import STATE


class EventTime(NamedTuple):
    """A proven event: its time is within ``radius`` of ``time``; slope 1 rising, -1 falling.

    The state then is within ``radii`` of ``state``: p q r [gamma1 gamma2 gamma3] in body axes.
    """

    time: Fraction
    radius: float
    slope: int
    state: tuple[Fraction, ...]
    radii: tuple[float, ...]


@dataclass(frozen=True, repr=False)
class CertifiedEvents(Result):
    """The proven events of one name between 0 and the end, in order away from 0.

    Zeros at 0 and at the end are not among them, as in a run.  ``undecided``: intervals of time in
    which it is not decided whether, or how often, the event happens: a grazing contact, a zero at
    the end, or at 0 if that is not known exactly.  The count is proven if there are no such
    intervals.  Times are in the scene's unit.

    >>> import polhode
    >>> event = polhode.Event("level", "gamma3 - 1/2")
    >>> scene = polhode.Scene(polhode.Body.of_moments((1, 1, 1)), (1, 0, 0), (0, 0, 1),
    ...                       events=(event,))
    >>> polhode.certify_events(scene, end=10)  # cos t = 1/2
    (<CertifiedEvents of level: 3, no others>,)
    """

    name: str
    times: tuple[EventTime, ...]
    undecided: tuple[tuple[float, float], ...]

    @property
    def proven(self) -> bool:
        """Whether there are these events and no others."""
        return not self.undecided

    def table(self) -> Table:
        """One row per event: its time and the state then, as balls, and the slope of the event."""
        count = Column("event", [*range(1, len(self.times) + 1)], type=INTEGER)
        return Table([count, *_columns(self.times)])

    def facts(self) -> list[Fact]:
        """Which event, whether there are no others, and where that is not decided."""
        first, last = [[pair[k] for pair in self.undecided] for k in range(2)]
        undecided = [Column("first", first), Column("last", last)]
        return [
            Fact("event", self.name),
            Fact("proven", self.proven, "whether there are these events and no others"),
            Fact("undecided", Table(undecided, 0), "intervals of time"),
        ]

    def __repr__(self) -> str:
        others = f"{len(self.undecided)} undecided" if self.undecided else "no others"
        return f"<CertifiedEvents of {self.name}: {len(self.times)}, {others}>"


def facts_of(events: Sequence[CertifiedEvents]) -> list[Fact]:
    """Several events as facts of one result: the table of all, and what is not decided."""
    rows = [(x.name, k, time) for x in events for k, time in enumerate(x.times, 1)]
    columns = [
        Column("event", [name for name, _, _ in rows], type=TEXT),
        Column("count", [k for _, k, _ in rows], "with those before", type=INTEGER),
        *_columns([time for _, _, time in rows]),
    ]
    ends = [(x.name, *pair) for x in events for pair in x.undecided]
    undecided = [
        Column("event", [name for name, _, _ in ends], type=TEXT),
        Column("first", [first for _, first, _ in ends]),
        Column("last", [last for _, _, last in ends]),
    ]
    return [
        Fact("events", Table(columns, 2), "of the scene, proven"),
        Fact("events_proven", [x.proven for x in events], "whether there are no others"),
        Fact("events_undecided", Table(undecided, 0), "intervals of time"),
    ]


def _columns(times: Sequence[EventTime]) -> list[Column]:
    width = len(times[0].state) if times else 0
    return [
        Column("t", [Ball(x.time, x.radius) for x in times], "time", type=EXACT),
        Column("slope", [x.slope for x in times], "its sign", type=INTEGER),
        *(
            Column(name, [Ball(x.state[k], x.radii[k]) for x in times], type=EXACT)
            for k, name in enumerate(STATE[:width])
        ),
    ]
