"""``polhode.prove_orbit``: a scene, or an approximate periodic orbit, to a theorem."""

from __future__ import annotations

import math
import time
from fractions import Fraction
from pathlib import Path

from flint import arb

from polhode.common.arguments import whole
from polhode.common.errors import BadInput
from polhode.common.progress import Message
from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.dynamics.periodic_orbits.orbit import Orbit
from polhode.dynamics.periodic_orbits.orbit import orbit as approximate
from polhode.dynamics.periodic_orbits.search import OrbitSearch
from polhode.dynamics.sections.starts import MAXIMA, asked_of
from polhode.enclosures.fixed_point_problem import Refused, in_scene_axes, motion, unit_for
from polhode.enclosures.proof_loop import SHORT_STEPS, Untrusted
from polhode.equations.section_functions import MOMENTUM
from polhode.numbers import exact
from polhode.numbers.conversion import exact_number, to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.scalars import AnyNumber
from polhode.proofs import orbit_candidate
from polhode.proofs.body_tolerance import of_bodies
from polhode.proofs.least_period import primes
from polhode.proofs.level import Level
from polhode.proofs.orbit_candidate import Found, follower
from polhode.proofs.proved_orbit import ProvedOrbit, Within, ball_of
from polhode.proofs.refusals import NotProved
from polhode.scenes import library
from polhode.scenes.scene import Scene

DIGITS = 30
MOST_DIGITS = 200
_NONE = Fraction(0)  # the scene's body alone
_SPARE = 1.3  # the proof's own bound of the steepness is less sharp than that of the level

#: A state in principal axes and a period, in the scene's units.
Guess = tuple[tuple[Fraction, ...], Fraction]


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
        An approximate orbit of the scene's body, as :func:`polhode.orbit` gives it or as a scene
        that ends after one period; it is only a guess.  Without one, an orbit near the scene's
        start is searched for.
    digits : int
        Correct digits wanted of start and period, 1 to MOST_DIGITS.
    h, f : number, optional
        The exact level of the proof: energy and vertical momentum; the scene's own unless given.
    period, returns : number and int, optional
        For the search, as in :func:`polhode.orbit`.
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
    scene = library.load(scene)
    wanted = whole(scene.name, "digits", digits, 1, MOST_DIGITS)
    bodies = tolerance_of(scene.name, tolerance)
    if orbit is None:
        orbit = approximate(scene, h=h, f=f, period=period, returns=returns, progress=progress)
    elif period is not None or returns is not None:
        raise BadInput(scene.name, "orbit", None, "no period or returns with it")
    asked = asked_of(scene, MOMENTUM, MAXIMA, h, f)
    on = Surface(scene, asked.h, asked.f)
    near = orbit.scene if isinstance(orbit, Orbit) else library.load(orbit)
    return proved(on, guess_of(on, near), wanted, progress, tolerance=bodies)


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
    return proved(found.surface, guess_in(found, k), digits, progress, tolerance=tolerance)


def guess_in(found: OrbitSearch, k: int) -> Guess:
    """The k-th orbit of a search in the scene's units."""
    on, known = found.surface, found.closed[k]
    state = [Fraction(x) for x in known.state.tolist()]
    return (*(w / on.unit for w in state[:3]), *state[3:]), Fraction(float(known.period)) * on.unit


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


def guess_of(on: Surface, near: Scene) -> Guess:
    """Start and end of a scene, in the principal axes of the level's body."""
    if near.gamma is None or near.end is None or sign(near.end) <= 0:
        raise BadInput(near.name, "orbit", None, "a start with gamma, and run.end, its period")
    axes = on.scene.body.axes
    state = (*axes.components(near.omega), *axes.components(near.gamma))
    return tuple(_binary(x) for x in state), _binary(near.end)


def _binary(x: Exact) -> Fraction:
    return x if isinstance(x, Fraction) else exact.binary(*exact.rounded(x, 4 * MOST_DIGITS))


def proved(
    on: Surface,
    guess: Guess,
    digits: int,
    progress: Message | None = None,
    untrusted: Untrusted = SHORT_STEPS,
    tolerance: Fraction = _NONE,
) -> ProvedOrbit:
    """The theorem near a guess in the scene's units; raises NotProved."""
    return of_guess(on, guess, digits, progress, untrusted, tolerance)[2]


def of_guess(
    on: Surface,
    guess: Guess,
    digits: int,
    progress: Message | None = None,
    untrusted: Untrusted = SHORT_STEPS,
    tolerance: Fraction = _NONE,
) -> tuple[Level, Found, ProvedOrbit]:
    """The same, with the level and the theorem in the proof's unit; raises NotProved."""
    began = time.process_time()
    state, period = guess
    scene, (p, q, r, *gamma) = on.scene, state
    unit = unit_for(scene.body, (p, q, r))
    by = Fraction(2) ** unit
    level = Level(motion(scene, unit=unit), on.h, on.f)
    point = [p * by, q * by, r * by, *gamma, period / by]
    try:
        parts = primes(arb(_SPARE * to_double(period) / (to_double(on.unit) * on.shortest)))
        found = orbit_candidate.corrected(level, point, digits, (*parts,), untrusted, progress)
        if found.theorem.open:
            raise NotProved(f"{scene.name}: {_shorter(level, found, untrusted)}")
        if tolerance:
            level, found = of_bodies(level, found, tolerance, follower(untrusted))
        return level, found, _result(level, found, time.process_time() - began)
    except Refused as why:
        raise NotProved(f"{scene.name}: {why}") from None


def _shorter(level: Level, found: Found, untrusted: Untrusted) -> str:
    """What is to be said of a period that may not be the least one."""
    least = orbit_candidate.multiple_of(level, found, follower(untrusted))
    if least is None:
        primes = ", ".join(map(str, found.theorem.open))
        return f"whether the period is the least one is undecided: it may be one over {primes}"
    times, theorem = least
    with ctx.workprec(found.candidate.noise + 128):
        period = ball_of(theorem.period * arb((1, level.motion.unit)))
    return f"the period is {times} times the least one, {period}"


def _result(level: Level, found: Found, seconds: float) -> ProvedOrbit:
    """A theorem in the scene's axes and units."""
    what, theorem, noise = level.motion, found.theorem, found.candidate.noise
    bits = noise + 128
    state = in_scene_axes(what, theorem.start, bits)
    with ctx.workprec(bits):
        unit = arb((1, what.unit))
        near = theorem.near
        within = Within(_below(near / unit), _below(near), _below(theorem.beside * unit))
        if not min(within) > 0.0:
            raise Refused("the box is no larger than the error of its centre")
        balls = [ball_of(x) for x in state]
        return ProvedOrbit(
            what.scene,
            level.h,
            level.f,
            ball_of(theorem.period * unit),
            tuple(balls[:3]),
            tuple(balls[3:]),
            ball_of(theorem.residue),
            theorem.kind,
            within,
            orbit_candidate.digits_of(theorem),
            noise,
            found.runs,
            seconds,
            what.scene.provenance(),
            what.tolerance,
        )


def _below(x: arb) -> float:
    """A double not above a positive number; 0 where that is none."""
    low = float(x.lower()) * (1.0 - 1e-9)
    return low if math.isfinite(low) else 0.0
