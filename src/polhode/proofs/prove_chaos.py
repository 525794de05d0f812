"""``polhode.prove_chaos``: a scene to a theorem about its level."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path

import numpy as np

from polhode.certificates import chaos_certificate, verify
from polhode.certificates.certificate_file import Made
from polhode.certificates.chaos_certificate import Chain, Chart, Rectangle
from polhode.common.arguments import whole
from polhode.common.interrupts import Message
from polhode.dynamics.families import orbit_search
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.orbit import Orbit
from polhode.dynamics.starts import MAXIMA, cut_of
from polhode.enclosures.fixed_point_problem import Motion, motion, unit_for, upper
from polhode.equations.section_functions import MOMENTUM
from polhode.numbers.conversion import to_double
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import AnyNumber, Doubles
from polhode.proofs import homoclinic
from polhode.proofs.certified_orbit import Candidate, of_closed
from polhode.proofs.homoclinic import Homoclinic, Lanes, Saddle
from polhode.proofs.prove_orbit import near_scene, proved
from polhode.proofs.proved_chaos import Guess, ProvedChaos
from polhode.proofs.proved_orbit import ProvedOrbit, as_arb, down, up
from polhode.proofs.refusals import NotProved
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS

# --- chain ----------------------------------------------------------------------------------------
#
# Charts and sets along a homoclinic orbit, in double: of what derivatives of the flow foretell.
#
# Not trusted: the checker of certificates decides.


ETA = 1e-4
_WIDER, _HIGHER = 0.7, 1.5  # of the image: a next set's width, its height
_LEAST_HEIGHT = 0.25  # of N0's: far above what the checker leaves open, which is of second order


def along(
    lanes: Lanes, at: Saddle, orbit: Homoclinic, size: float
) -> tuple[list[Chart], list[Rectangle], list[float]]:
    """Charts, the sets N0, M1, ..., Mk, and the time from each to the next one's plane.

    In principal axes and the lanes' unit of time; ``size``: of N0.
    """
    count = max(2, round(orbit.time / at.period))
    time = orbit.time / count
    times = time * np.arange(count)
    first = at.point + at.unstable * orbit.unstable
    last = at.point + at.stable * orbit.stable
    early = times <= orbit.ahead
    starts = np.where(early, first[:, None], last[:, None])
    states = lanes.after(starts, np.where(early, times, times - orbit.time))
    slopes = lanes.derivative(states, np.full(count, time))
    out, into = [at.unstable], [at.stable]
    for k in range(1, count):
        out.append(_flat(lanes, states[:, k], slopes[k - 1] @ out[-1]))
    for k in range(count - 1, 0, -1):
        into.append(_flat(lanes, states[:, k], np.linalg.solve(slopes[k], into[-1])))
    charts = [_chart(lanes, at.point, at.unstable, at.stable)]
    for k in range(1, count):
        charts.append(_chart(lanes, states[:, k], out[k], into[-k]))
    returned = lanes.derivative(at.point[:, None], np.array([at.period]))
    places = [0, *range(count)]
    maps = [
        _section_map(charts[place], charts[after], slope)
        for place, after, slope in zip(places, [*places[1:], 0], [*returned, *slopes], strict=True)
    ]
    width = min(1.0, 0.3 * (min(abs(at.multiplier), 4.0) - 1.0)) * size
    sets = [Rectangle(0, 0.0, size, size)]
    sets.append(Rectangle(0, orbit.unstable, width, _fitted(maps[0], sets[0], size).height))
    for k in range(1, count):
        sets.append(_fitted(maps[k], sets[-1], size)._replace(chart=k))
    return charts, sets, [at.period, *[time] * count]


def _section_map(chart: Chart, target: Chart, slope: Doubles) -> Doubles:
    """The derivative (2, 2) of the map from a chart to the next one's plane."""
    rates = target.deep[:, 3]
    across = np.eye(6) - np.outer(rates, target.plane) / (target.plane @ rates)
    frame = np.linalg.inv(np.hstack([target.wide, target.deep]))
    return np.asarray((frame @ across @ slope @ chart.wide)[:2])


def _fitted(derivative: Doubles, source: Rectangle, size: float) -> Rectangle:
    """A set that the image of another one covers, about its middle."""
    (a, b), (c, d) = np.abs(derivative) * [source.width, source.height]
    wide = min(size, _WIDER * max(a - b, 0.1 * a))
    return Rectangle(0, 0.0, float(wide), float(max(_HIGHER * (c + d), _LEAST_HEIGHT * size)))


def _chart(lanes: Lanes, state: Doubles, out: Doubles, into: Doubles) -> Chart:
    rates = lanes.field(state[:, None])[:, 0]
    wide = np.column_stack([_flat(lanes, state, v) for v in (out, into)])
    deep = np.column_stack([*lanes.gradients(state), rates])
    return Chart(state, wide, deep, rates, ETA)


