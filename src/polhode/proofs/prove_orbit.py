"""``polhode.prove_orbit``: a scene, or an approximate periodic orbit, to a theorem."""

from __future__ import annotations

import time
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from polhode.common.arguments import whole
from polhode.common.errors import BadInput, aligned
from polhode.common.interrupts import Message
from polhode.common.values import ByValue
from polhode.dynamics.families import OrbitSearch, orbit_search
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.orbit import Orbit
from polhode.dynamics.orbit import orbit as approximate
from polhode.dynamics.starts import MAXIMA, cut_of
from polhode.equations.section_functions import MOMENTUM
from polhode.numbers.conversion import exact_number
from polhode.numbers.exact import sign
from polhode.numbers.number_types import AnyNumber
from polhode.proofs import certified_orbit
from polhode.proofs.certified_orbit import Candidate
from polhode.proofs.proved_orbit import ProvedOrbit, of_proof
from polhode.proofs.refusals import NotProved
from polhode.results.cells import DOUBLE, TEXT, TRUTH
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS

DIGITS = 30
MOST_DIGITS = 200
_NONE = Fraction(0)  # the scene's body alone


def prove_orbit(
    scene: Scene | str | Path,
    orbit: Orbit | Scene | str | Path | None = None,
    digits: int = DIGITS,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    period: AnyNumber | None = None,
    returns: int | None = None,
    progress: Message | None = None,
    tolerance: AnyNumber | None = None,
) -> ProvedOrbit:
    """Prove that a periodic orbit exists, and where: start, period, residue, multipliers, kind.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case: its body, and the level unless that is given.
    orbit : Orbit, Scene, str or Path, optional
        A guess: an orbit of the scene's body, as :func:`polhode.orbit` gives it, or a scene that
        ends after one period.  Without one, an orbit near the scene's start is searched for.
    digits : int
        The digits wanted of start and period (30, at most 200).
    h, f : number, optional
        The level's energy h or vertical momentum f, exact, if not the scene's.
    period, returns : number and int, optional
        A guess of the period, or the number of near returns to try, as in :func:`polhode.orbit`.
    progress : callable, optional
        Called with a line of text now and then.
    tolerance : number, optional
        Prove it for every body whose moments and components of Mg r0, in principal axes, differ
        from the scene's by at most this relative amount, on the one level; above 0, below 1.  The
        balls then hold the orbits of all of them, and are accordingly wide.

    Returns
    -------
    ProvedOrbit
        What is proved, as balls in the scene's body axes and units.

    Raises
    ------
    NotProved
        Which condition failed, and by how much.
    BadInput
        A level that does not exist, a period that cannot be.

    Notes
    -----
    The theorem and where each step is in the code: ``polhode guide proofs``.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.prove_orbit("grioli/precession")
    >>> found
    <ProvedOrbit of grioli/precession: period 6.28319, elliptic>
    >>> print(str(found.period)[:32])  # 2 pi
    6.283185307179586476925286766559
    """
    scene = library.load(scene, takes=REQUESTS)
    digit_count = whole(scene.name, "digits", digits, 1, MOST_DIGITS)
    bodies = tolerance_of(scene.name, tolerance)
    if orbit is None:
        orbit = approximate(scene, h=h, f=f, period=period, returns=returns, progress=progress)
    elif period is not None or returns is not None:
        raise BadInput(scene.name, "orbit", None, "no period, returns with it")
    on = cut_of(scene, MOMENTUM, MAXIMA, h, f).on
    if isinstance(orbit, Orbit) and _alike(orbit.surface, on):
        candidate = certified_orbit.of_closed(on, orbit.closed)
    else:
        near = orbit.scene if isinstance(orbit, Orbit) else library.load(orbit, takes=REQUESTS)
        candidate = near_scene(on, near)
    return proved(candidate, digit_count, progress, bodies)


def tolerance_of(name: str, value: AnyNumber | None) -> Fraction:
    """A relative tolerance, exact; 0 where there is none; raises BadInput."""
    if value is None:
        return Fraction(0)
    expected = "a fraction above 0 and below 1"
    try:
        tolerance = exact_number(value)
    except (TypeError, ValueError) as fault:
        raise BadInput(name, "tolerance", value, f"{expected} ({fault})") from None
    if not (isinstance(tolerance, Fraction) and 0 < tolerance < 1):
        raise BadInput(name, "tolerance", value, expected)
    return tolerance


def prove_found(
    search: OrbitSearch,
    k: int,
    digits: int = DIGITS,
    progress: Message | None = None,
    tolerance: Fraction = _NONE,
) -> ProvedOrbit:
    """The k-th orbit of a search, proved as by :func:`prove_orbit`."""
    candidate = certified_orbit.of_closed(search.surface, search.closed[k])
    return proved(candidate, digits, progress, tolerance)


def prove_all(
    search: OrbitSearch, digits: int = DIGITS, tolerance: Fraction = _NONE
) -> list[ProvedOrbit | NotProved]:
    """The proof of each orbit of a search, or why there is none."""
    proofs: list[ProvedOrbit | NotProved] = []
    for k in range(len(search.orbits)):
        try:
            proofs.append(prove_found(search, k, digits, tolerance=tolerance))
        except NotProved as why:
            proofs.append(why)
    return proofs


def _alike(first: LevelBody, second: LevelBody) -> bool:
    """Whether states of both are of one body, one level and one unit of time."""
    levels = [(on.scene.body, on.h, on.f, on.unit) for on in (first, second)]
    return levels[0] == levels[1]


def near_scene(on: LevelBody, near: Scene) -> Candidate:
    """The candidate near a scene that ends after about one period; raises BadInput."""
    if near.gamma is None or near.end is None or sign(near.end) <= 0:
        raise BadInput(near.name, "orbit", None, "a start with gamma, and run.end, its period")
    return certified_orbit.of_scene(on, near)


def proved(
    candidate: Candidate,
    digits: int,
    progress: Message | None = None,
    tolerance: Fraction = _NONE,
) -> ProvedOrbit:
    """The theorem of a candidate; raises NotProved."""
    began = time.process_time()
    proof = certified_orbit.certified(candidate, digits, progress, tolerance)
    return of_proof(candidate.on, proof, tolerance, time.process_time() - began)


# --- prove orbits ---------------------------------------------------------------------------------
#
# ``polhode.prove_orbits``: the periodic orbits that a search of a level finds, each proved.


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
        complete = Fact(
            "complete", self.complete, "whether all guesses were tried, and all is proved"
        )
        return [*facts[:-1], complete, facts[-1]]

    def __repr__(self) -> str:
        count = sum(isinstance(x, ProvedOrbit) for x in self.proofs)
        return f"<ProvedOrbits of {self.scene.name}: {count} of {len(self.proofs)} proved>"

    def __str__(self) -> str:
        rows = [[str(k), _line(proof)] for k, proof in enumerate(self.proofs, 1)]
        return "\n".join(aligned(["orbit", "proof"], rows))


def _line(proof: ProvedOrbit | NotProved) -> str:
    if isinstance(proof, NotProved):
        return f"not proved: {proof}"
    period, radius = proof.period.decimals
    return f"proved: {proof.kind}, least period {period} +- {radius}, residue {proof.residue}"


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
    search = orbit_search(scene, grid, crossings, h, f, progress)
    return ProvedOrbits(search, tuple(prove_all(search, digits, bodies)))
