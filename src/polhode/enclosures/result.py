"""A proven enclosure of a motion: balls at the times asked for, and what they cost."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, counted
from polhode.common.interrupts import Progress
from polhode.common.values import ByValue, cached_property
from polhode.enclosures.statement import stated
from polhode.equations.kinematics import starting_attitude
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import to_mpf
from polhode.numbers.decimals import Ball, decimal_ball, guaranteed, shown
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import ordinary
from polhode.numbers.number_types import DOUBLE, Real
from polhode.results.cells import EXACT, INTEGER, TEXT, lines
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, unit_of
from polhode.scenes.vocabulary import COLUMNS, STATE

# --- certified events -----------------------------------------------------------------------------
#
# Proven events of a scene: what is known of each, as a result, and of all as facts of another.


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
        undecided = Table(_intervals(self.undecided), 0)
        return [
            Fact("event", self.name),
            Fact("proven", self.proven, "whether there are these events and no others"),
            Fact("undecided", undecided, "intervals of time"),
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
    names = [x.name for x in events for _ in x.undecided]
    ends = [pair for x in events for pair in x.undecided]
    undecided = [Column("event", names, type=TEXT), *_intervals(ends)]
    return [
        Fact("events", Table(columns, 2), "of the scene, proven"),
        Fact("events_proven", [x.proven for x in events], "whether there are no others"),
        Fact("events_undecided", Table(undecided, 0), "intervals of time"),
    ]


def _intervals(pairs: Sequence[tuple[float, float]]) -> list[Column]:
    return [Column(name, [pair[k] for pair in pairs]) for k, name in enumerate(("first", "last"))]


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


# --- result ---------------------------------------------------------------------------------------


class EnclosedPart(NamedTuple):
    """Angles or quaternions as balls, one row per time; None where an angle is not known.

    ``centres``: exact midpoints, ``radii``: doubles not below the radii, as in :class:`Enclosure`.
    """

    centres: tuple[tuple[Fraction | None, ...], ...]
    radii: tuple[tuple[float, ...], ...]

    @property
    def balls(self) -> list[list[Ball | None]]:
        """Midpoints with their radii."""
        return [
            [None if x is None else Ball(x, r) for x, r in zip(*pair, strict=True)]
            for pair in zip(*self, strict=True)
        ]

    @property
    def digits(self) -> tuple[float, ...]:
        """Proven digits at each time: -log10 of the largest radius, rounded down to a hundredth."""
        return tuple(digits_of(max(row)) for row in self.radii)

    def strings(self) -> list[list[str | None]]:
        """Decimals of which every digit is proven."""
        return [[None if x is None else guaranteed(*x) for x in row] for row in self.balls]

    def midpoints(self, bits: int) -> list[list[Real | None]]:
        """The midpoints as mpf."""
        return [
            [None if x is None else ordinary(to_mpf(x, bits)) for x in row] for row in self.centres
        ]

    def decimals(self) -> list[list[tuple[str, str]]]:
        """Balls as decimals, of what is known at every time: see :meth:`Enclosure.decimals`."""
        return [[decimal_ball(*x) for x in row if x is not None] for row in self.balls]


@dataclass(frozen=True, eq=False, repr=False)
class Enclosure(Result, ByValue):
    """Balls that contain the exact states p q r [gamma1 gamma2 gamma3].

    They are in the scene's body axes and units.  ``centres``: exact midpoints, one row per time;
    ``radii``: rows of doubles not below the balls' radii.
    ``digits``: proven correct digits at each time (-log10 of the larger of the radius of w over the
    largest |w| at the times and the radius of gamma).  ``angles`` (psi theta phi) and ``attitude``
    (q0 q1 q2 q3): if the scene's outputs ask for them, else None; ``derived``: outputs made of
    these, by their words.
    ``outcome``: REACHED_END, or TIME_LIMIT or INTERRUPTED: ``times`` are then those reached.
    ``noise``: the proof's noise level is 2**-noise in its own unit of time.  ``steps`` and
    ``seconds``: of the run that proved it; ``tries``: the number of runs; ``seconds_in_all``:
    CPU time of all of them and of the pilot run.  ``assumed``: what was decided by the rule for
    *equal* of :mod:`polhode.numbers.exact`, and is not proven; empty for rational data.  ``lost``:
    the approximate times, one for each sign of t, from which on psi and phi are None, because the
    third axis is, or passes, too near the vertical for their turns to be followed in double.
    ``omega_radius``: the radii of the start's box, in body axes; None if the start is the scene's
    own.  ``until``: the time to which the proof went, on the side where it ended.  ``events``: the
    scene's, proven too, where they were asked for.

    >>> import polhode
    >>> enclosure = polhode.certify("euler/largest-axis", at=[1], digits=20)
    >>> enclosure
    <Enclosure of euler/largest-axis: 1 time to t = 1, 24.4 digits proven>
    >>> print(enclosure.strings()[0][0])  # p, as far as it is proven
    0.44780868821841484276869
    """

    scene: Scene
    times: tuple[Exact, ...]
    centres: tuple[tuple[Fraction, ...], ...]
    radii: tuple[tuple[float, ...], ...]
    digits: tuple[float, ...]
    asked: int
    noise: int
    steps: int
    seconds: float = field(compare=False)
    tries: int
    seconds_in_all: float = field(compare=False)
    angles: EnclosedPart | None = None
    attitude: EnclosedPart | None = None
    outcome: Outcome = Outcome.REACHED_END
    derived: Mapping[str, EnclosedPart] = field(default_factory=dict)
    assumed: tuple[str, ...] = ()
    lost: tuple[float, ...] = ()
    omega_radius: tuple[Fraction, ...] | None = None
    until: float = math.nan
    events: tuple[CertifiedEvents, ...] | None = None

    @property
    def _states(self) -> EnclosedPart:
        """The balls of the states."""
        return EnclosedPart(self.centres, self.radii)

    @cached_property
    def midpoints(self) -> list[list[Real]]:
        """The midpoints as mpf, exact: rows of six (of three without gamma)."""
        bits = self.noise + 128
        return [[ordinary(to_mpf(x, bits)) for x in row] for row in self.centres]

    @property
    def complete(self) -> bool:
        """Whether the digits asked for are proven at every time, of the angles and attitude too;
        of a box, whether it was followed to the last time."""
        whole = self.fewest >= self.asked or self.omega_radius is not None
        return self.outcome.done and whole

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the proof."""
        return self.outcome is Outcome.INTERRUPTED

    @property
    def proven(self) -> float:
        """The fewest proven digits over all times."""
        return min(self.digits, default=math.inf)

    @property
    def fewest(self) -> float:
        """The fewest proven digits of the state, the angles and the attitude."""
        parts = [part.digits for part in (self.angles, self.attitude) if part is not None]
        return min([self.proven, *(digits_at for digits in parts for digits_at in digits)])

    @property
    def statement(self) -> tuple[str, ...]:
        """What is proven, in words, with all that it rests on; see `polhode guide proofs`."""
        outputs = [word for word in ("angles", "attitude") if getattr(self, word) is not None]
        return stated(
            self.scene, self.times, [*outputs, *self.derived], self.assumed, self.omega_radius
        )

    def table(self) -> Table:
        """A row a time: balls of the state and of outputs, and the digits that are proven."""
        columns = [Column("t", list(self.times), "time", unit_of(self.scene, "t"), digits=17)]
        columns += self._balls(self.scene.columns, self._states)
        parts = {"angles": self.angles, "attitude": self.attitude, **self.derived}
        for word, part in parts.items():
            if part is not None:
                columns += self._balls(COLUMNS[word].names, part)
        return Table([*columns, Column("digits_proven", list(self.digits), digits=4)])

    def _balls(self, names: Sequence[str], part: EnclosedPart) -> list[Column]:
        columns = row_columns(self.scene, names, part.balls, DOUBLE)
        return [column._replace(type=EXACT) for column in columns]

    def facts(self) -> list[Fact]:
        """What is proven, on what it rests, and what it took."""
        box = None if self.omega_radius is None else list(self.omega_radius)
        return [
            *scene_facts(self.scene),
            Fact("digits", self.asked, "proven digits asked for"),
            Fact("digits_proven", self.proven, "of the state, the fewest"),
            Fact("statement", list(self.statement), "what is proven", type=TEXT),
            Fact("assumed", list(self.assumed), "what it rests on besides", type=TEXT),
            Fact("outcome", self.outcome.value, "how the proof ended"),
            Fact("complete", self.complete, "whether the digits asked for are proven"),
            Fact("angles_lost", list(self.lost), "psi and phi are not known from then on"),
            Fact("omega_radius", box, "radii of the start's box"),
            Fact("until", self.until, "to which time the proof went"),
            Fact("noise", self.noise, "the proof's noise level is 2 to minus this"),
            Fact("steps", self.steps),
            Fact("tries", self.tries, "runs of the proof"),
            *(facts_of(self.events) if self.events else ()),
            provenance_fact(self.scene.provenance()),
        ]

    def strings(self) -> list[list[str | None]]:
        """The states as decimals of which every digit is proven; see :func:`guaranteed`."""
        return self._states.strings()

    def decimals(self) -> list[list[tuple[str, str]]]:
        """Balls as decimals: midpoints rounded a little beyond the radius, radii that allow it."""
        return self._states.decimals()

    def save(self, path: str | Path, progress: Progress | None = None) -> None:
        """Write the enclosure, or as .json the certificate that ``polhode verify`` checks.

        Parameters
        ----------
        path : str or Path
            ``.json``: the certificate of the states' balls, checked before it is written.  Other
            endings as of any result; those load again by :func:`polhode.load_result`.
        progress : callable, optional
            Told the part of the certificate's check that is done, and how many steps.

        Raises
        ------
        BadInput
            What has no certificate: irrational times or times of both signs, a scene without
            gamma.
        """
        of_kind("save", "path", path, (str, Path), "the path of a file")
        if Path(path).suffix.lower() not in (".json", ""):  # "-" is stdout
            super().save(path)
            return
        from polhode.certificates import certificate_file, state_certificate

        if self.omega_radius is not None:
            raise BadInput(self.scene.name, "start.omega", None, "numbers, for a certificate")
        turn: Sequence[Exact] = ()
        rows, gamma = self.decimals(), self.scene.gamma
        if self.attitude is not None and gamma is not None:
            turn = starting_attitude(gamma, self.scene.psi)
            rows = [[*x, *y] for x, y in zip(rows, self.attitude.decimals(), strict=True)]
        document = state_certificate.certificate(self.scene, self.times, rows, progress, turn)
        certificate_file.write(path, json.dumps(document))

    def __repr__(self) -> str:
        last = f" to t = {shown(self.times[-1])}" if self.times else ""
        times = f"{counted(len(self.times), 'time')}{last}"
        how = f"{self.proven:.1f} digits proven" if self.outcome.done else self.outcome.value
        return f"<Enclosure of {self.scene.name}: {times}, {how}>"

    def __str__(self) -> str:
        return "\n".join(lines(self.table()))


def digits_of(error: float) -> float:
    """-log10 of an error, rounded down to a hundredth; 0 from 1 on."""
    return max(0.0, math.floor(-100.0 * math.log10(error)) / 100.0) if error < 1 else 0.0
