"""Proved chaos: from a scene to a theorem about its level, in words and in the scene's units."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np

from polhode.certificates import verify
from polhode.certificates.certificate_file import JsonObject, by_checker
from polhode.common.arguments import whole, with_progress
from polhode.common.errors import counted
from polhode.common.interrupts import Message
from polhode.common.values import ByValue
from polhode.dynamics.families import orbit_search
from polhode.dynamics.level_body import LevelBody, level_of
from polhode.dynamics.newton_shooting import Closed
from polhode.dynamics.orbit import Orbit
from polhode.enclosures.fixed_point_problem import upper
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import AnyNumber
from polhode.proofs import chaos_certificate, homoclinic
from polhode.proofs.chaos_certificate import Guess
from polhode.proofs.proved_orbit import ProvedOrbit, as_arb, closed_orbit, down, theorem_of, up
from polhode.proofs.theorem import NotProved, Theorem
from polhode.results.table import Fact, Table
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, unit_of
from polhode.scenes.vocabulary import REQUESTS

# --- theorem --------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, repr=False)
class ProvedChaos(Theorem, ByValue):
    """A level on which the motion is chaotic: a theorem.

    ``orbit``: the proved unstable periodic orbit whose manifolds meet.  ``sets``, ``coverings``:
    of the proof.  ``entropy``: a lower bound of the flow's topological entropy on the level, per
    unit of the scene's time.  ``short``, ``long``: upper bounds of the times of the two loops.
    ``stretch``, ``height``, ``cone``: the least, largest and least margin; the conditions are
    stretch > 1, height < 1, cone > 0.  ``size``: of the sets, in the proof's scale.  ``tries``: of
    homoclinic orbits and sizes; ``seconds``: CPU.  ``certificate``: the JSON text that ``polhode
    verify`` checks.  ``guess``, ``images``: the sets and where they were proved to go, for figures.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.prove_chaos("general/asymmetric-chaotic")
    >>> found
    <ProvedChaos of general/asymmetric-chaotic: 20 coverings, entropy at least 2.7e-02>
    """

    scene: Scene
    h: Exact
    f: Exact
    orbit: ProvedOrbit
    sets: int
    coverings: int
    entropy: float
    short: float
    long: float
    stretch: float
    height: float
    cone: float
    size: float
    tries: int
    seconds: float = field(compare=False)
    certificate: str
    guess: Guess = field(compare=False)
    images: tuple[verify.Image, ...] = field(compare=False)
    provenance: Mapping[str, object] = field(default_factory=dict, compare=False)

    def table(self) -> Table:
        """One row: the orbit whose manifolds meet, as balls."""
        return self.orbit.table()

    def facts(self) -> list[Fact]:
        """The theorem, its bounds and margins, and what it took."""
        time = unit_of(self.scene, "t")
        return [
            *scene_facts(self.scene),
            Fact("proven", True),
            Fact("theorem", self.theorem),
            Fact("h", self.h, "energy"),
            Fact("f", self.f, "vertical momentum"),
            Fact("entropy", self.entropy, "lower bound of the topological entropy", f"1/{time}"),
            Fact("loops", [self.short, self.long], "upper bounds of their times", time),
            Fact("sets", self.sets),
            Fact("coverings", self.coverings),
            Fact("stretch", self.stretch, "the least; above 1"),
            Fact("height", self.height, "the largest; below 1"),
            Fact("cone", self.cone, "the least; above 0"),
            Fact("size", self.size, "of the sets, in the proof's scale"),
            Fact("tries", self.tries, "of homoclinic orbits and sizes"),
            *(x for x in self.orbit.facts() if x.name in ("kind", "multipliers", "digits_proven")),
            provenance_fact(self.provenance),
        ]

    def __repr__(self) -> str:
        coverings = counted(self.coverings, "covering")
        entropy = down(self.entropy)
        return f"<ProvedChaos of {self.scene.name}: {coverings}, entropy at least {entropy}>"

    def __str__(self) -> str:
        """The numbers, a line each, and the theorem."""
        orbit = self.orbit
        lines = [
            f"level       {orbit.level}",
            f"orbit       {orbit.kind}, period {orbit.period}, "
            f"multiplier {orbit.multipliers[0][0]}",
            f"sets        {self.sets}, {self.coverings} coverings with cones",
            f"margins     stretch {self.stretch:.3g} > 1, height {self.height:.3g} < 1, "
            f"cone {self.cone:.3g} > 0",
            f"loops       shorter than {up(self.short)} and {up(self.long)}",
            f"entropy     at least {down(self.entropy)}",
        ]
        return "\n".join([*lines, self.theorem])

    @property
    def theorem(self) -> str:
        """The theorem in words."""
        period, radius = self.orbit.period.decimals
        return (
            f"proved: on the level {self.orbit.level} the {self.orbit.kind} periodic orbit of "
            f"least period {period} +- {radius} has a transversal homoclinic orbit; for "
            f"every sequence of two loops, shorter than {up(self.short)} and {up(self.long)}, "
            f"exactly one motion follows it, a periodic one if the sequence is periodic; the "
            f"topological entropy of the motion on the level is at least {down(self.entropy)}"
        )


# --- prove chaos ----------------------------------------------------------------------------------


TRIES = 12
MOST_TRIES = 1000
SIZES = (1e-6, 1e-7, 3e-8)
_DIGITS = 25
_GRID, _RETURNS = (12, 12), 3
_ORBITS = 4  # unstable ones of a search that are tried
_EACH = 4  # homoclinic orbits of one of them, at first


@with_progress
def prove_chaos(
    scene: Scene | str | Path,
    orbit: Orbit | Scene | str | Path | None = None,
    tries: int = TRIES,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    progress: Message | None = None,
) -> ProvedChaos:
    """Prove that the motion on a level is chaotic: symbolic dynamics and positive entropy.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case: its body, and the level unless that is given.
    orbit : Orbit, Scene, str or Path, optional
        An approximate unstable periodic orbit of the level, as :func:`polhode.orbit` gives it or
        as a scene that ends after one period; without one some of the level are looked for.
    tries : int
        Homoclinic orbits and sizes that are tried.
    h, f : number, optional
        The exact level of the proof: energy and vertical momentum; the scene's own unless given.
    progress : callable, optional
        Called with a line of text now and then.

    Returns
    -------
    ProvedChaos
        What is proved.

    Raises
    ------
    NotProved
        Which condition failed; no homoclinic orbit was found.
    BadInput
        A level that does not exist.

    Notes
    -----
    The theorem and where each step is in the code: ``polhode guide proofs``.

    Examples
    --------
    >>> import polhode
    >>> polhode.prove_chaos("lagrange/backward")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    polhode.proofs.theorem.NotProved: lagrange/backward: no transversal homoclinic orbit ...
    """
    scene = library.load(scene, takes=REQUESTS)
    most = whole(scene.name, "tries", tries, 1, MOST_TRIES)
    on = level_of(scene, h, f)
    if orbit is not None:
        return _first_proof(on, [closed_orbit(on, orbit)], most, most, progress)
    if progress is not None:
        progress("unstable periodic orbits of the level")
    some = orbit_search(scene, _GRID, _RETURNS, h, f)
    if some.interrupted:
        raise KeyboardInterrupt
    order = sorted(range(len(some.closed)), key=lambda k: float(some.closed[k].period))
    unstable = [k for k in order if not 0.0 <= float(some.closed[k].residue) <= 1.0]
    if not unstable:
        raise NotProved(f"{scene.name}: no unstable periodic orbit was found on the level")
    orbits = [some.closed[k] for k in unstable[:_ORBITS]]
    return _first_proof(on, orbits, most if len(orbits) == 1 else _EACH, most, progress)


def _first_proof(
    on: LevelBody, orbits: list[Closed], each: int, most: int, progress: Message | None
) -> ProvedChaos:
    """The first chain of sets that is proved; raises NotProved.

    ``each``: homoclinic orbits of one periodic orbit, ``most``: chains in all.
    """
    began, name, tried, homoclinics = time.process_time(), on.scene.name, 0, 0
    say = progress or (lambda _: None)
    causes = ["none of the manifolds' points led to one"]
    for closed in orbits:
        if tried == most:
            break
        try:
            orbit = theorem_of(on, closed, _DIGITS)
            level, at = _saddle(orbit)
        except NotProved as why:
            causes.append(str(why).partition(": ")[2])
            continue
        say(f"manifolds of the orbit of period {float(orbit.period):.6g}")
        connections = islice(homoclinic.search(level, at), each)
        chains = ((approximate, size) for approximate in connections for size in SIZES)
        for approximate, size in islice(chains, most - tried):
            tried, homoclinics = tried + 1, homoclinics + (size == SIZES[0])
            say(f"chain {tried} of sets along homoclinic orbit {homoclinics}")
            moved, rho = homoclinic.towards(at, approximate, size)
            connection = homoclinic.connection_near(level, at, moved)
            if connection is None:
                causes.append("the homoclinic orbit is lost near the periodic one")
                continue
            guess = chaos_certificate.guess_along(level, at, connection, rho)
            try:
                return _proved(orbit, guess, rho, tried, began)
            except (verify.NotProved, verify.Damaged) as why:
                causes.append(str(why))
    if not homoclinics:
        raise NotProved(f"{name}: no transversal homoclinic orbit was found: {causes[-1]}")
    raise NotProved(
        f"{name}: {tried} chains of sets along {homoclinics} homoclinic orbits failed, the "
        f"last one since {causes[-1]}; try more of them, or another orbit"
    )


def _saddle(orbit: ProvedOrbit) -> tuple[LevelBody, homoclinic.Saddle]:
    """The level, and the orbit's directions on it; raises NotProved where it has none."""
    name, level = orbit.scene.name, LevelBody(orbit.near, orbit.h, orbit.f)
    if orbit.kind == "elliptic":
        raise NotProved(f"{name}: the periodic orbit is elliptic")
    place = np.array([to_double(x) for x in level.exact_start])
    at = homoclinic.saddle(level, place, float(orbit.period) / float(level.unit))
    if at is None:
        raise NotProved(f"{name}: the periodic orbit's multipliers are too near to 1")
    return level, at