def _flat(lanes: Lanes, state: Doubles, v: Doubles) -> Doubles:
    """A direction in the level and in the plane across the motion, of length 1."""
    rates = lanes.field(state[:, None])[:, 0]
    rows = np.vstack([lanes.gradients(state), rates])
    v = v - rates * (rates @ v) / (rates @ rates)
    v = v - rows.T @ np.linalg.solve(rows @ rows.T, rows @ v)
    return np.asarray(v / np.max(np.abs(v)))


def in_scene_axes(of: Motion, chart: Chart) -> Chart:
    """A chart of principal axes and a motion's unit of time, in the scene's axes and unit."""
    by = 2.0**of.unit
    turn = np.array([[to_double(x) for x in row] for row in of.scene.body.axes.rows]).T
    place = np.kron(np.diag([1.0 / by, 1.0]), turn)
    back = np.kron(np.diag([by, 1.0]), turn)
    return Chart(
        place @ chart.centre,
        place @ chart.wide,
        place @ chart.deep,
        back @ chart.plane,
        chart.eta,
    )


# --- prove chaos ----------------------------------------------------------------------------------


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
    polhode.proofs.refusals.NotProved: lagrange/backward: no transversal homoclinic orbit ...
    """
    scene = library.load(scene, takes=REQUESTS)
    most = whole(scene.name, "tries", tries, 1, MOST_TRIES)
    on = cut_of(scene, MOMENTUM, MAXIMA, h, f).on
    if orbit is not None:
        near = orbit.scene if isinstance(orbit, Orbit) else library.load(orbit, takes=REQUESTS)
        return _ChaosSearch(on, most, progress).found([near_scene(on, near)])
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
    return _ChaosSearch(on, most, progress).found(guesses)


class _ChaosSearch:
    """The tries of one proof."""

    def __init__(self, on: LevelBody, most: int, progress: Message | None) -> None:
        self.on, self.most, self.progress = on, most, progress
        self.tried = self.seen = 0
        self.began = time.process_time()
        self.causes: list[str] = []

    def found(self, guesses: list[Candidate]) -> ProvedChaos:
        """The first proof that holds; raises NotProved."""
        each = self.most if len(guesses) == 1 else _EACH
        for guess in guesses:
            try:
                theorem = self._beside(proved(guess, _DIGITS), each)
            except NotProved as why:
                self.causes.append(str(why).partition(": ")[2])
                continue
            if theorem is not None:
                return theorem
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
        of = motion(orbit.scene, unit=unit_for(body, (p, q, r)))
        by, lanes = 2.0**of.unit, Lanes.of(of)
        rates, vertical = (body.axes.components(v) for v in ((p, q, r), (a, b, c)))
        place = [*(by * to_double(x) for x in rates), *map(to_double, vertical)]
        at = homoclinic.saddle(lanes, np.array(place), float(orbit.period) / by)
        if at is None:
            self.causes.append("the periodic orbit's multipliers are too near to 1")
            return None
        self._say(f"manifolds of the orbit of period {float(orbit.period):.6g}")
        for k, approximate in enumerate(homoclinic.search(lanes, at)):
            if k == each:
                break
            self.seen += 1
            for size in SIZES:
                if self.tried == self.most:
                    return None
                self.tried += 1
                self._say(f"chain {self.tried} of sets along homoclinic orbit {self.seen}")
                moved, rho = homoclinic.towards(at, approximate, size)
                connection = homoclinic.corrected(lanes, at, moved)
                if connection is None:
                    self.causes.append("the homoclinic orbit is lost near the periodic one")
                    continue
                guess = Guess(lanes, at, *along(lanes, at, connection, rho))
                try:
                    return self._proved(of, orbit, guess, rho)
                except verify.NotProved as why:
                    self.causes.append(str(why))
        return None

    def _proved(self, of: Motion, orbit: ProvedOrbit, guess: Guess, size: float) -> ProvedChaos:
        """The theorem by one chain of sets; raises the checker's NotProved."""
        charts = [in_scene_axes(of, x) for x in guess.charts]
        times = [x * 2.0**of.unit for x in guess.times]
        scene, h, f = orbit.scene, orbit.h, orbit.f
        certificate = chaos_certificate.guesses(Chain(scene.body, h, f, charts, guess.sets, times))
        proof = chaos_certificate.proved(certificate)
        with ctx.workprec(orbit.bits + 64):
            start = [as_arb(x) for x in (*orbit.omega, *orbit.gamma)]
            period = as_arb(orbit.period)
        chaos_certificate.passes(proof, start, period)
        short, long = upper(proof.short), upper(proof.long)
        entropy = _least_entropy(short, long)
        statement: Made = {"entropy": down(entropy), "short": up(short), "long": up(long)}
        certificate = chaos_certificate.stated(certificate, statement, proof)
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
            json.dumps(certificate),
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
