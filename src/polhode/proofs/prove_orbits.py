"""``polhode.prove_orbits``: the periodic orbits that a search of a level finds, each proved."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from polhode.common.errors import aligned
from polhode.common.interrupts import Message
from polhode.common.values import ByValue
from polhode.dynamics.periodic_orbits.search import OrbitSearch, orbit_search
from polhode.numbers.scalars import AnyNumber
from polhode.proofs.prove_orbit import DIGITS, prove_all, tolerance_of
from polhode.proofs.proved_orbit import ProvedOrbit
from polhode.proofs.refusals import NotProved
from polhode.results.cells import DOUBLE, TEXT, TRUTH
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS


@dataclass(frozen=True, repr=False, eq=False)
class ProvedOrbits(Result, ByValue):
    """The orbits of a search, and of each its proof, or why there is none.

    ``search``: what was found, by increasing period.  ``proofs``: a :class:`ProvedOrbit` or a
    :class:`NotProved` for each.

    >>> import polhode
    >>> polhode.prove_orbits("general/asymmetric-regular", (4, 4), crossings=1)
    <ProvedOrbits of general/asymmetric-regular: 1 of 1 proved>
    """

    search: OrbitSearch
    proofs: tuple[ProvedOrbit | NotProved, ...]

    @property
    def scene(self) -> Scene:
        """The scene on whose level they are."""
        return self.search.scene

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the search."""
        return self.search.interrupted

    @property
    def complete(self) -> bool:
        """Whether all guesses were tried, and nothing was refused."""
        return not self.interrupted and all(isinstance(x, ProvedOrbit) for x in self.proofs)

    def table(self) -> Table:
        """One row per orbit: what the search found of it, and whether it is proved."""
        proved = [isinstance(x, ProvedOrbit) for x in self.proofs]
        digits = [x.digits if isinstance(x, ProvedOrbit) else None for x in self.proofs]
        causes = ["" if isinstance(x, ProvedOrbit) else str(x) for x in self.proofs]
        return Table(
            [
                *self.search.table().columns,
                Column("proven", proved, type=TRUTH),
                Column("digits_proven", digits, "of start and period", type=DOUBLE),
                Column("cause", causes, "why it is not proved", type=TEXT),
            ]
        )

    def facts(self) -> list[Fact]:
        """The level, and how many guesses were tried."""
        facts = [x for x in self.search.facts() if x.name != "complete"]
        told = Fact("complete", self.complete, "whether all guesses were tried, and all is proved")
        return [*facts[:-1], told, facts[-1]]

    def __repr__(self) -> str:
        count = sum(isinstance(x, ProvedOrbit) for x in self.proofs)
        return f"<ProvedOrbits of {self.scene.name}: {count} of {len(self.proofs)} proved>"

    def __str__(self) -> str:
        rows = [[str(k), _line(one)] for k, one in enumerate(self.proofs, 1)]
        return "\n".join(aligned(["orbit", "proof"], rows))


def _line(found: ProvedOrbit | NotProved) -> str:
    if isinstance(found, NotProved):
        return f"not proved: {found}"
    period, radius = found.period.decimals
    return f"proved: {found.kind}, least period {period} +- {radius}, residue {found.residue}"


def prove_orbits(
    scene: Scene | str | Path,
    grid: tuple[int, int] | None = None,
    crossings: int | None = None,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    digits: int = DIGITS,
    tolerance: AnyNumber | None = None,
    progress: Message | None = None,
) -> ProvedOrbits:
    """Prove the periodic orbits that a search of a level finds; others may be missed.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    grid : tuple of int, optional
        The cells of the section's coordinates l and L/G (20x20 unless given).
    crossings : int, optional
        The largest number of crossings in a period (3 unless given).
    h, f : number, optional
        The level's energy h or vertical momentum f, exact, if not the scene's.
    digits : int
        The digits wanted of start and period (30, at most 200).
    tolerance : number, optional
        Prove them for every body within this relative tolerance, as :func:`polhode.prove_orbit`.
    progress : callable, optional
        Called with a line of text now and then.

    Returns
    -------
    ProvedOrbits
        The orbits, and of each its proof or why there is none.

    Raises
    ------
    BadInput
        A level that does not exist.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.prove_orbits("general/asymmetric-regular", (4, 4), crossings=1)
    >>> found.column("proven"), found.proofs[0].kind
    ([True], 'elliptic')
    """
    scene = library.load(scene, takes=REQUESTS)
    bodies = tolerance_of(scene.name, tolerance)
    found = orbit_search(scene, grid, crossings, h, f, progress)
    return ProvedOrbits(found, tuple(prove_all(found, digits, bodies)))