def _proved(orbit: ProvedOrbit, guess: Guess, size: float, tries: int, began: float) -> ProvedChaos:
    """The theorem by one chain of sets; raises the checker's NotProved."""
    certificate = chaos_certificate.guesses(guess)
    proof = by_checker(verify.horseshoe, certificate)
    with ctx.workprec(orbit.bits + 64):
        start = [as_arb(x) for x in (*orbit.omega, *orbit.gamma)]
        period = as_arb(orbit.period)
    by_checker(verify.is_orbit_of, proof, start, period)
    short, long = upper(proof.short), upper(proof.long)
    entropy = _least_entropy(short, long)
    statement: JsonObject = {"entropy": down(entropy), "short": up(short), "long": up(long)}
    by_checker(verify.check_chaos, verify.read_chaos(statement), proof)
    return ProvedChaos(
        orbit.scene,
        orbit.h,
        orbit.f,
        orbit,
        len(guess.sets),
        len(proof.margins),
        entropy,
        short,
        long,
        min(float(x.stretch.lower()) for x in proof.margins),
        max(float(x.height.upper()) for x in proof.margins),
        min(float(x.cone.lower()) for x in proof.margins),
        size,
        tries,
        time.process_time() - began,
        json.dumps({**certificate, "statement": statement}),
        guess,
        tuple(proof.images),
        orbit.scene.provenance(),
    )


def _least_entropy(short: float, long: float) -> float:
    """About the x for which exp(-x short) + exp(-x long) is 1."""
    low, high = 0.0, math.log(2.0) / short
    for _ in range(60):
        x = (low + high) / 2
        low, high = (x, high) if math.exp(-x * short) + math.exp(-x * long) > 1.0 else (low, x)
    return low
