"""Families of periodic orbits along h or f: what is asked, what is found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, Unpack

import numpy as np

from polhode.common.arguments import cells, each, refuse_unknown, whole, with_options, with_progress
from polhode.common.errors import BadInput, counted, nearest
from polhode.common.interrupts import Message
from polhode.common.values import ByValue
from polhode.dynamics import newton_shooting as newton
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.orbit import (
    ASTRAY,
    DIGITS,
    NearOrbit,
    Orbit,
    completed,
    kind_of,
    orbit,
    orbit_near,
)
from polhode.dynamics.section import section
from polhode.dynamics.starts import MAXIMA, MOST_STARTS, Cut, cut_of, starts_of
from polhode.equations.section_functions import MOMENTUM
from polhode.numbers.conversion import AREA, ENERGY, exactly, reader, to_double
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import DOUBLE, AnyNumber, Doubles
from polhode.results.cells import INTEGER, TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, unit_of
from polhode.scenes.vocabulary import REQUESTS, STATE
from polhode.taylor.variations import NotFollowed

POINTS = 200
LOST = "not followed beyond"
MOST_POINTS = 100_000
_KNOWN = 1e-9  # about the error of a residue in double, times the matrix's size


class FamilyPoint(NamedTuple):
    """An orbit of a family, in double: its level, its period, its residue and a state of it.

    ``state``: p q r gamma1 gamma2 gamma3 in the scene's axes and units.
    """

    h: float
    f: float
    period: float
    residue: float
    state: tuple[float, ...]

    @property
    def kind(self) -> str:
        """elliptic, hyperbolic, inverse hyperbolic or parabolic."""
        return kind_of(self.residue, _KNOWN)


def points_table(scene: Scene, points: Sequence[FamilyPoint]) -> Table:
    """One row per orbit."""
    states = [point.state for point in points]
    return Table(
        [
            Column("orbit", [*range(1, len(points) + 1)], type=INTEGER),
            Column("h", [x.h for x in points], "energy"),
            Column("f", [x.f for x in points], "vertical momentum"),
            Column("period", [x.period for x in points], "", unit_of(scene, "t"), digits=12),
            Column("residue", [x.residue for x in points], "Greene's"),
            Column("kind", [x.kind for x in points], "of its stability", type=TEXT),
            *row_columns(scene, STATE, states, DOUBLE, digits=6),
        ]
    )


class Bifurcation(NamedTuple):
    """Where a residue passes 0 or 1: ``what``: fold, branch point or period doubling.

    Folds are found to ten digits and more; branch points, where two families meet, to about six.
    ``after``: the number of points before it.
    """

    what: str
    point: FamilyPoint
    after: int


@dataclass(frozen=True, repr=False, eq=False)
class OrbitFamily(Result, ByValue):
    """Periodic orbits along a curve on which h (or f) varies and f (or h) is kept fixed.

    ``by``: h or f.  ``points``: from the first orbit on, in double.  ``bifurcations``: in the order
    in which they were passed.  ``ended``: why the family ends there.

    >>> import polhode
    >>> found = polhode.orbit_family("grioli/precession", "h", "0.76")
    >>> found.ended
    'reached h = 19/25'
    >>> [one.what for one in found.bifurcations]
    ['branch point']
    """

    scene: Scene
    by: str
    points: tuple[FamilyPoint, ...]
    bifurcations: tuple[Bifurcation, ...]
    ended: str
    interrupted: bool
    members: tuple[newton.Member, ...]
    surface: LevelBody
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __repr__(self) -> str:
        orbits = counted(len(self.points), "orbit")
        return f"<OrbitFamily of {self.scene.name}: {orbits} along {self.by}, {self.ended}>"

    def table(self) -> Table:
        """One row per orbit, from the first on."""
        return points_table(self.scene, self.points)

    def facts(self) -> list[Fact]:
        """What varies, why the family ends, and its bifurcations."""
        passed = points_table(self.scene, [x.point for x in self.bifurcations])
        bifurcations = [
            Column("what", [x.what for x in self.bifurcations], type=TEXT),
            Column("after", [x.after for x in self.bifurcations], "orbits before", type=INTEGER),
            *passed.columns[1:],
        ]
        return [
            *scene_facts(self.scene),
            Fact("by", self.by, "what varies"),
            Fact("h", self.surface.h, "energy of the first orbit"),
            Fact("f", self.surface.f, "vertical momentum of the first orbit"),
            Fact("ended", self.ended, "why the family ends there"),
            Fact("complete", self.complete, "whether followed as far as asked"),
            Fact("bifurcations", Table(bifurcations, 0)),
            provenance_fact(self.provenance),
        ]

    @property
    def complete(self) -> bool:
        """Whether it was followed as far as it was asked for, or came back."""
        return not self.interrupted and not self.ended.startswith(LOST)

    def orbit(self, k: int, digits: int = DIGITS) -> Orbit:
        """The k-th point's orbit on exactly the level of its doubles, to 300 digits at most."""
        value = exactly(getattr(self.points[k], self.by))
        return completed(self.surface.at(self.by, value), self.members[k].orbit, digits)


