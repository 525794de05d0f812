"""``polhode.prove_chaos``: a scene to a theorem about its level."""

from __future__ import annotations

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from flint import arb

from polhode.common.arguments import whole
from polhode.common.progress import Message
from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.dynamics.periodic_orbits.orbit import Orbit
from polhode.dynamics.periodic_orbits.search import orbit_search
from polhode.dynamics.sections.starts import MAXIMA, asked_of
from polhode.enclosures.fixed_point_problem import Refused, motion, unit_for
from polhode.enclosures.polynomial import ball
from polhode.equations.section_functions import MOMENTUM
from polhode.numbers.flint_context import ctx
from polhode.numbers.scalars import AnyNumber
from polhode.proofs.certified_orbit import Candidate, of_closed
from polhode.proofs.chaos import chain_candidate, homoclinic, theorem
from polhode.proofs.chaos.homoclinic import Homoclinic, Saddle
from polhode.proofs.chaos.lanes import Lanes
from polhode.proofs.chaos.proved_chaos import Guess as Begun
from polhode.proofs.chaos.proved_chaos import ProvedChaos
from polhode.proofs.chaos.theorem import Horseshoe
from polhode.proofs.level import Level
from polhode.proofs.prove_orbit import near_scene, proved
from polhode.proofs.proved_orbit import ProvedOrbit, as_arb
from polhode.proofs.refusals import NotProved
from polhode.scenes import library
from polhode.scenes.scene import Scene

TRIES = 12
MOST_TRIES = 1000
SIZES = (1e-6, 1e-7, 3e-8)
_DIGITS = 25
_GRID, _RETURNS = (12, 12), 3
_ORBITS = 4  # unstable ones of a search that are tried
_EACH = 4  # homoclinic orbits of one of them, at first


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
    polhode.proofs.refusals.NotProved: lagrange/backward: no transversal homoclinic orbit was ...
    """
    scene = library.load(scene)
    most = whole(scene.name, "tries", tries, 1, MOST_TRIES)
    asked = asked_of(scene, MOMENTUM, MAXIMA, h, f)
    on = Surface(scene, asked.h, asked.f)
    if orbit is not None:
        near = orbit.scene if isinstance(orbit, Orbit) else library.load(orbit)
        return _Search(on, most, progress).found([near_scene(on, near)])
    if progress is not None:
        progress("unstable periodic orbits of the level")
    some = orbit_search(scene, _GRID, _RETURNS, h, f)
    if some.interrupted:
        raise KeyboardInterrupt
    order = sorted(range(len(some.closed)), key=lambda k: float(some.closed[k].period))
    unstable = [k for k in order if not 0.0 <= float(some.closed[k].residue) <= 1.0]
    if not unstable:
        raise NotProved(f"{scene.name}: no unstable periodic orbit was found on the level")
    guesses = [of_closed(some.surface, some.closed[k]) for k in unstable[:_ORBITS]]
    return _Search(on, most, progress).found(guesses)


class OrbitBalls(NamedTuple):
    """An orbit in principal axes and the unit of time of a level's motion."""

    start: list[arb]
    period: arb


def _level_of(on: Surface, told: ProvedOrbit) -> Level:
    """The level, in the unit of time that a proved orbit suggests."""
    p, q, r = (x.centre for x in told.omega)
    return Level(motion(on.scene, unit=unit_for(on.scene.body, (p, q, r))), on.h, on.f)


def balls_on(level: Level, told: ProvedOrbit) -> OrbitBalls:
    """A proved orbit in the axes and the unit of time of a level's motion."""
    bits = told.bits + 64
    with ctx.workprec(bits):
        by = arb((1, level.motion.unit))
        rows = [[ball(x, bits) for x in row] for row in told.scene.body.axes.rows]
        vectors = [[as_arb(x) for x in v] for v in (told.omega, told.gamma)]
        omega, gamma = (
            [row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in rows] for v in vectors
        )
        return OrbitBalls([*(by * x for x in omega), *gamma], as_arb(told.period) / by)


