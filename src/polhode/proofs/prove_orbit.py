"""``polhode.prove_orbit``: a scene, or an approximate periodic orbit, to a theorem."""

from __future__ import annotations

import time
from fractions import Fraction
from pathlib import Path

from polhode.common.arguments import whole
from polhode.common.errors import BadInput
from polhode.common.interrupts import Message
from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.dynamics.periodic_orbits.orbit import Orbit
from polhode.dynamics.periodic_orbits.orbit import orbit as approximate
from polhode.dynamics.periodic_orbits.search import OrbitSearch, picked
from polhode.dynamics.sections.starts import MAXIMA, asked_of
from polhode.equations.section_functions import MOMENTUM
from polhode.numbers.conversion import exact_number
from polhode.numbers.exact import sign
from polhode.numbers.scalars import AnyNumber
from polhode.proofs import certified_orbit
from polhode.proofs.certified_orbit import Candidate
from polhode.proofs.proved_orbit import ProvedOrbit, of_proof
from polhode.proofs.refusals import NotProved
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
    search: tuple[int, int] | None = None,
    pick: int | None = None,
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
    search, pick : tuple of int and int, optional
        Cells of a search instead, and which orbit of it to prove, as in :func:`polhode.orbit`.

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
    wanted = whole(scene.name, "digits", digits, 1, MOST_DIGITS)
    bodies = tolerance_of(scene.name, tolerance)
    guess = {"period": period, "returns": returns, "search": search, "pick": pick}
    if orbit is None and search is None and pick is None:
        orbit = approximate(scene, h=h, f=f, period=period, returns=returns, progress=progress)
    elif orbit is None and period is None:
        orbit = picked(scene, search, pick, returns, h, f, progress)
    elif orbit is None:
        raise BadInput(scene.name, "search", None, "no period with it")
    elif any(x is not None for x in guess.values()):
        raise BadInput(scene.name, "orbit", None, f"no {', '.join(guess)} with it")
    asked = asked_of(scene, MOMENTUM, MAXIMA, h, f)
    on = Surface(scene, asked.h, asked.f)
    if isinstance(orbit, Orbit) and _alike(orbit.surface, on):
        candidate = certified_orbit.of_closed(on, orbit.closed)
    else:
        near = orbit.scene if isinstance(orbit, Orbit) else library.load(orbit, takes=REQUESTS)
        candidate = near_scene(on, near)
    return proved(candidate, wanted, progress, bodies)


def tolerance_of(name: str, given: AnyNumber | None) -> Fraction:
    """A relative tolerance, exact; 0 where there is none; raises BadInput."""
    if given is None:
        return Fraction(0)
    expected = "a fraction above 0 and below 1"
    try:
        found = exact_number(given)
    except (TypeError, ValueError) as fault:
        raise BadInput(name, "tolerance", given, f"{expected} ({fault})") from None
    if not (isinstance(found, Fraction) and 0 < found < 1):
        raise BadInput(name, "tolerance", given, expected)
    return found


def prove_found(
    found: OrbitSearch,
    k: int,
    digits: int = DIGITS,
    progress: Message | None = None,
    tolerance: Fraction = _NONE,
) -> ProvedOrbit:
    """The k-th orbit of a search, proved as by :func:`prove_orbit`."""
    candidate = certified_orbit.of_closed(found.surface, found.closed[k])
    return proved(candidate, digits, progress, tolerance)


def prove_all(
    found: OrbitSearch, digits: int = DIGITS, tolerance: Fraction = _NONE
) -> list[ProvedOrbit | NotProved]:
    """The proof of each orbit of a search, or why there is none."""
    proofs: list[ProvedOrbit | NotProved] = []
    for k in range(len(found.orbits)):
        try:
            proofs.append(prove_found(found, k, digits, tolerance=tolerance))
        except NotProved as why:
            proofs.append(why)
    return proofs


def _alike(one: Surface, other: Surface) -> bool:
    """Whether states of both are of one body, one level and one unit of time."""
    levels = [(on.scene.body, on.h, on.f, on.unit) for on in (one, other)]
    return levels[0] == levels[1]


def near_scene(on: Surface, near: Scene) -> Candidate:
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
    found = certified_orbit.certified(candidate, digits, progress, tolerance)
    return of_proof(candidate.on, found, tolerance, time.process_time() - began)