@with_options(NearOrbit)
@with_progress
def orbit_family(
    start: Orbit | Scene | str | Path,
    by: str,
    to: AnyNumber,
    *,
    points: int = POINTS,
    **near: Unpack[NearOrbit],
) -> OrbitFamily:
    """Follow a family of periodic orbits from one orbit to another value of h or f.

    It is followed through folds; if it returns to the value at which it began, it ends there.
    Ctrl-C ends it and keeps the orbits found.

    Parameters
    ----------
    start : Orbit, Scene, str or Path
        An orbit, or a scene near one (see :func:`polhode.orbit`).
    by : {"h", "f"}
        What varies, the energy or the vertical momentum; the other one is kept fixed.
    to : number
        The value at which to end.
    points : int
        The largest number of orbits (200).

    Returns
    -------
    OrbitFamily
        A point for each orbit: value, start, period, residue; and how it ended.

    Raises
    ------
    BadInput
        If there is no first orbit, or several families pass through it.

    Examples
    --------
    >>> import polhode
    >>> spun = polhode.top(moments=[2, 1.5, 1], omega=[1, 0, 0], gamma=["4/5", "3/5", 0])
    >>> found = polhode.orbit_family(spun, "h", 4)  # the axis's rotation, twice as fast
    >>> abs(found.points[-1].period - 3.141592653589793) < 1e-13, found.ended
    (True, 'reached h = 4')
    """
    refuse_unknown("orbit_family", orbit_family, near)
    if by not in newton.BY:
        raise BadInput("orbit_family", "by", by, nearest(by, [*newton.BY]))
    progress = near.get("progress")
    if not isinstance(start, Orbit):
        first = orbit(start, **near)
    elif all(x is None or x is progress for x in near.values()):
        first = start
    else:
        raise BadInput(start.name, "start", None, "a scene, whose first orbit is looked for")
    on = first.surface
    name = on.scene.name
    most = whole(name, "points", points, 2, MOST_POINTS)
    unit = ENERGY if by == "h" else AREA
    (end,) = each(name, "to", (to,), reader(on.scene.units, unit), "a number")
    begin = on.h if by == "h" else on.f
    if sign(end - begin) == 0:
        raise BadInput(name, "to", shown(end), f"another {by} than that of the first orbit")
    try:
        arc = newton.Arc(on, first.closed, by)
    except newton.NotClosed as fault:
        expected = f"an orbit of one family ({fault}: its residue is {float(first.residue):.1e})"
        raise BadInput(name, "start", None, expected) from None
    return _followed(on, arc, by, begin, end, most, progress)


def _followed(
    on: LevelBody,
    arc: newton.Arc,
    by: str,
    begin: Exact,
    end: Exact,
    most: int,
    progress: Message | None,
) -> OrbitFamily:
    """The family from the first member towards one value, within both."""
    member, factor = arc.first, _factor(on, by)
    low, high = to_double(begin) / factor, to_double(end) / factor
    if member.slope * (high - low) < 0:
        member = member._replace(tangent=-member.tangent, slope=-member.slope)
    members, special = [member], []
    ended, interrupted, length = f"{most} points", False, newton.FIRST_STEP
    try:
        while len(members) < most:
            ends = (high,) if len(members) == 1 else (low, high)
            step = newton.stepped(arc, member, length, ends)
            targets = [mark for mark in step.passed if mark.what == newton.TARGET]
            for mark in step.passed:
                if mark.what == newton.TARGET:
                    break
                special.append(
                    Bifurcation(mark.what, point_of(on, mark.member.orbit), len(members))
                )
            if targets:
                last, back = targets[0].member, targets[0].member.value
                back = abs(back - low) < abs(back - high)
                value = begin if back else end
                members.append(_exactly_there(on, arc, last, by, value))
                ended = f"{'came back to' if back else 'reached'} {by} = {shown(value)}"
                break
            member, length = step.member, step.length
            members.append(member)
            if progress is not None:
                progress(f"{len(members)} orbits, {by} = {member.value * factor:.6g}")
    except newton.NotClosed as fault:
        ended = f"{LOST} {by} = {member.value * factor:.6g} ({fault})"
    except KeyboardInterrupt:
        ended, interrupted = "interrupted", True
    return OrbitFamily(
        on.scene,
        by,
        tuple(point_of(on, mark.orbit) for mark in members),
        tuple(special),
        ended,
        interrupted,
        tuple(members),
        on,
        on.scene.provenance(),
    )


