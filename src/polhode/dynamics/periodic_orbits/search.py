"""Periodic orbits of a level, searched for from the cells of its section.

From every cell's centre an orbit is followed to its first returns to the section of extrema of |G|.
Where the n-th return comes nearer to its start than from all cells around, Newton's method begins.
Orbits that cross between cells, or are too unstable to be met, stay unseen: no list is complete.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polhode.common.arguments import cells, whole
from polhode.common.errors import BadInput, counted
from polhode.common.interrupts import Message
from polhode.common.values import ByValue
from polhode.dynamics.periodic_orbits.families import FamilyPoint, point_of, points_table
from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.dynamics.periodic_orbits.newton_shooting import Closed, NotClosed, at_level, closed
from polhode.dynamics.periodic_orbits.orbit import (
    ASTRAY,
    DIGITS,
    Orbit,
    completed,
    moved_from,
    primitive,
)
from polhode.dynamics.sections import coordinates as geometry
from polhode.dynamics.sections.section import section
from polhode.dynamics.sections.starts import MAXIMA, MOST_STARTS, asked_of, starts_of
from polhode.equations.section_functions import MOMENTUM
from polhode.numbers.conversion import exactly
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import AnyNumber
from polhode.results.result import Result
from polhode.results.table import Fact, Table
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts
from polhode.scenes.vocabulary import REQUESTS
from polhode.taylor.variations import NotFollowed

GRID = (20, 20)
CROSSINGS = 3
MOST_CROSSINGS = 100
FARTHEST = 0.5  # scaled: a return farther away than this is none
LOOKS = 400  # along an orbit with which another one is compared
ALIKE = 1e-7  # relative: periods and residues of one orbit


class Guess(NamedTuple):
    """A start, a time, the distance at that time, and after how many crossings."""

    state: Doubles
    time: float
    distance: float
    crossings: int


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
    closed: tuple[Closed, ...]
    surface: Surface
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
        """The k-th orbit to ``digits`` digits."""
        known = self.closed[k]
        anchor = [exactly(x) for x in known.state.tolist()]
        return completed(self.surface, known, anchor, digits, self.scene.name, 0.0)


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
    asked = asked_of(scene, MOMENTUM, MAXIMA, h, f)
    on = Surface(scene, asked.h, asked.f)
    orbits: list[Closed] = []
    tried, interrupted = 0, False
    try:
        for guess in _guesses(on, across, most):
            tried += 1
            orbit = _closed(on, guess)
            if orbit is not None and not any(_same(on, orbit, other) for other in orbits):
                orbits.append(orbit)
            if progress is not None:
                progress(f"{tried} guesses, {len(orbits)} orbits")
    except KeyboardInterrupt:
        interrupted = True
    orbits.sort(key=lambda one: float(one.period))
    points = tuple(point_of(on, one) for one in orbits)
    return OrbitSearch(scene, points, tried, interrupted, tuple(orbits), on, scene.provenance())


def picked(
    scene: Scene,
    grid: tuple[int, int] | None,
    pick: int | None,
    crossings: int | None,
    h: AnyNumber | None,
    f: AnyNumber | None,
    progress: Message | None,
    digits: int = DIGITS,
) -> Orbit:
    """The orbit of this number among those of a search, from 1, to so many digits."""
    if grid is None or pick is None:
        expected = "a search and the number of an orbit in it; polhode orbits lists them"
        raise BadInput(scene.name, "pick", pick, expected)
    found = orbit_search(scene, grid, crossings, h, f, progress)
    if not 1 <= pick <= len(found.orbits):
        expected = f"a number to {len(found.orbits)}: so many orbits were found"
        raise BadInput(scene.name, "pick", pick, expected)
    return found.orbit(pick - 1, digits)


def _guesses(on: Surface, grid: tuple[int, int], most: int) -> Iterator[Guess]:
    """Starts whose return is nearer than those of the cells around, by rising number of it."""
    scene, unit = on.scene, float(on.unit)
    asked = asked_of(scene, MOMENTUM, MAXIMA, on.h, on.f)
    begun = starts_of(asked, geometry.ground(scene, on.h, on.f), None, grid)
    cut = section(
        scene,
        MOMENTUM,
        MAXIMA,
        grid=grid,
        crossings=most,
        h=on.h,
        f=on.f,
        workers=1,
        accuracy=False,
    )
    if cut.interrupted:
        raise KeyboardInterrupt
    states = geometry.turned(scene, cut.states, back=True)
    for n in range(most):
        off = (states[:, n] - begun.states) / on.scale(begun.states[0])
        distance = np.where(np.isnan(off).any(axis=1), np.inf, np.sqrt((off**2).sum(axis=1)))
        cells = np.full(grid[0] * grid[1], np.inf)
        np.minimum.at(cells, begun.of, distance)
        least = _least_around(cells.reshape(grid)).ravel()
        for k in np.flatnonzero((distance <= least[begun.of]) & (distance < FARTHEST)).tolist():
            time = float(cut.times[k, n]) / unit
            yield Guess(begun.states[k], time, float(distance[k]), n + 1)


def _least_around(cells: Doubles) -> Doubles:
    """The least of each cell and its eight neighbours; the first coordinate is an angle."""
    wide = np.pad(np.pad(cells, ((1, 1), (0, 0)), mode="wrap"), ((0, 0), (1, 1)), mode="edge")
    first, second = cells.shape
    parts = [wide[i : i + first, j : j + second] for i in range(3) for j in range(3)]
    least: Doubles = np.min(parts, axis=0)
    return least


def _closed(on: Surface, guess: Guess) -> Closed | None:
    """The orbit near a guess, with its shortest period; None where there is none."""
    try:
        orbit = closed(on, guess.state, guess.time, at_level(on, guess.state))
    except NotClosed:
        return None
    if moved_from(on, orbit, guess.state) > ASTRAY * guess.distance:
        return None
    return primitive(on, orbit)


def _same(on: Surface, one: Closed, other: Closed) -> bool:
    """Whether a state of one orbit lies on another: mirror images have period and residue alike."""
    alike = abs(one.period - other.period) < ALIKE * other.period
    if not alike or abs(one.residue - other.residue) > ALIKE * np.linalg.norm(other.monodromy):
        return False
    scale = on.scale(other.state)
    try:
        times = np.linspace(0, float(other.period), LOOKS + 1)
        off = (on.plain_flow.along(other.state, times) - one.state) / scale
    except NotFollowed:
        return False
    near = off[int(np.argmin((off**2).sum(axis=1)))]
    way = on.rates(one.state) / scale
    across = near - (near @ way) / (way @ way) * way
    return bool(np.linalg.norm(across) < 0.1 * float(other.period) / LOOKS * np.linalg.norm(way))
