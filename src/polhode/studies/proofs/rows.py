"""Study ``proofs``: periodic orbits of seven tops, their stability, and chaos of five tops.

Each proof is made by the checker of certificates, which imports nothing of polhode, and is read
again by it from the certificate that was written.
"""

from __future__ import annotations

import tempfile
import time
from fractions import Fraction
from pathlib import Path
from typing import TypeAlias

from polhode.certificates.verdict import verify
from polhode.common.errors import BadInput
from polhode.common.interrupts import Message
from polhode.common.processes import cores, in_order
from polhode.common.texts import JsonObject
from polhode.dynamics.families import orbit_search
from polhode.figures.proofs import crossings
from polhode.numbers.decimals import brief
from polhode.proofs.certified_orbit import NotProved
from polhode.proofs.prove_chaos import prove_chaos
from polhode.proofs.prove_orbit import prove_all
from polhode.proofs.prove_stability import prove_stability
from polhode.proofs.proved_chaos import ProvedChaos
from polhode.proofs.proved_orbit import ProvedOrbit
from polhode.scenes import library
from polhode.scenes.from_numbers import top
from polhode.scenes.scene import Scene
from polhode.studies.row_filter import Only

QUESTION = (
    "Which periodic orbits of a level can be proved to exist, of which tops is chaos proved, at "
    "what cost, and do the certificates hold when they are read again?"
)
ORBITS = {
    "asymmetric, chaotic": "general/asymmetric-chaotic",
    "asymmetric, regular": "general/asymmetric-regular",
    "asymmetric, of a section": "general/section",
    "Hairer and Vilmart's body": "published/hairer-vilmart",
    "Kovalevskaya's top": "kovalevskaya/generic",
    "Goryachev–Chaplygin top": "goryachev-chaplygin/two-frequencies",
    "next to Lagrange's top": None,
}
CHAOS = {
    "asymmetric, chaotic": "general/asymmetric-chaotic",
    "asymmetric, regular": "general/asymmetric-regular",
    "asymmetric, of a section": "general/section",
    "asymmetric, near upright": "general/near-upright",
    "Hairer and Vilmart's body": "published/hairer-vilmart",
}
DRAWN = "asymmetric, chaotic"  # the proof of chaos that has a figure
GRID, CROSSINGS, DIGITS = (16, 16), 3, 20
_QUICK_GRID = (6, 6)
_QUICK = ("asymmetric, regular",)

Row: TypeAlias = JsonObject
#: What is proved, of which top, and the cells of a search.
Job: TypeAlias = tuple[str, str, tuple[int, int]]


def rows(quick: bool, say: Message, wanted: Only) -> JsonObject:
    """The study's rows."""
    grid = _QUICK_GRID if quick else GRID
    jobs = [("chaos", what, grid) for what in ([] if quick else CHAOS) if wanted(f"chaos: {what}")]
    jobs += [
        ("orbits", what, grid)
        for what in (_QUICK if quick else ORBITS)
        if wanted(f"orbits: {what}")
    ]

    def begun(job: Job) -> None:
        say(f"{job[0]} of {job[1]}")

    workers = 1 if quick or len(jobs) < 2 else cores()
    found = [*in_order(_answer, jobs, workers, begun)]
    return {
        "grid": list(grid),
        "crossings": CROSSINGS,
        "digits": DIGITS,
        "orbits": [one for (kind, *_), one in zip(jobs, found, strict=True) if kind == "orbits"],
        "chaos": [one for (kind, *_), one in zip(jobs, found, strict=True) if kind == "chaos"],
    }


def scene_of(what: str) -> Scene:
    """The scene of a top."""
    name = ORBITS.get(what, CHAOS.get(what))
    if name is not None:
        return library.load(name)
    # Lagrange's top but for a moment that is a fiftieth larger
    return top(
        moments=[2, Fraction(51, 25), 1],
        centre=[0, 0, 1],
        weight=1,
        omega=[Fraction(1, 2), Fraction(1, 4), 2],
        gamma=[Fraction(3, 5), 0, Fraction(4, 5)],
        end=1,
        name="next to Lagrange's top",
    )


def _answer(job: Job) -> Row:
    kind, what, grid = job
    return _orbits(what, grid) if kind == "orbits" else _chaos(what)


def _orbits(what: str, grid: tuple[int, int]) -> Row:
    """All orbits of a search on the scene's own level."""
    scene = scene_of(what)
    began = time.process_time()
    search = orbit_search(scene, grid, CROSSINGS)
    searched = time.process_time() - began
    found = []
    for orbit, proof in zip(search.orbits, prove_all(search, DIGITS), strict=True):
        row: Row = {"period": float(orbit.period), "residue": float(orbit.residue)}
        if isinstance(proof, NotProved):
            found.append(row | {"proved": False, "cause": str(proof).partition(": ")[2]})
            continue
        period, radius = proof.period.decimals
        row |= {"proved": True, "kind": proof.kind, "least_period": period, "within": radius}
        row |= {"digits": round(proof.digits, 1), "seconds": round(proof.seconds, 3)}
        found.append(row | _checked(proof) | _stable(proof))
    return {
        "what": what,
        "scene": None if ORBITS[what] is None else scene.name,
        "h": brief(search.surface.h),
        "f": brief(search.surface.f),
        "search_seconds": round(searched, 2),
        "orbits": sorted(found, key=lambda row: row["period"]),
    }


def _stable(proof: ProvedOrbit) -> Row:
    """Whether an elliptic orbit is proved to be stable for all time, and how long that takes."""
    if proof.kind != "elliptic":
        return {}
    began = time.process_time()
    try:
        twist = str(prove_stability(proof).twist)
    except NotProved as why:
        return {"stable": False, "why_not_stable": str(why).partition(": ")[2]}
    return {
        "stable": True,
        "twist": twist,
        "stability_seconds": round(time.process_time() - began, 2),
    }


def _chaos(what: str) -> Row:
    """A proof of chaos on the scene's own level."""
    scene = scene_of(what)
    began = time.process_time()
    try:
        found = prove_chaos(scene)
    except NotProved as why:
        seconds = round(time.process_time() - began, 1)
        cause = str(why).partition(": ")[2]
        return {"what": what, "scene": scene.name, "proved": False, "cause": cause} | {
            "seconds": seconds
        }
    period, _ = found.orbit.period.decimals
    row: Row = {"what": what, "scene": scene.name, "proved": True, "period": period}
    row |= {"kind": found.orbit.kind, "coverings": found.coverings, "tries": found.tries}
    row |= {"entropy": found.entropy, "short": found.short, "long": found.long}
    row |= {"stretch": found.stretch, "height": found.height, "cone": found.cone}
    row |= {"h": brief(found.h), "f": brief(found.f)}
    if what == DRAWN:
        row["drawn"] = {
            name: [[round(float(x), 3) for x in axis] for axis in points]
            for name, points in crossings(found)._asdict().items()
        }
    return row | {"seconds": round(time.process_time() - began, 1)} | _checked(found)


def _checked(proof: ProvedOrbit | ProvedChaos) -> Row:
    """Whether the checker proves the proof's certificate, and how long that takes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.json"
        try:
            proof.save(path)
        except BadInput as why:
            return {"verified": False, "why": why.expected}
        began = time.process_time()
        verdict = verify(path)
    seconds = round(time.process_time() - began, 2)
    return {"verified": verdict.proved, "verify_seconds": seconds}