def _exactly_there(
    on: LevelBody, arc: newton.Arc, last: newton.Member, by: str, value: Exact
) -> newton.Member:
    """The member with just this value: along the arc it is met to a few digits less."""
    level = on.at(by, value)
    try:
        return arc.member(newton.closed(level, last.orbit.state, last.orbit.period), last.tangent)
    except newton.NotClosed:
        return last


def _factor(on: LevelBody, by: str) -> float:
    """What h (or f) over the largest moment is multiplied by to be in the scene's units."""
    return float(on.moments.max()) * float(on.units[newton.BY.index(by)])


def point_of(on: LevelBody, orbit: newton.Closed) -> FamilyPoint:
    """An orbit in the units and axes of its scene."""
    h, f, _ = on.integrals(orbit.state)
    state = on.outside(orbit.state)
    return FamilyPoint(
        float(h) * _factor(on, "h"),
        float(f) * _factor(on, "f"),
        float(orbit.period * float(on.unit)),
        float(orbit.residue),
        tuple(state.tolist()),
    )


# --- search ---------------------------------------------------------------------------------------
#
# Periodic orbits of a level, searched for from the cells of its section.
#
# From every cell's centre an orbit is followed to its first returns to the section of extrema of
# |G|. Where the n-th return comes nearer to its start than from all cells around, Newton's method
# begins. Orbits that cross between cells, or are too unstable to be met, stay unseen: no list is
# complete.


GRID = (20, 20)
CROSSINGS = 3
MOST_CROSSINGS = 100
FARTHEST = 0.5  # scaled: a return farther away than this is none
LOOKS = 400  # along an orbit with which another one is compared
ALIKE = 1e-7  # relative: periods and residues of one orbit


class OrbitGuess(NamedTuple):
    """A start, a time, and the distance at that time."""

    state: Doubles
    time: float
    distance: float


@dataclass(frozen=True, repr=False, eq=False)
class OrbitSearch(Result, ByValue):
    """The periodic orbits that were found on one level, by increasing period.

    The list is not complete.  ``orbits``: each with its period, residue and a state, in double.
    ``guesses``: how many were tried.

    >>> import polhode
    >>> found = polhode.orbit_search("general/asymmetric-regular", (8, 8), crossings=1)
    >>> found
    <OrbitSearch of general/asymmetric-regular: 3 orbits from 3 guesses>
    >>> found.orbit(0, digits=20).kind
    'elliptic'
    """

    scene: Scene
    orbits: tuple[FamilyPoint, ...]
    guesses: int
    interrupted: bool
    closed: tuple[newton.Closed, ...]
    surface: LevelBody
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __repr__(self) -> str:
        orbits = counted(len(self.orbits), "orbit")
        guesses = f"{self.guesses} guess" + "es" * (self.guesses != 1)
        return f"<OrbitSearch of {self.scene.name}: {orbits} from {guesses}>"

    def table(self) -> Table:
        """One row per orbit, by increasing period."""
        return points_table(self.scene, self.orbits)

    def facts(self) -> list[Fact]:
        """The level, and how many guesses were tried."""
        return [
            *scene_facts(self.scene),
            Fact("h", self.surface.h, "energy"),
            Fact("f", self.surface.f, "vertical momentum"),
            Fact("guesses", self.guesses, "that were tried"),
            Fact("complete", not self.interrupted, "whether all guesses were tried"),
            provenance_fact(self.provenance),
        ]

    def orbit(self, k: int, digits: int = DIGITS) -> Orbit:
        """The k-th orbit to ``digits`` digits, at most 300."""
        return completed(self.surface, self.closed[k], digits)


