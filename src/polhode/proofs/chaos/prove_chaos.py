"""``polhode.prove_chaos``: a scene to a theorem about its level."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path

import numpy as np

from polhode.certificates import chaos_certificate, verify
from polhode.certificates.certificate_file import Made
from polhode.certificates.chaos_certificate import Chain
from polhode.common.arguments import whole
from polhode.common.interrupts import Message
from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.dynamics.periodic_orbits.orbit import Orbit
from polhode.dynamics.periodic_orbits.search import orbit_search
from polhode.dynamics.sections.starts import MAXIMA, asked_of
from polhode.enclosures.fixed_point_problem import Motion, motion, unit_for, upper
from polhode.equations.section_functions import MOMENTUM
from polhode.numbers.conversion import to_double
from polhode.numbers.flint_context import ctx
from polhode.numbers.scalars import AnyNumber
from polhode.proofs.certified_orbit import Candidate, of_closed
from polhode.proofs.chaos import chain, homoclinic
from polhode.proofs.chaos.lanes import Lanes
from polhode.proofs.chaos.proved_chaos import Guess, ProvedChaos
from polhode.proofs.prove_orbit import near_scene, proved
from polhode.proofs.proved_orbit import ProvedOrbit, as_arb, down, up
from polhode.proofs.refusals import NotProved
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS

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
    scene = library.load(scene, takes=REQUESTS)
    most = whole(scene.name, "tries", tries, 1, MOST_TRIES)
    asked = asked_of(scene, MOMENTUM, MAXIMA, h, f)
    on = Surface(scene, asked.h, asked.f)
    if orbit is not None:
        near = orbit.scene if isinstance(orbit, Orbit) else library.load(orbit, takes=REQUESTS)
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
                found = self._beside(proved(guess, _DIGITS), each)
            except NotProved as why:
                self.causes.append(str(why).partition(": ")[2])
                continue
            if found is not None:
                return found
        name = self.on.scene.name
        if not self.seen:
            causes = self.causes or ["none of the manifolds' points led to one"]
            raise NotProved(f"{name}: no transversal homoclinic orbit was found: {causes[-1]}")
        raise NotProved(
            f"{name}: {self.tried} chains of sets along {self.seen} homoclinic orbits failed, the "
            f"last one since {self.causes[-1]}; try more of them, or another orbit"
        )

    def _beside(self, orbit: ProvedOrbit, each: int) -> ProvedChaos | None:
        if orbit.kind == "elliptic":
            self.causes.append("the periodic orbit is elliptic")
            return None
        p, q, r = (x.centre for x in orbit.omega)
        a, b, c = (x.centre for x in orbit.gamma)
        body = orbit.scene.body
        what = motion(orbit.scene, unit=unit_for(body, (p, q, r)))
        by, lanes = 2.0**what.unit, Lanes.of(what)
        rates, vertical = (body.axes.components(v) for v in ((p, q, r), (a, b, c)))
        place = [*(by * to_double(x) for x in rates), *map(to_double, vertical)]
        at = homoclinic.saddle(lanes, np.array(place), float(orbit.period) / by)
        if at is None:
            self.causes.append("the periodic orbit's multipliers are too near to 1")
            return None
        self._say(f"manifolds of the orbit of period {float(orbit.period):.6g}")
        for k, one in enumerate(homoclinic.search(lanes, at)):
            if k == each:
                break
            self.seen += 1
            for size in SIZES:
                if self.tried == self.most:
                    return None
                self.tried += 1
                self._say(f"chain {self.tried} of sets along homoclinic orbit {self.seen}")
                moved, rho = homoclinic.towards(at, one, size)
                found = homoclinic.corrected(lanes, at, moved)
                if found is None:
                    self.causes.append("the homoclinic orbit is lost near the periodic one")
                    continue
                guess = Guess(lanes, at, *chain.along(lanes, at, found, rho))
                try:
                    return self._proved(what, orbit, guess, rho)
                except verify.NotProved as why:
                    self.causes.append(str(why))
        return None

    def _proved(self, what: Motion, orbit: ProvedOrbit, guess: Guess, size: float) -> ProvedChaos:
        """The theorem by one chain of sets; raises the checker's NotProved."""
        charts = [chain.in_scene_axes(what, x) for x in guess.charts]
        times = [x * 2.0**what.unit for x in guess.times]
        scene, h, f = orbit.scene, orbit.h, orbit.f
        made = chaos_certificate.guesses(Chain(scene.body, h, f, charts, guess.sets, times))
        proof = chaos_certificate.proved(made)
        with ctx.workprec(orbit.bits + 64):
            start = [as_arb(x) for x in (*orbit.omega, *orbit.gamma)]
            period = as_arb(orbit.period)
        chaos_certificate.passes(proof, start, period)
        short, long = upper(proof.short), upper(proof.long)
        entropy = _least_entropy(short, long)
        statement: Made = {"entropy": down(entropy), "short": up(short), "long": up(long)}
        made = chaos_certificate.stated(made, statement, proof)
        return ProvedChaos(
            scene,
            h,
            f,
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
            self.tried,
            time.process_time() - self.began,
            json.dumps(made),
            guess,
            tuple(proof.images),
            scene.provenance(),
        )

    def _say(self, text: str) -> None:
        if self.progress is not None:
            self.progress(text)


def _least_entropy(short: float, long: float) -> float:
    """About the x for which exp(-x short) + exp(-x long) is 1."""
    low, high = 0.0, math.log(2.0) / short
    for _ in range(60):
        x = (low + high) / 2
        low, high = (x, high) if math.exp(-x * short) + math.exp(-x * long) > 1.0 else (low, x)
    return low