class _Search:
    """The tries of one proof."""

    def __init__(self, on: Surface, most: int, progress: Message | None) -> None:
        self.on, self.most, self.progress = on, most, progress
        self.tried = self.seen = 0
        self.began = time.process_time()
        self.causes: list[str] = []

    def found(self, guesses: list[Candidate]) -> ProvedChaos:
        """The first proof that holds; raises NotProved."""
        each = self.most if len(guesses) == 1 else _EACH
        for guess in guesses:
            try:
                told = proved(guess, _DIGITS)
                level = _level_of(self.on, told)
                made = self._beside(level, balls_on(level, told), told, each)
            except NotProved as why:
                self.causes.append(str(why).partition(": ")[2])
                continue
            if made is not None:
                return made
        name = self.on.scene.name
        if not self.seen:
            causes = self.causes or ["none of the manifolds' points led to one"]
            raise NotProved(f"{name}: no transversal homoclinic orbit was found: {causes[-1]}")
        raise NotProved(
            f"{name}: {self.tried} chains of sets along {self.seen} homoclinic orbits failed, the "
            f"last one since {self.causes[-1]}"
        )

    def _beside(
        self, level: Level, orbit: OrbitBalls, told: ProvedOrbit, each: int
    ) -> ProvedChaos | None:
        if told.kind == "elliptic":
            self.causes.append("the periodic orbit is elliptic")
            return None
        lanes = Lanes.of(level.motion)
        point = np.array([float(x.mid()) for x in orbit.start])
        at = homoclinic.saddle(lanes, point, float(orbit.period.mid()))
        if at is None:
            self.causes.append("the periodic orbit's multipliers are too near to 1")
            return None
        self._say(f"manifolds of the orbit of period {float(told.period):.6g}")
        for k, one in enumerate(homoclinic.search(lanes, at)):
            if k == each:
                break
            self.seen += 1
            for size in SIZES:
                if self.tried == self.most:
                    return None
                self.tried += 1
                self._say(f"chain {self.tried} of sets along homoclinic orbit {self.seen}")
                try:
                    proof, rho = chained(lanes, level, at, one, size, orbit)
                except Refused as why:
                    self.causes.append(str(why))
                    continue
                return self._told(level, told, proof, rho, Begun(lanes, at, one))
        return None

    def _say(self, text: str) -> None:
        if self.progress is not None:
            self.progress(text)

    def _told(
        self, level: Level, orbit: ProvedOrbit, proof: Horseshoe, size: float, begun: Begun
    ) -> ProvedChaos:
        by = 2.0**level.motion.unit
        scene = level.motion.scene
        return ProvedChaos(
            scene,
            level.h,
            level.f,
            orbit,
            1 + len(proof.chain.sets),
            len(proof.margins),
            proof.entropy / by,
            _above(proof.short) * by,
            _above(proof.long) * by,
            min(x.stretch for x in proof.margins),
            max(x.height for x in proof.margins),
            min(x.cone for x in proof.margins),
            size,
            self.tried,
            time.process_time() - self.began,
            proof,
            level,
            begun,
            scene.provenance(),
        )


def chained(
    lanes: Lanes, level: Level, at: Saddle, near: Homoclinic, size: float, orbit: OrbitBalls
) -> tuple[Horseshoe, float]:
    """The theorem along one homoclinic orbit with sets of about a size; raises Refused."""
    moved, rho = homoclinic.towards(at, near, size)
    found = homoclinic.corrected(lanes, at, moved)
    if found is None:
        raise Refused("the homoclinic orbit could not be corrected near the periodic one")
    with ctx.workprec(chain_candidate.NOISE + 128):
        fine = arb((1, chain_candidate.fine_of(chain_candidate.NOISE)))
        middles = [(x.mid() * fine).floor().unique_fmpz() for x in orbit.start]
    point = tuple(int(x or 0) for x in middles)
    charts, ticks = chain_candidate.charts(lanes, level, at, found, point)
    made = chain_candidate.chain(level, charts, ticks, rho, found.unstable, at.multiplier)
    proof = theorem.horseshoe(made)
    theorem.holds(level, made, orbit.start, orbit.period, chain_candidate.NOISE + 128)
    return proof, rho


def _above(x: arb) -> float:
    return float(x.upper()) * (1.0 + 1e-12)