@with_progress
def orbit_search(
    scene: Scene | str | Path,
    grid: tuple[int, int] | None = None,
    crossings: int | None = None,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    progress: Message | None = None,
) -> OrbitSearch:
    """Search a level for periodic orbits; orbits between the cells may be missed.

    Ctrl-C ends it and keeps the orbits found.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    grid : tuple of int, optional
        The cells of the section's coordinates l and L/G (20x20 unless given).
    crossings : int, optional
        The largest number of crossings in a period (3 unless given).
    h, f : number, optional
        The level's energy h or vertical momentum f, if not the scene's.
    progress : callable, optional
        Called with a line of text now and then.

    Returns
    -------
    OrbitSearch
        The orbits found, each once, by increasing period.

    Raises
    ------
    BadInput
        A level that does not exist.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.orbit_search("general/asymmetric-regular", crossings=2)
    >>> sorted({one.kind for one in found.orbits})
    ['elliptic', 'hyperbolic']
    """
    scene = library.load(scene, takes=REQUESTS)
    most = CROSSINGS if crossings is None else crossings
    most = whole(scene.name, "crossings", most, 1, MOST_CROSSINGS)
    across = cells(scene.name, GRID if grid is None else grid, MOST_STARTS)
    cut = cut_of(scene, MOMENTUM, MAXIMA, h, f)
    on = cut.on
    orbits: list[newton.Closed] = []
    tried, interrupted = 0, False
    try:
        for guess in _guesses(cut, across, most):
            tried += 1
            with suppress(newton.NotClosed):
                orbit = orbit_near(on, guess.state, guess.time, ASTRAY * guess.distance)
                if not any(_same(on, orbit, earlier) for earlier in orbits):
                    orbits.append(orbit)
            if progress is not None:
                progress(f"{tried} guesses, {len(orbits)} orbits")
    except KeyboardInterrupt:
        interrupted = True
    orbits.sort(key=lambda orbit: orbit.period)
    points = tuple(point_of(on, x) for x in orbits)
    return OrbitSearch(scene, points, tried, interrupted, tuple(orbits), on, scene.provenance())


def _guesses(cut: Cut, grid: tuple[int, int], most: int) -> Iterator[OrbitGuess]:
    """Starts whose return is nearer than those of the cells around, by rising number of it."""
    on, first = cut.on, starts_of(cut, None, grid)
    crossed = section(on.scene, *cut[1:], None, grid, most, on.h, on.f, workers=1, accuracy=False)
    if crossed.interrupted:
        raise KeyboardInterrupt
    states = on.within(crossed.states)
    for n in range(most):
        off = (states[:, n] - first.states) / on.scale(first.states[0])
        distance = np.where(np.isnan(off).any(axis=1), np.inf, np.sqrt((off**2).sum(axis=1)))
        cells = np.full(grid[0] * grid[1], np.inf)
        np.minimum.at(cells, first.of, distance)
        least = _least_around(cells.reshape(grid)).ravel()
        for k in np.flatnonzero((distance <= least[first.of]) & (distance < FARTHEST)).tolist():
            time = float(crossed.times[k, n]) / float(on.unit)
            yield OrbitGuess(first.states[k], time, float(distance[k]))


def _least_around(cells: Doubles) -> Doubles:
    """The least of each cell and its eight neighbours; the first coordinate is an angle."""
    wide = np.pad(np.pad(cells, ((1, 1), (0, 0)), mode="wrap"), ((0, 0), (1, 1)), mode="edge")
    first, second = cells.shape
    parts = [wide[i : i + first, j : j + second] for i in range(3) for j in range(3)]
    least: Doubles = np.min(parts, axis=0)
    return least


def _same(on: LevelBody, first: newton.Closed, second: newton.Closed) -> bool:
    """Whether a state of one orbit lies on another: mirror images have period and residue alike."""
    alike = abs(first.period - second.period) < ALIKE * second.period
    if not alike or abs(first.residue - second.residue) > ALIKE * np.linalg.norm(second.monodromy):
        return False
    scale = on.scale(second.state)
    try:
        times = np.linspace(0, float(second.period), LOOKS + 1)
        off = (on.plain_flow.along(second.state, times) - first.state) / scale
    except NotFollowed:
        return False
    near = off[int(np.argmin((off**2).sum(axis=1)))]
    flow = on.rates(first.state) / scale
    across = near - (near @ flow) / (flow @ flow) * flow
    return bool(np.linalg.norm(across) < 0.1 * float(second.period) / LOOKS * np.linalg.norm(flow))
